"""Objects of every class that files keep, with arguments that are not the defaults."""

from typing import Any

import numpy as np

import skancf as sk
from skancf import storage
from skancf.storage.registry import KINDS, class_named

STEEL = sk.Isotropic(2.1e11, 0.3, 7850.0, expansion=1.2e-5)
UP = (0.0, 0.0, 1.0)
GUST = sk.Table([0.0, 0.5, 2.0], [0.0, 1.0, 0.3], kind="smooth")
LINE = np.linspace(0.0, 1.0, 8)

EXAMPLES: dict[str, dict[str, Any]] = {
    "AnnulusSector": {"inner": 1.0, "outer": 2.0, "angle": 1.5},
    "Cone": {"radius_low": 2.0, "radius_high": 1.0, "height": 3.0, "angle": 1.0},
    "CylinderSector": {"radius": 2.0, "length": 3.0, "angle": 2 * np.pi},
    "HyperbolicParaboloid": {"length_x": 1.0, "length_y": 2.0, "rise": 0.3},
    "Parallelogram": {"length_x": 1.0, "length_y": 2.0, "angle": 1.1},
    "Rectangle": {"length_x": 0.1 + 0.2, "length_y": 1 / 3, "origin": [1.0, 2.0]},
    "SphereSector": {"radius": 1.0, "polar": (0.2, 1.0), "angle": 1.0},
    "Anisotropic": {"matrix": np.diag([3.0, 2.0, 4.0, 1.0, 1.5, 1.2]) * 1e9, "density": 1000.0, "angle": 0.2},
    "Damping": {"mass": 0.1, "stiffness": 1e-4},
    "Gent": {"shear": 4e5, "most": 50.0, "density": 1000.0},
    "Isotropic": {"young": 2.1e11, "poisson": 0.3, "density": np.float32(7850)},
    "Layer": {"material": STEEL, "thickness": 0.01, "angle": np.pi / 7},
    "Laminate": {"layers": [sk.Layer(STEEL, 0.01), sk.Layer(STEEL, 0.02, 0.3)], "offset": 0.001},
    "MooneyRivlin": {"c10": 2e5, "c01": 1e4, "density": 1000.0, "poisson": 0.45},
    "NeoHooke": {"shear": 4e5, "density": 1000.0},
    "Ogden": {"terms": [(4e5, 2.0), (1e4, -2.0)], "density": 1000.0},
    "Orthotropic": {"young": (1e11, 1e10, 1e10), "poisson": (0.3, 0.0, 0.0), "shear": (5e9, 5e9, 4e9), "density": 1600.0},
    "Yeoh": {"c10": 2e5, "c20": 1e3, "c30": 1e2, "density": 1000.0},
    "Zone": {"name": "doubler", "where": ((0.0, 0.5), (0.0, 1.0)), "thickness": 0.02},
    "Clamp": {"where": "left"},
    "Dashpot": {"where": [(1.0, 1.0)], "damping": (1.0, 2.0, 3.0)},
    "Foundation": {"stiffness": 1e4, "direction": UP},
    "NoRotation": {"where": "left"},
    "Pin": {"where": np.array([[0.0, 0.0], [1.0, 1.0]])},
    "Prescribed": {"where": "left", "displacement": (0.0, None, 0.1), "history": sk.Ramp(0.1)},
    "Roller": {"where": ["left", "right"], "direction": UP},
    "SimpleSupport": {"where": "boundary"},
    "Spring": {"where": (1.0, 1.0), "stiffness": (1.0, 2.0, 3.0)},
    "Symmetry": {"where": "left"},
    "DiskForce": {"at": (0.5, 0.5), "radius": 0.1, "force": UP},
    "EdgeImpulse": {"where": "right", "impulse": UP, "time": 0.1},
    "EdgeLoad": {"where": "right", "force": UP, "history": GUST},
    "EdgeMoment": {"where": "right", "moment": UP},
    "FollowerPressure": {"pressure": 1e3},
    "Gravity": {"acceleration": (0.0, 1.0, -9.81)},
    "Impulse": {"at": (0.5, 0.5), "impulse": UP, "time": 0.1},
    "LineLoad": {"start": (0.0, 0.5), "end": (1.0, 0.5), "force": UP},
    "MovingForce": {"path": sk.Path([0.0, 1.0], [(0.0, 0.5), (1.0, 0.5)]), "force": UP},
    "MovingLine": {
        "start": sk.Path([0.0, 1.0], [(0.0, 0.0), (1.0, 0.0)]), "end": sk.Path([0.0, 1.0], [(0.0, 1.0), (1.0, 1.0)]),
        "force": UP,
    },
    "PointForce": {"at": [0.5, 0.5], "force": np.array([0.0, 1e-300, -1.0])},
    "PointMoment": {"at": (0.5, 0.5), "moment": UP},
    "SurfaceLoad": {"force": UP, "history": sk.Pulse(0.1, 0.2, "triangle")},
    "Temperature": {"change": 20.0, "gradient": 3.0},
    "Hinge": {"first": "left", "second": "right"},
    "RigidLink": {"a": (0.0, 0.0), "b": (1.0, 1.0), "name": "rod"},
    "Full": {"n_thickness": 3},
    "Kirchhoff": {"assumed": False},
    "Path": {"times": [0.0, 1.0], "points": [(0.0, 0.5), (1.0, 0.5)]},
    "Pulse": {"duration": 0.1, "shape": "rectangle"},
    "Ramp": {"duration": 0.1, "start": 0.2},
    "Table": {"times": [0.0, 0.5, 2.0], "values": [0.0, 1.0, 0.3], "kind": "smooth"},
    "Sampled": {"x": LINE, "y": LINE**2, "values": LINE[None]},
    "Splined": {"x": LINE, "y": LINE, "values": np.outer(LINE, LINE**2), "error": 1e-9},
    "DisplacementControl": {"at": (1.0, 0.5), "direction": UP, "to": 0.1},
    "DisplacementReached": {"at": (1.0, 0.5), "direction": UP, "value": 0.1},
    "HalveAndGrow": {"first": 0.5},
    "FixedStep": {"dt": 1e-3},
    "LocalError": {"rtol": 1e-4},
    "NewtonCount": {"dt": 1e-3},
    "RigidVelocity": {"velocity": UP, "spin": (0.0, 1.0, 0.0)},
    "ConditionForce": {"name": "rod"},
    "Displacement": {"at": (1.0, 0.5), "direction": UP},
    "Reaction": {"where": "left", "direction": UP},
    "Rotation": {"at": (1.0, 0.5), "towards": UP},
    "SectionForce": {"at": (0.5, 0.5), "component": "M11"},
    "Region": {"centre": (0.5, 0.5), "half_size": (0.1, 0.2)},
}  # fmt: skip
"""Arguments of those that need any."""
FUNCTIONS = {"DrivenClamp", "FormTerm", "Hyperelastic", "MappedSurface", "Problem"}
"""Those that have functions, or everything, and tests of their own."""


def example(name: str) -> Any:
    """An object of a class."""
    return class_named(name)(**EXAMPLES.get(name, {}))


def every() -> list[str]:
    """Names of all classes that are described without functions."""
    return sorted(KINDS.keys() - FUNCTIONS)


def problem() -> sk.Problem:
    """One with a zone, a spring and a history."""
    return sk.Problem(
        sk.Rectangle(1.0, 0.5), 0.01, STEEL, [sk.Clamp("left"), sk.Spring((1.0, 0.5), (1e3, 1e3, 1e3))],
        [sk.PointForce((1.0, 0.0), (0.0, 0.0, -2000.0), history=GUST), sk.Gravity()], sk.Damping(stiffness=1e-4),
        zones=[sk.Zone("doubler", ((0.0, 0.5), (0.0, 0.5)), 0.02)],
    )  # fmt: skip


def system(theory: str = "kirchhoff", tree: bool = False) -> Any:
    """On a mesh of eight elements, or on a quadtree."""
    asked = problem()
    mesh = sk.meshes.uniform(asked.surface, 4, 2)
    return asked.on(sk.meshes.quadtree(mesh).refined([0]) if tree else mesh, theory)


def linked() -> Any:
    """A system with conditions."""
    asked = sk.Problem(
        sk.Rectangle(1.0, 0.5), 0.01, STEEL, [sk.Clamp("left")], [sk.PointForce((1.0, 0.0), (0.0, 0.0, -100.0))],
        conditions=[sk.RigidLink((1.0, 0.0), (1.0, 0.5), name="rod")],
    )  # fmt: skip
    return asked.on(sk.meshes.uniform(asked.surface, 4, 2), "kirchhoff")


def results() -> dict[str, Any]:
    """One of each kind of result, by its class."""
    plain, tree = system(), system("full", tree=True)
    pushed = sk.Problem(sk.Rectangle(1.0, 0.5), 0.01, STEEL, [sk.Clamp("left")], [sk.EdgeLoad("right", (-1.0, 0.0, 0.0))])
    made = [
        sk.solve_linear(plain), sk.solve(tree), sk.solve(linked()), sk.trace(plain, until=1.0), sk.modes(tree, 2),
        sk.buckling(pushed.on(plain.mesh, "kirchhoff"), 2),
        sk.simulate(plain, 0.02, dt=2e-3, outputs=5, record={"u": lambda state: state.displacement((1.0, 0.5))},
                    progress=False),
        sk.simulate(linked(), 0.004, dt=1e-3, outputs="steps", progress=False),
        sk.adapt(problem(), sk.StrainEnergy(), 0.05),
    ]  # fmt: skip
    names = ["Solution", "StaticResult", "with conditions", "PathResult", "Modes", "BucklingResult", "Motion",
             "Motion with conditions", "AdaptiveResult"]  # fmt: skip
    return dict(zip(names, made, strict=True))


assert storage.Splined.__module__ == "skancf.storage.splined"
