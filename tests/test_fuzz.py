"""Problems of every kind and scale, made by chance: the bounded part of ``make fuzz``, always the same examples."""

import numpy as np
import pytest
from fuzz.properties import PROPERTIES
from fuzz.run import Failure, run

from skancf.assembly.system import System
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


BROKEN = [
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
