"""Quantities of interest: their gradients by differences, their values by what is known, and which have no limit."""

from functools import cache
from math import pi

import numpy as np
import pytest
import skfem
from reference import elastica, navier

import skancf as sk
from skancf.adapt import Displacement, Reaction, Rotation, SectionForce, StrainEnergy, drift, no_limit
from skancf.adapt.quantities.section_force import COMPONENTS
from skancf.errors import InputError

MATERIAL = sk.Isotropic(1e6, 0.3, 1.0, expansion=1e-5)
THEORIES = ("full", "kirchhoff")
theories = pytest.mark.parametrize("theory", THEORIES)

SURFACES = {
    "flat": sk.Rectangle(1.0, 1.2),
    "curved": sk.CylinderSector(1.0, 1.0, 1.2),
    "closed": sk.CylinderSector(1.0, 1.0, 2 * pi, closed=True),
    "poled": sk.SphereSector(1.0, (0.0, 0.8), 2 * pi, closed=True),
}


def share(surface, x: float, y: float) -> tuple[float, float]:
    """A point at parts of the two parameters."""
    (x0, x1), (y0, y1) = surface.bounds
    return x0 + x * (x1 - x0), y0 + y * (y1 - y0)


def held(surface):
    end = surface.bounds[0][1]
    return lambda x, y: abs(x - end) < 1e-9


def loaded(surface) -> sk.Problem:
    """All that has a part in a gradient: springs, a foundation, temperature, and pressure with open edges."""
    inside = share(surface, 2 / 3, 0.5)
    supports = [sk.Clamp(held(surface)), sk.Spring(inside, (3.0, 2.0, 5.0)), sk.Spring(held(surface), (1e3, 0.0, 2e3)),
                sk.Foundation(40.0)]  # fmt: skip
    heat = sk.Temperature(lambda x, y: 20.0 * (1 + x) + 0 * y, lambda x, y: 300.0 * (1 + np.sin(y)) + 0 * x)
    loads = [sk.FollowerPressure(30.0), heat, sk.PointForce(inside, (1.0, 2.0, 3.0))]
    return sk.Problem(surface, 0.05, MATERIAL, supports, loads)


@cache
def state(name: str, theory: str, linear: bool) -> sk.Solution:
    """Any change of shape will do: no equilibrium is asked for."""
    surface = SURFACES[name]
    system = loaded(surface).on(sk.meshes.uniform(surface, 3, 6 if name in ("closed", "poled") else 4), theory=theory)
    q = system.undeformed + bump(system, np.random.default_rng(7), 0.03)
    return sk.Solution(system, q, load_factor=0.7, linear=linear)


def bump(system, rng, size: float) -> np.ndarray:
    """A change of all nodal coordinates, of a part of an element in position."""
    scale = np.array([0.3, 1.0, 1.0, 1.0]) * size
    return (scale[:, None] * rng.uniform(-1, 1, (system.geometry.n_nodes, 4, 3))).ravel()


def quantities(surface) -> dict:
    at, (x, y) = share(surface, 0.4, 0.3), surface.bounds
    some = (x[0] - 0.01, sum(x) / 2), (y[0] + 0.1, y[0] + 0.7 * (y[1] - y[0]))
    return {
        "displacement": Displacement(at, (1.0, -2.0, 0.5)),
        "rotation": Rotation(at, (0.3, 1.0, 0.2)),
        "normal force": SectionForce("N11", at=at),
        "shear force": SectionForce("N12", at=share(surface, 1 / 3, 0.5)),
        "moment": SectionForce("M22", at=at),
        "twist": SectionForce("M12", at=at),
        "mean normal force": SectionForce("N22", within=some),
        "mean moment": SectionForce("M11", within=some),
        "mean of all": SectionForce("M12"),
        "reaction": Reaction(held(surface), (0.2, 0.5, 1.0)),
        "reaction of a spring": Reaction(share(surface, 2 / 3, 0.5), (0.2, 0.5, 1.0)),
        "all reactions": Reaction(None, (0.0, 1.0, 0.0)),
        "energy": StrainEnergy(),
    }


def slope(quantity, solution, along, step=1e-3) -> float:
    """Central differences of fourth order."""
    def at(s):
        return quantity.value(sk.Solution(solution.system, solution.q + s * step * along, load_factor=solution.load_factor,
                                          linear=solution.linear))  # fmt: skip

    return (8 * (at(1) - at(-1)) - (at(2) - at(-2))) / (12 * step)


@pytest.mark.parametrize("what", quantities(SURFACES["flat"]))
@pytest.mark.parametrize("linear", [False, True], ids=["deformed", "linear"])
@pytest.mark.parametrize("name", SURFACES)
@theories
def test_gradient_is_the_derivative(theory, name, linear, what, rng):
    solution, quantity = state(name, theory, linear), quantities(SURFACES[name])[what]
    gradient = quantity.gradient(solution)
    assert gradient.shape == (solution.system.n_dofs,) and np.any(gradient)
    for _ in range(2):
        along = bump(solution.system, rng, 0.1)
        # The differences are good for 1e-9; against the sum of all parts, which may cancel.
        size = np.linalg.norm(gradient * along)
        assert abs(gradient @ along - slope(quantity, solution, along)) < 1e-7 * size
        assert abs(1.001 * gradient @ along - slope(quantity, solution, along)) > 1e-7 * size, "the test has teeth"
