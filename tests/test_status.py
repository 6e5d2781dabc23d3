"""One word for "it worked", with the same meaning in every result."""

import logging
from dataclasses import fields, is_dataclass, replace

import numpy as np
import pytest

import skancf as sk
from skancf.dynamics.step_solver import StepOutcome
from skancf.solving import run_steps
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
    statics = NewtonResult(q, status, ()), sk.StaticResult(None, status, (), ()), sk.PathResult((), q, (), status, ())
    others = sk.Motion((), (), None, {}, status), sk.AdaptiveResult(0.0, 0.0, 0.0, None, (), status, "", "")
    assert [result.ok for result in (*statics, *others)] == 5 * [status in WORKED]


def test_modes_and_load_factors_are_ok_where_their_checks_hold():
    for result in (sk.modes(strip(), 2), sk.buckling(strip(), 2)):
        assert result.checks and result.ok
        assert not replace(result, checks=(*result.checks, sk.Check("a check", 1.0, 0.1))).ok


def run(end, keeps=True):
    """A loop of three steps and an end: what it computed, and how it ended."""
    done = []

    def step():
        if len(done) == 3:
            if isinstance(end, BaseException):
                raise end
            return end
        done.append(len(done))

    said = run_steps(
        step,
        lambda: f" after {len(done)}" if keeps else None,
        lambda error: f"kept: {error}" if keeps else None,
        logging.getLogger("a loop"),
    )
    return done, said


def test_what_a_loop_computed_is_kept_whatever_ends_it():
    steps = [0, 1, 2]
    assert run((sk.Status.FINISHED, "")) == (steps, (sk.Status.FINISHED, ""))
    assert run(KeyboardInterrupt()) == (steps, (sk.Status.INTERRUPTED, "interrupted from the keyboard after 3"))
    assert run(OSError("disk")) == (steps, (sk.Status.FAILED, "kept: disk"))


@pytest.mark.parametrize("error", [KeyboardInterrupt(), ValueError("first step"), SystemExit()], ids=repr)
def test_where_nothing_is_there_to_be_kept_it_is_raised(error):
    with pytest.raises(type(error)):
        run(error, keeps=False)
    if isinstance(error, SystemExit):
        with pytest.raises(SystemExit):
            run(error)
