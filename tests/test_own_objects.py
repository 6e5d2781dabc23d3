"""Surfaces, laws, loads, supports, step controls and quantities of the user's own.

What is wrong with them is named before any work, and what their methods raise has a note that says which.
"""

from typing import Any

import numpy as np
import pytest

import skancf as sk
from skancf.loads.acting import Acting
from skancf.supports.conditions import Row, Support
from skancf.surfaces.checks import require_surface

MATERIAL = sk.Isotropic(1e7, 0.3, 1e3)
PLATE = sk.Rectangle(1.0, 1.0)


class Unbounded:
    """A plane, as a user may write it."""

    closed = (False, False)

    def position(self, x: Any, y: Any) -> Any:
        x, y = np.broadcast_arrays(x, y)
        return np.array([x, y, 0 * x], float)

    def derivatives(self, x: Any, y: Any) -> Any:
        x, y = np.broadcast_arrays(x, y)
        return np.array([1 + 0 * x, 0 * x, 0 * x], float), np.array([0 * x, 1 + 0 * x, 0 * x], float)

    def second_derivatives(self, x: Any, y: Any) -> Any:
        zero = np.zeros((3, *np.broadcast(x, y).shape))
        return zero, zero, zero


class Flat(Unbounded):
    bounds = ((0, 1), (0, 1))
    sides = ("left", "right", "bottom", "top")


def like(kind: type, **changed: Any) -> Any:
    return type(kind.__name__, (kind,), changed)()


def plate(surface: Any = PLATE, material: Any = MATERIAL, supports: Any = (), loads: Any = (), mesh: Any = None) -> Any:
    mesh = sk.meshes.uniform(PLATE, 2, 2) if mesh is None else mesh
    supports = [sk.Clamp("left"), *supports]
    return sk.Problem(surface, 0.01, material, supports, loads or [sk.Gravity()]).on(mesh, "kirchhoff")


def fails(*_: Any) -> Any:
    raise KeyError("mine")


def test_a_surface_of_ones_own_is_like_that_of_the_library():
    own, ours = (sk.solve_linear(plate(surface)) for surface in (like(Flat), PLATE))
    assert np.array_equal(own.q, ours.q)


@pytest.mark.parametrize("changed, says", [
    ({"position": lambda s, x, y: None}, r"surface\.position\(x, y\) = None: not a number"),
    ({"position": lambda s, x, y: np.stack([x, y])}, r"surface\.position of shape \(2, 2, 3\).*three components"),
    ({"position": lambda s, x, y: np.array([x, y, np.inf * x])}, r"surface\.position.*not finite"),
    ({"derivatives": lambda s, x, y: None}, r"surface\.derivatives returned None; it must return 2 arrays"),
    ({"derivatives": lambda s, x, y: np.zeros((3, 2, 3))}, r"surface\.derivatives returned .*2 arrays"),
    ({"derivatives": 5}, r"surface\.derivatives = 5: give a method"),
    ({"second_derivatives": lambda s, x, y: (np.zeros((3, *x.shape)),) * 2}, r"surface\.second_derivatives.*3 arrays"),
    ({"second_derivatives": None}, r"surface\.second_derivatives = None: give a method"),
    ({"closed": None}, r"surface\.closed = None: give two"),
    ({"closed": "no"}, r"surface\.closed = 'no'"),
    ({"bounds": None}, r"surface\.bounds = None"),
    ({"bounds": (0, 1, 0, 1)}, r"surface\.bounds = \(0, 1, 0, 1\): give \(\(x min, x max"),
    ({"bounds": ((1, 0), (0, 1))}, r"surface\.bounds.*min < max"),
    ({"sides": ("a", "b", "c")}, r"surface\.sides = .*four different names"),
    ({"sides": ("a", "b", "c", "corners")}, r"surface\.sides = .*none of boundary, corners"),
    ({"sides": (1, 2, 3, 4)}, r"surface\.sides = \(1, 2, 3, 4\)"),
])  # fmt: skip
def test_a_wrong_surface_is_named(changed, says):
    surface = like(Flat, **changed)
    for use in (plate, require_surface):
        with pytest.raises(sk.InputError, match=f"(?s){says}"):
            use(surface)


def test_a_surface_without_bounds_is_asked_on_the_mesh():
    with pytest.raises(sk.InputError, match=r"surface\.position of shape \(3,\)"):
        plate(like(Unbounded, position=lambda s, x, y: np.zeros(3)))


class OwnLaw:
    density = 1e3

    def stiffness(self) -> Any:
        return MATERIAL.stiffness()

    def thermal_strain(self) -> Any:
        return np.zeros(6)


class OwnLoad:
    def on(self, assembly: Any) -> Any:
        return like(Acting, force=lambda s, q, case: np.ones_like(q))


class OwnSupport(Support):
    def rows(self, geometry: Any) -> Any:
        return [Row(8, np.eye(12)[2], 0.01)]


class OwnSteps:
    smallest = 1e-3

    def first(self, guess: float) -> Any:
        return 0.005

    def accepts(self, attempt: Any) -> Any:
        return True

    def next_step(self, attempt: Any) -> Any:
        return 0.005


class OwnQuantity:
    unit = "m"

    def value(self, state: sk.Solution) -> Any:
        return float(state.q.sum())

    def gradient(self, state: sk.Solution) -> Any:
        return np.ones(state.q.size)


def law(**changed: Any) -> Any:
    return plate(material=like(OwnLaw, **changed))


def load(**changed: Any) -> Any:
    return plate(loads=[like(OwnLoad, **changed)])


def support(**changed: Any) -> Any:
    return sk.solve_linear(plate(supports=[like(OwnSupport, **changed)]))


def steps(**changed: Any) -> Any:
    return sk.simulate(plate(), 0.01, steps=like(OwnSteps, **changed), progress=False).unwrap()


def quantity(**changed: Any) -> Any:
    mesh = sk.meshes.uniform(PLATE, 2, 2)
    return sk.adapt(plate().problem, like(OwnQuantity, **changed), rtol=0.5, mesh=mesh, linear=True, max_levels=1,
                    progress=False)  # fmt: skip


@pytest.mark.parametrize("use", [law, load, support, steps, quantity])
def test_what_is_right_is_taken(use):
    assert use() is not None


@pytest.mark.parametrize("use, changed, says", [
    (law, {"stiffness": lambda s: None}, r"material\.stiffness\(\) = None"),
    (law, {"stiffness": lambda s: np.eye(3)}, r"material\.stiffness\(\) of shape \(3, 3\).*6 x 6"),
    (law, {"stiffness": lambda s: np.zeros((6, 6))}, "not positive definite"),
    (law, {"thermal_strain": lambda s: 0.0}, r"material\.thermal_strain\(\).*6 numbers"),
    (law, {"density": "1000"}, r"material\.density = '1000': not a number"),
    (load, {"on": lambda s, assembly: None}, "load.on of .* = None: give what acts"),
    (load, {"on": lambda s, assembly: np.ones(3)}, "load.on of .*skancf.loads.acting.Acting"),
    (support, {"rows": lambda s, geometry: [None]}, r"support\.rows of .*None is no condition"),
    (support, {"rows": lambda s, geometry: [Row(10**6, np.ones(12))]}, r"node = 1000000 .*nodes 0 to 8"),
    (support, {"rows": lambda s, geometry: [Row(0, np.ones(3))]}, "a, of a row .*12 numbers"),
    (steps, {"first": lambda s, guess: None}, r"steps\.first = None"),
    (steps, {"first": lambda s, guess: -1.0}, r"steps\.first = -1\.0 s: give a number greater than zero"),
    (steps, {"accepts": lambda s, attempt: "yes"}, r"steps\.accepts = 'yes': give True or False"),
    (steps, {"accepts": lambda s, attempt: False}, r"steps\.next_step = 0\.005 s after a step of 0\.005 s that was not"),
    (steps, {"next_step": lambda s, attempt: float("nan")}, r"steps\.next_step = nan"),
    (quantity, {"value": lambda s, state: None}, r"quantity\.value = None"),
    (quantity, {"value": lambda s, state: np.ones(2)}, r"quantity\.value = .*one number"),
    (quantity, {"gradient": lambda s, state: np.ones(3)}, r"quantity\.gradient = .*give [0-9]+ numbers"),
])  # fmt: skip
def test_what_is_wrong_is_named(use, changed, says):
    with pytest.raises(sk.SkancfError, match=f"(?s){says}"):
        use(**changed)


@pytest.mark.parametrize("use, method, note", [
    (lambda **changed: plate(like(Flat, **changed)), "derivatives", "surface"), (law, "stiffness", "material"),
    (load, "on", "load.on"), (support, "rows", "support.rows"), (quantity, "value", "quantity.value"),
    (quantity, "gradient", "quantity.gradient"),
])  # fmt: skip
def test_what_methods_raise_has_a_note(use, method, note):
    with pytest.raises(KeyError, match="mine") as raised:
        use(**{method: fails})
    assert any(known.endswith(f"given as {note}") for known in raised.value.__notes__)
