"""Adaptive buckling loads under forces at single points, and runs whose finer meshes say less than a coarser one."""

import numpy as np
import pytest

import skancf as sk
from skancf.adaptive import vibration
from skancf.adaptive.blunt import NOWHERE, blunt_points
from skancf.adaptive.stability import StabilityAnalysis
from skancf.solving import Status

PLATE, T = sk.Rectangle(0.3, 0.2), 0.01
SOFT = sk.Isotropic(young=3e6, poisson=0.3, density=1000.0)
CENTRE, TIP = (0.15, 0.1), (0.3, 0.1)


def pressed(zones=()):
    """A strip, clamped at the left and pressed at one point of the right edge."""
    return sk.Problem(PLATE, T, SOFT, [sk.Clamp("left")], [sk.PointForce(TIP, (-1.0, 0.0, 0.0))], zones=zones)


def at_point(mesh, point):
    """Elements with a corner there."""
    return np.flatnonzero((np.abs(mesh.p[:, mesh.t] - np.array(point)[:, None, None]).max(axis=0) < 1e-9).any(axis=0))


def smallest(mesh, point):
    """Length of the shortest side of an element there."""
    return np.ptp(mesh.p[:, mesh.t[:, at_point(mesh, point)]], axis=1).min()


STEPPED = [sk.Zone("thick", ((0.15, 0.3), (0.0, 0.1)), thickness=0.015, offset=0.002)]


@pytest.mark.parametrize(("zones", "rtol"), [((), 2e-4), (STEPPED, 1e-3)], ids=["even", "stepped"])
def test_a_point_force_buckles_no_single_elements(zones, rtol):
    """Against a uniform mesh of elements as large as twice the thickness, with an error of its own of less than 1e-3."""
    problem = pressed(zones)
    result = sk.adapt(problem, sk.BucklingLoad(), rtol)
    uniform = sk.buckling(problem.on(sk.meshes.uniform(PLATE, 16, 10), "kirchhoff"), 1).load_factors[0]
    assert result.ok and len(result.levels) > 2
    assert result.value == pytest.approx(uniform, rel=1e-3)
    # Elements of no more than one and a half of the thickness are not quartered.
    assert 0.75 * T < smallest(result.levels[-1].mesh, TIP) < 3 * T


def test_a_run_keeps_the_last_mesh_that_says_something(monkeypatch):
    """With small elements at the force, which buckle by themselves: the load falls to a small part on the last meshes."""
    sound = sk.adapt(pressed(), sk.BucklingLoad(), 2e-4)
    monkeypatch.setattr(StabilityAnalysis, "blunt", lambda self, system: NOWHERE)
    result = sk.adapt(pressed(), sk.BucklingLoad(), 1e-4)
    last = result.levels[-1]
    assert smallest(last.mesh, TIP) < T / 100
    assert result.status is Status.NO_LIMIT
    assert last.value < 0.5 * sound.value and last.bar > last.value
    assert abs(result.value - sound.value) < result.error_bar + sound.error_bar < 1e-3 * sound.value
    kept = next(level for level in result.levels if level.value == result.value)
    assert result.error_bar == kept.bar and result.solution.system.mesh.nelements == kept.n_elements < last.n_elements
    assert f"The answer is that on {kept.n_elements} elements: on {last.n_elements} it is" in result.message
    assert "zero within" not in result.message and not result.is_zero


def test_where_elements_stay_as_large_as_the_thickness():
    """At point forces, rods and single points that are held, by the thickness there; not along edges."""
    rod, pin = sk.RigidLink((0.0, 0.05), (0.3, 0.05)), sk.Pin([(0.1, 0.2)])
    problem = sk.Problem(PLATE, T, SOFT, [sk.Clamp("left"), pin], pressed().loads, conditions=[rod], zones=STEPPED)
    mesh = sk.meshes.uniform(PLATE, 6, 8)
    found = blunt_points(problem.on(mesh, "kirchhoff"))
    expected = {(0.3, 0.1), (0.0, 0.05), (0.3, 0.05), (0.1, 0.2)}
    assert {tuple(np.round(point[:2], 12)) for point in found.points.T} == expected
    at_rod = np.isclose(found.points[1], 0.05) & np.isclose(found.points[0], 0.3)
    assert found.sizes[at_rod] == pytest.approx(0.015) and found.sizes[np.isclose(found.points[1], 0.2)] == pytest.approx(T)
    edge = sk.Problem(PLATE, T, SOFT, [sk.Clamp("left")], [sk.EdgeLoad("right", (-1.0, 0.0, 0.0))])
    assert not blunt_points(edge.on(mesh, "kirchhoff")).sizes.size


def test_second_differences_along_a_singular_shape(monkeypatch):
    """A twist at a node of small elements strains those alone: steps of twice the size find the same force."""
    mesh = sk.meshes.quadtree(sk.meshes.uniform(PLATE, 6, 4), PLATE)
    for _ in range(12):
        mesh = mesh.refined(at_point(mesh, CENTRE))
    assert smallest(mesh, CENTRE) < 2e-5
    system = pressed().on(mesh, "kirchhoff")
    shape, at = np.zeros(system.n_dofs), system.layout.nodal(system.undeformed)
    moved = system.layout.nodal(shape)
    moved[:, 0, 0], moved[:, 1, 0] = at[:, 0, 0] ** 2, 2 * at[:, 0, 0]
    centre = np.argmin(np.linalg.norm(at[:, 0, :2] - CENTRE, axis=1))
    moved[centre, 3, 0] = 1e4
    found = vibration.softening(system, system.undeformed, shape)
    monkeypatch.setattr(vibration, "STEP", 2 * vibration.STEP)
    again = vibration.softening(system, system.undeformed, shape)
    assert np.abs(again - found).max() < 1e-4 * np.abs(found).max()
