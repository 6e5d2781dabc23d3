"""Exudyn: its thin plate in the absolute nodal coordinate formulation, four nodes with a position and two slopes each."""

import os
from math import cos, pi, sin
from typing import Any

import numpy as np

from benchmarks.programs.exudyn_plates import Plate, X, Y, Z, simulate, static
from benchmarks.programs.program import Outcome, Program, Variant
from benchmarks.scenes import Scene

UNIFORM = {
    "end_shear": (2, 3, 4, 6, 8, 12, 16),
    "roll_up": (4, 6, 8, 12, 16, 24, 32, 48),
    "hemisphere": (8, 12, 16, 24, 32, 48),
    "hinged_roof": (2, 3, 4, 6, 8, 12, 16),
    "l_shape": (4, 8, 16, 32, 64, 128),
    "corner_plate": (1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48),
    "paper_2n": (2, 4, 6, 8, 12, 16, 24, 32),
    "paper_20n": (2, 4, 6, 8, 12, 16, 24, 32),
    "free_ruler": (4, 6, 8, 12, 16, 24, 32),
}
# Time steps between two of the scene's times: their error is about that of the mesh.
STEPS = {
    "paper_2n": {2: 1, 4: 2, 6: 3, 8: 4, 12: 6, 16: 8, 24: 16, 32: 24},
    "paper_20n": {2: 1, 4: 2, 6: 3, 8: 4, 12: 6, 16: 8, 24: 16, 32: 24},
    "free_ruler": {4: 10, 6: 10, 8: 20, 12: 40, 16: 60, 24: 100, 32: 150},
}
VARIANTS = {
    "reduced": Variant("Exudyn, thin", "thin", UNIFORM),
    "full": Variant("Exudyn, thin, full integration", "thin", UNIFORM),
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


def end_shear(scene: Scene, n: int, reduced: bool) -> Outcome:
    return strip(scene, n, reduced, lambda plate: plate.end_force([0.0, 0.0, scene.data["force"]]))


def roll_up(scene: Scene, n: int, reduced: bool) -> Outcome:
    return strip(scene, n, reduced, lambda plate: plate.end_moment([0.0, -scene.data["moment"], 0.0]), steps=max(2, n // 4), follow=True)


def strip(scene: Scene, n: int, reduced: bool, load: Any, **how: Any) -> Outcome:
    plate = Plate(scene, lines(n, scene.data["length"]), lines(1, scene.data["width"]), reduced)
    # The slope across the edge may stretch.
    plate.fix(plate.index[:, 0], (X, Y, Z), (Y, Z), (X, Y, Z))
    load(plate)
    plate.mbs.Assemble()
    note = static(plate, **how)
    u = np.mean([plate.displacement(node) for node in plate.index[:, -1]], axis=0)
    return Outcome({"u": -u[X], "w": u[Z]}, plate.free, note)


def hemisphere(scene: Scene, n: int, reduced: bool) -> Outcome:
    d, radius = scene.data, scene.data["radius"]

    def sphere(x: Any, y: Any) -> Any:
        """By azimuth and latitude."""
        r = radius * np.cos(y) * np.cos(x), radius * np.cos(y) * np.sin(x), radius * np.sin(y)
        r_x = -r[Y], r[X], 0.0
        r_y = -radius * np.sin(y) * np.cos(x), -radius * np.sin(y) * np.sin(x), radius * np.cos(y)
        return r, r_x, r_y

    plate = Plate(scene, lines(n, pi / 2), lines(n, pi / 2 - d["hole"]), reduced, sphere)
    plate.mirror(plate.index[:, 0], Y, "y")
    plate.mirror(plate.index[:, -1], X, "y")
    a, b = plate.index[0, 0], plate.index[0, -1]
    plate.fix([plate.index[0, n // 2]], [Z])
    plate.force(a, [d["force"] / 2, 0.0, 0.0])
    plate.force(b, [0.0, -d["force"] / 2, 0.0])
    plate.mbs.Assemble()
    note = static(plate, steps=4)
    return Outcome({"outwards": plate.displacement(a)[X], "inwards": -plate.displacement(b)[Y]}, plate.free, note)


def hinged_roof(scene: Scene, n: int, reduced: bool) -> Outcome:
    """The force at one prescribed deflection after the other."""
    import exudyn as exu

    d, radius = scene.data, scene.data["radius"]

    def cylinder(x: Any, y: Any) -> Any:
        """By length and the angle from the crown."""
        r = x, radius * np.sin(y), radius * np.cos(y)
        return r, (1.0, 0.0, 0.0), (0.0, radius * np.cos(y), -radius * np.sin(y))

    plate = Plate(scene, lines(n, d["half_length"]), lines(n, d["half_angle"]), reduced, cylinder)
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


SMALL = 1e-6


def l_shape(scene: Scene, n: int, reduced: bool) -> Outcome:
    d = scene.data
    x = lines(2 * n, 1.0, -1.0)
    plate = Plate(scene, x, x, reduced, inside=lambda x, y: (x < 0) | (y > 0))
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


def corner_plate(scene: Scene, n: int, reduced: bool) -> Outcome:
    d = scene.data
    x = lines(n, d["side"] / 2)
    plate = Plate(scene, x, x, reduced)
    plate.mirror(plate.index[:, 0], X, "y")
    plate.mirror(plate.index[0], Y, "x")
    plate.fix([plate.index[-1, -1]], [Z])
    plate.force(plate.index[0, 0], [0.0, 0.0, d["force"] / 4])
    plate.mbs.Assemble()
    note = static(plate, linear=True)
    return Outcome({"centre": plate.displacement(plate.index[0, 0])[Z], "edge": plate.displacement(plate.index[-1, 0])[Z]}, plate.free, note)


def paper_example(scene: Scene, n: int, reduced: bool) -> Outcome:
    """A quarter."""
    d = scene.data
    x = lines(n, d["side"] / 2)
    plate = Plate(scene, x, x, reduced, density=d["density"])
    plate.fix([plate.index[0, 0]], (X, Y, Z))
    plate.mirror(plate.index[:, -1], X, "y")
    plate.mirror(plate.index[-1], Y, "x")
    plate.force(plate.index[-1, -1], [0.0, 0.0, d["force"] / 4])
    watched = {"centre": plate.index[-1, -1], "quarter": plate.index[n // 2, n // 2], "edge": plate.index[0, -1]}
    series, note = simulate(plate, scene, STEPS[scene.name][n], list(watched.values()))
    return Outcome({key: series[:, k, Z].tolist() for k, key in enumerate(watched)}, plate.free, note)


def free_ruler(scene: Scene, n: int, reduced: bool) -> Outcome:
    d = scene.data
    plate = Plate(scene, lines(n, d["length"]), lines(1, d["width"]), reduced, density=d["density"])
    plate.end_force([d["force_x"], 0.0, d["force_z"]], lambda t: max(0.0, min(t, d["over"] - t)) / d["peak"])
    series, note = simulate(plate, scene, STEPS[scene.name][n], [*plate.index[:, 0], *plate.index[:, -1]])
    ends = {"near": series[:, :2].mean(axis=1), "far": series[:, 2:].mean(axis=1)}
    return Outcome({f"{end}_{key}": u[:, c].tolist() for end, u in ends.items() for key, c in (("x", X), ("z", Z))}, plate.free, note)


RUNS = {"end_shear": end_shear, "roll_up": roll_up, "hemisphere": hemisphere, "hinged_roof": hinged_roof, "l_shape": l_shape,
        "corner_plate": corner_plate, "paper_2n": paper_example, "paper_20n": paper_example, "free_ruler": free_ruler}  # fmt: skip


def run(scene: Scene, variant: str, size: float) -> Outcome:
    return RUNS[scene.name](scene, int(size), variant == "reduced")


PROGRAM = Program("Exudyn", VARIANTS, prepare, version, run, environment="exudyn")
