"""A pretension that nothing but motion feels."""

from typing import Any

from skancf.history import Case
from skancf.linear import BlockMatrix
from skancf.terms.shell import is_heated


def pretension(system: Any) -> BlockMatrix:
    r"""Geometric stiffness G of a uniform dilation by one, a pretension that nothing but motion feels.

    Positive semidefinite, zero for translations; of a flat isotropic plate
    :math:`x \cdot G x = E h / (1 - \nu) \int |\nabla x|^2`. With a strain as its factor it counts against any membrane
    stiffness, whatever the unit, density and law.
    """
    start = system.undeformed
    cold = Case(0.0)
    case = [cold] if is_heated(system) else []
    dilated = system.stresses(start, start, *case) - system.stresses(start, None, *case)
    return BlockMatrix(system.pattern, system.tangent(start, cold, dilated).values - system.stiffness().values)
