"""Thin shells with laws at points through the thickness: equilibrium, paths and outputs against exact states of rubber."""

from dataclasses import dataclass
from math import pi, sqrt

import numpy as np
import pytest

import skancf as sk
from skancf.materials import Gent, MooneyRivlin, NeoHooke, Ogden, section_of
from skancf.materials.point_law import FINE, PointResponse
from skancf.meshes import uniform
from skancf.system.unstressed import unstressed

RUBBER = NeoHooke(shear=4.225e5, density=1000.0)
COMPRESSIBLE = NeoHooke(shear=1.5e6, density=1000.0, poisson=0.45)
MIDDLE = np.array([[0.5], [0.5]])
SURFACES = {"flat": sk.Rectangle(1.0, 0.7), "cylinder": sk.CylinderSector(1.0, 1.0, 1.2)}
surfaces = pytest.mark.parametrize("surface", SURFACES.values(), ids=SURFACES)


@dataclass(frozen=True)
class StVenantKirchhoff:
    """The linear law, asked at points."""

    law: sk.Isotropic
    n_history = 0

    def __getattr__(self, name):
        return getattr(self.law, name)

    def respond(self, C, guess=None, history=None):
        plane = np.ix_([0, 1, 5], [0, 1, 5])
        Q, n = self.law.stiffness()[plane], C.shape[1]
        strain = np.stack([(C[0] - 1) / 2, (C[1] - 1) / 2, C[2]])
        stress = Q @ strain
        D = np.repeat(np.array([Q[0, 0], Q[1, 1], Q[2, 2], Q[0, 1], Q[0, 2], Q[1, 2]])[:, None], n, axis=1)
        across = 1 + 2 * self.law.thinning() @ strain
        return PointResponse((strain * stress).sum(axis=0) / 2, stress, D, across, np.full(n, FINE))

    plane_stress = respond


def state(system, rng, amount=0.02):
    return amount * system.layout.scales.ravel() * rng.uniform(-1, 1, system.n_dofs)


def near(found, expected, tolerance):
    assert np.abs(np.asarray(found) - expected).max() <= tolerance * np.abs(expected).max()


@pytest.mark.parametrize("law", [RUBBER, COMPRESSIBLE], ids=["incompressible", "compressible"])
@surfaces
def test_force_is_the_derivative_of_energy_and_tangent_that_of_force(surface, law):
    system = sk.Problem(surface, 0.01, law).on(uniform(surface, 3, 4), "kirchhoff")
    rng = np.random.default_rng(1)
    q, u, h = system.undeformed + state(system, rng), state(system, rng), 1e-5
    ahead, behind = q + h * u, q - h * u
    # Differences of step h, whose square times third derivatives is 1e-9 here.
    near((system.strain_energy(ahead) - system.strain_energy(behind)) / (2 * h), system.internal_force(q) @ u, 1e-8)
    change = (system.internal_force(ahead) - system.internal_force(behind)) / (2 * h)
    near(system.tangent(q) @ u, change, 1e-8)
    near(system.stresses(q, u) - system.stresses(q), (system.stresses(ahead) - system.stresses(behind)) / (2 * h), 1e-8)
    # The law takes part: a linear one has another energy at these strains.
    linear = sk.Problem(surface, 0.01, sk.Isotropic(3 * law.shear, law.rest_poisson - 1e-3, 1000.0))
    assert abs(linear.on(system.mesh, "kirchhoff").strain_energy(q) / system.strain_energy(q) - 1) > 1e-3


def test_the_linear_law_at_points_has_the_numbers_of_the_linear_road():
    """Of membrane strains alone; bending has the square of the height besides, which is of second order in the strain."""
    law, surface = sk.Isotropic(2e5, 0.3, 1000.0), sk.Rectangle(1.0, 0.7)
    mesh = uniform(surface, 4, 3)
    linear, at_points = (sk.Problem(surface, 0.01, each).on(mesh, "kirchhoff") for each in (law, StVenantKirchhoff(law)))
    rng = np.random.default_rng(3)
    flat = linear.layout.nodal(0.05 * state(linear, rng, 1.0)).copy()
    flat[:, :, 2] = 0.0
    q = linear.undeformed + flat.ravel()
    near(at_points.internal_force(q), linear.internal_force(q), 1e-12)
    near(at_points.strain_energy(q), linear.strain_energy(q), 1e-12)
    # The rest state has one stiffness; in curved elements, too, up to the thickness over the radius squared.
    near(at_points.stiffness().values, linear.stiffness().values, 1e-12)
    near(unstressed(at_points, plain=True).values, unstressed(linear, plain=True).values, 1e-12)
    bent = linear.undeformed + state(linear, rng)
    found, expected = at_points.strain_energy(bent), linear.strain_energy(bent)
    assert 1e-6 < abs(found / expected - 1) < 1e-1
    section = section_of(StVenantKirchhoff(law), 0.01)
    near(section.abd(), section_of(law, 0.01).abd(), 1e-15)


TABLE = {
    "incompressible": (NeoHooke(1.5e6, 1000.0), 1.0, 5.25e6, sqrt(0.5)),
    "compressible": (COMPRESSIBLE, 1.105598565, 4.374167e6, 0.743504729),
}


@pytest.mark.parametrize("law, volume, cauchy, width", TABLE.values(), ids=TABLE)
def test_a_strip_stretched_to_twice_its_length(law, volume, cauchy, width):
    """J, width and stress of J. Kiendl et al. (2015) and of the exact incompressible law, to their digits."""
    surface, thickness = sk.Rectangle(2.0, 1.0), 0.05
    supports = [sk.Symmetry(["left", "bottom"]), sk.Roller("left"), sk.Prescribed("right", (2.0, None, None))]
    result = sk.solve(sk.Problem(surface, thickness, law, supports).on(uniform(surface, 2, 2), "kirchhoff"))
    solution = result.unwrap()
    assert result.iterations < 15  # of one step
    stretch = np.sqrt(1 + 2 * solution.strains(MIDDLE)[0, 0, :3])
    near(stretch[1], width, 1e-8)
    near(stretch[2], solution.thickness_stretch(MIDDLE)[0, 0], 1e-14)
    near(stretch.prod(), volume, 1e-8)
    true = solution.cauchy_stresses(MIDDLE)[0, 0]
    near(true[0], cauchy, 1e-6)
    near(solution.stresses(MIDDLE)[0, 0, 0], true[0] * stretch.prod() / stretch[0] ** 2, 1e-12)
    near(solution.reactions("right")[0], true[0] * stretch[1] * stretch[2] * thickness, 1e-9)
    near(solution.section_forces(MIDDLE)[0, :3, 0], thickness * solution.stresses(MIDDLE)[0, 0, [0, 1, 5]], 1e-9)
    # To first order it is a linear law.
    small = sk.solve_linear(solution.system)
    young = 2 * law.shear * (1 + law.rest_poisson)
    near(small.stresses(MIDDLE)[0, 0], [young, 0, 0, 0, 0, 0], 1e-9)
    near(small.section_forces(MIDDLE)[0, 0], young * thickness, 1e-9)
    near(small.strains(MIDDLE)[0, 0, :3], [1.0, -law.rest_poisson, -law.rest_poisson], 1e-9)


def balloon(law, n, pressure=5000.0):
    surface = sk.SphereSector(10.0, (0.0, pi / 2), pi / 2)
    problem = sk.Problem(surface, 0.1, law, [sk.Symmetry(["start", "end", "bottom"])], [sk.FollowerPressure(pressure)])
    return problem.on(uniform(surface, n, n), "kirchhoff")


PLACES = [(x, y) for x in (0.4, 0.9, pi / 2) for y in (0.0, 0.8, pi / 2)]


def stretch_of(solution):
    return float(np.mean([np.linalg.norm(solution.position(at)) for at in PLACES])) / 10.0


MU = 4.225e5
BALLOONS = {
    "neo-Hooke": (RUBBER, 5236.73, 1.38309, 4158.98),
    "Mooney-Rivlin": (MooneyRivlin(7 / 16 * MU, MU / 16, 1000.0), 5945.96, 1.53519, 5718.61),
    "Ogden": (Ogden([(6.3e5, 1.3), (0.012e5, 5.0), (-0.1e5, -2.0)], 1000.0), 5494.12, 1.37405, 4108.07),
}


@pytest.mark.parametrize("law, most, at, at_two", BALLOONS.values(), ids=BALLOONS)
def test_a_balloon_past_its_limit_point(law, most, at, at_two):
    """An octant of 4 x 4 elements; a membrane has p = 2 t/R mu (1/l - l^-7), and so has the shell but for (t / R)^2."""
    end = sk.DisplacementReached((pi / 2, pi / 4), (1.0, 1.0, 0.0), 10.0)
    path = sk.trace(balloon(law, 4), sk.ArcLength(first=0.2), until=end).unwrap()
    (limit,) = path.events
    assert limit.kind == "limit point"
    # On 2 x 2 elements 7e-4, on 4 x 4 3e-5, what is left are the thickness, 1e-4 of the radius squared, and elements at the
    # pole.
    near(5000.0 * limit.load_factor, most, 1e-4)
    near(stretch_of(limit.solution), at, 1e-3)
    near(5000.0 * path.solution.load_factor, at_two, 1e-3)
    assert path.negative_pivots[-1] == 1
    assert path.iterations <= 4 * len(path.solutions)
    stretch = stretch_of(path.solution)
    near(path.solution.thickness_stretch(MIDDLE, "middle").mean(), stretch**-2, 2e-3)


def test_a_strip_bent_by_a_moment():
    """Rivlin's flexure of a plate, exact for normals that keep their length, which those of the plate do not:

    M = k/3 mu h^2 (1 - 0.3 k^2) for k = curvature times thickness, without that in the bracket for the shell."""
    moment, k, L = 0.033234, 0.1, 0.5
    surface = sk.Rectangle(L, 0.2)
    supports = [sk.Symmetry(["left", "bottom", "top"]), sk.Roller("left")]
    problem = sk.Problem(surface, 0.1, NeoHooke(1.0, 1000.0), supports, [sk.EdgeMoment("right", (0.0, -moment * 0.01, 0.0))])
    solution = sk.solve(problem.on(uniform(surface, 4, 1), "kirchhoff")).unwrap()
    near(solution.rotation((L, 0.1)) / (L * k / 0.1), 1 - 0.00299, 2e-5)


def test_where_a_law_ends_the_load_stops_and_the_place_is_told():
    most, surface = 0.3, sk.Rectangle(2.0, 1.0)
    supports = [sk.Symmetry(["left", "bottom"]), sk.Roller("left"), sk.Prescribed("right", (1.2, None, None))]
    problem = sk.Problem(surface, 0.05, Gent(1e6, most, 1000.0), supports)
    result = sk.solve(problem.on(uniform(surface, 2, 1), "kirchhoff"), relax=False)
    assert not result.ok
    # Steps are halved up to the place where l^2 + 2 / l - 3 is the limit.
    last = max(np.roots([1.0, 0.0, -3.0 - most, 2.0]).real)
    assert 0.9 < (1.0 + 0.6 * result.solution.load_factor - 1.0) / (last - 1.0) < 1.0
    for word in ("Gent has no stress in element", "(x, y) = (", "z = ", "membrane strain (", "below most = 0.3"):
        assert word in result.message, (word, result.message)


@pytest.mark.parametrize("thickness", [0.02, 0.005])
def test_the_mixed_iteration_bends_rubber_as_quickly_as_the_linear_law(thickness):
    """A strip to half a circle: 40 iterations, 38 and 39 of the linear law, and 70 and 116 of the plain iteration."""
    surface, moment = sk.Rectangle(1.0, 0.1), 4 * MU * thickness**3 / 12 * pi
    supports, load = [sk.Clamp("left"), sk.Symmetry(["top", "bottom"])], sk.EdgeMoment("right", (0.0, -moment, 0.0))
    count, ends = {}, {}
    linear = sk.Isotropic(3 * MU, 0.4999, 1.0)
    for name, law, mixed in (("rubber", RUBBER, True), ("plain", RUBBER, False), ("linear", linear, True)):
        system = sk.Problem(surface, thickness, law, supports, [load]).on(uniform(surface, 8, 1), "kirchhoff")
        result = sk.solve(system, mixed=mixed, rtol=1e-8)
        count[name], ends[name] = result.iterations, result.unwrap().displacement((1.0, 0.05))
    near(ends["rubber"], ends["plain"], 1e-7)
    assert count["rubber"] <= 1.2 * count["linear"] and count["plain"] > 1.5 * count["rubber"], count


class EndsAt(StVenantKirchhoff):
    """Its energy, and nothing else, is no number beyond a strain of 0.2."""

    def plane_stress(self, C, guess=None, history=None):
        found = self.respond(C)
        return np.where(C[0] > 1.4, np.nan, found.energy), found.stress, found.stiffness, found.stretch33


ENDS = {"Gent": Gent(1e6, 0.3, 1000.0), "EndsAt": EndsAt(sk.Isotropic(2e6, 0.3, 1000.0))}


@pytest.mark.parametrize("name", ENDS)
def test_paths_and_motions_name_the_place_too(name):
    surface = sk.Rectangle(2.0, 1.0)
    supports = [sk.Symmetry(["left", "bottom"]), sk.Roller("left"), sk.Prescribed("right", (1.2, None, None))]
    held = sk.Problem(surface, 0.05, ENDS[name], supports).on(uniform(surface, 2, 1), "kirchhoff")
    free = sk.Problem(surface, 0.05, ENDS[name]).on(uniform(surface, 2, 1), "kirchhoff")

    def thrown(x, y):
        return np.stack([60 * (x - 1), 0 * x, 0 * x])

    for stopped in (sk.solve(held, relax=False), sk.trace(held, sk.ArcLength(first=0.1)),
                    sk.simulate(free, 0.1, dt=2e-3, velocity=thrown, progress=False)):  # fmt: skip
        assert not stopped.ok
        for word in (f"{name} has no stress in element", "(x, y) = (", "membrane strain ("):
            assert word in stopped.message, (word, stopped.message)
