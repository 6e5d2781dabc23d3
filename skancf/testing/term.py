"""Checks of terms of one's own, on demand.

A term with a force that is not the derivative of its energy, or a tangent that is not that of its force, seldom fails:
Newton's method converges slowly, or to the wrong answer. :func:`check_term` finds it by differences, and says where.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from skancf.arguments import having, whole
from skancf.conditions.check import STEPS
from skancf.errors import InputError, finite, positive
from skancf.history import Case
from skancf.kernels.constants import AXES, BLOCK
from skancf.linear import BlockMatrix, BlockPattern
from skancf.problem import Problem
from skancf.system import System
from skancf.terms.blocks import Blocks, SkewBlocks
from skancf.terms.own import check_cells, check_energy, check_force
from skancf.testing.shared import CASE, Report, blamed, mesh_of, pair, pattern_of, rotated, states_about
from skancf.tolerances import ROUNDED_FORCE, ROUNDED_VALUE, SAME_VALUE
from skancf.vectors import rotation

VECTORS = ("r", "r_x", "r_y", "the fourth vector")


class WrongTerm(InputError, AssertionError):
    """A term that contradicts itself; the message says where, and by how much."""


def check_term(
    term: Any, system: Any, *, states: Sequence[np.ndarray] | None = None, amount: float = 0.01, tolerance: float = 1e-6,
    mesh: Any = None, theory: Any = "full", seed: int = 0,
) -> Report:  # fmt: skip
    """Check that a term's energy, force, tangent and matrices belong together.

    Parameters
    ----------
    term : Addition or Term
        As a problem is given it, for example a :class:`~skancf.FormTerm`; or one that is on a system already.
    system : System or Problem
        Where it acts. A problem is put on a mesh, by default one of 3 x 4 elements.
    states : sequence of (n_dofs,) arrays, optional
        Where to check. Default: one near the undeformed state, and one turned by two radians.
    amount : float
        How far those are from a rigid body, in the sizes of the unknowns.
    tolerance : float
        Relative difference that is an error.
    mesh, theory
        For a problem.
    seed : int
        Of the random directions.

    Returns
    -------
    Report

    Raises
    ------
    InputError
        Where force is not the derivative of energy, tangent and damping are not those of force, a force between two states
        does other work than the energy, mass is not symmetric and positive, a load does not count with the load factor,
        what is remembered does not come back, or shapes and blocks are not those of the layout. The error is an
        AssertionError, too.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(sk.Rectangle(1.0, 1.0), 0.01, steel)
    >>> report = sk.testing.check_term(sk.FormTerm(energy=lambda w: 0.5 * 1e6 * w.u[2] ** 2), plate)
    >>> print(len(report.errors) > 0)
    True
    """
    system, tolerance = _system(term, system, mesh, theory), positive("tolerance", tolerance)
    bound = term if hasattr(term, "force") else term.on(system.shell, system.layout)
    having("term", bound, ("couples", "force", "add_tangent", "energy"), "a Term, or an Addition whose on() returns one")
    rng = np.random.default_rng(whole("seed", seed, least=0))
    check = _Check(bound, system, tolerance, rng, Report())
    check.blocks()
    found = states if states is not None else list(states_about(system.layout, positive("amount", amount), rng))
    for q in (finite("state", each) for each in found):
        if q.shape != (system.n_dofs,):
            raise InputError(f"a state of shape {q.shape}: this system has {system.n_dofs} unknowns")
        check.at(q)
    check.between(*pair(system.layout, found, rng))
    check.mass()
    check.rigid(found[0])
    return check.report


def _system(term: Any, given: Any, mesh: Any, theory: Any) -> Any:
    if isinstance(given, Problem):
        problem = given if hasattr(term, "force") or term in given.terms else replace(given, terms=(*given.terms, term))
        return problem.on(mesh_of(problem, mesh), theory)
    having("system", given, ("layout", "shell", "terms"), "a system or a problem")
    return given


class _Check:
    """One term on one system."""

    def __init__(self, term: Any, system: System, tolerance: float, rng: np.random.Generator, report: Report) -> None:
        self.term, self.system, self.tolerance, self.rng, self.report = term, system, tolerance, rng, report
        self.n, self.layout = system.n_dofs, system.layout

    @cached_property
    def _pattern(self) -> BlockPattern:
        return pattern_of(self.system, self.term)

    def blocks(self) -> None:
        """The cells are blocks of the layout, each once."""
        cells = self.term.couples()
        with blamed(WrongTerm):
            check_cells(cells, self.layout)
        ordered = np.sort(cells, axis=1)
        twice = (ordered[:, 1:] == ordered[:, :-1]).any(axis=1)
        if twice.any() and cells is not self.system.shell.cells:
            cell = int(np.argmax(twice))
            raise WrongTerm(f"couples(): blocks overlap, cell {cell} is {cells[cell].tolist()}; name each block of a cell "
                            "once")  # fmt: skip

    def at(self, q: np.ndarray) -> None:
        """Everything at one state."""
        v = self.layout.scales.ravel() * self.rng.uniform(-1, 1, self.n)
        force, energy = self._force(q, v), self._energy(q)
        if energy is not None:
            self._check_force(q, self._force(q, None))
        self._check_tangent(q, v, energy is not None)
        self._check_load(q, v, force)
        self._check_state(q, v, force)

    def _force(self, q: np.ndarray, v: np.ndarray | None, case: Case = CASE) -> np.ndarray:
        force = np.asarray(self.term.force(q.copy(), None if v is None else v.copy(), case))
        with blamed(WrongTerm):
            check_force(force, self.n)
        return force

    def _energy(self, q: np.ndarray) -> float | None:
        energy = self.term.energy(q.copy(), CASE)
        with blamed(WrongTerm):
            check_energy(energy)
        return None if energy is None else float(energy)

    def _way(self) -> np.ndarray:
        return np.asarray(self.layout.scales.ravel() * self.rng.uniform(-1, 1, self.n))

    def _check_force(self, q: np.ndarray, force: np.ndarray) -> None:
        way = self._way()
        size = np.abs(force) @ np.abs(way)
        error = _best(lambda h: self._slope(q, h * way) / h - force @ way)
        self._judge("force against energy", error, size, lambda: self._worst_force(q, force))

    def _slope(self, q: np.ndarray, step: np.ndarray) -> float:
        """Half of the change of the energy over two steps."""
        up, down = (self._energy(q + sign * step) or 0.0 for sign in (1, -1))
        return 0.5 * (up - down)

    def _worst_force(self, q: np.ndarray, force: np.ndarray) -> str:
        scales, unit = self.layout.scales.ravel(), np.zeros(self.n)
        differences = np.empty(self.n)
        for k in range(self.n):
            unit[k] = 1e-5 * scales[k]
            differences[k] = self._slope(q, unit) / unit[k]
            unit[k] = 0.0
        where = self._where((force - differences) * scales, differences, force)
        return f"{where}; look at signs, at factors of two, and at parts of the energy that the force does not have"

    def _where(self, wrong: np.ndarray, wanted: np.ndarray, found: np.ndarray) -> str:
        k = int(np.argmax(np.abs(wrong)))
        block, place = divmod(k, BLOCK)
        part = next(part for part in self.layout.parts if self.layout.part(part.name).stop > block)
        at = ", ".join(f"{each:.4g}" for each in self.layout.places[block])
        vector = VECTORS[place // AXES] if part.name == self.system.shell.name else f"vector {place // AXES}"
        return (f"worst at block {block} of part {part.name!r}, near ({at}), component {'xyz'[place % AXES]} of {vector}: "
                f"{found[k]:.6g} where the difference is {wanted[k]:.6g}")  # fmt: skip

    def _judge(self, what: str, error: float, size: float, where: Callable[[], str], tolerance: float | None = None) -> None:
        relative = error / size if size > 0 else error
        self.report.add(what, float(relative))
        if not relative <= (self.tolerance if tolerance is None else tolerance):
            raise WrongTerm(f"{what}: they differ by {relative:.1e} of their size; {where()}")

    def _matrices(self, add: Callable[[Any], None]) -> tuple[BlockMatrix, Any]:
        """The symmetric and the skew part of what the term adds."""
        symmetric, skew = Blocks(self._pattern), SkewBlocks(self._pattern)
        for blocks in (symmetric, skew):
            add(blocks)
        return symmetric.matrix(), skew.skew_matrix()

    def _check_tangent(self, q: np.ndarray, v: np.ndarray, has_energy: bool) -> None:
        skewed = self._check_derivative("tangent", q, v, (1.0, 0.0))
        self._check_derivative("damping", q, v, (0.0, 1.0))
        if has_energy:
            self._judge("skew part of the tangent of an energy", skewed, 1.0, lambda: "second derivatives of an energy are "
                        "symmetric; look at the order of rows and columns")  # fmt: skip

    def _check_derivative(self, name: str, q: np.ndarray, v: np.ndarray, of: tuple[float, float]) -> float:
        """A matrix against differences of the force along changes of q or of v; how much of it is skew."""
        matrix, skew = self._matrices(lambda blocks: getattr(self.term, f"add_{name}")(q, v, CASE, blocks))
        way, scales = self._way(), self.layout.scales.ravel()
        product = matrix @ way + (0.0 if skew is None else skew @ way)
        wrong = []
        for h in STEPS:
            up, down = (self._force(q + sign * h * of[0] * way, v + sign * h * of[1] * way) for sign in (1, -1))
            wrong.append(((up - down) / (2 * h) - product) * scales)
        best = min(wrong, key=lambda row: float(np.abs(row).max()))
        size = max(np.abs(product * scales).max(), ROUNDED_FORCE * np.abs(self._force(q, v) * scales).max() / STEPS[0])
        self._judge(f"{name} against force", float(np.abs(best).max()), float(size),
                    lambda: self._worst_row(name, best, product))  # fmt: skip
        return _part(skew, matrix)

    def _worst_row(self, name: str, wrong: np.ndarray, product: np.ndarray) -> str:
        scales = self.layout.scales.ravel()
        where = self._where(wrong, product + wrong / scales, product)
        block = int(np.argmax(np.abs(wrong))) // BLOCK
        if block not in self.term.couples():
            return f"{where}; that block is in no cell of couples(), and what a term adds elsewhere is left out"
        return f"{where} along a random direction; look at factors, at parts that add_{name} leaves out, and at its blocks"

    def _check_load(self, q: np.ndarray, v: np.ndarray, force: np.ndarray) -> None:
        if not self.term.load:
            return
        twice = self._force(q, v, Case(2 * CASE.factor, CASE.time))
        self._judge("load against load factor", float(np.abs(twice - 2 * force).max()), float(np.abs(force).max()),
                    lambda: "twice the factor is not twice the force; multiply by case.amplitude(history)")  # fmt: skip

    def _check_state(self, q: np.ndarray, v: np.ndarray, force: np.ndarray) -> None:
        self.term.restore(self.term.state())
        again = self._force(q, v)
        self._judge("force after restore(state())", float(np.abs(again - force).max()), float(np.abs(force).max()),
                    lambda: "another force in the same state; keep in state() all that the force depends on")  # fmt: skip

    def between(self, q0: np.ndarray, q1: np.ndarray) -> None:
        """The force between two states does the work of the energy."""
        force = self.term.between(q0.copy(), q1.copy(), CASE)
        if force is None:
            return
        energies = [self._energy(q) for q in (q0, q1)]
        if energies[0] is None or energies[1] is None:
            raise WrongTerm("between() gives a force, and energy() None: there is no energy whose work it could do")
        if np.shape(force) != (self.n,):
            raise WrongTerm(f"between(): of shape {np.shape(force)}; give {self.n} numbers, one for each unknown")
        change, work = energies[1] - energies[0], float(force @ (q1 - q0))
        error = max(0.0, abs(work - change) - ROUNDED_VALUE * abs(energies[1]))
        self._judge("work between two states against energy", error, float(np.abs(force) @ np.abs(q1 - q0)),
                    lambda: f"it does the work {work:.9g}, and the energy changes by {change:.9g}", SAME_VALUE)  # fmt: skip

    def mass(self) -> None:
        """Mass and constant damping are symmetric, mass has no negative part."""
        for name in ("mass", "viscous"):
            matrix, skew = self._matrices(getattr(self.term, f"add_{name}"))
            if skew is not None:
                self._judge(f"skew part of the {name} matrix", _part(skew, matrix), 1.0, lambda: "it must be symmetric")
            values = matrix.to_scipy()
            if name == "mass" and values.nnz and abs(values).max() > 0:
                self._check_positive(values)

    def _check_positive(self, matrix: Any) -> None:
        used = np.flatnonzero(np.asarray(abs(matrix).sum(axis=0)).ravel())
        if used.size > MOST_EIGENVALUES:
            lowest = min(float(x @ (matrix @ x)) / float(x @ x) for x in self.rng.normal(size=(20, self.n)))
        else:
            scales = self.layout.scales.ravel()[used]
            lowest = float(np.linalg.eigvalsh(scales[:, None] * matrix[used][:, used].toarray() * scales)[0])
        scales = self.layout.scales.ravel()
        size = float((np.abs(matrix.diagonal()) * scales**2).max())
        self._judge("negative part of the mass", max(0.0, -lowest), size,
                    lambda: "its kinetic energy is negative in some motion; integrate it with more points")  # fmt: skip

    def rigid(self, q: np.ndarray) -> None:
        """Whether rigid motions leave the energy as it is."""
        energy = self._energy(q)
        if energy is None:
            return
        turned = rotated(self.layout, np.reshape(q, self.layout.undeformed.shape), rotation(np.array([0.01, 0.02, -0.015])))
        turned[self.layout.moving, 0] += 0.01 * self.layout.scales[0, 0]
        try:
            after = self._energy(turned.ravel()) or 0.0
        except InputError:
            return
        change = np.abs(self._force(q, None)) @ np.abs(turned.ravel() - q)
        self.report.unchanged = bool(abs(after - energy) <= SAME_VALUE * max(abs(energy), change))


MOST_EIGENVALUES = 1500


def _part(skew: Any, matrix: BlockMatrix) -> float:
    """How large the skew part is against the other."""
    if skew is None:
        return 0.0
    largest = float(abs(skew).max())
    return largest / max(largest, float(np.abs(matrix.values).max()))


def _best(error: Callable[[float], float]) -> float:
    return min(abs(error(h)) for h in STEPS)
