"""First order about the undeformed state, without loss of digits.

The stiffness is applied to a change by the forces of the stresses of its strains.

An assembled entry is a sum over elements and points, and its rounding is a force without a counterpart: a plate of size L
with elements of size h is moved by it by the part :math:`(L / h)^2` of a unit in the last place. The rounding of stresses is
in equilibrium in each element, and moves it by that unit itself.
"""

from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np

from skancf.linear import BlockMatrix
from skancf.terms.shell import Shell

LARGE = 100
"""Changes are scaled to this power of two: the strains are linear in them, and against so large ones the rounding of those
of the undeformed state is nothing."""
SMALL = -200
"""Imaginary changes are scaled to this power of two."""


class ByStrains:
    """A :class:`skancf.linear.matrix.Form`.

    Parameters
    ----------
    shell : Shell
    undeformed : (n_dofs,) array
    foundation : BlockMatrix or None
        Of other terms.
    """

    def __init__(self, shell: Shell, undeformed: np.ndarray, foundation: Any) -> None:
        self._shell, self._assembly, self._foundation = shell, shell.assembly, foundation
        self._undeformed = shell.nodal(undeformed)

    def product(self, vector: np.ndarray) -> np.ndarray:
        """Internal force of a small change, (n_dofs,)."""
        large, power = enlarged(self._shell.nodal(vector))
        stresses = self._assembly.stresses(self._undeformed, large, keep_strains=False)[1]
        stresses -= self._stresses
        force = np.ldexp(self._shell.flat(self._assembly.force_of(self._undeformed, stresses)), -power)
        return force if self._foundation is None else force + self._foundation @ vector

    def energy(self, vector: np.ndarray) -> float:
        """Strain energy of a small change, half of the sum of stress times strain."""
        large, power = enlarged(self._shell.nodal(vector))
        strains, stresses = self._assembly.stresses(self._undeformed, large, keep_strains=True)
        energy = 0.5 * float(np.ldexp(np.vdot(strains - self._strains, stresses - self._stresses), -2 * power))
        return energy if self._foundation is None else energy + self._foundation.energy(vector)

    @cached_property
    def _stresses(self) -> np.ndarray:
        """Those of the undeformed state, rounding; without them what does not move would have some."""
        return self._assembly.stresses(self._undeformed, None, keep_strains=False)[1]

    @cached_property
    def _strains(self) -> np.ndarray:
        return self._assembly.stresses(self._undeformed, None, keep_strains=True)[0]


def unstressed(system: Any, plain: bool = False) -> BlockMatrix:
    """Tangent of the undeformed state without stresses of the shell.

    ``plain``: with membrane strains as they are, not assumed ones, an upper bound that locks on coarse meshes.
    """
    blocks = system.blocks()
    system.shell.add_stiffness(blocks, plain)
    return blocks.matrix() if system.foundation is None else blocks.matrix() + system.foundation


def enlarged(vector: np.ndarray) -> tuple[np.ndarray, int]:
    """A vector times a power of two, and the power."""
    size = float(np.abs(vector).max(initial=0.0))
    power = LARGE - int(np.frexp(size)[1]) if np.isfinite(size) else 0
    return np.ldexp(vector, power), power


def of_change(shell: Shell, at: np.ndarray, change: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Strains and stresses of a small change of unknowns (n_dofs,), to first order."""
    large, power = enlarged(shell.nodal(change))
    rest, moved = (shell.assembly.stresses(shell.nodal(at), step, keep_strains=True) for step in (None, large))
    strains, stresses = (np.ldexp(b - a, -power) for a, b in zip(rest, moved, strict=True))
    return strains, stresses


def derivative(quantity: Callable[[np.ndarray], np.ndarray], at: np.ndarray, change: np.ndarray) -> np.ndarray:
    r"""The derivative of an analytic function along a change of its argument,

    .. math:: \operatorname{Im} J(q + i s u) / s

    with a step s so small that its square is nothing: no difference is taken, and no digit lost.

    References
    ----------
    Squire and Trapp (1998), SIAM Review 40, 110-112.
    """
    power = SMALL - int(np.frexp(float(np.abs(change).max(initial=0.0)))[1])
    return np.asarray(np.ldexp(quantity(at + 1j * np.ldexp(change, power)).imag, -power))
