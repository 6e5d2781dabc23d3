"""Sections off the surface, and the shear of laminates: tables of docs/decisions/0021-sections-off-the-surface.rst.

From the folder of the repository, in ten seconds:

    .venv/bin/python docs/measure/sections.py

The references are exact elasticity: tubes layer by layer, cylindrical bending after Pagano (tests/reference).
"""

import sys
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
from tables import write

import skancf as sk
from skancf.materials import Section
from skancf.materials.curved import CurvedSection
from skancf.materials.law import turned

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests"))
from reference import cylindrical_bending, layered_tube, navier

Wall = list[tuple[sk.Isotropic | sk.Orthotropic, float, float]]
STIFF, SOFT = (sk.Isotropic(E, 0.3, 1.0) for E in (1.0, 0.2))
FIBRES = sk.Orthotropic((25, 1, 1), (0.25, 0.25, 0.25), (0.5, 0.5, 0.2), 1.0)
WALLS: dict[str, Wall] = {
    "one layer": [(STIFF, 1.0, 0)],
    "stiff inside, soft outside": [(STIFF, 0.5, 0), (SOFT, 0.5, 0)],
    "0/90, fibres outside along the hoop": [(FIBRES, 0.5, 0), (FIBRES, 0.5, 90)],
}
RATIOS = (0.02, 0.05, 0.1, 0.2)


def laminate(wall: Wall, offset: float = 0.0) -> sk.Laminate:
    return sk.Laminate([sk.Layer(law, t, np.radians(angle)) for law, t, angle in wall], offset)


def solid(wall: Wall) -> list[np.ndarray]:
    """Three-dimensional laws of the layers."""
    made = [type(law)(**{**vars(law), "kind": "3d", "shear_correction": 1.0}) for law, _, _ in wall]
    return [turned(law.stiffness(), np.radians(angle)) for law, (_, _, angle) in zip(made, wall, strict=True)]


def tube_errors(wall: Wall, offset: float, ratio: float, kind: str = "curved") -> list[float]:
    """Of the movement under pressure and the moment per turn of a tube of which the axis is held, relative."""
    section, R = laminate(wall, offset).section(), 1 / ratio
    if kind == "curved, rigid thickness":
        section = replace(section, thinning=np.zeros((len(wall), 3)))
    law = section.abd() if kind == "plate" else CurvedSection(section).law(np.array([0.0, -ratio, 0.0]))
    w, turn = np.array([0, 1 / R, 0, 0, 1 / R**2, 0]), np.array([0, 1.0, 0, 0, 2 / R, 0])
    out = R / (w @ law @ w) / R
    bent = (turn @ law @ turn - (w @ law @ turn) ** 2 / (w @ law @ w)) * R
    pressed = layered_tube.pressed(R + section.z, solid(wall), R).at_surface(R)
    return [out / pressed - 1, bent / layered_tube.tube(R + section.z, solid(wall), turn=1.0).integral(1, 1) - 1]


def tubes() -> None:
    rows = []
    for name, wall in WALLS.items():
        for offset in (0.0, 0.5, -0.5):
            for k, load in enumerate(("pressure", "bending")):
                kinds = ("plate", "curved") if offset else ("plate", "curved", "curved, rigid thickness")
                for kind in kinds:
                    values = [100 * tube_errors(wall, offset, ratio, kind)[k] for ratio in RATIOS]
                    rows.append([name, offset, load, kind, *(f"{v:.3f}" for v in values)])
    write("sections_tubes.csv", "wall; offset / h; load; law; " + "; ".join(f"h/R = {r:g}" for r in RATIOS), rows)


def remainders() -> None:
    """What is left of first order in bending, from two small ratios."""
    for name, wall in WALLS.items():
        fine, coarse = (tube_errors(wall, 0.5, ratio)[1] for ratio in (0.0125, 0.025))
        print(f"{name}: {(4 * fine - coarse) / 0.025:.4f} h/R of the bending stiffness is left")


def sandwich(ratio: float) -> Wall:
    return [(sk.Isotropic(1e6, 0.3, 1.0), 0.1, 0), (sk.Isotropic(1e6 / ratio, 0.3, 1.0), 0.8, 0),
            (sk.Isotropic(1e6, 0.3, 1.0), 0.1, 0)]  # fmt: skip


def shear_errors(wall: Wall, a: float) -> list[float]:
    """Of the deflection of cylindrical bending without shear, with the sum of 5/6 G t, and as it is."""
    section, p = laminate(wall).section(), np.pi / a
    bending = np.linalg.inv(section.abd()[np.ix_([0, 3], [0, 3])])[1, 1] / p**4
    laws = [layer.stiffness() for layer in laminate(wall).layers]
    summed = Section(section.z, np.array(laws), section.density, section.expansion).shear_stiffness()[0, 0]
    exact = cylindrical_bending.deflection(solid(wall), [t for _, t, _ in wall], a)[0]
    own = section.shear_stiffness()[0, 0]
    return [100 * ((bending + shear) / exact - 1) for shear in (0.0, 1 / (summed * p**2), 1 / (own * p**2))]


def shear() -> None:
    walls = {
        "one layer": [(sk.Isotropic(1e6, 0.3, 1.0), 1.0, 0.0)],
        "0/90/0": [(FIBRES, 1 / 3, 0), (FIBRES, 1 / 3, 90), (FIBRES, 1 / 3, 0)],
        "0/90": [(FIBRES, 0.5, 0), (FIBRES, 0.5, 90)],
        **{f"sandwich, core 1/{ratio:g} as stiff": sandwich(ratio) for ratio in (10, 100, 1000, 10000)},
    }
    rows = [[name, f"{a:g}", *(f"{v:.2f}" for v in shear_errors(wall, a))]
            for name, wall in walls.items() for a in (4, 10, 50)]  # fmt: skip
    write("sections_shear.csv", "section; a/h; without shear; sum of 5/6 G t; equilibrium", rows)


def nafems_section() -> sk.Laminate:
    face = sk.Orthotropic((10e6, 4e6, 4e6), (0.3, 0.3, 0.3), (1.875e6,) * 3, 1.0)
    core = sk.Orthotropic((10.0, 10.0, 10.0), (0, 0, 0), (10.0, 3e4, 1.2e4), 1.0)
    return sk.Laminate([sk.Layer(face, 0.028), sk.Layer(core, 0.75), sk.Layer(face, 0.028)])


def nafems(theory: str, n: int) -> list[str]:
    """R0031/3: deflection (in), S11 and S22 in the middle of a face (psi)."""
    quarter = sk.Rectangle(5.0, 5.0)
    held = [sk.Symmetry("left"), sk.Symmetry("bottom"), sk.SimpleSupport(["right", "top"], kind="hard")]
    problem = sk.Problem(quarter, material=nafems_section(), supports=held, loads=[sk.SurfaceLoad((0, 0, -100.0))])
    solution = sk.solve_linear(problem.on(sk.meshes.uniform(quarter, n, n), theory))
    middle = np.argmin(np.abs(solution.system.mesh.p).sum(axis=0))
    s11, s22 = solution.nodal_stresses(-0.389)[middle, :2]
    return [f"{solution.displacement((0, 0))[2]:.4f}", f"{s11:.0f}", f"{s22:.0f}"]


def sandwich_plate() -> None:
    rows = [[theory, f"{n} x {n}", *nafems(theory, n)] for theory in ("kirchhoff", "full") for n in (4, 8, 16, 24)]
    layers = nafems_section().layers
    section = nafems_section().section()
    raw = Section(section.z, np.array([layer.stiffness() for layer in layers]), section.density, section.expansion)
    for name, stiffness in (("sum of 5/6 G t", raw.shear_stiffness()), ("equilibrium", section.shear_stiffness())):
        w = -1e4 * navier.shear_deformable(section.abd()[3:, 3:] / 100, tuple(np.diag(stiffness)))
        rows.append([f"Navier's series, {name}", "", f"{w:.4f}", "", ""])
    write("sections_sandwich.csv", "theory; quarter; w (in); S11 (psi); S22 (psi)", rows)


if __name__ == "__main__":
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", sk.OutOfDepth)
        tubes()
        remainders()
        shear()
        sandwich_plate()
