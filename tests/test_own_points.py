"""Elements with integration points of their own: the same where the points are the same, and as good elsewhere."""

from functools import cache

import numpy as np
import pytest
from problems import SURFACES
from reference import navier
from scipy.optimize import nnls

import skancf as sk
from skancf.elements.quad_ancf import square_quadrature
from skancf.errors import InputError
from skancf.history import FULL
from skancf.layout.geometry import Geometry
from skancf.meshes import quadtree, uniform
from skancf.system.build import build
from skancf.system.unstressed import unstressed
from skancf.theories import theory_named
from skancf.theories.kirchhoff.theory import legendre

MATERIAL = sk.Isotropic(2e5, 0.3, 2000.0, expansion=1e-5)
PLY = sk.Orthotropic(young=(5e5, 1e5, 1e5), poisson=(0.2, 0.1, 0.3), shear=(6e4, 5e4, 4e4), density=2000.0)
LAWS = {
    "isotropic": (MATERIAL, 0.1),
    "laminate": (sk.Laminate([sk.Layer(PLY, 0.06, 0.3), sk.Layer(PLY, 0.04, -1.1)], offset=0.01), None),
}
GAUSS = square_quadrature(4)
# Sums of some hundred products in another order, relative to the largest.
SUMS = 1e-13
# Symbols of Christoffel have no bound at a pole, where parts of the second derivatives cancel.
AT_POLE = 1e-12


def shuffled(seed):
    """The Gauss points in another order."""
    order = np.random.default_rng(seed).permutation(16)
    return GAUSS[0][:, order], GAUSS[1][order]


@cache
def compressed(seed, degree=3):
    """At most 16 of many points by chance that integrate cubics in each direction exactly, with positive weights."""
    rng = np.random.default_rng(seed)
    points = rng.uniform(size=(2, 400))
    moments = legendre(points, (degree + 1, degree + 1)).T
    exact = np.zeros((degree + 1) ** 2)
    exact[0] = 1.0
    weights, left = nnls(moments, exact)
    assert left < 1e-14
    used = np.flatnonzero(weights)
    used = np.concatenate([used, np.repeat(used[:1], 16 - len(used))])
    weights = np.where(np.arange(16) < np.count_nonzero(weights), weights[used], 0.0)
    return points[:, used], weights


def on(problem, mesh, own=None, theory="kirchhoff"):
    return build(problem, Geometry(mesh, problem.surface, theory_named(theory), own))


def mesh_of(name):
    surface, nx, ny = SURFACES[name]
    return surface, uniform(surface, nx, ny)


def trees(name):
    """With hanging nodes."""
    surface, mesh = mesh_of(name)
    tree = quadtree(mesh, surface)
    return surface, tree.refined(np.arange(0, len(tree.leaves), 3))


def close(found, expected, tolerance=SUMS):
    return np.abs(found - expected).max() <= tolerance * np.abs(expected).max()


def rotation(axis, angle):
    a = np.asarray(axis) / np.linalg.norm(axis)
    W = np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])
    return np.eye(3) + np.sin(angle) * W + (1 - np.cos(angle)) * W @ W


def moved(system, rng, amount=0.01):
    """Far from the undeformed state: disturbed, and turned by more than a right angle."""
    nodal = (system.undeformed + amount * rng.normal(size=system.n_dofs)).reshape(-1, 4, 3) @ rotation([1, 2, 3], 2.0).T
    nodal[:, 0] += [0.3, -0.2, 0.9]
    return nodal.ravel()


def pair(name, law, assumed=True, rule=shuffled, share=2):
    """A system with the shared points, and one of which every second element has its own."""
    surface, mesh = trees(name)
    material, thickness = LAWS[law]
    loads = [sk.SurfaceLoad(lambda x, y: (1 + x, y, x * y)), sk.Gravity((0.0, 1.0, -9.0))]
    loads += [sk.Temperature(lambda x, y: 10 + x, 5.0)] if law == "isotropic" else []
    problem = sk.Problem(surface, thickness, material, [sk.Foundation(lambda x, y: 10 + x)], loads)
    own = {e: rule(e % 3) for e in range(0, mesh.nelements, share)}
    theory = sk.Kirchhoff(assumed=assumed)
    return on(problem, mesh, theory=theory), on(problem, mesh, own, theory)


@pytest.mark.parametrize("assumed", [True, False], ids=["assumed", "plain"])
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("name", SURFACES)
def test_gauss_points_in_another_order_change_nothing(name, law, assumed, rng):
    shared, own = pair(name, law, assumed)
    assert len(own.geometry.integration.points) == 4
    q, change = moved(shared, rng), 0.01 * rng.normal(size=shared.n_dofs)
    other, rounding = moved(shared, rng), AT_POLE if shared.geometry.ties.poles else SUMS
    a, b = shared, own
    assert close(a.mass.values, b.mass.values)
    assert close(a.shell.internal_force(q), b.shell.internal_force(q))
    assert close(a.shell.force_of(q, a.stresses(q, change)), b.shell.force_of(q, b.stresses(q, change)))
    assert close(a.tangent(q).values, b.tangent(q).values, rounding)
    ahead = [system.tangent(q, stresses=system.stresses(q, change)).values for system in (a, b)]
    assert close(*ahead, rounding)
    assert close(a.stiffness().values, b.stiffness().values, rounding)
    assert close(unstressed(a, plain=True).values, unstressed(b, plain=True).values, rounding)
    assert close(a.external_force(q), b.external_force(q))
    assert np.isclose(a.strain_energy(q), b.strain_energy(q), rtol=SUMS)
    assert np.isclose(a.assembly.areas.sum(), b.assembly.areas.sum(), rtol=SUMS)
    between = [s.shell.force_between(q, other, (s.stresses(q) + s.stresses(other)) / 2) for s in (shared, own)]
    assert close(between[1], between[0])
    rests = [s.assembly.rest_energy(s.assembly.membrane_rest(q.reshape(-1, 4, 3))) for s in (shared, own)]
    assert np.isclose(*rests, rtol=1e-11)  # a small difference of large strains
    heats = [s.shell.thermal_energy() for s in (shared, own)]
    assert np.isclose(*heats, rtol=SUMS)


def test_a_weight_that_is_wrong_shows(rng):
    def wrong(seed):
        points, weights = shuffled(seed)
        return points, weights * (1 + 1e-9 * np.arange(16))

    shared, own = pair("cap", "isotropic", rule=wrong)
    q = moved(shared, rng)
    assert not close(own.tangent(q).values, shared.tangent(q).values, 1e-12)
    assert not close(own.mass.values, shared.mass.values, 1e-12)
    assert not np.isclose(own.strain_energy(q), shared.strain_energy(q), rtol=1e-12)


def test_points_in_another_place_show(rng):
    shared, own = pair("cap", "isotropic", rule=compressed)
    q = moved(shared, rng)
    assert not close(own.tangent(q).values, shared.tangent(q).values, 1e-4)


@pytest.mark.parametrize("assumed", [True, False], ids=["assumed", "plain"])
def test_tangent_is_the_derivative_of_the_force_and_that_of_the_energy(assumed, rng):
    surface, mesh = mesh_of("cap")
    problem = sk.Problem(surface, 0.1, MATERIAL, [], [sk.FollowerPressure(3.0), sk.Gravity()])
    system = on(problem, mesh, {e: compressed(e % 2) for e in range(0, mesh.nelements, 2)}, sk.Kirchhoff(assumed=assumed))
    q, step = moved(system, rng, 0.02), rng.normal(size=system.n_dofs)
    eps = 1e-6

    def difference(function):
        return (function(q + eps * step) - function(q - eps * step)) / (2 * eps)

    # Rounding over the step, 1e-16 / 1e-6 with some hundred terms, and the third derivatives times its square.
    assert np.isclose(difference(system.strain_energy), system.internal_force(q) @ step, rtol=1e-7)
    by_force = difference(lambda v: system.internal_force(v) - system.external_force(v))
    skew = system.skew(q, FULL)
    found = system.tangent(q) @ step + (0.0 if skew is None else skew @ step)
    assert close(found, by_force, 1e-7)
    start, end = q, q + 0.1 * step / np.abs(step).max()
    middle = (system.stresses(start) + system.stresses(end)) / 2
    work = system.shell.force_between(start, end, middle) @ (end - start)
    assert np.isclose(work, system.strain_energy(end) - system.strain_energy(start), rtol=1e-12)


def bare(name, thickness=0.1):
    surface, mesh = trees(name)
    own = {e: compressed(e % 3) for e in range(0, mesh.nelements, 2)}
    return on(sk.Problem(surface, thickness, MATERIAL), mesh, own)


@pytest.mark.parametrize("name", SURFACES)
def test_rest_and_rigid_motion_are_free_of_force(name):
    system = bare(name)
    nodal = system.undeformed.reshape(-1, 4, 3) @ rotation([1, -2, 1], 2.5).T
    nodal[:, 0] += [0.3, -0.2, 0.9]
    scale = np.abs(system.internal_force(1.01 * system.undeformed)).max()  # a strain of a hundredth
    assert np.abs(system.internal_force(system.undeformed)).max() < 1e-12 * scale
    assert np.abs(system.internal_force(nodal.ravel())).max() < 1e-12 * scale
    assert system.strain_energy(nodal.ravel()) < 1e-24 * system.strain_energy(1.1 * system.undeformed)


def test_constant_strains_are_exact():
    """Stretch, shear and bending of a flat plate: energy of the whole area, forces as with shared points."""
    surface = sk.Rectangle(1.0, 0.8)
    mesh = quadtree(uniform(surface, 4, 3)).refined(np.array([0, 5]))
    problem = sk.Problem(surface, 0.1, MATERIAL)
    own = on(problem, mesh, {e: compressed(e % 3) for e in range(0, mesh.nelements, 2)})
    shared = on(problem, mesh)
    abd, nodal = problem.section.abd(), own.undeformed.reshape(-1, 4, 3)
    F = np.array([[0.02, 0.03, 0.0], [-0.01, 0.015, 0.0], [0.0, 0.0, 0.0]])
    stretched = (nodal @ (np.eye(3) + F).T).ravel()
    E = ((np.eye(3) + F).T @ (np.eye(3) + F) - np.eye(3))[:2, :2] / 2
    strain = np.array([E[0, 0], E[1, 1], 2 * E[0, 1]])
    assert np.isclose(own.strain_energy(stretched), 0.4 * strain @ abd[:3, :3] @ strain, rtol=1e-12)
    assert close(own.internal_force(stretched), shared.internal_force(stretched), 1e-12)
    # Small bending w = (a x^2 + b y^2 + 2 c x y) / 2.
    a, b, c = 0.3, -0.2, 0.1
    x, y = own.geometry.points
    bent = np.zeros((len(x), 4, 3))
    bent[:, :, 2] = np.stack([(a * x**2 + b * y**2) / 2 + c * x * y, a * x + c * y, b * y + c * x, c + 0 * x], axis=1)
    kappa, change = -np.array([a, b, 2 * c]), bent.ravel()
    assert np.isclose(own.stiffness().energy(change), 0.4 * kappa @ abd[3:, 3:] @ kappa, rtol=1e-12)
    assert close(own.stiffness() @ change, shared.stiffness() @ change, 1e-12)


def deflection(n, cut, degree=3):
    """Error of the middle of a simply supported square under uniform load against Navier's series, relative.

    Own points where ``cut`` says so of the distance of an element's middle from the centre, in its side and in all.
    """
    surface = sk.Rectangle(1.0, 1.0)
    mesh = uniform(surface, n, n)
    problem = sk.Problem(surface, 0.01, MATERIAL, [sk.SimpleSupport("boundary")], [sk.SurfaceLoad((0.0, 0.0, 1.0))])
    away = np.linalg.norm(mesh.p[:, mesh.t].mean(axis=1) - 0.5, axis=0)
    rules = {int(e): compressed(int(e) % 50, degree) for e in np.flatnonzero(cut(n * (away - 0.3)))}
    D = MATERIAL.young * 0.01**3 / 12 / (1 - MATERIAL.poisson**2)
    found = sk.solve_linear(on(problem, mesh, rules)).displacement((0.5, 0.5))[2]
    return abs(found * D / navier.kirchhoff_uniform() - 1)


def orders_of(cut, degree=3):
    errors = np.array([deflection(n, cut, degree) for n in (4, 8, 16)])
    return np.log2(errors[:-1] / errors[1:]), errors[-1]


def test_the_deflection_of_a_supported_plate_is_of_order_four():
    """Elements along a circle, as a cut goes, have points that are exact for cubics.

    What the rough part of a second derivative, cubic in one direction, makes with a linear one is not: an error of order one
    in the energy norm, squared, times the share of these elements. It is seen where all elements have such points.
    """
    orders, last = orders_of(lambda away: np.abs(away) < 0.6)
    assert (orders > 3.8).all() and last < 1.5 * deflection(16, lambda away: away > np.inf)
    assert orders_of(lambda away: away == away)[0][-1] < 3.2
    assert orders_of(lambda away: np.abs(away) < 0.6, degree=2)[1] > 10 * last, "points that are exact for squares only"


def part_of(mesh, element, low, high, seed):
    """Points in the part low < x < high, in the element's side along x, of an element."""
    corners = mesh.p[:, mesh.t[:, element]]
    axis = 0 if corners[0, 1] != corners[0, 0] else 1
    low, high = (low, high) if corners[0, (1, 3)[axis]] > corners[0, 0] else (1 - high, 1 - low)
    points, weights = (part.copy() for part in compressed(seed))
    points[axis] = low + (high - low) * points[axis]
    return points, (high - low) * weights


@pytest.mark.parametrize(("low", "high"), [(0.25, 1.0), (0.3, 0.8), (0.0, 0.3)])
def test_a_thin_curved_strip_that_is_cut_out_of_elements_locks_no_more_than_whole_ones(low, high):
    """Without lateral contraction strips of any width bend alike: the energy goes with the width.

    Assumed strains that are fitted at the own points, and not at the Gauss points of the whole element, were 1.6 to 3.3
    times as wrong here.
    """
    surface, thickness = sk.CylinderSector(1.0, 0.15, 1.2), 1e-3
    mesh = uniform(surface, 1, 4)
    law = sk.Isotropic(2e11, 0.0, 1.0)
    problem = sk.Problem(surface, thickness, law, [sk.Clamp("start")], [sk.SurfaceLoad((0.0, 0.0, 1.0))])
    own = {e: part_of(mesh, e, low, high, e) for e in range(mesh.nelements)}

    def energy(mesh, own=None, theory="kirchhoff"):
        return sk.solve_linear(on(problem, mesh, own, theory)).strain_energy

    exact = energy(uniform(surface, 1, 64))
    whole, cut = energy(mesh) / exact - 1, energy(mesh, own) / (high - low) / exact - 1
    assert abs(cut) < 1.2 * abs(whole) < 2e-3
    assert abs(energy(mesh, own, sk.Kirchhoff(assumed=False)) / (high - low) / exact - 1) > 5 * abs(whole)


def test_a_free_expansion_has_no_stress():
    surface, mesh = mesh_of("tube")
    problem = sk.Problem(surface, 0.1, MATERIAL, [], [sk.Temperature(100.0)])
    system = on(problem, mesh, {e: compressed(e % 3) for e in range(0, mesh.nelements, 2)})
    grown = (1 + 1e-3) * system.undeformed
    residual = system.shell.force(grown, None, FULL)
    held = np.abs(system.external_force(system.undeformed)).max()
    # What is left is the square of the strain, and the curvature that grows with it.
    assert np.abs(residual).max() < 5e-3 * held


def test_what_is_no_set_of_points():
    surface, mesh = sk.Rectangle(1.0, 1.0), uniform(sk.Rectangle(1.0, 1.0), 2, 2)
    problem = sk.Problem(surface, 0.1, MATERIAL)
    points, weights = GAUSS
    for own, words in (({4: GAUSS}, "elements 0 to 3"), ({0: (points[:, :4], weights)}, "16 points"),
                       ({0: (2 * points, weights)}, "from 0 to 1"), ({0: (points, -weights)}, "not negative")):  # fmt: skip
        with pytest.raises(InputError, match=words):
            on(problem, mesh, own)
    with pytest.raises(InputError, match="theory 'kirchhoff'"):
        on(problem, mesh, {0: shuffled(0)}, "full")
