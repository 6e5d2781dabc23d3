"""Which membrane strains a thin curved element should have: the tables of decision 0004 and of docs/theory/kirchhoff.rst.

From the folder of the repository, in some three minutes on two cores:

    .venv/bin/python docs/measure/membrane.py

It writes docs/decisions/membrane_variants.csv, docs/theory/locking_membrane.csv and docs/pictures/locking_membrane.png;
``variants`` makes the first alone, ``sweep`` the others.
"""

import csv
import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from math import pi, radians
from pathlib import Path

import numpy as np

import skancf as sk
from skancf import output
from skancf.elements.quad_ancf import square_quadrature
from skancf.terms.shells import kirchhoff_sections as sections
from skancf.theories.kirchhoff import theory as kirchhoff
from skancf.theories.kirchhoff.point import gradient

HERE = Path(__file__).resolve().parent.parent
PLAIN = sk.Kirchhoff(assumed=False)
CHOSEN = kirchhoff.KEPT

Rest = Callable[[np.ndarray, float], np.ndarray]


def constant(factor: float) -> Rest:
    """The rest of the membrane strains counts with a constant factor."""
    return lambda jets, t: np.full((jets.shape[2], 3), np.sqrt(factor))


def slenderness_alone(jets: np.ndarray, t: float) -> np.ndarray:
    """It counts with t^2 / (h_a h_b) whatever the curvature."""
    one, two = np.minimum(1.0, t / np.linalg.norm(jets[:2], axis=1).mean(axis=-1))
    return np.stack([one, two, np.sqrt(one * two)], axis=1)


VARIANTS = {
    "as they are": (PLAIN, CHOSEN, None),
    "P1 x P2, P2 x P1, P1 x P1": (sk.Kirchhoff(), CHOSEN, None),
    "the same, rest t2/h2": (sk.Kirchhoff(), CHOSEN, slenderness_alone),
    "the same, rest 0.02": (sk.Kirchhoff(), CHOSEN, constant(0.02)),
    "the same, no rest": (sk.Kirchhoff(), CHOSEN, constant(0.0)),
    "P1 x P3, P3 x P1, P1 x P1": (sk.Kirchhoff(), ((2, 4), (4, 2), (2, 2)), None),
    "P1 x P1 for all": (sk.Kirchhoff(), ((2, 2), (2, 2), (2, 2)), None),
    "P2 x P3, P3 x P2, P2 x P2": (sk.Kirchhoff(), ((3, 4), (4, 3), (3, 3)), None),
}


@contextmanager
def variant(kept: tuple, rest: Rest | None) -> Iterator[None]:
    """The library with other polynomials in the assumed strains, or with other factors of their rest."""
    before = kirchhoff.KEPT, sections.rest_factors
    kirchhoff.KEPT = kept
    if rest is not None:
        sections.rest_factors = rest
    try:
        yield
    finally:
        kirchhoff.KEPT, sections.rest_factors = before


def zero_modes(theory: sk.Kirchhoff, surface: sk.surfaces.BoundedSurface, n: int) -> int:
    """Eigenvalues of a free patch that are rounding, its matrix scaled to a unit diagonal."""
    free = sk.Problem(surface, 0.05, sk.Isotropic(1.0, 0.3, 1.0))
    system = free.on(sk.meshes.uniform(surface, n, n), theory)
    K = system.tangent(system.undeformed).to_scipy().toarray()
    scale = 1 / np.sqrt(K.diagonal())
    return int((np.abs(np.linalg.eigvalsh(K * scale * scale[:, None])) < 1e-13).sum())


def zero_modes_of_three_points() -> int:
    """Of one flat element with 3 x 3 points and membrane strains as they are."""
    points, weights = square_quadrature(3)
    table = kirchhoff.jet_table(points)
    flat = np.zeros((5, 3, points.shape[1]))
    flat[0, 0] = flat[1, 1] = 1.0
    B = np.einsum("kjip,jap->kpai", gradient(flat), table).reshape(6, len(weights), 48)
    law = np.diag([1, 1, 0.4, 1e-3, 1e-3, 4e-4])
    K = np.einsum("kpa,kl,lpb,p->ab", B, law, B, weights)
    scale = 1 / np.sqrt(K.diagonal())
    return int((np.abs(np.linalg.eigvalsh(K * scale * scale[:, None])) < 1e-13).sum())


def hemisphere(theory: sk.Kirchhoff, n: int, thickness: float = 0.04) -> tuple[float, int]:
    """Displacement under the outward force of the pinched hemisphere with a hole, and iterations.

    The force is scaled with the cube of the thickness, so that thin hemispheres bend as much.
    """
    surface = sk.SphereSector(10.0, (radians(18), pi / 2), pi / 2)
    force = 200.0 * (thickness / 0.04) ** 3
    shell = sk.Problem(
        surface, thickness, sk.Isotropic(6.825e7, 0.3, 1.0),
        supports=[sk.Symmetry("start"), sk.Symmetry("end"), sk.Prescribed((pi / 2, 0.0), (None, None, 0.0))],
        loads=[sk.PointForce((pi / 2, 0.0), (force, 0, 0)), sk.PointForce((pi / 2, pi / 2), (0, -force, 0))],
    )  # fmt: skip
    system = shell.on(sk.meshes.uniform(surface, n, n), theory)
    result = sk.solve(system, control=sk.HalveAndGrow(first=0.25))
    return float(result.unwrap().displacement((pi / 2, 0.0))[0]), result.iterations


def ring(theory: sk.Kirchhoff, nr: int, na: int) -> float:
    """Lift of the slit annulus (Sze, Liu and Lo 2004, 3.3) at the outer end of the pulled edge."""
    surface = sk.AnnulusSector(6.0, 10.0, 2 * pi)
    shell = sk.Problem(surface, 0.03, sk.Isotropic(21e6, 0.0, 1.0), supports=[sk.Clamp("end")],
                       loads=[sk.EdgeLoad("start", (0, 0, 0.8))])  # fmt: skip
    system = shell.on(sk.meshes.uniform(surface, nr, na), theory)
    return float(sk.solve(system, control=sk.HalveAndGrow(first=0.25)).unwrap().displacement((10.0, 0.0))[2])


def strip(theory: sk.Kirchhoff, n: int) -> float:
    """End deflection of a cantilever under an end force (Sze, Liu and Lo 2004, 3.1)."""
    surface = sk.Rectangle(10.0, 1.0)
    plate = sk.Problem(surface, 0.1, sk.Isotropic(1.2e6, 0.0, 1.0), supports=[sk.Clamp("left")],
                       loads=[sk.EdgeLoad("right", (0, 0, 4.0))])  # fmt: skip
    return float(sk.solve(plate.on(sk.meshes.uniform(surface, n, 1), theory)).unwrap().displacement((10.0, 0.5))[2])


def cylinder_buckling(theory: sk.Kirchhoff, n: tuple[int, int]) -> float:
    """Axial compression, R = L, R / t = 50, over the classical load 0.605 E t^2 / R."""
    surface, t = sk.CylinderSector(1.0, 1.0, 2 * pi, closed=True), 0.02
    shell = sk.Problem(
        surface, t, sk.Isotropic(1e6, 0.3, 1.0), loads=[sk.EdgeLoad("right", (-1.0, 0, 0))],
        supports=[sk.Roller("left", (1, 0, 0)), sk.Roller("boundary", (0, 1, 0)), sk.Roller("boundary", (0, 0, 1))],
    )  # fmt: skip
    factors = sk.buckling(shell.on(sk.meshes.uniform(surface, *n), theory), 1).load_factors
    return float(factors[0] / (1e6 * t**2 / np.sqrt(3 * (1 - 0.3**2))))


def sphere_buckling(theory: sk.Kirchhoff, n: tuple[int, int]) -> float:
    """Outer pressure, R / t = 50, over the classical one 2 E (t / R)^2 / sqrt(3 (1 - nu^2))."""
    surface, t = sk.SphereSector(1.0, (0.0, pi), 2 * pi, closed=True), 0.02
    shell = sk.Problem(
        surface, t, sk.Isotropic(1e6, 0.3, 1.0), loads=[sk.FollowerPressure(-1.0)],
        supports=[sk.Pin((0.0, 0.0)), sk.Roller((pi, 0.0), (1, 0, 0)), sk.Roller((pi, 0.0), (0, 1, 0)),
                  sk.Roller((pi / 2, 0.0), (0, 1, 0))],
    )  # fmt: skip
    factors = sk.buckling(shell.on(sk.meshes.uniform(surface, *n), theory), 1).load_factors
    return float(factors[0] / (2e6 * t**2 / np.sqrt(3 * (1 - 0.3**2))))


def or_none(compute: object, *arguments: object) -> float:
    try:
        value = compute(*arguments)  # type: ignore[operator]
    except sk.SkancfError:
        return float("nan")
    return value[0] if isinstance(value, tuple) else value


def write(name: str, rows: list[dict[str, object]]) -> None:
    with open(HERE / name, "w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        table.writeheader()
        table.writerows(rows)
    print(f"-- {name}")
    for row in rows:
        print(" | ".join(f"{value}" for value in row.values()))


def percent(value: float, reference: float) -> str:
    return "fails" if np.isnan(value) else f"{100 * (value / reference - 1):+.2f}"


def variants() -> None:
    best = {"hemisphere": hemisphere(PLAIN, 64)[0], "thin": hemisphere(sk.Kirchhoff(), 64, 1e-3)[0],
            "ring": ring(PLAIN, 12, 96), "strip": strip(PLAIN, 128)}  # fmt: skip
    rows = []
    for name, (theory, kept, rest) in VARIANTS.items():
        with variant(kept, rest):
            row = {
                "membrane strains": name,
                "zero modes: flat": zero_modes(theory, sk.Rectangle(1.0, 1.0), 1),
                "sphere": zero_modes(theory, sk.SphereSector(1.0, (0.5, 1.0), 0.5), 1),
                "flat 3 x 3": zero_modes(theory, sk.Rectangle(1.0, 1.0), 3),
                "hemisphere R/t = 250, 8 x 8 (%)": percent(or_none(hemisphere, theory, 8), best["hemisphere"]),
                "R/t = 10000, 16 x 16 (%)": percent(or_none(hemisphere, theory, 16, 1e-3), best["thin"]),
                "slit annulus 2 x 12 (%)": percent(or_none(ring, theory, 2, 12), best["ring"]),
                "strip 8 x 1 (%)": percent(or_none(strip, theory, 8), best["strip"]),
                "buckling: cylinder 8 x 24": f"{or_none(cylinder_buckling, theory, (8, 24)):.3f}",
                "sphere 20 x 24": f"{or_none(sphere_buckling, theory, (20, 24)):.3f}",
            }
        rows.append(row)
        print(row, flush=True)
    write("decisions/membrane_variants.csv", rows)
    print("zero modes of one flat element with 3 x 3 points:", zero_modes_of_three_points())
    print({name: f"{value:.5f}" for name, value in best.items()})


def flat(slenderness: float, n: int) -> float:
    """Deflection times D / (q a^4) of a clamped square plate."""
    h, surface = 1 / slenderness, sk.Rectangle(1.0, 1.0)
    plate = sk.Problem(surface, h, sk.Isotropic(12 * (1 - 0.3**2) / h**3, 0.3, 1.0), supports=[sk.Clamp("boundary")],
                       loads=[sk.SurfaceLoad((0, 0, 1e-9))])  # fmt: skip
    return float(sk.solve_linear(plate.on(sk.meshes.uniform(surface, n, n), "kirchhoff")).displacement((0.5, 0.5))[2] / 1e-9)


def sweep() -> None:
    """Errors on fixed meshes against slenderness: the pinched hemisphere, and a flat clamped plate."""
    rows, series = [], {}
    for thickness in (0.4, 0.1, 0.04, 0.01, 0.004, 0.001):
        exact = hemisphere(sk.Kirchhoff(), 64, thickness)[0]
        row: dict[str, object] = {"R/t": round(10 / thickness), "u (64 x 64)": f"{exact:.4f}"}
        for n in (8, 16, 32):
            for label, theory in (("assumed", sk.Kirchhoff()), ("as they are", PLAIN)):
                value = or_none(hemisphere, theory, n, thickness)
                row[f"{n} x {n} {label} (%)"] = percent(value, exact)
                if n == 16:
                    series.setdefault(f"hemisphere, {label}", []).append(abs(value / exact - 1))
        rows.append(row)
        print(row, flush=True)
    write("theory/locking_membrane.csv", rows)
    slenderness = [10.0**k for k in range(1, 6)]
    plate = [abs(flat(a, 8) / 0.001265319 - 1) for a in slenderness]
    print("flat clamped plate, 8 x 8:", [f"{error:.3e}" for error in plate])
    curves = {name: ([float(row["R/t"]) for row in rows], errors) for name, errors in series.items()}
    curves["flat clamped plate"] = (slenderness, plate)
    output.convergence(
        curves, HERE / "pictures" / "locking_membrane.png", xlabel="slenderness R/t, or a/h of the flat plate",
        ylabel="relative error of the deflection", title="The same meshes, thinner and thinner",
    )  # fmt: skip


if __name__ == "__main__":
    warnings.simplefilter("ignore", sk.statics.OutOfDepth)
    for name in sys.argv[1:] or ("variants", "sweep"):
        {"variants": variants, "sweep": sweep}[name]()
