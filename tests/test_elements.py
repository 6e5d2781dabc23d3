"""One contract for all elements: what a shape function owes the rest of the library."""

from collections.abc import Callable

import numpy as np
import pytest
import skfem
from reference import quads

import skancf as sk
from skancf.elements import ALL, ElementQuadANCF, ElementQuadHermite, MappingPlate, through_thickness
from skancf.errors import InputError

# Products of a few polynomials of size one; slopes divide by edges of 0.15 and more, quads make the factor larger.
ROUNDING = 1e-13
CORNERS = np.array([[0.0, 1, 1, 0], [0, 0, 1, 1]])
# Row of the gradient that a dof is.
SLOPE = {"u_x": 0, "u_y": 1, "u_z": 2}
MESHES = {ElementQuadANCF: quads.ALL, ElementQuadHermite: quads.ALIGNED}


def pairs(kind: dict) -> pytest.MarkDecorator:
    """Every element on every mesh of a kind that it is made for."""
    found = [(make, name) for make in ALL for name in kind if name in MESHES[make]]
    return pytest.mark.parametrize("make,mesh", [pytest.param(make, kind[name], id=f"{make.__name__}-{name}")
                                                 for make, name in found])  # fmt: skip


elements = pytest.mark.parametrize("make", ALL)
on_all_meshes, on_aligned_meshes = pairs(quads.ALL), pairs(quads.ALIGNED)
general_meshes = pytest.mark.parametrize("mesh", quads.GENERAL.values(), ids=quads.GENERAL)
aligned_meshes = pytest.mark.parametrize("mesh", quads.ALIGNED.values(), ids=quads.ALIGNED)


def has_depth(make: Callable) -> bool:
    return "u_z" in make().dofnames


def at_depth(make: Callable, points: np.ndarray, depth: float = 0.3) -> np.ndarray:
    """Points (2, n) with a third row through the thickness, for the element that has one."""
    z = np.random.default_rng(2).uniform(-depth, depth, points.shape[1])
    return np.vstack([points, z]) if has_depth(make) else points


def some_points(n: int = 6) -> np.ndarray:
    """(xi, eta) inside the element."""
    return np.random.default_rng(1).uniform(0, 1, (2, n))


def functions(make: Callable, mesh: skfem.MeshQuad, X: np.ndarray) -> list:
    element, mapping = make(), MappingPlate(mesh)
    return [element.gbasis(mapping, X, i)[0] for i in range(4 * len(element.dofnames))]


def value(field: skfem.DiscreteField) -> np.ndarray:
    return np.asarray(field)


def dof_of(name: str, field: skfem.DiscreteField) -> np.ndarray:
    if name == "u_xy":
        return field.hess[0, 1]
    return value(field) if name == "u" else field.grad[SLOPE[name]]


def nodality_error(make: Callable, mesh: skfem.MeshQuad, points: np.ndarray = CORNERS) -> float:
    names, fields = make().dofnames, functions(make, mesh, at_depth(make, points, 0.0))
    table = np.array([[dof_of(name, f)[:, corner] for corner in range(4) for name in names] for f in fields])
    return float(np.abs(table - np.eye(len(fields))[:, :, None]).max())


def sampled(basis: skfem.Basis, **nodal: np.ndarray) -> np.ndarray:
    q = basis.zeros()
    for name, dofs in zip(basis.elem.dofnames, basis.nodal_dofs, strict=True):
        q[dofs] = nodal.get(name, 0.0)
    return q


def own_basis(make: Callable, mesh: skfem.MeshQuad) -> skfem.Basis:
    """Over the volume for the element that has a depth, else over the surface."""
    rule = through_thickness(mesh, 0.2, 4, 2) if has_depth(make) else {"intorder": 7}
    return skfem.Basis(mesh, make(), **rule)


@on_all_meshes
def test_each_function_has_its_own_dof(make, mesh):
    # The twist divides by two edges.
    assert nodality_error(make, mesh) < (1 if has_depth(make) else 10) * ROUNDING
    assert nodality_error(make, mesh, CORNERS + 0.01 * (1 - 2 * CORNERS)) > 1e-3, "a point beside the node is noticed"


@on_all_meshes
def test_position_functions_add_up_to_one(make, mesh):
    every = functions(make, mesh, at_depth(make, some_points()))
    own = [f for i, f in enumerate(every) if i % len(make().dofnames) == 0]
    assert np.abs(sum(value(f) for f in own) - 1).max() < ROUNDING
    assert np.abs(sum(f.grad for f in own)).max() < 10 * ROUNDING  # slopes divide by the edge length


@on_all_meshes
def test_gradients_are_those_of_the_values(make, mesh):
    X, eps, mapping = at_depth(make, some_points()), 1e-6, MappingPlate(mesh)
    steps = eps * np.eye(len(X))[:, :, None]
    ahead, behind = ([functions(make, mesh, X + sign * step) for step in steps] for sign in (1, -1))
    for i, f in enumerate(functions(make, mesh, X)):
        local = [(value(more[i]) - value(less[i])) / (2 * eps) for more, less in zip(ahead, behind, strict=True)]
        along = np.einsum("ij...,i...->j...", mapping.DF(X), f.grad[:2])
        # Rounding of the values over the step, 1e-16 / 1e-6; the cubic term is eps^2.
        for exact, difference in zip([*along, *f.grad[2:]], local, strict=True):
            assert np.abs(exact - difference).max() < 1e-9


def test_without_depth_the_mid_surface():
    mesh, X = quads.uneven(), at_depth(ElementQuadANCF, some_points(), 0.0)
    for flat, deep in zip(*(functions(ElementQuadANCF, mesh, points) for points in (X[:2], X)), strict=True):
        assert len(flat.grad) == 2 and len(deep.grad) == 3
        assert np.array_equal(value(flat), value(deep)) and np.array_equal(flat.grad, deep.grad[:2])


@on_all_meshes
def test_linear_fields_are_exact(make, mesh):
    basis = own_basis(make, mesh)
    (x, y), (a, b, c, d) = mesh.p, (0.4, -1.2, 0.7, 0.33 if has_depth(make) else 0.0)
    field = basis.interpolate(sampled(basis, u=a + b * x + c * y, u_x=b, u_y=c, u_z=d))
    X, Y, *Z = basis.global_coordinates()
    assert np.abs(field - (a + b * X + c * Y + d * sum(Z))).max() < ROUNDING
    assert np.abs(field.grad - np.array([b, c, d])[: len(field.grad), None, None]).max() < 10 * ROUNDING
    wrong = basis.interpolate(sampled(basis, u=a + b * x + c * y, u_x=c, u_y=b, u_z=d))
    assert np.abs(wrong - field).max() > 1e-2, "slopes of x and y exchanged should be noticed"


INCOMPLETE = [(m, n) for m in range(4) for n in range(4) if m + n <= 3 or (m, n) in ((3, 1), (1, 3))]
BICUBIC = [(m, n) for m in range(4) for n in range(4)]
MONOMIALS = {ElementQuadANCF: (INCOMPLETE, (2, 2)), ElementQuadHermite: (BICUBIC, (4, 0))}


def monomial_error(make: Callable, mesh: skfem.MeshQuad, m: int, n: int) -> float:
    def power(s: np.ndarray, k: int) -> np.ndarray:
        return s**k if k >= 0 else 0 * s

    basis, (x, y) = own_basis(make, mesh), mesh.p
    u_x, u_y, u_xy = m * power(x, m - 1) * y**n, n * x**m * power(y, n - 1), m * n * power(x, m - 1) * power(y, n - 1)
    X, Y = basis.global_coordinates()[:2]
    field = basis.interpolate(sampled(basis, u=x**m * y**n, u_x=u_x, u_y=u_y, u_xy=u_xy))
    return float(np.abs(field - X**m * Y**n).max())


@on_aligned_meshes
def test_monomials_on_rectangles(make, mesh):
    inside, outside = MONOMIALS[make]
    assert len(inside) == (12 if has_depth(make) else 16)
    assert max(monomial_error(make, mesh, m, n) for m, n in inside) < ROUNDING
    assert monomial_error(make, mesh, *outside) > 1e-4, "a monomial that is not in the space of this element"


@general_meshes
def test_on_general_quads_quadratic_fields_are_not_exact(mesh):
    """What distortion costs; linear fields stay exact."""
    assert monomial_error(ElementQuadANCF, mesh, 1, 0) < ROUNDING
    assert monomial_error(ElementQuadANCF, mesh, 2, 0) > 1e-4


def test_the_bicubic_element_refuses_general_quads():
    mesh = quads.uneven()
    mesh = skfem.MeshQuad(mesh.p + np.where(np.arange(9) == 8, 0.1, 0.0), mesh.t, sort_t=False)  # one corner moved
    askew = int(np.flatnonzero((mesh.t == 8).any(axis=0))[0])
    for use in (lambda: skfem.Basis(mesh, ElementQuadHermite()), lambda: sk.Problem(
            sk.Plane(), 0.1, sk.Isotropic(1.0, 0.3, 1.0)).on(mesh, "kirchhoff")):  # fmt: skip
        with pytest.raises(InputError, match=rf"1 of 4 elements .*element {askew} with corners .*theory 'full'"):
            use()


@on_aligned_meshes
def test_director_carries_z_times_bilinear(make, mesh):
    basis, (x, y) = own_basis(make, mesh), mesh.p
    X, Y, *Z = basis.global_coordinates()
    field = basis.interpolate(sampled(basis, u_z=1 + 2 * x - y + 3 * x * y))
    assert np.abs(field - sum(Z) * (1 + 2 * X - Y + 3 * X * Y)).max() < ROUNDING
    assert has_depth(make) == (np.abs(field).max() > 0.01)


@on_all_meshes
def test_continuity_across_edges(make, mesh, rng):
    """Values of both elements, slopes of the bicubic one only."""
    one, other = (skfem.InteriorFacetBasis(mesh, make(), side=side, intorder=5) for side in (0, 1))
    q = rng.normal(size=one.N)
    left, right = one.interpolate(q), other.interpolate(q)
    assert np.abs(left - right).max() < 10 * ROUNDING
    jump = np.abs(left.grad - right.grad).max()
    # Of the C0 element slopes agree at the nodes only.
    assert jump > 1e-2 if has_depth(make) else jump < 100 * ROUNDING
    if not has_depth(make):
        assert np.abs(left.hess - right.hess).max() > 1e-2, "two sides of an edge, not one twice"


@aligned_meshes
def test_second_derivatives_are_those_of_scikit_fem(mesh, rng):
    """Its Bogner-Fox-Schmit element has monomials of global coordinates, good to 1e-11 on edges of this size."""
    one, other = (skfem.Basis(mesh, make(), intorder=7) for make in (ElementQuadHermite, skfem.ElementQuadBFS))
    assert list(one.elem.dofnames) == list(other.elem.dofnames)
    q = rng.normal(size=one.N)
    mine, theirs = one.interpolate(q), other.interpolate(q)
    assert np.abs(mine.hess).max() > 10
    for a, b in ((value(mine), value(theirs)), (mine.grad, theirs.grad), (mine.hess, theirs.hess)):
        assert np.abs(a - b).max() < 1e-10 * max(1.0, np.abs(b).max())


def small_element(h: float) -> skfem.MeshQuad:
    return skfem.MeshQuad.init_tensor([1 - h, 1.0], [1 - h, 1.0])


@elements
def test_small_elements_far_from_the_origin_lose_no_digits(make):
    h, X = 1 / 1024, at_depth(make, CORNERS / 3, 0.0)
    power = {"u": 0, "u_x": 1, "u_y": 1, "u_z": 0, "u_xy": 2}
    unit, small = functions(make, small_element(1.0), X), functions(make, small_element(h), X)
    for i, (f, g) in enumerate(zip(unit, small, strict=True)):
        size = h ** power[make().dofnames[i % 4]]
        assert np.abs(value(g) - size * value(f)).max() < ROUNDING * size
        # scikit-fem's map adds up numbers of size one to an edge of length h: rounding 1e-16 / h.
        assert np.abs(g.grad[:2] * h - size * f.grad[:2]).max() < 1e-15 / h


def test_global_monomials_lose_all_digits():
    """Why functions live on the reference square here: scikit-fem's element on the same small square."""

    def is_useless(h: float) -> bool:
        mesh = small_element(h)
        try:
            at_own_node = skfem.ElementQuadBFS().gbasis(mesh.mapping(), CORNERS[:, :1], 0)[0]
        except np.linalg.LinAlgError:
            return True
        return not np.abs(value(at_own_node) - 1).max() < 1e-2

    assert not is_useless(0.5) and is_useless(1 / 1024)


@elements
def test_an_element_keeps_nothing_of_a_mesh(make):
    used = make()
    skfem.Basis(quads.uneven(), used)
    second = quads.uneven().scaled(2.0)
    stale, fresh = skfem.Basis(second, used), skfem.Basis(second, make())
    for f, g in zip(stale.basis, fresh.basis, strict=True):
        assert np.array_equal(value(f[0]), value(g[0])) and np.array_equal(f[0].grad, g[0].grad)


def test_works_in_forms():
    mesh = quads.GENERAL["distorted"]
    basis = skfem.Basis(mesh, skfem.ElementVector(ElementQuadANCF(), 3), **through_thickness(mesh, 0.2))
    area = skfem.Functional(lambda w: 1.0).assemble(skfem.Basis(mesh, skfem.ElementQuad1()))
    assert np.isclose(skfem.Functional(lambda w: 1.0).assemble(basis), 0.2 * area, rtol=ROUNDING)
    q = basis.zeros().reshape(-1, 4, 3)
    q[:, 0, :2], q[:, 1:] = mesh.p.T, np.eye(3)
    field = basis.interpolate(q.ravel())  # the plate itself: its gradient is the identity
    assert np.abs(field.grad - np.eye(3)[:, :, None, None]).max() < 10 * ROUNDING


# Project Chrono, unit test of ChElementShellANCF_3443: plate 1 x 1 x 0.01 m, 7850 kg/m3; entries of the first node
# in the mass matrix, and its gravity force with g = 9.80665 m/s2. Printed there to 15 digits.
MASS = {(0, 0): 10.7594841269841, (0, 1): 1.43605158730159, (3, 3): 7.26851851851852e-05}
GRAVITY = -192.45550625
PRINTED = 1e-12


def test_mass_and_gravity_by_forms():
    mesh = skfem.MeshQuad.init_tensor([0.0, 1.0], [0.0, 1.0])
    basis = skfem.Basis(mesh, ElementQuadANCF(), **through_thickness(mesh, 0.01, 4, 2))
    mass = skfem.BilinearForm(lambda u, v, w: 7850 * u * v).assemble(basis)
    weight = skfem.LinearForm(lambda v, w: -9.80665 * 7850 * v).assemble(basis)
    node = basis.nodal_dofs[:, np.flatnonzero((mesh.p == 0).all(axis=0))[0]]
    for (i, j), value in MASS.items():
        assert np.isclose(mass[node[i], node[j]], value, rtol=PRINTED)
    assert np.isclose(weight[node[0]], GRAVITY, rtol=PRINTED)
    under = skfem.Basis(mesh, ElementQuadANCF(), **through_thickness(mesh, 0.01, 3, 2))
    assert not np.isclose(
        skfem.BilinearForm(lambda u, v, w: 7850 * u * v).assemble(under)[node[0], node[0]], MASS[0, 0], rtol=1e-6
    ), "three points a side are too few for the mass, and this test would notice"


def test_mass_and_gravity_by_the_system():
    plate = sk.Problem(sk.Rectangle(1, 1), 0.01, sk.Isotropic(210e9, 0.3, 7850.0), loads=[sk.Gravity()])
    system = plate.on(sk.meshes.uniform(plate.surface, 1, 1))
    node = 12 * np.flatnonzero((system.mesh.p == 0).all(axis=0))[0]
    mass = system.mass.to_scipy()
    for (i, j), value in MASS.items():
        for component in range(3):
            at = node + 3 * i + component, node + 3 * j + component
            assert np.isclose(mass[at], value, rtol=PRINTED)
    weight = system.external_force(system.undeformed)
    assert np.isclose(weight[node + 2], GRAVITY, rtol=PRINTED)
    assert np.isclose(weight.reshape(-1, 4, 3)[:, 0, 2].sum(), -9.80665 * 78.5, rtol=PRINTED)
