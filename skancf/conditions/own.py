"""The conditions of a problem on a layout, looked at when a system is made: what is wrong with one is told by its name."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import scipy.sparse as sp

from skancf.arguments import having, text, whole
from skancf.conditions.check import require_curvature, require_derivative
from skancf.conditions.condition import Condition, Joint
from skancf.conditions.sums import Conditions
from skancf.errors import InputError, shown
from skancf.functions import Noted, is_ours
from skancf.history import Case
from skancf.kernels.constants import BLOCK
from skancf.layout.layout import Layout
from skancf.terms.own import check_cells
from skancf.tolerances import SAME_VALUE

NAMES = [name for name in (*vars(Condition), "name", "n", "scales") if not name.startswith("_")]


def conditions_of(joints: Sequence[Joint], shell: Any, layout: Layout) -> Conditions:
    """The conditions of joints on a layout.

    Raises
    ------
    InputError
        For what is no condition, one whose rows, gradient and cells do not fit each other, one that the undeformed state
        does not meet at the load factor zero, and one whose gradient is zero there or not the derivative of its value, or
        whose curvature is not that of its forces.
    """
    found = [_condition(joint, shell, layout) for joint in joints]
    conditions = Conditions(found, layout.n_dofs)
    start = layout.undeformed.ravel()
    for name, each in zip(conditions.names, found, strict=True):
        values = each.value(start, Case(0.0))
        if not Conditions([each], layout.n_dofs).met(values):
            worst = int(np.argmax(np.abs(values) / each.scales))
            raise InputError(f"condition {name!r}: the undeformed state does not meet it, {each.rows()[worst]} is "
                             f"{values[worst]:.4g}. Begin with a state that does, and let its value depend "
                             "on the case to move there: it vanishes at case.factor = 0")  # fmt: skip
        if not is_ours(each):
            for require in (require_derivative, require_curvature):
                require(f"condition {name!r}", each, layout)
    return conditions


def _condition(joint: Joint, shell: Any, layout: Layout) -> Condition:
    if is_ours(joint):
        return joint.on(shell, layout)
    with Noted("conditions.on"):
        condition = joint.on(shell, layout)
    name = f"the condition of {shown(joint)}"
    having(name, condition, NAMES, "one from on(), of a class that is derived from skancf.conditions.Condition, with name, "
           "n and scales")  # fmt: skip
    check_condition_of(name, condition, layout)
    return condition


def check_condition_of(name: str, condition: Condition, layout: Layout) -> None:
    """InputError where shapes and blocks of a condition do not fit the layout, or its numbers are not finite."""
    text(f"name of {name}", condition.name)
    n, q = whole(f"n of {name}", condition.n, least=0), layout.undeformed.ravel().copy()
    q.flags.writeable = False  # a condition that writes into what it is given is stopped here
    with Noted("conditions: couples, value or gradient"):
        cells, value, gradient, between = (
            condition.couples(), condition.value(q, Case(0.0)), condition.gradient(q), condition.between(q, q)
        )  # fmt: skip
    check_cells(cells, layout)
    for what, array in (("value", np.asarray(value)), ("scales", np.asarray(condition.scales))):
        if array.shape != (n,) or array.dtype.kind not in "fiu" or not np.isfinite(array).all():
            raise InputError(f"{what} of {name}: {shown(array)}, of shape {array.shape}; give {n} finite numbers, one for "
                             "each of its n rows")  # fmt: skip
    if not (np.asarray(condition.scales) > 0).all():
        raise InputError(f"scales of {name}: {shown(condition.scales)}; the size of a row is greater than zero")
    for what, matrix in (("gradient", gradient), ("between", between)):
        _check_gradient(f"{what} of {name}", matrix, cells, n, layout)
    sizes = abs(sp.csr_matrix(gradient)) @ layout.scales.ravel()
    nothing = np.flatnonzero(sizes <= SAME_VALUE * np.asarray(condition.scales))
    if nothing.size:
        raise InputError(f"gradient of {name}: that of {condition.rows()[nothing[0]]} is zero in the undeformed state, in "
                         "which the condition holds nothing; write it as one that has a gradient, a distance and not its "
                         "square")  # fmt: skip


def _check_gradient(name: str, gradient: Any, cells: np.ndarray, n: int, layout: Layout) -> None:
    shape, rows = (n, layout.n_dofs), sp.csr_matrix(gradient) if sp.issparse(gradient) else None
    if rows is None or rows.shape != shape or rows.dtype.kind not in "fiu" or not np.isfinite(rows.data).all():
        raise InputError(f"{name}: {shown(gradient)}; give a sparse matrix of finite numbers, of shape {shape}")
    for k in range(n):
        blocks = np.unique(rows.indices[rows.indptr[k] : rows.indptr[k + 1]] // BLOCK)
        if not any(np.isin(blocks, cell).all() for cell in cells):
            raise InputError(f"{name}: row {k} depends on blocks {blocks.tolist()}, which no cell of couples() has together")
