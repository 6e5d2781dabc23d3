"""Terms of one's own that are wrong, and what is said of each."""

import numpy as np
import pytest

import skancf as sk
from skancf.errors import InputError
from skancf.layout.layout import Part
from skancf.terms import Addition, Term
from skancf.testing import check_term

SURFACE = sk.Rectangle(1.0, 0.6)
PLATE = sk.Problem(SURFACE, 0.05, sk.Isotropic(1e6, 0.3, 2000.0))
MESH = sk.meshes.uniform(SURFACE, 2, 2)


class Beads(Addition):
    """A mass at each node, a spring of fifth order from each to where it was, and drag; right unless told otherwise."""

    def __init__(self, **wrong):
        self.wrong = wrong

    def on(self, shell, layout):
        return type("Changed", (OfBeads,), self.wrong)(shell, layout)


class OfBeads(Term):
    """The energy is checked at rest, the drag by its damping."""

    k, mass, drag = 3.0, 2.0, 0.7

    def __init__(self, shell, layout):
        self.layout, self.n = layout, len(shell.geometry.points.T)
        self.cells = np.arange(self.n)[:, None]

    def couples(self):
        return self.cells

    def u(self, q):
        return self.layout.nodal(q)[: self.n, 0] - self.layout.undeformed[: self.n, 0]

    def spread(self, vectors):
        out = np.zeros_like(self.layout.undeformed)
        out[: self.n, 0] = vectors
        return out.ravel()

    def at_positions(self, matrices):
        out = np.zeros((self.n, 12, 12))
        out[:, :3, :3] = matrices
        return out

    def energy(self, q, case):
        return float((self.k * (self.u(q) ** 2).sum(axis=1) ** 2).sum() / 4)

    def force(self, q, v, case):
        u = self.u(q)
        rates = 0.0 if v is None else self.layout.nodal(v)[: self.n, 0]
        return self.spread(self.k * (u**2).sum(axis=1)[:, None] * u + self.drag * rates)

    def add_tangent(self, q, v, case, blocks):
        u = self.u(q)
        square = (u**2).sum(axis=1)[:, None, None] * np.eye(3) + 2 * u[:, :, None] * u[:, None]
        blocks.add(self.cells, self.at_positions(self.k * square))

    def add_damping(self, q, v, case, blocks):
        blocks.add(self.cells, self.at_positions(self.drag * np.eye(3)))

    def add_mass(self, blocks):
        blocks.add(self.cells, self.at_positions(self.mass * np.eye(3)))

    def between(self, q0, q1, case):
        """Exact: the energy is a square of a square."""
        a, b = self.u(q0), self.u(q1)
        mean = 0.5 * ((a**2).sum(axis=1) + (b**2).sum(axis=1))[:, None]
        return self.spread(self.k * mean * 0.5 * (a + b))


def scaled(name, factor):
    method = getattr(OfBeads, name)
    return lambda self, *given: factor * method(self, *given)


def added(name, matrix):
    def add(self, *given):
        given[-1].add(self.cells, self.at_positions(matrix))

    return add


def one_sided(self, q, v, case, blocks):
    u = self.u(q)
    square = 2 * u[:, :, None] * u[:, None] + (u**2).sum(axis=1)[:, None, None] * np.eye(3)
    blocks.add(self.cells, self.at_positions(self.k * square + np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 0]])))


def too_far(self):
    return np.array([[0, 1], [1, 400]])


def shifted_energy(self, q, case):
    return OfBeads.energy(self, q, case) + 1e-3 * float(self.u(q)[4, 2])


WRONG = {
    "twice the force": ({"force": scaled("force", 2.0)}, r"force against energy: they differ by .*; worst at block \d"),
    "another sign": ({"force": scaled("force", -1.0)}, "look at signs"),
    "one entry": ({"energy": shifted_energy}, r"block 4 of part 'plate', near \(.*\), component z of r: .* difference is"),
    "no tangent": ({"add_tangent": Term.add_tangent}, "tangent against force: .* worst at block"),
    "a part of it": ({"add_tangent": added("tangent", 0.02 * np.eye(3))}, "tangent against force"),
    "not symmetric": ({"add_tangent": one_sided}, r"tangent against force|skew part of the tangent"),
    "damping": ({"add_damping": added("damping", np.eye(3))}, "damping against force"),
    "other work": ({"between": scaled("between", 1.001)}, "work between two states .* the energy changes by"),
    "between of nothing": ({"energy": lambda self, q, case: None}, "no energy whose work it could do"),
    "mass": ({"add_mass": added("mass", -np.eye(3))}, "negative part of the mass"),
    "skew mass": ({"add_mass": added("mass", np.eye(3) + np.eye(3, k=1) - np.eye(3, k=-1))}, "skew part of the mass matrix"),
    "blocks": ({"couples": too_far}, "block 400 does not exist; the layout has blocks 0 to 8, in parts 'plate'"),
    "overlap": ({"couples": lambda self: np.array([[1, 1]])}, r"blocks overlap, cell 0 is \[1, 1\]"),
    "no cells": ({"couples": lambda self: [[1, 2]]}, "give an array .* of whole numbers"),
    "shape": ({"force": lambda self, q, v, case: np.zeros(3)}, "of shape .3,.; give 108 finite numbers"),
    "not finite": ({"force": lambda self, q, v, case: np.full(108, np.nan)}, "finite numbers"),
    "energy": ({"energy": lambda self, q, case: np.zeros(3)}, "give one finite number, or None"),
    "load": ({"load": True}, "twice the factor is not twice the force"),
}  # fmt: skip


@pytest.mark.parametrize("name", WRONG)
def test_what_is_wrong_is_said(name):
    wrong, message = WRONG[name]
    with pytest.raises(InputError, match=message) as caught:
        check_term(Beads(**wrong), PLATE.on(MESH, "full"))
    assert isinstance(caught.value, AssertionError)


def test_what_is_remembered_must_come_back():
    class Counts(OfBeads):
        calls = 0

        def restore(self, state):
            type(self).calls += 1

        def force(self, q, v, case):
            return (1.0 + self.calls) * super().force(q, v, case)

    system = PLATE.on(MESH, "full")
    with pytest.raises(InputError, match=r"force after restore\(state\(\)\)"):
        check_term(Counts(system.shell, system.layout), system)


@pytest.mark.parametrize("theory", ["kirchhoff", "full"])
def test_what_is_right_passes(theory):
    report = check_term(Beads(), PLATE, mesh=MESH, theory=theory)
    assert max(report.errors.values()) < 1e-6 and report.unchanged is False
    assert "tangent against force" in str(report) and "rigid motions change the energy" in str(report)
    system = PLATE.on(MESH, theory)
    shell = check_term(system.shell, system)
    assert shell.unchanged is True and max(shell.errors.values()) < 1e-6


class Bead(Addition):
    """A block of its own, tied to the node of number one by a spring."""

    def part(self, geometry):
        block = np.concatenate([np.zeros((1, 3)), np.eye(3)])[None]
        return Part("bead", block, np.ones((1, 12)), np.zeros((1, 3)))

    def on(self, shell, layout):
        return Tied(layout)


class Tied(Term):
    def __init__(self, layout):
        self.layout, self.cells = layout, np.array([[1, layout.part("bead").start]])

    def couples(self):
        return self.cells

    def apart(self, q):
        one, two = self.layout.nodal(q)[self.cells[0], 0]
        return two - one

    def energy(self, q, case):
        return 0.5 * float(self.apart(q) @ self.apart(q))

    def force(self, q, v, case):
        out = np.zeros_like(self.layout.undeformed)
        out[self.cells[0], 0] = [-self.apart(q), self.apart(q)]
        return out.ravel()

    def add_tangent(self, q, v, case, blocks):
        matrix = np.zeros((1, 2, 12, 2, 12))
        for i in range(2):
            for j in range(2):
                matrix[0, i, :3, j, :3] = (1 if i == j else -1) * np.eye(3)
        blocks.add(self.cells, matrix.reshape(1, 24, 24))


@pytest.mark.parametrize("theory", ["kirchhoff", "full"])
def test_a_term_with_a_block_of_its_own(theory):
    report = check_term(Bead(), PLATE, mesh=MESH, theory=theory)
    assert report.unchanged is True, "a spring between two blocks knows no place"
    system = sk.Problem(SURFACE, 0.05, PLATE.material, terms=[Bead()]).on(MESH, theory)
    assert system.to_mesh.shape == (108, 120) and system.to_mesh[:, 108:].nnz == 0


def test_what_is_no_term():
    with pytest.raises(InputError, match="give a system or a problem"):
        check_term(Beads(), MESH)
    with pytest.raises(InputError, match="a state of shape"):
        check_term(Beads(), PLATE, states=[np.zeros(3)])
    with pytest.raises(InputError, match="tolerance"):
        check_term(Beads(), PLATE, tolerance=-1.0)
