"""Buckling loads as quantities of interest."""

from dataclasses import dataclass

from skancf.adaptive.analysis import Answer, StaticAnalysis
from skancf.adaptive.blunt import Blunt, blunt_points
from skancf.adaptive.energies import energies, of_state, small
from skancf.adaptive.enriched import Enriched
from skancf.adaptive.estimate import Estimate
from skancf.adaptive.grow import SMALLEST
from skancf.adaptive.rings import NOTHING_KNOWN, Halvings
from skancf.adaptive.theory_error import TheoryError, of_eigenvalue
from skancf.adaptive.vibration import softened
from skancf.arguments import whole
from skancf.conditions.solver import curved
from skancf.errors import InputError
from skancf.solution import Solution
from skancf.statics.buckling import buckling
from skancf.statics.eigen_checks import require_checks
from skancf.statics.shapes import moved_along
from skancf.system.linearised import geometric_stiffness
from skancf.system.system import System


@dataclass(frozen=True)
class BucklingLoad:
    """A load factor at which the structure buckles, by :func:`skancf.buckling` (1).

    Under a force at a single point the smallest elements buckle by themselves, at a load that goes to zero with their size.
    :func:`skancf.adapt` lets elements at such points be about as large as the thickness.

    Parameters
    ----------
    number : int
        From 0 on, in ascending order.

    Raises
    ------
    InputError
        For a number that is no whole number of at least 0.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[
    ...         sk.Roller("boundary", kind="hard"), sk.Roller("left", (1, 0, 0)), sk.Roller((0.0, 0.0), (0, 1, 0)),
    ...     ],
    ...     loads=[sk.EdgeLoad("right", (-1e5, 0.0, 0.0))],
    ... )
    >>> result = sk.adapt(plate, sk.BucklingLoad(), rtol=1e-2)
    >>> print(f"{result.value:.3f}")
    7.594
    """

    number: int = 0

    unit = ""

    def __post_init__(self) -> None:
        whole("number", self.number, least=0)

    def analysis(self, statics: StaticAnalysis) -> "StabilityAnalysis":
        """How it is found."""
        return StabilityAnalysis(self, statics.backend)


@dataclass(frozen=True)
class StabilityAnalysis:
    """A linear buckling load."""

    quantity: BucklingLoad
    backend: str = "auto"

    @property
    def smallest(self) -> float:
        """That of small deflections."""
        return SMALLEST

    def blunt(self, system: System) -> Blunt:
        """Points whose elements would buckle by themselves if they were small."""
        return blunt_points(system)

    def solve(self, system: System, start: Solution | None) -> Answer:
        number = self.quantity.number
        found = buckling(system, number + 1, backend=self.backend, progress=False)
        if len(found.load_factors) <= number:
            raise InputError(f"number = {number}: {found.message or 'there are fewer positive buckling loads'}")
        require_checks(found.checks)
        return Answer(found.shape(number), float(found.load_factors[number]), found=found)

    def estimate(self, answer: Answer, halvings: Halvings = NOTHING_KNOWN) -> Estimate:
        r"""As for a frequency, on the pencil :math:`K_0 + \lambda K_\sigma` of the refined mesh with its own stresses."""
        found, number, value = answer.found, self.quantity.number, answer.value
        with Enriched(found.linear, backend=self.backend, blunt=self.blunt(answer.state.system)) as enriched:
            fine, better = enriched.system, enriched.corrected
            elastic = enriched.stiffness
            geometric = curved(fine, geometric_stiffness(fine, better.change), fine.undeformed, better.multipliers)
            phi = enriched.up(found.shapes[number])
            residual = elastic @ phi + value * (geometric @ phi)
            step, pulls = enriched.solve_both(-residual, -enriched.rows(phi))
            residual = residual + enriched.held_by(pulls)
            improved = phi + step
            factor = -elastic.energy(improved) / geometric.energy(improved)
            # d(load factor) = load factor^2 phi . dK phi with phi . K_0 phi = 1.
            weight = softened(enriched, phi, value**2)
            shares = enriched.shares(value * residual * enriched.surplus(step))
            shares = shares + enriched.shares(enriched.residual * enriched.surplus(weight))
            moved = moved_along(Solution(fine, fine.undeformed, load_factor=0.0), improved, None)
            of_mode = energies(small(fine, improved))
            of_stress = energies(of_state(better)), energies(small(fine, weight))
            halved = enriched.halvings((of_mode, of_mode), of_stress, before=halvings)
            return Estimate.seen(value, factor, shares, moved, enriched.left(halved), halvings=halved)

    def theory_error(self, answer: Answer) -> TheoryError:
        """From shear."""
        return of_eigenvalue(answer.value, float(answer.found.theory_errors[self.quantity.number]))
