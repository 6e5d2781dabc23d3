"""A condition of a user's own against itself: gradient and curvature by differences, beside the undeformed state."""

from collections.abc import Callable
from typing import Any

import numpy as np

from skancf.conditions.condition import Condition
from skancf.errors import InputError
from skancf.functions import Noted
from skancf.history import Case
from skancf.kernels.constants import BLOCK
from skancf.layout.layout import Layout
from skancf.terms.blocks import Blocks, coupled
from skancf.tolerances import DERIVED, SAME_VALUE

STEPS = (1e-3, 1e-5)
"""Of differences, in the sizes of the unknowns; the better one counts: long ones leave out what bends, short ones round."""
AMOUNT = 0.01
"""How far the states of the check are from the undeformed one, in the sizes of the unknowns."""


def check_derivatives(name: str, condition: Condition, layout: Layout) -> None:
    """Look at a condition with whole rows and cells, see :func:`skancf.conditions.own.conditions_of`.

    Raises
    ------
    InputError
        For a row without a gradient in the undeformed state, a gradient that is not the derivative of the value, and a
        curvature that is not that of the forces.
    """
    random, sizes = np.random.default_rng(condition.n), layout.scales.ravel()
    change, way = (sizes * random.uniform(-1, 1, layout.n_dofs) for _ in range(2))
    q = layout.undeformed.ravel() + AMOUNT * change
    with Noted("conditions: value, gradient or add_curvature"), np.errstate(all="ignore"):
        _check_rest(name, condition, layout)
        _check_gradient(name, condition, q, way)
        _check_curvature(name, condition, layout, q, way)


def _check_rest(name: str, condition: Condition, layout: Layout) -> None:
    sizes = abs(condition.gradient(layout.undeformed.ravel())) @ layout.scales.ravel()
    nothing = np.flatnonzero(sizes <= SAME_VALUE * np.asarray(condition.scales))
    if nothing.size:
        raise InputError(f"gradient of {name}: that of {condition.rows()[nothing[0]]} is zero in the undeformed state, in "
                         "which the condition holds nothing; write it as one that has a gradient, a distance and not its "
                         "square")  # fmt: skip


def _check_gradient(name: str, condition: Condition, q: np.ndarray, way: np.ndarray) -> None:
    gradient, scales = condition.gradient(q), np.asarray(condition.scales)
    found, size = gradient @ way, abs(gradient) @ np.abs(way)
    wanted, wrong = _nearest(lambda q: np.asarray(condition.value(q, Case(0.0))), q, way, found)
    rows = np.flatnonzero(wrong > DERIVED * np.maximum(size, np.abs(wanted)) + SAME_VALUE * scales)
    if rows.size:
        k = int(rows[0])
        raise InputError(f"gradient of {name}: it is not the derivative of value. Along a random change of q "
                         f"{condition.rows()[k]} changes by {wanted[k]:.6g}, and by the gradient {found[k]:.6g}; look at "
                         "signs, factors of two, and unknowns that it leaves out")  # fmt: skip


def _check_curvature(name: str, condition: Condition, layout: Layout, q: np.ndarray, way: np.ndarray) -> None:
    cells, sizes, multipliers = condition.couples(), layout.scales.ravel(), 1.0 / np.asarray(condition.scales)
    blocks = Blocks(*coupled([cells], layout))
    condition.add_curvature(q, multipliers, blocks)
    found = np.zeros(len(q)) if blocks.is_zero else blocks.matrix() @ way

    def force(q: np.ndarray) -> np.ndarray:
        return np.asarray(condition.gradient(q).T @ multipliers)

    wanted, wrong = _nearest(force, q, way, found)
    k = int(np.argmax(wrong * sizes))
    if wrong[k] * sizes[k] > DERIVED * (np.maximum(np.abs(wanted), np.abs(force(q))) * sizes).max():
        raise InputError(f"add_curvature of {name}: it is not the derivative of gradient(q).T @ multipliers. Along a random "
                         f"change of q the force at block {k // BLOCK}, number {k % BLOCK}, changes by {wanted[k]:.6g}, and "
                         f"by what it adds {found[k]:.6g}; where the gradient depends on q it adds, for each row, "
                         "multiplier times second derivative")  # fmt: skip


def _nearest(
    function: Callable[[np.ndarray], Any], q: np.ndarray, way: np.ndarray, found: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Central differences along a way, of several steps for each entry the one nearest to what was found; and how near."""
    slopes = np.array([(function(q + h * way) - function(q - h * way)) / (2 * h) for h in STEPS])
    wrong = np.abs(slopes - found)
    best = np.argmin(np.where(np.isnan(wrong), np.inf, wrong), axis=0)[None]
    return np.take_along_axis(slopes, best, 0)[0], np.take_along_axis(wrong, best, 0)[0]
