"""Thin plates in small deflection against series, Ritz values and closed formulas."""

from functools import cache
from math import pi, radians

import numpy as np
import pytest
from reference import axisymmetric, navier, thin_ritz, two_membranes

import skancf as sk

NU, THICKNESS = 0.3, 0.01
RIGIDITY = THICKNESS**3 / 12 / (1 - NU**2)
MATERIAL = sk.Isotropic(1.0, NU, 1.0)
# Deflections of 1e-6 of the side and less: what is quadratic in them, also in the strains, is below rounding.
LOAD = 1e-6
PRESSURE = sk.SurfaceLoad((0, 0, LOAD * RIGIDITY))
FORCE = sk.PointForce((0.5, 0.5), (0, 0, LOAD * RIGIDITY))
SUPPORTS = {"simple": sk.SimpleSupport("boundary"), "clamped": sk.Clamp("boundary"), "corners": sk.Pin("corners")}
MESHES = (4, 8, 16)


@cache
def square(edges: str, n: int, load=PRESSURE, b: float = 1.0) -> sk.Solution:
    return solved(sk.Rectangle(1.0, b), SUPPORTS[edges], load, n, n)


def solved(surface, support, load, nx: int, ny: int) -> sk.Solution:
    problem = sk.Problem(surface, THICKNESS, MATERIAL, [support], [load])
    return sk.solve_linear(problem.on(sk.meshes.uniform(surface, nx, ny), theory="kirchhoff"))


def deflection(solution: sk.Solution, at=(0.5, 0.5)) -> float:
    """w D / (q a^4) or w D / (P a^2)."""
    return solution.displacement(at)[2] / LOAD


def half_work(solution: sk.Solution) -> float:
    """Of a load q = D = a = 1; equal to the strain energy."""
    change = solution.q - solution.system.undeformed
    return 0.5 * float(change @ solution.system.external_force(solution.q)) / (LOAD**2 * RIGIDITY)


def observed_rates(errors) -> np.ndarray:
    return np.log2(np.array(errors[:-1]) / errors[1:])


# --- the references among themselves ---------------------------------------------------------------------------------


def test_references_agree_with_the_literature_and_each_other():
    # Timoshenko and Woinowsky-Krieger (1959), tables 8 and 35: three digits.
    energy, moment = navier.thin_uniform()
    assert np.isclose(moment, 0.0479, atol=5e-5)
    middle, edge = np.array([0.5]), np.array([0.0])
    simple, clamped, corners = (thin_ritz.uniform(edges, 20) for edges in ("simple", "clamped", "corners"))
    assert np.isclose(clamped.deflection(middle, middle)[0], 0.00126, atol=6e-6)
    # Series and Ritz: the corners of a simply supported plate have w ~ r^4 only, degree 21 leaves 1e-8.
    assert np.isclose(simple.deflection(middle, middle)[0], navier.kirchhoff_uniform(), rtol=1e-7)
    assert np.isclose(navier.thin_field(middle, middle)[0, 0], navier.kirchhoff_uniform(), rtol=1e-6)
    assert np.isclose(simple.energy, energy, rtol=1e-7)
    # Converged Ritz values (degree 18 and higher), eight digits.
    assert np.isclose(clamped.deflection(middle, middle)[0], 0.001265319, atol=1e-9)
    assert np.isclose(corners.deflection(middle, middle)[0], 0.02550650, atol=1e-8)
    assert np.isclose(corners.deflection(middle, edge)[0], 0.01774741, atol=2e-8)
    assert np.isclose(corners.energy, 0.009210284, atol=1e-9)
    # Two membranes: the square, and the acute rhombus of Morley, Skew Plates and Structures (1963): 0.000408.
    assert np.isclose(two_membranes.rhombic_centre(pi / 2), navier.kirchhoff_uniform(), rtol=1e-7)
    assert np.isclose(two_membranes.rhombic_centre(pi / 6), 0.000408, atol=5e-7)
    law = np.diag([1.0, 2.0, 0.4, 4.0, 1.0, 0.6])
    law[3, 4] = law[4, 3] = 0.5
    assert np.isclose(navier.thin_laminate(law), navier.thin_orthotropic(law[3:, 3:]), rtol=1e-12)
    # A ring with a very small hole is nearly a disc: the hole of radius e changes w by e^2 log e.
    tiny = axisymmetric.ring((1e-4, 1.0), ("free", "clamped"))
    assert np.isclose(tiny(1e-4), axisymmetric.disc_centre("clamped", "uniform"), rtol=1e-6)


# --- rates -----------------------------------------------------------------------------------------------------------


def exact_field(edges: str, x: np.ndarray) -> np.ndarray:
    """On the grid x by x."""
    if edges == "simple":
        return navier.thin_field(x, x)
    s, t = (v.ravel() for v in np.meshgrid(x, x, indexing="ij"))
    return thin_ritz.uniform(edges, 24).deflection(s, t).reshape(len(x), len(x))


def relative_l2_error(edges: str, n: int) -> float:
    """Against the exact deflection at 4 x 4 Gauss points of each element."""
    solution = square(edges, n)
    geometry = solution.system.geometry
    points, weights = geometry.theory.quadrature
    local = geometry.local((solution.q - solution.system.undeformed).reshape(-1, 4, 3))
    w = np.einsum("ap,ea->ep", geometry.theory.position_table(points)[0], local[:, :, 2]) / LOAD
    places = geometry.parameters(points)
    x = np.unique(np.round(places[0], 12))
    grid = exact_field(edges, x)
    i, j = (np.searchsorted(x, places[k] - 1e-9) for k in (0, 1))
    exact = grid[i, j]
    return float(np.sqrt(((w - exact) ** 2 @ weights).sum() / (exact**2 @ weights).sum()))


def exact_energy(edges: str) -> float:
    """Ritz's values of degree 24 are good for 1e-10 and, with free corners, 1e-8 of the energy."""
    return navier.thin_uniform()[0] if edges == "simple" else thin_ritz.uniform(edges, 24).energy


@pytest.mark.parametrize("edges", SUPPORTS)
def test_orders_of_deflection_and_energy(edges):
    l2 = [relative_l2_error(edges, n) for n in MESHES]
    # Of a minimum of the potential, the energy norm of the error squared is what the energy lacks.
    energy = [np.sqrt(1 - half_work(square(edges, n)) / exact_energy(edges)) for n in MESHES]
    # Bicubic: 4 and 2; free corners have w ~ r^2.76 and allow 3.5 and 1.76 in the end. Measured on 8 -> 16 elements:
    # 3.94, 3.92, 3.81 and 1.97, 1.97, 1.91, growing where the solution is smooth.
    order_l2, order_energy = (3.5, 1.75) if edges == "corners" else (3.9, 1.95)
    assert observed_rates(l2)[-1] > order_l2 and observed_rates(energy)[-1] > order_energy
    # Measured 6e-6, 6e-5, 5e-6 of the deflection and 0.0021, 0.0078, 0.0021 of the energy norm.
    assert l2[-1] < (6e-5 if edges == "clamped" else 7e-6)
    assert energy[-1] < (8e-3 if edges == "clamped" else 2.2e-3)


def test_the_energy_norm_sees_another_plate():
    """What the energy lacks, against a plate of another Poisson's ratio, does not fall with the mesh."""
    wrong = thin_ritz.uniform("corners", 16, poisson=0.28).energy
    errors = [abs(1 - half_work(square("corners", n)) / wrong) for n in MESHES[1:]]
    assert min(errors) > 1e-3 and abs(observed_rates(errors)[0]) < 0.1


# --- deflections and moments -----------------------------------------------------------------------------------------


def test_uniform_load_on_eight_by_eight():
    # Measured 4e-5, 8e-5 and 2e-5.
    for edges, exact in (("simple", 0.00406235266), ("clamped", 0.001265319), ("corners", 0.0255065)):
        assert np.isclose(deflection(square(edges, 8)), exact, rtol=1e-4)
    assert np.isclose(deflection(square("corners", 8), (0.5, 0.0)), 0.01774741, rtol=3e-5)
    assert abs(deflection(square("simple", 8)) / navier.mindlin_uniform(20, NU) - 1) > 0.01, "shear would be seen"


TABLE_8 = {1.2: 0.00564, 1.4: 0.00705, 1.5: 0.00772, 1.6: 0.00830, 1.8: 0.00931, 2.0: 0.01013, 3.0: 0.01223}


@pytest.mark.parametrize("b", TABLE_8)
def test_simply_supported_rectangles(b):
    w, series = deflection(square("simple", 8, b=b), (0.5, b / 2)), navier.kirchhoff_uniform(b=b)
    # Timoshenko and Woinowsky-Krieger (1959), table 8, computed by hand: the third digit is off by up to four.
    assert abs(series - TABLE_8[b]) < 4e-5
    assert np.isclose(w, series, rtol=1e-4)


FORCES = {"simple": 0.011600840, "clamped": 0.0056120, "corners": 0.03914}


@pytest.mark.parametrize("edges", FORCES)
def test_centre_force(edges):
    """Series, and Ritz values for "clamped" and "corners" (four to five digits)."""
    errors = [FORCES[edges] - deflection(square(edges, n, FORCE)) for n in MESHES]
    # w ~ r^2 log r: order 2 in the deflection under the force. Measured 2.0; last errors 7e-4, 1.4e-3, 2e-4.
    assert min(errors) > 0 and errors[-1] < 1.5e-3 * FORCES[edges]
    if edges == "corners":
        # At a distance from it the load hurts no more than by its work: 0.02291305 by Ritz.
        assert np.isclose(deflection(square(edges, 16, FORCE), (0.5, 0.0)), 0.02291305, rtol=1e-6)
    else:
        assert (np.abs(observed_rates(errors) - 2) < 0.1).all()


MOMENTS = {
    ("simple", (0.5, 0.5)): 0.047886, ("clamped", (0.5, 0.5)): 0.022905, ("clamped", (0.5, 0.0)): -0.051334,
    ("corners", (0.5, 0.5)): 0.111711,
}  # fmt: skip


def moments_at(solution: sk.Solution, at) -> np.ndarray:
    """M11, M22, M12 over (q a^2) at a node."""
    return solution.nodal_section_forces()[solution.system.geometry.node_at(at), 3:] / (LOAD * RIGIDITY)


@pytest.mark.parametrize("edges, at", MOMENTS)
def test_moments_at_nodes(edges, at):
    """M22 by the series, and by Ritz of degree 20 for clamped edges and free corners."""
    exact = MOMENTS[edges, at]
    errors = [abs(moments_at(square(edges, n), at)[1] - exact) for n in (8, 16, 32)]
    # Second derivatives of cubics: order 2; at the edge, from one side only, measured 1.86 and 1.94.
    assert observed_rates(errors)[-1] > 1.9
    # Measured on 32 x 32: 3e-4, 1e-3, 3.4e-3, 1.1e-3.
    assert errors[-1] < (4e-3 if at[1] == 0 else 1.3e-3) * abs(exact)
    along, _, twist = moments_at(square(edges, 16), at)
    assert abs(twist) < 1e-9 and np.isclose(along, moments_at(square(edges, 16), at)[1] * (NU if at[1] == 0 else 1))


def test_stress_through_the_thickness():
    solution = square("clamped", 16)
    force, t = solution.nodal_section_forces(), THICKNESS
    top, bottom, middle = (solution.nodal_stresses(z) for z in (t / 2, -t / 2, 0.0))
    bending = np.zeros_like(top)
    bending[:, [0, 1, 5]] = 6 * force[:, 3:] / t**2
    scale = np.abs(bending).max()
    # Strains of a state whose slopes are 1e-6 have a rounding of 1e-16 / 1e-8; the quadratic membrane part is less.
    assert np.abs(top - bending).max() < 1e-6 * scale and np.abs(bottom + bending).max() < 1e-6 * scale
    assert np.abs(middle).max() < 1e-6 * scale
    at = solution.system.geometry.node_at((0.5, 0.0))
    assert np.isclose(top[at, 1], -6 * 0.051334 * LOAD * RIGIDITY / t**2, rtol=0.015)  # the moment's error is 1.3 %


@pytest.mark.parametrize("edges", SUPPORTS)
@pytest.mark.parametrize("load", [PRESSURE, FORCE], ids=["pressure", "force"])
def test_equilibrium_and_energy(edges, load):
    solution = square(edges, 8, load)
    reaction = solution.reactions() / (LOAD * RIGIDITY)
    # Rounding, amplified by stiffnesses over the load: (a / h)^2 times that of bending.
    assert np.allclose(reaction, (0, 0, -1), atol=1e-9)
    assert np.isclose(solution.strain_energy / (LOAD**2 * RIGIDITY), half_work(solution), rtol=1e-8)
    if edges == "corners":
        assert np.allclose(solution.reactions((1.0, 0.0)) / (LOAD * RIGIDITY), (0, 0, -0.25), atol=1e-9)


# --- skew plates -----------------------------------------------------------------------------------------------------


@cache
def rhombic(edges: str, degrees: float, n: int) -> float:
    surface = sk.Parallelogram(1.0, 1.0, radians(degrees))
    return deflection(solved(surface, SUPPORTS[edges], PRESSURE, n, n))


@pytest.mark.parametrize("degrees, allowed", [(60, 1e-5), (30, 5e-4)])
def test_clamped_rhombic_plate(degrees, allowed):
    """Ritz in oblique coordinates, converged to five digits (30 degrees) and more. Measured 4e-6 and 4e-4."""
    middle = np.array([0.5])
    ritz, coarser = (thin_ritz.uniform("clamped", n, angle=radians(degrees)).deflection(middle, middle)[0] for n in (24, 18))
    assert np.isclose(ritz, coarser, rtol=5e-5)
    assert np.isclose(rhombic("clamped", degrees, 32), ritz, rtol=allowed)


@pytest.mark.parametrize("degrees", [60, 30])
def test_simply_supported_rhombic_plate(degrees):
    r"""At an obtuse corner :math:`\omega` of simply supported edges w ~ r^s, :math:`s = \pi / \omega`: order 2 (s - 1)."""
    w = np.array([rhombic("simple", degrees, n) for n in (16, 32, 64)])
    order = 2 * (180 / (180 - degrees) - 1)
    # Measured 0.99 for 1 (60 degrees) and 0.44 for 0.4.
    assert np.abs(observed_rates(np.diff(w)) - order).max() < 0.06
    limit, exact = w[-1] + (w[-1] - w[-2]) / (2**order - 1), two_membranes.rhombic_centre(radians(degrees))
    # Measured 1e-6 and 5e-3: at 30 degrees the meshes lack 7 %, extrapolated with an order that is not yet the last one.
    assert np.isclose(limit, exact, rtol=1e-5 if degrees == 60 else 8e-3)
    assert w[-1] < exact * (0.999 if degrees == 60 else 0.95)


# --- rings and discs -------------------------------------------------------------------------------------------------


@cache
def ring(edges: tuple[str, str], n: int, inner: float = 0.4) -> sk.Solution:
    """n elements along the radius, 2 n around; supported as asked at the inner and the outer edge."""
    surface = sk.AnnulusSector(inner, 1.0, 2 * pi, closed=True)
    kinds = {"clamped": sk.Clamp, "simple": sk.SimpleSupport}
    supports = [kinds[edge](side) for side, edge in zip(("inner", "outer"), edges, strict=True) if edge in kinds]
    problem = sk.Problem(surface, THICKNESS, MATERIAL, supports, [PRESSURE])
    return sk.solve_linear(problem.on(sk.meshes.uniform(surface, n, 2 * n), theory="kirchhoff"))


@pytest.mark.parametrize("edges", [("clamped", "free"), ("simple", "simple"), ("clamped", "clamped"), ("free", "simple")])
def test_ring(edges):
    exact = axisymmetric.ring((0.4, 1.0), edges)
    places = [(r, angle) for r in (0.5, 0.7, 0.95) for angle in (0.1, 3.0)]
    scale = max(abs(exact(r)) for r in (0.7, 1.0))
    errors = [max(abs(deflection(ring(edges, n), p) - exact(p[0])) for p in places) / scale for n in (8, 16)]
    # Measured on 16 x 32: 0.9e-5 to 1.8e-5 of the deflection, 3.5e-5 clamped at both edges; order 4, in the geometry too.
    assert errors[1] < (4e-5 if edges == ("clamped", "clamped") else 2e-5) and observed_rates(errors)[0] > 3.5
    other = axisymmetric.ring((0.4, 1.0), edges, poisson=0.0)
    assert edges == ("clamped", "clamped") or abs(other(0.7) / exact(0.7) - 1) > 0.01, "nu matters"


def test_ring_carries_its_load():
    solution = ring(("simple", "simple"), 16)
    applied = solution.system.external_force(solution.q).reshape(-1, 4, 3)[:, 0].sum(axis=0)
    assert np.allclose(solution.reactions(), -applied, atol=1e-9 * applied[2])
    # Cubics through 32 points of a circle miss its area by 4e-6.
    assert np.isclose(applied[2], LOAD * RIGIDITY * pi * (1 - 0.4**2), rtol=5e-6)


@pytest.mark.parametrize("load", ["uniform", "force"])
@pytest.mark.parametrize("edge", ["clamped", "simple"])
def test_disc_with_a_pole(edge, load):
    surface = sk.AnnulusSector(0.0, 1.0, 2 * pi, closed=True)
    support = sk.Clamp("outer") if edge == "clamped" else sk.SimpleSupport("outer")
    acting = PRESSURE if load == "uniform" else sk.PointForce((0.0, 0.0), FORCE.force)
    exact = axisymmetric.disc_centre(edge, load, NU)
    found = [deflection(solved(surface, support, acting, n, 2 * n), (0.0, 0.0)) for n in (8, 16)]
    errors = np.abs(np.array(found) / exact - 1)
    # Order 4 under the pressure, 2 under the force; measured 7e-6 and 9e-6, 4.4e-4 and 1.8e-4.
    assert observed_rates(errors)[0] > (3.5 if load == "uniform" else 1.95)
    assert errors[-1] < (1e-5 if load == "uniform" else 5e-4)


# --- laminates -------------------------------------------------------------------------------------------------------

PLY = sk.Orthotropic(young=(25.0, 1.0, 1.0), poisson=(0.25, 0.25, 0.25), shear=(0.5, 0.5, 0.2), density=1.0)


def cross_ply(angles: tuple[float, ...], n: int) -> tuple[float, np.ndarray]:
    """w_c under a unit load, and A, B, D; edges held, free to move along their normal (SS-1)."""
    laminate = sk.Laminate([sk.Layer(PLY, THICKNESS / len(angles), radians(angle)) for angle in angles])
    surface, load = sk.Rectangle(1.0, 1.0), 1e-12
    supports = [sk.Roller("boundary"), sk.Roller(["left", "right"], (0, 1, 0)), sk.Roller(["bottom", "top"], (1, 0, 0))]
    problem = sk.Problem(surface=surface, material=laminate, supports=supports, loads=[sk.SurfaceLoad((0, 0, load))])
    solution = sk.solve_linear(problem.on(sk.meshes.uniform(surface, n, n), theory="kirchhoff"))
    return solution.displacement((0.5, 0.5))[2] / load, classical(angles)


def classical(angles: tuple[float, ...]) -> np.ndarray:
    """A, B and D of plies at 0 or 90 degrees from engineering constants (Jones 1999, section 4.2)."""
    scale = 1 - 0.25**2 / 25
    Q = np.array([[25, 0.25, 0], [0.25, 1, 0], [0, 0, 0.5 * scale]]) / scale
    z = np.linspace(-THICKNESS / 2, THICKNESS / 2, len(angles) + 1)
    plies = [Q if angle == 0 else Q[[1, 0, 2]][:, [1, 0, 2]] for angle in angles]
    A, B, D = (sum(ply * (top**k - low**k) / k for ply, low, top in zip(plies, z, z[1:], strict=False)) for k in (1, 2, 3))
    return np.block([[A, B], [B, D]])


@pytest.mark.parametrize("angles", [(0, 90, 90, 0), (0, 90), (0, 90, 0, 90)], ids=str)
def test_cross_ply_laminates(angles):
    """Specially orthotropic, and with B of opposite sign along and across the fibres."""
    errors = []
    for n in (8, 16):
        w, abd = cross_ply(angles, n)
        errors.append(w / navier.thin_laminate(abd) - 1)
    # Measured 3e-5 to 4e-5 and 2e-6: order 4.
    assert errors[-1] < 3e-6 and observed_rates(errors)[0] > 3.9
    coupled = navier.thin_laminate(abd) / navier.thin_orthotropic(abd[3:, 3:])
    if angles == (0, 90, 90, 0):
        assert np.isclose(coupled, 1, rtol=1e-9)
    else:
        assert coupled > 1.15, "coupling makes the plate 17 to 146 % softer"
