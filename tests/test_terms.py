"""Terms and unknowns of the user's own, in every solver: a body on a spring, and a second block at each node."""

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

    def __init__(self, layout, cells, matrix, mass=0.0, masses=()):
        self.layout, self.cells, self.matrix = layout, cells, matrix
        self.mass, self.masses = mass, np.asarray(masses, int)
        self.undeformed = layout.undeformed.ravel()

    def couples(self):
        return self.cells

    def _blocks(self, q):
        return self.layout.blocks(q - self.undeformed)[self.cells].reshape(len(self.cells), -1)

    def force(self, q, v, case):
        out = np.zeros((self.layout.n_blocks, 12))
        np.add.at(out, self.cells, (self._blocks(q) @ self.matrix).reshape(*self.cells.shape, 12))
        return out.ravel()

    def energy(self, q, case):
        u = self._blocks(q)
        return 0.5 * float(np.vdot(u, u @ self.matrix))

    def add_tangent(self, q, v, case, blocks):
        if not blocks.skew:
            blocks.add(self.cells, np.repeat(self.matrix[None], len(self.cells), axis=0))

    def add_mass(self, blocks):
        if self.mass:
            blocks.add(self.masses[:, None], np.repeat(self.mass * np.eye(12)[None], len(self.masses), axis=0))


def between(k):
    """Matrix (24, 24) of a spring between the first vectors of two blocks."""
    out = np.zeros((24, 24))
    for i in range(3):
        out[np.ix_([i, 12 + i], [i, 12 + i])] = k * np.array([[1.0, -1.0], [-1.0, 1.0]])
    return out


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

    def __init__(self, one=30.0, other=60.0):
        self.one, self.other = one, other

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
        return Quadratic(layout, cells, matrix)


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
            return Quadratic(layout, np.arange(shell.geometry.n_nodes)[:, None], matrix)

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
