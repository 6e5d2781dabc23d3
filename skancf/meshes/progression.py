"""Element lengths in geometric progression, from a coarse mesh to a fine one or back."""

from math import log, log1p

import numpy as np

from skancf.errors import InputError, positive
from skancf.memory import require_much
from skancf.tolerances import ROOT_OF_GROWTH, ROOT_OF_GROWTH_RTOL


def progression(l_0: float, l_n: float, length: float) -> np.ndarray:
    r"""Lengths :math:`l_0 q^k, k = 0 \ldots n`, that lead from ``l_0`` to about ``l_n`` and add up to ``length``.

    .. math:: l_n = l_0 q^n, \qquad L = \frac{l_0 - l_n q}{1 - q}
              \quad\Rightarrow\quad q = \frac{L - l_0}{L - l_n}, \qquad n = \frac{\ln (l_n / l_0)}{\ln q}

    n is rounded to a whole number, and q is then corrected so that :math:`\sum_{k=0}^n l_0 q^k = L` with the same l_0
    and n; so the last length is not quite ``l_n``. For n > 1, growing lengths (l_0 < l_n) miss it by a factor of at
    most exp(1/n), shrinking ones by exp(2.5/n), as their small end tells little about the sum: number from the fine
    end where that matters. Equal lengths (``l_0 == l_n``) have q = 1, and n + 1 = round(L / l_0) of them are scaled.

    Parameters
    ----------
    l_0, l_n : float
        First and last length; either may be the larger. On circular meshes these are central angles.
    length : float
        Length L of the transition, its first and last element included (same unit).

    Returns
    -------
    (n + 1,) array
        The lengths, n >= 1; their sum is ``length`` to rounding.

    Raises
    ------
    InputError
        For values that are not positive, and for a transition too short for two elements.

    References
    ----------
    Research on local mesh refine method based on absolute nodal coordinate formulation, eq. (7), and (8) for angles.

    Examples
    --------
    >>> print(sk.meshes.progression(0.1, 0.4, 1.0))
    [0.1        0.16608024 0.27582647 0.45809328]
    """
    l_0, l_n, length = positive("l_0", l_0), positive("l_n", l_n), positive("length", length)
    n = _steps(l_0, l_n, length)
    require_much(8 * 4 * n, f"length = {length}", f"a transition of {n} elements", "take longer elements")
    if l_0 == l_n:
        return np.full(n + 1, length / (n + 1))
    from scipy.optimize import brentq  # not at the top: graded meshes alone need it, and it is slow to load

    k = np.arange(n + 1)
    # At log q = -+50 the sum is beyond L on either side: l_0 alone below, more than e^50 l_0 above.
    bound = max(50.0, 2 * abs(np.log(length / l_0)))

    def missing(log_q: float) -> float:
        return np.exp(np.minimum(log_q * k, 600)).sum() - length / l_0

    return l_0 * np.exp(brentq(missing, -bound, bound, xtol=ROOT_OF_GROWTH, rtol=ROOT_OF_GROWTH_RTOL) * k)


def _steps(l_0: float, l_n: float, length: float) -> int:
    """n of the formula, rounded."""
    n = round(_real_steps(l_0, l_n, length)) if length > max(l_0, l_n) else 0
    if n < 1:
        raise InputError(
            f"length = {length}: a transition from l_0 = {l_0} to l_n = {l_n} needs room for at least "
            f"these two, about {l_0 + l_n:.6g}; make the transition longer or the lengths smaller"
        )
    return n


def _real_steps(l_0: float, l_n: float, length: float) -> float:
    """n before rounding; ln(l_n / l_0) and ln q by log1p, because both may be close to 0."""
    if l_0 == l_n:
        return length / l_0 - 1
    part = (l_n - l_0) / l_0
    return (log1p(part) if part > -0.5 else log(l_n / l_0)) / log1p((l_n - l_0) / (length - l_n))
