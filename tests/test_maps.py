"""Vectors that are eliminated: maps of blocks, one after another, and elements that see them."""

import numpy as np
import pytest

import skancf as sk
from skancf.kernels.schedule import Schedule
from skancf.layout.maps import Map, element_maps
from skancf.terms.blocks import Blocks

SURFACE = sk.CylinderSector(1.0, 2.0, 1.0)
theories = pytest.mark.parametrize("theory", ["kirchhoff", "full"])


def tree(surface=SURFACE):
    mesh = sk.meshes.quadtree(sk.meshes.uniform(surface, 2, 2), surface)
    return mesh.refined([0, 3])


def random_map(rng, n_targets, n_blocks, s=2):
    sources = rng.integers(0, n_blocks, (n_targets, s))
    return Map(sources, rng.normal(size=(n_targets, s, 4, 4)), n_blocks)


def test_maps_follow_each_other(rng):
    one, two = random_map(rng, 7, 5), random_map(rng, 9, 7, 3)
    both, nodal = one.after(two), rng.normal(size=(5, 4, 3))
    assert both.sources.shape == (9, 6) and np.allclose(both(nodal), two(one(nodal)), rtol=1e-12)
    dense = (two.matrix @ one.matrix).toarray()
    assert np.allclose(both.matrix.toarray(), dense, rtol=1e-12)
    assert np.allclose(both(nodal).reshape(-1, 3), dense @ nodal.reshape(-1, 3), rtol=1e-12)


BALL = sk.SphereSector(1.0, (0.0, np.pi), 2 * np.pi)


@pytest.mark.parametrize("surface", [SURFACE, BALL], ids=["sector", "closed, with poles"])
@theories
def test_that_of_a_mesh_has_no_unknowns_where_nodes_hang(theory, surface, rng):
    geometry = sk.Problem(surface, 0.1, sk.Isotropic(1.0, 0.3, 1.0)).on(tree(surface), theory).geometry
    T = geometry.of_nodes
    assert len(geometry.hanging.nodes) and T.matrix.shape == (4 * geometry.mesh.p.shape[1], 4 * geometry.n_nodes)
    nodal = rng.normal(size=geometry.undeformed.shape)
    at_mesh = T(nodal)
    own = geometry.ties.node_of >= 0
    assert np.allclose(at_mesh[own], geometry.ties.mix[own] @ nodal[geometry.ties.node_of[own]], rtol=1e-12)
    h = geometry.hanging
    assert np.allclose(at_mesh[h.nodes], (h.weights @ at_mesh[h.ends]).sum(axis=0), rtol=1e-12)


class Bonded:
    """The mesh nodes of one edge follow three other blocks, as an edge that is bonded to bodies or extended does."""

    def __init__(self, system, rng):
        geometry = system.geometry
        nodes = np.flatnonzero(np.isin(np.arange(geometry.n_nodes), geometry.nodes_on("left")))
        n = geometry.n_nodes
        sources, weights = np.zeros((n, 3), int), np.zeros((n, 3, 4, 4))
        sources[:, 0], weights[:, 0] = np.arange(n), np.eye(4)
        sources[nodes] = n + np.arange(3)
        weights[nodes] = np.eye(4) / 3 + 0.05 * rng.normal(size=(len(nodes), 3, 4, 4))
        self.map = Map(sources, weights, n + 3)
        own = np.stack([geometry.dense_map(e).reshape(16, -1, 4) for e in range(geometry.n_elements)])
        self.own = np.stack([[own[e, rows, c] for c, rows in enumerate(geometry.theory.rows)] for e in range(len(own))])
        self.maps = element_maps(self.own, geometry.nodes, geometry.theory.rows, self.map)


@theories
def test_elements_that_depend_on_more_blocks_than_corners(theory, rng):
    """Forces and tangents of the compiled kernels are T^T f and T^T K T of those without a map, to rounding."""
    mesh = sk.meshes.uniform(SURFACE, 3, 2)
    system = sk.Problem(SURFACE, 0.1, sk.Isotropic(1e3, 0.3, 1.0)).on(mesh, theory)
    bonded, assembly = Bonded(system, rng), system.assembly
    maps, n_blocks = bonded.maps, bonded.map.n_blocks
    assert maps.nodes.shape[1] > 4, "elements at the edge see three blocks and two nodes of their own"
    z = np.vstack([system.geometry.undeformed, np.zeros((3, 4, 3))])
    z[-3:] = system.geometry.undeformed[:3]
    z = z + 0.01 * rng.normal(size=z.shape)
    T = np.kron(bonded.map.matrix.toarray(), np.eye(3))
    q = bonded.map(z).ravel()
    schedule = Schedule(maps.nodes, mesh.p[:, mesh.t].mean(axis=1))
    force, stresses = np.zeros((n_blocks, 4, 3)), system.stresses(q)
    schedule.run(type(assembly).residual_kernel, z, assembly._tables, maps, assembly._elements, force)
    exact = T.T @ system.internal_force(q)
    assert np.abs(force.ravel() - exact).max() < 1e-11 * np.abs(exact).max()
    pattern = sk.linear.BlockPattern.from_cells(maps.nodes.T, n_blocks, 12, np.zeros((3, n_blocks)))
    blocks = Blocks(pattern)
    schedule.run(type(assembly).tangent_kernel, z, stresses, assembly._tables, maps, assembly._elements,
                 blocks.slots_of(maps.nodes), blocks.values)  # fmt: skip
    K, exact = blocks.matrix().to_scipy().toarray(), T.T @ system.tangent(q).to_scipy().toarray() @ T
    assert np.abs(K - exact).max() < 1e-11 * np.abs(exact).max()
    assert np.abs(system.tangent(q).to_scipy().toarray() - exact[: len(q), : len(q)]).max() > 0.1 * np.abs(exact).max()
