"""A user's form at points: called, checked, and differentiated with respect to the jet.

First derivatives are those of a complex step,

.. math:: \\partial f / \\partial x = \\operatorname{Im} f(x + i s) / s,

with a step s so small that its square is nothing: no difference is taken, and no digit lost. A function that is not
analytic, such as one of ``abs``, has no such derivative, and is found by comparing with a difference.

References
----------
Squire and Trapp (1998), SIAM Review 40, 110-112.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from skancf.equality import by_value
from skancf.errors import InputError, shown
from skancf.functions import Noted
from skancf.history import Case
from skancf.terms.forms.fields import VELOCITY, Jet, Vector
from skancf.terms.forms.points import Chunk
from skancf.tolerances import CLOSE_JETS, ROUNDED_SUM

COMPLEX_STEP = 2.0**-100
"""In the size of what it changes."""
DIFFERENCE = 2.0**-22
"""A real step: between rounding, 1e-16 over it, and the square of it."""
AWAY, NOT_EQUAL, SOME = 1e-4, 1e-3, 0.2
"""How far from the undeformed state a form is tried, and what differs at how many of the points."""

Second = tuple[np.ndarray, list[str], list[str]]
"""Second derivatives (rows, 3, columns, 3, m, n), and the names of rows and columns."""


@by_value
@dataclass(frozen=True)
class Integrand:
    """A form of w, of v and w, or of u, v and w.

    Attributes
    ----------
    name : str
        Of the argument, for messages.
    function : callable
    """

    name: str
    function: Callable[..., Any]

    def __call__(self, chunk: Chunk, jet: Jet, case: Case, *tests: Jet) -> tuple[np.ndarray, list[list[str]]]:
        """Values (m, n), and what it read of the jet of each test function and of the state."""
        read: list[set[str]] = [set() for _ in tests]
        vectors = [_recorded(test, names) for test, names in zip(tests, read, strict=True)]
        w = chunk.fields(jet, case)
        with Noted(self.name), np.errstate(all="ignore"):
            try:
                found = self.function(*vectors, w)
            except TypeError as wrong:
                if any(np.iscomplexobj(each) for each in jet.values()):
                    raise self._not_analytic(f"it takes no complex numbers ({wrong})") from wrong
                raise
            except ValueError as wrong:
                if "broadcast" not in str(wrong) or isinstance(wrong, InputError):
                    raise
                raise InputError(
                    f"{self.name}: {wrong}; the form is called with some elements at a time, here with "
                    f"{chunk.weights.shape} elements and points, and fields of another basis or mesh do not fit; use what "
                    "w holds"
                ) from wrong
        value = self._checked(found, chunk, any(np.iscomplexobj(each) for each in jet.values()))
        used = [_ordered(chunk, {"r", *names}) for names in read]
        return value, [*used, _ordered(chunk, w.used)]

    def _checked(self, found: Any, chunk: Chunk, complex_in: bool) -> np.ndarray:
        shape = chunk.weights.shape
        try:
            value = np.asarray(found)
            fits = value.dtype.kind in "iufc" and np.broadcast_shapes(value.shape, shape) == shape
        except ValueError:
            value, fits = np.asarray(0.0), False
        if not fits:
            given = f"an array of shape {np.shape(found)}" if isinstance(found, np.ndarray) else shown(found)
            raise InputError(f"{self.name}: the form returned {given}; it must return one number for each point, here of "
                             f"shape {shape}, elements and points, as dot(a, b) does of vectors")  # fmt: skip
        if value.dtype.kind == "c" and not complex_in:
            raise InputError(f"{self.name}: the form returned complex numbers for real fields; it must return real ones")
        return np.broadcast_to(value, shape)

    def check_finite(self, value: np.ndarray, chunk: Chunk) -> None:
        """InputError for values (m, n) that are not finite; in other states they are what solvers turn back from."""
        wrong = ~np.isfinite(value) & (chunk.weights > 0)
        if wrong.any():
            element, point = np.argwhere(wrong)[0]
            place = ", ".join(f"{v:.6g}" for v in chunk.given["x"][:, element, point])
            raise InputError(f"{self.name}: the form is {value[wrong][0]} at ({place}) of the undeformed surface, and not "
                             f"finite at {wrong.sum()} points of {wrong.size}; it must be finite there")  # fmt: skip

    def _not_analytic(self, why: str) -> InputError:
        return InputError(
            f"{self.name}: derivatives are taken by complex steps, and {why}; write it without abs, real, conj and norm: "
            "a length is np.sqrt((v * v).sum(axis=0)), and a case is np.where(g.real < 0, ...); or give its derivative too, "
            "as residual or tangent"
        )  # fmt: skip

    def imaginary(self, chunk: Chunk, jet: Jet, case: Case, step: Jet, *tests: Jet) -> np.ndarray:
        """Derivative (m, n) along a step of some vectors of the jet."""
        moved = {name: jet[name] + 1j * COMPLEX_STEP * each for name, each in step.items()}
        value, _ = self(chunk, {**jet, **moved}, case, *tests)
        return np.asarray(np.imag(value) / COMPLEX_STEP)

    def check_analytic(self, chunk: Chunk, sizes: Mapping[str, float], case: Case, rng: np.random.Generator) -> None:
        """InputError where the complex step differs from a difference, near the undeformed state."""
        tests = [] if self.name == "energy" else [random_jet(chunk, sizes, rng)]
        away, way = (random_jet(chunk, sizes, rng) for _ in range(2))
        still = {**chunk.undeformed.jet, VELOCITY: np.zeros_like(away[VELOCITY])}
        jet = {name: each + AWAY * away[name] for name, each in still.items()}
        up, down = (
            self(chunk, {name: each + sign * DIFFERENCE * way[name] for name, each in jet.items()}, case, *tests)[0]
            for sign in (1, -1)
        )
        difference, found = (up - down) / (2 * DIFFERENCE), self.imaginary(chunk, jet, case, way, *tests)
        if not np.isfinite(difference).all():
            return  # a singular place is so near that no difference can be taken
        slack = NOT_EQUAL * max(np.abs(difference).max(), np.abs(found).max()) + ROUNDED_SUM * np.abs(up).max() / DIFFERENCE
        if (np.abs(found - difference) > slack).mean() > SOME:
            worst = np.unravel_index(np.argmax(np.abs(found - difference)), found.shape)
            raise self._not_analytic(
                f"its derivative by one is {found[worst]:.3g} where a difference has {difference[worst]:.3g}"
            )


def _recorded(test: Jet, names: set[str]) -> Vector:
    def part(name: str) -> np.ndarray:
        if name not in test:
            raise AttributeError(f"this theory's test functions have no {name}")
        names.add(name)
        return test[name]

    return Vector.of(part, "r")


def _ordered(chunk: Chunk, names: set[str]) -> list[str]:
    return [name for name in (*chunk.names, VELOCITY) if name in names]


def random_jet(chunk: Chunk, sizes: Mapping[str, float], rng: np.random.Generator) -> Jet:
    shape = (3, *chunk.weights.shape)
    return {name: sizes[name] * rng.uniform(-1, 1, shape) for name in (*chunk.names, VELOCITY)}


def _unit(chunk: Chunk, name: str, i: int, size: float = 1.0) -> Jet:
    none = np.zeros((3, 1, 1))
    unit = none.copy()
    unit[i] = size
    return {**dict.fromkeys(chunk.names, none), name: unit}


def gradient_of_energy(
    energy: Integrand, chunk: Chunk, jet: Jet, case: Case, sizes: Mapping[str, float]
) -> dict[str, np.ndarray]:
    """Derivative (3, m, n) with respect to each vector of the jet that the energy reads."""
    _, (used,) = energy(chunk, jet, case)
    return {name: np.stack([_component(energy, chunk, jet, case, name, i, sizes[name]) for i in range(3)]) for name in used}


def _component(
    form: Integrand, chunk: Chunk, jet: Jet, case: Case, name: str, i: int, size: float, *tests: Jet
) -> np.ndarray:
    return form.imaginary(chunk, jet, case, {name: _unit(chunk, name, i, size)[name]}, *tests) / size


def discrete_gradient(
    energy: Integrand, chunk: Chunk, start: Jet, end: Jet, case: Case, sizes: Mapping[str, float]
) -> dict[str, np.ndarray]:
    r"""A derivative g between two jets, with which the energy changes exactly,

    .. math:: g = \nabla f(\bar x) + \frac{f(x^1) - f(x^0) - \nabla f(\bar x) \cdot \Delta x}{|\Delta x|^2} \Delta x,

    where vectors are measured in their sizes. Of changes that are so small that rounding would be divided by them, the first
    part is exact.

    References
    ----------
    Gonzalez (1996), J. Nonlinear Sci. 6, 449-467.
    """
    middle = {name: 0.5 * (start[name] + end[name]) for name in start}
    change = {name: end[name] - start[name] for name in start}
    gradient = gradient_of_energy(energy, chunk, middle, case, sizes)
    missing = energy(chunk, end, case)[0] - energy(chunk, start, case)[0]
    length = np.zeros_like(missing)
    for name, each in gradient.items():
        missing = missing - (each * change[name]).sum(axis=0)
        length = length + ((change[name] / sizes[name]) ** 2).sum(axis=0)
    part = np.where(length > CLOSE_JETS**2, missing / np.where(length > 0, length, 1.0), 0.0)
    return {name: each + part * change[name] / sizes[name] ** 2 for name, each in gradient.items()}


def gradient_of_residual(residual: Integrand, chunk: Chunk, jet: Jet, case: Case) -> dict[str, np.ndarray]:
    """What the residual multiplies each vector of the variation's jet with, (3, m, n)."""
    _, (used, _) = residual(chunk, jet, case, every(chunk))
    return {name: np.stack([residual(chunk, jet, case, _unit(chunk, name, i))[0] for i in range(3)]) for name in used}


def every(chunk: Chunk) -> Jet:
    """A test function that has a part in all that is read of it."""
    return dict.fromkeys(chunk.names, np.ones((3, 1, 1)))


def _pairs(names: list[str]) -> list[tuple[str, int]]:
    return [(name, i) for name in names for i in range(3)]


def _filled(chunk: Chunk, rows: list[str], columns: list[str], entry: Callable[[int, int], np.ndarray | None]) -> np.ndarray:
    """(rows, 3, columns, 3, m, n) of a function of row and column, which for a symmetric matrix has the lower triangle."""
    out = np.empty((3 * len(rows), 3 * len(columns), *chunk.weights.shape))
    for b in range(out.shape[1]):
        for a in range(out.shape[0]):
            found = entry(a, b)
            out[a, b] = out[b, a] if found is None else found
    return out.reshape(len(rows), 3, len(columns), 3, *chunk.weights.shape)


def second_of_energy(energy: Integrand, chunk: Chunk, jet: Jet, case: Case, sizes: Mapping[str, float]) -> Second:
    """Differences of complex steps: one triangle of a symmetric matrix."""
    _, (used,) = energy(chunk, jet, case)
    pairs, states = _pairs(used), []
    for name, i in pairs:
        step = DIFFERENCE * _unit(chunk, name, i, sizes[name])[name]
        states.append(tuple({**jet, name: jet[name] + sign * step} for sign in (1, -1)))

    def entry(a: int, b: int) -> np.ndarray | None:
        if a < b:
            return None
        name, i = pairs[a]
        up, down = (_component(energy, chunk, state, case, name, i, sizes[name]) for state in states[b])
        return (up - down) / (2 * DIFFERENCE * sizes[pairs[b][0]])

    return _filled(chunk, used, used, entry), used, used


def second_of_residual(residual: Integrand, chunk: Chunk, jet: Jet, case: Case, sizes: Mapping[str, float]) -> Second:
    """Complex steps of the residual, exact to rounding."""
    _, (rows, read) = residual(chunk, jet, case, every(chunk))
    columns = [name for name in read if name != VELOCITY]
    tests, pairs = [_unit(chunk, *pair) for pair in _pairs(rows)], _pairs(columns)

    def entry(a: int, b: int) -> np.ndarray:
        name, i = pairs[b]
        return _component(residual, chunk, jet, case, name, i, sizes[name], tests[a])

    return _filled(chunk, rows, columns, entry), rows, columns


def damping_of_residual(residual: Integrand, chunk: Chunk, jet: Jet, case: Case, sizes: Mapping[str, float]) -> Second:
    """Derivatives with respect to the velocity, by complex steps."""
    _, (rows, _) = residual(chunk, jet, case, every(chunk))
    tests = [_unit(chunk, *pair) for pair in _pairs(rows)]

    def entry(a: int, b: int) -> np.ndarray:
        step = {VELOCITY: _unit(chunk, "r", b, sizes[VELOCITY])["r"]}
        return residual.imaginary(chunk, jet, case, step, tests[a]) / sizes[VELOCITY]

    return _filled(chunk, rows, [VELOCITY], entry), rows, [VELOCITY]


def second_by_form(tangent: Integrand, chunk: Chunk, jet: Jet, case: Case) -> Second:
    """The user's own: u is the change, v the variation."""
    _, (columns, rows, _) = tangent(chunk, jet, case, every(chunk), every(chunk))
    variations, changes = ([_unit(chunk, *pair) for pair in _pairs(names)] for names in (rows, columns))
    return _filled(chunk, rows, columns, lambda a, b: tangent(chunk, jet, case, changes[b], variations[a])[0]), rows, columns
