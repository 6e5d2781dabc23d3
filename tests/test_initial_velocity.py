"""Velocities at the start: rigid ones, and functions of the parameters projected on the mesh."""

import numpy as np
import pytest
from problems import SURFACES

import skancf as sk
from skancf.dynamics.initial import initial_velocity
from skancf.errors import InputError

theories = pytest.mark.parametrize("theory", ["kirchhoff", "full"])
PLATE = sk.Rectangle(1.2, 0.8)
V, SPIN, ABOUT = np.array([0.3, -0.2, 0.5]), np.array([1.0, -2.0, 0.7]), np.array([0.2, 0.1, -0.4])
RIGID = sk.RigidVelocity(tuple(V), tuple(SPIN), tuple(ABOUT))


def system_on(theory, surface=PLATE, mesh=None, supports=(), thickness=0.05):
    mesh = sk.meshes.uniform(surface, 3, 2) if mesh is None else mesh
    return sk.Problem(surface, thickness, sk.Isotropic(1e6, 0.3, 2000.0), list(supports)).on(mesh, theory)


def turned(q, spin, about, angle):
    """The configuration after a rotation."""
    k = spin / np.linalg.norm(spin)
    nodal = q.reshape(-1, 4, 3).copy()
    nodal[:, 0] -= about
    out = nodal * np.cos(angle) + np.cross(k, nodal) * np.sin(angle) + np.multiply.outer(nodal @ k, k) * (1 - np.cos(angle))
    out[:, 0] += about
    return out.ravel()


# --- rigid -----------------------------------------------------------------------------------------------------------


@theories
@pytest.mark.parametrize("name", SURFACES)
def test_rigid_velocity_is_the_rate_of_a_rigid_motion(theory, name, rng):
    """By central differences, at a configuration that is no rest, and with the momenta of a rigid body."""
    surface, nx, ny = SURFACES[name]
    system = system_on(theory, surface, sk.meshes.uniform(surface, nx, ny))
    q = system.undeformed + 0.01 * rng.normal(size=system.n_dofs)
    h = 1e-5
    ahead, behind = (turned(q, SPIN, ABOUT, s * h * np.linalg.norm(SPIN)) for s in (1, -1))
    shift = np.zeros((len(q) // 12, 4, 3))
    shift[:, 0] = V
    assert np.allclose(RIGID.at(q), (ahead - behind) / (2 * h) + shift.ravel(), rtol=0, atol=1e-8)
    assert np.array_equal(initial_velocity(system, q, RIGID), RIGID.at(q))
    strained = system.internal_force(q)
    assert abs(strained @ RIGID.at(q)) < 1e-9 * np.linalg.norm(strained) * np.linalg.norm(RIGID.at(q)), "it strains nothing"


@theories
def test_momenta_of_a_flat_plate(theory):
    system, mass, centre = system_on(theory), 1.2 * 0.8 * 0.05 * 2000.0, np.array([0.6, 0.4, 0.0])
    linear, angular = system.momenta(system.undeformed, initial_velocity(system, system.undeformed, RIGID))
    assert np.allclose(linear, mass * (V + np.cross(SPIN, centre - ABOUT)), rtol=1e-12)
    rotary = 0.05**2 if theory == "full" else 0.0
    own = mass / 12 * np.array([0.8**2 + rotary, 1.2**2 + rotary, 1.2**2 + 0.8**2]) * SPIN
    assert np.allclose(angular, np.cross(centre, linear) + own, rtol=1e-12)


# --- functions -------------------------------------------------------------------------------------------------------


def cubic(x, y):
    return np.stack([1 + x - 2 * y + x * y, x**3 - y**3 + x**2 * y, 3 * x * y**2 - x**2 + y])


def cubic_slopes(x, y):
    one = np.ones_like(x)
    along_x = np.stack([one + y, 3 * x**2 + 2 * x * y, 3 * y**2 - 2 * x])
    along_y = np.stack([-2 * one + x, -3 * y**2 + x**2, 6 * x * y + one])
    twist = np.stack([one, 2 * x, 6 * y])
    return along_x, along_y, twist


@theories
def test_a_cubic_field_is_kept(theory):
    system = system_on(theory)
    v = initial_velocity(system, system.undeformed, cubic).reshape(-1, 4, 3)
    x, y = system.geometry.points
    along_x, along_y, twist = cubic_slopes(x, y)
    # The director turns with the surface: e_z stays across the slopes.
    director = -np.stack([along_x[2], along_y[2], 0 * x])
    expected = np.stack([cubic(x, y), along_x, along_y, twist if theory == "kirchhoff" else director])
    assert np.allclose(v, expected.transpose(2, 0, 1), rtol=0, atol=1e-10)


@theories
def test_a_rigid_function_is_the_rigid_velocity(theory):
    system = system_on(theory)

    def field(x, y):
        r = np.stack([x, y, 0 * x])
        return np.moveaxis(V + np.cross(SPIN, np.moveaxis(r, 0, -1) - ABOUT), -1, 0)

    v = initial_velocity(system, system.undeformed, field)
    assert np.allclose(v, RIGID.at(system.undeformed), rtol=0, atol=1e-10)


@theories
@pytest.mark.parametrize("name", [*SURFACES, "hanging"])
def test_linear_momentum_of_any_function(theory, name):
    """The integral of the density times the field, on every surface; sine waves that no mesh has."""
    surface, nx, ny = SURFACES.get(name, (PLATE, 2, 2))
    mesh = sk.meshes.uniform(surface, nx, ny)
    mesh = sk.meshes.quadtree(mesh).refined([0]) if name == "hanging" else mesh
    system = system_on(theory, surface, mesh, thickness=1e-3)

    def field(x, y):
        return np.stack([np.sin(9 * x), np.cos(3 * x), 1 + np.sin(7 * x)])

    v = initial_velocity(system, system.undeformed, field).reshape(-1, 4, 3)
    positions = v.copy()
    positions[:, 3] *= theory == "kirchhoff"
    momentum = system.momenta(system.undeformed, positions.ravel())[0]
    geometry, sections = system.geometry, system.assembly.sections
    masses = sections.moments[sections.shape][:, 0]
    expected = (field(*geometry.parameters(geometry.theory.quadrature[0])) * masses).sum(axis=(1, 2))
    assert np.allclose(momentum, expected, rtol=0, atol=1e-9 * masses.sum())
    at_nodes = np.zeros_like(v)
    at_nodes[:, 0] = field(*geometry.points).T
    interpolated = system.momenta(system.undeformed, at_nodes.ravel())[0]
    assert np.abs(interpolated - expected).max() > 1e-3 * masses.sum(), "values at the nodes alone would lose some"


def director_rates(director, slopes, rates):
    nodal, moved = np.zeros((2, len(director), 4, 3))
    nodal[:, 1:3], nodal[:, 3], moved[:, 1:3] = slopes, director, rates
    return sk.Full().following(nodal, moved)[:, 3]


def test_directors_follow_a_strained_and_turned_configuration(rng):
    """On a sheared and turned state a rigid field of the slopes still turns directors as the body."""
    slopes, director = rng.normal(size=(5, 2, 3)), rng.normal(size=(5, 3))
    found = director_rates(director, slopes, np.cross(SPIN, slopes))
    assert np.allclose(found, np.cross(SPIN, director), rtol=0, atol=1e-12)
    normal = np.cross(slopes[:, 0], slopes[:, 1])
    rates = rng.normal(size=(5, 2, 3))
    h = 1e-6
    n = [np.cross(*(slopes + s * h * rates).swapaxes(0, 1)) for s in (1, -1)]
    ahead, behind = (m / np.linalg.norm(m, axis=1, keepdims=True) for m in n)
    unit = normal / np.linalg.norm(normal, axis=1, keepdims=True)
    assert np.allclose(director_rates(unit, slopes, rates), (ahead - behind) / (2 * h), rtol=0, atol=1e-7)


# --- the rest --------------------------------------------------------------------------------------------------------


@theories
def test_none_and_arrays(theory, rng):
    system = system_on(theory)
    q, given = system.undeformed, rng.normal(size=system.n_dofs)
    assert not initial_velocity(system, q, None).any()
    assert np.array_equal(initial_velocity(system, q, given.reshape(-1, 4, 3)), given)


@pytest.mark.parametrize(("build", "words"), [
    (lambda s: sk.RigidVelocity(velocity=(1.0, 0.0)), "velocity = .*3 numbers"),
    (lambda s: sk.RigidVelocity(spin=(0, 0, np.inf)), "spin.*not finite"),
    (lambda s: sk.RigidVelocity(about=1.0), "about = .*3 numbers"),
    (lambda s: initial_velocity(s, s.undeformed, np.zeros(5)), "velocity has 5 entries"),
    (lambda s: initial_velocity(s, s.undeformed, np.full(s.n_dofs, np.nan)), "velocity.*not finite"),
    (lambda s: initial_velocity(s, s.undeformed, lambda x, y: (1.0, 2.0)), "velocity of shape"),
    (lambda s: initial_velocity(s, s.undeformed, lambda x, y: (0, 0, np.nan)), "velocity.*not finite"),
])  # fmt: skip
def test_mistakes(build, words):
    system = system_on("full")
    with pytest.raises(InputError, match=words):
        build(system)
