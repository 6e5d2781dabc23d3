"""Exudyn: its thin plate in the absolute nodal coordinate formulation, four nodes with a position and two slopes each."""

from math import pi
from typing import Any

import numpy as np

from benchmarks.programs.exudyn_plates import Plate, X, Y, Z, simulate, static
from benchmarks.programs.program import Outcome, Program, Variant
from benchmarks.scenes import Scene

UNIFORM = {
    "end_shear": (2, 3, 4, 6, 8, 12, 16),
    "roll_up": (4, 6, 8, 12, 16, 24, 32),
    "hemisphere": (8, 12, 16, 24, 32, 48),
    "hinged_roof": (2, 3, 4, 6, 8, 12, 16, 24, 32, 48),
    "l_shape": (4, 6, 8, 12, 16, 24, 32, 48, 64, 96),
    "corner_plate": (2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96),
    "paper_2n": (2, 4, 6, 8, 12, 16, 24, 32),
    "paper_20n": (2, 4, 6, 8, 12, 16, 24, 32),
    "free_ruler": (3, 4, 6, 8, 12, 16, 24),
}
# Time steps between two of the scene's times: their error is about that of the mesh.
STEPS = {
    "paper_2n": {2: 1, 4: 2, 6: 2, 8: 4, 12: 6, 16: 8, 24: 12, 32: 16},
    "paper_20n": {2: 1, 4: 2, 6: 2, 8: 4, 12: 6, 16: 8, 24: 12, 32: 16},
    "free_ruler": {3: 10, 4: 10, 6: 20, 8: 20, 12: 40, 16: 80, 24: 160},
}
# With full integration the same takes three to four times as long and is no more accurate.
VARIANTS = {
    "thin": Variant("Exudyn, thin", "small", UNIFORM),
}


def prepare() -> None:
    import sys

    # The build without range checks.
    sys.exudynFast = True
    import exudyn  # noqa: F401


def version() -> str:
    import exudyn

    return f"Exudyn {exudyn.__version__}"


def lines(n: int, end: float, start: float = 0.0) -> Any:
    return np.linspace(start, end, n + 1)


def half_strip(scene: Scene, n: int, density: float = 0.0) -> Plate:
    """Half the width of a strip, one element wide. As one element over the whole width, the edges bow: the ruler comes out
    0.2 % off at best."""
    plate = Plate(scene, lines(n, scene.data["length"]), lines(1, scene.data["width"] / 2), density=density)
    plate.mirror(plate.index[0], Y, "x")
    return plate


def end_shear(scene: Scene, n: int) -> Outcome:
    return cantilever(scene, n, lambda plate: plate.end_force([0.0, 0.0, scene.data["force"] / 2]))


def roll_up(scene: Scene, n: int) -> Outcome:
    def load(plate: Plate) -> None:
        plate.end_moment([0.0, -scene.data["moment"] / 2, 0.0])

    return cantilever(scene, n, load, steps=4, rtol=1e-5, follow=True)


def cantilever(scene: Scene, n: int, load: Any, **how: Any) -> Outcome:
    plate = half_strip(scene, n)
    # The slope across the edge may stretch.
    plate.fix(plate.index[:, 0], (X, Y, Z), (Y, Z), (X, Y, Z))
    load(plate)
    plate.mbs.Assemble()
    note = static(plate, **how)
    u = plate.displacement(plate.index[0, -1])
    return Outcome({"u": -u[X], "w": u[Z]}, plate.free, note)


def hemisphere(scene: Scene, n: int) -> Outcome:
    d, radius = scene.data, scene.data["radius"]

    def sphere(x: Any, y: Any) -> Any:
        """By azimuth and latitude."""
        r = radius * np.cos(y) * np.cos(x), radius * np.cos(y) * np.sin(x), radius * np.sin(y)
        r_x = -r[Y], r[X], 0.0
        r_y = -radius * np.sin(y) * np.cos(x), -radius * np.sin(y) * np.sin(x), radius * np.cos(y)
        return r, r_x, r_y

    plate = Plate(scene, lines(n, pi / 2), lines(n, pi / 2 - d["hole"]), sphere)
    plate.mirror(plate.index[:, 0], Y, "y")
    plate.mirror(plate.index[:, -1], X, "y")
    a, b = plate.index[0, 0], plate.index[0, -1]
    plate.fix([plate.index[0, n // 2]], [Z])
    plate.force(a, [d["force"] / 2, 0.0, 0.0])
    plate.force(b, [0.0, -d["force"] / 2, 0.0])
    plate.mbs.Assemble()
    # Roughly on the way, well at the end.
    note = "; ".join([static(plate, steps=6, rtol=1e-1), static(plate, restart=True)])
    return Outcome({"outwards": plate.displacement(a)[X], "inwards": -plate.displacement(b)[Y]}, plate.free, note)


def hinged_roof(scene: Scene, n: int) -> Outcome:
    """The force at one prescribed deflection after the other."""
    import exudyn as exu

    d, radius = scene.data, scene.data["radius"]

    def cylinder(x: Any, y: Any) -> Any:
        """By length and the angle from the crown."""
        r = x, radius * np.sin(y), radius * np.cos(y)
        return r, (1.0, 0.0, 0.0), (0.0, radius * np.cos(y), -radius * np.sin(y))

    plate = Plate(scene, lines(n, d["half_length"]), lines(n, d["half_angle"]), cylinder)
    plate.mirror(plate.index[:, 0], X, "y")
    plate.mirror(plate.index[0], Y, "x")
    plate.fix(plate.index[-1], (X, Y, Z), (X, Y, Z))
    press = plate.fix([plate.index[0, 0]], [Z])
    plate.mbs.Assemble()
    values, notes = {}, []
    for k in range(len(scene.quantities)):
        plate.mbs.SetObjectParameter(press, "offset", -d[f"deflection_{k}"])
        notes.append(static(plate))
        values[f"force_{k}"] = -4 * float(plate.mbs.GetObjectOutput(press, exu.OutputVariableType.Force))
    return Outcome(values, plate.free, "; ".join(notes))


def l_shape(scene: Scene, n: int) -> Outcome:
    d = scene.data
    x = lines(2 * n, 1.0, -1.0)
    plate = Plate(scene, x, x, inside=lambda x, y: (x < 0) | (y > 0))
    x, y = plate.points.T
    edge = (abs(x) == 1) | (abs(y) == 1) | ((x >= 0) & (y <= 0))
    plate.fix(np.flatnonzero(edge), (X, Y, Z), (X, Y, Z), (X, Y, Z))
    inner = np.flatnonzero(~edge)
    # On a uniform mesh, the moments of a uniform load cancel in every node that can move.
    for node in inner:
        plate.force(node, [0.0, 0.0, d["pressure"] / n**2])
    plate.mbs.Assemble()
    note = static(plate, linear=True)
    volume = sum(plate.displacement(node)[Z] for node in inner) / n**2
    return Outcome({"volume": volume}, plate.free, note)


def corner_plate(scene: Scene, n: int) -> Outcome:
    d = scene.data
    x = lines(n, d["side"] / 2)
    plate = Plate(scene, x, x)
    plate.mirror(plate.index[:, 0], X, "y")
    plate.mirror(plate.index[0], Y, "x")
    plate.fix([plate.index[-1, -1]], [Z])
    plate.force(plate.index[0, 0], [0.0, 0.0, d["force"] / 4])
    plate.mbs.Assemble()
    note = static(plate, linear=True)
    centre, edge = (plate.displacement(node)[Z] for node in plate.index[[0, -1], 0])
    return Outcome({"centre": centre, "edge": edge}, plate.free, note)


def paper_example(scene: Scene, n: int) -> Outcome:
    """A quarter."""
    d = scene.data
    x = lines(n, d["side"] / 2)
    plate = Plate(scene, x, x, density=d["density"])
    plate.fix([plate.index[0, 0]], (X, Y, Z))
    plate.mirror(plate.index[:, -1], X, "y")
    plate.mirror(plate.index[-1], Y, "x")
    plate.force(plate.index[-1, -1], [0.0, 0.0, d["force"] / 4])
    watched = {"centre": plate.index[-1, -1], "quarter": plate.index[n // 2, n // 2], "edge": plate.index[0, -1]}
    series, note = simulate(plate, scene, STEPS[scene.name][n], list(watched.values()), 1e-2)
    return Outcome({key: series[:, k, Z].tolist() for k, key in enumerate(watched)}, plate.free, note)


def free_ruler(scene: Scene, n: int) -> Outcome:
    d = scene.data
    plate = half_strip(scene, n, d["density"])
    plate.end_force([d["force_x"] / 2, 0.0, d["force_z"] / 2], lambda t: max(0.0, min(t, d["over"] - t)) / d["peak"])
    series, note = simulate(plate, scene, STEPS[scene.name][n], [plate.index[0, 0], plate.index[0, -1]], 1e-4)
    ends = {"near": series[:, 0], "far": series[:, 1]}
    values = {f"{end}_{axis}": u[:, c].tolist() for end, u in ends.items() for axis, c in (("x", X), ("z", Z))}
    return Outcome(values, plate.free, note)


RUNS = {
    "end_shear": end_shear, "roll_up": roll_up, "hemisphere": hemisphere, "hinged_roof": hinged_roof, "l_shape": l_shape,
    "corner_plate": corner_plate, "paper_2n": paper_example, "paper_20n": paper_example, "free_ruler": free_ruler,
}  # fmt: skip


def run(scene: Scene, variant: str, size: float) -> Outcome:
    return RUNS[scene.name](scene, int(size))


PROGRAM = Program("Exudyn", VARIANTS, prepare, version, run, environment="exudyn")
