"""Equilibrium paths through limit points, snap-through and snap-back, and what stops load steps there."""

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest
import scipy.sparse as sp

import skancf as sk
from skancf.errors import DidNotConverge, InputError, SingularMatrix
from skancf.linear import BlockMatrix, BlockPattern, Constraints, DirectSolver, SkewSolver
from skancf.solving import Status
from skancf.statics import StepLength, newton
from skancf.statics.points import Follower
from skancf.statics.stopping import Constraint

# --- structures of one and two coordinates ---------------------------------------------------------------------------


class Springs:
    """A structure of n coordinates at one node, without supports, of unit mass."""

    def __init__(self, n):
        self.n = n
        self.pattern = BlockPattern.from_cells(np.zeros((1, 1), int), 1, n, np.zeros((2, 1)))
        self.constraints = Constraints(np.zeros((1, n), bool))
        self.undeformed = np.zeros(n)
        self.mass = BlockMatrix(self.pattern, np.eye(n)[None])

    def prescribed(self, time=None):
        return np.zeros(self.n)

    def stresses(self, q, change=None):
        return np.zeros(0)

    def external_force(self, q, case=None):
        return np.eye(self.n)[-1]

    def tangent(self, q, case=None, stresses=None):
        return BlockMatrix(self.pattern, self.stiffness(q)[None])


class Truss(Springs):
    """The shallow truss of von Mises: force u (u - 1) (u - 2), with limit points at u = 1 -+ 1 / sqrt(3)."""

    def __init__(self):
        super().__init__(1)

    def internal_force(self, q):
        return q**3 - 3 * q**2 + 2 * q

    def stiffness(self, q):
        return np.diag(3 * q**2 - 6 * q + 2)


class TrussBehindSpring(Springs):
    """The same truss, loaded at the far end v of a spring c: v snaps back where c is less than the truss's softening, 1."""

    def __init__(self, c):
        super().__init__(2)
        self.c = c

    def internal_force(self, q):
        u, v = q
        return np.array([u**3 - 3 * u**2 + 2 * u - self.c * (v - u), self.c * (v - u)])

    def stiffness(self, q):
        c = self.c
        return np.array([[3 * q[0] ** 2 - 6 * q[0] + 2 + c, -c], [-c, c]])


LIMIT = 2 / (3 * np.sqrt(3))
# Newton's tolerance in displacements is 1e-7; the load at a limit point feels its square and the search's, 1e-6 of a step.
SEARCH = 1e-6


def test_snap_through_of_a_truss():
    path = sk.trace(Truss(), until=1.0).unwrap()
    u = np.array([solution.q[0] for solution in path.solutions])
    assert np.allclose(path.load_factors, u**3 - 3 * u**2 + 2 * u, atol=1e-7)
    assert path.load_factors[-1] == pytest.approx(1.0, abs=1e-12) and u[-1] > 2
    assert (np.diff(u) > 0).all(), "it did not turn back"
    assert np.array_equal(path.negative_pivots, np.where(3 * u**2 - 6 * u + 2 < 0, 1, 0))
    assert path.negative_pivots.any(), "no point of the descending branch, so nothing was passed"
    assert [event.kind for event in path.events] == ["limit point"] * 2
    assert [event.load_factor for event in path.events] == pytest.approx([LIMIT, -LIMIT], abs=SEARCH)
    assert all(event.refined and abs(abs(event.mode[0]) - 1) < 1e-12 for event in path.events)
    places = [event.solution.q[0] for event in path.events]
    assert places == pytest.approx([1 - 1 / np.sqrt(3), 1 + 1 / np.sqrt(3)], abs=1e-3)


@pytest.mark.parametrize("c", [0.3, 3.0])
def test_snap_back_behind_a_soft_spring(c):
    """The load point turns back where the spring is softer than the falling truss, and there only."""
    path = sk.trace(TrussBehindSpring(c), sk.ArcLength(0.02), until=1.0).unwrap()
    u, v = np.array([solution.q for solution in path.solutions]).T
    assert np.allclose(v - u, path.load_factors / c, atol=1e-6), "the spring carries the load"
    assert np.allclose(u**3 - 3 * u**2 + 2 * u, path.load_factors, atol=1e-6)
    assert (np.diff(u) > 0).all()
    assert (np.diff(v) < 0).any() == (c < 1), "the turning point of the displacement"
    assert [event.load_factor for event in path.events] == pytest.approx([LIMIT, -LIMIT], abs=1e-5)
    assert all(event.kind == "limit point" for event in path.events)


class Buckling(Springs):
    """The truss with a sideways motion w, of which the stiffness c (u^3 - u0^3) changes its sign at u0."""

    def __init__(self, u0, c):
        super().__init__(2)
        self.u0, self.c = u0, c

    def internal_force(self, q):
        w, u = q
        return np.array([self.c * (u**3 - self.u0**3) * w, u**3 - 3 * u**2 + 2 * u + 1.5 * self.c * u**2 * w**2])

    def stiffness(self, q):
        w, u = q
        cross = 3 * self.c * u**2 * w
        down = 3 * u**2 - 6 * u + 2 + 3 * self.c * u * w**2
        return np.array([[self.c * (u**3 - self.u0**3), cross], [cross, down]])


@pytest.mark.parametrize("u0", [0.40, 0.45])
@pytest.mark.parametrize("c", [-100.0, 100.0])
def test_a_bifurcation_and_a_limit_point_in_one_step(u0, c):
    """They are told apart though pivots change by two, or by none: one is lost and one won."""
    path = sk.trace(Buckling(u0, c), sk.ArcLength(0.14), steps=6).unwrap()
    u = np.array([solution.q[1] for solution in path.solutions])
    between = (u > 0.40) & (u < 0.45)
    assert not between.any(), "a point between them, so that they were found in two steps"
    expected = [("limit point", LIMIT), ("bifurcation", u0**3 - 3 * u0**2 + 2 * u0)]
    found = [(event.kind, event.load_factor) for event in path.events[:2]]
    for (kind, load_factor), (expected_kind, value) in zip(found, expected if u0 > 0.42 else expected[::-1], strict=True):
        assert kind == expected_kind and load_factor == pytest.approx(value, abs=1e-5)
    sideways = [np.abs(event.mode[0]) for event in path.events[:2] if event.kind == "bifurcation"]
    assert sideways == pytest.approx([1.0], abs=1e-6) and all(event.refined for event in path.events[:2])


def test_a_motion_without_stiffness_is_not_taken_for_converged():
    """A mode a million times softer is far from its place, though that costs hardly any energy."""
    turn = np.sqrt(0.5) * np.array([[1.0, 1.0], [1.0, -1.0]])

    class Soft(Springs):
        def internal_force(self, q):
            stiff, soft = turn @ q
            return turn.T @ np.array([stiff, 1e-6 * (soft - 1.0) ** 3])

        def external_force(self, q, case=None):
            return turn.T @ np.array([1.0, 0.0])

        def stiffness(self, q):
            return turn.T @ np.diag([1.0, 3e-6 * (turn @ q - 1.0)[1] ** 2]) @ turn

    system = Soft(2)
    at_load = Constraint(np.zeros(2), 1.0, 1.0, np.zeros(2))
    with DirectSolver(system.pattern, system.constraints) as solver:
        result = newton(system, np.zeros(2), solver, load_factor=0.0, constraint=at_load, rtol=1e-3)
    assert result.ok and result.load_factor == pytest.approx(1.0, abs=1e-12)
    # Corrections of this cubic fall by a third each time: the last, sqrt(rtol) of a way of sqrt(2), leaves twice its size.
    assert turn @ result.q == pytest.approx([1.0, 1.0], abs=0.1)


def test_the_other_way_and_on_from_a_point():
    system = Truss()
    pulled = sk.trace(system, sk.ArcLength(-0.05), until=-0.5).unwrap()
    assert (np.diff(pulled.load_factors) < 0).all() and not pulled.events
    with pytest.raises(InputError, match="first = 0"):
        sk.ArcLength(0.0)


def test_the_number_of_steps_ends_a_path():
    path = sk.trace(Truss(), until=1.0, steps=3)
    assert path.status is Status.NOT_REACHED and len(path.solutions) == 4 and "these were all the steps" in path.message
    free = sk.trace(Truss(), steps=3)
    assert free.status is Status.CONVERGED and len(free.solutions) == 4 and free.message == ""


@pytest.mark.parametrize("below", [0.1, 1e-2, 1e-6])
def test_an_end_just_below_the_limit_point_is_on_the_way_up(below):
    """The step from 0.369 ends at 0.370 beyond the limit point at 0.385; the end lies in it, and not on the far branch."""
    path = sk.trace(Truss(), until=LIMIT * (1 - below)).unwrap()
    assert path.solution.load_factor == pytest.approx(LIMIT * (1 - below), rel=1e-12) and not path.events
    assert path.load_factors.max() == path.solution.load_factor and path.solution.q[0] < 1 - 1 / np.sqrt(3)


def test_an_end_that_was_passed_but_not_found_is_not_reached(monkeypatch):
    monkeypatch.setattr(Follower, "at_condition", lambda *_: None)
    path = sk.trace(Truss(), until=0.3)
    assert path.status is Status.NOT_REACHED and "between load factors" in path.message and "StepLength" in path.message
    # The smallest step is 1e-4 of the first one, which is a load of 0.05; what is discarded is beyond.
    assert 0.3 - 0.05e-4 < path.solution.load_factor < 0.3 and (np.diff(path.load_factors) > 0).all()


def test_a_path_that_fails_keeps_what_it_has():
    class Breaks(Truss):
        def internal_force(self, q):
            return super().internal_force(q) if q[0] < 0.6 else np.array([np.nan])

    path = sk.trace(Breaks(), until=1.0)
    assert path.status is Status.STEP_TOO_SMALL and len(path.solutions) > 5 and path.solutions[-1].q[0] > 0.59
    assert "the path stopped at load factor" in path.message and "not finite" in path.message
    assert [event.load_factor for event in path.events] == pytest.approx([LIMIT], abs=SEARCH)
    assert any(not attempt.ok for attempt in path.attempts)
    with pytest.raises(DidNotConverge, match="the path stopped"):
        path.unwrap()


@pytest.mark.parametrize(("error", "status"), [(KeyboardInterrupt, Status.INTERRUPTED), (ZeroDivisionError, Status.FAILED)])
def test_an_interruption_or_error_keeps_what_there_is(error, status):
    class Stops(Truss):
        calls = 0

        def internal_force(self, q):
            self.calls += 1
            if self.calls > 9:
                raise error("stop")
            return super().internal_force(q)

    path = sk.trace(Stops(), until=1.0)
    assert path.status is status and len(path.solutions) > 3
    if error is KeyboardInterrupt:
        result = sk.solve(Stops(), control=sk.HalveAndGrow(first=0.1, growth=1.0))
        assert result.status is Status.INTERRUPTED and len(result.path) > 2 and "load factor" in result.message


def test_a_corner_is_refused_with_a_message():
    """A stiffness that jumps sideways: the path has a corner of a right angle, and no step is short enough for it."""

    class Corner(Springs):
        def __init__(self):
            super().__init__(2)

        def internal_force(self, q):
            u, v = q
            return np.array([u - 1e3 * max(v - 1, 0.0), v])

        def stiffness(self, q):
            return np.eye(2)

    path = sk.trace(Corner(), sk.ArcLength(0.3), until=3.0)
    assert path.status is Status.TURNED_BACK and "another direction" in path.message
    # The first step is 0.3 and the smallest 1e-4 of it.
    assert path.solution.load_factor == pytest.approx(1.0, abs=1e-4) and not path.events


# --- shallow arch ----------------------------------------------------------------------------------------------------

LENGTH, THICKNESS, YOUNG = 10.0, 0.1, 1e6
RIGIDITY, STIFFNESS, WAVE = YOUNG * THICKNESS**3 / 12, YOUNG * THICKNESS, np.pi / LENGTH
CROWN, DOWN = (LENGTH / 2, 0.5), (0.0, 0.0, -1.0)


@dataclass(frozen=True)
class Arch:
    """z = rise sin(pi x / L)."""

    rise: float
    bounds = ((0.0, LENGTH), (0.0, 1.0))
    sides = ("left", "right", "near", "far")

    def position(self, x, y):
        x, y = np.broadcast_arrays(np.asarray(x, float), np.asarray(y, float))
        return np.stack([x, y, self.rise * np.sin(WAVE * x)])

    def derivatives(self, x, y):
        x, y = np.broadcast_arrays(np.asarray(x, float), np.asarray(y, float))
        zero = np.zeros(x.shape)
        return (np.stack([zero + 1, zero, self.rise * WAVE * np.cos(WAVE * x)]), np.stack([zero, zero + 1, zero]))


def arch(rise, n=16):
    """Pinned at both ends, under p sin(pi x / L), with p = E I (pi / L)^4 rise at load factor one."""
    amplitude = RIGIDITY * WAVE**4 * rise
    load = sk.SurfaceLoad(lambda x, y: np.stack([0 * x, 0 * x, -amplitude * np.sin(WAVE * x)]))
    problem = sk.Problem(Arch(rise), THICKNESS, sk.Isotropic(YOUNG, 0.0, 1.0), [sk.Pin("left"), sk.Pin("right")], [load])
    return problem.on(sk.meshes.uniform(problem.surface, n, 1))


def load_of(rise, a):
    """Load factor of the shallow sinusoidal arch of present rise a (Fung and Kaplan, 1952, NACA TN 2840)."""
    return (rise - a) / rise + STIFFNESS / RIGIDITY * (rise**2 - a**2) * a / (4 * rise)


RADIUS = THICKNESS / np.sqrt(12)


PULL = sk.EdgeLoad("right", (1.0, 0, 0))
CONTROLS = {"arc": sk.ArcLength(0.1), "crown": sk.DisplacementControl(CROWN, DOWN, 2.5 * 0.11)}


@pytest.mark.parametrize("control", CONTROLS.values(), ids=CONTROLS)
def test_snap_through_of_a_shallow_arch(control):
    """Both limit points, and with an arch so flat no other mode before them."""
    rise = 0.11
    system = arch(rise)
    until = sk.DisplacementReached(CROWN, DOWN, 2.5 * rise)
    path = sk.trace(system, control, until=until if isinstance(control, sk.ArcLength) else None).unwrap()
    crown = path.displacement(CROWN)[:, 2]
    assert crown[-1] == pytest.approx(-2.5 * rise, rel=1e-6)
    top = np.sqrt((rise**2 - 4 * RADIUS**2) / 3)
    expected = [load_of(rise, top), load_of(rise, -top)]
    assert [event.kind for event in path.events] == ["limit point"] * 2
    # The arch is taken as shallow there, and 16 elements are half a percent too stiff in bending.
    assert [event.load_factor for event in path.events] == pytest.approx(expected, abs=5e-3 * expected[0])
    assert np.array_equal(path.negative_pivots > 0, (crown < -rise + top) & (crown > -rise - top))
    # The whole path, relative to the highest load.
    assert np.abs(path.load_factors - load_of(rise, rise + crown)).max() < 2e-2 * np.abs(path.load_factors).max()
    # The initial stiffness continued is far off, so the curve is what was compared.
    linear = path.load_factors[1] / crown[1] * crown
    assert np.abs(linear - load_of(rise, rise + crown)).max() > 0.3 * np.abs(path.load_factors).max()


def test_an_arch_that_is_higher_bifurcates_first():
    """Its antisymmetric mode gets soft when the thrust is E I (2 pi / L)^2, before the limit point."""
    rise = 0.15
    path = sk.trace(arch(rise), sk.ArcLength(0.1), until=sk.DisplacementReached(CROWN, DOWN, 0.12)).unwrap()
    kinds = [event.kind for event in path.events]
    assert kinds[:2] == ["bifurcation", "limit point"]
    expected = load_of(rise, np.sqrt(rise**2 - 16 * RADIUS**2)), load_of(rise, np.sqrt((rise**2 - 4 * RADIUS**2) / 3))
    assert [event.load_factor for event in path.events[:2]] == pytest.approx(expected, rel=1e-2)
    start = path.solutions[0].q
    first, second = (sk.Solution(event.solution.system, start + event.mode) for event in path.events[:2])
    quarter = np.array([[LENGTH / 4, 0.5], [3 * LENGTH / 4, 0.5]])
    left, right = first.displacement(quarter)[:, 2]
    assert left == pytest.approx(-right, rel=1e-2), "antisymmetric"
    left, right = second.displacement(quarter)[:, 2]
    assert left == pytest.approx(right, rel=1e-2), "symmetric"


def test_displacement_control_names_its_turning_point():
    """The axial shortening of the arch's half has a maximum where the arch is flat: it cannot be prescribed beyond."""
    quarter = (LENGTH / 4, 0.5)
    by_arc = sk.trace(arch(0.11), sk.ArcLength(0.1), until=sk.DisplacementReached(CROWN, DOWN, 0.22)).unwrap()
    most = np.abs(by_arc.displacement(quarter)[:, 0]).max()
    sign = float(np.sign(by_arc.displacement(quarter)[1, 0]))
    path = sk.trace(arch(0.11), sk.DisplacementControl(quarter, (sign, 0, 0), 3 * most, first=0.02))
    assert path.status is Status.TURNED_BACK and "turning point" in path.message and "ArcLength()" in path.message
    assert np.abs(path.displacement(quarter)[-1, 0]) == pytest.approx(most, rel=0.05)
    with pytest.raises(InputError, match="is there already"):
        sk.trace(arch(0.15), sk.DisplacementControl(CROWN, DOWN, 0.0))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: sk.DisplacementControl(CROWN, (0, 0, 0), 1.0), r"direction = \(0, 0, 0\)"),
        (lambda: sk.DisplacementControl(CROWN, DOWN, 1.0, first=2.0), "first = 2.0"),
        (lambda: sk.DisplacementReached(CROWN, (0, 0, 0), 1.0), r"direction = \(0, 0, 0\)"),
        (lambda: StepLength(cut=1.0), "cut = 1.0"),
        (lambda: StepLength(smallest=2.0), "smallest = 2.0"),
        (lambda: StepLength(easy=0), "easy = 0"),
        (lambda: sk.trace(strip([]), steps=0), "steps = 0"),
        (lambda: sk.trace(strip([]), "arc"), "control = 'arc': give an ArcLength or a DisplacementControl"),
        (lambda: sk.solve(strip([]), control="x"), "control = 'x': give a HalveAndGrow"),
        (lambda: sk.solve(strip([]), control=sk.ArcLength()), "give a HalveAndGrow"),
        (lambda: sk.trace(strip([PULL]), sk.DisplacementControl((0.0, 0.0), DOWN, 1.0)), "does not move with the load"),
        (lambda: sk.trace(strip([PULL]), sk.DisplacementControl((LENGTH, 0.5), DOWN, 1.0)), "does not move with the load"),
        (lambda: sk.trace(strip([])), "nothing loads"),
        (lambda: sk.trace(strip([], [sk.Pin("left")])), "leave free"),
    ],
)
def test_inputs_that_cannot_be_used(make, message):
    with pytest.raises(InputError, match=message):
        make()


CLAMPED = (sk.Clamp("left"),)


def strip(loads, supports=CLAMPED, n=8):
    problem = sk.Problem(sk.Rectangle(LENGTH, 1.0), THICKNESS, sk.Isotropic(YOUNG, 0.0, 1.0), supports, loads)
    return problem.on(sk.meshes.uniform(problem.surface, n, 1))


EULER = np.pi**2 * RIGIDITY / (4 * LENGTH**2)


def test_a_straight_column_bifurcates_at_its_euler_load():
    path = sk.trace(strip([sk.EdgeLoad("right", (-EULER, 0, 0))]), sk.ArcLength(0.3), until=1.5).unwrap()
    assert path.load_factors[-1] == pytest.approx(1.5, abs=1e-9)
    assert [event.kind for event in path.events] == ["bifurcation"]
    # Eight elements are 0.3 % too stiff (the linear buckling load shows the same); the strain at buckling is 2e-4.
    assert path.events[0].load_factor == pytest.approx(1.0, rel=5e-3)
    assert path.negative_pivots[0] == 0 and path.negative_pivots[-1] == 1


def test_the_path_is_that_of_load_steps():
    """Where there is no limit point both ways give one equilibrium; also under a prescribed displacement alone."""
    for system in (strip([sk.EdgeLoad("right", (0, 0, 4 * RIGIDITY / LENGTH**2))]),
                   strip([], [sk.Clamp("left"), sk.Prescribed("right", (None, None, 5.0))])):  # fmt: skip
        steps = sk.solve(system, rtol=1e-9).unwrap()
        path = sk.trace(system, sk.ArcLength(0.1), until=1.0, rtol=1e-9).unwrap()
        # Two solves, each to 1e-9 in energy; lengths of 10.
        assert np.abs(path.solution.q - steps.q).max() < 1e-5 and path.solution.load_factor == pytest.approx(1.0, abs=1e-12)
        half = sk.trace(system, sk.ArcLength(0.1), until=0.5, rtol=1e-9).unwrap().solution
        on = sk.trace(system, sk.ArcLength(0.1), until=1.0, start=half, rtol=1e-9).unwrap()
        assert on.solutions[0] is not half and np.abs(on.solution.q - steps.q).max() < 1e-5
        assert on.load_factors[0] == half.load_factor


@dataclass(frozen=True)
class Roof:
    """A cylindrical panel over (axis, angle), of which the half from its middle to a curved edge is meshed."""

    radius: float = 2540.0
    half_length: float = 254.0
    half_angle: float = 0.1
    sides = ("middle", "edge", "left", "right")

    @property
    def bounds(self):
        return (0.0, self.half_length), (-self.half_angle, self.half_angle)

    def position(self, x, y):
        x, y = np.broadcast_arrays(np.asarray(x, float), np.asarray(y, float))
        return np.stack([x, self.radius * np.sin(y), self.radius * np.cos(y)])

    def derivatives(self, x, y):
        x, y = np.broadcast_arrays(np.asarray(x, float), np.asarray(y, float))
        zero = np.zeros(x.shape)
        return (np.stack([zero + 1, zero, zero]), np.stack([zero, self.radius * np.cos(y), -self.radius * np.sin(y)]))


def hinged_roof(thickness, n):
    """The hinged roof of Sze, Liu and Lo (2004), Finite Elements in Analysis and Design 40: 3000 at its centre."""
    problem = sk.Problem(Roof(), thickness, sk.Isotropic(3102.75, 0.3, 1e-6),
                         [sk.Pin(["left", "right"]), sk.Symmetry("middle")],
                         [sk.PointForce((0.0, 0.0), (0, 0, -1500.0))])  # fmt: skip
    return problem.on(sk.meshes.uniform(problem.surface, n, 2 * n))


def test_hinged_roof_snaps_through():
    """Their limit point is at 0.742 of the load, the minimum after it at 0.173, and 28.9 is the displacement at the end."""
    path = sk.trace(hinged_roof(12.7, 6), until=1.0).unwrap()
    assert [event.kind for event in path.events] == ["limit point"] * 2 and all(event.refined for event in path.events)
    # A mesh of 6 x 12 is within 1.5 %; its displacement at the flat top is not, but the load there is.
    assert [event.load_factor for event in path.events] == pytest.approx([0.7421, 0.1729], rel=1.5e-2)
    assert -path.displacement((0, 0))[-1, 2] == pytest.approx(28.88, rel=1.5e-2)
    assert len(path.solutions) < 30, "long steps"


def test_thin_hinged_roof_snaps_back():
    """At half the thickness load and displacement of the centre both turn back; displacement control cannot follow."""
    system = hinged_roof(6.35, 4)
    path = sk.trace(system, until=1.0).unwrap()
    centre = -path.displacement((0, 0))[:, 2]
    assert (np.diff(centre) < 0).any() and (path.load_factors < -0.05).any()
    limits = [event.load_factor for event in path.events if event.kind == "limit point"]
    assert len(limits) == 2 and limits[0] > 0 > limits[1]
    controlled = sk.trace(system, sk.DisplacementControl((0, 0), DOWN, 30.0))
    turn = np.flatnonzero(np.diff(centre) < 0)[0]
    assert controlled.status is Status.TURNED_BACK and "turning point" in controlled.message
    assert -controlled.displacement((0, 0))[-1, 2] == pytest.approx(centre[turn], rel=2e-2)


# --- diagnoses that load steps name -----------------------------------------------------------------------------------


def test_load_steps_name_a_limit_point():
    result = sk.solve(arch(0.11), load_factor=2.5, control=sk.HalveAndGrow(first=0.1, smallest=1e-3), relax=False)
    rise = 0.11
    top = load_of(rise, np.sqrt((rise**2 - 4 * RADIUS**2) / 3))
    assert result.status is Status.LIMIT_POINT, result.message
    assert result.solution.load_factor == pytest.approx(top, rel=2e-2)
    named = float(result.message.split("limit point near ")[1].split(",")[0])
    assert named == pytest.approx(top, rel=2e-2) and "trace(system, ArcLength())" in result.message


def test_loads_that_move_nothing_have_no_path_and_no_limit_point():
    """A force on a clamped edge: statics is at rest, and no compliance is divided by."""
    held = strip([sk.EdgeLoad("left", (0.0, 0.0, 5.0))])
    with pytest.raises(InputError, match="move nothing"):
        sk.trace(held, until=1.0)
    result = sk.solve(held)
    assert result.status is Status.CONVERGED and np.abs(result.solution.displacements).max() < 1e-12


def test_load_steps_name_a_mechanism():
    """A strip whose end is held by nothing: one element's stiffness is taken out of the tangent."""

    class Loose(Truss):
        def internal_force(self, q):
            return 0 * q

        def stiffness(self, q):
            return np.zeros((1, 1))

    result = sk.solve(Loose(), control=sk.HalveAndGrow(smallest=0.5))
    assert result.status is Status.MECHANISM and "mechanism" in result.message and "node 0" in result.message
    assert sk.trace(Loose(), until=1.0).status is Status.MECHANISM


def test_load_steps_name_a_folded_element():
    class Folds(Truss):
        def internal_force(self, q):
            return np.full(1, np.nan) if q.any() else super().internal_force(q)

        shell = SimpleNamespace(
            folded=lambda q: (3, (0.5, 0.25)) if q.any() else None, largest_turn=lambda change: 0.0
        )  # fmt: skip

    result = sk.solve(Folds(), control=sk.HalveAndGrow(smallest=0.5))
    assert result.status is Status.FOLDED and "Element 3 at (0.5, 0.25) folded" in result.message


@pytest.mark.parametrize("theory", ["full", "kirchhoff"])
def test_what_counts_as_folded(theory):
    """Three elements a side; the inner node (1/3, 1/3) belongs to the first, and the one at 2/3 beside it to the second."""
    problem = sk.Problem(sk.Rectangle(1.0, 1.0), 0.01, sk.Isotropic(1.0, 0.3, 1.0))
    system = problem.on(sk.meshes.uniform(problem.surface, 3, 3), theory)
    flat = system.undeformed.reshape(-1, 4, 3)
    inner = int(np.argmin(np.linalg.norm(flat[:, 0, :2] - 1 / 3, axis=1)))

    def moved(change):
        nodal = flat.copy()
        change(nodal)
        return system.shell.folded(nodal.ravel())

    def turn_over(v):
        v[..., 1:] *= -1

    def roll(v):
        """A right angle from one side of each element to the other."""
        k = 3 * np.pi / 2
        s, c = np.sin(k * v[:, 0, 0]), np.cos(k * v[:, 0, 0])
        v[:, 0, 0], v[:, 0, 2], v[:, 1, 0], v[:, 1, 2] = s / k, (1 - c) / k, c, s

    def turn_slope_over(v):
        v[inner, 1] *= -1

    def pass_the_next_node(v):
        v[inner, 0, 0] += 0.6

    def shrink(v):
        v *= 0

    assert moved(lambda v: None) is None and moved(turn_over) is None and moved(roll) is None
    assert moved(turn_slope_over)[0] == 0 and moved(shrink)[0] == 0
    element, place = moved(pass_the_next_node)
    assert np.abs(place[:2] - [0.5, 1 / 6]).max() < 1e-12, element


def test_an_unstable_equilibrium_with_a_following_load_says_what_is_counted():
    """A moment about the normal of a flat edge does nothing, and its tangent is skew."""
    pressed = sk.EdgeLoad("right", (-1.5 * EULER, 0, 0))
    cases = [pressed], [pressed, sk.EdgeMoment("right", (0, 0, 0.01))]
    plain, follows = (sk.solve(strip(loads), relax=False) for loads in cases)
    assert "flutter is not found" in follows.message and "flutter" not in plain.message and plain.message
    assert np.allclose(plain.solution.q, follows.solution.q, atol=1e-9)


def test_load_steps_say_where_stability_was_lost():
    pressed = strip([sk.EdgeLoad("right", (-1.5 * EULER, 0, 0))])
    result = sk.solve(pressed, control=sk.HalveAndGrow(first=0.1, growth=1.0), relax=False)
    assert result.status is Status.CONVERGED and result.negative_pivots == 1
    low, high = (float(w) for w in result.message.split("load factor ")[1].split(".  ")[0].split(". The")[0].split(" and "))
    assert low < 1 / 1.5 < high and high - low == pytest.approx(0.1, abs=1e-9)


# --- tangents with a skew part ---------------------------------------------------------------------------------------


def random_system(rng, skewness, n_nodes=5, block=3):
    """A positive matrix and a skew one on a chain of nodes, with a node fixed and another turned."""
    cells = np.array([np.arange(n_nodes - 1), np.arange(1, n_nodes)])
    pattern = BlockPattern.from_cells(cells, n_nodes, block, rng.random((2, n_nodes)))
    values = rng.standard_normal((pattern.n_blocks, block, block))
    diagonal = values[pattern.diagonal_slots]
    values[pattern.diagonal_slots] = diagonal + diagonal.transpose(0, 2, 1) + 20 * np.eye(block)
    upper = np.triu(rng.standard_normal((n_nodes * block,) * 2), 1)
    fixed = np.zeros((n_nodes, block), bool)
    fixed[0], fixed[2, 0] = True, True
    turn = np.linalg.qr(rng.standard_normal((block, block)))[0]
    constraints = Constraints(fixed, np.array([2]), turn[None])
    return BlockMatrix(pattern, values), sp.csr_matrix(skewness * (upper - upper.T)), constraints


@pytest.mark.parametrize("skewness", [0.0, 0.1, 2.0])
def test_skew_part_is_solved_for(rng, skewness):
    matrix, skew, constraints = random_system(rng, skewness)
    rhs = rng.standard_normal(matrix.shape[0])
    with DirectSolver(matrix.pattern, constraints) as solver:
        solver.factor(matrix)
        exact, plain = SkewSolver(matrix, skew, solver), SkewSolver(matrix, None, solver)
        x, without = exact.solve(rhs), plain.solve(rhs)
    # By a dense solve on the free coordinates.
    numbers = np.flatnonzero(~constraints.fixed.ravel())
    free = np.array([constraints.from_frame(e) for e in np.eye(matrix.shape[0])[numbers]])
    dense = matrix.to_scipy().toarray() + skew.toarray()
    expected = free.T @ np.linalg.solve(free @ dense @ free.T, free @ rhs)
    assert np.abs(x - expected).max() < 1e-7 * np.abs(expected).max()  # GMRES stops at 1e-9
    assert np.allclose(exact.multiply(x), dense @ x)
    assert (np.abs(without - expected).max() > 1e-3 * np.abs(expected).max()) == (skewness > 0), "the skew part matters"


def test_newton_uses_the_skew_part():
    """A force that turns with the coordinates, f = k x q: with the exact tangent a linear problem takes one step."""

    class Turning(Springs):
        k = 0.7

        def __init__(self):
            super().__init__(2)

        def internal_force(self, q):
            return 2.0 * q

        def stiffness(self, q):
            return 2.0 * np.eye(2)

        def external_force(self, q, case=None):
            return np.array([1.0 - self.k * q[1], self.k * q[0]])

        def skew(self, q, case):
            return sp.csr_matrix(case.factor * self.k * np.array([[0.0, 1.0], [-1.0, 0.0]]))

    class WithoutSkew(Turning):
        def skew(self, q, case):
            return None

    expected = np.linalg.solve([[2.0, 0.7], [-0.7, 2.0]], [1.0, 0.0])
    exact, crude = sk.solve(Turning(), rtol=1e-9), sk.solve(WithoutSkew(), rtol=1e-9)
    assert np.abs(exact.unwrap().q - expected).max() < 1e-9 and exact.iterations == 2
    assert np.abs(crude.unwrap().q - expected).max() < 1e-8 and crude.iterations > 5
    path = sk.trace(Turning(), until=1.0).unwrap()
    assert np.abs(path.solution.q - expected).max() < 1e-7


def test_a_skew_part_beyond_reach_is_an_error():
    matrix = BlockMatrix(BlockPattern.from_cells(np.zeros((1, 1), int), 1, 200, np.zeros((2, 1))), np.eye(200)[None])
    rng = np.random.default_rng(1)
    upper = np.triu(rng.standard_normal((200, 200)), 1) * 1e6
    with DirectSolver(matrix.pattern, Constraints(np.zeros((1, 200), bool))) as solver:
        solver.factor(matrix)
        with pytest.raises(SingularMatrix, match="skew part"):
            SkewSolver(matrix, sp.csr_matrix(upper - upper.T), solver).solve(np.ones(200))
