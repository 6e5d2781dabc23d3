"""Arguments of the loop, and what is checked before any work."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from skancf.adaptive.analysis import Analysis, StaticAnalysis
from skancf.adaptive.estimate import Estimate, residual_indicator
from skancf.adaptive.limits import drift, no_limit
from skancf.adaptive.recovery import recovery_indicator
from skancf.adaptive.stress import face_stress
from skancf.arguments import PROBLEM, flag, having, instance, whole
from skancf.errors import InputError, NoLimit, number, positive, shown, warn
from skancf.linear import check_backend
from skancf.meshes import MeshQuadTree
from skancf.problem import Problem
from skancf.solution import Solution
from skancf.statics.diagnosis import require_support
from skancf.statics.validity import warn_without_time
from skancf.system.system import System
from skancf.theories import Theory
from skancf.tolerances import SEVEN_DIGITS, SHARPEST

INDICATORS: dict[str, Callable[[Solution], np.ndarray] | None] = {
    "goal": None, "residual": residual_indicator, "recovery": recovery_indicator, "stress": face_stress,
}  # fmt: skip
"""By what elements are marked; the error bar is that of the quantity with each of them."""


def check(
    problem: Any, rtol: float, atol: float, indicator: Any, policies: tuple[Any, Any], max_dofs: int,
    max_seconds: float | None, max_levels: int, backend: str, **flags: bool,
) -> None:  # fmt: skip
    instance("problem", problem, Problem, PROBLEM)
    check_backend(backend)
    for name, value in flags.items():
        flag(name, value)
    if number("atol", atol) < 0:
        raise InputError(f"atol = {atol}: give an absolute accuracy of at least 0")
    if not (number("rtol", rtol) > 0 or (rtol == 0 and atol > 0)):
        raise InputError(f"rtol = {rtol}: give a relative accuracy greater than zero, such as 1e-3")
    for name, policy in zip(("marking", "coarsening"), policies, strict=True):
        if policy is None and name == "marking":
            continue
        having(name, policy, ("marked",), "a policy such as Doerfler(0.9), Maximum(0.5) or Never()")
    if isinstance(indicator, type) or (
        not callable(indicator) and not (isinstance(indicator, str) and indicator in INDICATORS)
    ):
        raise InputError(
            f"indicator = {shown(indicator)}: choose one of {list(INDICATORS)}, or give a function of a Solution"
        )
    positive("max_dofs", max_dofs)
    whole("max_levels", max_levels, floats=True)
    if max_seconds is not None:
        positive("max_seconds", max_seconds, "s")


def newton_rtol(rtol: float) -> float:
    """Of Newton's method, which gains at least a factor ten more with its last step."""
    return min(1e-4, max(SHARPEST, 1e-2 * rtol))


def first_system(
    problem: Problem, mesh: MeshQuadTree, theory: str | Theory, quantity: Any, analysis: Analysis, max_dofs: int
) -> System:
    """The system on the first mesh, on which all that can be known without a solve is checked."""
    system = problem.on(mesh, theory)
    if system.n_dofs > max_dofs:
        raise InputError(f"max_dofs = {max_dofs}: the first mesh of {mesh.nelements} elements already has {system.n_dofs} "
                         "nodal coordinates; allow more, or begin with a coarser mesh")  # fmt: skip
    if why := no_limit(quantity, system):
        raise NoLimit(why)
    for hint in (drift(system), _between_lines(quantity, mesh)):
        if hint:
            warn(hint)
    warn_without_time(system)
    if isinstance(analysis, StaticAnalysis):
        require_support(system)
    return system


def _between_lines(quantity: Any, mesh: MeshQuadTree) -> str | None:
    """That the rectangle of a mean is another one on each mesh; None where its sides are lines of the first mesh or will be
    after a few halvings."""
    for axis, sides in enumerate(getattr(quantity, "within", None) or ()):
        lines = np.unique(mesh.leaves.forest.points[axis])
        for side in (side for side in sides if lines[0] < side < lines[-1]):
            k = np.searchsorted(lines, side) - 1
            share = HALVINGS * (side - lines[k]) / (lines[k + 1] - lines[k])
            if abs(share - round(share)) > SEVEN_DIGITS:
                return (f"within: {'xy'[axis]} = {side:.6g} lies between the mesh lines {lines[k]:.6g} and "
                        f"{lines[k + 1]:.6g}, and no halving meets it: the mean is over another rectangle on each mesh; "
                        "begin with a mesh that has the line, or without one of your own")  # fmt: skip
    return None


HALVINGS = 2**6
"""Parts of an element whose lines count as lines of the mesh."""


class AdaptArguments(NamedTuple):
    """What the user asked for and allows."""

    rtol: float
    atol: float
    max_dofs: int
    max_seconds: float | None
    max_levels: int

    def tolerance(self, value: float) -> float:
        return max(self.rtol * abs(value), self.atol)

    def zero(self, estimate: Estimate) -> str:
        """That a value is zero as accurately as asked of the sizes of what makes it; empty where it is not."""
        if not (abs(estimate.value) <= estimate.bar <= self.rtol * estimate.scale):
            return ""
        return (f"the value is zero within its error bar, {estimate.bar:.2g}, which is less than rtol times "
                f"{estimate.scale:.3g}, the size of what cancels in it or of such numbers elsewhere")  # fmt: skip
