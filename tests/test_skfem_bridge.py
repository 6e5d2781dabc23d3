"""Bases of scikit-fem on the system's mesh, and the way from the unknowns to them."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp
import skfem
from problems import SURFACES
from reference import quads
from skfem.helpers import dot
from test_hanging import tree
from test_thin_kernel import mixed

import skancf as sk
from skancf.errors import InputError

# Two ways to add up sixteen products; relative to the largest value.
SUMS = 1e-12
MATERIAL = sk.Isotropic(1e6, 0.3, 2000.0)
theories = pytest.mark.parametrize("theory", ["kirchhoff", "full"])


def system_on(surface, mesh, theory):
    return sk.Problem(surface, 0.05, MATERIAL).on(mesh, theory)


def some_mesh(name):
    surface, *counts = SURFACES[name]
    return surface, mixed(sk.meshes.uniform(surface, *counts))


MESHES = {
    **{f"tree, {name}": (SURFACES[name][0], tree(name)) for name in SURFACES},
    **{f"renumbered, {name}": some_mesh(name) for name in SURFACES},
    "sphere": (sphere := sk.SphereSector(1.0, (0.0, np.pi), 2 * np.pi, closed=True), sk.meshes.uniform(sphere, 4, 6)),
    **{name: (sk.Plane(), mesh) for name, mesh in quads.GENERAL.items()},
}
CASES = [(n, t) for n in MESHES for t in ("kirchhoff", "full") if not (n in quads.GENERAL and t == "kirchhoff")]
everywhere = pytest.mark.parametrize(("name", "theory"), CASES)


def disturbed(system, rng):
    return system.undeformed + 0.1 * rng.normal(size=system.n_dofs)


def by_own_tables(system, q, points, elements):
    """r and its derivatives with respect to x and y at one point of each element: (n, 3), (n, 3, 2)."""
    geometry, theory = system.geometry, system.geometry.theory
    values, slopes = theory.position_table(points)[0], theory.slope_table(points)
    local = geometry.local(q.reshape(-1, 4, 3), elements)
    corners = system.mesh.p[:, system.mesh.t[:, elements]]
    (xi, eta), (a, b, c, d) = points, corners.swapaxes(0, 1)
    jacobian = np.stack([(1 - eta) * (b - a) + eta * (c - d), (1 - xi) * (d - a) + xi * (c - b)], axis=1)
    covariant = np.einsum("gae,eai->eig", slopes, local)
    return np.einsum("ae,eai->ei", values, local), covariant @ np.linalg.inv(np.moveaxis(jacobian, 2, 0))


@everywhere
def test_the_interpolated_surface_is_the_deformed_one(name, theory, rng):
    system = system_on(*MESHES[name], theory)
    q, basis = disturbed(system, rng), system.basis(5)
    field, x = basis.interpolate(system.to_mesh @ q), basis.global_coordinates()
    scale = np.abs(field).max()
    elements = np.arange(system.mesh.nelements)
    for k in range(x.shape[2]):
        values, slopes = by_own_tables(system, q, np.repeat(basis.X[:, [k]], len(elements), axis=1), elements)
        assert np.abs(np.asarray(field)[:, :, k].T - values).max() < SUMS * scale
        assert np.abs(field.grad[..., k].transpose(2, 0, 1) - slopes).max() < SUMS * np.abs(slopes).max()
    at = np.asarray(x)[:, ::3, 4]
    positions = sk.Solution(system, q).position(at.T)
    assert np.abs(np.asarray(field)[:, ::3, 4].T - positions).max() < SUMS * scale
    wrong = basis.interpolate(system.to_mesh @ disturbed(system, rng))
    assert np.abs(np.asarray(wrong)[:, ::3, 4].T - positions).max() > 1e-3 * scale, "another state is another surface"


@everywhere
def test_the_nodes_of_the_mesh_have_the_vectors_that_the_geometry_says(name, theory, rng):
    system = system_on(*MESHES[name], theory)
    q = disturbed(system, rng)
    expected = system.geometry.at_mesh_nodes(q.reshape(-1, 4, 3)).ravel()
    assert np.abs(system.to_mesh @ q - expected).max() < SUMS * np.abs(expected).max()
    assert system.to_mesh.shape == (system.basis(1).N, system.n_dofs)


@theories
def test_on_open_conforming_meshes_it_is_the_identity(theory):
    for surface, mesh in ((sk.Plane(), mixed(quads.uneven())), some_mesh("flat")):
        system = system_on(surface, mesh, theory)
        assert abs(system.to_mesh - sp.eye(system.n_dofs)).max() == 0
    closed = system_on(*MESHES["tree, tube"], theory)
    assert closed.to_mesh.shape[0] > closed.to_mesh.shape[1]


@theories
@pytest.mark.parametrize("name", ["tube", "disc"])
def test_forces_and_stiffness_come_back_by_the_transpose(name, theory, rng):
    """A uniform dead load: its form on the basis, and the library's own."""
    surface, mesh = MESHES[f"tree, {name}"]
    system = sk.Problem(surface, 0.05, MATERIAL, loads=[sk.SurfaceLoad((1.0, 2.0, 3.0))]).on(mesh, theory)
    T, basis = system.to_mesh, system.basis()
    undeformed = basis.interpolate(T @ system.undeformed)

    def area(w):
        return np.linalg.norm(np.cross(*w["X"].grad.swapaxes(0, 1), axis=0), axis=0)

    load = skfem.LinearForm(lambda v, w: (1.0 * v[0] + 2.0 * v[1] + 3.0 * v[2]) * area(w))
    mass = skfem.BilinearForm(lambda u, v, w: 2000.0 * dot(u, v) * area(w))
    force = T.T @ load.assemble(basis, X=undeformed)
    expected = system.external_force(system.undeformed)
    assert np.abs(force - expected).max() < SUMS * np.abs(expected).max()
    rigid = np.zeros((system.n_dofs // 12, 4, 3))
    rigid[:, 0] = [1.0, 2.0, 3.0]
    M = T.T @ mass.assemble(basis, X=undeformed) @ T
    whole = 14 * 2000.0 * skfem.Functional(area).assemble(basis, X=undeformed)
    assert np.isclose(rigid.ravel() @ (M @ rigid.ravel()), whole, rtol=SUMS)


@theories
def test_edges_have_bases_of_their_own(theory):
    surface = sk.AnnulusSector(1.0, 2.0, 1.0)
    system = system_on(surface, sk.meshes.uniform(surface, 3, 4), theory)
    length = skfem.Functional(lambda w: np.sqrt((w["X"].grad[:, 1] ** 2).sum(axis=0)))
    found = {}
    for name in ("inner", "outer"):
        basis = system.basis(facets=name)
        found[name] = length.assemble(basis, X=basis.interpolate(system.to_mesh @ system.undeformed))
    # Cubics make arcs of a quarter of a radian: 1e-7 of their length.
    assert np.isclose(found["inner"], 1.0, rtol=1e-5) and np.isclose(found["outer"], 2.0, rtol=1e-5)


def test_a_basis_of_the_volume():
    system = system_on(sk.Plane(), quads.uneven(), "full")
    basis = system.basis(thickness=0.2)
    volume = skfem.Functional(lambda w: np.linalg.det(np.moveaxis(w["r"].grad, (0, 1), (-2, -1))))
    found = volume.assemble(basis, r=basis.interpolate(system.to_mesh @ system.undeformed))
    assert np.isclose(found, 0.2 * quads.area(system.mesh), rtol=SUMS)


def demo():
    path = Path(__file__).parents[1] / "demos" / "plot_19_two_theories.py"
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@theories
def test_forms_of_both_theories_are_the_library(theory, rng, monkeypatch):
    """Those of the demo, which solves with them; one in a thousand of the law shows."""
    forms = demo()
    mesh = sk.meshes.quadtree(sk.meshes.uniform(forms.PLATE.surface, 2, 1)).refined([0])
    mine = forms.THEORIES[theory]
    system = forms.PLATE.on(mesh, mine.theory)
    q = disturbed(system, rng)
    force, tangent = mine.at(system, q)
    expected = system.internal_force(q)
    assert np.abs(force - expected).max() < SUMS * np.abs(expected).max()
    expected = system.tangent(q).to_scipy()
    assert abs(tangent() - expected).max() < SUMS * abs(expected).max()
    for law in ("SOLID", "BENDING"):
        monkeypatch.setattr(forms, law, 1.001 * getattr(forms, law))
    other, _ = mine.at(system, q)
    assert np.abs(other - force).max() > 1e-6 * np.abs(force).max()


def test_what_there_is_no_basis_for():
    surface = sk.Rectangle(1.0, 1.0)
    thin, full = (system_on(surface, sk.meshes.uniform(surface, 2, 2), theory) for theory in ("kirchhoff", "full"))
    with pytest.raises(InputError, match="no director and no depth"):
        thin.basis(thickness=0.1)
    with pytest.raises(InputError, match="edges have no depth"):
        full.basis(thickness=0.1, facets="left")
    with pytest.raises(InputError, match="intorder = 'high'"):
        full.basis("high")
    with pytest.raises(InputError, match="no boundary 'lid'"):
        full.basis(facets="lid")
