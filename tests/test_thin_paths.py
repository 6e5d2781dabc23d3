"""Whole paths of thin shells: snap-through of a hinged roof, buckling, and what load control says of it."""

from functools import cache
from math import pi

import numpy as np
import pytest
from reference import sze
from scipy.interpolate import CubicSpline

import skancf as sk
from skancf.solving import Status

CROWN = (254.0, pi / 2)
DOWN = (0.0, 0.0, -1.0)


def roof(n, thickness=12.7):
    surface = sk.CylinderSector(2540.0, 508.0, 0.2, start=pi / 2 - 0.1)
    problem = sk.Problem(
        surface, thickness, sk.Isotropic(3102.75, 0.3, 1.0), [sk.Pin("start"), sk.Pin("end")],
        [sk.PointForce(CROWN, (0, 0, -3000.0))],
    )  # fmt: skip
    return problem.on(sk.meshes.uniform(surface, n, n), "kirchhoff")


@cache
def path(n, largest=2.0):
    control = sk.ArcLength(first=0.1, steps=sk.StepLength(largest=largest))
    return sk.trace(roof(n), control, until=1.08, steps=150).unwrap()


def curve(found):
    """Load factor as a function of the deflection of the crown, which grows all along this path."""
    w = -found.displacement(CROWN)[:, 2]
    assert (np.diff(w) > 0).all()
    return CubicSpline(w, found.load_factors)


def test_hinged_roof_follows_the_published_path():
    """Distance of the published points from the path, in units of the largest deflection and load.

    They are those of shear-flexible S4R elements and good to half a percent; 24 x 24 elements here move the path by 2e-4.
    """
    w, load = sze.HINGED_ROOF.T
    fine = np.linspace(0, w[-1], 4001)
    ours = curve(path(16))(fine)
    distance = np.hypot(np.subtract.outer(w, fine) / w.max(), np.subtract.outer(load, ours) / load.max()).min(axis=1)
    assert distance.max() < 0.0065, distance
    assert distance.mean() < 0.0035


def test_hinged_roof_has_converged():
    w = np.linspace(0, 29, 100)
    coarse, fine = (curve(path(n))(w) for n in (8, 16))
    assert np.abs(coarse - fine).max() < 0.01  # of 1.08: order 4, and 24 x 24 moves it by less than 1e-3


def test_events_of_the_roof():
    """Two limit points; between them the tangent has one negative eigenvalue more."""
    found = path(16)
    limits = [event for event in found.events if event.kind == "limit point"]
    assert len(limits) == 2
    # The largest and smallest published loads, 0.7421 and 0.1729, at points that lie an increment apart.
    for event, load, w in zip(limits, (0.7421, 0.1729), (10.9, 19.5), strict=True):
        assert event.load_factor == pytest.approx(load, abs=0.005 * 1.08)
        assert -event.solution.displacement(CROWN)[2] == pytest.approx(w, abs=0.5)
    between = (found.load_factors < limits[0].load_factor) & (-found.displacement(CROWN)[:, 2] > 12)
    assert (found.negative_pivots[between & (-found.displacement(CROWN)[:, 2] < 19)] >= 1).all()
    assert found.negative_pivots[0] == found.negative_pivots[-1] == 0
    assert found.iterations < 6 * len(found.solutions), "a step takes a few iterations"


def test_load_control_names_the_limit_point_and_keeps_what_it_has():
    result = sk.solve(roof(8), relax=False)
    assert result.status is Status.LIMIT_POINT and "limit point near 0.7415" in result.message, result.message
    assert "solve(system, follow=True)" in result.message
    assert 0.74 < result.solution.load_factor < 0.7416


@pytest.mark.parametrize("thickness", [12.7, 6.35])
def test_load_steps_go_on_by_arc_length_where_asked(thickness):
    """Through the limit points of both roofs, also where the crown moves back, to the state beyond."""
    wanted = {12.7: 0.9, 6.35: 0.3}[thickness]
    result = sk.solve(roof(8, thickness), load_factor=wanted, follow=True)
    assert result.status is Status.CONVERGED and result.solution.load_factor == pytest.approx(wanted, rel=1e-12)
    assert result.message.count("limit point at") == 2 and result.negative_pivots == 0
    assert [state.load_factor for state in result.path] != sorted(state.load_factor for state in result.path)
    if thickness == 12.7:
        assert curve(path(8))(-result.solution.displacement(CROWN)[2]) == pytest.approx(wanted, abs=1e-3)


def test_pulled_cylinder_passes_its_two_limit_points():
    """An open cylinder pulled apart: at half of the load, bending turns into stretching within 0.3 % of it (Sze, Liu and Lo,
    3.5: end values 2.768, 4.551 and 3.303 under 40 000, with S4R elements)."""
    surface = sk.CylinderSector(4.953, 10.35 / 2, pi / 2)
    problem = sk.Problem(
        surface, 0.094, sk.Isotropic(10.5e6, 0.3125, 1.0), [sk.Symmetry("left"), sk.Symmetry("start"), sk.Symmetry("end")],
        [sk.PointForce((0.0, pi / 2), (0, 0, 10_000.0))],
    )  # fmt: skip
    found = sk.trace(problem.on(sk.meshes.uniform(surface, 16, 16), "kirchhoff"), until=1.0, steps=100).unwrap()
    u = found.solution.displacement([(0.0, pi / 2), (0.0, 0.0), (10.35 / 2, 0.0)])
    ends = np.array([u[0, 2], np.linalg.norm(u[1]), np.linalg.norm(u[2])])
    # 16 x 16 elements for an eighth against 24 x 36 S4R.
    assert np.allclose(ends, [2.768, 4.551, 3.303], rtol=0.025), ends
    assert found.iterations < 100


def test_displacement_control_passes_the_limit_points():
    found = sk.trace(roof(8), sk.DisplacementControl(CROWN, DOWN, to=25.0, first=0.1)).unwrap()
    w, load = -found.displacement(CROWN)[:, 2], found.load_factors
    assert w[-1] == pytest.approx(25.0, rel=1e-9)
    assert np.abs(curve(path(8))(w) - load).max() < 1e-3  # the spline between the points of the other path
    assert load.max() > 0.7 > 0.25 > load[(w > 15)].min()


def test_the_thinner_roof_snaps_back():
    """With t = 6.35 the crown moves back for a while: the path turns in its deflection, and the load changes sign."""
    found = sk.trace(roof(12, 6.35), sk.ArcLength(first=0.05), until=0.3, steps=150).unwrap()
    w = -found.displacement(CROWN)[:, 2]
    assert (np.diff(w) < 0).any() and found.load_factors.min() < 0 < found.load_factors[-1]


def test_roll_up_of_a_very_thin_strip_ends_at_its_load():
    """L/h = 1000, bent into a circle. From a long step the solve at the end's load fails; the path must not go on beyond."""
    length, thickness, young = 10.0, 0.01, 210e9
    moment = 2 * pi * young * thickness**3 / 12 / length
    problem = sk.Problem(
        sk.Rectangle(length, 1.0), thickness, sk.Isotropic(young, 0.0, 1.0),
        [sk.Clamp("left"), sk.Roller("bottom", (0, 1, 0))], [sk.EdgeMoment("right", (0, -moment, 0))],
    )  # fmt: skip
    found = sk.trace(problem.on(sk.meshes.uniform(problem.surface, 16, 2), "kirchhoff"), until=1.0).unwrap()
    assert any(not attempt.ok for attempt in found.attempts), "the end was looked for in vain once"
    assert (np.diff(found.load_factors) > 0).all() and found.load_factors[-1] == pytest.approx(1.0, rel=1e-12)
    # A full circle brings the end back to the clamp, but for the elements: 9e-5 of the length.
    assert np.abs(found.solution.displacement((length, 0.5)) - [-length, 0, 0]).max() < 1e-4 * length


# --- eigenvalues -----------------------------------------------------------------------------------------------------

# omega a^2 sqrt(rho t / D), nu = 0.3, by Ritz's method with polynomials of high order; the first ones agree with the
# NAFEMS benchmark FV12 (free) and, to its digits, with A. W. Leissa, J. Sound Vib. 31 (1973) 257-293.
FREQUENCIES = {
    "simple": ([sk.SimpleSupport("boundary")], [19.7392, 49.3480, 49.3480, 78.9568, 98.6960]),
    "clamped": ([sk.Clamp("boundary")], [35.98519, 73.39385, 73.39385, 108.2165, 131.5808, 132.2048]),
    "free": ([], [13.46820, 19.59614, 24.27020, 34.80089, 34.80089, 61.09323]),
    "one edge": ([sk.Clamp("left")], [3.4710, 8.5062, 21.284, 27.199, 30.954]),
    "corners": ([sk.Pin("corners")], [7.11088, 15.77024, 15.77024, 19.59614, 38.43154, 44.36961]),
}


def finer_at_the_ends(n, both=True):
    """Positions of nodes from 0 to 1: elements at the ends, or at the first one only, are about half of the mean."""
    s = np.linspace(0, 1, n + 1)
    return 0.6 * s + 0.4 * ((1 - np.cos(pi * s)) / 2 if both else 1 - np.cos(pi * s / 2))


@pytest.mark.parametrize("edges", FREQUENCIES)
def test_frequencies_of_square_plates(edges):
    supports, expected = FREQUENCIES[edges]
    surface, t = sk.Rectangle(1.0, 1.0), 1e-3
    plate = sk.Problem(surface, t, sk.Isotropic(1e6, 0.3, 1.0), supports)
    scale = np.sqrt(1e6 * t**3 / 12 / 0.91 / t)
    rigid, errors = (6 if edges == "free" else 0), []
    for n in (8, 16):
        mesh = sk.meshes.uniform(surface, n, n)
        if edges == "one edge":  # its ends are singular corners
            mesh = sk.meshes.tensor(surface, finer_at_the_ends(n, both=False), finer_at_the_ends(n))
        modes = sk.modes(plate.on(mesh, "kirchhoff"), len(expected) + rigid)
        assert modes.n_rigid == rigid
        errors.append(modes.omega[rigid:] / scale / expected - 1)
    # On 16 x 16 elements; the fifth and sixth mode between clamped edges, shorter waves, need 20 x 20 for 1e-4.
    few = 4 if edges == "clamped" else len(expected)
    assert np.abs(errors[1][:few]).max() < 1e-4 and np.abs(errors[1]).max() < 1.5e-4
    assert np.abs(errors[0]).max() > 3 * np.abs(errors[1]).max()


def test_plate_under_compression_buckles_at_four_pi_squared():
    surface, t = sk.Rectangle(1.0, 1.0), 1e-3
    D = 1e6 * t**3 / 12 / 0.91
    held = [sk.Roller("boundary"), sk.Prescribed((0, 0), (0, 0, None)), sk.Prescribed((0, 1), (0, None, None))]
    push = [sk.EdgeLoad("right", (-1.0, 0, 0)), sk.EdgeLoad("left", (1.0, 0, 0))]
    errors = []
    for n in (4, 8):
        plate = sk.Problem(surface, t, sk.Isotropic(1e6, 0.3, 1.0), held, push)
        factors = sk.buckling(plate.on(sk.meshes.uniform(surface, n, n), "kirchhoff")).load_factors
        expected = [pi**2 * D * (m + 1 / m) ** 2 for m in (1, 2, 3)]
        errors.append(np.abs(factors[:3] / expected - 1))
    assert errors[1][0] < 3e-5 and errors[1].max() < 3e-3
    assert errors[0][0] > 10 * errors[1][0]  # order 4
