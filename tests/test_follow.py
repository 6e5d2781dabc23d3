"""Meshes that follow a motion: fronts and loads are followed, nothing is lost on the way, and it is all in the ledger."""

import dataclasses
import itertools

import numpy as np
import pytest

import skancf as sk

PLATE = sk.Problem(
    sk.Rectangle(2.0, 2.0), 0.01, sk.Isotropic(1e7, 0.0, 1000.0), [sk.Foundation(2e3)],
    [sk.MovingForce(lambda t: (0.4 + t, 1.0), (0, 0, -1.0), history=sk.Ramp(0.2))], damping=sk.Damping(1.0, 5e-4),
)  # fmt: skip


def tree(problem, n=4):
    return sk.meshes.quadtree(sk.meshes.uniform(problem.surface, n, n))


def followed(problem, t_end, n=4, theory="kirchhoff", rtol=2e-3, outputs=21, follow=None, **options):
    system = problem.on(tree(problem, n), theory)
    return sk.simulate(system, t_end, rtol=rtol, outputs=outputs, progress=False, follow=follow or sk.Follow(0.3), **options)


@pytest.fixture(scope="module")
def running():
    """A load that runs over a plate on an elastic foundation."""
    levels = {}

    def under_load(state):
        mesh = state.system.mesh
        element = state.system.geometry.locate((0.4 + state.time, 1.0))[0]
        levels[state.time] = mesh.levels[element], mesh.levels.max()
        return mesh.t.shape[1]

    motion = followed(PLATE, 1.2, record={"elements": under_load})
    assert motion.ok, motion.message
    return motion, levels


def test_the_load_is_never_outside_of_the_fine_part(running):
    _motion, levels = running
    later = [pair for time, pair in levels.items() if time > 0.3]
    assert len(later) > 30 and max(finest for _, finest in later) >= 2
    # The finest elements are where the curvature is; those under the load are at most one level coarser.
    assert all(own >= finest - 1 for own, finest in later)


def test_elements_behind_the_load_are_merged(running):
    motion, _ = running
    first = next(state for state in motion.states if state.time > 0.3)
    last = list(motion.states)[-1]

    def level_at(state, at):
        return state.system.mesh.levels[state.system.geometry.locate(at)[0]]

    assert level_at(first, (0.75, 1.0)) > level_at(last, (0.75, 1.0))
    assert level_at(last, (1.55, 1.0)) > level_at(first, (1.55, 1.0))


def test_following_costs_less_than_the_fine_mesh_and_finds_its_answer(running):
    motion, _ = running
    fine = sk.simulate(PLATE.on(tree(PLATE, 16), "kirchhoff"), 1.2, rtol=2e-3, outputs=21, progress=False)
    coarse = sk.simulate(PLATE.on(tree(PLATE, 4), "kirchhoff"), 1.2, rtol=2e-3, outputs=21, progress=False)
    w = [np.array([-m.at(t).displacement((0.4 + t, 1.0))[2] for t in m.times[8:]]) for m in (motion, fine, coarse)]
    error, without = (np.abs(x - w[1]).mean() / w[1].mean() for x in (w[0], w[2]))
    # An error of 0.3 in the energy norm is some 0.09 of an energy, and so of a deflection.
    assert error < 0.09 < without
    unknowns = np.mean([step.n_dofs for step in motion.steps])
    assert unknowns < 0.6 * fine.system.n_dofs


def test_every_change_is_in_the_ledger(running):
    motion, _ = running
    ledger, parts = motion.ledger, motion.segments
    assert len(ledger.events) == sum(a.system is not b.system for a, b in itertools.pairwise(parts)) > 3
    for event, before, after in zip(ledger.events, parts, parts[1:], strict=False):
        assert (event.before, event.after) == (before.system.geometry.n_elements, after.system.geometry.n_elements)
        assert event.time == before.times[-1] == after.times[0]
    changes = sum(event.strain + event.kinetic for event in ledger.events if not event.again)
    assert ledger.remeshing[-1] == pytest.approx(changes, abs=1e-3 * ledger.turnover[-1])
    # With what changes of the mesh took, the energy balances to what the integration loses.
    assert abs(ledger.balance[-1]) < 0.05 * ledger.turnover[-1]


def test_a_front_that_was_outrun_is_computed_again():
    """A blow on a plate on a coarse mesh: the first interval ends far beyond the asked error."""
    blow = dataclasses.replace(PLATE, loads=[sk.Impulse((1.0, 1.0), (0, 0, 0.05))], supports=[])
    motion = followed(blow, 0.05, follow=sk.Follow(0.3, every=5))
    again = [event for event in motion.ledger.events if event.again]
    assert again and all(event.after > event.before for event in again)
    # What was computed in vain counts as rejected, and the times of the ledger ascend.
    assert sum(not step.accepted for step in motion.steps) >= 5
    assert (np.diff(motion.ledger.times) >= 0).all() and (np.diff(motion.times) > 0).all()
    accepted = sum(step.dt for step in motion.steps if step.accepted)
    assert accepted == pytest.approx(0.05)


@pytest.mark.parametrize("theory", ["kirchhoff", "full"])
def test_a_free_body_keeps_its_momenta_over_all_changes(theory):
    free = sk.Problem(sk.Rectangle(1.0, 1.0), 0.02, sk.Isotropic(1e6, 0.3, 1000.0), damping=sk.Damping(stiffness=1e-3))
    spin = sk.RigidVelocity((0.5, 0.0, 1.0), (1.0, 2.0, 0.5), about=(0.5, 0.5, 0.0))
    system = free.on(tree(free), theory)
    v = spin.at(system.undeformed).reshape(-1, 4, 3)
    x, y = system.undeformed.reshape(-1, 4, 3)[:, 0, :2].T
    v[:, 0, 2] += np.exp(-((x - 0.5) ** 2 + (y - 0.5) ** 2) / 0.02)
    motion = sk.simulate(system, 0.2, dt=4e-3, velocity=v.ravel(), newton_rtol=1e-9, outputs=11, progress=False,
                         follow=sk.Follow({"kirchhoff": 0.1, "full": 0.15}[theory], every=5), balance=None)  # fmt: skip
    ledger = motion.ledger
    assert motion.ok and len(ledger.events) > 2 and {e.after > e.before for e in ledger.events} == {True, False}
    for momentum in (ledger.linear, ledger.angular):
        # Newton's method leaves 1e-9 of the energy norm in each step, a change of mesh 1e-12.
        assert np.abs(momentum - momentum[0]).max() < 1e-8 * np.abs(momentum[0]).max()
    # Changes of mesh never raise the energy, but for the rounding of the sum.
    assert (np.diff(ledger.remeshing) < 1e-9 * ledger.turnover[-1]).all()
    assert np.abs(ledger.balance).max() < 1e-8 * ledger.turnover[-1]


def test_a_plate_at_rest_keeps_its_mesh():
    rest = dataclasses.replace(PLATE, loads=[])
    motion = followed(rest, 0.1, velocity=sk.RigidVelocity((0, 0, 0.1)))
    assert not motion.ledger.events and motion.system.geometry.n_elements == 16


def test_a_mesh_that_may_not_grow_is_warned_of():
    with pytest.warns(sk.OutOfDepth, match="max_dofs = 400: the mesh that this motion asks for has"):
        motion = followed(PLATE, 0.3, follow=sk.Follow(0.1, max_dofs=400))
    assert motion.ok and max(step.n_dofs for step in motion.steps) <= 400


def test_states_between_meshes_are_found_at_any_time(running):
    motion, _ = running
    with pytest.raises(sk.InputError, match="states on several meshes"):
        _ = motion.q
    places = np.array([motion.at(t).displacement((1.0, 1.0))[2] for t in np.linspace(0.3, 1.2, 200)])
    # Deflections are continuous, also over changes of the mesh: the load takes 1 s over 1 m.
    assert np.abs(np.diff(places)).max() < 0.1 * np.ptp(places)
    assert motion.displacement((1.0, 1.0)).shape == (21, 3)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"rtol": 0.0}, "rtol = 0.0"), ({"every": 0}, "every = 0"), ({"every": 2.5}, "every = 2.5"),
        ({"max_dofs": -1}, "max_dofs = -1"), ({"indicator": 3}, "indicator = 3"), ({"energy": -1.0}, "energy = -1.0"),
    ],
)  # fmt: skip
def test_bad_policies_are_refused(options, message):
    with pytest.raises(sk.InputError, match=message):
        sk.Follow(**options)


def test_a_mesh_without_a_tree_is_refused():
    system = PLATE.on(sk.meshes.uniform(PLATE.surface, 4, 4), "kirchhoff")
    with pytest.raises(sk.InputError, match=r"must be a quadtree; make it by sk\.meshes\.quadtree"):
        sk.simulate(system, 0.1, follow=sk.Follow(), progress=False)


def test_the_mass_is_assembled_once_for_each_mesh(monkeypatch):
    from skancf.terms.shell import Shell

    count, gathered = [], Shell.add_gathered
    monkeypatch.setattr(Shell, "add_gathered", lambda self, *a: count.append(id(self)) or gathered(self, *a))
    motion = followed(PLATE, 0.3)
    assert len(set(count)) == len(count) == 1 + len(motion.ledger.events) > 1
