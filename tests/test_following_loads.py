"""Loads that follow the motion: forces as derivatives of potentials, tangents with their skew parts."""

from math import pi

import numpy as np
import pytest
from reference import follower_strip

import skancf as sk

SOFT = sk.Isotropic(1e3, 0.3, 1.0)
theories = pytest.mark.parametrize("theory", ["kirchhoff", "full"])
SURFACES = {
    "flat": sk.Rectangle(1.0, 1.0),
    "sector": sk.AnnulusSector(0.5, 1.0, 1.0),
    "cylinder": sk.CylinderSector(1.0, 1.0, 1.0),
    "tube": sk.CylinderSector(1.0, 1.0, 2 * pi, closed=True),
}
SIDE = {"flat": "right", "sector": "outer", "cylinder": "right", "tube": "right"}


def system_on(surface, theory, loads, supports=(), n=2, material=SOFT):
    mesh = sk.meshes.uniform(surface, n, 6 if any(surface.closed) else n)
    return sk.Problem(surface, 0.1, material, list(supports), list(loads)).on(mesh, theory)


def disturbed(system, rng, amount=0.05):
    return system.undeformed + amount * rng.normal(size=system.n_dofs)


def load_tangent(system, q, eps=1e-6):
    """Minus the derivative of the external force, by central differences."""
    unit = eps * np.eye(system.n_dofs)
    return -np.array([system.external_force(q + e) - system.external_force(q - e) for e in unit]).T / (2 * eps)


def own_tangents(system, q):
    """The loads' symmetric part in the tangent, and the skew part; those of the strains are taken away."""
    without = sk.Problem(system.geometry.surface, 0.1, SOFT).on(system.mesh, system.geometry.theory)
    symmetric = (system.tangent(q).to_scipy() - without.tangent(q).to_scipy()).toarray()
    skew = system.skew(q)
    return symmetric, np.zeros_like(symmetric) if skew is None else skew.toarray()


LOADS = {
    "pressure": lambda side: sk.FollowerPressure(200.0),
    "moment": lambda side: sk.EdgeMoment(side, (30.0, -50.0, 20.0)),
}


@theories
@pytest.mark.parametrize("surface", SURFACES)
@pytest.mark.parametrize("load", LOADS)
def test_tangent_and_skew_part_are_the_derivative_of_the_force(load, surface, theory, rng):
    system = system_on(SURFACES[surface], theory, [LOADS[load](SIDE[surface])])
    q = disturbed(system, rng)
    numeric, (symmetric, skew) = load_tangent(system, q), own_tangents(system, q)
    scale = np.abs(numeric).max()
    # Central differences: eps^2, and rounding over the step; the strains' part, taken away, is a hundred times larger.
    assert np.abs(symmetric + skew - numeric).max() < 1e-7 * scale
    assert np.abs(skew + skew.T).max() < 1e-14 * scale and np.abs(symmetric - symmetric.T).max() < 1e-12 * scale
    assert np.abs(symmetric - numeric).max() > 1e-2 * scale, "the symmetric part alone is another matrix"


@theories
@pytest.mark.parametrize("load", LOADS)
def test_half_of_the_load_is_half_of_its_tangent(load, theory, rng):
    system = system_on(SURFACES["sector"], theory, [LOADS[load]("outer")])
    q = disturbed(system, rng)
    none, half, whole = (system.tangent(q, sk.Case(factor)).values for factor in (0.0, 0.5, 1.0))
    assert np.abs(half - (none + whole) / 2).max() < 1e-14 * np.abs(whole).max()
    assert abs(system.skew(q, sk.Case(0.5)) - 0.5 * system.skew(q)).max() == 0


@theories
@pytest.mark.parametrize("load", LOADS)
def test_on_a_clamped_boundary_nothing_is_skew(load, theory, rng):
    """Loads of bodies whose edge is held have a potential."""
    surface = SURFACES["flat"]
    loads, boundary = [LOADS[load]("boundary")], [sk.Clamp("boundary")]
    system = system_on(surface, theory, loads, boundary, n=3)
    q = system.undeformed + system.constraints.free_part(0.05 * rng.normal(size=system.n_dofs))
    skew = system.skew(q)
    free = np.array([system.constraints.from_frame(e) for e in np.eye(system.n_dofs)[~system.constraints.fixed.ravel()]])
    assert np.abs(free @ skew @ free.T).max() < 1e-14 * abs(skew).max()
    one_free = system_on(surface, theory, [LOADS[load]("left")], [sk.Clamp(["right", "top", "bottom"])], n=3)
    skew, c = one_free.skew(q), one_free.constraints
    free = np.array([c.from_frame(e) for e in np.eye(system.n_dofs)[~c.fixed.ravel()]])
    assert np.abs(free @ skew @ free.T).max() > 0.1 * abs(skew).max(), "with a free edge it is"


def volume(system, q, n=6):
    r"""Enclosed by a closed surface, :math:`\tfrac13 \int r \cdot (r_{,1} \times r_{,2})`, by other points."""
    s, w = np.polynomial.legendre.leggauss(n)
    points = np.stack([a.ravel() for a in np.meshgrid((s + 1) / 2, (s + 1) / 2)])
    geometry, local = system.geometry, system.geometry.local(q.reshape(-1, 4, 3))
    r = np.einsum("ap,eai->epi", geometry.theory.position_table(points)[0], local)
    one, two = np.einsum("gap,eai->gepi", geometry.theory.slope_table(points), local)
    triple = (r * np.cross(one, two)).sum(axis=2)
    return float(geometry.side @ triple @ np.outer(w, w).ravel() / 12)


@theories
def test_pressure_in_a_closed_body_does_the_work_of_its_volume(theory, rng):
    ball = sk.SphereSector(2.0, (0.0, pi), 2 * pi, closed=True)
    system = system_on(ball, theory, [sk.FollowerPressure(5.0)], n=4)
    # Arcs of cubics on a coarse mesh: 0.5 % off in the thin theory, 1.3 % in the other.
    assert np.isclose(volume(system, system.undeformed), 4 / 3 * pi * 8, rtol=0.02)
    q, eps = disturbed(system, rng), 1e-5
    steps = eps * np.eye(system.n_dofs)
    numeric = 5.0 * np.array([volume(system, q + e) - volume(system, q - e) for e in steps]) / (2 * eps)
    force = system.external_force(q)
    # The volume is cubic: eps^2, and rounding of it over the step.
    assert np.abs(force - numeric).max() < 1e-8 * np.abs(force).max()
    assert system.skew(q) is None, "a closed surface has no edge"
    symmetric, _ = own_tangents(system, q)
    assert np.abs(symmetric - load_tangent(system, q, 1e-5)).max() < 1e-8 * np.abs(symmetric).max()


@theories
def test_pressure_on_a_closed_body_has_no_resultant(theory, rng):
    ball = sk.SphereSector(2.0, (0.0, pi), 2 * pi, closed=True)
    system = system_on(ball, theory, [sk.FollowerPressure(5.0)], n=4)
    q = disturbed(system, rng)
    force = system.external_force(q).reshape(-1, 4, 3)
    assert np.abs(force[:, 0].sum(axis=0)).max() < 1e-12 * np.abs(force[:, 0]).sum()
    assert np.abs(np.cross(q.reshape(-1, 4, 3), force).sum(axis=(0, 1))).max() < 1e-12 * np.abs(force).sum()
    dead = system_on(ball, theory, [sk.SurfaceLoad((0, 0, 5.0))], n=4).external_force(q).reshape(-1, 4, 3)
    assert np.abs(dead[:, 0].sum(axis=0)).max() > 0.1 * np.abs(dead[:, 0]).sum()


@theories
def test_moment_rolls_a_strip_up(theory):
    """A quarter of a circle by m = E t^3 / 12 kappa, nu = 0: its tip is at 2 / pi (1, 1) times the length.

    The end moment's axis stays in the surface and across it; it then has a potential.
    """
    strip, kappa = sk.Rectangle(1.0, 0.1), pi / 2
    stiff = sk.Isotropic(1e6, 0.0, 1.0)
    load = sk.EdgeMoment("right", (0.0, -1e6 * 0.01**3 / 12 * kappa, 0.0))
    mesh = sk.meshes.uniform(strip, 16, 1)
    system = sk.Problem(strip, 0.01, stiff, [sk.Clamp("left")], [load]).on(mesh, theory)
    tip = sk.solve(system).unwrap().position((1.0, 0.05))
    # Found 4e-5; the element of theory full is of order two: 2e-3.
    assert np.allclose(tip, [2 / pi, 0.05, 2 / pi], rtol=0, atol=1e-4 if theory == "kirchhoff" else 3e-3)


# --- a cantilever that the pressure rolls up -------------------------------------------------------------------------


def cantilever(load, n, t=0.003):
    """E I per width is 1."""
    strip = sk.Rectangle(1.0, 0.1)
    problem = sk.Problem(strip, t, sk.Isotropic(12 / t**3, 0.0, 1.0), [sk.Clamp("left")], [load])
    return problem.on(sk.meshes.uniform(strip, n, 1), "kirchhoff")


@pytest.mark.parametrize("load", [2.0, 10.0, 30.0])
def test_cantilever_under_follower_pressure_against_the_elastica(load):
    """The strip also stretches, by force over E A = 12 (L/t)^2 E I / L^2: what is left on a fine mesh falls with t^2."""
    x, y, angle = follower_strip.tip(load)

    def error(pressure, t):
        end = sk.solve(cantilever(pressure, 64, t)).unwrap()
        u = end.displacement((1.0, 0.05))
        return np.hypot(u[0] + 1 - x, u[2] - y), end

    follows, end = error(sk.FollowerPressure(load), 0.003)
    assert follows < 1e-4
    assert error(sk.FollowerPressure(load), 0.01)[0] == pytest.approx((0.01 / 0.003) ** 2 * follows, rel=0.15)
    assert end.rotation((1.0, 0.05)) == pytest.approx(np.arccos(np.cos(angle)), abs=1e-4)
    dead, _ = error(sk.SurfaceLoad((0.0, 0.0, load)), 0.003)
    assert dead > 50 * follows, "a pressure that does not follow bends it elsewhere"


def test_the_skew_part_takes_part_in_the_solution():
    """The last iterations are quadratic with it, linear without: the symmetric part alone needs more of them."""
    system, alone = (cantilever(sk.FollowerPressure(30.0), 16, 0.01) for _ in range(2))
    alone.skew = lambda *_: None
    with_skew, without = (sk.solve(s, control=sk.HalveAndGrow(first=0.05, growth=1.0)) for s in (system, alone))
    assert with_skew.unwrap() is not None
    assert without.iterations > 1.3 * with_skew.iterations, (without.iterations, with_skew.iterations)
