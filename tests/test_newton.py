"""Newton's method on a toy, x^3 - x = load, whose tangents and rules are those of a few lines."""

from dataclasses import dataclass, field

import numpy as np
import pytest

from skancf.errors import SingularMatrix
from skancf.solving import Status, iterate


@dataclass
class Toy:
    """With a tangent of every state, or with the first one."""

    load: float = 6.0
    keep: bool = False
    tangent: float | None = None
    visited: list = field(default_factory=list)

    def residual(self, x):
        self.visited.append(float(x[0]))
        return x**3 - x - self.load

    def correction(self, x, residual):
        if self.tangent is None or not self.keep:
            self.tangent = float(3 * x[0] ** 2 - 1)
        if not self.tangent:
            raise SingularMatrix("no stiffness against x")
        change = -residual / self.tangent
        return change, abs(float(change @ residual))

    def step(self, x, residual, change):
        return x + change


@dataclass
class Until:
    """Ends with a status where the energy is small."""

    energy: float
    status: Status = Status.CONVERGED

    def assess(self, x, change, energies):
        return (self.status, "small") if energies[-1] < self.energy else None


def solved(x=2.5, most=50, energy=1e-24, status=Status.CONVERGED, **toy):
    return iterate(np.array([x]), Toy(**toy), Until(energy, status), most)


def test_new_tangents_converge_quadratically_and_a_kept_one_linearly():
    new, kept = solved(), solved(keep=True)
    assert new.ok and kept.ok and new.message == "small"
    assert abs(new.x[0] - 2.0) < 1e-12 and abs(kept.x[0] - 2.0) < 1e-10
    logs = np.log10(new.energies)
    assert logs[-1] < 1.8 * logs[-2] < 0 and new.iterations < 7 < kept.iterations
    # x^3 - x has the tangent 11 at 2 and 17.75 at 2.5: each kept correction is 1 - 11 / 17.75 of the one before.
    ratios = np.sqrt(np.array(kept.energies[1:]) / kept.energies[:-1])
    assert ratios[-3:] == pytest.approx(1 - 11 / 17.75, rel=1e-3)


def test_a_residual_for_each_correction_and_none_more():
    toy = Toy()
    found = iterate(np.array([2.5]), toy, Until(1e-3), 50)
    assert found.iterations == len(found.energies) == len(toy.visited)
    assert found.x[0] not in toy.visited, "the last correction is taken, and not looked at again"


@pytest.mark.parametrize(("status", "taken"), [(Status.CONVERGED, True), (Status.ROUNDING, True), (Status.DIVERGED, False)])
def test_the_last_correction_is_taken_where_it_leads_to_an_answer(status, taken):
    found = solved(energy=np.inf, status=status)
    assert found.status is status and found.ok is (status is Status.CONVERGED)
    assert bool(found.x[0] != 2.5) is taken


def test_failures_are_ends_like_others():
    spent = solved(most=3)
    assert spent.status is Status.STEPS_SPENT and spent.iterations == 3 == len(spent.energies)
    singular = solved(keep=True, tangent=0.0)
    assert singular.status is Status.SINGULAR and singular.message == "no stiffness against x" and not singular.energies
    with np.errstate(over="ignore"):
        lost = solved(x=1e200)
    assert lost.status is Status.NOT_FINITE and not np.isfinite(lost.residual).all() and lost.x[0] == 1e200
