"""One contract for all elements: what a shape function owes the rest of the library."""

from collections.abc import Callable

import numpy as np
import pytest
import skfem
from reference import quads

import skancf as sk
from skancf.elements import ALL, MappingPlate, through_thickness

# Products of a few polynomials of size one; slopes divide by edges of 0.15 and more, quads make the factor larger.
ROUNDING = 1e-13
CORNERS = np.array([[0.0, 1, 1, 0], [0, 0, 1, 1], [0, 0, 0, 0]])
ROW = {"u": None, "u_x": 0, "u_y": 1, "u_z": 2}

elements = pytest.mark.parametrize("make", ALL)
aligned_meshes = pytest.mark.parametrize("mesh", quads.ALIGNED.values(), ids=quads.ALIGNED)
general_meshes = pytest.mark.parametrize("mesh", quads.GENERAL.values(), ids=quads.GENERAL)
meshes = pytest.mark.parametrize("mesh", quads.ALL.values(), ids=quads.ALL)


def some_points(n: int = 6, depth: float = 0.3) -> np.ndarray:
    """(xi, eta, z) inside the element and through its thickness."""
    rng = np.random.default_rng(1)
    return np.vstack([rng.uniform(0, 1, (2, n)), rng.uniform(-depth, depth, n)])


def functions(make: Callable, mesh: skfem.MeshQuad, X: np.ndarray) -> list:
    element, mapping = make(), MappingPlate(mesh)
    return [element.gbasis(mapping, X, i)[0] for i in range(4 * len(element.dofnames))]


def value(field: skfem.DiscreteField) -> np.ndarray:
    return np.asarray(field)


def dof_of(name: str, field: skfem.DiscreteField) -> np.ndarray:
    return value(field) if ROW[name] is None else field.grad[ROW[name]]


def nodality_error(make: Callable, mesh: skfem.MeshQuad, X: np.ndarray = CORNERS) -> float:
    names, fields = make().dofnames, functions(make, mesh, X)
    table = np.array([[dof_of(name, f)[:, corner] for corner in range(4) for name in names] for f in fields])
    return float(np.abs(table - np.eye(len(fields))[:, :, None]).max())


def sampled(basis: skfem.Basis, **nodal: np.ndarray) -> np.ndarray:
    q = basis.zeros()
    for name, dofs in zip(basis.elem.dofnames, basis.nodal_dofs, strict=True):
        q[dofs] = nodal.get(name, 0.0)
    return q


def volume_basis(make: Callable, mesh: skfem.MeshQuad) -> skfem.Basis:
    return skfem.Basis(mesh, make(), **through_thickness(mesh, 0.2, 4, 2))


@elements
@meshes
def test_each_function_has_its_own_dof(make, mesh):
    assert nodality_error(make, mesh) < ROUNDING
    beside = CORNERS + 0.01 * (1 - 2 * CORNERS) * np.array([[1.0], [1], [0]])
    assert nodality_error(make, mesh, beside) > 1e-3, "a point beside the node should be noticed"


@elements
@meshes
def test_position_functions_add_up_to_one(make, mesh):
    own = [f for i, f in enumerate(functions(make, mesh, some_points())) if i % len(make().dofnames) == 0]
    assert np.abs(sum(value(f) for f in own) - 1).max() < ROUNDING
    assert np.abs(sum(f.grad for f in own)).max() < 10 * ROUNDING  # slopes divide by the edge length


@elements
@meshes
def test_gradients_are_those_of_the_values(make, mesh):
    X, eps, mapping = some_points(), 1e-6, MappingPlate(mesh)
    jacobian = mapping.DF(X)
    step = [np.array([[eps], [0], [0]]), np.array([[0], [eps], [0]]), np.array([[0], [0], [eps]])]
    ahead, behind = ([functions(make, mesh, X + sign * d) for d in step] for sign in (1, -1))
    for i, f in enumerate(functions(make, mesh, X)):
        local = [(value(ahead[j][i]) - value(behind[j][i])) / (2 * eps) for j in range(3)]
        expected = np.einsum("ij...,i...->j...", jacobian, f.grad[:2])
        # Rounding of the values over the step, 1e-16 / 1e-6; the cubic term is eps^2.
        assert np.abs(expected - local[:2]).max() < 1e-9
        assert np.abs(f.grad[2] - local[2]).max() < 1e-9


@elements
def test_without_depth_the_mid_surface(make):
    mesh, X = quads.uneven(), some_points(depth=0.0)
    for flat, deep in zip(functions(make, mesh, X[:2]), functions(make, mesh, X), strict=True):
        assert len(flat.grad) == 2 and len(deep.grad) == 3
        assert np.array_equal(value(flat), value(deep)) and np.array_equal(flat.grad, deep.grad[:2])


@elements
@meshes
def test_linear_fields_are_exact(make, mesh):
    basis = volume_basis(make, mesh)
    (x, y), (a, b, c, d) = mesh.p, (0.4, -1.2, 0.7, 0.33)
    field = basis.interpolate(sampled(basis, u=a + b * x + c * y, u_x=b, u_y=c, u_z=d))
    X, Y, Z = basis.global_coordinates()
    assert np.abs(field - (a + b * X + c * Y + d * Z)).max() < ROUNDING
    assert np.abs(field.grad - np.array([b, c, d])[:, None, None]).max() < 10 * ROUNDING
    wrong = basis.interpolate(sampled(basis, u=a + b * x + c * y, u_x=c, u_y=b, u_z=d))
    assert np.abs(wrong - field).max() > 1e-2, "slopes of x and y exchanged should be noticed"


MONOMIALS = [(m, n) for m in range(4) for n in range(4) if m + n <= 3 or (m, n) in ((3, 1), (1, 3))]


def monomial_error(make: Callable, mesh: skfem.MeshQuad, m: int, n: int) -> float:
    def power(s: np.ndarray, k: int) -> np.ndarray:
        return s**k if k >= 0 else 0 * s

    basis, (x, y) = volume_basis(make, mesh), mesh.p
    q = sampled(basis, u=x**m * y**n, u_x=m * power(x, m - 1) * y**n, u_y=n * x**m * power(y, n - 1))
    X, Y, _ = basis.global_coordinates()
    return float(np.abs(basis.interpolate(q) - X**m * Y**n).max())


@elements
@aligned_meshes
def test_twelve_monomials_on_rectangles(make, mesh):
    assert len(MONOMIALS) == 12
    assert max(monomial_error(make, mesh, m, n) for m, n in MONOMIALS) < ROUNDING
    assert monomial_error(make, mesh, 2, 2) > 1e-4, "x2 y2 is not in the space of this element"


@elements
@general_meshes
def test_on_general_quads_quadratic_fields_are_not_exact(make, mesh):
    """What distortion costs; linear fields stay exact."""
    assert monomial_error(make, mesh, 1, 0) < ROUNDING
    assert monomial_error(make, mesh, 2, 0) > 1e-4


@elements
@aligned_meshes
def test_director_carries_z_times_bilinear(make, mesh):
    basis, (x, y) = volume_basis(make, mesh), mesh.p
    X, Y, Z = basis.global_coordinates()
    field = basis.interpolate(sampled(basis, u_z=1 + 2 * x - y + 3 * x * y))
    assert np.abs(field - Z * (1 + 2 * X - Y + 3 * X * Y)).max() < ROUNDING


@elements
@meshes
def test_values_are_continuous_across_edges_and_slopes_are_not(make, mesh, rng):
    one, other = (skfem.InteriorFacetBasis(mesh, make(), side=side, intorder=5) for side in (0, 1))
    q = rng.normal(size=one.N)
    left, right = one.interpolate(q), other.interpolate(q)
    assert np.abs(left - right).max() < 10 * ROUNDING
    # Across an edge the slope agrees at the nodes only: this element is C0.
    assert np.abs(left.grad - right.grad).max() > 1e-2


def small_element(h: float) -> skfem.MeshQuad:
    return skfem.MeshQuad.init_tensor([1 - h, 1.0], [1 - h, 1.0])


@elements
def test_small_elements_far_from_the_origin_lose_no_digits(make):
    h = 1 / 1024
    unit, small = functions(make, small_element(1.0), CORNERS / 3), functions(make, small_element(h), CORNERS / 3)
    for i, (f, g) in enumerate(zip(unit, small, strict=True)):
        size = h if make().dofnames[i % 4] in ("u_x", "u_y") else 1.0
        assert np.abs(value(g) - size * value(f)).max() < ROUNDING
        # scikit-fem's map adds up numbers of size one to an edge of length h: rounding 1e-16 / h.
        assert np.abs(g.grad[:2] * h - size * f.grad[:2]).max() < 1e-15 / h

    def error_of_bfs(h: float) -> float:
        """Value of scikit-fem's global monomials in the node where the function is one."""
        mesh = small_element(h)
        return float(np.abs(skfem.ElementQuadBFS().gbasis(mesh.mapping(), CORNERS[:2, :1], 0)[0] - 1).max())

    assert error_of_bfs(0.5) < 1e-9 and error_of_bfs(h) > 1, "why functions live on the reference square here"


@elements
def test_an_element_keeps_nothing_of_a_mesh(make):
    used = make()
    skfem.Basis(quads.uneven(), used)
    second = quads.uneven().scaled(2.0)
    stale, fresh = skfem.Basis(second, used), skfem.Basis(second, make())
    for f, g in zip(stale.basis, fresh.basis, strict=True):
        assert np.array_equal(value(f[0]), value(g[0])) and np.array_equal(f[0].grad, g[0].grad)


@elements
def test_works_in_forms(make):
    mesh = quads.GENERAL["distorted"]
    basis = skfem.Basis(mesh, skfem.ElementVector(make(), 3), **through_thickness(mesh, 0.2))
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


@elements
def test_mass_and_gravity_by_forms(make):
    mesh = skfem.MeshQuad.init_tensor([0.0, 1.0], [0.0, 1.0])
    basis = skfem.Basis(mesh, make(), **through_thickness(mesh, 0.01, 4, 2))
    mass = skfem.BilinearForm(lambda u, v, w: 7850 * u * v).assemble(basis)
    weight = skfem.LinearForm(lambda v, w: -9.80665 * 7850 * v).assemble(basis)
    node = basis.nodal_dofs[:, np.flatnonzero((mesh.p == 0).all(axis=0))[0]]
    for (i, j), value in MASS.items():
        assert np.isclose(mass[node[i], node[j]], value, rtol=PRINTED)
    assert np.isclose(weight[node[0]], GRAVITY, rtol=PRINTED)
    under = skfem.Basis(mesh, make(), **through_thickness(mesh, 0.01, 3, 2))
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
