r"""A summand of the equations of motion,

.. math:: M \ddot q + \sum_k f_k(q, \dot q, t) = 0.

A :class:`Term` says which blocks it couples, its force, and the tangent of that; what else it has, it overrides. Whatever
the solvers, the ledger and the checks know of a system is a sum over terms.
"""

from typing import Any

import numpy as np

from skancf.history import Case
from skancf.layout.layout import Layout
from skancf.layout.singularities import Singularity, places_of
from skancf.terms.blocks import Blocks


class Term:
    """A term of a system; a kind of term overrides what it has.

    Attributes
    ----------
    load : bool
        Whether it acts from outside: it counts with the load factor, by ``case.amplitude(history)``, and its work is that
        of loads. Other terms belong to the structure.
    timed : bool
        Whether its energy depends on the time, too: what time does to it is booked as work.

    Examples
    --------
    >>> class Push(sk.terms.Term):
    ...     load = True
    ...     def __init__(self, nodal):
    ...         self.nodal = nodal
    ...     def force(self, q, v, case):
    ...         return -case.amplitude(None) * self.nodal
    ...     def energy(self, q, case):
    ...         return -case.amplitude(None) * float(self.nodal @ q)
    >>> Push(np.ones(12)).energy(np.ones(12), sk.Case(0.5))
    -6.0
    """

    load: bool = False
    timed: bool = False

    def bind(self, blocks: Blocks) -> None:
        """Called once, when all terms are known, with sums of its own to keep constant matrices from. Default: nothing."""

    def couples(self) -> np.ndarray:
        """Cells (m, n) of blocks: those of a row are coupled in the matrix. Default: none, as of a dead load."""
        return np.empty((0, 1), dtype=int)

    def force(self, q: np.ndarray, v: np.ndarray | None, case: Case) -> np.ndarray:
        """Its force on the left side of the equations, (n_dofs,): the derivative of its energy, if it has one.

        Parameters
        ----------
        q : (n_dofs,) array
        v : (n_dofs,) array or None
            Rates of q; None at rest.
        case : Case
        """
        raise NotImplementedError

    def add_tangent(self, q: np.ndarray, v: np.ndarray | None, case: Case, blocks: Blocks) -> None:
        """Add the derivative of :meth:`force` with respect to q, by ``blocks.add(cells, matrices)``. Default: zero."""

    def add_damping(self, q: np.ndarray, v: np.ndarray | None, case: Case, blocks: Blocks) -> None:
        """Add the derivative of :meth:`force` with respect to v. Default: zero."""

    def energy(self, q: np.ndarray, case: Case) -> float | None:
        """Its energy (J), of which the force is the derivative; None where it has none, and the ledger books its work."""
        return None

    def between(self, q0: np.ndarray, q1: np.ndarray, case: Case) -> np.ndarray | None:
        """A force (n_dofs,) between two states that does the work of the energy exactly, f . (q1 - q0) = E(q1) - E(q0);
        None where the force in the middle is taken."""
        return None

    def add_mass(self, blocks: Blocks) -> None:
        """Add its constant mass matrix. Default: it has none."""

    def add_viscous(self, blocks: Blocks) -> None:
        """Add the constant matrix of forces in proportion to v. Default: it has none."""

    def histories(self) -> list[Any]:
        """Its functions of time, among them None for one that is constant."""
        return [getattr(self, "history", None)]

    def singularities(self, case: Case) -> list[Singularity]:
        """What it does that is not smooth: see :class:`~skancf.layout.singularities.Singularity`. Default: nothing."""
        return []

    def places(self, case: Case) -> np.ndarray:
        """Points (2, n) of the parameter plane at which it acts, if it is at some only; else (2, 0). Default: the single
        points of its singularities."""
        return places_of(self.singularities(case))

    def impulse(self) -> tuple[float, np.ndarray] | None:
        """A time (s) and the impulse (n_dofs,) that acts then; None of what acts all the time."""
        return None

    def reached(self, q: np.ndarray, v: np.ndarray, case: Case) -> None:
        """Called at the end of every accepted step of a motion: what a term remembers changes here alone, since steps are
        tried, and forces asked for, more often. Default: nothing."""

    def state(self) -> dict[str, Any]:
        """What it remembers between steps, see :class:`~skancf.dynamics.HasState`. Default: nothing.

        It is not forgotten when a run ends: give another run a system of its own.
        """
        return {}

    def restore(self, state: dict[str, Any]) -> None:
        """Go back to what :meth:`state` gave."""


class Addition:
    """What a user adds to a problem: terms, and blocks that they need; knows no mesh.

    A kind of addition overrides :meth:`on`, and :meth:`part` where its terms have unknowns of their own.

    Examples
    --------
    >>> class Push(sk.terms.Term):
    ...     load = True
    ...     def __init__(self, nodal):
    ...         self.nodal = nodal
    ...     def force(self, q, v, case):
    ...         return -case.amplitude(None) * self.nodal
    ...     def energy(self, q, case):
    ...         return -case.amplitude(None) * float(self.nodal @ q)
    >>> class PushLast(sk.terms.Addition):
    ...     def on(self, shell, layout):
    ...         nodal = np.zeros(layout.n_dofs)
    ...         nodal[12 * (layout.n_blocks - 1) + 2] = 10.0  # z of the last node
    ...         return Push(nodal)
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> strip = sk.Problem(sk.Rectangle(1.0, 0.1), 0.01, steel, supports=[sk.Clamp("left")], terms=[PushLast()])
    >>> solution = sk.solve_linear(strip.on(sk.meshes.uniform(strip.surface, 4, 1), "kirchhoff"))
    >>> print(f"{solution.reactions()[2]:.4f} N")
    -10.0000 N
    """

    def part(self, geometry: Any) -> Any:
        """The :class:`~skancf.layout.layout.Part` of its own unknowns on a mesh; None without any."""
        return None

    def on(self, shell: Any, layout: Layout) -> Term:
        """The term on a layout, of which the part ``"plate"`` is the shell, see :class:`skancf.terms.shell.Shell`."""
        raise NotImplementedError
