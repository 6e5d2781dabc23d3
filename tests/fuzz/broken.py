"""The library broken on purpose, and the properties that must notice: each oracle can fail."""

from collections.abc import Callable
from typing import Any

import numpy as np

import skancf as sk
from skancf.adaptive.estimate import Estimate
from skancf.dynamics.energy_momentum import EnergyMomentum
from skancf.dynamics.state import State
from skancf.dynamics.steps import LocalError
from skancf.linear import BlockMatrix, DirectSolver
from skancf.solution import Solution
from skancf.statics import cascade, equilibrium, linear
from skancf.system import system
from skancf.system.linearised import Linearised
from skancf.system.system import System
from skancf.terms.blocks import Blocks
from skancf.terms.shell import Shell
from skancf.thinness.form import ShearForm

Patch = Any
"""pytest's monkeypatch."""


def _reactions_too_large(patch: Patch) -> None:
    keep = Solution.reactions
    patch.setattr(Solution, "reactions", lambda self: 1.001 * keep(self))


def _energy_too_large(patch: Patch) -> None:
    keep = Linearised.strain_energy
    patch.setattr(Linearised, "strain_energy", lambda self, *rest: 1.0001 * keep(self, *rest))


def _loads_that_grow_faster(patch: Patch) -> None:
    keep = linear.small_answer

    def larger(*rest: Any) -> Any:
        change, multipliers = keep(*rest)
        return change * (1 + abs(change).max()), multipliers

    patch.setattr(linear, "small_answer", larger)
    patch.setattr(linear, "unmet", lambda measured: [])  # which would have refused such an answer


def _forces_by_the_axes_of_space(patch: Patch) -> None:
    keep = System.applied_force
    turn = np.tile([1.0, 1.01, 1.0], 4)
    patch.setattr(System, "applied_force", lambda self, *rest: keep(self, *rest) * np.resize(turn, self.n_dofs))


def _loads_by_the_order_of_nodes(patch: Patch) -> None:
    keep = System.applied_force
    patch.setattr(System, "applied_force", lambda self, *rest: keep(self, *rest) * np.linspace(1.0, 1.01, self.n_dofs))


def _answers_by_the_order_of_nodes(patch: Patch) -> None:
    """No symmetric matrix gives them."""
    keep = DirectSolver.solve
    patch.setattr(
        DirectSolver, "solve", lambda self, f, *rest, **more: keep(self, f * np.linspace(1, 1.01, f.size), *rest, **more)
    )
    patch.setattr(linear, "unmet", lambda measured: [])


def _newton_that_ends_early(patch: Patch) -> None:
    keep = cascade.newton
    patch.setattr(cascade, "newton", lambda *rest, **options: keep(*rest, **{**options, "rtol": 1e-1}))
    patch.setattr(cascade.Cascade, "_verified", lambda self, result: result)


def _stiffer(patch: Patch, by: Callable[[System, np.ndarray], np.ndarray]) -> None:
    """Adds to the diagonal blocks (n_nodes, 12, 12) of the stiffness what a function of them says."""
    keep = system.unstressed

    def unstressed(self: System, plain: bool = False) -> BlockMatrix:
        values, slots = keep(self, plain).values.copy(), self.pattern.diagonal_slots
        values[slots] += by(self, values[slots])
        return BlockMatrix(self.pattern, values)

    patch.setattr(system, "unstressed", unstressed)


def _slopes_held_by_space(patch: Patch) -> None:
    """No rigid rotation is free, and all translations are."""
    slopes = np.diag(np.repeat([0.0, 1e-3, 0.0, 0.0], 3))
    _stiffer(patch, lambda system, blocks: slopes * np.abs(blocks))


def _a_spring_without_unit(patch: Patch) -> None:
    point = np.diag(np.repeat([10.0, 0.0, 0.0, 0.0], 3))
    _stiffer(patch, lambda system, blocks: point)


def _stiffer_with_more_elements(patch: Patch) -> None:
    keep = System.stiffness
    patch.setattr(System, "stiffness", lambda self: (1 + 1e-2 * self.geometry.n_elements) * keep(self))


def _a_restart_that_stops_short(patch: Patch) -> None:
    keep = equilibrium.equilibrium
    patch.setattr(
        equilibrium, "equilibrium",
        lambda system, factor, **more: keep(system, factor * (1.0 if more["start"] is None else 0.999), **more),
    )  # fmt: skip


def _a_linear_answer_too_large(patch: Patch) -> None:
    keep = linear.small_answer

    def larger(*rest: Any) -> Any:
        change, multipliers = keep(*rest)
        return 1.01 * change, multipliers

    patch.setattr(linear, "small_answer", larger)
    patch.setattr(linear, "unmet", lambda measured: [])


def _a_mass_by_the_order_of_nodes(patch: Patch) -> None:
    keep = Shell.add_mass

    def add_mass(self: Shell, blocks: Blocks) -> None:
        keep(self, blocks)
        slots = blocks.pattern.diagonal_slots
        blocks.values[slots] *= np.linspace(1.0, 1.1, len(slots))[:, None, None]

    patch.setattr(Shell, "add_mass", add_mass)


def _loads_that_take_anything(patch: Patch) -> None:
    for load in (sk.SurfaceLoad, sk.PointForce, sk.LineLoad):
        patch.setattr(load, "__post_init__", lambda self: None)


def _loads_that_do_not_scale(patch: Patch) -> None:
    keep = System.applied_force

    def applied(self: System, *rest: Any) -> np.ndarray:
        force = keep(self, *rest)
        return force * (1 + 0.02 * np.sin(np.log(np.abs(force).max() + 1e-300)))

    patch.setattr(System, "applied_force", applied)


def _stresses_that_feed(patch: Patch) -> None:
    keep = EnergyMomentum.stresses
    patch.setattr(EnergyMomentum, "stresses", lambda self, *rest: 1.02 * keep(self, *rest))


def _a_force_from_nowhere(patch: Patch) -> None:
    keep = Shell.force_between

    def between(self: Shell, *rest: Any) -> np.ndarray:
        force = keep(self, *rest)
        return force + 1e-3 * np.abs(force).max() * np.tile([1.0, 0.0, 0.0] + 9 * [0.0], len(force) // 12)

    patch.setattr(Shell, "force_between", between)


def _states_without_what_was_before(patch: Patch) -> None:
    keep = State.state
    patch.setattr(State, "state", lambda self: keep(self) | {"jerk": None, "before": None})


def _errors_made_small(patch: Patch) -> None:
    keep = LocalError.over
    patch.setattr(LocalError, "over", lambda self, attempt: 1e-4 * keep(self, attempt))


def _bars_too_small(patch: Patch) -> None:
    keep = Estimate.bar.fget
    assert keep
    patch.setattr(Estimate, "bar", property(lambda self: 0.6 * keep(self)))


def _half_of_shear(patch: Patch) -> None:
    keep = ShearForm.product
    patch.setattr(ShearForm, "product", lambda self, *rest: 0.5 * keep(self, *rest))


BROKEN = [
    ("balance", _reactions_too_large), ("balance", _forces_by_the_axes_of_space), ("moments", _slopes_held_by_space),
    ("clapeyron", _energy_too_large), ("reciprocity", _answers_by_the_order_of_nodes),
    ("superposition", _loads_that_grow_faster), ("nested", _stiffer_with_more_elements), ("units", _a_spring_without_unit),
    ("frame", _forces_by_the_axes_of_space), ("mirror", _forces_by_the_axes_of_space),
    ("numbering", _loads_by_the_order_of_nodes), ("symmetry", _loads_by_the_order_of_nodes),
    ("honest", _newton_that_ends_early), ("restart", _a_restart_that_stops_short),
    ("small loads", _a_linear_answer_too_large), ("vibration", _a_mass_by_the_order_of_nodes),
    ("free bodies", _slopes_held_by_space), ("refusals", _loads_that_take_anything),
    ("energy of motions", _stresses_that_feed), ("energy of motions", _a_force_from_nowhere),
    ("small motions", _loads_that_do_not_scale), ("motions in units", _loads_that_do_not_scale),
    ("motions in a frame", _forces_by_the_axes_of_space), ("restarted motions", _states_without_what_was_before),
    ("asked error", _errors_made_small), ("bars", _bars_too_small), ("theory", _half_of_shear),
]  # fmt: skip
"""Properties and what breaks the library so that they fail."""
