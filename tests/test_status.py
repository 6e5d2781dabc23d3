"""One word for "it worked", with the same meaning in every result."""

from dataclasses import fields, is_dataclass, replace

import numpy as np
import pytest

import skancf as sk
from skancf.dynamics.step_solver import StepOutcome
from skancf.statics import NewtonResult

WORKED = {sk.Status.CONVERGED, sk.Status.FINISHED, sk.Status.REACHED}
OTHER_WORDS = ("converged", "finished", "reached", "success", "outcome")


def strip():
    problem = sk.Problem(sk.Rectangle(10.0, 1.0), 0.1, sk.Isotropic(1.2e6, 0.0, 1.0), [sk.Clamp("left")],
                         [sk.EdgeLoad("right", (-0.1, 0, 1.0))])  # fmt: skip
    return problem.on(sk.meshes.uniform(problem.surface, 4, 1), "kirchhoff")


def test_what_worked_and_what_did_not():
    assert {status for status in sk.Status if status.ok} == WORKED
    assert len({status.value for status in sk.Status}) == len(sk.Status), "each has words of its own"


def results():
    """Classes that say how something ended."""
    named = [getattr(sk, name) for name in sk.__all__]
    found = [c for c in named if isinstance(c, type) and is_dataclass(c) and "status" in {f.name for f in fields(c)}]
    return [*found, sk.Modes, sk.BucklingResult, NewtonResult, StepOutcome]


def test_every_result_has_the_word_and_no_other():
    assert {sk.StaticResult, sk.PathResult, sk.Motion, sk.AdaptiveResult} <= set(results())
    for result in results():
        assert hasattr(result, "ok") or "ok" in {field.name for field in fields(result)}, result
        assert not [word for word in OTHER_WORDS if hasattr(result, word)], result


@pytest.mark.parametrize("status", sk.Status, ids=lambda status: status.name)
def test_a_result_says_what_its_status_says(status):
    q = np.zeros(12)
    for result in (
        NewtonResult(q, status, ()), sk.StaticResult(None, status, (), ()), sk.PathResult((), q, (), status, ()),
        sk.Motion((), (), None, {}, status), sk.AdaptiveResult(0.0, 0.0, 0.0, None, (), status, "", ""),
    ):  # fmt: skip
        assert result.ok is (status in WORKED)


def test_modes_and_load_factors_are_ok_where_their_checks_hold():
    for result in (sk.modes(strip(), 2), sk.buckling(strip(), 2)):
        assert result.checks and result.ok
        assert not replace(result, checks=(*result.checks, sk.Check("a check", 1.0, 0.1))).ok
