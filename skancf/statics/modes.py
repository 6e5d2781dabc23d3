"""Small free vibrations about an equilibrium."""

import logging
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import eigh
from scipy.sparse.linalg import ArpackError, ArpackNoConvergence, LinearOperator, eigsh

from skancf.arguments import whole
from skancf.checks import Check
from skancf.equality import by_value
from skancf.errors import DidNotConverge, InputError, number
from skancf.linear import BlockMatrix, Constraints, DirectSolver, factor_shifted
from skancf.memory import require_much
from skancf.progress import Bar, ShowProgress, check_progress
from skancf.showing import counted, in_a_notebook, in_brackets, looked_at, passed, short, some, summary
from skancf.solution import Solution
from skancf.states import StateLike
from skancf.statics.arguments import check_arguments, state_on_mesh
from skancf.statics.conditioned import conditions_in
from skancf.statics.eigen_checks import (
    SAFETY,
    TRIES,
    count_check,
    gap_after,
    gap_or_group,
    group_note,
    orthogonality_check,
    pair_check,
    rigid_check,
    warn_of_failures,
)
from skancf.statics.left_out import frequency_changes, warn_of_changes
from skancf.statics.motions import Motions, motions_of
from skancf.statics.shapes import moved_along, nth, swung_along
from skancf.statics.tangents import state_tangent, warn_if_skew
from skancf.statics.validity import warn_without_time
from skancf.system.rigid import free_rigid_motions
from skancf.system.system import System
from skancf.tabular import Column, Tabular
from skancf.thinness import warn_if_mass_is_off
from skancf.tolerances import TINY, ZERO_EIGENVALUE

logger = logging.getLogger(__name__)


@by_value
@dataclass(frozen=True)
class Modes(Tabular):
    r"""Outcome of :func:`modes`, in ascending order; as a table the frequencies, see :class:`~skancf.tabular.Tabular`.

    Attributes
    ----------
    eigenvalues : (n,) array
        :math:`\omega^2` (1/s2). Negative where the equilibrium is not stable, zero for motions without stiffness.
    shapes : (n, n_dofs) array
        Of unit modal mass, :math:`\phi^T M \phi = 1`, zero along prescribed coordinates.
    n_rigid : int
        Motions of which the stiffness is zero to rounding, all of them even if more than n: rigid motions of a free
        structure, or a mechanism.
    n_unstable : int
        Negative eigenvalues, all of them even if more than n.
    state : Solution
        The equilibrium.
    note : str
        That n cuts a group of equal or nearly equal eigenvalues, and how many to ask for to have all of it.
    checks : tuple of Check
        A bound on the relative error of each eigenvalue from its residual, the worst of them; products of the shapes; and
        whether any of the lowest is missing, by the signs of the pivots of :math:`K - s M`, s in the gap behind the last;
        with conditions, at rest, also whether all free rigid motions are there.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> system = plate.on(sk.meshes.uniform(plate.surface, 6, 6), "kirchhoff")
    >>> found = sk.modes(system, 1)
    >>> first = found.shape(0, size=0.05)  # a Solution, its largest displacement 0.05 m
    >>> print(found.n_rigid, f"{found.frequencies[0]:.1f} Hz", f"{abs(first.displacement((0.5, 0.5))[2]):.3f} m")
    0 89.7 Hz 0.050 m
    """

    eigenvalues: np.ndarray
    shapes: np.ndarray
    n_rigid: int
    n_unstable: int
    state: Solution
    note: str = ""
    checks: tuple[Check, ...] = ()

    __repr__, _repr_html_, view = in_brackets, in_a_notebook, looked_at

    @summary
    def __str__(self) -> str:
        said = f"{counted(len(self.eigenvalues), 'mode')}, frequencies {some(self.frequencies, 'Hz')}"
        still = [f"{n} {what}" for n, what in ((self.n_rigid, "without stiffness"), (self.n_unstable, "unstable")) if n]
        return f"Modes: {', '.join([said, *still])}; {self.state.system}{passed(self.checks)}"

    @property
    def ok(self) -> bool:
        """Whether what was asked for was found, and every check passed."""
        return all(check.passed for check in self.checks)

    @cached_property
    def theory_errors(self) -> np.ndarray:
        r"""By which part of itself transverse shear and the rotary inertia of the normals, which theory `kirchhoff` leaves
        out, would change each frequency, (n,): to first order in each, with the form F of :mod:`skancf.thinness.form`,

        .. math:: \frac{\omega_{\text{with}}}{\omega} - 1, \qquad
            \omega_{\text{with}}^2 \approx \frac{\omega^2}{(1 + F(\phi, \phi) / \omega^2) \,
            (1 + \int \rho \tfrac{h^3}{12} |\nabla \phi|^2)},

        where stresses of the state take no part in the first factor. Zero in theory `full`, NaN for motions without
        stiffness and unstable ones.
        """
        return frequency_changes(self.state, self.eigenvalues, self.shapes)

    def _table(self) -> dict[str, Column]:
        return {
            "mode": (np.arange(len(self.eigenvalues)), ""), "frequency": (self.frequencies, "Hz"),
            "omega": (self.omega, "rad/s"), "eigenvalue": (self.eigenvalues, "1/s2"),
        }  # fmt: skip

    @property
    def omega(self) -> np.ndarray:
        r"""Angular frequencies (rad/s), (n,); for an unstable motion, minus its rate of growth :math:`\sqrt{-\omega^2}`."""
        return np.sign(self.eigenvalues) * np.sqrt(np.abs(self.eigenvalues))

    @property
    def frequencies(self) -> np.ndarray:
        """Frequencies (Hz), (n,); negative as in ``omega``."""
        return self.omega / (2 * np.pi)

    def _as_solution(self) -> Solution:
        raise InputError("modes have several shapes; give one of them, as modes.shape(0), or modes.state")

    def shape(self, i: int, size: float | None = None) -> Solution:
        """The equilibrium moved along mode ``i``, for pictures; ``size`` is the largest displacement of a node (m)."""
        return moved_along(self.state, nth(self.shapes, i), size)

    def swing(self, i: int, size: float | None = None, *, frames: int = 24) -> tuple[Solution, ...]:
        r"""One period of mode ``i`` about the equilibrium, for films that repeat: the shape times :math:`\sin 2 \pi k / n`
        in the k-th of n ``frames``; ``size`` is the largest displacement of a node (m).

        Examples
        --------
        >>> strip = sk.Problem(sk.Rectangle(1.0, 0.3), 0.01, sk.Isotropic(2e9, 0.3, 1e3), [sk.Clamp("left")])
        >>> modes = sk.modes(strip.on(sk.meshes.uniform(strip.surface, 4, 1)), 1)
        >>> swing = modes.swing(0, size=0.1, frames=4)
        >>> [round(float(abs(state.displacement((1.0, 0.0))[2])), 3) for state in swing]
        [0.0, 0.1, 0.0, 0.1]
        """
        return swung_along(self.state, nth(self.shapes, i), size, frames)


def modes(
    system: System,
    n: int = 6,
    *,
    state: StateLike | None = None,
    tolerance: float = 1e-10,
    backend: str = "auto",
    progress: ShowProgress = True,
) -> Modes:
    r"""Lowest frequencies, :math:`K \phi = \omega^2 M \phi`, K being the tangent of the undeformed state or ``state``.

    Lanczos' method on :math:`(K - \sigma M)^{-1} M`, with :math:`\sigma = 0`, or a small negative number where K is
    singular; Sylvester's law of inertia shows whether an eigenvalue is missing.

    Parameters
    ----------
    n : int
        Number of modes.
    state : Solution, optional
        An equilibrium, of which the stresses and the loads' stiffness enter: prestressed vibration. About a linear answer
        K is that of :func:`buckling`, of the undeformed place with the first-order stresses.
    tolerance : float
        Relative accuracy of the eigenvalues.
    backend : str
        Of the linear solver.
    progress : bool or callable
        A bar, nothing, or a function that is told of each solve; see :class:`~skancf.Progress`.

    Raises
    ------
    InputError
        For more modes than free coordinates.

    Warns
    -----
    OutOfDepth
        Where loads follow a free edge: only the symmetric part of K is taken, and flutter is not found. Where a check
        fails, for example as modes are missing that further searches did not find.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> system = plate.on(sk.meshes.uniform(plate.surface, 6, 6), "kirchhoff")
    >>> found = sk.modes(system, 2)
    >>> print(*(f"{f:.1f} Hz" for f in found.frequencies))
    89.7 Hz 183.2 Hz
    """
    check_arguments(system, backend)
    check_progress(progress)
    if state is not None:
        state = state_on_mesh(system, state, "state")
    tolerance = check_tolerance(tolerance)
    warn_if_mass_is_off(system)
    if state is None:
        warn_without_time(system)
    n = checked_count(n, system.constraints)
    stiffness, at_rest = state_tangent(system, state), state is None
    state = state or Solution(system, system.undeformed.copy(), load_factor=0.0)
    warn_if_skew(system, stiffness, state.about, state.load_factor)
    with Bar("modes", None, progress) as bar, DirectSolver(system.pattern, system.constraints, backend) as solver:
        motions = motions_of(system, solver, state.about, stiffness)
        motions.require(n)
        spectrum = _Spectrum(motions, stiffness, system.mass, tolerance, bar)
        pairs, cut, count = spectrum.lowest(n)
    first, values = pairs.of(slice(n)), pairs.values
    products = first.shapes @ np.array([spectrum.with_mass(v) for v in first.shapes]).T
    checks: tuple[Check, ...] = (pair_check(first.errors, first.allowed), orthogonality_check(products, "mass"), count)
    n_rigid, n_unstable = int((values == 0).sum()), int((values < 0).sum())
    if at_rest and conditions_in(system):
        checks = (*checks, rigid_check(n_rigid, len(free_rigid_motions(system))))
    warn_of_failures(checks)
    note = group_note("mode", values, n, gap_after(values, n) or cut)
    logger.info("%d modes, eigenvalues from %.6g to %.6g; %d solves", n, first.values[0], first.values[-1], bar.done)
    found = Modes(first.values, first.shapes, n_rigid, n_unstable, state, note, checks)
    warn_of_changes("frequency", found.theory_errors)
    return found


class Pairs(NamedTuple):
    """Ascending eigenvalues (m,), shapes (m, n_dofs) of unit modal mass, and bounds (m,) on relative errors with what is
    allowed for them."""

    values: np.ndarray
    shapes: np.ndarray
    errors: np.ndarray
    allowed: np.ndarray

    def __repr__(self) -> str:
        return short(self)

    def of(self, order: Any) -> "Pairs":
        return Pairs(*(part[order] for part in self))


class _Spectrum:
    """Eigenpairs of K against M."""

    def __init__(self, motions: Motions, stiffness: BlockMatrix, mass: BlockMatrix, tolerance: float, bar: Bar) -> None:
        self.motions, self.stiffness, self.mass, self.tolerance, self.bar = motions, stiffness, mass, tolerance, bar
        self.constraints = motions.constraints

    def lowest(self, n: int) -> tuple[Pairs, int, Check]:
        """All pairs up to the first gap behind the n lowest, all unstable ones and all without stiffness; the number of
        pairs before that gap; and whether that number exists.

        Lanczos' method may pass over one of several equal eigenvalues, or a negative one far from the shift. By Sylvester's
        law the pivots of K - s M count those below s, with s in the gap, and what is missing is looked for in addition to
        what was found.
        """
        room = self.motions.room
        shift, ask, lost, stuck, tries, searched_again = None, n + 1, room, 0, 0, False
        pairs = self._pairs(np.zeros((0, self.mass.shape[0])), 0.0)
        while len(pairs.values) + ask < room and 2 * ask < room:
            if shift is None:
                shift = factor_shifted(self.motions, self.stiffness, self.mass)
            new = self._pairs(self._lanczos(ask, shift, pairs.shapes), shift)
            pairs = Pairs(*map(np.concatenate, zip(pairs, new, strict=True)))
            pairs = pairs.of(np.argsort(pairs.values, kind="stable"))
            tries += 1
            logger.debug("search %d: %d eigenvalues, shift %.4g", tries, len(pairs.values), shift)
            cut = gap_or_group(pairs.values, max(n, int((pairs.values <= 0).sum())), tries)
            if cut is None:
                ask = max(2, len(pairs.values) // 2)
                continue
            at = 0.5 * float(pairs.values[cut - 1] + pairs.values[cut])
            counted = self._below(at)
            stuck = stuck + 1 if counted - cut >= lost else 0
            lost = counted - cut
            if lost <= 0 or stuck == TRIES:
                pairs = self._bounded(pairs, shift, at)
                if (pairs.errors <= pairs.allowed).all() or not shift or searched_again:
                    return pairs, cut, count_check(cut, counted, f"below {at:.6g}")
                # Beside motions without stiffness, so near the shift, others have few digits: all again from farther away.
                shift, searched_again = -float(pairs.values[pairs.values > 0][0]), True
                pairs, ask, lost, stuck = pairs.of(slice(0)), cut + 1, room, 0
            else:
                ask = lost + 1
            self.motions.factor(self.stiffness + (-shift) * self.mass)
        pairs, all_of_them = self._dense()
        cut = gap_after(pairs.values, n) or all_of_them
        return pairs, cut, count_check(len(pairs.values), all_of_them, "of all coordinates")

    def _below(self, at: float) -> int:
        """Number of eigenvalues below a number, as many negative pivots as K - s M has."""
        self.motions.factor(self.stiffness + (-at) * self.mass)
        return self.motions.negative_pivots

    def _pairs(self, shapes: np.ndarray, shift: float) -> Pairs:
        r"""Shapes with their eigenvalues; the factors are those at the shift.

        With :math:`A = K - \sigma M` and the residual r, some eigenvalue :math:`\lambda^*` is as near as
        :math:`|\lambda - \lambda^*| \le |\lambda^* - \sigma| \, \|A^{-1} r\|_M`.
        """
        values, shapes, noise = self._clean(shapes)
        scale = _scale(values, shift)
        errors = self._errors(values, shapes, shift) / scale
        return Pairs(values, shapes, errors, SAFETY * self.tolerance + noise / scale)

    def _errors(self, values: np.ndarray, shapes: np.ndarray, shift: float) -> np.ndarray:
        """Those bounds, (m,), with the factors, which are those at the shift."""
        pairs = zip(values, shapes, strict=True)
        found = (self.motions.correction(self.stiffness @ v - value * (self.mass @ v), v) for value, v in pairs)
        sizes, more = np.array([(self._size(moved), change) for moved, change in found]).reshape(-1, 2).T
        return np.asarray(sizes * np.abs(values - shift) + more)

    def _bounded(self, pairs: Pairs, shift: float, at: float) -> Pairs:
        """A second bound, with the factors at a higher number, for pairs that the first one does not show to be right: near
        the shift it takes a trace of a rigid motion in an elastic one for much."""
        k = np.flatnonzero(~(pairs.errors <= pairs.allowed))
        errors, values = pairs.errors.copy(), pairs.values[k]
        second = self._errors(values, pairs.shapes[k], at)
        errors[k] = np.fmin(errors[k], second / _scale(values, shift))
        return pairs._replace(errors=errors)

    def _size(self, v: np.ndarray) -> float:
        return float(np.sqrt(v @ self.with_mass(v)))

    def _lanczos(self, n: int, shift: float, known: np.ndarray) -> np.ndarray:
        """Shapes (n, n_dofs) of the eigenvalues nearest to the shift, besides the known ones."""

        def apart(v: np.ndarray) -> np.ndarray:
            return v - known.T @ (known @ self.with_mass(v))

        solve = self.bar.counting(self.motions.solve, f"solves for {n} modes")
        start = self.with_mass(np.random.default_rng(len(known)).standard_normal(self.mass.shape[0]))
        weight = LinearOperator(self.mass.shape, matvec=self.with_mass, dtype=np.float64)
        # In shift-and-invert mode the first operator is not used.
        return lanczos(
            weight, k=n, M=weight, sigma=shift, v0=apart(solve(start)), tol=self.tolerance,
            OPinv=LinearOperator(self.mass.shape, matvec=lambda v: apart(solve(v)), dtype=np.float64),
            ncv=min(self.motions.room, max(2 * n + 1, 20)),
        )[1]  # fmt: skip

    def _dense(self) -> tuple[Pairs, int]:
        """All, and how many there are, for nearly as many modes as coordinates, where Lanczos' method has no room."""
        free = self.motions.directions()
        stiffness, mass = (free @ matrix.to_scipy() @ free.T for matrix in (self.stiffness, self.mass))
        values, shapes, noise = self._clean(eigh(stiffness, mass)[1].T @ free)
        order = np.argsort(values, kind="stable")
        values, shapes, noise = values[order], shapes[order], noise[order]
        parts = shapes @ free.T
        residuals = stiffness @ parts.T - mass @ parts.T * values
        errors = np.sqrt(np.maximum((residuals * np.linalg.solve(mass, residuals)).sum(axis=0), 0.0))
        scale = np.maximum(np.abs(values), TINY)
        # Full matrices have the rounding of their largest eigenvalue in all.
        rounding = np.maximum(noise, ZERO_EIGENVALUE * np.abs(values).max())
        return Pairs(values, shapes, errors / scale, SAFETY * self.tolerance + rounding / scale), len(free)

    def _clean(self, shapes: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Values, zero where they are rounding, shapes of unit modal mass on the free coordinates, and that rounding."""
        shapes = np.array([self._normalised(self.constraints.free_part(v)) for v in shapes]).reshape(shapes.shape)
        values = np.array([2 * self.stiffness.energy(v) for v in shapes])
        noise = np.array([self.stiffness.rounding(v, ZERO_EIGENVALUE) for v in shapes])
        return np.where(np.abs(values) <= noise, 0.0, values), shapes, noise

    def _normalised(self, v: np.ndarray) -> np.ndarray:
        return v / np.sqrt(v @ self.with_mass(v)) * np.sign(v[np.argmax(np.abs(v))])

    def with_mass(self, v: np.ndarray) -> np.ndarray:
        return self.constraints.free_part(self.mass @ self.constraints.free_part(v))


def _scale(values: np.ndarray, shift: float) -> np.ndarray:
    """To what errors of eigenvalues are relative: their size, of zero ones that of the shift."""
    return np.maximum(np.where(values == 0, abs(shift), np.abs(values)), TINY)


def lanczos(matrix: LinearOperator, **options: Any) -> tuple[np.ndarray, np.ndarray]:
    """Eigenvalues (k,) and eigenvectors (k, n) by scipy's ``eigsh``, or :class:`~skancf.DidNotConverge`."""
    try:
        values, vectors = eigsh(matrix, **options)
    except ArpackNoConvergence as none:
        raise DidNotConverge(
            f"Lanczos' method found {len(none.eigenvalues)} of {options['k']} eigenvalues; ask for fewer, or allow a larger "
            f"tolerance than {options['tol']}"
        ) from none
    except ArpackError as broken:
        raise DidNotConverge(f"Lanczos' method broke down ({broken}): stiffness or mass is zero to rounding, or too large; "
                             "give the problem in units in which its numbers are of moderate size") from broken  # fmt: skip
    return values, vectors.T


def checked_count(n: int, constraints: Constraints) -> int:
    """n as a whole number from one to the number of free coordinates, or InputError."""
    n = whole("n", n, floats=True)
    if n > constraints.n_free:
        raise InputError(f"n = {n}: give a whole number of modes, at most the {constraints.n_free} free coordinates")
    # Lanczos' method keeps two vectors for each mode and one more; without room for it all are found.
    each = 3 * constraints.fixed.size if 2 * (n + 1) < constraints.n_free else 4 * constraints.n_free
    require_much(8 * n * each, f"n = {n} modes of {constraints.fixed.size} unknowns", "their shapes", "ask for fewer")
    return n


def check_tolerance(tolerance: float) -> float:
    """InputError for what is no relative accuracy of eigenvalues, from zero (rounding) to less than one."""
    checked = number("tolerance", tolerance)
    if not 0 <= checked < 1:
        raise InputError(f"tolerance = {tolerance}: give the relative accuracy of the eigenvalues, less than one")
    return checked
