"""Problems of every kind and scale, made by chance: the bounded part of ``make fuzz``, always the same examples."""

import numpy as np
import pytest
from fuzz.properties import PROPERTIES
from fuzz.run import Failure, run

from skancf.assembly.system import System
from skancf.dynamics import checkpoint
from skancf.dynamics.energy_momentum import EnergyMomentum
from skancf.dynamics.steps import LocalError
from skancf.solution import Solution
from skancf.statics import Modes, cascade, equilibrium


@pytest.mark.parametrize("name", PROPERTIES)
def test_what_must_hold_holds_for_problems_made_by_chance(name):
    run(name, PROPERTIES[name])


def _reactions_too_large(monkeypatch):
    keep = Solution.reactions
    monkeypatch.setattr(Solution, "reactions", lambda self: 1.001 * keep(self))


def _energy_too_large(monkeypatch):
    keep = System.linear_energy
    monkeypatch.setattr(System, "linear_energy", lambda self, *rest: 1.0001 * keep(self, *rest))


def _loads_that_grow_faster(monkeypatch):
    keep = System.linear_change
    monkeypatch.setattr(System, "linear_change", lambda self, *rest: keep(self, *rest) * (1 + abs(keep(self, *rest)).max()))
    monkeypatch.setattr(equilibrium, "unmet", lambda measured: [])  # which would have refused such an answer


def _forces_by_the_axes_of_space(monkeypatch):
    keep = System.applied_force
    turn = np.tile([1.0, 1.01, 1.0], 4)
    monkeypatch.setattr(System, "applied_force", lambda self, *rest: keep(self, *rest) * np.resize(turn, self.n_dofs))


def _loads_by_the_order_of_nodes(monkeypatch):
    keep = System.applied_force
    monkeypatch.setattr(
        System, "applied_force", lambda self, *rest: keep(self, *rest) * np.linspace(1.0, 1.01, self.n_dofs)
    )


def _newton_that_ends_early(monkeypatch):
    keep = cascade.newton
    monkeypatch.setattr(cascade, "newton", lambda *rest, **options: keep(*rest, **{**options, "rtol": 1e-1}))
    monkeypatch.setattr(cascade.Cascade, "_verified", lambda self, result: result)


def _one_rigid_motion_missed(monkeypatch):
    monkeypatch.setattr(Modes, "n_rigid", property(lambda self: 5, lambda self, value: None), raising=False)


def _loads_that_do_not_scale(monkeypatch):
    keep = System.applied_force

    def applied(self, *rest):
        force = keep(self, *rest)
        return force * (1 + 0.02 * np.sin(np.log(np.abs(force).max() + 1e-300)))

    monkeypatch.setattr(System, "applied_force", applied)


def _stresses_that_feed(monkeypatch):
    keep = EnergyMomentum.stresses
    monkeypatch.setattr(EnergyMomentum, "stresses", lambda self, *rest: 1.02 * keep(self, *rest))


def _a_force_from_nowhere(monkeypatch):
    keep = System.force_between

    def between(self, *rest):
        force = keep(self, *rest)
        return force + 1e-3 * np.abs(force).max() * np.tile([1.0, 0.0, 0.0] + 9 * [0.0], self.n_dofs // 12)

    monkeypatch.setattr(System, "force_between", between)


def _states_without_what_was_before(monkeypatch):
    monkeypatch.setattr(checkpoint, "_optional", lambda state: {"jerk": None, "before": None})


def _errors_made_small(monkeypatch):
    keep = LocalError.over
    monkeypatch.setattr(LocalError, "over", lambda self, attempt: 1e-4 * keep(self, attempt))


BROKEN = [
    ("energy of motions", _stresses_that_feed), ("energy of motions", _a_force_from_nowhere),
    ("small motions", _loads_that_do_not_scale), ("motions in units", _loads_that_do_not_scale),
    ("motions in a frame", _forces_by_the_axes_of_space), ("restarted motions", _states_without_what_was_before),
    ("asked error", _errors_made_small),
    ("balance", _reactions_too_large), ("clapeyron", _energy_too_large),
    ("superposition", _loads_that_grow_faster), ("frame", _forces_by_the_axes_of_space),
    ("mirror", _forces_by_the_axes_of_space), ("balance", _forces_by_the_axes_of_space),
    ("numbering", _loads_by_the_order_of_nodes), ("symmetry", _loads_by_the_order_of_nodes),
    ("honest", _newton_that_ends_early), ("free bodies", _one_rigid_motion_missed),
]  # fmt: skip


@pytest.mark.parametrize("name, broken", BROKEN, ids=lambda given: getattr(given, "__name__", given))
def test_a_broken_library_is_caught(name, broken, monkeypatch):
    broken(monkeypatch)
    with pytest.raises(Failure):
        run(name, PROPERTIES[name], shrink=False)
