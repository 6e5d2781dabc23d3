r"""A state in a richer space: every element quartered, one linear step, and where that step comes from.

With the residual R and the tangent K of the refined system at the transferred state, the step :math:`\delta = -K^{-1} R`
leads to the solution of the refined system, in linear problems exactly. What a quantity changes on the way is the estimate
of its error. The residual vanishes on what the coarse mesh can do; the rest of a weight z is its surplus
:math:`z - P I z` over its nodal interpolant, which lives in the bubbles of elements and edges.
"""

from dataclasses import dataclass
from functools import cached_property
from types import TracebackType
from typing import Any

import numpy as np

from skancf.adaptive.energies import Strained, energies, virtual_work
from skancf.adaptive.grow import SMALLEST, SMALLEST_LARGE, may_be_quartered
from skancf.adaptive.interpolation import Interpolation, ancestors_in
from skancf.adaptive.quantities import SectionForce
from skancf.adaptive.rings import Halvings, Pair, halvings
from skancf.adaptive.singular import images, singular_points, touching
from skancf.errors import InputError, finite
from skancf.history import Case
from skancf.layout.singularities import nodes_at
from skancf.linear import DirectSolver, SkewSolver
from skancf.materials import Section
from skancf.meshes import MeshQuadTree
from skancf.solution import Solution
from skancf.solving import End, Status, iterate
from skancf.statics.corrections import skew_part
from skancf.statics.equilibrium import equilibrium
from skancf.statics.newton import newton
from skancf.statics.stopping import work
from skancf.system.system import System
from skancf.theories import left_per_halving
from skancf.tolerances import CANCELLED, ROUNDED_ROW

AT_POLES = 1 / 4
"""Part of an error that is left on quartered elements at a pole, whose membrane strains are no assumed ones."""
AT_JUMPS, AT_ASSUMED_JUMPS = 1 / 2, 2 / 3
"""The same at a line where the membrane stiffness jumps: strains jump there, and slopes at nodes do not. Assumed membrane
strains feel it the more the finer they are, down to elements as long as the plate is thick."""
EXTRA = 4
"""Refinements beyond the first at singular points, where one halves an error that it divides by sixteen elsewhere."""
MOST = 12
"""Elements of the refined mesh per element of the mesh."""
CHORDS = 6
"""Steps with one tangent before Newton's method takes over."""
NEAR = 1e-4
"""A correction of this size, in energy norm relative to the first, is the last one."""


def enriched_mesh(system: System, points: np.ndarray, smallest: float = SMALLEST) -> Any:
    """Every element quartered, and those at singular points (2, n) :data:`EXTRA` times more."""
    mesh = system.mesh
    leaves = mesh.leaves.refined(np.arange(mesh.nelements))
    for _ in range(EXTRA):
        if len(leaves) > MOST * (mesh.nelements + MOST):
            break  # more singular points than elements
        at_points = touching(leaves, images(system.geometry, leaves, points))
        leaves = leaves.refined(at_points[may_be_quartered(leaves, system.geometry.surface, smallest / 4)[at_points]])
    return mesh.regrown(leaves)


class Refined:
    """A refined system beside a coarse one, and fields between them.

    Attributes
    ----------
    coarse, system : System
        The same problem on the mesh and on the refined one.
    points : (2, n) array
        Singular ones, of the problem and of the quantity.
    """

    def __init__(
        self, coarse: System, mesh: MeshQuadTree | None = None, quantity: Any = None, smallest: float = SMALLEST
    ) -> None:
        self.coarse, self.points, self._quantity = coarse, singular_points(coarse, quantity), quantity
        fine_mesh = enriched_mesh(coarse, self.points, smallest) if mesh is None else mesh
        self.system: System = coarse.problem.on(fine_mesh, coarse.geometry.theory)
        self._up = Interpolation.of(coarse, self.system)
        self._down = Interpolation.of(self.system, coarse)

    def halvings(self, *pairs: Pair, before: Halvings | None = None) -> Halvings:
        """What a halving leaves at the singular points of the problem, by energies of answers and weights here, and by
        ``before``, that of a coarser mesh, where there are too few rings."""
        return halvings(self.coarse, self.system, singular_points(self.coarse), pairs, before)

    def left(self, halved: Halvings) -> np.ndarray:
        """Part of what each element contributes to an error that is left on the refined mesh, (n_elements,).

        By the order of the theory, at poles :data:`AT_POLES`; at lines where the membrane stiffness jumps, and at singular
        points no less than the power of what one halving leaves there.
        """
        coarse, fine, geometry = self.coarse.mesh.leaves, self.system.mesh.leaves, self.coarse.geometry
        left = np.full(len(coarse), left_per_halving(geometry.theory))
        left[geometry.at_poles] = AT_POLES
        deepest = np.zeros(len(coarse), dtype=int)
        np.maximum.at(deepest, ancestors_in(coarse, fine), fine.cells.level)
        halved_by = deepest - coarse.cells.level
        section = self.coarse.assembly.section
        if not isinstance(section, Section):
            lines, theory = section.beside_jumps, geometry.theory
            at_lines = AT_ASSUMED_JUMPS if theory.assumed and not theory.directors else AT_JUMPS
            left[lines] = np.maximum(left[lines], at_lines ** halved_by[lines])
        there, once = halved.of(coarse, self.points)
        left[there] = np.maximum(left[there], once ** halved_by[there])
        return left

    def up(self, q: np.ndarray) -> np.ndarray:
        """Nodal coordinates of the same field on the refined mesh."""
        return self._up.field(q)

    def down(self, q: np.ndarray) -> np.ndarray:
        """Nodal coordinates on the coarse mesh of a field's interpolant."""
        return self._down.field(q)

    def surplus(self, weight: np.ndarray) -> np.ndarray:
        """What of a field on the refined mesh the coarse one cannot have, (n_fine,).

        A weight that is singular at a node has slopes and a twist there that are those of the smallest element, and say
        nothing of larger ones: its interpolant has none.
        """
        coarse = self.coarse.layout.nodal(self.down(weight))
        coarse[self._at_quantity, 1:] = 0.0
        return weight - self.up(coarse.ravel())

    @cached_property
    def _at_quantity(self) -> np.ndarray:
        """Coarse nodes at the point of a section force, at most one."""
        if not isinstance(self._quantity, SectionForce) or self._quantity.at is None:
            return np.empty(0, dtype=int)
        geometry = self.coarse.geometry
        return nodes_at(geometry, geometry.within(finite("at", self._quantity.at)[:, None]))

    def shares(self, products: np.ndarray) -> np.ndarray:
        """Sizes of products (n_fine,) of residual and weight, node by node, shared among the coarse elements there."""
        geometry = self.system.geometry
        sizes = np.abs(self.system.layout.blocks(products)[: geometry.n_nodes].sum(axis=1))
        nodes = geometry.ties.node_of[geometry.mesh.t]
        valence = np.bincount(nodes[nodes >= 0], minlength=len(sizes))
        parts = np.where(nodes >= 0, (sizes / np.maximum(valence, 1))[nodes], 0.0).sum(axis=0)
        coarse = self.coarse.mesh
        return np.bincount(ancestors_in(coarse.leaves, geometry.mesh.leaves), parts, minlength=coarse.nelements)

    def is_new(self) -> np.ndarray:
        """Which nodes of the refined mesh the coarse one does not have, (n_fine_blocks,)."""
        fine, coarse = self.system.geometry, self.coarse.geometry
        old = coarse.mesh.leaves.forest.point_keys(coarse.mesh.leaves.cells).ravel()
        new = fine.mesh.leaves.forest.point_keys(fine.mesh.leaves.cells).ravel()
        out = np.zeros(self.system.layout.n_blocks, dtype=bool)
        out[fine.ties.node_of[fine.mesh.t.ravel()[~np.isin(new, old)]]] = True
        return out


class Enriched(Refined):
    """A state on the refined system, with factors of its tangent; a context manager, which gives their memory back.

    Attributes
    ----------
    state : Solution
        On the coarse mesh.
    model : Model
        Of the refined system, as that of the state.
    start : (n_fine,) array
        The state's unknowns there.
    residual : (n_fine,) array
    stiffness : BlockMatrix
        Tangent of the refined system there; where Newton's method had to go far, at its solution.
    """

    def __init__(
        self, state: Solution, mesh: MeshQuadTree | None = None, quantity: Any = None, backend: str = "auto"
    ) -> None:
        _require_at_rest(state)
        super().__init__(state.system, mesh, quantity, SMALLEST if state.linear else SMALLEST_LARGE)
        self.state, self._backend = state, backend
        self.model = type(state.model)(self.system)
        self.start = self._up.unknowns(state)
        self.residual, self.stiffness = self.residual_of(self.start), self.model.tangent(self.start, Case(state.load_factor))
        self._moved = self.system.constraints.fixed_part(self.model.held(state.load_factor) - self.start)

    @cached_property
    def _solver(self) -> DirectSolver:
        return DirectSolver(self.system.pattern, self.system.constraints, self._backend)

    @cached_property
    def _step(self) -> np.ndarray:
        """To the solution of the refined system, by one tangent, or by Newton's method where its corrections do not shrink
        fast; leaves the factors of a tangent there in the solver."""
        moved = self._moved
        self._solver.factor(self.stiffness)
        tangent = SkewSolver(self.stiffness, skew_part(self.model, self.start, self.state.load_factor), self._solver)
        first = tangent.solve(-(self.residual + tangent.multiply(moved))) + moved
        if self.model.linear:
            return first
        chord = iterate(first, _Chord(self, tangent), _Shrinking(work(first, tangent.multiply(first))), CHORDS)
        return chord.x if chord.ok else self._newton() - self.start

    @property
    def unresolved(self) -> np.ndarray:
        """What is left of the residual after the step, (n_fine,): rounding, and what Newton's method left."""
        if self.model.linear:  # with the digits of the step alone
            return self.residual + self.stiffness @ self._step
        return self.residual_of(self._end)

    def residual_of(self, x: np.ndarray) -> np.ndarray:
        """At unknowns of the model, (n_fine,)."""
        return self.model.internal_force(x) - self.state.load_factor * self.model.external_force(x)

    def _newton(self) -> np.ndarray:
        """Coordinates of the refined equilibrium by Newton's method, relaxed from the coarse one where that fails."""
        fine, factor = self.system, self.state.load_factor
        result: Any = newton(fine, self.start, self._solver, load_factor=factor, rtol=NEAR)
        q = result.q
        if not result.ok:
            start = Solution(fine, self.start, load_factor=factor)
            q = equilibrium(fine, factor, start=start, rtol=NEAR, backend=self._solver.backend_name).unwrap().q
        self.stiffness = fine.tangent(q, Case(factor))
        self._solver.factor(self.stiffness)
        return np.asarray(q)

    def __enter__(self) -> "Enriched":
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if "_solver" in vars(self):
            self._solver.close()

    def solve(self, force: np.ndarray) -> np.ndarray:
        """K^-1 force on the free coordinates, after the step."""
        return self._solver.solve(force)

    def rounding(self, weight: np.ndarray, gradient: np.ndarray) -> float:
        r"""Size of what the dual weight makes of the unresolved residual, and of the rounding of internal forces, and what
        the gradient of the quantity makes of the rounding of the coordinates themselves.

        The rest that Newton's method left has a direction, and cancels in parts as the residual does; rounding has none.
        That of products by strains is in equilibrium in each element, and does work on the strains of the weight only, no
        more than :math:`2 \epsilon \sqrt{U(u) U(z)}`.
        """
        stiffness, change = self.stiffness, self._change
        left = self.system.constraints.free_part(self.unresolved)
        if stiffness.form is not None:
            noise = 2 * ROUNDED_ROW * np.sqrt(abs(stiffness.energy(change) * stiffness.energy(weight)))
        else:
            noise = ROUNDED_ROW * np.abs(weight) @ self.system.constraints.free_part(stiffness.sizes() @ np.abs(change))
        return abs(float(weight @ left)) + float(noise + ROUNDED_ROW * np.abs(gradient) @ np.abs(self._end))

    def scale(self, smooth: np.ndarray, weight: Strained, answer: Strained) -> float:
        r"""Sum of the sizes of what makes a quantity, the work of the answer's stresses on the strains of the dual weight in
        the elements,

        .. math:: S = \sum_K \Bigl| \int_K \sigma(u) : \varepsilon(z) \Bigr| .

        But no less than a millionth of the most that it could be, :math:`2 \sqrt{U(u)\, U(z)}` or
        :math:`\sum_i |\lambda z_i|\, |F_i|`: where nothing contributes, as to the membrane force of a bent flat plate,
        rounding is judged by that.
        """
        system, factor = self.system, abs(self.state.load_factor)
        force = self.model.external_force(self._end)
        sizes = [np.linalg.norm(system.layout.nodal(v), axis=2) for v in (smooth, force)]
        most = [2 * np.sqrt(energies(answer).sum() * energies(weight).sum()), factor * (sizes[0] * sizes[1]).sum()]
        return max(float(np.abs(virtual_work(answer, weight)).sum()), CANCELLED * float(max(most)))

    @property
    def corrected(self) -> Solution:
        """The state after that step."""
        return Solution.of(self.model, self._end, self.state.load_factor)

    @property
    def _end(self) -> np.ndarray:
        """The unknowns after the step."""
        return self.start + self._step

    @property
    def _change(self) -> np.ndarray:
        """From the undeformed state to that after the step."""
        return self.model.change(self.start) + self._step

    def free_diagonal(self) -> np.ndarray:
        """The diagonal blocks of the tangent in nodal coordinates, one where they are held, (n_fine_nodes, 12, 12)."""
        pattern, constraints = self.system.pattern, self.system.constraints
        blocks = self.stiffness.values[pattern.diagonal_slots].copy()
        upper = np.triu(np.ones(blocks.shape[1:], dtype=bool))
        blocks = np.where(upper, blocks, blocks.swapaxes(1, 2))
        frames = np.broadcast_to(np.eye(blocks.shape[1]), blocks.shape).copy()
        frames[constraints.frame_nodes] = constraints.frames
        turned = frames @ blocks @ frames.swapaxes(1, 2)
        free = ~constraints.fixed
        turned *= free[:, :, None] & free[:, None, :]
        held = (~free).astype(float) * np.abs(blocks).max(axis=(1, 2))[:, None]
        turned += np.einsum("ni,ij->nij", held, np.eye(blocks.shape[1]))
        return frames.swapaxes(1, 2) @ turned @ frames


@dataclass(frozen=True)
class _Chord:
    """Steps from the start of an enriched state, by its one tangent."""

    enriched: Enriched
    tangent: SkewSolver

    def residual(self, step: np.ndarray) -> np.ndarray:
        return self.enriched.residual_of(self.enriched.start + step)

    def correction(self, step: np.ndarray, residual: np.ndarray) -> tuple[np.ndarray, float]:
        more = self.tangent.solve(-residual)
        return more, work(more, self.tangent.multiply(more))

    def step(self, step: np.ndarray, residual: np.ndarray, more: np.ndarray) -> np.ndarray:
        return step + more


@dataclass(frozen=True)
class _Shrinking:
    """Ends where corrections are small beside the first, of energy ``largest``, and where they do not shrink fast."""

    largest: float

    def assess(self, step: np.ndarray, more: np.ndarray, energies: list[float]) -> End | None:
        size, last = energies[-1], energies[-2] if len(energies) > 1 else np.inf
        if size <= NEAR**2 * self.largest:
            return Status.CONVERGED, ""
        return None if size < last / 4 else (Status.DIVERGED, "")


def _require_at_rest(state: Solution) -> None:
    if not isinstance(state.system.mesh, MeshQuadTree):
        raise InputError("the error is estimated on a refined mesh, and this one cannot be refined: make it by "
                         "sk.meshes.quadtree(mesh, surface)")  # fmt: skip
    if state.velocity is not None or state.time is not None:
        raise InputError("the error is that of an equilibrium, and this is a state of a motion, whose inertia is no load; "
                         "give an answer of solve or solve_linear")  # fmt: skip
