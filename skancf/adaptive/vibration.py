"""Eigenfrequencies as quantities of interest."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from skancf.adaptive.analysis import Answer, StaticAnalysis
from skancf.adaptive.energies import energies, small
from skancf.adaptive.enriched import Enriched
from skancf.adaptive.estimate import Estimate
from skancf.adaptive.grow import SMALLEST
from skancf.adaptive.quantities import StrainEnergy
from skancf.adaptive.refined import Refined
from skancf.adaptive.rings import NOTHING_KNOWN, Halvings
from skancf.adaptive.theory_error import TheoryError, of_eigenvalue
from skancf.arguments import flag, whole
from skancf.conditions.solver import solver_at
from skancf.errors import InputError
from skancf.kernels.constants import FOURTH
from skancf.linear import BlockMatrix, DirectSolver, factor_shifted
from skancf.solution import Solution
from skancf.statics.conditioned import rows_of, solved
from skancf.statics.eigen_checks import require_checks
from skancf.statics.modes import Modes, modes
from skancf.statics.shapes import moved_along
from skancf.statics.tangents import state_tangent
from skancf.system.system import System


@dataclass(frozen=True)
class Eigenfrequency:
    """An eigenfrequency (Hz).

    Parameters
    ----------
    number : int
        From 0 on, motions without stiffness (those of a free body) not counted.
    loaded : bool
        About the equilibrium under the problem's loads, instead of the undeformed state.

    Raises
    ------
    InputError
        For a number that is no whole number of at least 0.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> result = sk.adapt(plate, sk.Eigenfrequency(), rtol=1e-2)
    >>> print(f"{result.value:.1f} Hz")
    89.8 Hz
    """

    number: int = 0
    loaded: bool = False

    unit = "Hz"

    def __post_init__(self) -> None:
        whole("number", self.number, least=0)
        flag("loaded", self.loaded)

    def analysis(self, statics: StaticAnalysis) -> "VibrationAnalysis":
        """How it is found; ``statics`` is how an equilibrium is."""
        return VibrationAnalysis(self, statics)


@dataclass(frozen=True)
class VibrationAnalysis:
    """An eigenfrequency of the undeformed or the loaded structure."""

    quantity: Eigenfrequency
    statics: StaticAnalysis

    @property
    def smallest(self) -> float:
        """That of the equilibrium about which it vibrates."""
        return self.statics.smallest if self.quantity.loaded else SMALLEST

    def solve(self, system: System, start: Solution | None) -> Answer:
        rest = Answer(Solution(system, system.undeformed, load_factor=0.0), 0.0)
        if self.quantity.loaded:
            rest = replace(self.statics, quantity=StrainEnergy()).solve(system, start)
        state = rest.state if self.quantity.loaded else None
        found = _enough_modes(system, self.quantity.number, state, self.statics.backend)
        mode = _number(found, self.quantity.number)
        value = float(found.frequencies[mode])
        return replace(rest, state=found.shape(mode), value=value, found=(found, mode))

    def estimate(self, answer: Answer, halvings: Halvings = NOTHING_KNOWN) -> Estimate:
        r"""By one step of inverse iteration on the refined mesh.

        With :math:`r = (K - \lambda M) \phi` there and :math:`e = -K^{-1} r`, the quotient of Rayleigh of
        :math:`\phi + e` against that of the mesh; :math:`r \cdot (e - I e)` is where the difference comes from.
        """
        found, mode = answer.found
        shape, value, backend = found.shapes[mode], found.eigenvalues[mode], self.statics.backend
        if not self.quantity.loaded:
            return self._about(Refined(found.state.system), answer, None, halvings)
        with Enriched(found.state, backend=backend) as enriched:
            estimate = self._about(enriched, answer, enriched.corrected, halvings)
            weight = softened(enriched, enriched.up(shape))
            of_state = enriched.shares(enriched.residual * enriched.surplus(weight))
            return replace(estimate, indicators=estimate.indicators + _per_eigenvalue(answer.value, value) * of_state)

    def theory_error(self, answer: Answer) -> TheoryError:
        """From shear and the rotary inertia of the normals."""
        found, mode = answer.found
        return of_eigenvalue(answer.value, float(found.theory_errors[mode]))

    def _about(self, refined: Refined, answer: Answer, rest: Solution | None, halvings: Halvings) -> Estimate:
        found, mode = answer.found
        shape, value, fine = found.shapes[mode], found.eigenvalues[mode], refined.system
        stiffness, mass, phi = state_tangent(fine, rest), fine.mass, refined.up(shape)
        residual = stiffness @ phi - value * (mass @ phi)
        with DirectSolver(fine.pattern, fine.constraints, self.statics.backend) as solver:
            held = solver_at(fine, solver, fine.undeformed if rest is None else rest.q)
            factor_shifted(held, stiffness, mass)
            step, pulls, _ = solved(held, -residual, -rows_of(held, phi))
        if pulls.size:
            residual = residual + held.gradient.T @ pulls
        improved = phi + step
        shares = refined.shares(residual * refined.surplus(step)) * _per_eigenvalue(answer.value, value)
        moved = moved_along(rest or Solution(fine, fine.undeformed, load_factor=0.0), improved, None)
        of_mode = energies(small(fine, improved, None if rest is None else rest.q))
        halved = refined.halvings((of_mode, of_mode), before=halvings)
        found = _frequency(improved, stiffness, mass)
        return Estimate.seen(answer.value, found, shares, moved, refined.left(halved), halvings=halved)


def _frequency(shape: np.ndarray, stiffness: BlockMatrix, mass: BlockMatrix) -> float:
    value = stiffness.energy(shape) / mass.energy(shape)
    return float(np.sign(value) * np.sqrt(abs(value)) / (2 * np.pi))


def _per_eigenvalue(frequency: float, value: float) -> float:
    """Change of a frequency per change of its eigenvalue."""
    return abs(frequency / (2 * value)) if value else 0.0


def softened(enriched: Enriched, shape: np.ndarray, factor: float = 1.0) -> np.ndarray:
    r"""Weight of what the state about which a shape moves has to do with :math:`\phi \cdot K \phi`, times a factor: with
    conditions K has their curvature, and a change of multipliers counts by :math:`\phi \cdot g_{qq} \phi`."""
    system, q = enriched.system, enriched.corrected.about
    force = factor * softening(system, q, shape)
    if not system.conditions:
        return enriched.solve(force)
    step = _step(system, shape)
    after, before = (system.conditions.gradient(q + s * step * shape) @ shape for s in (1, -1))
    return enriched.solve_both(force, factor * (after - before) / (2 * step))[0]


def softening(system: System, q: np.ndarray, shape: np.ndarray) -> np.ndarray:
    r"""Derivative of :math:`\phi \cdot K(q) \phi` with respect to q, by a second difference of the internal force.

    The third derivatives of the energy are symmetric, so that it is the second derivative of the force along the shape.
    """
    step = _step(system, shape)
    ahead, at, behind = (system.internal_force(q + s * step * shape) for s in (1, 0, -1))
    return np.asarray((ahead - 2 * at + behind) / step**2)


def _step(system: System, shape: np.ndarray) -> float:
    """So that positions and slopes change by :data:`STEP`, relatively. Twists do not count: at a point force in the surface
    they grow with the inverse square of the element size, and strain nothing but the elements there."""
    undeformed, moved = (np.abs(system.layout.nodal(q))[:, :FOURTH] for q in (system.undeformed, shape))
    return float(STEP * undeformed.max() / moved.max())


RIGID_MOTIONS = 6
"""Motions that a free body has."""
STEP = 1e-4
"""Of a second difference, relative: rounding grows with its inverse square."""


def _enough_modes(system: System, number: int, state: Any, backend: str) -> Modes:
    """So many that the asked one is among them, behind the motions without stiffness."""
    found = modes(system, number + 1, state=state, backend=backend, progress=False)
    if found.n_rigid > RIGID_MOTIONS:
        raise InputError(f"number = {number}: {found.n_rigid} motions without stiffness come first; support the structure, "
                         "it is a mechanism")  # fmt: skip
    if found.n_rigid:
        found = modes(system, number + 1 + found.n_rigid, state=state, backend=backend, progress=False)
    require_checks(found.checks)
    return found


def _number(found: Modes, number: int) -> int:
    return int(np.flatnonzero(found.eigenvalues != 0)[number])
