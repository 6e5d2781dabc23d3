"""Thin plates and shells in large displacement: elastica, roll-up, von Karman's plates, published shells."""

from functools import cache
from math import pi

import numpy as np
import pytest
from problems import PULLED, PUSHED
from problems import hemisphere as hemisphere_problem
from reference import elastica, sze, von_karman

import skancf as sk
from skancf.system.system import System

TWENTIETHS = sk.HalveAndGrow(first=0.05, growth=1.0)
EIGHTHS = sk.HalveAndGrow(first=1 / 8, growth=1.0)
YOUNG, THICKNESS = 1.2e6, 0.1
RIGIDITY = YOUNG * THICKNESS**3 / 12


def strip(n: int, load, length: float) -> System:
    """A cantilever of width 1, n elements."""
    material = sk.Isotropic(YOUNG, 0.0, 1.0)
    problem = sk.Problem(sk.Rectangle(length, 1.0), THICKNESS, material, [sk.Clamp("left")], [load])
    return problem.on(sk.meshes.uniform(problem.surface, n, 1), theory="kirchhoff")


def tip(solution: sk.Solution, length: float) -> np.ndarray:
    """-u and w in the middle of the end."""
    u = solution.displacement((length, 0.5))
    assert abs(u[1]) < 1e-8 * length, "the strip stays in its plane"
    return np.array([-u[0], u[2]])


# --- end force -------------------------------------------------------------------------------------------------------


@cache
def pushed(n: int, alpha: float, length: float = 10.0) -> sk.StaticResult:
    return sk.solve(strip(n, sk.EdgeLoad("right", (0, 0, alpha * RIGIDITY / length**2)), length), rtol=1e-9)


@pytest.mark.parametrize("alpha", range(1, 11))
def test_elastica_in_one_load_step(alpha):
    result = pushed(16, float(alpha))
    found = tip(result.unwrap(), 10.0) / 10.0
    # Measured 2e-6 to 6.3e-5: the strip stretches by up to alpha (h / L)^2 / 12 = 8e-6 alpha, which the elastica does not.
    assert np.hypot(*(found - elastica.tip(alpha))) < 1e-4
    assert result.iterations <= 14, "measured 6 to 9 for the whole load at once"


def test_order_four_against_the_strip_that_stretches():
    exact = np.array(elastica.extensible(100.0, 10.0))
    assert np.hypot(*(exact - elastica.tip(10.0))) > 5e-5
    errors = [np.hypot(*(tip(pushed(n, 10.0).unwrap(), 10.0) / 10.0 - exact)) for n in (8, 16, 32)]
    # Measured 1.06e-4, 1.3e-5, 7.0e-7: orders 3.0 and 4.2.
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    assert rates[0] > 2.9 and rates[1] > 3.9 and errors[-1] < 1e-6
    # The reference in the limit that does not stretch.
    assert np.allclose(elastica.extensible(1e5, 10.0), elastica.tip(10.0), atol=1e-8)


def test_end_shear_curve():
    """Published to 0.5 % of the end value by four-node elements; measured 0.05 %."""
    steps = sk.solve(strip(16, sk.EdgeLoad("right", (0, 0, 4.0)), 10.0), control=TWENTIETHS)
    found = np.array([tip(state, 10.0) for state in steps.path[1:]])
    assert found.shape == sze.END_SHEAR.shape
    assert np.abs(found - sze.END_SHEAR).max() < 0.005 * sze.END_SHEAR.max()
    at_once = sk.solve(strip(16, sk.EdgeLoad("right", (0, 0, 4.0)), 10.0))
    assert at_once.iterations <= 8  # measured 7
    assert np.allclose(tip(at_once.unwrap(), 10.0), found[-1], atol=1e-6)


# --- end moment ------------------------------------------------------------------------------------------------------


@cache
def rolled(n: int, length: float = 12.0) -> sk.StaticResult:
    """To a full circle in eight steps."""
    moment = 2 * pi * RIGIDITY / length
    return sk.solve(strip(n, sk.EdgeMoment("right", (0, -moment, 0)), length), control=EIGHTHS, rtol=1e-9)


def test_roll_up():
    result, length = rolled(16), 12.0
    assert len(result.path) == 9 and result.unwrap().load_factor == 1.0
    for state in result.path[1:]:
        found, turns = tip(state, length) / length, state.load_factor
        # Measured 5e-6 to 3.6e-4; at the end mostly stretch: h^2 k^2 / 12 = 2.3e-4 on a circle of curvature k.
        assert np.hypot(*(found - elastica.rolled(turns, 1.0))) < 1e-3
        # Against the strip that stretches: measured up to 9.5e-5, at the end.
        assert np.hypot(*(found - elastica.extensible(120.0, 0.0, 2 * pi * turns))) < 1.2e-4


def test_roll_up_converges_with_order_four():
    errors = [[np.hypot(*(tip(state, 12.0) / 12.0 - elastica.extensible(120.0, 0.0, 2 * pi * state.load_factor)))
               for state in rolled(n).path[1::2]] for n in (8, 16, 32)]  # fmt: skip
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    # Measured 3.8 to 4.0 from the first eighth to the last of the circle.
    assert (rates > 3.7).all()


# --- von Karman's plates ---------------------------------------------------------------------------------------------


VON_KARMAN = {
    "simple": (sk.SimpleSupport,),
    "clamped": (sk.Clamp,),
    "clamped, free in plane": (sk.Roller, sk.NoRotation),
}
LOADS = (6.25, 25.0, 100.0, 250.0)


@cache
def von_karman_ritz(edges: str) -> np.ndarray:
    return von_karman.centre(edges, LOADS, n=8)


def von_karman_plate(edges: str, load: float, slenderness: float, n: int, linear: bool = False) -> float:
    """w_c / h of a square plate, a quarter on n x n elements, under q a^4 / (E h^4) = load."""
    h, surface = 1 / slenderness, sk.Rectangle(0.5, 0.5)
    held = [kind(["left", "bottom"]) for kind in VON_KARMAN[edges]]
    supports = [sk.Symmetry("right"), sk.Symmetry("top"), *held]
    problem = sk.Problem(surface, h, sk.Isotropic(1.0, 0.3, 1.0), supports, [sk.SurfaceLoad((0, 0, load * h**4))])
    system = problem.on(sk.meshes.uniform(surface, n, n), theory="kirchhoff")
    solution = sk.solve_linear(system) if linear else sk.solve(system).unwrap()
    return solution.displacement((0.5, 0.5))[2] / h


@pytest.mark.parametrize("load", LOADS)
@pytest.mark.parametrize("edges", VON_KARMAN)
def test_large_deflection_of_plates(edges, load):
    """a / h = 400: von Karman's strains leave out the squares of w / a, 3e-5 at w = 2 h."""
    exact = von_karman_ritz(edges)[LOADS.index(load)]
    found = von_karman_plate(edges, load, 400.0, 12)
    # Measured at most 2e-6, 2e-5 and 6e-5, most of it of the mesh.
    assert np.isclose(found, exact, rtol=1e-4)
    if load > 25.0:
        assert von_karman_plate(edges, load, 400.0, 4, linear=True) > 1.2 * exact, "far from linear"


def test_von_karmans_strains_are_an_approximation():
    """The difference to Green's strains falls with the square of h / a: 4 times less on a plate twice as slender."""
    edges, exact = "clamped, free in plane", von_karman_ritz("clamped, free in plane")[2]
    thick, thin = (von_karman_plate(edges, LOADS[2], slenderness, 16) / exact - 1 for slenderness in (25.0, 50.0))
    assert 3.7 < thick / thin < 4.3


def test_von_karman_values_agree_with_published_ones():
    # Levy, NACA TN 847 (1942), clamped, Poisson's ratio 0.316: truncated double series, up to 2.5 % soft.
    loads, levy = (17.79, 63.4, 184.0, 402.0), (0.237, 0.695, 1.323, 1.902)
    found = von_karman.centre("clamped", loads, poisson=0.316)
    assert (np.diff(np.array(levy) / found) > 0).all() and np.allclose(found, levy, rtol=0.026)
    coarser = von_karman.centre("clamped, free in plane", LOADS, n=6)
    assert np.allclose(coarser, von_karman_ritz("clamped, free in plane"), rtol=1e-4)


# --- shells ----------------------------------------------------------------------------------------------------------

# On 64 x 64 elements; 48 x 48 differs by 3e-5.
CONVERGED = np.array([4.07417, 8.14929])


@cache
def hemisphere(n: int, control: sk.HalveAndGrow | None = None, assumed: bool = True) -> np.ndarray:
    """Displacements along the two forces of 200, at every step of the load: (steps, 2)."""
    problem = hemisphere_problem(force=200.0)
    system = problem.on(sk.meshes.uniform(problem.surface, n, n), sk.Kirchhoff(assumed=assumed))
    result = sk.solve(system, control=control)
    result.unwrap()
    return np.array([(s.displacement(PULLED)[0], -s.displacement(PUSHED)[1]) for s in result.path[1:]])


def test_hemisphere_curve():
    """Both displacements within 0.5 % of the larger end value; measured 0.49 %, halfway, and 0.38 % at the end."""
    found = hemisphere(24, TWENTIETHS)
    assert found.shape == sze.HEMISPHERE.shape
    assert np.abs(found - sze.HEMISPHERE).max() < 0.005 * sze.HEMISPHERE.max()
    linear = np.outer(np.arange(1, 21) / 20, 20 * found[0])
    assert np.abs(linear - sze.HEMISPHERE).max() > 0.5 * sze.HEMISPHERE.max(), "far from linear"


def test_hemisphere_on_coarse_meshes():
    coarse, medium, fine = (np.abs(hemisphere(n)[-1] / CONVERGED - 1).max() for n in (8, 16, 24))
    # Measured 1.6 %, 0.12 % and 0.03 %; plain strains 5.6 % and 0.7 %.
    assert coarse < 0.02 and medium < 0.003 and fine < 5e-4
    plain = np.abs(hemisphere(8, assumed=False)[-1] / CONVERGED - 1).max()
    assert plain > 0.045


def test_the_mixed_iteration_carries_the_hemisphere_in_few_iterations():
    problem = hemisphere_problem(force=200.0)
    system = problem.on(sk.meshes.uniform(problem.surface, 16, 16), "kirchhoff")
    mixed, plain = sk.solve(system), sk.solve(system, mixed=False)
    assert np.allclose(mixed.unwrap().displacement(PULLED), plain.unwrap().displacement(PULLED), rtol=1e-6, atol=1e-6)
    assert mixed.iterations <= 25, "measured 22"
    assert plain.iterations > 2 * mixed.iterations, "measured 92"


def test_slit_annulus():
    """A plate that is turned over; measured 0.36 and 0.29 % below the published four-node elements on 40 x 6."""
    surface = sk.AnnulusSector(6.0, 10.0, 2 * pi)
    found = []
    for nr, around in ((2, 12), (4, 24), (6, 40)):
        problem = sk.Problem(surface, 0.03, sk.Isotropic(21e6, 0.0, 1.0), [sk.Clamp("start")],
                             [sk.EdgeLoad("end", (0, 0, 0.8))])  # fmt: skip
        result = sk.solve(problem.on(sk.meshes.uniform(surface, nr, around), theory="kirchhoff"))
        found.append([result.unwrap().displacement((r, 2 * pi))[2] for r in (6.0, 10.0)])
    assert np.allclose(found[-1], sze.SLIT_ANNULUS, rtol=0.005)
    # Measured 1.1 and 0.07 %.
    assert np.allclose(found[0], found[-1], rtol=0.013) and np.allclose(found[1], found[-1], rtol=0.001)
