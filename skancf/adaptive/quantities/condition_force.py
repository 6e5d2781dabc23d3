"""The force of a condition: in a link, or of a whole hinge along a direction."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from skancf.arguments import plain, text
from skancf.equality import by_value
from skancf.errors import InputError, unit_vector
from skancf.showing import short
from skancf.solution import Solution
from skancf.states import StateLike, solution_of


@by_value
@dataclass(frozen=True)
class ConditionForce:
    r"""The force of a condition (N), by its multipliers: :math:`w \cdot \lambda`.

    Its dual weight is the answer to a condition that gives way, :math:`K z + G^T \mu = 0` with :math:`G z = w`: to a rod
    that is longer by one, or a hinge whose sides are apart by one along the direction.

    Parameters
    ----------
    name : str
        Of the condition, as in :attr:`Solution.conditions <skancf.Solution.conditions>`.
    direction : (3,), optional
        Of any length: of a :class:`~skancf.Hinge` the part of the whole force along it, which the second edge exerts on the
        first. Not of a :class:`~skancf.RigidLink`, whose force is along it, and positive if it pulls.

    Raises
    ------
    InputError
        For a direction of length zero; with a state, for a name that no condition has, a direction that it cannot have, and
        a state without multipliers.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> strip = sk.Problem(
    ...     sk.Rectangle(1.0, 0.1), 0.002, steel,
    ...     supports=[sk.Pin([(0.0, 0.0), (0.0, 0.1)]), sk.Roller([(1.0, 0.0), (1.0, 0.1)])],
    ...     loads=[sk.EdgeLoad("right", (1000.0, 0.0, 0.0))],
    ...     conditions=[sk.RigidLink((0.0, 0.05), (1.0, 0.05), name="strut")],
    ... )
    >>> solution = sk.solve_linear(strip.on(sk.meshes.uniform(strip.surface, 4, 2), "kirchhoff"))
    >>> print(f"{sk.ConditionForce('strut').value(solution):.1f} N")
    76.8 N
    """

    name: str
    direction: tuple[float, float, float] | None = None

    unit: ClassVar[str] = "N"

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        text("name", self.name)
        if self.direction is not None:
            unit_vector("direction", self.direction)

    def value(self, state: StateLike) -> float:
        """The force."""
        state = solution_of("state", state)
        weights = self.by_multipliers(state)
        if state.multipliers is None:
            raise InputError(f"ConditionForce({self.name!r}): this state has no multipliers; give what solve, solve_linear "
                             "or trace found")  # fmt: skip
        return float(weights @ state.multipliers)

    def gradient(self, state: StateLike) -> np.ndarray:
        r""":math:`\partial J / \partial q`, (n_dofs,): zero, for it depends on multipliers alone."""
        state = solution_of("state", state)
        return np.zeros(state.system.n_dofs)

    def by_multipliers(self, state: Solution) -> np.ndarray:
        r""":math:`w = \partial J / \partial \lambda`, (n,)."""
        conditions: Any = state.system.conditions
        if self.name not in conditions.names:
            known = ", ".join(map(repr, conditions.names)) or "none"
            raise InputError(f"ConditionForce({self.name!r}): there is no such condition; there are: {known}")
        direction = None if self.direction is None else unit_vector("direction", self.direction)
        return np.asarray(conditions.resultant(self.name, direction))
