"""Quantities of interest: their gradients by differences, their values by what is known, and which have no limit."""

from functools import cache
from math import pi

import numpy as np
import pytest
import skfem
from reference import elastica, navier

import skancf as sk
from skancf.adaptive import Displacement, Reaction, Rotation, SectionForce, StrainEnergy, drift, no_limit
from skancf.adaptive.quantities.section_force import COMPONENTS
from skancf.errors import InputError

MATERIAL = sk.Isotropic(1e6, 0.3, 1.0, expansion=1e-5)
THEORIES = ("full", "kirchhoff")
theories = pytest.mark.parametrize("theory", THEORIES)

SURFACES = {
    "flat": sk.Rectangle(1.0, 1.2),
    "curved": sk.CylinderSector(1.0, 1.0, 1.2),
    "closed": sk.CylinderSector(1.0, 1.0, 2 * pi, closed=True),
    "poled": sk.SphereSector(1.0, (0.0, 0.8), 2 * pi, closed=True),
}


def share(surface, x: float, y: float) -> tuple[float, float]:
    """A point at parts of the two parameters."""
    (x0, x1), (y0, y1) = surface.bounds
    return x0 + x * (x1 - x0), y0 + y * (y1 - y0)


def held(surface):
    end = surface.bounds[0][1]
    return lambda x, y: abs(x - end) < 1e-9


def loaded(surface) -> sk.Problem:
    """All that has a part in a gradient: springs, a foundation, temperature, and pressure with open edges."""
    inside = share(surface, 2 / 3, 0.5)
    supports = [sk.Clamp(held(surface)), sk.Spring(inside, (3.0, 2.0, 5.0)), sk.Spring(held(surface), (1e3, 0.0, 2e3)),
                sk.Foundation(40.0)]  # fmt: skip
    heat = sk.Temperature(lambda x, y: 20.0 * (1 + x) + 0 * y, lambda x, y: 300.0 * (1 + np.sin(y)) + 0 * x)
    loads = [sk.FollowerPressure(30.0), heat, sk.PointForce(inside, (1.0, 2.0, 3.0))]
    return sk.Problem(surface, 0.05, MATERIAL, supports, loads)


@cache
def state(name: str, theory: str, linear: bool) -> sk.Solution:
    """Any change of shape will do: no equilibrium is asked for."""
    surface = SURFACES[name]
    system = loaded(surface).on(sk.meshes.uniform(surface, 3, 6 if name in ("closed", "poled") else 4), theory=theory)
    q = system.undeformed + bump(system, np.random.default_rng(7), 0.03)
    return sk.Solution(system, q, load_factor=0.7, linear=linear)


def bump(system, rng, size: float) -> np.ndarray:
    """A change of all nodal coordinates, of a part of an element in position."""
    scale = np.array([0.3, 1.0, 1.0, 1.0]) * size
    return (scale[:, None] * rng.uniform(-1, 1, (system.geometry.n_nodes, 4, 3))).ravel()


def quantities(surface) -> dict:
    at, (x, y) = share(surface, 0.4, 0.3), surface.bounds
    some = (x[0] - 0.01, sum(x) / 2), (y[0] + 0.1, y[0] + 0.7 * (y[1] - y[0]))
    return {
        "displacement": Displacement(at, (1.0, -2.0, 0.5)),
        "rotation": Rotation(at, (0.3, 1.0, 0.2)),
        "normal force": SectionForce("N11", at=at),
        "shear force": SectionForce("N12", at=share(surface, 1 / 3, 0.5)),
        "moment": SectionForce("M22", at=at),
        "twist": SectionForce("M12", at=at),
        "mean normal force": SectionForce("N22", within=some),
        "mean moment": SectionForce("M11", within=some),
        "mean of all": SectionForce("M12"),
        "reaction": Reaction(held(surface), (0.2, 0.5, 1.0)),
        "reaction of a spring": Reaction(share(surface, 2 / 3, 0.5), (0.2, 0.5, 1.0)),
        "all reactions": Reaction(None, (0.0, 1.0, 0.0)),
        "energy": StrainEnergy(),
    }


def slope(quantity, solution, along, step=1e-3) -> float:
    """Central differences of fourth order."""

    def at(s):
        return quantity.value(sk.Solution(solution.system, solution.q + s * step * along, load_factor=solution.load_factor,
                                          linear=solution.linear))  # fmt: skip

    return (8 * (at(1) - at(-1)) - (at(2) - at(-2))) / (12 * step)


@pytest.mark.parametrize("what", quantities(SURFACES["flat"]))
@pytest.mark.parametrize("linear", [False, True], ids=["deformed", "linear"])
@pytest.mark.parametrize("name", SURFACES)
@theories
def test_gradient_is_the_derivative(theory, name, linear, what, rng):
    solution, quantity = state(name, theory, linear), quantities(SURFACES[name])[what]
    gradient = quantity.gradient(solution)
    assert gradient.shape == (solution.system.n_dofs,) and np.any(gradient)
    along = bump(solution.system, rng, 0.1)
    # The differences are good for 1e-9; against the size of the parts, which may cancel.
    size, measured = np.linalg.norm(gradient * along), slope(quantity, solution, along)
    assert abs(gradient @ along - measured) < 1e-7 * size
    assert abs(1.001 * gradient @ along - measured) > 1e-7 * size, "a gradient that is wrong by a thousandth is seen"


@pytest.mark.parametrize("linear", [False, True], ids=["deformed", "linear"])
@theories
def test_gradient_at_a_pole(theory, linear, rng):
    solution, pole = state("poled", theory, linear), (0.0, 1.0)
    along = bump(solution.system, rng, 0.1)
    forces = [SectionForce(name, at=pole) for name in ("N12", "M11")]
    for quantity in (Displacement(pole), Rotation(pole, (1, 2, 0)), *forces):
        gradient = quantity.gradient(solution)
        assert abs(gradient @ along - slope(quantity, solution, along)) < 1e-7 * np.linalg.norm(gradient * along)


@theories
def test_gradient_of_section_forces_of_a_laminate(theory, rng):
    """Unsymmetric, oblique and off the reference surface: all strains make all forces."""
    ply = sk.Orthotropic((2e6, 1e6, 1e6), (0.2, 0.2, 0.2), (4e5, 5e5, 6e5), 1.0)
    laminate = sk.Laminate([sk.Layer(ply, 0.02, angle=0.3), sk.Layer(ply, 0.03, angle=1.1)], offset=0.01)
    surface = SURFACES["curved"]
    problem = sk.Problem(surface, material=laminate, supports=[sk.Clamp(held(surface))])
    system = problem.on(sk.meshes.uniform(surface, 2, 2), theory=theory)
    solution = sk.Solution(system, system.undeformed + bump(system, rng, 0.03))
    along = bump(system, rng, 0.1)
    for name in COMPONENTS:
        for quantity in (SectionForce(name, at=share(surface, 0.4, 0.3)), SectionForce(name)):
            gradient = quantity.gradient(solution)
            assert abs(gradient @ along - slope(quantity, solution, along)) < 1e-7 * np.linalg.norm(gradient * along)


def test_a_gradient_without_skew_stiffness_or_heat_would_be_seen(rng):
    """Parts that are easily forgotten are there: without them these gradients would pass as well."""
    solution = state("curved", "full", False)
    system, along = solution.system, bump(solution.system, rng, 0.1)
    reaction, energy = (quantities(SURFACES["curved"])[k] for k in ("reaction", "energy"))
    held_part = system.constraints.fixed_part(reaction._motion(system))
    skew = system.skew(solution.q, sk.Case(0.7)) @ held_part
    assert abs(skew @ along) > 1e-5 * np.linalg.norm(reaction.gradient(solution) * along)
    heat = 0.7 * system.shell.initial_stress_force(solution.q, sk.Case())
    assert abs(heat @ along) > 1e-5 * np.linalg.norm(energy.gradient(solution) * along)


# --- values ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("linear", [False, True], ids=["deformed", "linear"])
@theories
def test_values_are_those_of_the_solution(theory, linear):
    solution = state("curved", theory, linear)
    surface, geometry = SURFACES["curved"], solution.system.geometry
    at, direction = share(surface, 0.4, 0.3), np.array([2.0, 1.0, -1.0])
    unit = direction / np.linalg.norm(direction)
    assert np.isclose(Displacement(at, direction).value(solution), solution.displacement(at) @ unit, rtol=1e-12)
    assert np.isclose(Reaction(held(surface), direction).value(solution), solution.reactions(held(surface)) @ unit)
    assert StrainEnergy().value(solution) == solution.strain_energy
    element, local = geometry.locate(at)
    points, areas = geometry.theory.quadrature[0], solution.system.assembly.areas
    there, everywhere = solution.recovered_section_forces(local[:, None])[element, :, 0], solution.section_forces(points)
    means = np.einsum("ekp,ep->k", everywhere, areas) / areas.sum()
    for k, name in enumerate(COMPONENTS):
        # Solution takes differences for a linear answer.
        assert np.isclose(SectionForce(name, at=at).value(solution), there[k], rtol=1e-6)
        assert np.isclose(SectionForce(name).value(solution), means[k], rtol=1e-6)


NU, THIN = 0.3, 0.01
RIGIDITY = THIN**3 / 12 / (1 - NU**2)
PLATE = sk.Rectangle(1.0, 1.0)
MIDDLE = (0.5, 0.5)
HARD, UNIFORM = (sk.SimpleSupport("boundary", "hard"),), sk.SurfaceLoad((0, 0, 1e-6 * RIGIDITY))


@cache
def plate(theory: str, n: int, thickness: float = THIN, supports=HARD, load=UNIFORM) -> sk.Solution:
    problem = sk.Problem(PLATE, thickness, sk.Isotropic(1.0, NU, 1.0), list(supports), [load])
    return sk.solve_linear(problem.on(sk.meshes.uniform(PLATE, n, n), theory=theory))


@theories
def test_simply_supported_plate_against_series(theory):
    solution, load = plate(theory, 16), 1e-6 * RIGIDITY
    energy, moment = navier.thin_uniform()
    assert np.isclose(moment, 0.047886, atol=1e-6)
    # Measured 3e-6, 1.4e-3 and 4e-6; in theory `full` 5e-3 each.
    deflection, of_moment, of_energy = (1e-5, 2e-3, 1e-5) if theory == "kirchhoff" else (6e-3, 6e-3, 6e-3)
    assert np.isclose(Displacement(MIDDLE).value(solution) / 1e-6, navier.kirchhoff_uniform(), rtol=deflection)
    for name in ("M11", "M22"):
        assert np.isclose(SectionForce(name, at=MIDDLE).value(solution) / load, moment, rtol=of_moment)
    assert np.isclose(StrainEnergy().value(solution) / (1e-6 * load), energy, rtol=of_energy)


@pytest.mark.filterwarnings("ignore::skancf.OutOfDepth")
@theories
def test_reactions_carry_the_load(theory):
    load = 1e-6 * RIGIDITY
    assert np.isclose(Reaction().value(plate(theory, 16)), -load, rtol=1e-9)
    on_corners = plate(theory, 8, supports=(sk.Pin("corners"),))
    assert np.isclose(Reaction("corners").value(on_corners), -load, rtol=1e-9)
    assert np.isclose(Reaction((1.0, 0.0), (0, 0, -3)).value(on_corners), load / 4, rtol=1e-9)


def test_mean_moment_against_series():
    """Of half the sum M11 + M22 = -(1 + nu) D laplacian w over a quarter in the middle, from the series on a fine grid."""
    solution = plate("kirchhoff", 16)
    s = (np.arange(80) + 0.5) / 160 + 0.25
    m, n = np.meshgrid(np.arange(1, 80, 2), np.arange(1, 80, 2), indexing="ij")
    terms = 16 / pi**4 / (m * n * (m**2 + n**2))  # of -laplacian w, for q = D = a = 1
    exact = np.einsum("mn,mi,nj->", terms, *(np.sin(pi * np.arange(1, 80, 2)[:, None] * s),) * 2) / len(s) ** 2
    within = ((0.25, 0.75), (0.25, 0.75))
    means = [SectionForce(name, within=within).value(solution) / (1e-6 * RIGIDITY) for name in ("M11", "M22")]
    assert np.allclose(means, (1 + NU) / 2 * exact, rtol=1e-4)
    assert abs(SectionForce("M11").value(solution) / (1e-6 * RIGIDITY) / means[0] - 1) > 0.1, "other regions, other means"


@theories
def test_rotation_of_a_cantilever(theory):
    surface, t = sk.Rectangle(1.0, 0.1), 0.01
    stiffness = 1e6 * 0.1 * t**3 / 12
    problem = sk.Problem(surface, t, sk.Isotropic(1e6, 0.0, 1.0), [sk.Clamp("left")],
                         [sk.EdgeLoad("right", (0, 0, 3 * stiffness / 0.1))])  # fmt: skip
    system = problem.on(sk.meshes.uniform(surface, 10, 1), theory=theory)
    tilt, back = Rotation((1.0, 0.05), (-2.0, 0.0, 7.0)), Rotation((1.0, 0.05), (1.0, 0.0, 0.0))
    bent, small = sk.solve(system).solution, sk.solve_linear(system)
    # Measured 3.6e-3 and 2e-6 on 10 elements.
    assert np.isclose(tilt.value(bent), elastica.tip_angle(3.0), rtol=5e-3 if theory == "full" else 5e-6)
    assert np.isclose(back.value(bent), -tilt.value(bent), rtol=1e-12)
    assert np.isclose(tilt.value(bent), bent.rotation((1.0, 0.05)), rtol=1e-9)
    assert np.isclose(tilt.value(small), 1.5, rtol=1e-8), "of first order: P L^2 / 2 E I"


@theories
def test_tube_under_pressure_across_its_seam(theory):
    tube = SURFACES["closed"]
    ends = sk.Prescribed(lambda x, y: (abs(x) < 1e-9) | (abs(x - 1) < 1e-9), (0.0, None, None))
    problem = sk.Problem(tube, 0.01, sk.Isotropic(1e6, 0.0, 1.0), [ends], [sk.FollowerPressure(1.0)])
    solution = sk.Solution(system := problem.on(sk.meshes.uniform(tube, 2, 16), theory=theory), system.undeformed)
    radial = solution.q.reshape(-1, 4, 3) * 1.01
    solution = sk.Solution(system, radial.ravel())
    names = {name: SectionForce(name, within=((0.0, 1.0), (-0.3, 0.3))).value(solution) for name in ("N11", "N22")}
    around = {name: SectionForce(name, within=((0.0, 1.0), (2 * pi - 0.3, 2 * pi + 0.3))).value(solution) for name in names}
    assert names == pytest.approx(around, rel=1e-12)
    # Stretched alike in all directions by E = (1.01^2 - 1) / 2, nu = 0.
    assert np.allclose(list(names.values()), 1e6 * 0.01 * (1.01**2 - 1) / 2, rtol=1e-3)


def test_a_moving_state_has_no_reaction():
    solution = state("flat", "full", False)
    moving = sk.Solution(solution.system, solution.q, velocity=np.ones_like(solution.q))
    with pytest.raises(InputError, match="inertia"):
        Reaction().value(moving)


BAD = {
    "this is no direction": lambda: Displacement(MIDDLE, (0, 0, 0)),
    "at = .*give 2 numbers": lambda: Displacement((1.0, 2.0, 3.0)),
    "towards .*no direction": lambda: Rotation(MIDDLE, (0, 0, 0)),
    "component = 'M13': choose one of": lambda: SectionForce("M13"),
    "a point or a rectangle, not both": lambda: SectionForce("M11", at=MIDDLE, within=((0, 1), (0, 1))),
    "x0 < x1 and y0 < y1": lambda: SectionForce("M11", within=((0, 1), (1, 0))),
    "within.*not finite": lambda: SectionForce("M11", within=((0, np.nan), (0, 1))),
    "direction .*no direction": lambda: Reaction("left", (0, 0, 0)),
    "lies outside the surface": lambda: Displacement((2.0, 0.0)).value(plate("full", 4)),
    "towards = .0, 0, 2. is parallel to the undeformed normal": lambda: Rotation(MIDDLE, (0, 0, 2)).value(plate("full", 4)),
    "no integration .*at least one element": lambda: SectionForce("M11", None, ((2, 3), (0, 1))).value(plate("full", 4)),
    "no boundary 'lef'": lambda: Reaction("lef").value(plate("full", 4)),
}


@pytest.mark.parametrize("message", BAD)
def test_bad_input(message):
    with pytest.raises(InputError, match=message):
        BAD[message]()


def test_units():
    found = {q.unit for q in quantities(SURFACES["flat"]).values()}
    assert found == {"m", "rad", "N/m", "N", "J"}
    assert (SectionForce("N12").unit, SectionForce("M12").unit) == ("N/m", "N")


# --- which have no limit ---------------------------------------------------------------------------------------------

DOWN = (0.0, 0.0, -1.0)
AT_MIDDLE, AT_CORNER = SectionForce("M11", at=MIDDLE), SectionForce("M12", at=(1.0, 1.0))


def on(theory: str, supports=(), loads=(), surface=PLATE, mesh=None):
    mesh = sk.meshes.uniform(surface, 4, 4) if mesh is None else mesh
    return sk.Problem(surface, 0.1, sk.Isotropic(1.0, NU, 1.0), list(supports), list(loads)).on(mesh, theory=theory)


@theories
def test_section_force_under_a_point_force(theory):
    system = on(theory, [sk.Clamp("left")], [sk.PointForce(MIDDLE, DOWN)])
    why = no_limit(AT_MIDDLE, system)
    assert "at=(0.5, 0.5)" in why and "PointForce" in why
    assert "SectionForce('M11', within=((0.25, 0.75), (0.25, 0.75)))" in why
    assert no_limit(SectionForce("M11", within=((0.25, 0.75), (0.25, 0.75))), system) is None
    assert no_limit(SectionForce("M11", at=(0.5, 0.51)), system) is None
    assert no_limit(AT_MIDDLE, on(theory, [sk.Clamp("left")], [sk.DiskForce(MIDDLE, 0.1, DOWN)])) is None
    assert no_limit(AT_MIDDLE, on(theory, [sk.Clamp("left")], [sk.PointForce(MIDDLE, (0, 0, 0))])) is None


POINTS = {
    "point": MIDDLE,
    "points": [(0.25, 0.25), MIDDLE],
    "names and points": ["left", MIDDLE],
    "function": lambda x, y: (abs(x - 0.5) < 1e-9) & (abs(y - 0.5) < 1e-9),
}


@pytest.mark.parametrize("place", POINTS)
@pytest.mark.parametrize("support", [sk.Pin, sk.Clamp, sk.Roller, lambda where: sk.Spring(where, (0, 0, 1.0))])
@theories
def test_section_force_at_a_support_of_a_single_point(theory, support, place):
    system = on(theory, [support(POINTS[place])])
    assert "holds this single point" in no_limit(AT_MIDDLE, system)
    assert no_limit(SectionForce("M11", at=(0.0, 0.5)), system) is None, "of an edge"


def test_moments_at_a_free_right_angled_corner():
    for support in (sk.Pin("corners"), sk.Roller([(1.0, 1.0)])):
        assert no_limit(AT_CORNER, on("kirchhoff", [support])) is None
        assert "single point" in no_limit(AT_CORNER, on("full", [support]))
        assert "single point" in no_limit(SectionForce("N12", at=(1.0, 1.0)), on("kirchhoff", [support]))
    assert no_limit(AT_CORNER, on("kirchhoff", loads=[sk.PointForce((1, 1), DOWN)])) is None
    assert "PointForce" in no_limit(AT_CORNER, on("kirchhoff", loads=[sk.PointForce((1, 1), (1, 0, 0))]))
    assert "Clamp" in no_limit(AT_CORNER, on("kirchhoff", [sk.Clamp((1.0, 1.0))])), "holds the normal too"
    assert "Pin" in no_limit(AT_CORNER, on("kirchhoff", [sk.Symmetry("top"), sk.Pin((1.0, 1.0))])), "half of an edge"
    assert "Pin" in no_limit(SectionForce("M12", at=(1.0, 0.5)), on("kirchhoff", [sk.Pin((1.0, 0.5))]))
    skew = sk.Parallelogram(1.0, 1.0, 1.0)
    corner = SectionForce("M12", at=skew_corner(skew))
    assert "Pin" in no_limit(corner, on("kirchhoff", [sk.Pin("corners")], surface=skew))


def skew_corner(surface) -> tuple[float, float]:
    return tuple(high for _, high in surface.bounds)


def l_shape() -> skfem.MeshQuad:
    mesh = skfem.MeshQuad.init_tensor(*2 * (np.linspace(0, 1, 5),))
    rest = mesh.remove_elements(np.flatnonzero((mesh.p[:, mesh.t].mean(axis=1) > 0.5).all(axis=0)))
    return rest.with_boundaries({"opening": lambda x: (x > 0.49).all(axis=0) & (x < 0.99).all(axis=0)})


@theories
def test_section_force_in_a_reentrant_corner(theory):
    system = on(theory, [sk.SimpleSupport("boundary")], mesh=l_shape())
    why = no_limit(AT_MIDDLE, system)
    assert "re-entrant corner" in why and "270 degrees" in why and "within=" in why
    for x, y in ((0.25, 0.25), (0.0, 0.0), (0.5, 1.0), (0.5, 0.75), (1.0, 0.5)):
        assert no_limit(SectionForce("M11", at=(x, y)), system) is None
    for surface in (SURFACES["closed"], SURFACES["poled"]):
        whole = on(theory, surface=surface, mesh=sk.meshes.uniform(surface, 3, 8))
        for x in (0.0, 0.5, 1.0):
            assert no_limit(SectionForce("M11", at=share(surface, x, 0.0)), whole) is None


def test_the_polygon_of_a_hole_has_no_corners():
    """Around a hole of 16 elements the nodes have 180 + 22.5 degrees, less on finer meshes."""
    ring = skfem.MeshQuad.init_tensor(np.linspace(0.1, 0.4, 4), np.linspace(0, 2 * pi, 17))
    r, angle = ring.p
    flat = sk.Plane()
    p, first = np.unique(np.round(np.stack([r * np.cos(angle), r * np.sin(angle)]), 12), axis=1, return_inverse=True)
    system = on("full", surface=flat, mesh=skfem.MeshQuad(p, first.ravel()[ring.t]))
    assert no_limit(SectionForce("M11", at=(0.1, 0.0)), system) is None


def test_displacement_under_a_point_force():
    across, along = sk.PointForce(MIDDLE, DOWN), sk.PointForce(MIDDLE, (1.0, 0.0, 0.0))
    sideways = Displacement(MIDDLE, (1.0, 0.0, 0.0))
    thick, thin = (on(theory, [sk.Clamp("left")], [across]) for theory in THEORIES)
    why = no_limit(Displacement(MIDDLE), thick)
    assert "(0.5, 0.5)" in why and "DiskForce" in why and "'kirchhoff'" in why
    assert no_limit(Displacement(MIDDLE), thin) is None
    assert no_limit(sideways, thick) is None, "across the force"
    assert no_limit(Displacement((0.5, 0.6)), thick) is None
    assert no_limit(Rotation(MIDDLE, (1, 0, 0)), thick) is None and no_limit(Rotation(MIDDLE, (1, 0, 0)), thin) is None
    assert no_limit(Reaction("left"), thick) is None
    for theory in THEORIES:  # In the plane it is elasticity of two dimensions.
        pulled = no_limit(sideways, on(theory, [sk.Clamp("left")], [along]))
        assert "DiskForce" in pulled and "or theory" not in pulled


def test_energy_with_a_point_force():
    thick, thin = (on(theory, [sk.Clamp("left")], [sk.PointForce(MIDDLE, DOWN)]) for theory in THEORIES)
    assert "(0.5, 0.5)" in no_limit(StrainEnergy(), thick) and "'kirchhoff'" in no_limit(StrainEnergy(), thick)
    assert no_limit(StrainEnergy(), thin) is None
    assert "DiskForce" in no_limit(StrainEnergy(), on("kirchhoff", loads=[sk.PointForce(MIDDLE, (1, 0, 0))]))
    assert no_limit(StrainEnergy(), on("full", loads=[sk.DiskForce(MIDDLE, 0.1, DOWN)])) is None


@theories
def test_one_point_has_many_parameters(theory):
    """At the seam of a closed parameter and at a pole."""
    tube, cap = SURFACES["closed"], SURFACES["poled"]
    seam = on(theory, [], [sk.PointForce((0.5, 0.0), DOWN)], tube, sk.meshes.uniform(tube, 2, 8))
    assert "PointForce" in no_limit(SectionForce("M11", at=(0.5, 2 * pi)), seam)
    assert no_limit(SectionForce("M11", at=(0.5, pi)), seam) is None
    pole = on(theory, [], [sk.PointForce((0.0, 0.0), DOWN)], cap, sk.meshes.uniform(cap, 2, 8))
    assert "PointForce" in no_limit(SectionForce("M11", at=(0.0, 2.0)), pole)
    assert no_limit(SectionForce("M11", at=(0.4, 2.0)), pole) is None


def test_drift_with_supports_of_single_points():
    for where in ("corners", [(0.0, 0.0), (1.0, 1.0)], lambda x, y: x + y < 1e-9):
        why = drift(on("full", [sk.Pin(where)]))
        assert "(0, 0)" in why and "logarithm" in why and "kirchhoff" in why
        assert drift(on("kirchhoff", [sk.Pin(where)])) is None
    assert drift(on("full", [sk.Clamp("left"), sk.Pin((0.0, 0.0))])) is None, "the edge holds this point anyway"
    assert drift(on("full", [sk.Foundation(1.0)])) is None
    assert "normal is held" in drift(on("kirchhoff", [sk.Clamp(MIDDLE)]))


def growth(quantity, theory: str, supports, load) -> float:
    """The last change between meshes of 8, 16 and 32 elements a side, over the one before it."""
    coarse, middle, fine = (quantity.value(plate(theory, n, 0.5, tuple(supports), load)) for n in (8, 16, 32))
    return (fine - middle) / (middle - coarse)


@pytest.mark.filterwarnings("ignore::skancf.OutOfDepth")
def test_the_numbers_bear_the_rules_out():
    """What grows with a logarithm changes by the same amount each time; what has a limit by less and less."""
    force, half = sk.PointForce((0.5, 0.25), (0, 0, 1e-6)), sk.SurfaceLoad(half_loaded)
    left, centre = [sk.Clamp("left")], [sk.Clamp(MIDDLE)]
    sinks, turns = Displacement((0.5, 0.25)), Rotation((0.5, 0.25), (0, 1, 0))
    # Measured 0.93, 1.00 and 1.00.
    assert growth(sinks, "full", left, force) > 0.85
    assert growth(Displacement((0.5, 0.25), (1, 0, 0)), "kirchhoff", left, sk.PointForce((0.5, 0.25), (1e-6, 0, 0))) > 0.85
    assert growth(Displacement((1.0, 0.5)), "kirchhoff", centre, half) > 0.9
    # Measured 0.29 and 0.26.
    assert growth(turns, "full", left, force) < 0.5
    assert growth(sinks, "kirchhoff", left, force) < 0.5


def half_loaded(x, y):
    return np.stack([0 * x, 0 * x, 1e-6 * (x > 0.5)])
