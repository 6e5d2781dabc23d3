"""Terms and unknowns of the user's own, in every solver: a body on a spring, and a second block at each node."""

import gc
import weakref

import numpy as np
import pytest

import skancf as sk
from skancf.layout.layout import Layout, Part
from skancf.terms import Addition, Term

PLATE = sk.Rectangle(1.0, 1.0)
MATERIAL = sk.Isotropic(1e7, 0.3, 1e3)
STIFFNESS, MASS, TIP = 40.0, 3.0, (1.0, 1.0)
theories = pytest.mark.parametrize("theory", ["kirchhoff", "full"])


class Quadratic(Term):
    """The energy of springs between blocks, with a constant matrix, and masses of blocks."""

    def __init__(self, layout, cells, matrix, mass=0.0, masses=(), weights=None):
        self.layout, self.cells, self.matrix = layout, cells, matrix
        self.weights = np.ones(len(cells)) if weights is None else weights
        self.mass, self.masses = mass, np.asarray(masses, int)
        self.undeformed = layout.undeformed.ravel()

    def couples(self):
        return self.cells

    def _blocks(self, q):
        return self.layout.blocks(q - self.undeformed)[self.cells].reshape(len(self.cells), -1)

    def force(self, q, v, case):
        out = np.zeros((self.layout.n_blocks, 12))
        np.add.at(out, self.cells, (self.weights[:, None] * self._blocks(q) @ self.matrix).reshape(*self.cells.shape, 12))
        return out.ravel()

    def energy(self, q, case):
        u = self._blocks(q)
        return 0.5 * float(np.vdot(u, self.weights[:, None] * u @ self.matrix))

    def add_tangent(self, q, v, case, blocks):
        if not blocks.skew:
            blocks.add(self.cells, self.weights[:, None, None] * self.matrix)

    def add_mass(self, blocks):
        if self.mass:
            blocks.add(self.masses[:, None], np.repeat(self.mass * np.eye(12)[None], len(self.masses), axis=0))


def between(k):
    """Matrix (24, 24) of a spring between the first vectors of two blocks."""
    out = np.zeros((24, 24))
    for i in range(3):
        out[np.ix_([i, 12 + i], [i, 12 + i])] = k * np.array([[1.0, -1.0], [-1.0, 1.0]])
    return out


def area_of_nodes(geometry, areas):
    return np.bincount(geometry.nodes.ravel(), np.repeat(areas.sum(axis=1) / 4, 4), minlength=geometry.n_nodes)


class Body(Addition):
    """A body that hangs on the corner of a plate by a spring; its directors keep to themselves, by springs of their own."""

    def __init__(self, stiffness=STIFFNESS, mass=MASS, held=False, at=TIP):
        self.stiffness, self.mass, self.held, self.at = stiffness, mass, held, at

    def part(self, geometry):
        r = geometry.surface.position(*np.array(self.at)[:, None]).T
        vectors = np.concatenate([r, np.eye(3)])[None]
        held = np.zeros((1, 12), bool)
        held[0, 3:] = True
        held[0, :3] = self.held
        return Part("body", vectors, np.ones((1, 12)), r, held)

    def on(self, shell, layout):
        cells = np.array([[shell.geometry.node_at(self.at), layout.part("body").start]])
        return Quadratic(layout, cells, between(self.stiffness), self.mass, cells[0, 1:])


class Second(Addition):
    """A second block at every node, between springs to the node and to the ground: together one spring to the ground."""

    def __init__(self, one=30.0, other=60.0, mass=0.0):
        self.one, self.other, self.mass = one, other, mass

    def part(self, geometry):
        held = np.ones((geometry.n_nodes, 12), bool)
        held[:, :3] = False
        scales = np.ones((geometry.n_nodes, 12))
        return Part("second", np.zeros((geometry.n_nodes, 4, 3)), scales, geometry.undeformed[:, 0], held, False, True)

    def on(self, shell, layout):
        n = shell.geometry.n_nodes
        cells = np.column_stack([np.arange(n), layout.part("second").start + np.arange(n)])
        matrix = between(self.one)
        matrix[12:15, 12:15] += self.other * np.eye(3)
        weights = area_of_nodes(shell.geometry, shell.assembly.areas)
        return Quadratic(layout, cells, matrix, self.mass, cells[:, 1], weights)


def problem(terms=(), loads=None, supports=None, **more):
    loads = [sk.PointForce(TIP, (0.0, 0.0, -2.0))] if loads is None else loads
    supports = [sk.Clamp("left")] if supports is None else supports
    return sk.Problem(PLATE, 0.02, MATERIAL, supports, loads, terms=list(terms), **more)


def on(terms=(), n=4, theory="kirchhoff", **more):
    return problem(terms, **more).on(sk.meshes.uniform(PLATE, n, n), theory)


def spring_at_nodes(k):
    """The same as :class:`Second`, without unknowns of its own."""

    class Springs(Addition):
        def on(self, shell, layout):
            matrix = np.zeros((12, 12))
            matrix[:3, :3] = k * np.eye(3)
            weights = area_of_nodes(shell.geometry, shell.assembly.areas)
            return Quadratic(layout, np.arange(shell.geometry.n_nodes)[:, None], matrix, weights=weights)

    return Springs()


HELD, GROUNDED = [Body(held=True)], [sk.Clamp("left"), sk.Spring(TIP, (STIFFNESS,) * 3)]
SAME = [
    pytest.param({"terms": HELD}, {"supports": GROUNDED}, id="held body"),
    pytest.param({"terms": [Second(30.0, 60.0)]}, {"terms": [spring_at_nodes(20.0)]}, id="second block"),
]
"""Problems with unknowns of their own, and the same without: springs in a row are one."""


@theories
@pytest.mark.parametrize("own, same", SAME)
def test_statics_of_springs_in_a_row(theory, own, same):
    """Linear and large deflections, paths, and the reactions: equal to what the tolerance of Newton's method leaves."""
    one, other = on(theory=theory, **own), on(theory=theory, **same)
    assert one.n_dofs > other.n_dofs
    for solve in (sk.solve_linear, lambda s: sk.solve(s, rtol=1e-12).unwrap(),
                  lambda s: sk.trace(s, until=1.0, rtol=1e-12).unwrap().solution):  # fmt: skip
        a, b = solve(one), solve(other)
        assert np.allclose(a.displacement(TIP), b.displacement(TIP), rtol=1e-8, atol=1e-12)
        assert np.isclose(a.strain_energy, b.strain_energy, rtol=1e-8)
        assert abs(a.displacement(TIP)[2]) > 0.01, "the load does something"
    assert np.allclose(sk.solve_linear(one).reactions(), [0, 0, 2.0], atol=1e-9)


@theories
@pytest.mark.parametrize("own, same", SAME)
def test_modes_and_buckling_of_springs_in_a_row(theory, own, same):
    one, other = on(theory=theory, **own), on(theory=theory, **same)
    a, b = (sk.modes(s, 3).frequencies for s in (one, other))
    assert np.allclose(a, b, rtol=1e-7)
    load = {"loads": [sk.EdgeLoad("right", (-1.0, 0.0, 0.0))]}
    a, b = (sk.buckling(on(theory=theory, **each, **load), 1).load_factors[0] for each in (own, same))
    assert np.isclose(a, b, rtol=1e-6)
    assert not np.isclose(a, sk.buckling(on(theory=theory, **load), 1).load_factors[0], rtol=1e-2), "the springs count"


@theories
@pytest.mark.parametrize("rule", [sk.EnergyMomentum(rho_inf=1.0), sk.GeneralizedAlpha(0.8)])
def test_motions_of_springs_in_a_row(theory, rule):
    """The second block has hardly any inertia, so that it follows, and the ledger has the same energies."""
    one, other = (on([term], n=2, theory=theory) for term in (Second(mass=1e-6), spring_at_nodes(20.0)))
    a, b = (sk.simulate(s, 0.2, dt=0.01, rule=rule, newton_rtol=1e-10, balance=None, progress=False) for s in (one, other))
    assert a.ok and b.ok
    assert np.allclose(a.displacement(TIP), b.displacement(TIP), rtol=0, atol=1e-5 * np.abs(b.displacement(TIP)).max())
    for name in ("kinetic", "strain", "work"):
        scale = b.ledger.strain.max()
        assert np.allclose(getattr(a.ledger, name), getattr(b.ledger, name), atol=1e-4 * scale), name


def test_unknowns_without_inertia_are_named_in_motion():
    with pytest.raises(sk.InputError, match=r"part 'second' has unknowns without inertia.*add_mass"):
        sk.simulate(on([Second()], n=1), 0.1, progress=False)


def test_a_free_plate_and_a_body_keep_their_momenta_and_energy():
    """Nothing acts from outside; the spring is quadratic, so that the force in the middle does its work exactly."""
    system = on([Body(at=(1.0, 1.0))], n=2, supports=[], loads=[])
    v = np.zeros_like(system.layout.undeformed)
    v[-1, 0] = [0.3, -0.2, 1.0]
    motion = sk.simulate(system, 0.3, dt=0.01, rule=sk.EnergyMomentum(rho_inf=1.0), velocity=v.ravel(), progress=False)
    ledger = motion.ledger
    assert motion.ok and ledger.kinetic[0] == pytest.approx(0.5 * MASS * (0.3**2 + 0.2**2 + 1.0))
    assert ledger.linear[0] == pytest.approx(MASS * np.array([0.3, -0.2, 1.0]))
    assert ledger.strain.max() > 0.1 * ledger.kinetic[0], "the spring takes part"
    assert np.abs(ledger.energy - ledger.energy[0]).max() < 1e-6 * ledger.energy[0]
    # The spring pulls on centres at a distance, so that it has no moment about the middle.
    assert np.abs(ledger.linear - ledger.linear[0]).max() < 1e-9 * MASS
    assert np.abs(ledger.angular - ledger.angular[0]).max() < 1e-9 * MASS
    moved = list(motion.states)[-1].change.reshape(-1, 12)[-1, :3]
    assert np.linalg.norm(moved) > 0.05, "the body moves"


@pytest.mark.parametrize("own, same", SAME)
def test_adapt_with_unknowns_of_its_own(own, same):
    """Meshes change, the body stays: the same number with an error bar that holds it."""
    results = [sk.adapt(problem(**each), sk.Displacement(TIP, (0, 0, 1)), rtol=1e-3, linear=True, progress=False)
               for each in (own, same)]  # fmt: skip
    (a, b) = results
    assert a.ok and b.ok and len(a.levels) == len(b.levels)
    assert np.isclose(a.value, b.value, rtol=1e-6) and np.isclose(a.error_bar, b.error_bar, rtol=1e-3)
    mesh = sk.meshes.quadtree(sk.meshes.uniform(PLATE, 1, 1), PLATE)
    a, b = (sk.adapt(problem(**each), sk.Displacement(TIP, (0, 0, 1)), rtol=2e-2, mesh=mesh, progress=False)
            for each in (own, same))  # fmt: skip
    assert len(a.levels) == len(b.levels) > 1 and a.status is b.status
    assert np.isclose(a.value, b.value, rtol=1e-6) and np.isclose(a.error_bar, b.error_bar, rtol=1e-2)


def test_what_layouts_refuse():
    part = Second().part(on(n=1).geometry)
    with pytest.raises(sk.InputError, match="two parts have the name 'second'"):
        Layout([part, part])
    with pytest.raises(sk.InputError, match="part 'arm': the layout has 'second'"):
        Layout([part]).part("arm")
    with pytest.raises(sk.InputError, match="a vector of 3 nodal coordinates; this system has 48"):
        Layout([part]).nodal(np.zeros(3))
    with pytest.raises(sk.InputError, match=r"scales of part 'a'.*greater than zero"):
        Part("a", np.zeros((1, 4, 3)), np.zeros((1, 12)), np.zeros((1, 3)))
    with pytest.raises(sk.InputError, match=r"undeformed of part 'a', of shape \(1, 3\)"):
        Part("a", np.zeros((1, 3)), np.ones((1, 12)), np.zeros((1, 3)))


CELL = np.array([[0, 1]])


class Wrong(Addition):
    def __init__(self, cells, matrix):
        self.cells, self.matrix = np.asarray(cells), matrix

    def on(self, shell, layout):
        return Quadratic(layout, self.cells, self.matrix)


def test_what_couples_blocks_that_are_not_there_is_named():
    with pytest.raises(sk.InputError, match=r"couples\(\): block 40 does not exist; the layout has blocks 0 to 3"):
        on([Wrong([[0, 40]], between(1.0))], n=1)
    with pytest.raises(sk.InputError, match=r"matrices of shape \(1, 12, 12\) for cells of shape \(1, 2\): give"):
        own = {"couples": CELL, "add_tangent": lambda self, q, v, case, blocks: blocks.add(CELL, np.eye(12)[None])}
        sk.solve_linear(on([term_with(**own)], n=1))
    with pytest.raises(sk.InputError, match=r"terms: .* is not a term"):
        problem([3.0])


def term_with(**methods):
    """A term whose methods return what is given, or are it."""

    class Given(Addition):
        def on(self, shell, layout):
            made = {name: (each if callable(each) else lambda *_, each=each: each) for name, each in methods.items()}
            return type("Own", (Term,), {"force": lambda self, q, v, case: np.zeros(q.size), **made})()

    return Given()


BAD_TERMS = {
    "short": ({"force": np.zeros(3)}, r"force: array.*of shape \(3,\); give 48 finite numbers"),
    "nodal": ({"force": np.zeros((4, 4, 3))}, r"of shape \(4, 4, 3\); give 48"),
    "one number": ({"force": 0.0}, r"force: 0.0, of shape \(\); give 48"),
    "none": ({"force": None}, "force: None.*give 48 finite numbers"),
    "complex": ({"force": np.zeros(48) + 1j}, "give 48 finite numbers"),
    "text": ({"force": np.array(["a"] * 48)}, "give 48 finite numbers"),
    "not finite": ({"force": np.full(48, np.nan)}, "give 48 finite numbers"),
    "no force": ({"force": Term.force}, r"has no force: write force\(self, q, v, case\), which returns 48 numbers"),
    "energies": ({"energy": np.zeros(3)}, "energy: array.*give one finite number, or None"),
    "text of energy": ({"energy": "much"}, "energy: 'much'; give one finite number"),
    "complex energy": ({"energy": 1j}, "energy: 1j; give one"),
    "infinite energy": ({"energy": np.inf}, "energy: inf; give one"),
    "list of cells": ({"couples": [[0, 1]]}, r"couples\(\): \[\[0, 1\]\]; give an array \(m, n\) of whole numbers"),
    "row of cells": ({"couples": np.array([0, 1])}, r"give an array \(m, n\) of whole numbers"),
    "cells of floats": ({"couples": np.array([[0.0, 1.0]])}, r"give an array \(m, n\) of whole numbers"),
    "histories": ({"histories": None}, r"histories\(\) of .*: None; return a list"),
    "impulse": ({"impulse": 3.0}, r"impulse\(\) of .*: 3.0; return a time and 48 numbers"),
}


@pytest.mark.parametrize("name", BAD_TERMS)
def test_terms_are_looked_at_when_a_system_is_made(name):
    methods, message = BAD_TERMS[name]
    with pytest.raises(sk.InputError, match=message):
        on([term_with(**methods)], n=1)


def test_a_term_that_writes_into_the_state_is_stopped():
    with pytest.raises(ValueError, match="read-only") as caught:
        on([term_with(force=lambda self, q, v, case: q.__iadd__(1e-3))], n=1)
    assert any("force" in note for note in caught.value.__notes__)


def test_additions_return_a_term_and_a_part():
    class Returns(Addition):
        def __init__(self, term, part=None):
            self.term, self.own = term, part

        def on(self, shell, layout):
            return self.term

        def part(self, geometry):
            return self.own

    for term in (None, 3.0, [Steady(0, 0, False)]):
        with pytest.raises(sk.InputError, match=r"the term of .*: give one term from on\(\)"):
            on([Returns(term)], n=1)
    with pytest.raises(sk.InputError, match=r"part\(\) of .* returned 3.0; return a skancf.layout.layout.Part"):
        on([Returns(None, 3.0)], n=1)
    with pytest.raises(sk.InputError, match="part 'few' is nodal and has 1 blocks: give one for each of the 4 nodes"):
        on([Returns(None, Part("few", np.zeros((1, 4, 3)), np.ones((1, 12)), np.zeros((1, 3)), nodal=True))], n=1)
    with pytest.raises(sk.InputError, match="name of a part = 3: give a text"):
        Part(3, np.zeros((1, 4, 3)), np.ones((1, 12)), np.zeros((1, 3)))
    with pytest.raises(sk.InputError, match=r"loads: .* is a term; give it in terms"):
        problem(loads=[sk.FormTerm(energy=lambda w: w.J)])
    with pytest.raises(sk.InputError, match=r"terms: PointForce.* is not a term"):
        problem([sk.PointForce(TIP, (0.0, 0.0, 1.0))])


@pytest.mark.parametrize("cells, matrices", [
    (np.array([0]), np.eye(12)[None]), (np.array([[0.0]]), np.eye(12)[None]), (np.array([[0]]), 1j * np.eye(12)[None]),
])  # fmt: skip
def test_matrices_are_real_and_of_rows_of_blocks(cells, matrices):
    with pytest.raises(sk.InputError, match=r"of whole numbers, a row of blocks|of real numbers"):
        on(n=1).blocks().add(cells, matrices)


def test_a_factor_is_no_case():
    system = on(supports=[sk.Prescribed("left", (0.1, 0.0, 0.0))], n=1)
    q = system.undeformed
    for asked in (system.external_force, system.applied_force, system.tangent, system.skew, system.strain_energy):
        with pytest.raises(sk.InputError, match=r"case = 0.5: give a Case, as in sk.Case\(0.5\)"):
            asked(q, 0.5)
    with pytest.raises(sk.InputError, match=r"sk.Case\(0.5\)"):
        system.prescribed(0.5)


class Constant(Addition):
    """An energy that is the same everywhere, of any sign: it has no force, and must not count."""

    def __init__(self, amount):
        self.amount = amount

    def on(self, shell, layout):
        term = Quadratic(layout, np.zeros((1, 1), int), np.zeros((12, 12)))
        term.energy = lambda q, case: self.amount
        return term


@pytest.mark.parametrize("amount", [-1e6, 1e6])
def test_the_zero_of_an_energy_does_not_matter(amount):
    """Of any size and sign: the same iterations, the same answer and the same checks."""
    one, other = sk.solve(on([Constant(amount)])), sk.solve(on())
    assert one.ok and one.iterations == other.iterations
    assert np.array_equal(one.solution.q, other.solution.q)
    assert one.solution.strain_energy == pytest.approx(other.solution.strain_energy + amount)


class Push(Addition):
    """A constant force at a node that is part of the structure: no load factor counts."""

    def __init__(self, force, energy):
        self.given, self.has_energy = np.asarray(force, float), energy

    def on(self, shell, layout):
        force = np.zeros((layout.n_blocks, 12))
        force[shell.geometry.node_at(TIP), :3] = -self.given
        return Steady(layout.undeformed.ravel(), force.ravel(), self.has_energy)


class Steady(Term):
    def __init__(self, undeformed, given, has_energy):
        self.undeformed, self.given, self.has_energy = undeformed, given, has_energy

    def force(self, q, v, case):
        return self.given

    def energy(self, q, case):
        return float(self.given @ (q - self.undeformed)) if self.has_energy else None


@pytest.mark.parametrize("energy", [True, False])
@pytest.mark.parametrize("factor", [1.0, 0.4])
def test_a_force_at_rest_of_the_structure_is_no_load(energy, factor):
    """Beside a load of half of the factor it is a load of its own size, in linear and large deflections."""
    load = sk.PointForce(TIP, (0.0, 0.0, -1.0))
    own = on([Push((0.0, 0.0, -1.0), energy)], loads=[load])
    same = on(loads=[sk.PointForce(TIP, (0.0, 0.0, -1.0 - factor))])
    a, b = sk.solve(own, load_factor=factor, rtol=1e-12).unwrap(), sk.solve(same, rtol=1e-12).unwrap()
    assert np.allclose(a.displacement(TIP), b.displacement(TIP), rtol=1e-8)
    if factor == 1.0:
        a, b = sk.solve_linear(own), sk.solve_linear(same)
        assert np.allclose(a.displacement(TIP), b.displacement(TIP), rtol=1e-10)
        # What holds the plate at the place of the push is the push.
        assert np.allclose(a.reactions("left"), [0, 0, 2.0], atol=1e-9)
        assert np.allclose(a.reactions(), [0, 0, 1.0], atol=1e-9), "all that is no load"


def test_a_force_at_rest_does_not_grow_with_the_load_factor_in_small_deflections():
    load, tip = [sk.PointForce(TIP, (0.0, 0.0, -1.0))], sk.Displacement(TIP, (0, 0, 1))
    own, same = problem([Push((0.0, 0.0, -1.0), True)], load), problem(loads=load)
    a = sk.adapt(own, tip, rtol=1e-2, linear=True, load_factor=0.4)
    b = sk.adapt(same, tip, rtol=1e-2, linear=True, load_factor=1.4)
    assert a.ok and np.isclose(a.value, b.value, rtol=1e-9) and np.isclose(a.error_bar, b.error_bar, rtol=1e-6)


def test_a_force_at_rest_has_no_part_in_a_load_factor_of_buckling():
    squeeze = {"energy": lambda w: 5.0 * w.u[0], "where": "right"}
    load = [sk.EdgeLoad("right", (-1.0, 0.0, 0.0))]
    with pytest.raises(sk.InputError, match=r"do not grow with the load factor.*load=True.*sk.trace"):
        sk.buckling(on([sk.FormTerm(**squeeze)], loads=load), 1)
    own = on([sk.FormTerm(**squeeze, load=True)], loads=load), on(loads=[sk.EdgeLoad("right", (-6.0, 0.0, 0.0))])
    found, expected = (sk.buckling(system, 1).load_factors[0] for system in own)
    assert np.isclose(found, expected, rtol=1e-8)
    # A tension that the supports hold strains nothing, and stiffens: it counts.
    held = {"supports": [sk.Clamp("boundary")], "loads": [sk.SurfaceLoad((1.0, 0.0, 0.0))]}
    tense = [sk.buckling(on(terms, **held), 1).load_factors[0] for terms in ([sk.FormTerm(energy=lambda w: 90.0 * w.J)], [])]
    assert tense[0] > 1.1 * tense[1]


class Damper(Addition):
    """A force against the velocity of a node, with its square."""

    def __init__(self, c):
        self.c = c

    def on(self, shell, layout):
        return Drag(layout, shell.geometry.node_at(TIP), self.c)


class Drag(Term):
    def __init__(self, layout, node, c):
        self.layout, self.node, self.c = layout, node, c

    def couples(self):
        return np.array([[self.node]])

    def force(self, q, v, case):
        out = np.zeros_like(self.layout.undeformed)
        if v is not None:
            rate = self.layout.nodal(v)[self.node, 0]
            out[self.node, 0] = self.c * np.linalg.norm(rate) * rate
        return out.ravel()

    def add_damping(self, q, v, case, blocks):
        rate = self.layout.nodal(v)[self.node, 0]
        size = np.linalg.norm(rate)
        matrix = np.zeros((1, 12, 12))
        matrix[0, :3, :3] = self.c * (size * np.eye(3) + np.outer(rate, rate) / (size or 1.0))
        blocks.add(self.couples(), matrix)


@pytest.mark.parametrize("rule", [sk.EnergyMomentum(rho_inf=1.0), sk.GeneralizedAlpha(0.8)])
def test_the_work_of_a_force_against_the_velocity_is_booked(rule):
    options = {"dt": 0.005, "rule": rule, "newton_rtol": 1e-10, "balance": None, "progress": False}
    damped, free = (sk.simulate(on(terms, n=2), 0.3, **options) for terms in ([Damper(5.0)], []))
    ledger = damped.ledger
    assert damped.ok and ledger.energy[-1] < 0.9 * free.ledger.energy[-1], "it takes energy"
    assert ledger.work[-1] < free.ledger.work[-1], "its work is negative"
    tolerance = 1e-6 if isinstance(rule, sk.EnergyMomentum) else 0.05
    assert np.abs(ledger.balance).max() < tolerance * ledger.turnover[-1]


def test_a_system_lives_as_long_as_it_is_used():
    """Nothing of it refers back to it, so that meshes of a long run do not pile up until a collection."""
    system = on([Second(mass=1.0)], supports=[sk.Clamp("left"), sk.Foundation(10.0)], n=2)
    results = [sk.solve(system), sk.solve_linear(system), sk.modes(system, 1),
               sk.simulate(system, 0.01, dt=0.005, progress=False)]  # fmt: skip
    assert system.to_mesh.shape[1] == system.n_dofs and system.inertia.total > 0 and results[1].strain_energy > 0
    alive = [weakref.ref(each) for each in (system, system.pattern, system.layout, system.shell)]
    gc.collect()
    gc.disable()
    try:
        del system, results
        assert [each() for each in alive] == 4 * [None]
    finally:
        gc.enable()


class Loose(Body):
    """A body of which a direction is neither held nor has a stiffness."""

    def part(self, geometry):
        part = super().part(geometry)
        held = part.held.copy()
        held[0, 7] = False
        return Part("loose", part.undeformed, part.scales, part.places, held)

    def on(self, shell, layout):
        cells = np.array([[shell.geometry.node_at(self.at), layout.part("loose").start]])
        return Quadratic(layout, cells, between(self.stiffness), self.mass, cells[0, 1:])


def test_what_nothing_resists_is_named_by_its_part():
    for solve in (sk.solve_linear, sk.solve):
        with pytest.raises(sk.InputError, match=r"nothing resists unknowns of part 'loose', in its block 0.*held"):
            solve(on([Loose()], n=1))


def test_solvers_turn_back_from_a_tangent_that_is_not_finite():
    def energy(w):
        return 20.0 * w.u[2] ** 2

    def tangent(u, v, w):
        return 40.0 * u[2] * v[2] * np.where(np.abs(w.u[2]) > 1e-3, np.nan, 1.0)

    form = sk.FormTerm(energy=energy, residual=lambda v, w: 40.0 * w.u[2] * v[2], tangent=tangent)
    result = sk.solve(on([form], n=1))
    assert not result.ok and "not finite" in result.message
