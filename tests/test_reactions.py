"""Forces and moments of supports: known ones, and their sums against the loads."""

import numpy as np
import pytest

import skancf as sk
from skancf.vectors import sum_of_cross

STRIP, STEEL = sk.Rectangle(2.0, 0.5), sk.Isotropic(2e9, 0.0, 7.8e3)
THEORIES = ["kirchhoff", "full"]


def solved(supports, loads, theory="kirchhoff", linear=True, n=(8, 2), **more):
    system = sk.Problem(STRIP, 0.02, STEEL, supports, loads, **more).on(sk.meshes.uniform(STRIP, *n), theory)
    return sk.solve_linear(system) if linear else sk.solve(system).unwrap()


def loads_of(state):
    """Sum of the loads and their moment about the origin."""
    system = state.system
    force = system.shell.nodal(state.model.external_force(state.unknowns, state.case))
    return force[:, 0].sum(axis=0), sum_of_cross(system.shell.nodal(state.about), force)


@pytest.mark.parametrize("theory", THEORIES)
def test_a_cantilever_has_the_moment_of_its_load(theory):
    state = solved([sk.Clamp("left")], [sk.EdgeLoad("right", (0, 0, 4.0))], theory)
    table = state.reactions_by_support()
    force, moment = table["Clamp 'left'"]
    assert np.allclose(force, [0, 0, -2], atol=1e-9) and np.allclose(moment, [0, 4, 0], atol=1e-7)
    assert np.allclose(table.points, [[0, 0.25, 0]]) and np.allclose(state.reaction_moment("left"), moment)
    assert np.allclose(state.reaction_moment("left", about=(1, 0.25, 0)), [0, 2, 0], atol=1e-7)
    assert np.allclose(state.reactions_by_support((1, 0.25, 0)).moments, [[0, 2, 0]], atol=1e-7)
    with pytest.raises(sk.InputError, match="name = 'Pin': no such support; there are \"Clamp 'left'\""):
        _ = table["Pin"]


@pytest.mark.parametrize("theory", THEORIES)
@pytest.mark.parametrize("linear", [True, False])
def test_sums_balance_the_loads(theory, linear):
    """Supports that share corners, springs, a foundation, in a state that bends a lot."""
    supports = [
        sk.Clamp("left"), sk.SimpleSupport("bottom"), sk.Spring("right", (50.0, 20.0, 80.0)), sk.Foundation(30.0),
    ]  # fmt: skip
    state = solved(supports, [sk.SurfaceLoad((3.0, -1.0, 40.0)), sk.EdgeLoad("top", (0, 10.0, 5.0))], theory, linear)
    table = state.reactions_by_support()
    assert table.names == ("Clamp 'left'", "SimpleSupport 'bottom'", "Spring 'right'", "Foundation")
    force, moment = loads_of(state)
    assert np.abs(table.total_force + force).max() < 1e-7 * np.abs(force).max()
    assert np.abs(table.total_moment + moment).max() < 1e-6 * np.abs(moment).max()
    assert np.abs(table.total_force - state.reactions()).max() < 1e-9 * np.abs(force).max()
    assert np.abs(table.total_moment - state.reaction_moment(about=(0, 0, 0))).max() < 1e-7 * np.abs(moment).max()
    assert (np.abs(table.forces).max(axis=1) > 1e-3).all(), "each of them takes part"
    spring = -np.array([50.0, 20.0, 80.0]) * 0.5
    mean = state.displacement([(2.0, y) for y in np.linspace(0, 0.5, 401)])
    mean = (mean[1:] + mean[:-1]).mean(axis=0) / 2
    assert np.allclose(table["Spring 'right'"][0], spring * mean, rtol=1e-3)


def test_a_shared_coordinate_is_shared_and_others_are_not():
    """Left holds x, y and z; bottom holds z alone: only z of their corner is shared."""
    z_only = sk.Prescribed("bottom", (None, None, 0))
    both = solved([sk.Pin("left"), z_only], [sk.EdgeLoad("right", (6.0, 0, 0))])
    pin, lifted = both.reactions_by_support().forces
    assert np.allclose(pin, [-3, 0, 0], atol=1e-9) and np.allclose(lifted, 0, atol=1e-9)
    twice = solved([sk.Clamp("left"), sk.Pin("left"), sk.Clamp("left")], [sk.EdgeLoad("right", (0, 0, 4.0))])
    table = twice.reactions_by_support()
    assert table.names == ("Clamp 'left' 1", "Pin 'left'", "Clamp 'left' 2")
    assert np.allclose(table.forces[:, 2], -2 / 3) and np.allclose(table.moments[:, 1].sum(), 4.0)


def test_links_and_hinges_are_listed_and_tied_parts_have_no_net_force():
    link = sk.RigidLink((0.5, 0.0), (1.5, 0.5))
    state = solved([sk.Clamp("left")], [sk.EdgeLoad("right", (0, 0, 4.0))], linear=False, conditions=[link])
    table = state.reactions_by_support()
    force, moment = loads_of(state)
    assert len(table.names) == 2 and np.abs(table.forces[1]).max() < 1e-9 and np.abs(table.moments[1]).max() < 1e-9
    assert np.abs(table.total_force + force).max() < 1e-7 and np.abs(table.total_moment + moment).max() < 1e-6
    assert abs(next(iter(state.conditions.values()))) > 1e-3, "the link carries a force"


def test_a_table_and_a_state_that_moves():
    state = solved([sk.Clamp("left")], [sk.EdgeLoad("right", (0, 0, 4.0))])
    columns = state.reactions_by_support().columns
    assert list(columns) == ["support", "Fx", "Fy", "Fz", "Mx", "My", "Mz", "X", "Y", "Z"]
    moving = sk.Solution(state.system, state.q, np.ones(state.q.size), 0.0)
    for ask in (moving.reactions, moving.reaction_moment, moving.reactions_by_support):
        with pytest.raises(sk.InputError, match="this state moves"):
            ask()
