"""Functions of time: values, ranges, and what covers a run."""

from math import pi, sin

import numpy as np
import pytest

import skancf as sk
from skancf.errors import InputError
from skancf.history import check_cover, check_covers

UNIT = sk.Rectangle(1.0, 1.0)


def test_ramp_and_pulses():
    ramp = sk.Ramp(2.0, start=1.0)
    assert [ramp(t) for t in (-5.0, 1.0, 1.5, 3.0, 9.0)] == [0.0, 0.0, 0.25, 1.0, 1.0]
    expected = {"sine": [0, 0, sin(pi / 4), 1.0, 0, 0], "triangle": [0, 0, 0.5, 1.0, 0, 0], "rectangle": [0, 1, 1, 1, 0, 0]}
    for shape, values in expected.items():
        pulse = sk.Pulse(2.0, start=1.0, shape=shape)
        assert np.allclose([pulse(t) for t in (0.9, 1.0, 1.5, 2.0, 3.0, 3.1)], values, rtol=0, atol=1e-15)
    times = np.linspace(0, 2, 20001)
    for shape, area in (("sine", 2 * 2 / pi), ("triangle", 1.0), ("rectangle", 2.0)):
        pulse = sk.Pulse(2.0, shape=shape)
        middle = [pulse(t) for t in (times[1:] + times[:-1]) / 2]
        assert np.isclose(np.sum(middle) * 1e-4, area, rtol=1e-7)


def test_a_linear_table():
    table = sk.Table([0.0, 1.0, 3.0], np.array([0.0, 2.0, -2.0]))
    assert [table(t) for t in (0.0, 0.25, 1.0, 2.0, 3.0)] == [0.0, 0.5, 2.0, 0.0, -2.0]
    assert table.span == (0.0, 3.0)
    assert table == sk.Table((0.0, 1.0, 3.0), (0.0, 2.0, -2.0)) and hash(table) != hash(sk.Ramp(1.0))


def test_a_smooth_table_goes_through_its_values_and_overshoots_nowhere():
    t, values = np.array([0.0, 1.0, 2.0, 3.0, 4.0]), np.array([0.0, 0.0, 1.0, 1.0, 3.0])
    smooth, linear = sk.Table(t, values, "smooth"), sk.Table(t, values)
    assert np.allclose([smooth(s) for s in t], values, rtol=0, atol=1e-15)
    fine = np.linspace(0, 4, 4001)
    found = np.array([smooth(s) for s in fine])
    assert (np.diff(found) >= -1e-15).all() and found.max() <= 3.0
    # A jump of the slope shows as a second difference of the size of the step; a continuous one as of its square.
    kinks = [np.abs(np.diff([h(s) for s in fine], 2)).max() for h in (smooth, linear)]
    assert kinks[0] < 1e-5 < 5e-4 < kinks[1]


def test_a_path():
    path = sk.Path([0.0, 1.0, 2.0], [(-0.5, 0.0), (0.5, 1.0), (0.5, 3.0)])
    assert np.array_equal(path(0.5), [0.0, 0.5]) and np.array_equal(path(1.5), [0.5, 2.0])
    assert path.span == (0.0, 2.0)
    with pytest.raises(InputError, match=r"Path at t = 2.5 s: its values are from t = 0.0 to 2.0 s"):
        path(2.5)


def test_outside_a_table():
    table = sk.Table([1.0, 2.0], [3.0, 4.0])
    for t in (0.99, 2.01, np.nan):
        with pytest.raises(InputError, match=rf"Table at t = {t} s: its values are from t = 1.0 to 2.0 s"):
            table(t)
    assert table(2.0 + 1e-12) == 4.0 and table(1.0 - 1e-12) == 3.0, "rounding of the time is no reason to stop"


@pytest.mark.parametrize(("build", "words"), [
    (lambda: sk.Table([0.0, 1.0, 1.0], [0, 1, 2]), r"times\[1\] = 1.0, times\[2\] = 1.0: times must ascend"),
    (lambda: sk.Table([0.0], [1.0]), "two times or more"),
    (lambda: sk.Table(3.0, [1.0]), "two times or more"),
    (lambda: sk.Table([0.0, 1.0], [1.0, 2.0, 3.0]), "give 2 numbers"),
    (lambda: sk.Table([0.0, 1.0], [1.0, np.nan]), r"values\[1\].*not finite"),
    (lambda: sk.Table([0.0, np.inf], [1.0, 1.0]), r"times\[1\].*not finite"),
    (lambda: sk.Table([0.0, 1.0], [1.0, 1.0], "cubic"), "kind = 'cubic'.*'linear' or 'smooth'"),
    (lambda: sk.Path([0.0, 1.0], [(0, 0)]), r"give 2 points \(x, y\)"),
    (lambda: sk.Ramp(0.0), "duration = 0.0 s"),
    (lambda: sk.Ramp(1.0, np.nan), "start"),
    (lambda: sk.Pulse(-1.0), "duration = -1.0 s"),
    (lambda: sk.Pulse(1.0, shape="square"), "shape = 'square'.*rectangle"),
])  # fmt: skip
def test_mistakes(build, words):
    with pytest.raises(InputError, match=words):
        build()


def test_cover():
    table = sk.Table([0.0, 1.0], [0.0, 1.0])
    for history in (None, sk.Ramp(1.0), lambda t: t):
        check_cover(history, -1e9, 1e9)
    check_cover(table, 0.0, 1.0)
    check_cover(table, 0.2, 1.0 + 1e-12)
    for begin, end in ((-0.1, 0.5), (0.5, 1.1)):
        with pytest.raises(InputError, match=rf"Table from t = 0 to 1 s does not cover the run from t = {begin} to {end} s"):
            check_cover(table, begin, end)


def test_a_system_checks_loads_and_prescribed_motion():
    table = sk.Table([0.0, 1.0], [0.0, 1.0])
    material = sk.Isotropic(1e6, 0.3, 1.0)
    loads = [sk.PointForce((0.5, 0.5), (0, 0, 1.0), table), sk.EdgeLoad("right", (0, 0, 1.0), table),
             sk.EdgeMoment("right", (0, 1.0, 0), table), sk.FollowerPressure(1.0, table), sk.Gravity(history=table),
             sk.SurfaceLoad((0, 0, 1.0), table), sk.Temperature(1.0, history=table),
             sk.DiskForce((0.5, 0.5), 0.1, (0, 0, 1.0), table),
             sk.LineLoad((0, 0.5), (1, 0.5), (0, 0, 1.0), table)]  # fmt: skip
    cases = [([sk.Clamp("left")], [load]) for load in loads]
    cases.append(([sk.Prescribed("left", (0, 0, 0.1), table)], []))
    for supports, acting in cases:
        for theory in ("kirchhoff", "full"):
            problem = sk.Problem(UNIT, 0.1, material, supports, acting)
            system = problem.on(sk.meshes.uniform(UNIT, 2, 2), theory)
            check_covers(system.histories(), 0.0, 1.0)
            with pytest.raises(InputError, match="does not cover the run"):
                check_covers(system.histories(), 0.0, 1.1)


@pytest.mark.parametrize("theory", ["kirchhoff", "full"])
def test_statics_takes_everything_as_given_whatever_its_history(theory):
    """The history is not even called: neither its largest value nor its last one is meant."""

    def never(time):
        raise AssertionError("statics has no time")

    def problem(history):
        law = sk.Isotropic(young=1e7, poisson=0.3, density=1e3, expansion=1e-5)
        supports = [sk.Clamp("left"), sk.Prescribed("right", (None, None, 0.02), history=history)]
        loads = [
            sk.EdgeLoad("right", (-3.0, 1.0, 0.0), history=history), sk.SurfaceLoad((0, 0, 0.5), history=history),
            sk.PointForce((0.5, 0.5), (0.0, 0.0, 0.1), history=history), sk.FollowerPressure(0.2, history=history),
            sk.EdgeMoment("right", (0.0, 0.1, 0.0), history=history), sk.Temperature(0.3, history=history),
        ]  # fmt: skip
        return sk.Problem(UNIT, 0.02, law, supports, loads)

    def answers(history):
        system = problem(history).on(sk.meshes.uniform(UNIT, 2, 2), theory)
        solved, traced = sk.solve(system).unwrap(), sk.trace(system, until=1.0).unwrap()
        pressed = sk.modes(system, 2, state=solved), sk.buckling(system, 1)
        best = sk.adapt(problem(history), sk.Displacement(at=(1.0, 0.5)), theory=theory, rtol=0.2)
        return [solved.q, traced.solution.q, sk.solve_linear(system).q, pressed[0].eigenvalues,
                pressed[1].load_factors, best.value]  # fmt: skip

    for given, plain in zip(answers(never), answers(None), strict=True):
        assert np.array_equal(given, plain)
