"""Modes and buckling with conditions: against the null space of their gradient, beams, a ring and a column."""

import sys
import warnings

import numpy as np
import pytest
import scipy.sparse as sp
from numpy.polynomial import legendre
from scipy.interpolate import BPoly
from scipy.linalg import eigh, null_space
from scipy.optimize import brentq

import skancf as sk
from skancf.conditions import Condition, Joint
from skancf.errors import InputError
from skancf.linear import DirectSolver
from skancf.statics import motions as motions_module
from skancf.statics.conditioned import curved
from skancf.statics.motions import HeldMotions, Motions, motions_of
from skancf.system.linearised import geometric_stiffness

STEEL = sk.Isotropic(young=2e11, poisson=0.3, density=7800.0)
BAR = sk.Isotropic(young=2e11, poisson=0.0, density=7800.0)
TUBE = sk.CylinderSector(radius=1.0, length=0.5, angle=2 * np.pi)
HINGE, ROD = sk.Hinge("start", "end"), sk.RigidLink((0.0, 0.5), (0.5, 2.5))
theories = pytest.mark.parametrize("theory", ["kirchhoff", "full"])


CLAMPED = (sk.Clamp("left"),)


def tube(joints, theory="kirchhoff", n=(2, 8), supports=CLAMPED, loads=()):
    problem = sk.Problem(TUBE, 0.01, STEEL, supports, loads, conditions=list(joints))
    return problem.on(sk.meshes.uniform(TUBE, *n), theory)


def null_basis(system, q):
    """Motions that meet the conditions, by singular values: rows (n, n_dofs)."""
    fixed = system.constraints.fixed.ravel()
    free = np.array([system.constraints.from_frame(e) for e in np.eye(fixed.size)[~fixed]])
    rows = system.conditions.gradient(q) @ free.T
    sizes = np.linalg.norm(rows, axis=1)
    return null_space(rows[sizes > 1e-10] / sizes[sizes > 1e-10, None], rcond=1e-10).T @ free


def reference(system, stiffness, other, q=None):
    """All eigenvalues of a pencil among those motions, with full matrices."""
    z = null_basis(system, system.undeformed if q is None else q)
    return eigh(z @ stiffness.to_scipy() @ z.T, z @ other.to_scipy() @ z.T, eigvals_only=True)


def worst(found, expected):
    return np.abs(np.asarray(found) / expected - 1).max()


# --- against full matrices -------------------------------------------------------------------------------------------


@theories
@pytest.mark.parametrize("joints", [(HINGE, ROD), (HINGE, ROD, ROD, HINGE)], ids=["independent", "redundant"])
def test_modes_are_those_of_the_null_space(theory, joints):
    """Ten by Lanczos' method, and all there are. Redundant conditions change neither their number nor any of them."""
    system = tube(joints, theory)
    expected = reference(system, system.stiffness(), system.mass)
    found = sk.modes(system, 10)
    assert found.ok and found.n_rigid == 0
    assert worst(found.eigenvalues, expected[:10]) < 1e-8
    gaps = np.array([system.conditions.gradient(system.undeformed) @ v for v in found.shapes])
    assert np.abs(gaps).max() < 1e-9 * np.abs(found.shapes).max()
    every = sk.modes(system, len(expected))
    # Full matrices have the rounding of the largest of them in all.
    assert np.abs(every.eigenvalues - expected).max() < 1e-11 * expected[-1] and every.ok
    with pytest.raises(InputError, match=f"at most the {len(expected)} motions that meet the conditions"):
        sk.modes(system, len(expected) + 1)
    assert worst(sk.modes(tube((), theory), 1).eigenvalues, expected[:1]) > 0.1, "the hinge matters"


@theories
def test_a_free_tube_has_its_six_rigid_motions(theory):
    system = tube((HINGE, ROD), theory, supports=())
    expected = reference(system, system.stiffness(), system.mass)
    found = sk.modes(system, 10)
    assert found.ok and found.n_rigid == 6
    assert worst(found.eigenvalues[6:], expected[6:10]) < 1e-7  # rounding of the full matrices, of which six are zero


@pytest.mark.parametrize(("passes", "stiffness"), [(1, 1e4), (2, 1e4), (3, 1e4), (1, 1e7), (2, 1e7)])
def test_the_bound_knows_how_well_conditions_are_met(monkeypatch, passes, stiffness):
    """A gap changes the eigenvalue by its work with the multipliers: the bound is above the error, and follows it."""
    monkeypatch.setattr(motions_module, "PASSES", passes)
    monkeypatch.setattr(motions_module, "STIFFNESS", stiffness)
    system = tube((HINGE, ROD))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = sk.modes(system, 10)
    error = worst(found.eigenvalues, reference(system, system.stiffness(), system.mass)[:10])
    assert found.checks[0].value > 0.9 * error or error < 1e-11
    assert found.checks[0].value < 20 * error + 1e-11
    assert found.ok == (found.checks[0].value < 1.1e-7)
    assert (error > 1e-4) == ((passes, stiffness) == (1, 1e4))


@theories
def test_modes_about_a_loaded_state_have_the_curvature_of_conditions(theory):
    loads = [sk.PointForce((0.5, 0.6), (0.0, 0.0, 4e6)), sk.PointForce((0.0, 2.0), (0.0, -4e5, 0.0))]
    system = tube((HINGE, sk.RigidLink((0.3, 0.5), (0.5, 2.5))), theory, loads=loads)
    state = sk.solve(system).unwrap()
    plain = system.tangent(state.q)
    whole = curved(system, plain, state.q, state.multipliers)
    found = sk.modes(system, 6, state=state)
    assert found.ok
    assert worst(found.eigenvalues, reference(system, whole, system.mass, state.q)[:6]) < 1e-8
    assert worst(found.eigenvalues, reference(system, plain, system.mass, state.q)[:6]) > 1e-4, "the curvature matters"
    with pytest.raises(InputError, match="no multipliers"):
        sk.modes(system, 6, state=sk.Solution(system, state.q))


def test_what_theory_kirchhoff_leaves_out_of_frequencies(monkeypatch):
    """Against theory `full`, of bending out of the plane. The choice of a theory sees the same."""
    monkeypatch.setattr(sys.modules[__name__], "THICKNESS", 0.05)
    with pytest.warns(sk.OutOfDepth, match="leaves out"):
        thin = sk.modes(column(), 6)
    thick = sk.modes(column(n=48, theory="full"), 6)
    said, seen = thin.theory_errors, thick.frequencies / thin.frequencies - 1
    assert worst(said[[0, 2]], seen[[0, 2]]) < 0.1 and said[2] < -0.01  # what is left is the error of the second mesh
    shares = [tube(joints, "auto").choice.share for joints in ((HINGE, ROD), ())]
    errors = [sk.modes(tube(joints), 1).theory_errors[0] for joints in ((HINGE, ROD), ())]
    assert worst(shares, 1 / (1 + np.array(errors)) ** 2 - 1) < 1e-3
    assert abs(shares[0] / shares[1] - 1) > 0.1, "conditions take part"


def test_numbers_of_eigenvalues_are_right_near_each():
    system = tube((HINGE, ROD, ROD))
    expected = reference(system, system.stiffness(), system.mass)
    with DirectSolver(system.pattern, system.constraints) as solver:
        motions = motions_of(system, solver, system.undeformed, system.stiffness())
        assert type(motions) is HeldMotions
        for k in range(12):
            for share in (1 - 1e-4, 1 + 1e-4):
                motions.factor(system.stiffness() + (-share * expected[k]) * system.mass)
                assert motions.negative_pivots == np.count_nonzero(expected < share * expected[k])


def test_without_conditions_the_direct_solver_is_asked(monkeypatch):
    monkeypatch.setattr(motions_module, "HeldMotions", None)
    system = tube(())
    with DirectSolver(system.pattern, system.constraints) as solver:
        motions = motions_of(system, solver, system.undeformed, system.stiffness())
        assert type(motions) is Motions and motions.solve == solver.solve
    assert sk.modes(system, 2).ok


# --- a ring with a hinge ---------------------------------------------------------------------------------------------


def hinged_ring(n, degree=24):
    r""":math:`\omega^2 \rho A R^4 / E I` of in-plane motions of a ring that does not stretch and has one hinge, (n,).

    Ritz's method with the tangential motion v, a polynomial of the angle; the radial one is v' and turns by v'' + v, both
    sides of the hinge as they like:
    :math:`\int (v''' + v')(\delta v''' + \delta v') = \Omega^2 \int v \delta v + v' \delta v'`.
    """
    x, weights = legendre.leggauss(degree + 5)
    every = np.eye(degree + 1)

    def table(points, order):
        return np.pi**-order * np.array([np.broadcast_to(legendre.legval(points, legendre.legder(c, order)), points.shape)
                                         for c in every])  # fmt: skip

    v = [table(x, order) for order in range(4)]
    bent = v[3] + v[1]
    ends = np.array([table(np.array([-1.0, 1.0]), order) @ [1.0, -1.0] for order in (0, 1)])
    z = null_space(ends)
    stiffness, mass = (bent * weights) @ bent.T, (v[0] * weights) @ v[0].T + (v[1] * weights) @ v[1].T
    return eigh(z.T @ stiffness @ z, z.T @ mass @ z, eigvals_only=True)[3 : 3 + n]


RING = sk.CylinderSector(radius=1.0, length=0.1, angle=2 * np.pi)
ENDS = [sk.Roller(end, (1, 0, 0)) for end in ("left", "right")]


def ring(mesh, theory="kirchhoff", joints=(HINGE,)):
    """The same five numbers, of a ring that is 0.01 thick and stays in its plane."""
    modes = sk.modes(sk.Problem(RING, 0.01, BAR, ENDS, conditions=list(joints)).on(mesh, theory), 8)
    assert modes.ok and modes.n_rigid == 3
    return modes.eigenvalues[3:] * BAR.density * 12 / (BAR.young * 0.01**2)


# Theory `kirchhoff` is of fourth order until stretching is seen, which changes the numbers by some 1e-5; `full` of second.
@pytest.mark.parametrize(("theory", "final", "rate"), [("kirchhoff", 1e-4, 10), ("full", 7e-3, 3.5)])
def test_a_ring_with_a_hinge(theory, final, rate):
    expected = hinged_ring(5)
    # Two lobes that bend nothing at the hinge are those of a whole ring: n^2 (n^2 - 1)^2 / (n^2 + 1).
    assert expected[1] == pytest.approx(7.2, rel=1e-9) and expected[3] == pytest.approx(57.6, rel=1e-9)
    coarse, fine = (worst(ring(sk.meshes.uniform(RING, 1, n), theory), expected) for n in (32, 64))
    assert fine < final and rate * fine < coarse
    with pytest.warns(sk.OutOfDepth, match="not joined"):
        assert worst(ring(sk.meshes.uniform(RING, 1, 32), theory, ()), expected) > 0.3


@theories
def test_a_hinge_between_edges_of_other_meshes(theory):
    mesh = sk.meshes.uniform(RING, 1, 32)
    finer = sk.meshes.quadtree(mesh, RING)
    for _ in range(2):
        finer = finer.refined(np.flatnonzero(finer.p[1][finer.t].min(axis=0) < 1e-9))
    assert worst(ring(finer, theory), ring(mesh, theory)) < {"kirchhoff": 1e-4, "full": 1e-2}[theory]


# --- two strips and a link -------------------------------------------------------------------------------------------

LENGTH, WIDTH, THICKNESS = 1.0, 0.05, 0.01


def strips(n, joints):
    """Two strips, one above the other, that begin at one clamped panel; mesh lines leave its bend to the panel."""
    across = BPoly.from_derivatives([0.0, 1.0], [[WIDTH, 1.0, 0.0], [WIDTH, -1.0, 0.0]])
    height = BPoly.from_derivatives([0.0, 1.0], [[0.0, 0.0, 0.0], [0.3, 0.0, 0.0]])

    def place(x, y):
        u = np.clip(y - WIDTH, 0.0, 1.0)
        flat = np.where(y < 0.5, y, 1 + 2 * WIDTH - y)
        return [x, np.where(u * (1 - u) > 0, across(u), flat), height(u)]

    surface = sk.MappedSurface(place, ((-0.1, LENGTH), (0.0, 1 + 2 * WIDTH)))
    x = np.array([-0.1, *np.linspace(0, LENGTH, n + 1)])
    y = np.array([0.0, *np.linspace(WIDTH, 1 + WIDTH, 11), 1 + 2 * WIDTH])
    mesh = sk.meshes.tensor(surface, x, y, openings=[((0.0, LENGTH), (WIDTH, 1 + WIDTH))])
    root = [sk.Clamp(lambda x, y: x < 1e-9)]
    return sk.Problem(surface, THICKNESS, BAR, root, conditions=list(joints)).on(mesh, "kirchhoff")


def test_two_cantilevers_whose_tips_a_link_ties():
    """Together they move as one alone, beta L = 1.8751, 4.6941; against each other the link holds the tips: 3.9266, 7.0686.
    Sideways it holds nothing."""
    link = sk.RigidLink((LENGTH, WIDTH / 2), (LENGTH, 1 + 1.5 * WIDTH))
    expected = np.array([1.87510407, 3.92660231, 4.69409113, 7.06858275])
    errors = []
    for n in (4, 8):
        modes = sk.modes(strips(n, [link]), 6)
        numbers = (modes.omega * np.sqrt(12 * BAR.density / BAR.young) * LENGTH**2 / THICKNESS) ** 0.5
        errors.append(np.abs(numbers[[0, 1, 4, 5]] / expected - 1))
    assert modes.ok and (errors[1] < [3e-6, 3e-5, 1e-4, 3e-4]).all() and (errors[0] > 8 * errors[1]).all()
    tips = modes.shape(0, 1.0).displacement([(LENGTH, WIDTH / 2), (LENGTH, 1 + 1.5 * WIDTH)])[:, 2]
    assert tips[0] == pytest.approx(tips[1], rel=1e-9) and abs(tips[0]) == pytest.approx(1.0, rel=1e-3)
    apart = sk.modes(strips(4, []), 2)
    assert apart.eigenvalues[1] == pytest.approx(apart.eigenvalues[0], rel=1e-6), "without it each moves alone"


# --- a column under a pendulum ---------------------------------------------------------------------------------------

ROOT, GAP = 0.1, 0.5
PRESSED = BAR.young * WIDTH * THICKNESS**3 / 12 / LENGTH**2 * (
    brentq(lambda x: np.sin(x) - x * (1 + GAP / LENGTH) * np.cos(x), 0.1, np.pi / 2) ** 2
)  # fmt: skip
r"""Force at which a clamped column buckles that is pressed by a link of length a whose other end stays on its line: the tip
is pushed aside by P w(L) / a, so that :math:`\tan k L = k (L + a)`, :math:`k^2 = P / E I`. A dead force has k L = pi/2."""


def column(load=1.0, n=8, theory="kirchhoff", joints=()):
    """A column and, beside and above it, a frame on rollers that presses a link down onto its tip."""
    width = WIDTH + 0.1
    surface = sk.Rectangle(ROOT + LENGTH + GAP + 0.1, width, origin=(-ROOT, 0.0))
    end = LENGTH + GAP
    mesh = sk.meshes.tensor(
        surface, [-ROOT, *np.linspace(0, LENGTH, n + 1), end, end + 0.1], [0.0, WIDTH, 0.1, width],
        openings=[((0.0, end), (WIDTH, 0.1)), ((LENGTH, end), (0.0, WIDTH))],
    )  # fmt: skip

    def frame(x, y):
        return (x > LENGTH + GAP / 2) | ((y > 0.1 - 1e-9) & (x > 1e-9))

    link = sk.RigidLink((LENGTH, WIDTH / 2), (end, WIDTH / 2), name="pendulum")
    supports = [sk.Clamp(lambda x, y: x < 1e-9), sk.Roller(frame, (0, 0, 1)), sk.Roller(frame, (0, 1, 0))]
    loads = [sk.EdgeLoad("right", (-load / width, 0, 0))]
    return sk.Problem(surface, THICKNESS, BAR, supports, loads, conditions=[link, *joints]).on(mesh, theory)


def critical_load():
    """Load on the frame at which the link has the force that buckles the column; the frame takes the rest."""
    return -PRESSED / sk.solve_linear(column()).conditions["pendulum"]


@pytest.mark.parametrize(("theory", "n", "tolerance"), [("kirchhoff", 4, 1e-5), ("kirchhoff", 8, 1e-5), ("full", 8, 4e-3)])
def test_a_column_under_a_pendulum(theory, n, tolerance):
    found = sk.buckling(column(1.0, n, theory), 2, signs="both")
    assert found.ok
    force = -found.load_factors * found.linear.conditions["pendulum"]
    assert force[0] == pytest.approx(PRESSED, rel=tolerance)
    euler = np.pi**2 / 4 * BAR.young * WIDTH * THICKNESS**3 / 12 / LENGTH**2
    assert force[0] < 0.5 * euler  # as it would be without the curvature of the link


def test_buckling_is_that_of_the_null_space():
    system = column(joints=[sk.RigidLink((0.6, 0.0), (LENGTH + GAP, 0.0), name="strut")])
    found = sk.buckling(system, 4)
    load = geometric_stiffness(system, found.linear.change)
    for geometric, right in ((curved(system, load, system.undeformed, found.linear.multipliers), True), (load, False)):
        inverse = -reference(system, geometric, system.stiffness())
        expected = np.sort(1.0 / inverse[inverse > 0])[:4]
        assert (worst(found.load_factors, expected) < 1e-8) == right
    again = sk.buckling(column(joints=[sk.RigidLink((0.6, 0.0), (LENGTH + GAP, 0.0))] * 3), 4)
    assert worst(again.load_factors, found.load_factors) < 1e-8 and again.ok, "redundant conditions change nothing"


def test_the_first_frequency_vanishes_where_the_column_buckles():
    load = critical_load()
    at_rest = sk.modes(column(), 1).eigenvalues[0]
    for share in (0.5, 1.0):
        system = column(share * load)
        about = sk.modes(system, 1, state=sk.solve_linear(system)).eigenvalues[0]
        # Nearly linear in the load: the first mode is not quite the buckled shape.
        assert about == pytest.approx((1 - share) * at_rest, rel=5e-2, abs=1e-5 * at_rest)


class Shortened(Joint):
    """The tip of a strip moves along its axis, by so much at the load factor one."""

    def __init__(self, y, short):
        self.y, self.short = y, short

    def on(self, shell, layout):
        return Shortening(self, shell, layout)


class Shortening(Condition):
    name, n, scales = "shortening", 1, np.ones(1)

    def __init__(self, given, shell, layout):
        rows = shell.position_rows(*shell.geometry.locate_all(np.array([[LENGTH], [given.y]])))
        self.row = sp.csr_matrix(sp.kron(rows, [[1.0, 0.0, 0.0]]))
        self.cells, self.start, self.short = np.unique(self.row.indices // 12)[None], layout.undeformed.ravel(), given.short

    def couples(self):
        return self.cells

    def value(self, q, case):
        return self.row @ (q - self.start) + case.factor * self.short

    def gradient(self, q):
        return self.row


@pytest.mark.parametrize(("theory", "tolerance"), [("kirchhoff", 1e-5), ("full", 4e-3)])
def test_a_condition_that_moves_buckles_a_column(theory, tolerance):
    """At the shortening of Euler's load, which nothing else brings about."""
    strip, short = sk.Rectangle(LENGTH, WIDTH), np.pi**2 / 48 * THICKNESS**2 / LENGTH
    tips = [Shortened(y, short) for y in (0.0, WIDTH / 2, WIDTH)]
    problem = sk.Problem(strip, THICKNESS, BAR, [sk.Clamp("left")], conditions=tips)
    system = problem.on(sk.meshes.uniform(strip, 8, 1), theory)
    found = sk.buckling(system, 1)
    assert found.ok and found.load_factors[0] == pytest.approx(1.0, rel=tolerance)
    path = sk.trace(system, until=1.05)
    (event,) = path.unwrap().events
    assert event.kind == "bifurcation" and event.load_factor == pytest.approx(found.load_factors[0], rel=2e-5)
    force = sum(float(each[0]) for each in path.solution.conditions.values())
    assert force == pytest.approx(1.05 * short * BAR.young * WIDTH * THICKNESS / LENGTH, rel=1e-4)


def test_paths_know_where_the_column_buckles():
    load = critical_load()
    for share, unstable in ((0.99, 0), (1.01, 1)):
        system = column(share * load)
        result = sk.solve(system, relax=False)
        modes = sk.modes(system, 2, state=result.solution)
        assert result.negative_pivots == modes.n_unstable == unstable and modes.ok
    events = sk.trace(column(1.1 * load), steps=10).events
    assert events[0].kind == "bifurcation" and events[0].load_factor == pytest.approx(1 / 1.1, rel=1e-5)
