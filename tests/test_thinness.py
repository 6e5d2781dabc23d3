"""Is thin theory enough? Shear forces from equilibrium, the share of shear, and the choice that follows."""

import warnings
from math import pi

import numpy as np
import pytest

import skancf as sk
from skancf import InputError

CENTRE = np.array([[0.5], [0.5]])


def plate(h, n, supports, theory="kirchhoff", load=1e-6, **options):
    surface = sk.Rectangle(1.0, 1.0)
    problem = sk.Problem(surface, h, sk.Isotropic(1e6, 0.3, 1.0), [supports], [sk.SurfaceLoad((0, 0, load))])
    return problem.on(sk.meshes.uniform(surface, n, n), theory, **options)


def quiet(solve, system):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", sk.OutOfDepth)
        return solve(system)


def navier_shear(x, y, terms=200):
    """Q1 / (q a) of a simply supported square plate: -D d(laplacian w)/dx with q along z and M = -D w'' in this sign."""
    m = np.arange(1, 2 * terms, 2)
    cx, sy = np.cos(pi * np.outer(x, m)), np.sin(pi * np.outer(y, m))
    factor = 16 / (pi**2 * np.outer(m, m)) * (pi * m)[:, None] / (pi**2 * (m[:, None] ** 2 + m[None, :] ** 2))
    return np.einsum("pm,mn,pn->p", cx, factor, sy)


def test_shear_forces_converge_in_the_middle_of_elements():
    """Order 2 against Navier's series; its 200 terms are good to 1e-5 away from the edges."""
    errors = []
    for n in (8, 16, 32):
        solution = quiet(sk.solve_linear, plate(0.01, n, sk.SimpleSupport("boundary")))
        x, y = solution.system.geometry.parameters(CENTRE)[:, :, 0]
        Q = solution.shear_forces()[:, 0, 0] / 1e-6
        inner = (np.abs(x - 0.5) < 0.25) & (np.abs(y - 0.5) < 0.25)
        errors.append(np.abs(Q - navier_shear(x, y))[inner].max())
    rates = np.log2(np.divide(errors[:-1], errors[1:]))
    assert rates[-1] > 1.8 and errors[-1] < 1e-4, (rates, errors)


@pytest.mark.parametrize("start", [0.0, 0.7])
def test_shear_force_of_a_clamped_ring_follows_from_equilibrium(start):
    """Q_r = -(q r / 2 + c / r) with the reaction; here the inner edge is free, so Q_r = -q (r^2 - a^2) / (2 r)."""
    surface = sk.AnnulusSector(0.5, 1.0, pi / 2, start=start)
    problem = sk.Problem(surface, 0.01, sk.Isotropic(1e6, 0.3, 1.0),
                         [sk.Clamp("outer"), sk.Symmetry("start"), sk.Symmetry("end")],
                         [sk.SurfaceLoad((0, 0, 1e-6))])  # fmt: skip
    solution = sk.solve_linear(problem.on(sk.meshes.uniform(surface, 16, 16), "kirchhoff"))
    r = solution.system.geometry.parameters(CENTRE)[0, :, 0]
    Q = solution.shear_forces()[:, :, 0] / 1e-6
    # Order 2 with 16 elements over half a radius: 1e-3 of the largest, 0.375.
    assert np.abs(Q[:, 0] + (r**2 - 0.25) / (2 * r)).max() < 4e-3
    assert np.abs(Q[:, 1]).max() < 1e-6


def test_share_of_shear_is_what_a_thick_plate_shows():
    """Thick minus thin deflection over thin, Reissner-Mindlin by its closed formula for simple (hard) supports."""
    for h in (0.02, 0.05, 0.1):
        solution = quiet(sk.solve_linear, plate(h, 32, sk.SimpleSupport("boundary", kind="hard")))
        # Its energy: sum of q^2 / (4 S k^2) over Navier's terms, and of q^2 / (4 D k^4).
        m = np.arange(1, 400, 2)
        k2, q2 = pi**2 * (m[:, None] ** 2 + m[None, :] ** 2), (16 / (pi**2 * np.outer(m, m))) ** 2
        D, S = 1e6 * h**3 / 12 / 0.91, 5 / 6 * 1e6 / 2.6 * h
        expected = (q2 / (S * k2)).sum() / (q2 / (D * k2**2)).sum()
        # First order at the edges: 1 % with 32 elements a side.
        assert solution.shear_share == pytest.approx(expected, rel=0.02)


def test_share_does_not_depend_on_the_size_of_a_linear_load():
    shares = [quiet(sk.solve_linear, plate(0.05, 8, sk.Clamp("boundary"), load=q)).shear_share for q in (1e-9, 1.0, 1e6)]
    assert np.ptp(shares) < 1e-6 * shares[0]


@pytest.mark.parametrize(("h", "theory"), [(0.1, "full"), (0.02, "kirchhoff")])
def test_auto_takes_what_is_enough_and_says_why(h, theory):
    system = plate(h, 8, sk.SimpleSupport("boundary", kind="hard"), theory="auto", tolerance=0.01)
    assert system.geometry.theory.name == system.choice.theory == theory
    assert (system.choice.share > 0.01) == (theory == "full")
    assert f"theory '{theory}'" in system.choice.reason and "% asked" in system.choice.reason
    assert plate(h, 8, sk.SimpleSupport("boundary")).choice is None


def test_auto_takes_the_full_theory_where_the_mesh_is_askew():
    mesh = sk.meshes.uniform(sk.Rectangle(1, 1), 4, 4)
    moved = mesh.p.copy()
    moved[:, np.argmin(np.abs(mesh.p - 0.5).sum(axis=0))] += 0.05
    askew = type(mesh)(moved, mesh.t)
    law, load = sk.Isotropic(1e6, 0.3, 1.0), sk.SurfaceLoad((0, 0, 1.0))
    problem = sk.Problem(sk.Plane(), 0.01, law, [sk.Clamp("boundary")], [load])
    system = problem.on(askew, theory="auto")
    assert system.geometry.theory.name == "full" and "no aligned rectangles" in system.choice.reason
    with pytest.raises(InputError, match="first: element"):
        problem.on(askew, theory="kirchhoff")


def test_auto_takes_the_full_theory_where_a_support_does_not_fit_the_thin_one():
    skew = sk.Parallelogram(1.0, 1.0, 1.0)

    def problem(where):
        return sk.Problem(skew, 0.01, sk.Isotropic(1e6, 0.3, 1.0), [sk.Clamp("left"), sk.Symmetry(where)],
                          [sk.SurfaceLoad((0, 0, 1.0))])  # fmt: skip

    mesh = sk.meshes.uniform(skew, 2, 2)
    system = problem("right").on(mesh, theory="auto")
    assert system.choice.theory == system.geometry.theory.name == "full" and np.isnan(system.choice.share)
    assert "right angles" in system.choice.reason
    with pytest.raises(InputError, match="no boundary 'rihgt'"):
        problem("rihgt").on(mesh, theory="auto")


def test_auto_needs_something_to_judge_by():
    surface = sk.Rectangle(1, 1)
    mesh, law = sk.meshes.uniform(surface, 2, 2), sk.Isotropic(1e6, 0.3, 1.0)
    with pytest.raises(InputError, match="name the theory"):
        sk.Problem(surface, 0.01, law, loads=[sk.Gravity()]).on(mesh, "auto")
    with pytest.raises(InputError, match="nothing strains the surface"):
        sk.Problem(surface, 0.01, law, [sk.Clamp("left")], [sk.EdgeLoad("left", (0, 0, 1.0))]).on(mesh, "auto")
    with pytest.raises(InputError, match="tolerance = 0"):
        sk.Problem(surface, 0.01, law, [sk.Clamp("left")]).on(mesh, "auto", tolerance=0)


def test_a_thin_answer_of_a_thick_plate_comes_with_a_warning():
    with pytest.warns(sk.OutOfDepth, match="transverse shear"):
        sk.solve_linear(plate(0.1, 8, sk.SimpleSupport("boundary")))
    with pytest.warns(sk.OutOfDepth, match="theory='auto'"):
        sk.solve(plate(0.2, 8, sk.Clamp("boundary")))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sk.solve_linear(plate(0.01, 8, sk.SimpleSupport("boundary")))
        sk.solve_linear(plate(0.1, 8, sk.SimpleSupport("boundary"), theory="full"))


def test_energy_and_work_of_a_small_deflection():
    """Clapeyron: the strain energy is the work."""
    solution = sk.solve_linear(plate(0.01, 4, sk.Clamp("boundary")))
    assert solution.strain_energy == pytest.approx(solution.work, rel=1e-9)


def test_share_of_an_answer_that_is_no_number_is_none():
    system = plate(0.01, 2, sk.Clamp("boundary"))
    assert np.isnan(sk.Solution(system, np.full(system.n_dofs, np.nan)).shear_share)
    assert sk.Solution(system, system.undeformed).shear_share == 0
