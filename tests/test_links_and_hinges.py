"""Statics with conditions: tied arches and hinged rings against formulas, half models and stiff springs."""

from dataclasses import dataclass

import numpy as np
import pytest
import scipy.sparse as sp

import skancf as sk
from skancf.conditions.rows import cells_of
from skancf.layout.layout import vectors
from skancf.terms import Addition, Term

YOUNG, R, T = 2e11, 1.0, 0.01
BEAM = sk.Isotropic(young=YOUNG, poisson=0.0, density=7800.0)
WIDTH = 0.05
D = YOUNG * T**3 / 12 * WIDTH
"""Bending stiffness of a ring, EI."""
ARCH = sk.CylinderSector(R, WIDTH, np.pi)
theories = pytest.mark.parametrize("theory", ["kirchhoff", "full"])
pytestmark = pytest.mark.filterwarnings("ignore:the sides 'start' and 'end'")


def arch(*joints, force=1.0, n=24, terms=(), theory="kirchhoff", supports=()):
    """A half ring, pinned at one foot, the other free to slide, loaded at the crown."""
    supports = [sk.Pin("start"), sk.Roller("end"), *supports]
    crown = [sk.LineLoad((0.0, np.pi / 2), (WIDTH, np.pi / 2), (0.0, 0.0, -force / WIDTH))]
    problem = sk.Problem(ARCH, T, BEAM, supports, crown, terms=list(terms), conditions=list(joints))
    return problem.on(sk.meshes.uniform(ARCH, 1, n), theory)


TIES = [sk.RigidLink((x, 0.0), (x, np.pi), name=f"tie at {x:g}") for x in (0.0, WIDTH)]


@theories
def test_the_thrust_of_a_tied_arch(theory):
    r"""Two hinges, half a circle, a force P at the crown: the thrust is :math:`P / \pi`, in two ties together.

    Stretch changes it by parts of (T / R)^2, and bilinear directors on 48 elements by 1e-3.
    """
    answer = sk.solve_linear(arch(*TIES, n=48, theory=theory))
    forces = list(answer.conditions.values())
    assert list(answer.conditions) == ["tie at 0", "tie at 0.05"]
    assert forces[0] == pytest.approx(forces[1], rel=1e-6)  # by symmetry
    assert sum(forces) == pytest.approx(1 / np.pi, rel={"kirchhoff": 2e-4, "full": 2e-3}[theory])
    assert answer.displacement((0.0, np.pi))[1] == pytest.approx(0.0, abs=1e-15)
    loose = sk.solve_linear(arch(theory=theory))
    assert abs(loose.displacement((0.0, np.pi))[1]) > 0.3 * R**3 / D  # what the ties hold back
    # Of the reactions there is none but the load: the thrust is within the body.
    assert np.abs(answer.reactions() - [0, 0, 1]).max() < 1e-9
    assert np.abs(answer.reactions("start") - [0, 0, 0.5]).max() < 1e-9


class SpringTerm(Term):
    r"""A spring :math:`\tfrac k2 (|d| - L)^2` between two points."""

    def __init__(self, stiffness, link, shell, layout):
        rows = shell.position_rows(*shell.geometry.locate_all(np.array([link.a, link.b]).T))
        self.shape, self.cells = sp.kron(rows[1] - rows[0], sp.eye(3)).tocsr(), cells_of(sp.csr_matrix(rows[1] - rows[0]))
        self.k, self.length = stiffness, np.linalg.norm(self.shape @ layout.undeformed.ravel())

    def couples(self):
        return self.cells

    def force(self, q, v, case):
        d = self.shape @ q
        return self.shape.T @ (self.k * (1 - self.length / np.linalg.norm(d)) * d)

    def add_tangent(self, q, v, case, blocks):
        d = self.shape @ q
        size, n = np.linalg.norm(d), d / np.linalg.norm(d)
        stiff = self.k * ((1 - self.length / size) * np.eye(3) + self.length / size * np.outer(n, n))
        shape = self.shape[:, (12 * self.cells[0][:, None] + np.arange(12)).ravel()]
        blocks.add(self.cells, (shape.T @ stiff @ shape)[None])

    def energy(self, q, case):
        return 0.5 * self.k * (np.linalg.norm(self.shape @ q) - self.length) ** 2


@dataclass(frozen=True)
class StiffSpring(Addition):
    stiffness: float
    link: sk.RigidLink

    def on(self, shell, layout):
        return SpringTerm(self.stiffness, self.link, shell, layout)


@theories
def test_a_rigid_link_is_the_limit_of_stiff_springs(theory):
    """A tied arch pressed down by a fifth of its radius: the difference falls as one over the stiffness."""
    force = 4 * D / R**2
    tied = sk.solve(arch(*TIES, force=force, theory=theory))
    assert tied.ok and abs(tied.solution.displacement((0.0, np.pi / 2))[2]) > 0.05 * R
    ends = tied.solution.position([(0.0, 0.0), (0.0, np.pi)])
    assert np.linalg.norm(ends[1] - ends[0]) == pytest.approx(2 * R, rel=1e-14)
    apart = []
    for k in (1e3, 1e4, 1e5):
        springs = [StiffSpring(k * D / R**3, tie) for tie in TIES]
        soft = sk.solve(arch(terms=springs, force=force, theory=theory)).unwrap()
        apart.append(np.abs(soft.q - tied.solution.q).max())
    assert np.diff(np.log10(apart)) == pytest.approx([-1, -1], abs=0.05) and apart[-1] < 1e-4 * R
    assert tied.negative_pivots == 0 and tied.iterations <= 8


RING, HALF = sk.CylinderSector(R, WIDTH, 2 * np.pi), sk.CylinderSector(R, WIDTH, np.pi)


def at(angle):
    return lambda x, y: abs(y - angle) < 1e-6


def hinged_ring(force, n=32, theory="kirchhoff", hinge=True, surface=RING):
    """A ring pushed by a force at its slit, along -y, held at the other end of the diameter."""
    load = [sk.EdgeLoad("start", (0.0, -force / WIDTH, 0.0))]
    conditions = [sk.Hinge("start", "end")] if hinge else []
    problem = sk.Problem(surface, T, BEAM, [sk.Clamp(at(np.pi))], load, conditions=conditions)
    return problem.on(sk.meshes.uniform(surface, 1, n), theory)


def half_ring(force, n=16, theory="kirchhoff"):
    """The same by symmetry, without conditions: the hinge stays on the diameter, and turns."""
    load = [sk.EdgeLoad("start", (0.0, -0.5 * force / WIDTH, 0.0))]
    problem = sk.Problem(HALF, T, BEAM, [sk.Clamp("end"), sk.Roller("start")], load)
    return problem.on(sk.meshes.uniform(HALF, 1, n), theory)


@theories
def test_a_hinged_ring_under_a_diametral_load(theory):
    r"""By beam theory :math:`\delta = (\pi/4 - 4/(3\pi)) P R^3 / EI`, and the hinge carries :math:`2 P / (3 \pi)` along the
    circle, P/2 along the diameter. Stretch adds parts of (T / R)^2; bilinear directors have errors of second order."""
    pushed = sk.solve_linear(hinged_ring(1.0, n=64, theory=theory))
    found = -pushed.displacement((WIDTH / 2, 0.0))[1] * D / R**3
    assert found == pytest.approx(np.pi / 4 - 4 / (3 * np.pi), rel={"kirchhoff": 2e-4, "full": 5e-3}[theory])
    carried = pushed.conditions["hinge"]
    assert np.abs(carried.total - [0.0, 0.5, -2 / (3 * np.pi)]).max() < {"kirchhoff": 2e-5, "full": 2e-4}[theory]
    if theory == "kirchhoff":  # even along the hinge; in `full` forces at edges have errors of first order
        assert np.abs(carried.per_length([0.0, 0.02, WIDTH]) * WIDTH - carried.total).max() < 1e-6
        assert np.abs(carried.at_ends).max() < 1e-6
    gap = pushed.displacement([(x, y) for x in (0.0, 0.02, WIDTH) for y in (0.0, 2 * np.pi)])
    assert np.abs(gap[::2] - gap[1::2]).max() < 1e-12 * np.abs(gap).max()
    half = sk.solve_linear(half_ring(1.0, n=32, theory=theory))
    difference = pushed.displacement((0.0, 1.0)) - half.displacement((0.0, 1.0))
    # Rounding of thin stiffness; in `full` half a ring leaves slopes free at its clamp.
    assert np.abs(difference).max() < {"kirchhoff": 1e-8, "full": 1e-6}[theory] * np.abs(gap).max()


def test_a_hinge_where_a_closed_ring_has_no_moment_changes_nothing():
    r"""A ring pulled by P along a diameter has no moment where the sine of the angle from the load is :math:`2 / \pi`; the
    diameter grows by :math:`(\pi/4 - 2/\pi) P R^3 / EI`."""
    slit = np.arcsin(2 / np.pi)
    grown = {}
    for closed in (False, True):
        ring = sk.CylinderSector(R, WIDTH, 2 * np.pi, start=slit, closed=closed)
        edges = np.concatenate([np.linspace(slit, np.pi, 25), np.linspace(np.pi, 2 * np.pi, 33)[1:],
                                np.linspace(2 * np.pi, 2 * np.pi + slit, 8)[1:]])  # fmt: skip
        mesh = sk.meshes.tensor(ring, [0.0, WIDTH], edges)
        load = [sk.LineLoad((0.0, 2 * np.pi), (WIDTH, 2 * np.pi), (0.0, -1.0 / WIDTH, 0.0))]
        conditions = [] if closed else [sk.Hinge("start", "end")]
        answer = sk.solve_linear(sk.Problem(ring, T, BEAM, [sk.Clamp(at(np.pi))], load, conditions=conditions).on(
            mesh, "kirchhoff"))  # fmt: skip
        grown[closed] = -answer.displacement((0.0, 2 * np.pi))[1] * D / R**3
    assert grown[True] == pytest.approx(np.pi / 4 - 2 / np.pi, rel=5e-4)  # stretch of the ring
    assert grown[False] == pytest.approx(grown[True], rel=1e-4)


@theories
@pytest.mark.parametrize("way", [1, -1])
def test_a_hinged_ring_far_from_its_circle(theory, way):
    """Pulled to half a radius, and pushed as far: the same as half a ring that needs no condition."""
    force = way * {1: 3.0, -1: 1.2}[way] * D / R**2
    whole, half = (sk.solve(make(force, theory=theory)) for make in (hinged_ring, half_ring))
    assert whole.ok and half.ok and whole.negative_pivots == half.negative_pivots == 0
    u, v = (found.solution.displacement((0.0, 0.0)) for found in (whole, half))
    assert abs(v[1]) > 0.3 * R and np.abs(u - v).max() < 1e-6 * R  # half a ring leaves slopes free at its clamp
    assert abs(whole.iterations - half.iterations) <= 2
    assert {"values of conditions, of their scales"} < {check.name for check in whole.checks}


def test_a_path_through_limit_points():
    """A ring pushed at its hinge snaps through: limit points at the loads of the half ring."""
    found = {}
    for make in (hinged_ring, half_ring):
        control = sk.DisplacementControl(at=(0.0, 0.0), direction=(0.0, 1.0, 0.0), to=1.9 * R)
        path = sk.trace(make(-2.0 * D / R**2, n={hinged_ring: 32, half_ring: 16}[make]), control)
        assert path.ok
        found[make] = [event.load_factor for event in path.events if event.kind == "limit point"], path
    whole, half = found[hinged_ring], found[half_ring]
    assert len(half[0]) and whole[0] == pytest.approx(half[0], rel=1e-6)
    state = whole[1].solutions[-1]
    assert state.conditions["hinge"].total[1] == pytest.approx(-state.load_factor * D / R**2, rel=1e-6)


def tube(n, theory="kirchhoff", around=16):
    """A short tube clamped along its back, hinged in front, with a load that varies along the hinge."""
    surface = sk.CylinderSector(R, 1.0, 2 * np.pi)
    load = sk.EdgeLoad("start", lambda x, y: [0 * x, -np.sin(2 * x) - x, 0 * x + 0.2 * x**2])
    problem = sk.Problem(surface, 0.1, sk.Isotropic(YOUNG, 0.3, 7800.0), [sk.Clamp(at(np.pi))], [load],
                         conditions=[sk.Hinge("start", "end")])  # fmt: skip
    return problem.on(sk.meshes.uniform(surface, n, around), theory)


FORCES = [("kirchhoff", (8, 16, 48), 0, 4e-3), ("full", (4, 8, 24), 4, 0.06)]


@pytest.mark.parametrize(("theory", "ns", "around", "last"), FORCES)
def test_the_force_along_a_hinge_is_of_second_order(theory, ns, around, last):
    """Against a mesh with more elements along it; not at its ends, where plates have corner forces. In `full` edges have
    layers as wide as the plate is thick, which take small elements around the tube, too."""
    s = np.linspace(0.26, 0.74, 65)
    along = [sk.solve_linear(tube(n, theory, around * n or 16)).conditions["hinge"].per_length(s) for n in ns]
    errors = [np.sqrt(((each - along[2]) ** 2).mean() / (along[2] ** 2).mean()) for each in along[:2]]
    assert np.log2(errors[0] / errors[1]) > 1.9 and errors[1] < last, errors


def braced(n, theory, force=2 * D / R**2, rods=True):
    """A two-hinged arch with rods between its quarter points: its thrust and the forces of the rods, over the load."""
    links = [sk.RigidLink((x, np.pi / 4), (x, 3 * np.pi / 4)) for x in (0.0, WIDTH)] if rods else []
    crown = [sk.LineLoad((0.0, np.pi / 2), (WIDTH, np.pi / 2), (0.0, 0.0, -force / WIDTH))]
    problem = sk.Problem(ARCH, T, BEAM, [sk.Pin("start"), sk.Pin("end")], crown, conditions=links)
    state = sk.solve(problem.on(sk.meshes.uniform(ARCH, 1, n), theory)).unwrap()
    return np.array([state.reactions("start")[1], sum(state.conditions.values())]) / force


@theories
def test_reactions_and_forces_of_links_are_of_second_order(theory):
    """In large deflections, on meshes that are halved, against one of 128 elements; `kirchhoff` is faster than that."""
    limit, *found = (braced(n, theory) for n in (128, 8, 16, 32))
    errors = np.abs(np.array(found) / limit - 1)
    assert (np.log2(errors[:-1] / errors[1:]) > 1.85).all(), errors  # 2 against the limit of the meshes, which is finer
    assert (errors[-1] < {"kirchhoff": 5e-5, "full": 4e-3}[theory]).all()
    assert limit[0] < 0.6 * braced(32, theory, rods=False)[0] and limit[1] > 0.5  # rods take most of the thrust


def test_forces_of_a_hinge_balance_the_load_on_one_side():
    """Of the load on one side of the slit reactions are the opposite; the total of a hinge is the sum of its parts."""
    answer = sk.solve_linear(tube(8))
    load = np.array([0.0, -(np.sin(1.0) ** 2) - 0.5, 0.2 / 3])
    assert np.abs(answer.reactions() + load).max() < 1e-6
    hinge = answer.conditions["hinge"]
    halves = hinge.ends[1:] - hinge.ends[:-1]
    middle = hinge.per_length(0.5 * (hinge.ends[1:] + hinge.ends[:-1]))
    assert np.abs(halves @ middle + hinge.at_ends.sum(axis=0) - hinge.total).max() < 1e-12 * np.abs(middle).max()
    with pytest.raises(sk.InputError, match="from 0 to 1 m"):
        hinge.per_length(1.1)


@theories
def test_rest_stays_at_rest(theory):
    system = hinged_ring(0.0, theory=theory)
    for state in (sk.solve(system).unwrap(), sk.solve_linear(system)):
        assert np.abs(state.displacements).max() < 1e-12 * R
        assert np.abs(state.multipliers).max() < 1e-12 * YOUNG * T and np.abs(state.reactions()).max() < 1e-12 * YOUNG * T


def test_conditions_that_depend_on_each_other_change_nothing():
    """The same tie twice shares its force; one between held points, and one along a held edge, has none."""
    ends = [sk.RigidLink((0.0, 0.0), (WIDTH, 0.0), name="held")]
    force = 4 * D / R**2
    once, twice = sk.solve(arch(*TIES, force=force)), sk.solve(arch(*TIES, *TIES, *ends, force=force))
    assert once.ok and twice.ok and twice.iterations == once.iterations
    assert np.abs(once.solution.q - twice.solution.q).max() < 1e-9 * R
    forces = list(twice.solution.conditions.values())
    assert forces[:2] == pytest.approx(forces[2:4], rel=1e-6) and forces[4] == 0.0
    assert sum(forces) == pytest.approx(sum(once.solution.conditions.values()), rel=1e-6)
    line, double = sk.solve_linear(arch(*TIES)), sk.solve_linear(arch(*TIES, *TIES, *ends))
    assert np.abs(line.change - double.change).max() < 1e-9 * np.abs(line.change).max()


@dataclass(frozen=True)
class Slides(sk.conditions.Joint):
    """A point moves along a direction, by so much at full load."""

    at: tuple
    direction: tuple
    by: float
    name: str = "slide"

    def on(self, shell, layout):
        return SlideCondition(self, shell, layout)


class SlideCondition(sk.conditions.Condition):
    n, scales = 1, np.ones(1)

    def __init__(self, given, shell, layout):
        rows = shell.position_rows(*shell.geometry.locate_all(np.array([given.at]).T))
        self.name, self.given, self.cells = given.name, given, cells_of(rows)
        self.row = sp.kron(rows, sp.csr_matrix([given.direction])).tocsr()
        self.start = self.row @ layout.undeformed.ravel()

    def couples(self):
        return self.cells

    def value(self, q, case):
        return self.row @ q - self.start - case.factor * self.given.by

    def gradient(self, q):
        return self.row


@theories
def test_a_condition_of_ones_own_moves_a_point(theory):
    """It does what a prescribed displacement does, in load steps, along a path and in a linear answer."""
    foot, way = (0.0, np.pi), (0.0, 1.0, 0.0)
    moves = [Slides((x, np.pi), way, -0.3 * R, name=f"foot at {x:g}") for x in (0.0, WIDTH)]
    given = arch(*moves, force=D / R**2, theory=theory)
    held = arch(force=D / R**2, theory=theory, supports=[sk.Prescribed([foot, (WIDTH, np.pi)], (None, -0.3 * R, None))])
    ways = (sk.solve_linear, lambda system: sk.solve(system).solution, lambda system: sk.trace(system, until=1.0).solution)
    for solver in ways:
        ours, theirs = solver(given), solver(held)
        assert ours.displacement(foot)[1] == pytest.approx(-0.3 * R, rel=1e-9)
        assert np.abs(ours.change - theirs.change).max() < 1e-6 * R
        pulled, reaction = sum(float(each[0]) for each in ours.conditions.values()), theirs.reactions("end")[1]
        assert pulled == pytest.approx(-reaction, rel=1e-5)


CONTRADICTIONS = {
    "two of one's own": ([Slides((0.0, np.pi), (0, 1, 0), 0.1, "out"), Slides((0.0, np.pi), (0, 2, 0), 0.3, "far out")],
                         [], "('out' and 'far out'|'far out' and 'out')"),
    "one and a support": ([Slides((0.0, 0.0), (0, 1, 0), 0.1, "out")], [], "'out' and what supports prescribe"),
    "a link between points that supports move apart": (
        [sk.RigidLink((0.0, 0.0), (0.0, np.pi), name="rod")], [sk.Prescribed((0.0, np.pi), (None, 0.1, None))],
        "'rod' and what supports prescribe"),
}  # fmt: skip


@pytest.mark.parametrize("case", CONTRADICTIONS)
def test_contradictions_are_named(case):
    joints, supports, words = CONTRADICTIONS[case]
    system = arch(*joints, supports=supports)
    for solver in (sk.solve, sk.solve_linear, sk.trace):
        with pytest.raises(sk.InputError, match=f"contradict each other: {words}"):
            solver(system)


def test_a_condition_of_ones_own_may_hold_a_rigid_motion():
    loose = sk.Problem(ARCH, T, BEAM, [sk.Roller("start"), sk.Roller("end")], [sk.EdgeLoad("left", (0.0, 0.0, -1.0))])
    mesh = sk.meshes.uniform(ARCH, 1, 12)
    with pytest.raises(sk.InputError, match="translation along x, translation along y"):
        sk.solve_linear(loose.on(mesh, "kirchhoff"))
    stops = [Slides((0.0, 0.0), (1, 0, 0), 0.0), Slides((0.0, 0.0), (0, 1, 0), 0.0), Slides((0.0, np.pi), (1, 0, 0), 0.0)]
    held = sk.Problem(ARCH, T, BEAM, loose.supports, loose.loads, conditions=stops).on(mesh, "kirchhoff")
    assert sk.solve_linear(held).conditions["slide 1"][0] == pytest.approx(0.0, abs=1e-6)
    with pytest.raises(sk.InputError, match="translation along x"):
        sk.solve_linear(sk.Problem(ARCH, T, BEAM, loose.supports, loose.loads, conditions=list(TIES)).on(mesh, "kirchhoff"))


def test_results_know_their_conditions():
    system = arch(*TIES)
    with pytest.raises(sk.InputError, match="no multipliers"):
        _ = sk.Solution(system, system.undeformed).conditions
    assert sk.solve_linear(arch()).conditions == {}
    with pytest.raises(sk.InputError, match="give 2 numbers"):
        sk.Solution(system, system.undeformed, multipliers=np.zeros(3))
    start = sk.solve(system, load_factor=0.5).unwrap()
    again = sk.solve(system, start=start)
    assert again.ok and np.abs(again.solution.q - sk.solve(system).solution.q).max() < 1e-9 * R
    turned = start.q.copy()
    vectors(turned)[::4] += 1.0
    assert system.conditions.met(system.conditions.value(turned))
