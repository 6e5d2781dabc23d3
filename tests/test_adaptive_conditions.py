"""Estimates, adaptive meshes and states on other meshes with conditions: hinges and links are made anew on each mesh."""

import dataclasses

import numpy as np
import pytest
import scipy.sparse as sp

import skancf as sk
from skancf.adaptive.interpolation import multipliers_on

YOUNG, R, T, WIDTH = 2e11, 1.0, 0.01, 0.05
BEAM = sk.Isotropic(young=YOUNG, poisson=0.0, density=7800.0)
D = YOUNG * T**3 / 12 * WIDTH
"""Bending stiffness of a ring, EI."""
RING, HALF = sk.CylinderSector(R, WIDTH, 2 * np.pi), sk.CylinderSector(R, WIDTH, np.pi)
TIP = sk.Displacement((WIDTH / 2, 0.0), (0, -1, 0))
theories = pytest.mark.parametrize("theory", ["kirchhoff", "full"])
pytestmark = pytest.mark.filterwarnings("ignore:the sides 'start' and 'end'")


def ring(force):
    """Pulled at its hinge, held at the other end of the diameter."""
    load = [sk.EdgeLoad("start", (0.0, -force / WIDTH, 0.0))]
    held = [sk.Clamp(lambda x, y: abs(y - np.pi) < 1e-6)]
    return sk.Problem(RING, T, BEAM, held, load, conditions=[sk.Hinge("start", "end")])


def half(force):
    """The same by symmetry, without conditions."""
    load = [sk.EdgeLoad("start", (0.0, -0.5 * force / WIDTH, 0.0))]
    return sk.Problem(HALF, T, BEAM, [sk.Clamp("end"), sk.Roller("start")], load)


def arch(force, ties=True):
    """Pressed down at its crown, its feet tied."""
    rods = [sk.RigidLink((x, 0.0), (x, np.pi), name=f"tie at {x:g}") for x in (0.0, WIDTH)] if ties else []
    crown = [sk.LineLoad((0.0, np.pi / 2), (WIDTH, np.pi / 2), (0.0, 0.0, -force / WIDTH))]
    return sk.Problem(HALF, T, BEAM, [sk.Pin("start"), sk.Roller("end")], crown, conditions=rods)


def tree(problem, n, across=1):
    return sk.meshes.quadtree(sk.meshes.uniform(problem.surface, across, n))


def solved(problem, n, theory, linear=False):
    system = problem.on(tree(problem, n), theory)
    return sk.solve_linear(system) if linear else sk.solve(system).unwrap()


@theories
@pytest.mark.parametrize("linear", [True, False])
def test_the_estimate_of_a_hinged_ring_is_that_of_half_a_ring(theory, linear):
    """Which needs no condition. Contributions of elements are the same, too, those at the hinge among them."""
    force = 1.0 if linear else 3.0 * D / R**2
    whole, part = (solved(make(force), n, theory, linear) for make, n in ((ring, 16), (half, 8)))
    of_whole, of_part = (sk.goal_estimate(state, TIP) for state in (whole, part))
    assert of_whole.value == pytest.approx(of_part.value, rel=5e-6)
    # In small elements at the corners of a hinge its two sides part by little; half a ring leaves slopes free at its clamp.
    assert of_whole.error == pytest.approx(of_part.error, rel=3e-3)
    assert of_whole.indicators.sum() == pytest.approx(of_part.indicators.sum(), rel=0.01)
    better = of_whole.better
    assert better.system.conditions.met(better.system.conditions.value(better.q))
    energy = [sk.residual_indicator(state).sum() for state in (whole, part)]
    assert energy[0] == pytest.approx(2 * energy[1], rel=0.16)  # bubbles of the two edges at the hinge count apart


@theories
def test_estimates_of_a_tied_arch_against_finer_meshes(theory):
    """In large deflections, of a displacement, of the energy, and of a mean moment."""
    force = 4.0 * D / R**2
    state, fine = (solved(arch(force), n, theory) for n in (16, 64))
    numbers = [sk.Displacement((WIDTH / 2, np.pi / 2), (0, 0, -1)), sk.StrainEnergy(),
               sk.SectionForce("M22", within=((0.0, WIDTH), (np.pi / 4, np.pi / 2)))]  # fmt: skip
    for number in numbers:
        found, true = sk.goal_estimate(state, number), number.value(fine) - number.value(state)
        assert found.error / true == pytest.approx(1.1, abs=0.15), number
        assert found.bar > abs(true)


def lopsided(n=8):
    """A ring whose elements are half as long beside one side of its hinge, and across it."""
    mesh = tree(ring(1.0), n, 2)
    return mesh.refined(np.flatnonzero(mesh.p[1, mesh.t].mean(axis=0) < 0.8))


def varying(force):
    load = [sk.EdgeLoad("start", lambda x, y: [0 * x, -force / WIDTH * (1 + x / WIDTH) ** 2, 0 * x])]
    return dataclasses.replace(ring(force), loads=load)


def test_a_hinge_between_elements_that_do_not_match():
    """Refined, it has other rows, which the interpolated answer does not quite meet; the estimate counts that."""
    problem = varying(1.0)
    mesh = lopsided().refined()
    state, fine = (sk.solve_linear(problem.on(each, "kirchhoff")) for each in (mesh, mesh.refined().refined()))
    assert len(mesh.hanging) and state.conditions["hinge"].ends.size == 5
    number = sk.Displacement((0.0, 0.0), (0, -1, 0))
    found, true = sk.goal_estimate(state, number), number.value(fine) - number.value(state)
    assert found.error == pytest.approx(0.8 * true, rel=0.2) and found.bar > abs(true)


@theories
@pytest.mark.parametrize("linear", [True, False])
def test_adapt_with_a_hinge(theory, linear):
    """To the answer of half a ring on a fine mesh, within the error bar; elements are quartered and merged at the hinge."""
    force = 1.0 if linear else 3.0 * D / R**2
    rtol = {"kirchhoff": 1e-3, "full": 3e-2}[theory]
    result = sk.adapt(ring(force), TIP, rtol=rtol, mesh=sk.meshes.uniform(RING, 1, 16), theory=theory, linear=linear)
    assert result.status.ok, result.message
    expected = TIP.value(solved(half(force), 48, "kirchhoff", linear))
    slack = {"kirchhoff": 2e-4, "full": 1e-3}[theory]  # of the finer answer and, in `full`, of shear
    assert abs(result.value - expected) < result.error_bar + slack * expected
    state = result.solution
    assert len(result.levels) > 1 and (len(state.system.mesh.hanging) or (theory, linear) == ("full", True))
    ends = state.position([(x, y) for x in (0.0, 0.02, WIDTH) for y in (0.0, 2 * np.pi)])
    assert np.abs(ends[::2] - ends[1::2]).max() < 1e-9 * R
    assert state.conditions["hinge"].total[1] / force == pytest.approx(0.5, abs=2e-3)


def test_links_that_pull_at_points_are_told():
    """They sink as point supports do: across the surface in theory `full`, along it in both."""
    plate = sk.Rectangle(1.0, 1.0)
    flat = sk.Problem(plate, T, BEAM, [sk.Clamp("boundary")], conditions=[sk.RigidLink((0.3, 0.5), (0.7, 0.5))])
    for problem, found in ((flat, {"kirchhoff": "mean of a region", "full": "mean of a region"}),
                           (arch(1.0), {"kirchhoff": None, "full": "take theory 'kirchhoff'"}),
                           (ring(1.0), {"kirchhoff": None, "full": None})):  # fmt: skip
        for theory, words in found.items():
            system = problem.on(tree(problem, 4), theory)
            said = sk.adaptive.drift(system)
            assert said is None if words is None else ("a RigidLink pulls at single points" in said and words in said)
            assert sk.adaptive.no_limit(sk.StrainEnergy(), system) is None
    moment = sk.SectionForce("N11", at=(0.3, 0.5))
    assert "a RigidLink acts there" in sk.adaptive.no_limit(moment, flat.on(tree(flat, 10, 10), "kirchhoff"))


@pytest.mark.filterwarnings("ignore:a RigidLink pulls at single points")
@theories
def test_adapt_with_links(theory):
    force, rtol = 4.0 * D / R**2, {"kirchhoff": 1e-3, "full": 1e-2}[theory]
    crown = sk.Displacement((WIDTH / 2, np.pi / 2), (0, 0, -1))
    result = sk.adapt(arch(force), crown, rtol=rtol, mesh=sk.meshes.uniform(HALF, 1, 8), theory=theory)
    expected = crown.value(solved(arch(force), 64, "kirchhoff"))
    assert result.status.ok and abs(result.value - expected) < result.error_bar + 1e-3 * expected
    assert abs(crown.value(solved(arch(force, ties=False), 16, "kirchhoff")) / expected - 1) > 0.5
    feet = result.solution.position([(0.0, 0.0), (0.0, np.pi)])
    assert np.linalg.norm(feet[1] - feet[0]) == pytest.approx(2 * R, rel=1e-12)


def braced(force=1.0):
    """A cantilever whose tip hangs on rods from its clamp: supports carry what the rods pull."""
    surface = sk.CylinderSector(R, WIDTH, np.pi / 2)
    rods = [sk.RigidLink((x, 0.0), (x, np.pi / 2)) for x in (0.0, WIDTH)]
    load = [sk.LineLoad((0.0, np.pi / 4), (WIDTH, np.pi / 4), (0.0, force / WIDTH, force / WIDTH))]
    return sk.Problem(surface, T, BEAM, [sk.Clamp("start")], load, conditions=rods)


@theories
@pytest.mark.parametrize("linear", [True, False])
def test_reactions_that_rods_pull_at(theory, linear):
    """The whole reaction is minus the load on any mesh; its gradient has the curvature of rods that pull at supports."""
    force = 1.0 if linear else 2.0 * D / R**2
    state = solved(braced(force), 8, theory, linear)
    number = sk.Reaction("start", (0, 1, 0))
    assert number.value(state) == pytest.approx(-force, rel=1e-6)
    assert abs(sum(state.conditions.values())) > 0.05 * force
    found = sk.goal_estimate(state, number)
    assert abs(found.error) < 1e-5 * force
    step = 1e-6 * np.random.default_rng(0).standard_normal(state.q.size)
    ahead, behind = (dataclasses.replace(state, q=state.q + s * step, small=None) for s in (1, -1))
    rate = 0.5 * (number.value(ahead) - number.value(behind))
    assert number.gradient(state) @ step == pytest.approx(rate, rel=1e-5)


@theories
def test_a_state_on_another_mesh_has_its_forces(theory):
    problem = varying(D / R**2)
    mesh = lopsided()
    state = sk.solve(problem.on(mesh, theory)).unwrap()
    s = np.linspace(0.001, WIDTH - 0.001, 9)
    for other in (mesh.refined(), mesh.refined([0, 5])):
        there = sk.transfer(state, problem.on(other, theory))
        conditions = there.system.conditions
        assert conditions.met(conditions.value(there.q))
        one, two = (each.conditions["hinge"].per_length(s) for each in (state, there))
        assert np.abs(one - two).max() < 1e-9 * np.abs(one).max()
        again = sk.solve(there.system, start=there)
        assert again.ok and again.iterations <= {"kirchhoff": 6, "full": 8}[theory]
    back = sk.transfer(sk.transfer(state, problem.on(mesh.refined(), theory)), state.system)
    assert np.abs(back.multipliers - state.multipliers).max() < 1e-9 * np.abs(state.multipliers).max()
    merged = sk.transfer(state, problem.on(mesh.coarsened(np.arange(mesh.nelements)), theory))
    assert merged.system.conditions.met(merged.system.conditions.value(merged.q))
    assert np.abs(merged.conditions["hinge"].total - state.conditions["hinge"].total).max() < 0.1 * D / R**2


def test_a_hinge_counts_from_the_same_end_on_every_mesh():
    problem = varying(1.0)
    mesh = tree(problem, 8)
    for each in (mesh, mesh.refined([0]), mesh.refined([7]), lopsided()):
        state = sk.solve_linear(problem.on(each, "kirchhoff"))
        ends = state.conditions["hinge"].per_length([0.0, WIDTH]) @ [0, 1, 0]
        assert ends[1] > 2 * ends[0] > 0


def test_states_without_multipliers_are_refused():
    state = solved(ring(1.0), 8, "kirchhoff", linear=True)
    bare = dataclasses.replace(state, multipliers=None)
    for ask in (lambda: sk.goal_estimate(bare, TIP), lambda: sk.residual_indicator(bare)):
        with pytest.raises(sk.InputError, match="no multipliers, and its system has conditions: 'hinge'"):
            ask()
    assert multipliers_on(state, state.system) is not None


@pytest.mark.filterwarnings("ignore:theory 'kirchhoff' leaves out")
@pytest.mark.parametrize("loaded", [False, True])
def test_adapt_a_frequency(loaded):
    """The second one of a hinged ring, which is symmetric, against that of half a ring; about its loaded state too."""
    force, found = 2.0 * D / R**2, []
    for problem, number, n in ((ring(force), 1, 16), (half(force), 0, 8)):
        mesh = sk.meshes.uniform(problem.surface, 1, n)
        found.append(sk.adapt(problem, sk.Eigenfrequency(number, loaded=loaded), rtol=5e-3, mesh=mesh))
    whole, part = found
    assert whole.status.ok and part.status.ok
    assert whole.value == pytest.approx(part.value, rel=5e-3)
    assert whole.levels[0].value == pytest.approx(part.levels[0].value, rel=5e-4)  # half a ring leaves slopes free
    assert whole.levels[0].error == pytest.approx(part.levels[0].error, rel=0.02)


def test_adapt_a_buckling_load():
    result = sk.adapt(arch(D / R**2), sk.BucklingLoad(), rtol=2e-3, mesh=sk.meshes.uniform(HALF, 1, 8))
    fine = sk.buckling(arch(D / R**2).on(sk.meshes.uniform(HALF, 1, 48), "kirchhoff"), 1).load_factors[0]
    loose = sk.buckling(arch(D / R**2, ties=False).on(sk.meshes.uniform(HALF, 1, 24), "kirchhoff"), 1).load_factors[0]
    assert result.status.ok and abs(result.value - fine) < result.error_bar + 2e-4 * fine
    assert abs(loose / fine - 1) > 0.1


def test_what_shear_adds_with_conditions():
    """Against theory `full` on meshes that go to its limit, at second order; a hinge and a rod across take part."""
    surface, t = sk.CylinderSector(R, 0.5, 2 * np.pi), 0.1
    load = sk.EdgeLoad("start", lambda x, y: [0 * x, -YOUNG * t**3 / 12 * (1 + x), 0 * x])
    rod = sk.RigidLink((0.25, np.pi / 2), (0.25, 3 * np.pi / 2))
    problem = dataclasses.replace(ring(1.0), surface=surface, thickness=t, material=sk.Isotropic(YOUNG, 0.3, 7800.0),
                                  loads=[load], conditions=[sk.Hinge("start", "end"), rod])  # fmt: skip
    thin = sk.solve_linear(problem.on(sk.meshes.uniform(surface, 4, 48), "kirchhoff"))
    thick = [sk.solve_linear(problem.on(sk.meshes.uniform(surface, n, 8 * n), "full")) for n in (4, 8)]
    for number in (sk.Displacement((0.25, 0.0), (0, -1, 0)), sk.StrainEnergy()):
        values = [number.value(state) for state in thick]
        limit = values[1] + (values[1] - values[0]) / 3
        found = sk.theory_error(thin, number)
        # To 0.02 on meshes of 16 elements and more across.
        assert found.value == pytest.approx(limit - number.value(thin), rel=0.12) and found.share > 0.04
    bent = sk.solve(ring(2.0 * D / R**2).on(sk.meshes.uniform(RING, 1, 24), "kirchhoff")).solution
    of_half = sk.solve(half(2.0 * D / R**2).on(sk.meshes.uniform(HALF, 1, 12), "kirchhoff")).solution
    shares = [sk.theory_error(state, TIP).share for state in (bent, of_half)]
    assert shares[0] == pytest.approx(shares[1], rel=1e-3)


@pytest.mark.filterwarnings("ignore:theory 'kirchhoff' leaves out")
@pytest.mark.parametrize(("thickness", "name"), [(0.01, "kirchhoff"), (0.3, "full")])
def test_the_theory_is_chosen_with_conditions(thickness, name):
    problem = dataclasses.replace(ring(2.0 * D / R**2), thickness=thickness)
    assert problem.on(sk.meshes.uniform(RING, 1, 16), "auto").geometry.theory.name == name


@theories
def test_meshes_that_follow_a_motion_with_conditions(theory):
    """A hinged tube with a rod across, thrown and struck: nothing pulls from outside, and momenta stay."""
    surface = sk.CylinderSector(R, 0.5, 2 * np.pi)
    joints = [sk.Hinge("start", "end"), sk.RigidLink((0.25, 1.0), (0.25, 4.0), name="rod")]
    free = sk.Problem(surface, 0.05, sk.Isotropic(1e6, 0.3, 1000.0), conditions=joints)
    system = free.on(tree(free, 12, 2), theory)
    v = sk.RigidVelocity((0.5, 0.0, 1.0), (1.0, 2.0, 0.5), about=(0.0, 0.0, 0.0)).at(system.undeformed).reshape(-1, 4, 3)
    _, y, z = system.undeformed.reshape(-1, 4, 3)[:, 0].T
    v[:, 0, 2] += 2 * np.exp(-(y**2 + (z + 1) ** 2) / 0.1)
    motion = sk.simulate(system, 0.08, dt=4e-3, velocity=v.ravel(), newton_rtol=1e-9, outputs=3, progress=False,
                         follow=sk.Follow(0.3, every=5), balance=None)  # fmt: skip
    ledger = motion.ledger
    assert motion.ok and ledger.events and ledger.events[0].after > ledger.events[0].before
    for momentum in (ledger.linear, ledger.angular):
        # Newton's method leaves 1e-9 of the energy norm in each step, a change of mesh 1e-12.
        assert np.abs(momentum - momentum[0]).max() < 1e-9 * np.abs(momentum[0]).max()
    assert np.abs(ledger.balance).max() < 1e-9 * ledger.turnover[-1]
    for state in motion.states:
        assert state.system.conditions.met(1e-2 * state.system.conditions.value(state.q))


@theories
def test_a_moving_state_on_another_mesh_keeps_conditions_and_momenta(theory, rng):
    """On one where elements at the hinge are merged, whose rows are fewer."""
    free = sk.Problem(sk.CylinderSector(R, 0.5, 2 * np.pi), 0.05, BEAM, conditions=[sk.Hinge("start", "end")])
    fine = free.on(tree(free, 8, 2).refined([0, 1, 15]), theory)
    x = fine.undeformed.reshape(-1, 4, 3)[:, 0]
    rates = np.zeros((len(x), 4, 3))
    rates[:, 0] = np.sin(x @ rng.normal(size=(3, 3))) + rng.normal(size=3)
    start = sk.Solution(fine, fine.undeformed, rates.ravel(), time=0.0)
    start = dataclasses.replace(start, velocity=sk.remap(start, fine).v)
    for mesh in (fine.mesh.refined([2, 5]), fine.mesh.coarsened(np.arange(fine.mesh.nelements))):
        other = free.on(mesh, theory)
        there = sk.remap(start, other)
        conditions = other.conditions
        assert conditions.met(conditions.value(there.q))
        assert np.abs(conditions.gradient(there.q) @ there.v).max() < 1e-9 * np.abs(there.v).max()
        momenta = there.change.momenta
        assert np.abs(momenta[1] - momenta[0]).max() < 1e-10 * np.abs(momenta[0]).max()
        assert there.change.raised == 0.0


@theories
@pytest.mark.parametrize("linear", [True, False])
def test_the_force_of_a_condition_as_a_quantity(theory, linear):
    """Of a tie, and of a hinge along the circle; the estimate against a finer mesh, and what `adapt` finds of it."""
    force = 1.0 if linear else 2.0 * D / R**2
    for problem, number, n in ((arch(force), sk.ConditionForce("tie at 0"), 8), (varying(force), ALONG, 16)):
        state, fine = solved(problem, n, theory, linear), solved(problem, 48, theory, linear)
        found, true = sk.goal_estimate(state, number), number.value(fine) - number.value(state)
        assert found.bar > abs(true) and abs(found.error - true) < {"kirchhoff": 3e-3, "full": 0.05}[theory] * force
    assert number.value(state) == pytest.approx(state.conditions["hinge"].total[2], rel=1e-14)
    across = sk.goal_estimate(state, sk.ConditionForce("hinge", (0, 1, 0)))
    assert across.value == pytest.approx(7 / 6 * force, rel=1e-6) and abs(across.error) < 1e-6 * force  # by equilibrium


ALONG = sk.ConditionForce("hinge", (0, 0, 1))


def test_adapt_the_force_of_a_hinge():
    result = sk.adapt(ring(1.0), ALONG, rtol=1e-3, mesh=sk.meshes.uniform(RING, 1, 16), linear=True)
    assert result.status.ok and result.unit == "N"
    assert abs(result.value + 2 / (3 * np.pi)) < result.error_bar + 5e-5  # of a beam; stretch adds parts of (T / R)^2


WRONG_FORCES = {
    "no such condition": (sk.ConditionForce("rod"), "no such condition; there are: 'hinge', 'rigid link'"),
    "a hinge without a direction": (sk.ConditionForce("hinge"), "give a direction"),
    "a link with one": (sk.ConditionForce("rigid link", (0, 0, 1)), "leave the direction out"),
}


@pytest.mark.parametrize("case", WRONG_FORCES)
def test_forces_that_are_none(case):
    number, words = WRONG_FORCES[case]
    rod = sk.RigidLink((0.0, 1.0), (0.0, 5.0))
    problem = dataclasses.replace(ring(1.0), conditions=[sk.Hinge("start", "end"), rod])
    state = solved(problem, 8, "kirchhoff", linear=True)
    for ask in (number.value, lambda each: sk.goal_estimate(each, number)):
        with pytest.raises(sk.InputError, match=words):
            ask(state)
    with pytest.raises(sk.InputError, match="no multipliers"):
        sk.ConditionForce("rigid link").value(dataclasses.replace(state, multipliers=None))


class MovedFoot(sk.conditions.Joint):
    """A foot of the arch moves inwards, by a condition of its own."""

    def __init__(self, x):
        self.x = x

    def on(self, shell, layout):
        return FootCondition(self.x, shell, layout)


class FootCondition(sk.conditions.Condition):
    name, n, scales = "foot", 1, np.ones(1)

    def __init__(self, x, shell, layout):
        rows = shell.position_rows(*shell.geometry.locate_all(np.array([[x], [np.pi]])))
        self.row = sp.csr_matrix(sp.kron(rows, [[0.0, 1.0, 0.0]]))
        self.blocks, self.start = np.unique(self.row.indices // 12)[None], self.row @ layout.undeformed.ravel()

    def couples(self):
        return self.blocks

    def value(self, q, case):
        return self.row @ q - self.start + 0.3 * case.factor

    def gradient(self, q):
        return self.row


@theories
@pytest.mark.parametrize("linear", [True, False])
def test_a_condition_is_estimated_as_the_support_that_it_replaces(theory, linear):
    """All of an estimate, and of what shear adds: of a displacement, the energy, and the thrust."""
    bare = arch(D / R**2, ties=False)
    held = sk.Prescribed([(0.0, np.pi), (WIDTH, np.pi)], (None, -0.3, None))
    one = dataclasses.replace(bare, conditions=[MovedFoot(0.0), MovedFoot(WIDTH)])
    other = dataclasses.replace(bare, supports=[*bare.supports, held])
    states = [solved(problem, 12, theory, linear) for problem in (one, other)]
    numbers = [sk.Displacement((WIDTH / 2, np.pi / 2), (0, 0, 1)), sk.StrainEnergy(), sk.Reaction("start", (0, 1, 0))]
    for number in numbers:
        ours, theirs = (sk.goal_estimate(state, number) for state in states)
        assert ours.error == pytest.approx(theirs.error, rel=3e-3)  # of the thrust, a small part of it, up to Newton's rest
        assert np.allclose(ours.indicators, theirs.indicators, rtol=1e-3)
        if theory == "kirchhoff":
            shear = [sk.theory_error(state, number).value for state in states]
            assert shear[0] == pytest.approx(shear[1], rel=1e-6) and shear[0] != 0
    assert np.allclose(*(sk.residual_indicator(state) for state in states), rtol=1e-5)
