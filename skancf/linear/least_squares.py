r"""Equations g(x) = 0 that may have no solution, by damped least squares,

.. math:: \Delta x = -J^T (J J^T + \mu)^{-1} r, \qquad r = D g, \quad J = D G ,

with one row for each equation, and all rows of one size by the diagonal D.

References
----------
Marquardt (1963), J. SIAM 11, 431-441; Nielsen (1999), IMM-REP-1999-05, DTU, for the damping.
"""

from collections.abc import Callable

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import spsolve

from skancf.linear.constraints import Constraints
from skancf.tolerances import CONTRADICTION

MOST = 100
"""Tries of a step; a dozen are the rule, and several dozen near a place where a row loses its gradient."""
DAMPING, LEAST = 1e-3, 1e-10
"""The first one and the least one, of the size of a row."""
FAINT = 1e-3
"""Of the largest part of an equation that is left open: a smaller part is not what keeps the others from being met."""


def least_squares(
    value: Callable[[np.ndarray], np.ndarray], gradient: Callable[[np.ndarray], sp.csr_matrix], x: np.ndarray,
    constraints: Constraints, met: Callable[[np.ndarray], bool],
) -> tuple[np.ndarray, np.ndarray | None]:  # fmt: skip
    """A place near x that meets equations as well as any.

    Parameters
    ----------
    value, gradient : callable
        g (n,) and its derivative (n, n_dofs) of x.
    x : (n_dofs,) array
        Where to begin; prescribed coordinates stay.
    met : callable
        Whether values of g are as good as zero.

    Returns
    -------
    x : (n_dofs,) array
    rows : (m,) int array or None
        Empty where all are met. Where free changes no longer lessen what is left, those that contradict each other, the
        worst first. None where neither was found.
    """
    values, (rows, even), damping, times = value(x), _free_rows(gradient, x, constraints), DAMPING, 2.0
    for _ in range(MOST):
        if met(values):
            return x, np.empty(0, dtype=int)
        left = even * values
        slope = rows.T @ left
        if np.linalg.norm(slope) <= CONTRADICTION * np.linalg.norm(left):
            order = np.argsort(-np.abs(left))
            return x, order[np.abs(left[order]) > FAINT * np.abs(left).max()]
        damped = sp.csc_matrix(rows @ rows.T + damping * sp.eye(len(left)))
        change = -(rows.T @ np.atleast_1d(spsolve(damped, left)))
        news = value(x + change)
        gain = (left @ left - (even * news) @ (even * news)) / (change @ (damping * change - slope))
        if gain > 0:
            x, values, times = x + change, news, 2.0
            damping = max(damping * max(1.0 / 3.0, 1.0 - (2.0 * gain - 1.0) ** 3), LEAST)
            rows, even = _free_rows(gradient, x, constraints)
        else:
            damping, times = times * damping, 2.0 * times
    return x, None


def _free_rows(
    gradient: Callable[[np.ndarray], sp.csr_matrix], x: np.ndarray, constraints: Constraints
) -> tuple[sp.csr_matrix, np.ndarray]:
    """Rows on free coordinates, and what all were multiplied by to be of one size."""
    whole = gradient(x)
    sizes = np.sqrt(np.asarray(whole.multiply(whole).sum(axis=1)).ravel())
    even = np.divide(1.0, sizes, out=np.ones(len(sizes)), where=sizes > 0)
    return sp.csr_matrix(sp.diags(even) @ whole @ constraints.free_projection), even
