"""What is solved on each mesh to get a number: an equilibrium by default."""

from dataclasses import dataclass
from typing import Any, Protocol

from skancf.adaptive.estimate import Estimate, goal_estimate, value_of
from skancf.adaptive.grow import SMALLEST, SMALLEST_LARGE
from skancf.adaptive.quantities import Quantity
from skancf.adaptive.rings import NOTHING_KNOWN, Halvings
from skancf.adaptive.theory_error import TheoryError, theory_error_or_why
from skancf.adaptive.transfer import transfer
from skancf.checks import Check
from skancf.showing import short
from skancf.solution import Solution
from skancf.solving import FOUND, Status
from skancf.statics.equilibrium import equilibrium
from skancf.statics.linear import small_deflection
from skancf.system.system import System


@dataclass(frozen=True)
class Answer:
    """What was found on one mesh.

    Attributes
    ----------
    state : Solution
        For pictures and files: the equilibrium, or a mode.
    value : float
    iterations : int
        Newton iterations.
    restarted : bool
        The transferred state led nowhere, and the load was applied anew.
    found : object
        What the estimate needs besides.
    note : str
        What the solve met on its way, or has to say of the state.
    checks : tuple of Check
        Of the state.
    """

    state: Solution
    value: float
    iterations: int = 0
    restarted: bool = False
    found: Any = None
    note: str = ""
    checks: tuple[Check, ...] = ()

    __repr__ = short


class Analysis(Protocol):
    """How a number is found on a mesh, and how far it is from its limit."""

    @property
    def smallest(self) -> float:
        """Size of the smallest elements that rounding lets it have, of the extent of the surface."""

    def solve(self, system: System, start: Solution | None) -> Answer:
        """The answer on a mesh, from a state of another mesh if there is one."""

    def estimate(self, answer: Answer, halvings: Halvings = NOTHING_KNOWN) -> Estimate:
        """Its error and where it comes from, with what is known of singular points from the mesh before."""

    def theory_error(self, answer: Answer) -> TheoryError:
        """What the theory leaves out of it."""


@dataclass(frozen=True)
class StaticAnalysis:
    """A quantity of an equilibrium.

    Parameters
    ----------
    quantity : Quantity
    linear : bool
        Small deflections.
    load_factor : float
    rtol : float
        Of Newton's method.
    """

    quantity: Quantity
    linear: bool = False
    load_factor: float = 1.0
    rtol: float = 1e-6
    backend: str = "auto"

    @property
    def smallest(self) -> float:
        """Smaller ones where displacements are small."""
        return SMALLEST if self.linear else SMALLEST_LARGE

    def solve(self, system: System, start: Solution | None) -> Answer:
        if self.linear:
            state = small_deflection(system, self.load_factor, backend=self.backend)
            return Answer(state, value_of(self.quantity, state))
        return self._nonlinear(system, start)

    def _nonlinear(self, system: System, start: Solution | None) -> Answer:
        """From the transferred state, relaxed from there if need be; if that leads nowhere, with the load applied anew."""
        spent, options = 0, {"rtol": self.rtol, "backend": self.backend}
        for begin in (None,) if start is None else (transfer(start, system), None):
            result = equilibrium(system, self.load_factor, start=begin, **options)  # type: ignore[arg-type]
            spent += result.iterations
            if result.status is Status.INTERRUPTED:
                raise KeyboardInterrupt
            if result.status in FOUND:
                break
        state, restarted = result.unwrap(), start is not None and begin is None
        return Answer(state, value_of(self.quantity, state), spent, restarted, None, result.message, result.checks)

    def estimate(self, answer: Answer, halvings: Halvings = NOTHING_KNOWN) -> Estimate:
        return goal_estimate(answer.state, self.quantity, backend=self.backend, halvings=halvings, progress=False)

    def theory_error(self, answer: Answer) -> TheoryError:
        return theory_error_or_why(answer.state, self.quantity, self.backend)
