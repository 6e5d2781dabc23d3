"""Whether value, gradient, curvature and discrete gradient of a condition belong together, by differences."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from skancf.conditions.condition import Condition
from skancf.errors import InputError
from skancf.history import Case
from skancf.kernels.constants import AXES, BLOCK
from skancf.layout.layout import Layout
from skancf.terms.blocks import Blocks, coupled
from skancf.tolerances import ROUNDED_FORCE, SAME_DERIVATIVE, SAME_VALUE

STEPS = (1e-3, 1e-4, 1e-5, 1e-6)
"""Of differences, in the sizes of the unknowns; of several the best counts: large ones leave out what bends, small ones are
rounding."""

BESIDE = 0.01
"""How far from the undeformed state curvatures are compared, in the sizes of the unknowns."""
CURVED = "look at add_curvature(q, multipliers, blocks): the sum of multipliers times second derivatives, over each cell"


class WrongCondition(InputError, AssertionError):
    """A condition that contradicts itself; the message says in which row, and by how much."""


def differenced(
    function: Callable[[np.ndarray], np.ndarray], q: np.ndarray, way: np.ndarray, wanted: np.ndarray
) -> np.ndarray:
    """The derivative of a function along a way by central differences, of several the one nearest to what is wanted."""
    found = [np.asarray(function(q + h * way) - function(q - h * way)) / (2 * h) for h in STEPS]
    return min(found, key=lambda each: float(np.abs(each - wanted).max(initial=0.0)))


def require_derivative(name: str, condition: Condition, layout: Layout) -> None:
    """WrongCondition where the gradient in the undeformed state is not the derivative of the value, along one direction: no
    solve would fail for it, but forces would act in other directions than they should."""
    rng = np.random.default_rng(0)
    way = layout.scales.ravel() * rng.uniform(-1, 1, layout.n_dofs)
    _against_value(name, condition, layout, layout.undeformed.ravel().copy(), way, Case(0.0), SAME_DERIVATIVE)


def require_curvature(name: str, condition: Condition, layout: Layout) -> None:
    """WrongCondition where the curvature away from the undeformed state is not the derivative of forces: frequencies about a
    loaded state, buckling loads and stability would be wrong, and Newton's method slow."""
    rng, sizes = np.random.default_rng(0), layout.scales.ravel()
    change, way = (sizes * rng.uniform(-1, 1, layout.n_dofs) for _ in range(2))
    pulls = rng.uniform(0.5, 1, condition.n) / condition.scales
    blocks = Blocks(*coupled([condition.couples()], layout))
    error, size = _against_gradient(condition, layout, layout.undeformed.ravel() + BESIDE * change, way, pulls, blocks)
    if error > SAME_DERIVATIVE * size:
        raise WrongCondition(f"{name}: curvature against gradient: they differ by {error / size:.1e} of their size; "
                             f"{CURVED}")  # fmt: skip


def _against_gradient(
    condition: Condition, layout: Layout, q: np.ndarray, way: np.ndarray, pulls: np.ndarray, blocks: Any
) -> tuple[float, float]:
    """Largest difference of what add_curvature gives along a way from that of gradients, and their size."""
    condition.add_curvature(q, pulls, blocks)
    wanted = blocks.matrix() @ way
    found = differenced(lambda x: condition.gradient(x).T @ pulls, q, way, wanted)
    scales = layout.scales.ravel()
    # What rounds in the difference, where there is no curvature.
    noise = np.abs(condition.gradient(q).T @ pulls * scales).max(initial=0.0) * ROUNDED_FORCE / STEPS[0]
    error, size = (float(np.abs(each * scales).max(initial=0.0)) for each in (found - wanted, found))
    return error, max(size, noise)


def _against_value(
    name: str, condition: Condition, layout: Layout, q: np.ndarray, way: np.ndarray, case: Case, tolerance: float
) -> float:
    """Largest relative difference of the gradient from the derivative of the value."""
    gradient = condition.gradient(q)
    wanted = np.asarray(gradient @ way)
    found = differenced(lambda x: np.asarray(condition.value(x, case)), q, way, wanted)
    sizes = np.maximum(np.asarray(abs(gradient) @ np.abs(way)), np.abs(found))
    errors = np.divide(np.abs(found - wanted), sizes, out=np.zeros(len(sizes)), where=sizes > 0)
    worst = float(errors.max(initial=0.0))
    if not worst <= tolerance:
        row = int(np.argmax(np.where(np.isfinite(errors), errors, np.inf)))
        raise WrongCondition(f"{name}: gradient against value: {condition.rows()[row]} differs by {worst:.1e} of its size; "
                             f"{_place(condition, layout, q, row, case)}. Its forces would have other directions than what "
                             "they keep")  # fmt: skip
    return worst


def _place(condition: Condition, layout: Layout, q: np.ndarray, row: int, case: Case) -> str:
    """The unknown by which a row differs most."""
    gradient = condition.gradient(q).toarray()[row]
    cells = condition.couples()
    blocks = np.unique(np.concatenate([cells.ravel(), np.flatnonzero(gradient) // BLOCK])).astype(int)
    numbers = (BLOCK * blocks[:, None] + np.arange(BLOCK)).ravel()
    scales, step = layout.scales.ravel(), np.zeros(layout.n_dofs)
    found = np.zeros(len(numbers))
    for k, number in enumerate(numbers):
        step[number] = scales[number]
        one = differenced(lambda x: np.asarray(condition.value(x, case)), q, step, condition.gradient(q) @ step)
        found[k], step[number] = one[row] / scales[number], 0.0
    worst = int(np.argmax(np.abs(found - gradient[numbers]) * scales[numbers]))
    block, place = divmod(int(numbers[worst]), BLOCK)
    at = ", ".join(f"{each:.4g}" for each in layout.places[block])
    return (f"worst at block {block}, near ({at}), component {'xyz'[place % AXES]} of its vector {place // AXES}: it gives "
            f"{gradient[numbers[worst]]:.6g} where the difference is {found[worst]:.6g}")  # fmt: skip


@dataclass(frozen=True)
class ConditionCheck:
    """One condition on one system.

    Parameters
    ----------
    name : str
        By which messages know it.
    condition : Condition
    system : System
    tolerance : float
    rng : numpy.random.Generator
    add : callable
        Gets what was checked, and its error.
    """

    name: str
    condition: Condition
    system: Any
    tolerance: float
    rng: np.random.Generator
    add: Callable[[str, float], None]

    def at(self, q: np.ndarray, case: Case) -> None:
        """Gradient and curvature at a state."""
        way = self.way()
        error = _against_value(self.name, self.condition, self.system.layout, q, way, case, self.tolerance)
        self.add("gradient against value", error)
        pulls, blocks = self.rng.uniform(-1, 1, self.condition.n) / self.condition.scales, self.system.blocks()
        error, size = _against_gradient(self.condition, self.system.layout, q, way, pulls, blocks)
        self._judge("curvature against gradient", error, size, CURVED)

    def between(self, q0: np.ndarray, q1: np.ndarray, case: Case) -> None:
        """The discrete gradient."""
        values = [np.asarray(self.condition.value(q, case)) for q in (q0, q1)]
        gradient = self.condition.between(q0, q1)
        wrong = values[1] - values[0] - gradient @ (q1 - q0)
        sizes = np.maximum(np.asarray(abs(gradient) @ np.abs(q1 - q0)), np.abs(values).max(axis=0, initial=0.0))
        errors = np.divide(np.abs(wrong), sizes, out=np.zeros(len(sizes)), where=sizes > 0)
        self._judge("discrete gradient against values", float(errors.max(initial=0.0)), 1.0,
                    "between(q0, q1) times the change must be the change of the value, exactly: the gradient in the middle "
                    "is so for linear and quadratic conditions", SAME_VALUE)  # fmt: skip

    def carried(self) -> None:
        """Multipliers are the same on the same mesh."""
        pulls = self.rng.uniform(-1, 1, self.condition.n)
        error = np.abs(np.asarray(self.condition.carried(pulls, self.condition)) - pulls)
        self._judge("multipliers carried to the same mesh", float(error.max(initial=0.0)), 1.0,
                    "carried(multipliers, onto) changes them though nothing else does", SAME_VALUE)  # fmt: skip

    def way(self) -> np.ndarray:
        """A random direction in the sizes of the unknowns."""
        layout = self.system.layout
        return np.asarray(layout.scales.ravel() * self.rng.uniform(-1, 1, layout.n_dofs))

    def _judge(self, what: str, error: float, size: float, advice: str, tolerance: float | None = None) -> None:
        relative = error / size if size > 0 else error
        self.add(what, relative)
        if not relative <= (self.tolerance if tolerance is None else tolerance):
            raise WrongCondition(f"{self.name}: {what}: they differ by {relative:.1e} of their size; {advice}")
