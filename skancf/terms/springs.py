"""Springs and dashpots of supports as terms: constant matrices on local vectors of elements."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from skancf.history import Case
from skancf.linear import BlockMatrix
from skancf.terms.shell import Shell
from skancf.terms.term import Term

Parts = Sequence[tuple[np.ndarray, np.ndarray]]
"""Elements (m,) and symmetric matrices (m, 48, 48) of their local vectors, component by component."""


class Springs(Term):
    r"""The energy :math:`\tfrac12 u \cdot K u` of the displacement u from the undeformed state."""

    matrix: BlockMatrix

    def __init__(self, parts: Parts, shell: Shell) -> None:
        self.parts, self.shell = parts, shell
        self._undeformed = shell.layout.undeformed.ravel()

    def couples(self) -> np.ndarray:
        return self.shell.cells

    def bind(self, blocks: Any) -> None:
        _add(self.parts, self.shell, blocks)
        self.matrix = blocks.matrix()

    def force(self, q: np.ndarray, v: np.ndarray | None, case: Case) -> np.ndarray:
        return self.matrix @ (q - self._undeformed)

    def add_tangent(self, q: np.ndarray, v: np.ndarray | None, case: Case, blocks: Any) -> None:
        if not blocks.skew:
            blocks.values += self.matrix.values

    def energy(self, q: np.ndarray, case: Case) -> float:
        return self.matrix.energy(q - self._undeformed)


class Dashpots(Term):
    """Forces in proportion to velocities, from outside."""

    def __init__(self, parts: Parts, shell: Shell) -> None:
        self.parts, self.shell = parts, shell

    def couples(self) -> np.ndarray:
        return self.shell.cells

    def force(self, q: np.ndarray, v: np.ndarray | None, case: Case) -> np.ndarray:
        """None besides the constant matrix of :meth:`add_viscous`."""
        return np.zeros_like(q)

    def add_viscous(self, blocks: Any) -> None:
        _add(self.parts, self.shell, blocks)


def _add(parts: Parts, shell: Shell, blocks: Any) -> None:
    for elements, matrices in parts:
        shell.on_elements(blocks).add(elements, matrices)
