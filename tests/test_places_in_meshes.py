"""Which element holds a point, and what is there."""

import numpy as np
import pytest
import skfem

import skancf as sk
from skancf.meshes.finder import element_finder
from skancf.vectors import cross, sum_of_cross


def distorted(rng: np.random.Generator, mirrored: bool) -> skfem.MeshQuad:
    """General quads, corners numbered either way round."""
    mesh = skfem.MeshQuad.init_tensor(np.linspace(0, 2, 7), np.linspace(-1, 1, 6))
    inner = np.setdiff1d(np.arange(mesh.p.shape[1]), mesh.boundary_nodes())
    points = mesh.p.copy()
    points[:, inner] += rng.uniform(-0.1, 0.1, (2, len(inner)))
    return skfem.MeshQuad(points, mesh.t[::-1] if mirrored else mesh.t)


@pytest.mark.parametrize("mirrored", [False, True])
def test_points_are_found_in_the_elements_that_they_were_made_in(rng, mirrored):
    mesh = distorted(rng, mirrored)
    xi, eta = rng.uniform(0.01, 0.99, (2, mesh.t.shape[1]))
    shape = np.stack([(1 - xi) * (1 - eta), xi * (1 - eta), xi * eta, (1 - xi) * eta])
    points = (mesh.p[:, mesh.t] * shape).sum(axis=1)
    order = rng.permutation(points.shape[1])
    assert (element_finder(mesh)(*points[:, order]) == order).all()


def test_a_point_of_several_elements_is_in_the_first(rng):
    mesh = distorted(rng, False)
    nodes = np.arange(mesh.p.shape[1])
    first = [np.flatnonzero((mesh.t == node).any(axis=0))[0] for node in nodes]
    assert (element_finder(mesh)(*mesh.p) == first).all()


def test_no_element_is_an_error(rng):
    mesh = distorted(rng, False)
    assert element_finder(mesh)(np.array([]), np.array([])).size == 0
    for x, y in ((2.001, 0.0), (1.0, -1.001), (-5.0, 7.0)):
        with pytest.raises(ValueError, match="outside"):
            element_finder(mesh)(np.array([0.5, x]), np.array([0.5, y]))


def test_displacements_at_many_points_are_those_at_each(rng):
    plate = sk.Problem(sk.Rectangle(2.0, 1.0), 0.05, sk.Isotropic(1e6, 0.3, 1.0), supports=[sk.Clamp("left")])
    for theory in ("kirchhoff", "full"):
        system = plate.on(sk.meshes.uniform(plate.surface, 3, 2), theory)
        state = sk.Solution(system, system.undeformed + 0.01 * rng.standard_normal(system.n_dofs))
        at = rng.uniform(0, 1, (9, 2)) * [2.0, 1.0]
        for z in (0.0, 0.02):
            assert np.allclose(state.displacement(at, z), [state.displacement(point, z) for point in at], atol=1e-15)
        assert np.allclose(sk.Solution(system, system.undeformed).position(at)[:, :2], at)
        with pytest.raises(sk.InputError, match=r"point \(2\.5, 0\.5\) lies outside"):
            state.displacement([(0.5, 0.5), (2.5, 0.5)])
        with pytest.raises(sk.InputError, match="give a point"):
            state.displacement([0.5, 0.5, 0.5])


def test_products_of_vectors(rng):
    a, b = rng.standard_normal((2, 3, 4, 5))
    assert np.allclose(cross(a, b), np.cross(a, b, axis=0))
    rows = np.moveaxis(a, 0, 2), np.moveaxis(b, 0, 2)
    assert np.allclose(sum_of_cross(*rows), np.cross(*rows).sum(axis=(0, 1)))
