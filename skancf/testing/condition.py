"""Checks of conditions of one's own, on demand."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from skancf.arguments import having, whole
from skancf.conditions.check import ConditionCheck, WrongCondition
from skancf.conditions.own import NAMES, check_condition_of
from skancf.errors import InputError, finite, positive
from skancf.linear import BlockPattern
from skancf.problem import Problem
from skancf.terms.blocks import Blocks
from skancf.testing.shared import CASE, Report, blamed, mesh_of, pair, pattern_of, states_about


def check_condition(
    condition: Any, system: Any, *, states: Sequence[np.ndarray] | None = None, amount: float = 0.01,
    tolerance: float = 1e-6, mesh: Any = None, theory: Any = "full", seed: int = 0,
) -> Report:  # fmt: skip
    """Check that a condition's value, gradient, curvature and discrete gradient belong together.

    Parameters
    ----------
    condition : Joint or Condition
        As a problem is given it, for example a :class:`~skancf.RigidLink`; or one that is on a system already.
    system : System or Problem
        Where it holds. A problem is put on a mesh, by default one of 3 x 4 elements.
    states, amount, tolerance, mesh, theory, seed
        As of :func:`check_term`.

    Returns
    -------
    Report

    Raises
    ------
    InputError
        Where the gradient is not the derivative of the value, the curvature not that of the gradient, the discrete gradient
        does not give the change of the value exactly, or shapes and blocks are not those of the layout. The error is an
        AssertionError, too. A problem whose condition has a wrong gradient in the undeformed state is refused anyway.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(sk.Rectangle(1.0, 1.0), 0.01, steel)
    >>> report = sk.testing.check_condition(sk.RigidLink((0.0, 0.0), (1.0, 1.0)), plate)
    >>> print(max(report.errors.values()) < 1e-6)
    True
    """
    tolerance, rng = positive("tolerance", tolerance), np.random.default_rng(whole("seed", seed, least=0))
    if isinstance(system, Problem):
        system = replace(system, conditions=()).on(mesh_of(system, mesh), theory)
    having("system", system, ("layout", "shell", "terms"), "a system or a problem")
    bound = condition if hasattr(condition, "gradient") else condition.on(system.shell, system.layout)
    having("condition", bound, NAMES, "a Condition, or a Joint whose on() returns one")
    name, report = f"condition {bound.name!r}", Report()
    with blamed(WrongCondition):
        check_condition_of(name, bound, system.layout)
    coupled = _Coupled(system.layout, pattern_of(system, bound))
    check = ConditionCheck(name, bound, coupled, tolerance, rng, report.add)
    found = states if states is not None else list(states_about(system.layout, positive("amount", amount), rng))
    for q in (finite("state", each) for each in found):
        if q.shape != (system.n_dofs,):
            raise InputError(f"a state of shape {q.shape}: this system has {system.n_dofs} unknowns")
        check.at(q, CASE)
    check.between(*pair(system.layout, found, rng), CASE)
    check.carried()
    return report


@dataclass(frozen=True)
class _Coupled:
    """A layout with blocks of all that a condition couples."""

    layout: Any
    pattern: BlockPattern

    def blocks(self) -> Blocks:
        return Blocks(self.pattern)
