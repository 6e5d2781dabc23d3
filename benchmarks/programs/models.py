"""The scenes as problems of skancf, and what is read off their solutions."""

from collections.abc import Callable
from dataclasses import dataclass
from math import pi
from typing import Any

import numpy as np

import skancf as sk
from benchmarks.scenes import Scene


@dataclass(frozen=True)
class Model:
    """A scene as a problem.

    ``ratio``: elements along the first and the second parameter for fineness n are n * ratio, at least one. ``values`` reads
    the scene's quantities off a state. ``goal``: what an adaptive run is asked for; ``peaks``: where graded meshes are fine.
    """

    problem: sk.Problem
    values: Callable[[Any], dict[str, Any]]
    ratio: tuple[float, float] = (1.0, 1.0)
    linear: bool = False
    openings: tuple[Any, ...] = ()
    peaks: tuple[tuple[float, float], ...] = ()
    goal: Any = None

    def uniform(self, n: int) -> Any:
        counts = [max(1, round(n * part)) for part in self.ratio]
        return sk.meshes.uniform(self.problem.surface, *counts, openings=self.openings)


def model(scene: Scene) -> Model:
    """Built anew at each call: it is part of what is timed."""
    return MODELS[scene.name](scene)


def strip(scene: Scene, loads: list[Any]) -> sk.Problem:
    d = scene.data
    surface = sk.Rectangle(d["length"], d["width"])
    return sk.Problem(surface, d["thickness"], sk.Isotropic(d["young"], d["poisson"], 1.0), [sk.Clamp("left")], loads)


def end_of(problem: sk.Problem) -> Callable[[Any], dict[str, float]]:
    (_, x), (low, high) = problem.surface.bounds

    def values(state: Any) -> dict[str, float]:
        u, _, w = state.displacement((x, (low + high) / 2))
        return {"u": -float(u), "w": float(w)}

    return values


def end_shear(scene: Scene) -> Model:
    problem = strip(scene, [sk.EdgeLoad("right", (0.0, 0.0, scene.data["force"] / scene.data["width"]))])
    return Model(problem, end_of(problem), (1.0, 0.0), goal=sk.Displacement((10.0, 0.5)))


def roll_up(scene: Scene) -> Model:
    problem = strip(scene, [sk.EdgeMoment("right", (0.0, -scene.data["moment"] / scene.data["width"], 0.0))])
    return Model(problem, end_of(problem), (1.0, 0.0))


def hemisphere(scene: Scene) -> Model:
    d = scene.data
    surface = sk.SphereSector(d["radius"], polar=(d["hole"], pi / 2), angle=pi / 2)
    a, b, half = (pi / 2, 0.0), (pi / 2, pi / 2), d["force"] / 2
    supports = [sk.Symmetry("start"), sk.Symmetry("end"), sk.Prescribed((pi / 2, pi / 4), (None, None, 0.0))]
    loads = [sk.PointForce(a, (half, 0.0, 0.0)), sk.PointForce(b, (0.0, -half, 0.0))]
    problem = sk.Problem(surface, d["thickness"], sk.Isotropic(d["young"], d["poisson"], 1.0), supports, loads)

    def values(state: Any) -> dict[str, float]:
        return {"outwards": float(state.displacement(a)[0]), "inwards": -float(state.displacement(b)[1])}

    return Model(problem, values, peaks=(a, b), goal=sk.Displacement(b, (0.0, -1.0, 0.0)))


def hinged_roof(scene: Scene) -> Model:
    """A quarter, pressed down at its crown by a prescribed displacement of one, times the load factor."""
    d = scene.data
    surface = sk.CylinderSector(d["radius"], d["half_length"], d["half_angle"], start=pi / 2 - d["half_angle"])
    crown = (d["half_length"], pi / 2)
    supports = [sk.Pin("start"), sk.Symmetry("end"), sk.Symmetry("right"), sk.Prescribed(crown, (None, None, -1.0))]
    problem = sk.Problem(surface, d["thickness"], sk.Isotropic(d["young"], d["poisson"], 1.0), supports, [])
    return Model(problem, lambda state: {"force": -4 * float(state.reactions([crown])[2])}, peaks=(crown,))


def l_shape(scene: Scene) -> Model:
    d = scene.data
    surface = sk.Rectangle(2.0, 2.0, origin=(-1.0, -1.0))
    material = sk.Isotropic(d["young"], d["poisson"], 1.0)
    load = sk.SurfaceLoad((0.0, 0.0, d["pressure"]))
    problem = sk.Problem(surface, d["thickness"], material, [sk.Clamp("boundary")], [load])
    # Linear: the load does twice the work that is stored.
    return Model(
        problem, lambda state: {"volume": 2 * float(state.strain_energy) / d["pressure"]}, linear=True,
        openings=(((0.0, 1.0), (-1.0, 0.0)),), peaks=((0.0, 0.0),), goal=sk.StrainEnergy(),
    )  # fmt: skip


def corner_plate(scene: Scene) -> Model:
    d, side = scene.data, scene.data["side"] / 2
    surface = sk.Rectangle(side, side)
    supports = [sk.Symmetry("left"), sk.Symmetry("bottom"), sk.Roller([(side, side)])]
    loads = [sk.PointForce((0.0, 0.0), (0.0, 0.0, d["force"] / 4))]
    problem = sk.Problem(surface, d["thickness"], sk.Isotropic(d["young"], d["poisson"], 1.0), supports, loads)

    def values(state: Any) -> dict[str, float]:
        return {"centre": float(state.displacement((0.0, 0.0))[2]), "edge": float(state.displacement((0.0, side))[2])}

    return Model(problem, values, linear=True, peaks=((0.0, 0.0),), goal=sk.Displacement((0.0, 0.0)))


def paper_example(scene: Scene) -> Model:
    """A quarter; its parameters are those of the whole plate."""
    d, half = scene.data, scene.data["side"] / 2
    surface = sk.Rectangle(half, half)
    supports = [sk.Pin([(0.0, 0.0)]), sk.Symmetry("right"), sk.Symmetry("top")]
    loads = [sk.PointForce((half, half), (0.0, 0.0, d["force"] / 4))]
    material = sk.Isotropic(d["young"], d["poisson"], d["density"])
    problem = sk.Problem(surface, d["thickness"], material, supports, loads)
    points = {"centre": (half, half), "quarter": (half / 2, half / 2), "edge": (half, 0.0)}

    def values(motion: Any) -> dict[str, Any]:
        return {key: [float(u[2]) for u in motion.displacement(at)] for key, at in points.items()}

    return Model(problem, values, peaks=((half, half), (0.0, 0.0)))


def free_ruler(scene: Scene) -> Model:
    d = scene.data
    surface = sk.Rectangle(d["length"], d["width"])
    pulse = sk.Table((0.0, d["peak"], d["over"], d["end"]), (0.0, 1.0, 0.0, 0.0))
    load = sk.EdgeLoad("right", (d["force_x"] / d["width"], 0.0, d["force_z"] / d["width"]), pulse)
    problem = sk.Problem(surface, d["thickness"], sk.Isotropic(d["young"], d["poisson"], d["density"]), [], [load])
    near, far = (0.0, d["width"] / 2), (d["length"], d["width"] / 2)

    def values(motion: Any) -> dict[str, Any]:
        ends = {"near": np.asarray(motion.displacement(near)), "far": np.asarray(motion.displacement(far))}
        return {f"{end}_{axis}": u[:, k].tolist() for end, u in ends.items() for axis, k in (("x", 0), ("z", 2))}

    return Model(problem, values, (1.0, 0.0))


MODELS: dict[str, Callable[[Scene], Model]] = {
    "end_shear": end_shear, "roll_up": roll_up, "hemisphere": hemisphere, "hinged_roof": hinged_roof, "l_shape": l_shape,
    "corner_plate": corner_plate, "paper_2n": paper_example, "paper_20n": paper_example, "free_ruler": free_ruler,
}  # fmt: skip
