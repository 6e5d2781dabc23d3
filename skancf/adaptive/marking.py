r"""Which elements an indicator marks, for refinement or for coarsening.

Indicators :math:`\eta_K \ge 0` are one number per element. Those that add up, such as the squared error of each element,
suit :class:`Doerfler`; any measure suits the others. Numbers of marked elements are ascending.
"""

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from skancf.arguments import plain
from skancf.errors import InputError, finite, number
from skancf.tolerances import ABOVE_ZERO, SAME_VALUE


class Marking(Protocol):
    """A policy that marks elements.

    Examples
    --------
    >>> class Worst:
    ...     def marked(self, indicators):
    ...         return np.array([np.argmax(indicators)])
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> result = sk.adapt(plate, sk.StrainEnergy(), rtol=1e-2, linear=True, marking=Worst(), max_levels=3)
    >>> print(len(result.levels))
    3
    """

    def marked(self, indicators: Any) -> np.ndarray:
        """Numbers of the marked elements, ascending, of indicators (n,) that are not negative."""


@dataclass(frozen=True)
class Doerfler:
    r"""The fewest elements that hold a share of the total.

    .. math:: \sum_{K \in M} \eta_K \ge \text{share} \sum_K \eta_K

    Values that equal the smallest one taken, to 1e-9, are all taken, so that symmetric problems keep symmetric meshes.

    Parameters
    ----------
    share : float
        Between 0 and 1; 1 takes every element whose indicator is not zero.

    Raises
    ------
    InputError
        For a share outside (0, 1].

    References
    ----------
    W. Doerfler, A convergent adaptive algorithm for Poisson's equation, SIAM J. Numer. Anal. 33 (1996) 1106-1124. His
    share is that of squared errors, so the indicators are the squares.

    Examples
    --------
    >>> print(sk.Doerfler(share=0.5).marked(np.array([4.0, 1.0, 1.0, 3.0])))
    [0 3]
    """

    share: float = 0.5

    def __post_init__(self) -> None:
        plain(self)
        _check_share("share", self.share)

    def marked(self, indicators: Any) -> np.ndarray:
        """Numbers of the marked elements, ascending; none where all indicators are zero."""
        values = check_indicators(indicators)
        largest = np.sort(values)[::-1]
        sums = np.cumsum(largest)
        # The sum's own rounding must not ask for one element more.
        wanted = self.share * sums[-1:] * (1 - SAME_VALUE)
        return _at_least(values, largest[np.searchsorted(sums, wanted)])


@dataclass(frozen=True)
class Maximum:
    r"""Elements whose indicator is at least a factor of the largest one, :math:`\eta_K \ge \text{factor} \max_L \eta_L`.

    Parameters
    ----------
    factor : float
        Between 0 and 1; the larger, the fewer elements.

    Raises
    ------
    InputError
        For a factor outside (0, 1].

    References
    ----------
    I. Babuska and M. Vogelius, Feedback and adaptive finite element solution of one-dimensional boundary value problems,
    Numer. Math. 44 (1984) 75-102.

    Examples
    --------
    >>> print(sk.Maximum(factor=0.5).marked(np.array([4.0, 1.0, 1.0, 3.0])))
    [0 3]
    """

    factor: float = 0.5

    def __post_init__(self) -> None:
        plain(self)
        _check_share("factor", self.factor)

    def marked(self, indicators: Any) -> np.ndarray:
        """Numbers of the marked elements, ascending; none where all indicators are zero."""
        values = check_indicators(indicators)
        return _at_least(values, self.factor * values.max(initial=0.0))


@dataclass(frozen=True)
class FixedFraction:
    r"""The largest indicators of a fraction of the elements, :math:`\lceil \text{fraction} \cdot n \rceil` of n.

    Values that equal the smallest one taken, to 1e-9, are all taken; zeros never.

    Parameters
    ----------
    fraction : float
        Between 0 and 1.

    Raises
    ------
    InputError
        For a fraction outside (0, 1].

    Examples
    --------
    >>> print(sk.FixedFraction(fraction=0.25).marked(np.array([4.0, 1.0, 1.0, 3.0])))
    [0]
    """

    fraction: float = 0.2

    def __post_init__(self) -> None:
        plain(self)
        _check_share("fraction", self.fraction)

    def marked(self, indicators: Any) -> np.ndarray:
        """Numbers of the marked elements, ascending; none where all indicators are zero."""
        values = check_indicators(indicators)
        n = values.size
        # A product such as 0.07 * 100 is 7 and a rounding.
        rank = n - int(np.ceil(self.fraction * n * (1 - SAME_VALUE)))
        return _at_least(values, np.partition(values, rank)[rank] if n else 0.0)


@dataclass(frozen=True)
class AllElements:
    """Every element: uniform refinement.

    Examples
    --------
    >>> print(sk.AllElements().marked(np.array([4.0, 1.0, 1.0, 3.0])))
    [0 1 2 3]
    """

    def marked(self, indicators: Any) -> np.ndarray:
        """Numbers of all elements."""
        return np.arange(check_indicators(indicators).size)


@dataclass(frozen=True)
class Even:
    r"""Every element where the indicators are even, else the fewest that hold a share of the total (:class:`Doerfler`).

    .. math:: \frac{\left( \sum_K \sqrt{\eta_K} \right)^2}{n \sum_K \eta_K} \ge \text{even}

    With indicators that fall as the square of the area, those of theory `full`, the left side is the part of the elements
    that would have as small an error if all indicators were equal. Where it is near 1 there is little to gain by local
    refinement, and of whole meshes that are quartered the values themselves may tell the error, without a dual solve.

    Parameters
    ----------
    even : float
        Between 0 and 1.
    share : float
        Of :class:`Doerfler`.

    Raises
    ------
    InputError
        For parameters outside (0, 1].

    Examples
    --------
    >>> print(sk.Even().marked(np.array([4.0, 1.0, 1.0, 3.0])))
    [0 1 2 3]
    """

    even: float = 0.65
    share: float = 0.9

    def __post_init__(self) -> None:
        plain(self)
        _check_share("even", self.even)
        _check_share("share", self.share)

    @property
    def part(self) -> Doerfler:
        """The marking where indicators are not even, or all elements would be too many."""
        return Doerfler(self.share)

    def marked(self, indicators: Any) -> np.ndarray:
        """Numbers of the marked elements, ascending; none where all indicators are zero."""
        values = check_indicators(indicators)
        relative = values / max(values.max(initial=0.0), ABOVE_ZERO)
        if np.sqrt(relative).sum() ** 2 >= self.even * values.size * relative.sum() > 0:
            return np.arange(values.size)
        return self.part.marked(values)


@dataclass(frozen=True)
class Below:
    r"""For coarsening: elements whose indicator is less than a factor of the mean.

    .. math:: \eta_K < \text{factor} \cdot \tfrac1n \sum_L \eta_L

    Values that equal the bound, to 1e-9, are not taken.

    Parameters
    ----------
    factor : float
        Between 0 and 1; the smaller, the fewer elements.

    Raises
    ------
    InputError
        For a factor outside (0, 1].

    Examples
    --------
    >>> print(sk.Below(factor=0.5).marked(np.array([4.0, 1.0, 1.0, 3.0])))
    [1 2]
    """

    factor: float = 0.01

    def __post_init__(self) -> None:
        plain(self)
        _check_share("factor", self.factor)

    def marked(self, indicators: Any) -> np.ndarray:
        """Numbers of the marked elements, ascending; none where all indicators are zero."""
        values = check_indicators(indicators)
        bound = self.factor * values.mean() if values.size else 0.0
        return np.flatnonzero(values < bound * (1 - SAME_VALUE))


@dataclass(frozen=True)
class Never:
    """No element: no coarsening.

    Examples
    --------
    >>> print(sk.Never().marked(np.array([4.0, 1.0, 1.0, 3.0])))
    []
    """

    def marked(self, indicators: Any) -> np.ndarray:
        """Nothing."""
        check_indicators(indicators)
        return np.empty(0, dtype=int)


def check_indicators(indicators: Any) -> np.ndarray:
    """Indicators as a float array (n,); :class:`InputError` where one is negative or not finite."""
    values = finite("indicators", indicators)
    if values.ndim != 1:
        raise InputError(f"indicators has shape {values.shape}: give one number for each element, an array (n,)")
    if values.min(initial=0.0) < 0:
        worst = int(np.argmin(values))
        raise InputError(f"indicators[{worst}] = {values[worst]}: an indicator must not be negative; take absolute values")
    return values


def _at_least(values: np.ndarray, bound: Any) -> np.ndarray:
    """Numbers of the values that are at least a bound, to rounding, and not zero."""
    return np.flatnonzero((values >= bound * (1 - SAME_VALUE)) & (values > 0))


def _check_share(name: str, value: float) -> None:
    if not 0 < number(name, value) <= 1:
        raise InputError(f"{name} = {value}: give a number greater than 0 and at most 1")
