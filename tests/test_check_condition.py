"""Conditions of one's own that are wrong, and what is said of each."""

import numpy as np
import pytest
import scipy.sparse as sp

import skancf as sk
from skancf.conditions import Condition, Joint
from skancf.errors import InputError
from skancf.testing import WrongCondition, check_condition

SURFACE = sk.CylinderSector(radius=1.0, length=0.6, angle=2 * np.pi)
TUBE = sk.Problem(SURFACE, 0.05, sk.Isotropic(1e6, 0.3, 2000.0))
MESH = sk.meshes.uniform(SURFACE, 2, 6)
theories = pytest.mark.parametrize("theory", ["kirchhoff", "full"])
pytestmark = pytest.mark.filterwarnings("ignore:the sides 'start' and 'end'")


class OnSphere(Joint):
    """A point keeps its distance from the origin, and another its height; right unless told otherwise."""

    def __init__(self, **wrong):
        self.wrong = wrong

    def on(self, shell, layout):
        return type("Changed", (Sphere,), self.wrong)(shell, layout)


class Sphere(Condition):
    name, n, scales = "sphere", 2, np.ones(2)

    def __init__(self, shell, layout):
        rows = shell.position_rows(*shell.geometry.locate_all(np.array([(0.4, 1.0), (0.2, 4.0)]).T))
        self.place = sp.csr_matrix(sp.kron(rows[0], sp.eye(3)))
        self.height = sp.csr_matrix(sp.kron(rows[1], [[0.0, 0.0, 1.0]]))
        self.blocks = np.unique(np.concatenate([self.place.indices, self.height.indices]) // 12)[None]
        self.start = self.numbers(layout.undeformed.ravel())

    def numbers(self, q):
        r = self.place @ q
        return np.array([0.5 * r @ r, (self.height @ q)[0]])

    def couples(self):
        return self.blocks

    def value(self, q, case):
        return self.numbers(q) - self.start

    def gradient(self, q):
        return sp.csr_matrix(sp.vstack([sp.csr_matrix((self.place @ q)[None]) @ self.place, self.height]))

    def add_curvature(self, q, multipliers, blocks):
        numbers = (12 * self.blocks[0][:, None] + np.arange(12)).ravel()
        shape = self.place[:, numbers].toarray()
        blocks.add(self.blocks, multipliers[0] * (shape.T @ shape)[None])


@theories
@pytest.mark.parametrize("joint", [sk.Hinge("start", "end"), sk.RigidLink((0.1, 1.0), (0.5, 3.0)), OnSphere()])
def test_what_is_right_passes(joint, theory):
    report = check_condition(joint, TUBE, mesh=MESH, theory=theory)
    assert set(report.errors) == {"gradient against value", "curvature against gradient", "discrete gradient against values",
                                  "multipliers carried to the same mesh"}  # fmt: skip
    assert max(report.errors.values()) < 1e-8
    system = TUBE.on(MESH, theory)
    assert str(check_condition(joint.on(system.shell, system.layout), system)) == str(report)


def twice(self, q):
    return 2.0 * Sphere.gradient(self, q)


def stale(self, q):
    """That of the undeformed state."""
    return self.kept if hasattr(self, "kept") else setattr(self, "kept", Sphere.gradient(self, q)) or self.kept


def half_of_it(self, q, multipliers, blocks):
    Sphere.add_curvature(self, q, 0.5 * multipliers, blocks)


def fixed(self, q0, q1):
    return self.gradient(q0)


WRONG = {
    "a gradient twice as large": ({"gradient": twice}, r"gradient against value: row \d differs by .*e-01.*worst at block"),
    "a gradient of another state": ({"gradient": stale}, "gradient against value: row 0"),
    "no curvature": ({"add_curvature": lambda *_: None}, "curvature against gradient: they differ by 1.0e.00"),
    "half of the curvature": ({"add_curvature": half_of_it}, "curvature against gradient: they differ by 5.0e-01"),
    "a gradient at one end": ({"between": fixed}, "discrete gradient against values"),
    "other multipliers on the same mesh": ({"carried": lambda self, m, onto: 2 * m}, "carried to the same mesh"),
    "a gradient of another shape": ({"gradient": lambda self, q: Sphere.gradient(self, q)[:1]}, "give a sparse matrix"),
    "a value that is none": ({"value": lambda self, q, case: np.array([0.0, np.nan])}, "finite numbers"),
}  # fmt: skip


@pytest.mark.parametrize("case", WRONG)
def test_what_is_wrong_is_named(case):
    wrong, words = WRONG[case]
    with pytest.raises(WrongCondition, match=words) as said:
        check_condition(OnSphere(**wrong), TUBE, mesh=MESH)
    assert isinstance(said.value, InputError) and isinstance(said.value, AssertionError)
    assert "'sphere'" in str(said.value)


def test_a_wrong_gradient_is_refused_without_a_check():
    """No solve would fail: the point would be held, by a force in a wrong direction."""
    turned = {"gradient": lambda self, q: sp.csr_matrix(sp.vstack([self.height, Sphere.gradient(self, q)[:1]]))}
    problem = sk.Problem(SURFACE, 0.05, TUBE.material, [sk.Clamp("left")], conditions=[OnSphere(**turned)])
    with pytest.raises(WrongCondition, match=r"gradient against value: row 0.*other directions than what they keep"):
        problem.on(MESH, "kirchhoff")
    right = sk.Problem(SURFACE, 0.05, TUBE.material, [sk.Clamp("left")], conditions=[OnSphere()])
    assert right.on(MESH, "kirchhoff").conditions.n == 2


def test_what_is_no_condition():
    with pytest.raises(InputError, match="give a system or a problem"):
        check_condition(OnSphere(), MESH)
    with pytest.raises(InputError, match="a state of shape"):
        check_condition(OnSphere(), TUBE, mesh=MESH, states=[np.zeros(3)])
    with pytest.raises(InputError, match="a Condition, or a Joint"):
        check_condition(type("Odd", (), {"on": lambda *_: 3})(), TUBE, mesh=MESH)
