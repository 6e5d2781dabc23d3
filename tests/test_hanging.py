"""Hanging nodes: fields fit together, rigid motions are free, loads and supports are what they are on uniform meshes."""

from math import pi

import numpy as np
import pytest
from problems import SURFACES

import skancf as sk
from skancf.errors import InputError
from skancf.meshes import quadtree, uniform
from skancf.theories import theory_named

MATERIAL = sk.Isotropic(1e6, 0.3, 2000.0)
theories = pytest.mark.parametrize("theory", ["kirchhoff", "full"])
every = pytest.mark.parametrize("name", SURFACES)


def tree(name, seed=0, steps=3):
    """Refined at random, the first time in a corner of the parameter plane: at the seam, and at the pole."""
    surface, *counts = SURFACES[name]
    mesh, rng = quadtree(uniform(surface, *counts), surface).refined([0]), np.random.default_rng(seed)
    for _ in range(steps - 1):
        mesh = mesh.refined(rng.choice(mesh.nelements, 2, replace=False))
    assert len(mesh.hanging) > 3
    return mesh


def system_on(name, theory, mesh=None, supports=(), loads=(), thickness=0.05, material=MATERIAL):
    mesh = tree(name) if mesh is None else mesh
    return sk.Problem(SURFACES[name][0], thickness, material, list(supports), list(loads)).on(mesh, theory)


def box(mesh, elements):
    return mesh.p[:, mesh.t[0, elements]], mesh.p[:, mesh.t[2, elements]]


def fields_at(system, q, elements, at):
    """r, r_x, r_y, and r_z in theory `full`, seen from elements (m,) at points (2, m): (3 or 4, m, 3)."""
    geometry, theory = system.geometry, system.geometry.theory
    low, high = box(system.mesh, elements)
    local, s = geometry.local(q.reshape(-1, 4, 3), elements), (at - low) / (high - low)
    tables = [theory.position_table(s)[0], *(theory.slope_table(s) / (high - low)[:, None]), *theory.position_table(s)[1:]]
    return np.stack([np.einsum("am,mai->mi", table, local) for table in tables])


def jumps(system, q):
    """Largest jump of each field over all edges, and across the seams, over its size."""
    mesh, geometry = system.mesh, system.geometry
    inner = np.flatnonzero(mesh.f2t[1] >= 0)
    parts = [(inner, *mesh.f2t[:, inner], np.zeros((2, len(inner))))]
    for axis, (low, high) in geometry.closed_bounds().items():
        outer = mesh.boundary_facets()
        outer = outer[(mesh.p[axis, mesh.facets[:, outer]] == low).all(axis=0)]
        other = mesh.boundary_facets()
        other = other[(mesh.p[axis, mesh.facets[:, other]] == high).all(axis=0)]
        for facets, shift in ((outer, high - low), (other, low - high)):
            move = np.zeros((2, len(facets)))
            move[axis] = shift
            beyond = mesh.element_finder()(*(mesh.p[:, mesh.facets[:, facets]].mean(axis=1) + move))
            # A whole side of a larger element has two smaller ones beyond; they see it from their side.
            whole = np.ptp(mesh.p[1 - axis, mesh.t[:, mesh.f2t[0, facets]]], axis=0)
            fits = whole <= np.ptp(mesh.p[1 - axis, mesh.t[:, beyond]], axis=0) * (1 + 1e-9)
            parts.append((facets[fits], mesh.f2t[0, facets][fits], beyond[fits], move[:, fits]))
    found = []
    for facets, one, two, move in parts:
        for s in np.linspace(0, 1, 7) if len(facets) else ():
            ends = mesh.p[:, mesh.facets[:, facets]]
            at = (1 - s) * ends[:, 0] + s * ends[:, 1]
            values, others = fields_at(system, q, one, at), fields_at(system, q, two, at + move)
            found.append(np.abs(values - others).max(axis=(1, 2)) / np.abs(values).max(axis=(1, 2)))
    return np.max(found, axis=0)


def random_state(system, rng):
    return system.undeformed + 0.1 * rng.normal(size=system.n_dofs)


@theories
@every
@pytest.mark.parametrize("seed", [0, 1])
def test_fields_fit_together(name, theory, seed, rng):
    """Positions and both slopes in the thin theory; positions and directors in the full one. Sums of 32 products."""
    system = system_on(name, theory, tree(name, seed))
    for q in (system.undeformed, random_state(system, rng)):
        r, r_x, r_y, *d = jumps(system, q)
        assert max([r, *d]) < 1e-12
        assert theory == "full" or max(r_x, r_y) < 1e-12
    assert theory == "kirchhoff" or max(r_x, r_y) > 1e-2, "slopes of the full theory jump, so this sees a jump"


@pytest.mark.parametrize("theory, vector, field", [
    ("kirchhoff", "r", 0), ("kirchhoff", "along", 0), ("kirchhoff", "across", 1), ("kirchhoff", "fourth", 1),
    ("full", "r", 0), ("full", "along", 0), ("full", "fourth", 3),
])  # fmt: skip
@pytest.mark.parametrize("name", ["flat", "tube"])
def test_wrong_weights_tear_the_field(name, theory, vector, field, rng, monkeypatch):
    """Each row of the weights is needed."""
    kind = type(theory_named(theory))
    right = kind.hanging_weights

    def wrong(self, way, along_x):
        out = right(self, way, along_x)
        rows = {"r": np.zeros_like(way, dtype=int), "along": np.where(along_x, 1, 2), "across": np.where(along_x, 2, 1),
                "fourth": np.full(len(way), 3)}[vector]  # fmt: skip
        out[:, np.arange(len(way)), rows] *= 1.5
        return out

    monkeypatch.setattr(kind, "hanging_weights", wrong)
    system = system_on(name, theory)
    found = jumps(system, random_state(system, rng))
    assert found[field : field + 2].max() > 1e-3


@theories
@every
def test_rigid_motions_have_no_energy_and_nothing_else_has_none(name, theory):
    system = system_on(name, theory)
    free = ~system.constraints.fixed.ravel()
    assert system.constraints.n_free == free.sum()
    tangent = system.tangent(system.undeformed).to_scipy().toarray()[np.ix_(free, free)]
    size = 1 / np.sqrt(tangent.diagonal())
    values = np.sort(np.abs(np.linalg.eigvalsh(size[:, None] * tangent * size)))
    assert values[5] < 1e-11 and values[6] > 1e-7
    turned = system.undeformed.reshape(-1, 4, 3) @ np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    turned[:, 0] += [0.3, -0.2, 0.9]
    assert system.strain_energy(turned.ravel()) < 1e-24 * system.strain_energy(2 * system.undeformed)


def monomial(i, j, x, y):
    """x^i y^j and its derivatives x, y, xy."""

    def power(s, n):
        return s**n if n >= 0 else 0 * s

    return np.stack([power(x, i) * power(y, j), i * power(x, i - 1) * power(y, j), j * power(x, i) * power(y, j - 1),
                     i * j * power(x, i - 1) * power(y, j - 1)])  # fmt: skip


def reproduced(system, i, j):
    """Error of a monomial given at the nodes, over its size."""
    x, y = system.geometry.points
    q = np.zeros((len(x), 4, 3))
    q[:, :, 0] = monomial(i, j, x, y).T
    if system.geometry.theory.directors:
        q[:, 3] = 0.0
    elements = np.repeat(np.arange(system.mesh.nelements), 5)
    low, high = box(system.mesh, elements)
    at = low + np.random.default_rng(1).uniform(size=low.shape) * (high - low)
    exact = monomial(i, j, *at)
    return np.abs(fields_at(system, q.ravel(), elements, at)[0, :, 0] - exact[0]).max()


def test_the_thin_element_reproduces_bicubics():
    system = system_on("flat", "kirchhoff")
    assert max(reproduced(system, i, j) for i in range(4) for j in range(4)) < 1e-13
    assert reproduced(system, 4, 0) > 1e-6


TWELVE = [(i, j) for i in range(4) for j in range(4) if i + j < 4 or (i, j) in ((3, 1), (1, 3))]
CROSSED = {(2, 1), (1, 2), (3, 1), (1, 3)}


def test_what_the_full_element_reproduces():
    """All twelve monomials on a conforming mesh; at hanging nodes those whose slope across an edge is linear along it."""
    whole = system_on("flat", "full", quadtree(uniform(SURFACES["flat"][0], 3, 3)))
    divided = system_on("flat", "full")
    assert max(reproduced(whole, *powers) for powers in TWELVE) < 1e-13
    errors = {powers: reproduced(divided, *powers) for powers in TWELVE}
    assert {powers for powers, error in errors.items() if error > 1e-13} == CROSSED
    assert all(errors[powers] > 1e-4 for powers in CROSSED)
    # Across edges along x, the slope r_y of x^2 y and x^3 y is not linear; along y, that of the others.
    surface = SURFACES["flat"][0]
    tall = quadtree(uniform(surface, 2, 1)).refined([0])
    assert np.ptp(tall.p[0, tall.hanging_ends]) == 0, "one edge, along y"
    one = system_on("flat", "full", tall)
    assert {powers for powers in TWELVE if reproduced(one, *powers) > 1e-13} == {(1, 2), (1, 3)}


# --- patch tests -------------------------------------------------------------------------------------------------------


def interior(system):
    edge = system.geometry.nodes_on("boundary")
    inner = np.ones(system.geometry.n_nodes, dtype=bool)
    inner[edge] = False
    assert inner.sum() > 3
    return inner


@theories
def test_a_constant_membrane_strain_is_in_equilibrium(theory):
    system = system_on("flat", theory)
    F = np.array([[1.01, 0.02, 0.0], [-0.01, 0.97, 0.0], [0.0, 0.0, 1.0]])
    q = (system.undeformed.reshape(-1, 4, 3) @ F.T).ravel()
    force, inner = system.internal_force(q).reshape(-1, 4, 3)[:, :3], interior(system)
    assert np.abs(force[inner]).max() < 1e-12 * np.abs(force[~inner]).max()


@theories
@pytest.mark.parametrize("powers", [(2, 0), (1, 1), (0, 2)])
def test_a_constant_curvature_is_in_equilibrium(theory, powers):
    """Small deflections; with nu = 0, so that the thickness strain of the full theory stays zero."""
    system = system_on("flat", theory, material=sk.Isotropic(1e6, 0.0, 2000.0))
    values = monomial(*powers, *system.geometry.points)
    u = np.zeros((system.geometry.n_nodes, 4, 3))
    u[:, :3, 2] = values[:3].T
    if theory == "kirchhoff":
        u[:, 3, 2] = values[3]
    else:
        u[:, 3, :2] = -values[1:3].T
    force, inner = (system.stiffness() @ u.ravel()).reshape(-1, 4, 3), interior(system)
    assert np.abs(force[inner]).max() < 1e-11 * np.abs(force[~inner]).max()
    # A cubic one is not: its shear force needs a load.
    u[:, 0, 2] *= 1 + system.geometry.points[0]
    force = (system.stiffness() @ u.ravel()).reshape(-1, 4, 3)
    assert np.abs(force[inner]).max() > 1e-3 * np.abs(force[~inner]).max()


@theories
def test_a_strip_under_an_edge_moment_bends_exactly(theory):
    """w = -M x^2 / (2 D) with nu = 0."""
    material = sk.Isotropic(1e6, 0.0, 2000.0)
    system = system_on("flat", theory, supports=[sk.Clamp("left")], loads=[sk.EdgeMoment("right", (0.0, 1e-3, 0.0))],
                       material=material)  # fmt: skip
    solution = sk.solve_linear(system)
    at = np.random.default_rng(0).uniform(size=(40, 2)) * [1.0, 0.8]
    w = -1e-3 * at[:, 0] ** 2 / (2 * 1e6 * 0.05**3 / 12)
    # Condition of the stiffness, about 1e6.
    assert np.abs(solution.displacement(at)[:, 2] - w).max() < 1e-8 * np.abs(w).max()


# --- loads -------------------------------------------------------------------------------------------------------------


def work_on_rigid_motions(system):
    """Work of the loads on the six rigid motions of the undeformed body: resultants and moments about the origin."""
    nodal, force = system.undeformed.reshape(-1, 4, 3), system.external_force(system.undeformed).reshape(-1, 4, 3)
    turns = [(np.cross(axis, nodal) * force).sum() for axis in np.eye(3)]
    return np.array([*force[:, 0].sum(axis=0), *turns])


FORCE = (2.0, -1.0, 3.0)
LOADS = {
    "surface": sk.SurfaceLoad(lambda x, y: (1 + x, y, x * y)),
    "edge": sk.EdgeLoad("right", lambda x, y: (1 + y, y**2, 1 - y)),
    "all edges": sk.EdgeLoad("boundary", FORCE),
    "line": sk.LineLoad((0.05, 0.1), (0.9, 0.7), lambda x, y: (1 + x, y, x)),
    "disk": sk.DiskForce((0.3, 0.3), 0.15, FORCE),
    "point": sk.PointForce((0.26, 0.2), FORCE),
    "pressure": sk.FollowerPressure(2.0),
    "weight": sk.Gravity((1.0, 2.0, -9.81)),
    "moment": sk.EdgeMoment("right", (1.0, 2.0, 0.0)),
}


@theories
@pytest.mark.parametrize("kind", LOADS)
def test_resultants_and_moments_of_loads(kind, theory):
    even = quadtree(uniform(SURFACES["flat"][0], 2, 2))
    found, wanted = (work_on_rigid_motions(system_on("flat", theory, mesh, loads=[LOADS[kind]]))
                     for mesh in (tree("flat"), even))  # fmt: skip
    # The disk's 768 points are the same ones.
    assert np.abs(found - wanted).max() < 1e-12 * np.abs(wanted).max() and np.abs(wanted).max() > 0.1


@theories
@pytest.mark.parametrize("name", ["tube", "disc"])
def test_resultants_on_closed_surfaces(name, theory):
    """Areas of elements are of order four; lengths are those of the surface."""
    surface, area = SURFACES[name][0], 2 * pi if name == "tube" else pi
    mesh = quadtree(uniform(surface, 4, 8), surface).refined([0, 9])
    assert len(mesh.hanging)
    on_area, on_edge = (work_on_rigid_motions(system_on(name, theory, mesh, loads=[load]))[2]
                        for load in (sk.SurfaceLoad((0, 0, 1.0)), sk.EdgeLoad(surface.sides[1], (0, 0, 1.0))))  # fmt: skip
    assert np.isclose(on_area, area, rtol=3e-3) and np.isclose(on_edge, 2 * pi, rtol=1e-12)


LINE = ((0.5, 0.0), (0.5, 0.8))


def with_line(mesh):
    return mesh.with_boundaries({"line": lambda x: abs(x[0] - 0.5) < 1e-9}, boundaries_only=False)


@theories
def test_loads_on_a_line_inside(theory):
    """Of which some edges are between two levels."""
    mesh, even = with_line(tree("flat")), with_line(quadtree(uniform(SURFACES["flat"][0], 2, 2)))
    assert (np.abs(mesh.p[0, mesh.hanging] - 0.5) < 1e-9).any()
    for load in (sk.EdgeLoad("line", FORCE), sk.EdgeMoment("line", (1.0, 2.0, 0.0))):
        found, wanted = (work_on_rigid_motions(system_on("flat", theory, m, loads=[load])) for m in (mesh, even))
        assert np.abs(found - wanted).max() < 1e-12 * np.abs(wanted).max()
    line = sk.LineLoad(*LINE, FORCE)
    found = work_on_rigid_motions(system_on("flat", theory, mesh, loads=[line]))
    assert np.allclose(found, work_on_rigid_motions(system_on("flat", theory, mesh, loads=[sk.EdgeLoad("line", FORCE)])))


# --- supports ----------------------------------------------------------------------------------------------------------


@theories
def test_a_line_inside_is_held(theory):
    """All of it, hanging nodes too, and nothing else."""
    supports = [sk.Clamp("line")]
    system = system_on("flat", theory, with_line(tree("flat")), supports, [sk.SurfaceLoad((0, 0, 1e-2))])
    held = system.constraints.fixed.any(axis=1)
    assert np.array_equal(np.flatnonzero(held), system.geometry.nodes_on("line"))
    solution = sk.solve_linear(system)
    y = np.linspace(0, 0.8, 33)
    size = np.abs(solution.displacements).max()
    assert np.abs(solution.displacement(np.stack([0 * y + 0.5, y], axis=1))).max() < 1e-13 * size
    assert np.abs(solution.displacement([(0.0, 0.4), (1.0, 0.8)])[:, 2]).min() > 0.1 * size


@theories
def test_a_function_that_is_true_at_hanging_nodes_too(theory):
    """The edge in it is held all along, as by its name; what hangs is no node of the place."""
    mesh = tree("flat")

    def strip(x, y):
        return x < 0.3

    assert strip(*mesh.p[:, mesh.hanging]).any()
    loads = [sk.SurfaceLoad((0, 0, 1e-3))]
    system = system_on("flat", theory, mesh, [sk.Clamp(strip)], loads)
    solution = sk.solve_linear(system)
    y = np.linspace(0, 0.8, 33)
    edge, free = (solution.displacement(np.stack([0 * y + x, y], axis=1)) for x in (0.0, 1.0))
    assert np.abs(edge).max() < 1e-13 * np.abs(free).max()
    on_edge = system_on("flat", theory, mesh, [sk.Clamp(lambda x, y: x < 1e-9)], loads)
    by_name = system_on("flat", theory, mesh, [sk.Clamp("left")], loads)
    assert np.array_equal(on_edge.constraints.fixed, by_name.constraints.fixed)
    at = mesh.p[:, mesh.hanging[0]]
    with pytest.raises(InputError, match="true at hanging nodes only"):
        system_on("flat", theory, mesh, [sk.Pin(lambda x, y: (abs(x - at[0]) < 1e-9) & (abs(y - at[1]) < 1e-9))])


@theories
@pytest.mark.parametrize("support", [sk.Pin, sk.Clamp, lambda where: sk.Spring(where, (1.0, 1.0, 1.0))])
def test_a_point_at_a_hanging_node_is_refused(theory, support):
    mesh = tree("flat")
    with pytest.raises(InputError, match=r"hangs in the middle of a larger element's edge.*refine the mesh around it"):
        system_on("flat", theory, mesh, [support(tuple(mesh.p[:, mesh.hanging[0]].tolist()))])


@theories
def test_a_line_that_ends_at_a_hanging_node_is_refused(theory):
    mesh = tree("flat")
    half = mesh.divided[0][:1]
    with pytest.raises(InputError, match=r"the line ends at \(.*\), where a node hangs"):
        system_on("flat", theory, mesh.with_boundaries({"half": half}), [sk.Pin("half")])


@theories
def test_springs_and_foundations(theory, rng):
    """Their energy in rigid motions is that of the uniform mesh: stiffness times length, or area."""
    even = quadtree(uniform(SURFACES["flat"][0], 2, 2))
    for support in (sk.Spring("left", (1.0, 2.0, 3.0)), sk.Spring((1.0, 0.8), (1.0, 2.0, 3.0)), sk.Foundation(5.0),
                    sk.Foundation(5.0, (1.0, 0.0, 2.0)), sk.Spring("line", (1.0, 2.0, 3.0))):  # fmt: skip
        energies = []
        for mesh in (tree("flat"), even):
            system = system_on("flat", theory, with_line(mesh), [support])
            nodal = system.undeformed.reshape(-1, 4, 3)
            A, b = 1e-3 * np.random.default_rng(3).normal(size=(3, 3)), np.array([1.0, 2.0, -1.0])
            moved = nodal @ A.T
            moved[:, 0] += b
            energies.append(0.5 * moved.ravel() @ (system.foundation @ moved.ravel()))
        assert np.isclose(energies[0], energies[1], rtol=1e-12) and energies[0] > 0.1


@theories
@pytest.mark.parametrize("name", ["flat", "tube"])
def test_reactions_balance(name, theory):
    side, load = SURFACES[name][0].sides[0], sk.SurfaceLoad((1e-2, 2e-2, -1e-2))
    system = system_on(name, theory, supports=[sk.Clamp(side)], loads=[load])
    applied = system.external_force(system.undeformed).reshape(-1, 4, 3)[:, 0].sum(axis=0)
    for solution in (sk.solve_linear(system), sk.solve(system).unwrap()):
        assert np.abs(solution.reactions() + applied).max() < 1e-7 * np.abs(applied).max()
        assert np.allclose(solution.reactions(side), solution.reactions())


@theories
def test_a_tube_under_inner_pressure(theory):
    """A patch across the seam shows less than the difference of two uniform meshes."""
    surface = SURFACES["tube"][0]
    supports, loads = [sk.Clamp(["left", "right"])], [sk.FollowerPressure(20.0)]
    coarse, fine = (quadtree(uniform(surface, n, 3 * n), surface) for n in (4, 8))
    middle = fine.p[:, fine.t].mean(axis=1)
    patch = np.flatnonzero((np.abs(middle[0] - 0.5) < 0.3) & ((middle[1] < 0.6) | (middle[1] > 2 * pi - 0.6)))
    patched = fine.refined(patch)
    assert {0.0, 2 * pi} <= set(patched.p[1, patched.t[:, patched.levels > 0]].ravel()) and len(patched.hanging)
    at = np.stack([np.full(5, 0.5), np.array([0.0, 0.1, 2 * pi - 0.1, 2.0, 4.0])], axis=1)
    found, wanted, rough = (sk.solve(system_on("tube", theory, mesh, supports, loads)).unwrap().displacement(at)
                            for mesh in (patched, fine, coarse))  # fmt: skip
    size = np.linalg.norm(wanted, axis=1)
    assert size.min() > 1e-4 and np.ptp(size) < 1e-3 * size.max(), "the answer is round"
    error = np.linalg.norm(rough - wanted, axis=1).max()
    assert np.linalg.norm(found - wanted, axis=1).max() < 0.3 * error < 0.03 * size.max()


def test_a_simply_supported_plate_converges():
    """w = 0.00406235 q a^4 / D in the middle (Timoshenko and Woinowsky-Krieger 1959, table 8)."""
    surface, D = sk.Rectangle(1.0, 1.0), 1e6 * 0.01**3 / 12 / (1 - 0.3**2)
    mesh, errors = quadtree(uniform(surface, 2, 2)).refined([0, 1]).refined([2, 6]), []
    for _ in range(3):
        system = sk.Problem(surface, 0.01, MATERIAL, [sk.SimpleSupport("boundary", kind="hard")],
                            [sk.SurfaceLoad((0, 0, 1e-6))]).on(mesh, "kirchhoff")  # fmt: skip
        w = sk.solve_linear(system).displacement((0.5, 0.5))[2]
        errors.append(abs(w / (0.00406235 * 1e-6 / D) - 1))
        assert len(mesh.hanging)
        mesh = mesh.refined(1)
    # Order four: measured 20 and 18.
    assert errors[1] < errors[0] / 12 and errors[2] < errors[1] / 12 and errors[2] < 4e-5


# --- consistency -------------------------------------------------------------------------------------------------------


@theories
@pytest.mark.parametrize("name", ["flat", "tube", "cap"])
def test_forces_are_gradients_of_the_energy(name, theory, rng):
    """Central differences with a step of 1e-6 leave about 1e-9."""
    system = system_on(name, theory)
    q = system.undeformed + 0.02 * system.constraints.free_part(rng.normal(size=system.n_dofs))
    p, step = system.constraints.free_part(rng.normal(size=system.n_dofs)), 1e-6
    slope = (system.strain_energy(q + step * p) - system.strain_energy(q - step * p)) / (2 * step)
    assert np.isclose(slope, system.internal_force(q) @ p, rtol=1e-7)
    change = (system.internal_force(q + step * p) - system.internal_force(q - step * p)) / (2 * step)
    tangent = system.tangent(q)
    assert np.abs(tangent @ p - change).max() < 1e-7 * np.abs(change).max()
    dense = tangent.to_scipy()
    assert abs(dense - dense.T).max() < 1e-12 * abs(dense).max()


@theories
def test_forces_on_unknowns_are_those_on_all_nodes(theory, rng):
    """The maps are transposes of each other, and the compiled ones are the plain ones."""
    geometry = system_on("cap", theory).geometry
    q, f = rng.normal(size=(geometry.n_nodes, 4, 3)), rng.normal(size=(geometry.n_elements, 16, 3))
    every_element = np.arange(geometry.n_elements)
    assert np.isclose((geometry.local(q) * f).sum(), (q * geometry.nodal(f, every_element)).sum(), rtol=1e-12)
    assert np.allclose((geometry.local_matrix @ q.reshape(-1, 3)).reshape(-1, 16, 3), geometry.local(q), rtol=0, atol=1e-12)
    element = int(np.flatnonzero(np.isin(geometry.mesh.t, geometry.mesh.hanging).any(axis=0))[0])
    dense = geometry.dense_map(element) @ q[geometry.nodes[element]].reshape(-1, 3)
    assert np.allclose(dense, geometry.local(q)[element], rtol=0, atol=1e-12)
    # What the elements see at a corner is what the nodes of the mesh have.
    seen, at_nodes = geometry.local(q)[element], geometry.at_mesh_nodes(q)[geometry.mesh.t[:, element]]
    assert np.allclose(seen[geometry.theory.rows[:, 0]], at_nodes[:, 0], rtol=0, atol=1e-12)


@theories
def test_threads_do_not_change_a_bit(theory, monkeypatch, rng):
    from skancf.kernels import schedule

    found, q = [], None
    for threads in ("1", "2"):
        monkeypatch.setenv("SKANCF_THREADS", threads)
        system = system_on("tube", theory, tree("tube", steps=6))
        q = random_state(system, rng) if q is None else q
        found.append((system.internal_force(q), system.tangent(q).values, system.mass.values))
    assert schedule.n_threads() == 2
    for one, two in zip(*found, strict=True):
        assert np.array_equal(one, two)


@theories
def test_section_forces_at_hanging_nodes(theory):
    """A constant strain has the same ones at all nodes."""
    system = system_on("flat", theory)
    q = system.undeformed.reshape(-1, 4, 3).copy()
    q[..., 0] *= 1.001
    forces = sk.Solution(system, q.ravel()).nodal_section_forces()
    assert len(forces) == system.mesh.p.shape[1]
    assert np.abs(forces - forces[0]).max() < 1e-9 * np.abs(forces[0]).max() > 0
