"""Conditions as such: their values, gradients and curvatures, what they are on a mesh, and what is refused."""

import warnings
from dataclasses import dataclass

import numpy as np
import pytest
import scipy.sparse as sp

import skancf as sk
from skancf.conditions import Condition, Joint
from skancf.conditions.edges import segments
from skancf.errors import InputError
from skancf.layout.layout import vectors

STEEL = sk.Isotropic(young=2e11, poisson=0.3, density=7800.0)
TUBE = sk.CylinderSector(radius=1.0, length=0.5, angle=2 * np.pi)
HINGE, ROD = sk.Hinge("start", "end"), sk.RigidLink((0.0, 0.5), (0.5, 2.5))
theories = pytest.mark.parametrize("theory", ["kirchhoff", "full"])


def on(*joints, theory="kirchhoff", n=(3, 12), surface=TUBE, loads=()):
    problem = sk.Problem(surface, 0.01, STEEL, [sk.Clamp("left")], list(loads), conditions=list(joints))
    return problem.on(sk.meshes.uniform(surface, *n), theory)


def near(system, seed=0, amount=1e-2):
    rng = np.random.default_rng(seed)
    return system.undeformed + amount * rng.standard_normal(system.n_dofs), rng.standard_normal(system.n_dofs)


def rotated(system, q, axis=(1.0, 2.0, -0.5), angle=2.0):
    axis = np.array(axis) / np.linalg.norm(axis)
    w = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return (vectors(q) @ (np.eye(3) + np.sin(angle) * w + (1 - np.cos(angle)) * w @ w).T).ravel()


@theories
def test_gradient_curvature_and_discrete_gradient(theory):
    system = on(HINGE, ROD, theory=theory)
    conditions, (q, d), h = system.conditions, near(system), 1e-5
    difference = (conditions.value(q + h * d) - conditions.value(q - h * d)) / (2 * h)
    assert np.abs(difference - conditions.gradient(q) @ d).max() < 1e-9  # central differences of quadratics, to rounding
    multipliers, blocks = np.random.default_rng(1).standard_normal(conditions.n), system.blocks()
    conditions.add_curvature(q, multipliers, blocks)
    curved = blocks.matrix() @ d
    difference = (conditions.force(q + h * d, multipliers) - conditions.force(q - h * d, multipliers)) / (2 * h)
    assert np.abs(difference - curved).max() < 1e-9 and np.abs(curved).max() > 0.1
    change = conditions.value(q + d) - conditions.value(q)
    assert np.abs(change - conditions.between(q, q + d) @ d).max() < 1e-13 * np.abs(change).max()
    assert np.abs(change - conditions.gradient(q) @ d).max() > 1e-3  # the gradient at one end is not exact


@theories
def test_rigid_motions_do_not_open_conditions(theory):
    system = on(HINGE, ROD, theory=theory)
    turned = rotated(system, system.undeformed)
    vectors(turned)[::4] += [1.0, -2.0, 3.0]
    assert system.conditions.missed(system.conditions.value(turned)) < 1e-15
    assert np.abs(turned - system.undeformed).max() > 1.0
    assert system.conditions.missed(system.conditions.value(near(system)[0])) > 1e-3


def test_a_hinge_where_meshes_match_closes_the_gap_all_along():
    """The gap, cubic on each of n elements and smooth, has 2 n + 2 numbers: as many as a hinge has rows a component."""
    system = on(HINGE)
    gap = system.conditions[0]
    rows = gap.gradient(system.undeformed)[::3]
    assert rows.shape[0] == 2 * 3 + 2 and np.linalg.matrix_rank(rows.toarray()) == rows.shape[0]
    null = np.linalg.svd(rows.toarray())[2][rows.shape[0] :]
    s = np.linspace(0.0, 0.5, 17)
    places = [np.array([s, np.full(17, y)]) for y in (0.0, 2 * np.pi)]
    ends = [system.shell.position_rows(*system.geometry.locate_all(place)) for place in places]
    x = (null.T @ np.random.default_rng(0).standard_normal(len(null)))[::3]
    assert np.abs((ends[0] - ends[1]) @ x).max() < 1e-12 < 0.1 < np.abs(ends[0] @ x).max()


def test_segments_are_no_shorter_than_the_elements_they_meet():
    ends, knots = segments(np.array([0, 1, 2, 3, 4.0]), np.array([0, 0.5, 1, 1.5, 2, 4]) * 2)
    assert ends.tolist() == [0, 1, 2, 4] and knots.tolist() == [0, 0.5, 1, 1.5, 2, 3, 4]
    ends, knots = segments(np.linspace(0, 1, 4), np.linspace(0, 1, 3))
    assert np.allclose(ends, [0, 1 / 2, 1]) and np.allclose(knots, [0, 1 / 3, 1 / 2, 2 / 3, 1])
    same, _ = segments(np.linspace(0, 1, 9), np.linspace(0, 3, 9))
    assert np.allclose(same, np.linspace(0, 1, 9))


def test_edges_of_other_meshes_are_closed_before_strains_are_measured():
    """A torus slit around its tube: its two circles are interpolated by other elements, and miss each other a little."""
    bounds = ((0.0, 2 * np.pi), (0.3, 2.3))
    torus = sk.MappedSurface(lambda x, y: [(2 + np.cos(y)) * np.cos(x), (2 + np.cos(y)) * np.sin(x), np.sin(y)], bounds)
    mesh = sk.meshes.quadtree(sk.meshes.uniform(torus, 8, 2))
    finer = mesh.refined([k for k in range(mesh.nelements) if mesh.p[0, mesh.t[:, k]].max() < 1.0])
    problem = sk.Problem(torus, 0.01, STEEL, [sk.Clamp("bottom")], conditions=[sk.Hinge("left", "right")])
    system = problem.on(finer, "kirchhoff")
    bare = sk.Problem(torus, 0.01, STEEL, [sk.Clamp("bottom"), sk.Spring("left", (1.0,) * 3)]).on(finer, "kirchhoff")
    conditions, moved = system.conditions, np.abs(system.undeformed - bare.undeformed)
    assert conditions.missed(conditions.value(bare.undeformed)) > 1e-6  # what was closed
    assert conditions.missed(conditions.value(system.undeformed)) < 1e-15 and 1e-6 < moved.max() < 1e-2
    assert np.abs(system.internal_force(system.undeformed)).max() < 1e-12 * 2e11 * 0.01


@dataclass(frozen=True)
class OnPlane(Joint):
    """A point of the surface stays on the plane through it with a normal."""

    at: tuple
    normal: tuple
    name: str = "plane"

    def on(self, shell, layout):
        return PlaneCondition(self, shell, layout)


class PlaneCondition(Condition):
    n, scales = 1, np.ones(1)

    def __init__(self, given, shell, layout):
        self.name = given.name
        rows = shell.position_rows(*shell.geometry.locate_all(np.array([given.at]).T))
        self.row = sp.kron(rows, sp.csr_matrix([given.normal])).tocsr()
        self.blocks = np.unique(self.row.indices // 12)[None]
        self.start = self.row @ layout.undeformed.ravel()

    def couples(self):
        return self.blocks

    def value(self, q, case):
        return self.row @ q - self.start

    def gradient(self, q):
        return self.row


def wrong(**methods):
    made = type("Wrong", (PlaneCondition,), methods)
    at = OnPlane((0.25, 1.0), (1, 0, 0))
    return type("Given", (Joint,), {"on": lambda self, shell, layout: made(at, shell, layout)})()


def square(self, q, case):
    x = self.row @ q - self.start
    return x + x**2


def slope(self, q):
    return sp.csr_matrix(self.row * float(1 + 2 * (self.row @ q - self.start)[0]))


def bend(self, q, multipliers, blocks):
    along = self.row.toarray().reshape(-1, 12)[self.blocks[0]].ravel()
    blocks.add(self.blocks, 2 * multipliers[0] * np.outer(along, along)[None])


REFUSED = {
    "a link of no length": (lambda: on(sk.RigidLink((0.1, 1.0), (0.1, 1.0))), "length is zero"),
    "a link between the two sides of a slit": (lambda: on(sk.RigidLink((0.1, 0.0), (0.1, 2 * np.pi))), "one place in space"),
    "a point off the surface": (lambda: on(sk.RigidLink((0.1, 1.0), (2.0, 1.0))), "outside the surface"),
    "edges that do not meet": (lambda: on(sk.Hinge("left", "right")), r"up to 0\.5 m apart"),
    "one edge twice": (lambda: on(sk.Hinge("start", "start")), "edges in common"),
    "no edge": (lambda: on(sk.Hinge("start", "finish")), "no boundary 'finish'"),
    "edges in pieces": (lambda: on(sk.Hinge("start", lambda x, y: (x < 0.01) | (x > 0.49))), "no single line"),
    "no place": (lambda: sk.Hinge("start", 3), "name of an edge"),
    "a load among conditions": (lambda: on(sk.PointForce((0.1, 1.0), (0, 0, 1))), "skancf.conditions"),
    "no condition": (lambda: on(type("None_", (Joint,), {"on": lambda *_: 3})()), "one from on"),
    "a gradient of another shape": (lambda: on(wrong(gradient=lambda self, q: self.row[:, :-1])), "gradient of"),
    "a dense gradient": (lambda: on(wrong(gradient=lambda self, q: self.row.toarray())), "sparse matrix"),
    "a complex gradient": (lambda: on(wrong(gradient=lambda self, q: self.row * 1j)), "sparse matrix of finite numbers"),
    "a gradient that is none": (lambda: on(wrong(gradient=lambda self, q: 2 * self.row)),
                                "gradient against value: row 0 differs by .* worst at block .* component x"),
    "a gradient of zeros": (lambda: on(wrong(gradient=lambda self, q: 0 * self.row)), "row 0 is zero in the undeformed"),
    "a square": (lambda: on(wrong(value=lambda self, q, case: (self.row @ q - self.start) ** 2, gradient=lambda self, q:
                 sp.csr_matrix(self.row * float(2 * (self.row @ q - self.start)[0])))), "a distance and not its square"),
    "no curvature": (lambda: on(wrong(value=square, gradient=slope)), "curvature against gradient: .* add_curvature"),
    "rows that are no number": (lambda: on(wrong(n=1.0)), "n of .* whole number of at least 0"),
    "a name that is no text": (lambda: on(OnPlane((0.25, 1.0), (1, 0, 0), 3)), "name of .* = 3: give a text"),
    "blocks that are not coupled": (lambda: on(wrong(couples=lambda self: self.blocks[:, :1])), "no cell of couples"),
    "blocks that are not there": (lambda: on(wrong(couples=lambda self: self.blocks + 10**6)), "does not exist"),
    "a value of another shape": (lambda: on(wrong(value=lambda self, q, case: np.zeros(2))), "value of"),
    "a size of zero": (lambda: on(wrong(scales=np.zeros(1))), "greater than zero"),
    "a value at rest": (lambda: on(wrong(value=lambda self, q, case: self.row @ q)), "does not meet it"),
}  # fmt: skip


@pytest.mark.filterwarnings("ignore:the sides 'start'")
@pytest.mark.parametrize("case", REFUSED)
def test_what_is_refused(case):
    make, words = REFUSED[case]
    with pytest.raises(InputError, match=words):
        make()


def test_a_slit_that_a_hinge_names_is_meant():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        on(HINGE)
    with pytest.warns(sk.OutOfDepth, match="not joined"):
        on()


def test_a_gap_that_is_not_the_mesh_s_is_said():
    nearly = sk.CylinderSector(radius=1.0, length=0.5, angle=6.28)
    with pytest.warns(sk.OutOfDepth, match=r"'start' and 'end' of the surface miss each other by up to 0\.003185 m"):
        on(HINGE, surface=nearly)


def test_without_conditions_nothing_is_there():
    system = on(surface=sk.Rectangle(1.0, 1.0))
    assert not system.conditions and system.conditions.n == 0 and system.conditions.gradient(system.undeformed).shape[0] == 0


def test_own_conditions_and_names():
    joints = [OnPlane((0.25, 1.0), (1, 0, 0)), OnPlane((0.25, 2.0), (0, 1, 0)), ROD]
    system = on(HINGE, *joints)
    assert system.conditions.names == ("hinge", "plane 1", "plane 2", "rigid link")
    assert system.conditions.owner(system.conditions.n - 2) == "plane 2"
    taken = on(*[sk.RigidLink((0.1, y), (0.4, y + 2), name=name) for y, name in ((1, "a"), (2, "a"), (3, "a 1"), (0, "b"))])
    assert taken.conditions.names == ("a 2", "a 3", "a 1", "b"), "each has a name of its own"


def test_own_conditions_that_are_right():
    """Of none or some rows, bent or straight, with gradients of any sparse kind."""
    for methods in (
        {"value": square, "gradient": slope, "add_curvature": bend}, {"gradient": lambda self, q: self.row.tolil()},
        {"n": 0, "scales": np.empty(0), "value": lambda *_: np.empty(0), "gradient": lambda self, q: self.row[:0]},
    ):  # fmt: skip
        assert on(wrong(**methods)).conditions.n == methods.get("n", 1)
