"""The force of the supports at a place, in one direction."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from skancf.arguments import plain
from skancf.conditions.solver import curved
from skancf.equality import by_value
from skancf.errors import unit_vector
from skancf.showing import short
from skancf.solution import Solution
from skancf.states import StateLike, solution_of
from skancf.system.system import System


@by_value
@dataclass(frozen=True)
class Reaction:
    r"""Force of the supports at a place on the body, along a unit direction of space (N), springs included.

    With the motion c of the nodes there by one along the direction, its part P c along the directions that supports hold,
    the residual R and the stiffness F of the springs it is

    .. math:: c \cdot (P R(q) - F (q - q_0)), \qquad \text{with the gradient} \qquad K^T P c - F c

    and the tangent K of the state, that of follower loads included. Conditions pull at what supports hold, too: R is with
    their forces, and K with their curvature.

    Parameters
    ----------
    where
        Place, as for a support; None for all supports.
    direction : (3,)
        Of any length.

    Raises
    ------
    InputError
        For a direction of length zero; with a state, for a place that its mesh does not have, and for a state that moves:
        see :meth:`Solution.reactions <skancf.Solution.reactions>`.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> system = plate.on(sk.meshes.uniform(plate.surface, 6, 6), "kirchhoff")
    >>> print(f"{sk.Reaction('left').value(sk.solve_linear(system)):.1f} N")
    247.5 N
    """

    where: Any = None
    direction: tuple[float, float, float] = (0.0, 0.0, 1.0)

    unit: ClassVar[str] = "N"

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        unit_vector("direction", self.direction)

    def value(self, state: StateLike) -> float:
        """The force in a state of rest."""
        state = solution_of("state", state)
        return float(state.reactions(self.where) @ unit_vector("direction", self.direction))

    def gradient(self, state: StateLike) -> np.ndarray:
        r""":math:`\partial J / \partial q`, (n_dofs,)."""
        state = solution_of("state", state)
        system, motion = state.system, self._motion(state.system)
        held = system.constraints.fixed_part(motion)
        model, x = state.model, state.unknowns
        tangent = model.tangent(x, state.case)
        if not model.linear:
            tangent = curved(system, tangent, x, state.multipliers)
        out, skew = tangent @ held, model.skew(x, state.case)
        if skew is not None:
            out = out - skew @ held
        others = system.others.tangent(state.about, state.case)
        return np.asarray(out if others is None else out - others @ motion)

    def lift(self, state: Solution) -> np.ndarray:
        """The motion P c of the support, (n_dofs,): with it the dual weight z - P c is smooth, the answer to a support that
        gives way."""
        return state.system.constraints.fixed_part(self._motion(state.system))

    def _motion(self, system: System) -> np.ndarray:
        """The nodes of the place moved by one, (n_dofs,)."""
        out = np.zeros_like(system.geometry.undeformed)
        nodes = slice(None) if self.where is None else system.geometry.nodes_on(self.where)
        out[nodes, 0] = unit_vector("direction", self.direction)
        return system.shell.flat(out)
