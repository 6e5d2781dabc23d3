"""What is solved on each mesh to get a number: an equilibrium by default."""

from dataclasses import dataclass
from typing import Any, Protocol

from skancf.adaptive.estimate import Estimate, goal_estimate
from skancf.adaptive.quantities import Quantity
from skancf.adaptive.transfer import transfer
from skancf.assembly.system import System
from skancf.solution import Solution
from skancf.statics import HalveAndGrow
from skancf.statics.equilibrium import equilibrium, small_deflection
from skancf.statics.newton import Status


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
    """

    state: Solution
    value: float
    iterations: int = 0
    restarted: bool = False
    found: Any = None


class Analysis(Protocol):
    """How a number is found on a mesh, and how far it is from its limit."""

    def solve(self, system: System, start: Solution | None) -> Answer:
        """The answer on a mesh, from a state of another mesh if there is one."""

    def estimate(self, answer: Answer) -> Estimate:
        """Its error and where it comes from."""


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

    def solve(self, system: System, start: Solution | None) -> Answer:
        if self.linear:
            state = small_deflection(system, self.load_factor, backend=self.backend)
            iterations, restarted = 0, False
        else:
            state, iterations, restarted = self._nonlinear(system, start)
        return Answer(state, self.quantity.value(state), iterations, restarted)

    def _nonlinear(self, system: System, start: Solution | None) -> tuple[Solution, int, bool]:
        spent = 0
        if start is not None:
            near, at_once = transfer(start, system), HalveAndGrow(smallest=0.99)
            once = equilibrium(
                system, self.load_factor, control=at_once, start=near, rtol=self.rtol, backend=self.backend
            )
            spent = once.iterations
            if once.status is Status.CONVERGED:
                return once.solution, spent, False
            _pass_on_interrupt(once.status)
        result = equilibrium(system, self.load_factor, rtol=self.rtol, follow=True, backend=self.backend)
        _pass_on_interrupt(result.status)
        return result.unwrap(), spent + result.iterations, start is not None

    def estimate(self, answer: Answer) -> Estimate:
        return goal_estimate(answer.state, self.quantity, backend=self.backend)


def _pass_on_interrupt(status: Status) -> None:
    if status is Status.INTERRUPTED:
        raise KeyboardInterrupt
