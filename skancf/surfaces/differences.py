"""Derivatives by differences of high order that never leave an interval."""

from collections.abc import Callable
from functools import cache
from math import factorial

import numpy as np

from skancf.surfaces.protocol import Interval
from skancf.tolerances import SAME_VALUE

POINTS = 9


def _weights(order: int, first: int) -> list[float]:
    """Weights of f(first) ... f(first + POINTS - 1) in the derivative at 0: of the polynomial through these points."""
    nodes = np.arange(first, first + POINTS, dtype=float)
    weights = []
    for k in range(POINTS):
        others = np.delete(nodes, k)
        # Whole numbers far below 2^53: exact.
        weights.append(factorial(order) * np.poly(others)[::-1][order] / np.prod(nodes[k] - others))
    return weights


@cache
def _table(order: int) -> np.ndarray:
    """Weights by how many of the points lie below."""
    return np.array([_weights(order, -below) for below in range(POINTS)])


def difference(
    function: Callable[[np.ndarray], np.ndarray], t: np.ndarray, interval: Interval, step: float, order: int = 1
) -> np.ndarray:
    r"""First or second derivative of ``function`` from nine values at distances h = step (high - low).

    .. math:: f^{(m)}(t) \approx h^{-m} \sum_{k=0}^{8} w_k \bigl(f(t + (k - b) h) - f(t)\bigr)

    b = 4 points lie below t, fewer or more near the ends. Errors are of order h^8 in the middle, h^(9 - m) near the ends.

    Parameters
    ----------
    function : callable
        From an array of the shape of t to one of shape (3, ...).
    t : array
        Within the interval.
    interval : (2,) tuple
        low, high.
    step : float
        At most 1/9, so that nine points fit in at any t.
    order : int
        m, 1 or 2.

    References
    ----------
    B. Fornberg, Generation of finite difference formulas on arbitrarily spaced grids, Math. Comp. 51 (1988) 699-706.
    """
    low, high = interval
    h = step * (high - low)
    # A rounding below a whole number of steps still counts as that number; the clip takes the rounding away.
    fit_below, fit_above = (np.floor(distance / h + SAME_VALUE).astype(int) for distance in (t - low, high - t))
    below = np.maximum(np.minimum(POINTS // 2, fit_below), POINTS - 1 - fit_above)
    weights = _table(order)[below]
    # Less f(t), which changes nothing but the rounding: that of a constant is nothing then.
    here = function(t)
    total = sum(weights[..., k] * (function(np.clip(t + (k - below) * h, low, high)) - here) for k in range(POINTS))
    return np.asarray(total) / h**order
