r"""Conditions on the unknowns,

.. math:: g(q) = 0, \qquad M \ddot q + \sum_k f_k(q, \dot q, t) + G(q)^T \lambda = 0, \qquad G = \partial g / \partial q .

The multipliers :math:`\lambda` are the forces that keep them. They are not unknowns of the matrix: solvers carry them
outside of it, see :mod:`skancf.linear.conditioned`. A :class:`Condition` gives g, its gradient and its curvature; whatever
solvers and checks know of conditions is a sum over them.
"""

from typing import Any

import numpy as np
import scipy.sparse as sp

from skancf.errors import InputError
from skancf.history import Case
from skancf.layout.layout import Layout
from skancf.layout.singularities import Singularity
from skancf.terms.blocks import Blocks


class Condition:
    """Rows of g on a layout; a kind of condition overrides what it has.

    Attributes
    ----------
    name : str
        By which messages and results know it; numbers are added where two are equal.
    n : int
        Rows.
    scales : (n,) array
        The size in which each row counts, greater than zero: a row that is a small part of it is met. Of a row that is a
        difference of positions that is the extent of the body.

    Examples
    --------
    >>> from scipy.sparse import csr_matrix
    >>> class Level(sk.conditions.Condition):
    ...     name, n, scales = "level", 1, np.ones(1)
    ...     def __init__(self, layout):
    ...         row = np.zeros(layout.n_dofs)
    ...         row[[2, 14]] = 1.0, -1.0  # z of the first two nodes
    ...         self.row = csr_matrix(row)
    ...     def couples(self):
    ...         return np.array([[0, 1]])
    ...     def value(self, q, case):
    ...         return self.row @ q
    ...     def gradient(self, q):
    ...         return self.row
    """

    name: str
    n: int
    scales: np.ndarray

    def couples(self) -> np.ndarray:
        """Cells (m, k) of blocks: those that a row depends on are in one cell."""
        raise NotImplementedError

    def value(self, q: np.ndarray, case: Case) -> np.ndarray:
        """g, (n,). In the undeformed state it vanishes at the load factor zero; one that depends on the case moves what it
        holds, as a prescribed displacement does."""
        raise NotImplementedError

    def gradient(self, q: np.ndarray) -> sp.csr_matrix:
        """G, its derivative, (n, n_dofs)."""
        raise NotImplementedError

    def add_curvature(self, q: np.ndarray, multipliers: np.ndarray, blocks: Blocks) -> None:
        r"""Add :math:`\sum_k \lambda_k \, \partial^2 g_k / \partial q^2` by ``blocks.add(cells, matrices)``. Default: zero,
        of a linear condition."""

    def between(self, q0: np.ndarray, q1: np.ndarray) -> sp.csr_matrix:
        r"""An exact discrete gradient, :math:`g(q_1) - g(q_0) = \bar G (q_1 - q_0)`. Default: the gradient in the middle,
        which is exact for linear and quadratic conditions; others override it."""
        return self.gradient(0.5 * (q0 + q1))

    def rows(self) -> list[str]:
        """What each row is, for messages. Default: their numbers."""
        return [f"row {k}" for k in range(self.n)]

    def histories(self) -> list[Any]:
        """Its functions of time. Default: none."""
        return []

    def singularities(self, case: Case) -> list[Singularity]:
        """What its forces do that is not smooth: see :class:`~skancf.layout.singularities.Singularity`. Default: nothing."""
        return []

    def carried(self, multipliers: np.ndarray, onto: "Condition") -> np.ndarray:
        """Its multipliers (n,) for the same condition on another mesh, (onto.n,). Default: as they are, where both have the
        same rows; a condition whose rows depend on the mesh overrides it, or raises InputError."""
        if onto.n != self.n:
            raise InputError(f"condition {self.name!r}: it has {self.n} rows on one mesh and {onto.n} on another; say in "
                             "carried(multipliers, onto) which multipliers are the same forces there")  # fmt: skip
        return multipliers

    def resultant(self, direction: np.ndarray | None) -> np.ndarray:
        """Weights (n,) by which its multipliers make one force (N): along a direction of space (3,), or, of a condition that
        has a direction of its own, without one.

        Default: the multiplier itself, where there is one.

        Raises
        ------
        InputError
            For a direction where it has its own, and for none where it needs one.
        """
        if direction is not None or self.n != 1:
            raise InputError(f"condition {self.name!r}: it has {self.n} multipliers, and its class does not say by which "
                             "weights they make a force; let it have a method resultant(direction)")  # fmt: skip
        return np.ones(1)

    def forces(self, multipliers: np.ndarray) -> Any:
        """Its multipliers (n,) as a user reads them. Default: as they are."""
        return multipliers


class Joint:
    """What a user gives a problem in ``conditions``: what holds together; knows no mesh.

    A kind of joint overrides :meth:`on`.

    Examples
    --------
    >>> from scipy.sparse import csr_matrix
    >>> class Level(sk.conditions.Condition):
    ...     name, n, scales = "level", 1, np.ones(1)
    ...     def __init__(self, layout):
    ...         row = np.zeros(layout.n_dofs)
    ...         row[[2, 14]] = 1.0, -1.0  # z of the first two nodes
    ...         self.row = csr_matrix(row)
    ...     def couples(self):
    ...         return np.array([[0, 1]])
    ...     def value(self, q, case):
    ...         return self.row @ q
    ...     def gradient(self, q):
    ...         return self.row
    >>> class LevelFirst(sk.conditions.Joint):
    ...     def on(self, shell, layout):
    ...         return Level(layout)
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(sk.Rectangle(1.0, 1.0), 0.01, steel, conditions=[LevelFirst()])
    >>> plate.on(sk.meshes.uniform(plate.surface, 2, 2)).conditions.n
    1
    """

    @property
    def wheres(self) -> dict[str, Any]:
        """Places of the boundary, by the names of the arguments that mean them. Default: none."""
        return {}

    @property
    def points(self) -> tuple[Any, ...]:
        """Single points (2,) of the parameter plane that it pulls at: a mesh that refines itself begins with nodes there.
        Default: none."""
        return ()

    def gap(self, geometry: Any) -> sp.csr_matrix | None:
        """Weights (m, 4 n_nodes) of nodal vectors that make a gap which is to vanish undeformed, for
        :func:`~skancf.conditions.closing.close_gaps`. Default: none."""
        return None

    def on(self, shell: Any, layout: Layout) -> Condition:
        """The condition on a layout, of which the part ``"plate"`` is the shell, see :class:`skancf.terms.shell.Shell`."""
        raise NotImplementedError
