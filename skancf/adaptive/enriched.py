r"""A state in a richer space: every element quartered, one linear step, and where that step comes from.

With the residual R and the tangent K of the refined system at the transferred state, the step :math:`\delta = -K^{-1} R`
leads to the solution of the refined system, in linear problems exactly. What a quantity changes on the way is the estimate
of its error. The residual vanishes on what the coarse mesh can do; the rest of a weight z is its surplus
:math:`z - P I z` over its nodal interpolant, which lives in the bubbles of elements and edges.
"""

import logging
from dataclasses import dataclass
from functools import cached_property
from types import TracebackType
from typing import Any

import numpy as np

from skancf.adaptive.blunt import NOWHERE, Blunt
from skancf.adaptive.energies import Strained, energies, virtual_work
from skancf.adaptive.grow import SMALLEST, SMALLEST_LARGE
from skancf.adaptive.interpolation import multipliers_on
from skancf.adaptive.refined import Refined
from skancf.errors import DidNotConverge, InputError
from skancf.history import Case
from skancf.linear import BlockMatrix, DirectSolver
from skancf.meshes import MeshQuadTree
from skancf.solution import Solution
from skancf.solving import End, Status, iterate
from skancf.statics.conditioned import Tangent, curved, factored_about, rows_of, solved
from skancf.statics.corrections import NONE, skew_part
from skancf.statics.equilibrium import equilibrium
from skancf.statics.newton import newton, refusal
from skancf.statics.stopping import work
from skancf.tolerances import CANCELLED, ROUNDED_ROW

logger = logging.getLogger(__name__)

CHORDS = 6
"""Steps with one tangent before Newton's method takes over."""
NEAR = 1e-4
"""A correction of this size, in energy norm relative to the first, is the last one."""


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
    multipliers : (n,) array
        Of the conditions of the refined system: the same forces; none without conditions.
    residual : (n_fine,) array
        With those.
    stiffness : BlockMatrix
        Tangent of the refined system there; where Newton's method had to go far, at its solution.
    """

    def __init__(
        self, state: Solution, mesh: MeshQuadTree | None = None, quantity: Any = None, backend: str = "auto",
        blunt: Blunt = NOWHERE,
    ) -> None:  # fmt: skip
        _require_at_rest(state)
        super().__init__(state.system, mesh, quantity, SMALLEST if state.linear else SMALLEST_LARGE, blunt)
        self.state, self._backend = state, backend
        self.model = type(state.model)(self.system)
        self.start, self.multipliers = self._up.unknowns(state), multipliers_on(state, self.system)
        self.residual = self.residual_of(self.start, self.multipliers)
        if beyond := refusal(self.system):
            raise DidNotConverge(f"the error is estimated on a finer mesh, and there {beyond}; find the answer on a "
                                 "finer mesh")  # fmt: skip
        self.stiffness = self._tangent_at(self.start)
        self._moved = self.system.constraints.fixed_part(self.model.held(state.load_factor) - self.start)

    @cached_property
    def _direct(self) -> DirectSolver:
        return DirectSolver(self.system.pattern, self.system.constraints, self._backend)

    def _factored(self, x: np.ndarray) -> Tangent:
        """By the stiffness, which belongs to unknowns x."""
        skew = skew_part(self.model, x, self.state.load_factor)
        return factored_about(self.system, self._direct, self.stiffness, skew, self.model.about(x))

    @cached_property
    def _answer(self) -> tuple[np.ndarray, np.ndarray]:
        """The step (n_fine,) to the solution of the refined system, and the multipliers (n,) there: by one tangent, or by
        Newton's method where its corrections do not shrink fast; leaves the factors of a tangent there."""
        moved, n = self._moved, self.start.size
        self._tangent = tangent = self._factored(self.start)
        open_rows = self.missed(self.start) + rows_of(tangent, moved)
        change, more, _ = solved(tangent, -(self.residual + tangent.multiply(moved)), -open_rows)
        first, pulls = change + moved, self.multipliers + more
        if self.model.linear:
            return first, pulls
        criterion = _Shrinking(work(first, tangent.multiply(first)))
        chord = iterate(np.concatenate([first, pulls]), _Chord(self, tangent), criterion, CHORDS, logger)
        return (chord.x[:n], chord.x[n:]) if chord.ok else self._newton()

    @property
    def _step(self) -> np.ndarray:
        return self._answer[0]

    @property
    def unresolved(self) -> np.ndarray:
        """What is left of the residual after the step, (n_fine,): rounding, and what Newton's method left."""
        step, pulls = self._answer
        if self.model.linear:  # with the digits of the step alone
            return self.residual + self.stiffness @ step + self._force(self.start, pulls - self.multipliers)
        return self.residual_of(self._end, pulls)

    @property
    def unmet(self) -> np.ndarray:
        """The same of the conditions, (n,)."""
        return self.missed(self._end)

    def residual_of(self, x: np.ndarray, multipliers: np.ndarray) -> np.ndarray:
        """At unknowns of the model, (n_fine,)."""
        model, state = self.model, self.state
        residual = model.internal_force(x, None, state.case) - state.load_factor * model.external_force(x)
        return residual + self._force(x, multipliers) if multipliers.size else residual

    def _force(self, x: np.ndarray, multipliers: np.ndarray) -> np.ndarray:
        return self.model.conditions_force(x, multipliers)

    def missed(self, x: np.ndarray) -> np.ndarray:
        """Values of the conditions at unknowns of the model, (n,)."""
        return self.model.conditions_value(x, self.state.case) if self.multipliers.size else NONE

    def _tangent_at(self, x: np.ndarray) -> BlockMatrix:
        """Of a nonlinear model with the curvature of conditions."""
        tangent = self.model.tangent(x, Case(self.state.load_factor))
        return tangent if self.model.linear else curved(self.system, tangent, x, self.multipliers)

    def _newton(self) -> tuple[np.ndarray, np.ndarray]:
        """The step and the multipliers by Newton's method, relaxed from the coarse equilibrium where that fails."""
        fine, factor, start = self.system, self.state.load_factor, self.start
        result: Any = newton(fine, start, self._direct, load_factor=factor, rtol=NEAR, multipliers=self.multipliers)
        q, pulls = result.q, result.multipliers
        if not result.ok:
            begin = Solution(fine, start, load_factor=factor, multipliers=self.multipliers)
            found = equilibrium(fine, factor, start=begin, rtol=NEAR, backend=self._direct.backend_name).unwrap()
            q, pulls = found.q, NONE if found.multipliers is None else found.multipliers
        self.stiffness = curved(fine, fine.tangent(q, Case(factor)), q, pulls)
        self._tangent = self._factored(q)
        return np.asarray(q) - start, pulls

    def __enter__(self) -> "Enriched":
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if "_direct" in vars(self):
            self._direct.close()

    def solve(self, force: np.ndarray) -> np.ndarray:
        """K^-1 force on the free coordinates, after the step; with conditions the motion that keeps them."""
        return self.solve_both(force)[0]

    def solve_both(self, force: np.ndarray, values: np.ndarray = NONE) -> tuple[np.ndarray, np.ndarray]:
        """The same, and the multipliers (n,) of it; the motion may also change the conditions by some values (n,)."""
        _ = self._answer
        tangent: Any = self._tangent
        if not self.multipliers.size:
            return self._direct.solve(force), NONE
        values = values if values.size else np.zeros(self.multipliers.size)
        x, pulls = tangent.symmetric().solve_both(force, values)
        return x, pulls

    def rows(self, change: np.ndarray) -> np.ndarray:
        """What a change makes of the conditions after the step, (n,)."""
        _ = self._answer
        return rows_of(self._tangent, change)

    def held_by(self, pulls: np.ndarray) -> np.ndarray:
        """The forces of multipliers (n,) after the step, (n_fine,)."""
        return self._force(self._end, pulls)

    def pulled(self, pulls: np.ndarray) -> np.ndarray:
        r"""What conditions that the interpolated state does not meet add to an estimate by the multipliers (n,) of a dual
        weight, row by row, spread over the unknowns of each: (n_fine,)."""
        if not pulls.size:
            return np.zeros(self.start.size)
        rows = abs(self.system.conditions.gradient(self.model.about(self.start)))
        sums = np.asarray(rows.sum(axis=1)).ravel()
        return np.asarray(rows.T @ (np.abs(pulls * self.missed(self.start)) / np.where(sums > 0, sums, 1.0)))

    def rounding(self, weight: np.ndarray, gradient: np.ndarray, pulls: np.ndarray = NONE) -> float:
        r"""Size of what the dual weight makes of the unresolved residual, and of the rounding of internal forces, and what
        the gradient of the quantity makes of the rounding of the coordinates themselves. ``pulls`` are the multipliers of
        the weight, by which conditions that are not quite met count.

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
        held = abs(float(pulls @ self.unmet)) if pulls.size else 0.0
        return abs(float(weight @ left)) + held + float(noise + ROUNDED_ROW * np.abs(gradient) @ np.abs(self._end))

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
        pulls = self._answer[1]
        return Solution.of(self.model, self._end, self.state.load_factor, pulls if pulls.size else None)

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
    """Steps from the start of an enriched state and multipliers, by its one tangent."""

    enriched: Enriched
    tangent: Tangent

    def residual(self, x: np.ndarray) -> np.ndarray:
        n = self.enriched.start.size
        at = self.enriched.start + x[:n]
        return np.concatenate([self.enriched.residual_of(at, x[n:]), self.enriched.missed(at)])

    def correction(self, x: np.ndarray, residual: np.ndarray) -> tuple[np.ndarray, float]:
        n = self.enriched.start.size
        change, more, _ = solved(self.tangent, -residual[:n], -residual[n:])
        return np.concatenate([change, more]), work(change, self.tangent.multiply(change))

    def step(self, x: np.ndarray, residual: np.ndarray, more: np.ndarray) -> np.ndarray:
        return x + more


@dataclass(frozen=True)
class _Shrinking:
    """Ends where corrections are small against the first, of energy ``largest``, and where they do not shrink fast."""

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
