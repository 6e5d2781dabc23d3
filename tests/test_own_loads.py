"""Loads, supports, laws and step control of the user's own do in every analysis what the library's own do."""

from functools import cache

import numpy as np
import pytest

import skancf as sk
from skancf.elements.quad_ancf import square_quadrature
from skancf.kernels.constants import FOURTH, R_X, R_Y, R
from skancf.loads import Singularity
from skancf.loads.acting import Acting
from skancf.supports import Support
from skancf.theories.rows import Row, condition

PLATE, AT = sk.Rectangle(1.0, 1.0), (0.75, 0.5)
TIP = sk.Displacement((1.0, 0.5))
THEORIES = ["kirchhoff", "full"]
theories = pytest.mark.parametrize("theory", THEORIES)
pytestmark = pytest.mark.filterwarnings("ignore::skancf.OutOfDepth")  # thick, soft and coarse, so that runs are short
BEND = 0.037
"""A time at which a history bends, between the steps of a run that knows nothing of it."""


class Bends:
    """A function of time of one's own, with a corner."""

    knots = (BEND,)

    def __call__(self, t: float) -> float:
        return min(t, BEND) / BEND


class Follower:
    """Forces along the deformed normal, p (r_x x r_y) times a weight at points of elements: a pressure, or one force. That
    of one point grows with the area there, which no energy holds on small elements: it is for coarse meshes."""

    def __init__(self, size, at=None, history=None):
        self.size, self.at, self.history = size, at, history

    def on(self, assembly):
        return FollowerOnMesh(assembly.geometry, self)


class FollowerOnMesh(Acting):
    def __init__(self, geometry, load):
        self.geometry, self.load, self.history = geometry, load, load.history
        if load.at is None:
            points, weights = square_quadrature(5)
            self.elements = np.arange(geometry.n_elements)
        else:
            element, local = geometry.locate(load.at)
            self.elements, points = np.array([element]), local[:, None]
            slopes = np.einsum("gap,ai->gpi", geometry.theory.slope_table(points), geometry.undeformed_local[element])
            weights = 1 / np.linalg.norm(np.cross(*slopes), axis=1)
        self.values, self.slopes = geometry.theory.position_table(points)[0], geometry.theory.slope_table(points)
        self.amounts = load.size * weights * geometry.side[self.elements][:, None]

    def _tangents(self, q):
        return np.einsum("gap,eai->gepi", self.slopes, self.geometry.local(q, self.elements))

    def force(self, q, case):
        along = np.cross(*self._tangents(q)) * (case.amplitude(self.history) * self.amounts)[:, :, None]
        return self.geometry.nodal(np.einsum("ap,epi->eai", self.values, along), self.elements)

    def add_stiffness(self, q, case, blocks):
        (one, two), axes = self._tangents(q), np.eye(3)[:, None, None]
        turned = np.stack([np.cross(axes, two), np.cross(one, axes)])
        turned = turned * (case.amplitude(self.history) * self.amounts)[:, :, None]
        full = -np.einsum("ap,gjepi,gbp->eiajb", self.values, turned, self.slopes, optimize=True)
        blocks.add(self.elements, full.reshape(-1, 48, 48))

    def singularities(self, case):
        return [] if self.load.at is None else [Singularity("force", self.load.at, "a Follower", (0, 0, self.load.size))]


class Timed:
    """A dead force at a point, a function of time that is no ``history``."""

    def __init__(self, at, force, function):
        self.at, self.given, self.function = at, np.asarray(force, float), function

    def on(self, assembly):
        geometry = assembly.geometry
        element, local = geometry.locate(self.at)
        table = geometry.theory.position_table(local[:, None])[0, :, 0]
        nodal = geometry.nodal(np.multiply.outer(table, self.given)[None], np.array([element]))
        return TimedOnMesh(self, nodal)


class TimedOnMesh(Acting):
    def __init__(self, load, nodal):
        self.load, self.nodal = load, nodal

    def force(self, q, case):
        return case.factor * (1.0 if case.time is None else self.load.function(case.time)) * self.nodal

    def histories(self):
        return [self.load.function]

    def singularities(self, case):
        return [Singularity("force", self.load.at, "a Timed", self.load.given)]


class Held(Support):
    """A clamped left edge, by rows of its own, moved along z with a history."""

    holds = ("position", "normal")
    where = "left"

    def __init__(self, moved=0.0, history=None):
        self.moved, self.history = moved, history

    def rows(self, geometry):
        e = np.eye(3)
        along = [R_X, FOURTH] if geometry.theory.name == "kirchhoff" else []
        rows = []
        for node in np.flatnonzero(geometry.mesh.p[0] == 0.0):
            rows += [Row(int(node), condition({R: 1.0}, axis), self.moved * axis[2]) for axis in e]
            rows += [Row(int(node), condition({R_Y: 1.0}, axis)) for axis in e]
            rows += [Row(int(node), condition({kind: 1.0}, e[2])) for kind in along]
            rows += [] if along else [Row(int(node), condition({FOURTH: 1.0}, axis)) for axis in e]
        return rows


LAW = sk.Isotropic(1e6, 0.3, 1000.0, expansion=1e-4)


class OwnLaw:
    """A law with all a law may have."""

    density = LAW.density

    def __init__(self, like=LAW):
        self.like = like

    def stiffness(self):
        return self.like.stiffness()

    def thermal_strain(self):
        return self.like.thermal_strain()


class OwnSteps:
    """Always the same step."""

    smallest = 1e-6

    def __init__(self, dt):
        self.dt = dt

    def first(self, guess):
        return self.dt

    def accepts(self, attempt):
        return True

    def next_step(self, attempt):
        return min(self.dt, 2 * attempt.dt)


HEAT = sk.Temperature(2.0, 50.0)


def problem(own, moved=0.0, loads=None):
    if loads is None:
        force = (0.3, 0.1, -1.0)
        loads = ([Follower(-20.0, history=sk.Ramp(0.1)), Timed(AT, force, Bends())] if own else
                 [sk.FollowerPressure(-20.0, history=sk.Ramp(0.1)), sk.PointForce(AT, force, history=Bends())])  # fmt: skip
    support = Held(moved, Bends()) if own else sk.Clamp("left")
    return sk.Problem(PLATE, 0.05, OwnLaw() if own else LAW, [support], [HEAT, *loads])


@cache
def system(own, theory):
    return problem(own).on(sk.meshes.uniform(PLATE, 2, 2), theory)


# --- every analysis --------------------------------------------------------------------------------------------------


def linear(at):
    state = sk.solve_linear(at)
    return state.q, state.strain_energy, state.reactions(), state.section_forces()


def solve(at):
    state = sk.solve(at, rtol=1e-10).unwrap()
    return state.q, state.strain_energy, state.reactions(), state.section_forces()


def trace(at):
    path = sk.trace(at, until=1.0).unwrap()
    return path.solution.q, path.load_factors


def modes(at):
    return sk.modes(at, 4).eigenvalues, sk.modes(at, 4, state=sk.solve(at, rtol=1e-10).unwrap()).eigenvalues


def buckling(at):
    return (sk.buckling(at, 2).load_factors,)


def motion(rule):
    def run(at):
        found = sk.simulate(at, 0.12, dt=0.01, rule=rule, newton_rtol=1e-11, progress=False, balance=None, outputs=3)
        assert found.ok
        return found.q, found.ledger.times, *found.ledger.table().values()

    return run


def adapt(at):
    theory = at.geometry.theory
    found = sk.adapt(at.problem, TIP, 0.02 if theory.order == 4 else 0.2, theory=theory, mesh=at.mesh)
    return np.array([found.value, found.error_bar]), found.solution.system.mesh.p


ANALYSES = {"solve_linear": linear, "solve": solve, "trace": trace, "modes": modes, "buckling": buckling,
            "energy-momentum": motion(sk.EnergyMomentum()), "generalized alpha": motion(sk.GeneralizedAlpha()),
            "adapt": adapt}  # fmt: skip


@theories
@pytest.mark.parametrize("analysis", ANALYSES)
def test_everything_of_ones_own_is_like_the_librarys(analysis, theory):
    """Support, law, a load that follows and one that depends on time; up to the rounding of sums in another order."""
    own, ours = (ANALYSES[analysis](system(own, theory)) for own in (True, False))
    for mine, known in zip(own, ours, strict=True):
        mine, known = np.asarray(mine), np.asarray(known)
        assert mine.shape == known.shape
        # Newton's method ends at 1e-10 and below; eigenvalues and differences of energies have rounding on top.
        assert np.allclose(mine, known, rtol=1e-6, atol=1e-8 * np.abs(known).max(initial=1.0))
    assert any(np.any(np.asarray(part)) for part in own)


def test_a_small_difference_would_be_seen():
    """Of a thousandth of the load, and of a load whose stiffness is missing."""
    ours = screwed("kirchhoff", [sk.FollowerPressure(-20.0)])
    q, more = solve(ours)[0], solve(screwed("kirchhoff", [Follower(-20.02)]))[0]
    assert np.allclose(q, solve(screwed("kirchhoff", [Follower(-20.0)]))[0], rtol=1e-6, atol=1e-8)
    assert not np.allclose(q, more, rtol=1e-6, atol=1e-8)
    soft = type("Soft", (FollowerOnMesh,), {"add_stiffness": Acting.add_stiffness})
    load = type("Lazy", (Follower,), {"on": lambda self, assembly: soft(assembly.geometry, self)})(-20.0)
    found, known = (sk.modes(at, 2, state=sk.solve(at).unwrap()).eigenvalues for at in (screwed("kirchhoff", [load]), ours))
    assert not np.allclose(found, known, rtol=1e-6)


@theories
@pytest.mark.parametrize("kind", ["plane_stress", "3d"])
def test_a_law_of_ones_own(kind, theory):
    """Bit by bit; and theory `kirchhoff` condenses any law, where `full` takes it as it is."""
    like = sk.Isotropic(1e6, 0.3, 1000.0, kind=kind, expansion=1e-4)
    mesh, loads = sk.meshes.uniform(PLATE, 2, 2), [HEAT, sk.SurfaceLoad((0, 0, -1.0))]
    own, ours, plate = (sk.solve_linear(sk.Problem(PLATE, 0.05, law, [sk.Clamp("left")], loads).on(mesh, theory))
                        for law in (OwnLaw(like), like, LAW))  # fmt: skip
    assert np.array_equal(own.q, ours.q) and np.array_equal(own.section_forces(), ours.section_forces())
    assert np.array_equal(sk.modes(own.system, 2).eigenvalues, sk.modes(ours.system, 2).eigenvalues)
    same = np.allclose(own.q, plate.q, rtol=0, atol=1e-12)
    assert same == (kind == "plane_stress" or theory == "kirchhoff")


@theories
def test_a_support_of_ones_own_that_moves(theory):
    """As a clamp that is prescribed: in statics as given, in a run with its history, its reaction and work booked."""
    mesh, load = sk.meshes.uniform(PLATE, 2, 2), [sk.SurfaceLoad((0, 0, -1.0))]
    own, ours = (sk.Problem(PLATE, 0.05, LAW, supports, load).on(mesh, theory) for supports in (
        [Held(0.05, Bends())],
        [sk.Prescribed("left", (0.0, 0.0, 0.05), history=Bends(), rotation=(0, 0, 0)), sk.NoRotation("left")]))  # fmt: skip
    for analysis in (solve, motion(sk.EnergyMomentum())):
        for mine, known in zip(analysis(own), analysis(ours), strict=True):
            assert np.allclose(mine, known, rtol=1e-7, atol=1e-9 * np.abs(known).max(initial=1.0))
    ledger = run(own, sk.EnergyMomentum()).ledger
    assert np.abs(ledger.balance).max() < 1e-9 * ledger.turnover[-1] and abs(ledger.work[-1]) > 0.1 * ledger.turnover[-1]


def test_a_step_control_of_ones_own():
    at = system(False, "kirchhoff")
    own, ours = (sk.simulate(at, 0.05, rule=sk.EnergyMomentum(), steps=steps, balance=None, progress=False)
                 for steps in (OwnSteps(0.01), sk.FixedStep(0.01)))  # fmt: skip
    assert np.array_equal(own.q, ours.q) and np.array_equal(own.ledger.times, ours.ledger.times)


# --- what is booked --------------------------------------------------------------------------------------------------


def run(at, rule, n=12, **options):
    return sk.simulate(at, 0.12, dt=0.12 / n, rule=rule, newton_rtol=1e-11, progress=False,
                       **{"balance": None, "outputs": 3} | options)  # fmt: skip


def screwed(theory, loads):
    return sk.Problem(PLATE, 0.05, LAW, [sk.Clamp("left")], loads).on(sk.meshes.uniform(PLATE, 2, 2), theory)


@theories
def test_tangent_of_a_follower_of_ones_own(theory, rng):
    """With its skew part it is the derivative of the force."""
    at = screwed(theory, [Follower(-3.0, AT)])
    q = at.undeformed + 0.05 * rng.normal(size=at.n_dofs)
    along, eps, bare = rng.normal(size=at.n_dofs), 1e-6, screwed(theory, [])
    slope = (at.external_force(q + eps * along) - at.external_force(q - eps * along)) / (2 * eps)
    symmetric, skew = (at.tangent(q) @ along - bare.tangent(q) @ along), at.skew(q) @ along
    # Rounding of the strains' part, taken away, and of the differences.
    assert np.abs(symmetric + skew + slope).max() < 1e-6 * np.abs(slope).max()
    assert np.abs(skew).max() > 0.01 * np.abs(slope).max()


@theories
def test_work_of_loads_of_ones_own_is_booked(theory):
    """Energy and momenta balance to rounding; a dead force has done its integral over the path."""
    at = screwed(theory, [Timed(AT, (0.3, 0.1, -1.0), Bends()), Follower(-5.0, AT, history=Bends())])
    ledger = run(at, sk.EnergyMomentum()).ledger
    assert np.abs(ledger.balance).max() < 1e-9 * ledger.turnover[-1] and ledger.work[-1] > 0.5 * ledger.turnover[-1]
    sizes = np.abs([ledger.linear_impulse, ledger.angular_impulse]).max(axis=(1, 2))
    assert (np.abs(ledger.momentum_balance).max(axis=(0, 2)) < 1e-9 * sizes).all()
    force = np.array([0.3, 0.1, -1.0])
    alone = run(screwed(theory, [Timed(AT, force, lambda t: 1.0)]), sk.EnergyMomentum())
    moved = alone.at(0.12).displacement(AT)
    assert alone.ledger.work[-1] == pytest.approx(force @ moved, rel=1e-9)


def test_another_rule_balances_to_order_two():
    at = screwed("kirchhoff", [Timed(AT, (0.3, 0.1, -1.0), lambda t: np.sin(20 * t)), Follower(-5.0, AT)])
    coarse, fine = (np.abs(run(at, sk.GeneralizedAlpha(), n).ledger.balance).max() for n in (24, 48))
    assert 1.6 < np.log2(coarse / fine) < 3.5


@theories
def test_reactions_carry_a_load_of_ones_own(theory):
    """Forces and moments of the supports are those of the loads, in the deformed state of a force that follows."""
    state = sk.solve(screwed(theory, [Follower(-3.0, AT)]), rtol=1e-11).unwrap()
    load = state.system.external_force(state.q).reshape(-1, 4, 3)[:, 0].sum(axis=0)
    assert np.allclose(state.reactions(), -load, rtol=0, atol=1e-8)
    assert abs(load[0]) > 0.1, "it follows"
    assert sk.adaptive.Reaction().value(state) == pytest.approx(-load[2], rel=1e-8)


@pytest.mark.parametrize("load", ["history", "histories"])
def test_steps_end_where_a_history_of_ones_own_bends(load):
    """Of the attribute ``history``, and of a load that says :meth:`histories`; without knots steps pass over it."""

    def loads(function):
        return [Timed(AT, (0, 0, -1.0), function) if load == "histories" else Follower(-1.0, AT, function)]

    times, passed = (run(screwed("kirchhoff", loads(function)), sk.EnergyMomentum()).ledger.times
                     for function in (Bends(), Bends().__call__))  # fmt: skip
    assert np.abs(times - BEND).min() < 1e-12 < 1e-3 < np.abs(passed - BEND).min()


def test_a_table_that_does_not_cover_the_run_is_named():
    at = screwed("kirchhoff", [Timed(AT, (0, 0, -1.0), sk.Table([0.0, 0.1], [0.0, 1.0]))])
    with pytest.raises(sk.InputError, match="does not cover the run"):
        run(at, sk.EnergyMomentum())


def test_what_adapt_says_of_loads_of_ones_own():
    """A value within its bar of a finer run's, and no limit where a point force has none."""
    own = screwed("kirchhoff", [Timed(AT, (0.5, 0, -3.0), Bends())]).problem
    rough, fine = (sk.adapt(own, TIP, rtol) for rtol in (1e-2, 1e-3))
    assert rough.ok and fine.ok and abs(rough.value - fine.value) < rough.error_bar + fine.error_bar
    with pytest.raises(sk.NoLimit, match="a Follower acts there"):
        sk.adapt(screwed("kirchhoff", [Follower(-3.0, AT)]).problem, sk.SectionForce("M11", at=AT), 1e-2)
    with pytest.raises(sk.NoLimit, match="a Timed there sinks"):
        sk.adapt(screwed("full", [Timed(AT, (0, 0, -1.0), Bends())]).problem, sk.Displacement(AT), 1e-2, theory="full")


class Wrongly:
    """A load whose class on a mesh has some methods of one's own."""

    def __init__(self, **methods):
        self.methods = methods

    def on(self, assembly):
        return type("WronglyOnMesh", (Acting,), self.methods)()


def given(value):
    return lambda self, *_: value


@pytest.mark.parametrize("methods, message", [
    ({"force": given(np.zeros((3, 4, 3)))}, r"force of the load .* of shape \(3, 4, 3\); give finite numbers of shape"),
    ({"force": given(np.zeros(108))}, r"of shape \(108,\); give finite numbers of shape \(9, 4, 3\)"),
    ({"force": given(None)}, r"= None, of shape \(\); give finite numbers of shape \(9, 4, 3\)"),
    ({"force": given(np.full((9, 4, 3), np.nan))}, r"give finite numbers of shape \(9, 4, 3\)"),
    ({"force": given(np.zeros((9, 4, 3), complex))}, r"give finite numbers of shape \(9, 4, 3\)"),
    ({"initial_stresses": given(np.zeros(3))}, r"initial_stresses of the load .* of shape \(3,\); give"),
])  # fmt: skip
def test_loads_of_ones_own_are_looked_at_when_a_system_is_made(methods, message):
    problem = sk.Problem(PLATE, 0.1, sk.Isotropic(1e6, 0.3, 1e3), [sk.Clamp("left")], [Wrongly(**methods)])
    with pytest.raises(sk.InputError, match=message):
        problem.on(sk.meshes.uniform(PLATE, 2, 2))


@pytest.mark.parametrize("elements, matrices, message", [
    ([0], np.eye(12)[None], r"matrices of shape \(1, 12, 12\) for 1 elements: give \(1, 48, 48\)"),
    ([0], 1j * np.eye(48)[None], "of real numbers"),
    ([4], np.eye(48)[None], r"elements array\(\[4\]\): give whole numbers \(m,\) from 0 to 3"),
    ([-1], np.eye(48)[None], "from 0 to 3"), ([0.0], np.eye(48)[None], "give whole numbers"),
])  # fmt: skip
def test_stiffnesses_of_ones_own_are_looked_at_before_compiled_code_is(elements, matrices, message):
    load = Wrongly(add_stiffness=lambda self, q, case, blocks: blocks.add(np.array(elements), matrices))
    problem = sk.Problem(PLATE, 0.1, sk.Isotropic(1e6, 0.3, 1e3), [sk.Clamp("left")], [load])
    system = problem.on(sk.meshes.uniform(PLATE, 2, 2))
    for asked in (system.tangent, system.skew):
        with pytest.raises(sk.InputError, match=message):
            asked(system.undeformed)
