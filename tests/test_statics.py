"""Newton's method and load steps: what they report, and that a failure is data."""

import numpy as np
import pytest

import skancf as sk
from skancf.errors import InputError
from skancf.linear import DirectSolver
from skancf.solving import Status
from skancf.statics import HalveAndGrow, NewtonResult, newton

LENGTH, THICKNESS, YOUNG = 10.0, 0.1, 1.2e6
RIGIDITY = YOUNG * THICKNESS**3 / 12


CLAMPED = (sk.Clamp("left"),)


def strip(alpha=4.0, n=8, supports=CLAMPED, loads=None):
    """A cantilever strip 10 x 1 under the end force P L^2 / E I = alpha."""
    loads = [sk.EdgeLoad("right", (0, 0, alpha * RIGIDITY / LENGTH**2))] if loads is None else loads
    problem = sk.Problem(sk.Rectangle(LENGTH, 1.0), THICKNESS, sk.Isotropic(YOUNG, 0.0, 1.0), list(supports), loads)
    return problem.on(sk.meshes.uniform(problem.surface, n, 1))


def newton_on(system, **options):
    with DirectSolver(system.pattern, system.constraints) as solver:
        return newton(system, system.undeformed, solver, **options)


# --- Newton's method -------------------------------------------------------------------------------------------------


def test_residuals_fall_quadratically_and_the_answer_is_an_equilibrium():
    system = strip()
    watched = []
    result = newton_on(system, rtol=1e-10, watch=lambda step, norm: watched.append(step))
    assert result.status is Status.CONVERGED and result.ok and result.negative_pivots == 0
    norms = np.array(result.residual_norms)
    assert watched == list(range(len(norms))) and norms.max() == 1.0
    # Near the end the number of right digits doubles; the last drop may meet rounding.
    logs = np.log10(norms[norms > 1e-10][-3:])
    assert logs[2] < 1.5 * logs[1] < 0
    residual = system.internal_force(result.q) - system.external_force(result.q)
    free = system.constraints.free_part(residual)
    assert np.abs(free).max() < 1e-6 * np.abs(system.external_force(result.q)).max()


def test_a_single_solve_that_runs_out_of_steps_says_so():
    result = newton_on(strip(), max_steps=3)
    assert result.status is Status.STEPS_SPENT and not result.ok and len(result.residual_norms) == 3
    with pytest.raises(sk.DidNotConverge, match="iteration limit reached; residual") as caught:
        result.unwrap()
    assert caught.value.residual_norms == result.residual_norms
    assert newton_on(strip()).unwrap() is not None


def test_no_load_no_motion():
    result = sk.solve(strip(0.0))
    assert result.status is Status.CONVERGED
    assert np.abs(result.solution.displacements).max() < 1e-12  # rounding, over a length of 10


def test_a_state_that_is_not_finite_is_located():
    system = strip()
    q = system.undeformed.copy()
    q[-12:] = 1e200  # its strains overflow
    with DirectSolver(system.pattern, system.constraints) as solver:
        result = newton(system, q, solver)
    assert result.status is Status.NOT_FINITE and "node that was at (" in result.message


def test_mixed_and_plain_find_the_same_equilibrium():
    mixed, plain = newton_on(strip(), rtol=1e-10), newton_on(strip(), rtol=1e-10, mixed=False)
    assert mixed.ok and plain.ok
    assert np.abs(mixed.q - plain.q).max() < 1e-8
    assert len(mixed.residual_norms) < len(plain.residual_norms)


# --- load steps ------------------------------------------------------------------------------------------------------


def test_steps_are_halved_where_newton_fails():
    """Too few iterations for the whole load: the path must cut its steps and arrive all the same."""
    system = strip(10.0)
    direct = sk.solve(system, rtol=1e-9)
    hard = sk.solve(system, rtol=1e-9, max_iterations=6)
    tried = [factor for factor, _ in hard.attempts]
    failed = [result.status for _, result in hard.attempts if not result.ok]
    assert Status.STEPS_SPENT in failed, "nothing failed, so halving was not tested"
    assert tried[:2] == [1.0, 0.5]
    assert hard.status is Status.CONVERGED and hard.message == ""
    assert np.abs(hard.solution.q - direct.solution.q).max() < 1e-7
    # The path holds every equilibrium, in order, from the undeformed state to the whole load.
    factors = [solution.load_factor for solution in hard.path]
    assert factors[0] == 0.0 and factors[-1] == 1.0 and (np.diff(factors) > 0).all()
    assert len(factors) - 1 == len(hard.attempts) - len(failed)
    assert hard.iterations == sum(len(result.residual_norms) for _, result in hard.attempts)


def test_failure_is_data():
    system = strip(10.0)
    result = sk.solve(system, max_iterations=3, control=HalveAndGrow(smallest=0.2), relax=False)
    assert result.status is Status.STEP_TOO_SMALL
    assert "load factor 0:" in result.message and "iteration limit reached on the way to" in result.message
    assert "last residuals" in result.message
    assert np.array_equal(result.solution.q, system.undeformed), "the last equilibrium"
    assert [factor for factor, _ in result.attempts] == [1.0, 0.5, 0.25]
    assert all(len(attempt.residual_norms) == 3 for _, attempt in result.attempts)
    with pytest.raises(sk.DidNotConverge, match="statics stopped") as caught:
        result.unwrap()
    assert caught.value.residual_norms == result.attempts[-1][1].residual_norms


def test_failure_on_the_way_keeps_the_last_equilibrium():
    """A start that is easy and an end that is not."""
    system = strip(10.0)
    control = HalveAndGrow(first=0.05, smallest=0.02, growth=20.0, cut=100.0)
    result = sk.solve(system, max_iterations=5, control=control, relax=False)
    assert result.status is Status.STEP_TOO_SMALL
    last = result.solution
    assert last.load_factor == 0.05 and [factor for factor, _ in result.attempts] == [0.05, 1.0]
    residual = system.internal_force(last.q) - last.load_factor * system.external_force(last.q)
    assert np.abs(system.constraints.free_part(residual)).max() < 1e-4 * np.abs(system.external_force(last.q)).max()
    assert f"load factor {last.load_factor:.6g}" in result.message


def test_step_control():
    def outcome(status, n):
        return NewtonResult(np.zeros(0), status, (1.0,) * n)

    control = HalveAndGrow(cut=4.0, growth=2.0, easy=5)
    assert control.next_step(0.4, outcome(Status.CONVERGED, 5)) == 0.8
    assert control.next_step(0.4, outcome(Status.CONVERGED, 6)) == 0.4
    assert control.next_step(0.4, outcome(Status.DIVERGED, 3)) == 0.1
    for name in ("first", "smallest", "cut", "growth", "easy"):
        with pytest.raises(InputError, match=f"{name} = 0"):
            HalveAndGrow(**{name: 0})


@pytest.mark.parametrize("wrong", [{"cut": 1.0}, {"cut": 0.5}, {"growth": 0.5}], ids=str)
def test_step_control_that_cannot_end_is_refused(wrong):
    with pytest.raises(InputError):
        HalveAndGrow(**wrong)


def test_nodal_coordinates_of_another_mesh_are_refused():
    other = sk.solve_linear(strip(n=4))
    with pytest.raises(InputError, match="another mesh"):
        sk.solve(strip(n=8), start=other)
    with pytest.raises(InputError, match="12 per node"):
        strip(n=8).internal_force(other.q)


def test_continued_from_a_solution():
    system = strip(4.0)
    half = sk.solve(system, load_factor=0.5, rtol=1e-9)
    on = sk.solve(system, start=half.unwrap(), rtol=1e-9)
    back = sk.solve(system, start=on.unwrap(), load_factor=0.5, rtol=1e-9)
    assert on.path[0] is half.solution and on.path[0].load_factor == 0.5
    assert np.abs(on.solution.q - sk.solve(system, rtol=1e-9).solution.q).max() < 1e-7
    assert np.abs(back.solution.q - half.solution.q).max() < 1e-7, "elastic: the way back ends where it began"
    assert np.abs(on.solution.q - half.solution.q).max() > 0.1


def test_path_of_a_prescribed_displacement():
    """The free end of the strip is lifted: the reaction is the force that would have lifted it as far."""
    lift = 6.0
    lifted = strip(supports=[sk.Clamp("left"), sk.Prescribed("right", (None, None, lift))], loads=[])
    result = sk.solve(lifted, control=HalveAndGrow(first=0.25, growth=1.0), rtol=1e-9)
    end = [solution.displacement((LENGTH, 0.5))[2] for solution in result.path]
    assert np.allclose(end, [0, 1.5, 3.0, 4.5, 6.0], atol=1e-12)
    reactions = np.array([solution.reactions("right")[2] for solution in result.path])
    assert (np.diff(reactions, 2) > 0).all(), "it stiffens"
    pushed = strip(loads=[sk.EdgeLoad("right", (0, 0, reactions[-1]))])
    assert np.isclose(sk.solve(pushed, rtol=1e-9).solution.displacement((LENGTH, 0.5))[2], lift, atol=2e-4)


def test_a_support_that_tears_is_refused_before_any_work():
    with pytest.raises(InputError, match="leave free"):
        sk.solve(strip(supports=[sk.Pin("left")]))
    with pytest.raises(InputError, match="backend = 'abacus'"):
        sk.solve(strip(), backend="abacus")


def test_overflow_is_a_result_that_says_where():
    problem = sk.Problem(sk.Rectangle(1.0, 1.0), 0.1, sk.Isotropic(1e6, 0.3, 1.0), [sk.Clamp("left")],
                         [sk.PointForce((1.0, 1.0), (0, 0, 1e99))])  # fmt: skip
    result = sk.solve(problem.on(sk.meshes.uniform(problem.surface, 2, 2)), load_factor=1e99)
    assert result.status.value != "converged" and "first at the node" in result.message


def test_an_unstable_equilibrium_says_so():
    """A strip pushed to five times its Euler load, pi^2 E I / (4 L^2), and nothing that disturbs it."""
    length, thickness, young = 10.0, 0.1, 1e6
    euler = np.pi**2 * young * thickness**3 / 12 / (4 * length**2)
    for factor, stable in ((0.5, True), (5.0, False)):
        problem = sk.Problem(sk.Rectangle(length, 1.0), thickness, sk.Isotropic(young, 0.0, 1.0), [sk.Clamp("left")],
                             [sk.EdgeLoad("right", (-factor * euler, 0, 0))])  # fmt: skip
        result = sk.solve(problem.on(sk.meshes.uniform(problem.surface, 8, 1)), relax=False)
        assert (result.negative_pivots == 0) is stable
        assert ("not stable" in result.message) is not stable
