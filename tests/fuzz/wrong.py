"""Statements that must be refused, by chance: a number of a good statement replaced by none."""

from typing import Any

from hypothesis import strategies as st

import skancf as sk
from fuzz.bodies import among

GOOD: list[tuple[Any, dict[str, Any]]] = [
    (sk.Rectangle, {"length_x": 1.0, "length_y": 2.0, "origin": (0.0, 1.0)}),
    (sk.Parallelogram, {"length_x": 1.0, "length_y": 2.0, "angle": 1.0}),
    (sk.CylinderSector, {"radius": 1.0, "length": 2.0, "angle": 1.0, "start": 0.5}),
    (sk.Cone, {"radius_low": 1.0, "radius_high": 2.0, "height": 1.0, "angle": 1.0}),
    (sk.SphereSector, {"radius": 1.0, "polar": (0.2, 1.0), "angle": 1.0}),
    (sk.AnnulusSector, {"inner": 1.0, "outer": 2.0, "angle": 1.0}),
    (sk.HyperbolicParaboloid, {"length_x": 1.0, "length_y": 2.0, "rise": 0.3}),
    (sk.Isotropic, {"young": 1e9, "poisson": 0.3, "density": 1e3, "shear_correction": 0.8, "expansion": 1e-5}),
    (sk.Orthotropic, {"young": (2e9, 1e9, 1e9), "poisson": (0.2, 0.2, 0.2), "shear": (1e8, 1e8, 1e8), "density": 1e3}),
    (sk.PointForce, {"at": (0.5, 0.5), "force": (0.0, 0.0, 1.0)}),
    (sk.DiskForce, {"at": (0.5, 0.5), "radius": 0.1, "force": (0.0, 0.0, 1.0)}),
    (sk.LineLoad, {"start": (0.5, 0.5), "end": (0.1, 0.5), "force": (0.0, 0.0, 1.0)}),
    (sk.SurfaceLoad, {"force": (0.0, 0.0, 1.0)}),
    (sk.EdgeMoment, {"where": "left", "moment": (0.0, 0.0, 1.0)}),
    (sk.Gravity, {"acceleration": (0.0, 0.0, 1.0)}),
    (sk.FollowerPressure, {"pressure": 1.0}),
    (sk.Temperature, {"change": 1.0, "gradient": 2.0}),
    (sk.Roller, {"where": "left", "direction": (0.0, 0.0, 1.0)}),
    (sk.Spring, {"where": "left", "stiffness": (0.0, 0.0, 1.0)}),
    (sk.Foundation, {"stiffness": 1.0}),
    (sk.Prescribed, {"where": "left", "displacement": (0.0, None, 1.0)}),
]  # fmt: skip
NONE = among(float("nan"), float("inf"), -float("inf"), "one", 1j, [1.0, [2.0]])


@st.composite
def statements(draw: Any) -> tuple[Any, dict[str, Any]]:
    """A kind of statement, and arguments of which one is no number, or one entry of it."""
    make, good = draw(st.sampled_from(GOOD))
    name = draw(st.sampled_from([name for name in good if name != "where"]))
    value, bad = good[name], draw(NONE)
    if isinstance(value, tuple) and draw(st.booleans()):
        k = draw(st.sampled_from([k for k, entry in enumerate(value) if entry is not None]))
        bad = (*value[:k], bad, *value[k + 1 :])
    return make, {**good, name: bad}


def refused(statement: tuple[Any, dict[str, Any]]) -> None:
    """InputError, before any work."""
    make, arguments = statement
    try:
        make(**arguments)
    except sk.InputError:
        return
    raise AssertionError(f"{make.__name__} takes {arguments}")
