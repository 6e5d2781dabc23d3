"""Supports hold what they say, loads do the work they should, and mistakes are named."""

import math
import warnings

import numpy as np
import pytest
import skfem

import skancf as sk
from skancf.errors import InputError

SUMS = 1e-12  # sums of a few hundred products
MATERIAL = sk.Isotropic(1e6, 0.3, 2000.0)
UNIT = sk.Rectangle(1, 1)
DIRECTIONS = [v + c for v in ("r", "rx", "ry", "d") for c in ("_1", "_2", "_3")]


theories = pytest.mark.parametrize("theory", ["full", "kirchhoff"])


def system_with(supports=(), loads=(), surface=UNIT, n=2, mesh=None, thickness=0.1, material=MATERIAL, theory="full"):
    mesh = sk.meshes.uniform(surface, n, n) if mesh is None else mesh
    return sk.Problem(surface, thickness, material, list(supports), list(loads)).on(mesh, theory)


def held_at(system, point):
    """Names of the coordinates held at a node; None where a frame of its own is needed."""
    node = system.geometry.node_at(point)
    assert node not in system.constraints.frame_nodes
    return {name for name, held in zip(DIRECTIONS, system.constraints.fixed[node], strict=True) if held}


def each(*vectors, components="123"):
    return {f"{v}_{c}" for v in vectors for c in components}


# --- which coordinates are held --------------------------------------------------------------------------------------

MIDDLE = (0.0, 0.5)  # of the left edge, which runs along y
CASES = {
    "pin": (sk.Pin("left"), each("r", "ry")),
    "clamp": (sk.Clamp("left"), each("r", "ry", "d")),
    "soft": (sk.SimpleSupport("left"), each("r", "ry")),
    "hard": (sk.SimpleSupport("left", kind="hard"), each("r", "ry") | {"d_2"}),
    "roller": (sk.Roller("left"), {"r_3", "ry_3"}),
    "hard roller": (sk.Roller("left", kind="hard"), {"r_3", "ry_3", "d_2"}),
    "roller along x": (sk.Roller("left", (2.0, 0, 0)), {"r_1", "ry_1"}),
    "symmetry": (sk.Symmetry("left"), {"r_1", "ry_1", "rx_2", "rx_3", "d_1"}),
    "prescribed": (sk.Prescribed("left", (0.1, None, 0.0)), {"r_1", "ry_1", "r_3", "ry_3"}),
    "point pin": (sk.Pin(MIDDLE), each("r")),
    "point without rotation": (sk.NoRotation(MIDDLE), each("d")),
}


THIN_CASES = {  # d is r_xy here
    "pin": each("r", "ry"),
    "clamp": each("r", "ry") | {"rx_3", "d_3"},  # the stretch across the edge, and its change along it, stay free
    "soft": each("r", "ry"),
    "hard": each("r", "ry"),  # the normal cannot tilt along an edge that is held
    "roller": {"r_3", "ry_3"},
    "hard roller": {"r_3", "ry_3"},
    "roller along x": {"r_1", "ry_1"},
    "symmetry": {"r_1", "ry_1", "rx_2", "rx_3", "d_2", "d_3"},
    "prescribed": {"r_1", "ry_1", "r_3", "ry_3"},
    "point pin": each("r"),
    "point without rotation": {"rx_3", "ry_3"},
}


@theories
@pytest.mark.parametrize("case", CASES)
def test_held_coordinates(case, theory):
    support, expected = CASES[case]
    system = system_with([support], theory=theory)
    assert held_at(system, MIDDLE) == (expected if theory == "full" else THIN_CASES[case])
    assert held_at(system, (0.5, 0.5)) == held_at(system, (1.0, 0.5)) == set()


def test_at_a_corner_both_edges_count():
    around, one = system_with([sk.Pin("boundary")]), system_with([sk.Pin("left")])
    assert held_at(around, (0, 0)) == each("r", "rx", "ry")
    assert held_at(one, (0, 0)) == each("r", "ry")
    two = system_with([sk.SimpleSupport("left", kind="hard"), sk.SimpleSupport("bottom", kind="hard")])
    assert held_at(two, (0, 0)) == each("r", "rx", "ry") | {"d_1", "d_2"}


def test_places():
    geometry = system_with(n=4).geometry
    left = np.flatnonzero(geometry.points[0] == 0)
    assert np.array_equal(geometry.nodes_on("left"), left)
    assert np.array_equal(geometry.nodes_on(lambda x, y: x < 1e-9), left)
    assert np.array_equal(geometry.nodes_on([(0, y) for y in np.linspace(0, 1, 5)]), left)
    assert np.array_equal(geometry.nodes_on(["left", "right", "top", "bottom"]), geometry.nodes_on("boundary"))
    corners = geometry.nodes_on("corners")
    assert np.array_equal(corners, geometry.nodes_on([(0, 0), (1, 0), (0, 1), (1, 1)])) and len(corners) == 4
    assert len(geometry.facets_on(lambda x, y: x < 1e-9)) == 4


# --- symmetry --------------------------------------------------------------------------------------------------------

HEAVY = sk.SurfaceLoad((0.0, 0.0, 2000.0))  # bends the plates below by about their thickness and more


def positions_at(system, points):
    solution = sk.solve(system, rtol=1e-10).unwrap()
    u = solution.displacement(points)
    assert np.abs(u).max() > 0.02, "too small to tell a nonlinear answer"
    return u


@theories
def test_quarter_plate_is_the_full_plate(theory):
    full = system_with([sk.Clamp("boundary")], [HEAVY], n=8, thickness=0.02, theory=theory)
    quarter = sk.Rectangle(0.5, 0.5)
    supports = [sk.Clamp(["left", "bottom"]), sk.Symmetry(["right", "top"])]
    part = system_with(supports, [HEAVY], quarter, n=4, thickness=0.02, theory=theory)
    at = part.mesh.p.T
    # Newton's method to 1e-10 on displacements of 0.03.
    assert np.abs(positions_at(part, at) - positions_at(full, at)).max() < 1e-9
    loose = system_with([sk.Clamp(["left", "bottom"]), sk.Pin((0.5, 0.5))], [HEAVY], quarter, n=4, thickness=0.02,
                        theory=theory)  # fmt: skip
    assert np.abs(positions_at(loose, at) - positions_at(full, at)).max() > 1e-3, "symmetry matters"


@theories
def test_half_a_sector_is_the_sector(theory):
    whole, half = sk.AnnulusSector(0.5, 1.0, 1.0), sk.AnnulusSector(0.5, 1.0, 0.5)
    full = system_with([sk.Clamp("inner")], [HEAVY], whole, n=6, thickness=0.05, theory=theory)
    mesh = sk.meshes.uniform(half, 6, 3)
    part = system_with([sk.Clamp("inner"), sk.Symmetry("end")], [HEAVY], half, mesh=mesh, thickness=0.05, theory=theory)
    # The plane of symmetry is askew: its nodes need frames of their own; a clamped thin edge may need them too.
    assert len(part.constraints.frame_nodes) >= 7
    at = mesh.p.T
    assert np.abs(positions_at(part, at) - positions_at(full, at)).max() < 1e-9


def turned_strip(angle, length, n):
    """A strip of width 0.5 that runs along ``angle`` from the origin, sides named along it."""
    mesh = sk.meshes.uniform(sk.Rectangle(length, 0.5), n, 2)
    c, s = np.cos(angle), np.sin(angle)
    return skfem.MeshQuad(np.array([[c, -s], [s, c]]) @ mesh.p, mesh.t, sort_t=False).with_boundaries(mesh.boundaries)


def test_symmetry_on_a_skew_edge():
    angle, to_space = 0.4, np.array([[np.cos(0.4), -np.sin(0.4), 0], [np.sin(0.4), np.cos(0.4), 0], [0, 0, 1.0]])

    def strip(angle, length, n, supports):
        return system_with(supports, [HEAVY], sk.Plane(), mesh=turned_strip(angle, length, n), thickness=0.05)

    full = strip(angle, 2.0, 8, [sk.Clamp(["left", "right"])])
    half = strip(angle, 1.0, 4, [sk.Clamp("left"), sk.Symmetry("right")])
    straight = strip(0.0, 1.0, 4, [sk.Clamp("left"), sk.Symmetry("right")])
    # Three nodes on the plane of symmetry, three on the clamped edge, of which the slope along it is held.
    assert len(half.constraints.frame_nodes) == 6 and not len(straight.constraints.frame_nodes)
    u = positions_at(half, half.mesh.p.T)
    assert np.abs(u - positions_at(full, half.mesh.p.T)).max() < 1e-9
    assert np.abs(u - positions_at(straight, straight.mesh.p.T) @ to_space.T).max() < 1e-9


@theories
def test_an_edge_in_no_plane_is_refused(theory):
    """Its direction turns, or the normal does; edges that meet in a corner have planes of their own."""
    sector, saddle = sk.AnnulusSector(0.5, 1.0, 1.0), sk.HyperbolicParaboloid(1.0, 1.0, 0.4)
    for surface, where in ((sector, "outer"), (sector, "boundary"), (saddle, "left"), (sector, ["start", "inner"])):
        for n in (1, 4):
            with pytest.raises(InputError, match=r"Symmetry\(.*near \(.*lies in no plane"):
                system_with([sk.Symmetry(where)], [], surface, n=n, theory=theory)
    for surface, where in ((UNIT, "boundary"), (sector, ["start", "end"]), (sk.CylinderSector(1.0, 1.0, 1.0), "boundary"),
                           (sk.AnnulusSector(0.0, 1.0, 0.3), ["start", "end"])):  # fmt: skip
        system_with([sk.Symmetry(where)], [], surface, n=4, theory=theory)


def test_a_polygon_of_short_edges_lies_in_no_plane():
    """Where two straight edges differ by less than a corner they are meant as one curve."""
    mesh = sk.meshes.uniform(UNIT, 1, 2)
    p = mesh.p.copy()
    p[0, (p[0] == 1) & (p[1] == 0.5)] += 0.1  # turns by 23 degrees
    bent = skfem.MeshQuad(p, mesh.t, sort_t=False).with_boundaries(mesh.boundaries)
    with pytest.raises(InputError, match=r"near \(1.1, 0.5, 0\) the edge lies in no plane"):
        system_with([sk.Symmetry("right")], [], sk.Plane(), mesh=bent)
    system_with([sk.Symmetry("left")], [], sk.Plane(), mesh=bent)


# --- single points ---------------------------------------------------------------------------------------------------

POINTS = {  # a surface, a node in it, and how many conditions hold r and the director (d, or the normal)
    "plate": (sk.Parallelogram(1.0, 1.0, 1.0), (0.5, 0.5)),
    "shell": (sk.CylinderSector(2.0, 1.0, 1.0), (0.5, 0.5)),
    "pole": (sk.AnnulusSector(0.0, 1.0, 2 * np.pi, closed=True), (0.0, 0.0)),
    "pole by name": (sk.SphereSector(1.0, (0.0, 0.8), 2 * np.pi, closed=True), "top"),
}


@theories
@pytest.mark.parametrize("name", POINTS)
@pytest.mark.parametrize("support", [sk.NoRotation, sk.Clamp])
def test_a_point_that_does_not_turn_may_stretch(support, name, theory):
    """Held are the rotations, three at most, and no strain of the surface at the point."""
    surface, at = POINTS[name]
    at = surface.sides[0] if name == "pole by name" else at
    mesh = sk.meshes.uniform(surface, 2, 8)
    system = system_with([support(at)], [], surface, mesh=mesh, theory=theory)
    (node,) = system.geometry.nodes_on(at)
    held = system.constraints.fixed.reshape(-1, 12).sum(axis=1)
    by_twist = 3 if node in system.geometry.ties.poles and theory == "kirchhoff" else 0  # a pole has no r_xy
    director = 3 if theory == "full" else 2
    assert held[node] == director + by_twist + (4 if support is sk.Clamp else 0) and held.sum() == held[node]
    undeformed = system.undeformed.reshape(-1, 4, 3)
    one, two = undeformed[node, 1:3]
    normal = np.cross(one, two) / np.linalg.norm(np.cross(one, two))

    def is_held(matrix):
        """A linear motion about the node."""
        change = (undeformed - [undeformed[node, 0], *np.zeros((3, 3))]) @ np.array(matrix).T
        if theory == "full":  # the director turns with the normal, and is not stretched
            spin = (matrix - np.transpose(matrix)) / 2
            change[:, 3] = undeformed[:, 3] @ spin.T
        return np.abs(system.constraints.fixed_part(change.ravel())).max() > 1e-9

    tangent = one / np.linalg.norm(one)
    across = np.cross(normal, tangent)
    e, f = np.outer(tangent, tangent), np.outer(tangent, across)
    assert not is_held(e) and not is_held(f + f.T) and not is_held(np.outer(across, across))
    assert is_held(f - f.T) == (support is sk.Clamp), "the rotation about the normal"
    for axis in (tangent, across):
        assert is_held(np.outer(axis, normal) - np.outer(normal, axis))


@theories
@pytest.mark.parametrize("at", [(0.5, 0.5), (0.0, 0.0), (1.0, 0.5)])
def test_a_clamped_point_holds_all_rigid_motions_and_no_strain(at, theory):
    """Pulled evenly on all sides the plate stretches evenly about it: u = (1 - nu) f / (E t) x."""
    f, around = 1.0, {"left": (-1, 0, 0), "right": (1, 0, 0), "bottom": (0, -1, 0), "top": (0, 1, 0)}
    loads = [sk.EdgeLoad(edge, tuple(f * np.array(along))) for edge, along in around.items()]
    solution = sk.solve_linear(system_with([sk.Clamp(at)], loads, n=4, theory=theory))
    points = np.array([(0, 0), (1, 0.3), (0.2, 1), (0.7, 0.6)])
    exact = 0.7 * f / (1e6 * 0.1) * (points - at)
    # Rounding times a condition of 1e7.
    assert np.allclose(solution.displacement(points)[:, :2], exact, rtol=0, atol=1e-8 * np.abs(exact).max())


# --- rollers, prescribed displacements, reactions --------------------------------------------------------------------


def test_skew_roller_holds_its_direction_only():
    direction = np.array([1.0, 0.0, 1.0]) / np.sqrt(2)
    system = system_with([sk.Clamp("left"), sk.Roller("right", (1, 0, 1))], [HEAVY], n=4)
    solution = sk.solve(system, rtol=1e-10).unwrap()
    u = solution.displacements[:, system.geometry.nodes_on("right")]
    assert np.abs(direction @ u).max() < 1e-13 < 1e-5 < np.abs(u).max()
    reaction = solution.reactions("right")
    assert np.abs(np.cross(reaction, direction)).max() < SUMS * np.linalg.norm(reaction)


def pulled(u):
    """A strip 2 x 1 between frictionless sides, its right end moved."""
    supports = [sk.Roller("left", (1, 0, 0)), sk.Roller("bottom", (0, 1, 0)), sk.Roller("boundary")]
    strip = sk.Rectangle(2, 1)
    supports.append(sk.Prescribed("right", (u, None, None)))
    return system_with(supports, [], strip, material=sk.Isotropic(1e6, 0.0, 1.0))


def test_reaction_to_a_prescribed_displacement():
    u, area = 0.4, 0.1
    stretch = 1 + u / 2
    result = sk.solve(pulled(u), rtol=1e-10)
    force = 1e6 * area * stretch * (stretch**2 - 1) / 2  # P = F S with S = E (F^2 - 1) / 2
    assert np.allclose(result.unwrap().reactions("right"), [force, 0, 0], atol=1e-9 * force)
    assert np.allclose(result.solution.reactions("left"), [-force, 0, 0], atol=1e-9 * force)
    assert np.allclose(result.solution.displacement((2.0, 0.3)), [u, 0, 0], atol=1e-12)
    assert np.allclose(result.solution.displacement((1.0, 0.3)), [u / 2, 0, 0], atol=1e-9)
    half = sk.solve(pulled(u), load_factor=0.5).unwrap()
    assert np.allclose(half.displacement((2.0, 0.3)), [u / 2, 0, 0], atol=1e-12)
    small = 1e-6
    linear = sk.solve_linear(pulled(small)).reactions("right")[0]
    assert np.isclose(linear, 1e6 * area * small / 2, rtol=3e-6)  # quadratic strain: 1.5 u / L


def test_conflicting_displacements_are_refused():
    with pytest.raises(InputError, match=r"node \(1\.0, 0\.0\) prescribe different values"):
        system_with([sk.Prescribed("right", (0.1, None, None)), sk.Prescribed("right", (0.2, None, None))])
    with pytest.raises(InputError, match="different values"):
        system_with([sk.Clamp("right"), sk.Prescribed("right", (0.2, None, None))])
    system_with([sk.Clamp("right"), sk.Prescribed("right", (0.0, 0.0, None))])


def test_two_supports_may_prescribe_the_same_displacement():
    """As they do in the corner that two edges share."""
    edges = [sk.Prescribed(edge, (0.1, None, None)) for edge in ("right", "top")]
    moved = system_with(edges).prescribed().reshape(-1, 4, 3)
    nodes = system_with().geometry.nodes_on(["right", "top"])
    assert np.allclose(moved[nodes, 0, 0], 0.1, rtol=SUMS)


# --- loads -----------------------------------------------------------------------------------------------------------

PLATE = sk.Rectangle(2, 1, origin=(0.5, -0.3))
CENTRE = np.array([1.5, 0.2, 0])
FORCE, SHIFT = np.array([1.0, -2.0, 3.0]), np.array([0.01, 0, 0])
LOADS = {  # load: force, point through which it acts
    "surface": (sk.SurfaceLoad(FORCE), 2.0 * FORCE, CENTRE),
    "edge": (sk.EdgeLoad("right", FORCE), 1.0 * FORCE, np.array([2.5, 0.2, 0])),
    "two edges": (sk.EdgeLoad(["top", "bottom"], FORCE), 4.0 * FORCE, CENTRE),
    "gravity": (sk.Gravity((0, 0, -10.0)), np.array([0, 0, -10.0 * 2000 * 0.1 * 2]), CENTRE),
    "point": (sk.PointForce((1.234, 0.111), FORCE), FORCE, np.array([1.234, 0.111, 0])),
    "point on an edge": (sk.PointForce((2.5, 0.2), FORCE), FORCE, np.array([2.5, 0.2, 0])),
    "disk": (sk.DiskForce((1.3, 0.25), 0.2, FORCE), FORCE, np.array([1.3, 0.25, 0])),
    "line": (sk.LineLoad((0.7, -0.1), (1.9, 0.4), FORCE), 1.3 * FORCE, np.array([1.3, 0.15, 0])),
    "line along edges of elements": (sk.LineLoad((0.5, 0.2), (2.5, 0.2), FORCE), 2 * FORCE, np.array([1.5, 0.2, 0])),
}


def virtual_work(system, force):
    """Of a nodal force in the six rigid motions about the origin: resultant force and moment."""
    q, f = system.undeformed.reshape(-1, 4, 3), force.reshape(-1, 4, 3)
    return f[:, 0].sum(axis=0), np.cross(q, f).sum(axis=(0, 1))


@theories
@pytest.mark.parametrize("n", [1, 2, 3])
@pytest.mark.parametrize("name", LOADS)
def test_resultants(name, n, theory):
    load, expected, through = LOADS[name]
    system = system_with([], [load], PLATE, n=n, theory=theory)
    force, moment = virtual_work(system, system.external_force(system.undeformed))
    scale = np.abs(expected).max()
    assert np.abs(force - expected).max() < SUMS * scale
    assert np.abs(moment - np.cross(through, expected)).max() < 10 * SUMS * scale
    assert np.abs(moment - np.cross(through + SHIFT, expected)).max() > 1e-3 * scale, "a shift of 1 cm shows"


def points_on(load, n=6):
    """Gauss points (m, 2) and weights (m,) of a load on the plate, cell by cell of a 3 x 3 mesh, ends of lines given."""
    s, w = np.polynomial.legendre.leggauss(n)
    (x0, x1), (y0, y1) = PLATE.bounds

    def along(cuts):
        cuts = np.sort(cuts)
        steps = np.diff(cuts)
        return (cuts[:-1, None] + np.outer(steps, (s + 1) / 2)).ravel(), np.outer(steps, w / 2).ravel()

    if isinstance(load, sk.SurfaceLoad):
        (x, wx), (y, wy) = along(np.linspace(x0, x1, 4)), along(np.linspace(y0, y1, 4))
        return np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2), np.outer(wx, wy).ravel()
    if isinstance(load, sk.PointForce):
        return np.array([load.at]), np.ones(1)
    start, end = ((x1, y0), (x1, y1)) if isinstance(load, sk.EdgeLoad) else (load.start, load.end)
    start, run = np.array(start), np.subtract(end, start)
    lines = [(np.linspace(*bounds, 4) - a) / b for bounds, a, b in zip(PLATE.bounds, start, run, strict=True) if b]
    cuts = np.concatenate([[0.0, 1.0], *[t[(t > 0) & (t < 1)] for t in lines]])
    t, w = along(cuts)
    return start + np.outer(t, run), w * np.linalg.norm(run)


VARYING = sk.SurfaceLoad(lambda x, y: np.stack([x * y, 1 + x, y - x]))
WORKING = [VARYING, sk.EdgeLoad("right", lambda x, y: np.stack([y, 1 + 0 * x, y * y])), LOADS["point"][0],
           sk.LineLoad((0.7, -0.1), (1.9, 0.4), lambda x, y: np.stack([x, y, x - y])), LOADS["line"][0]]  # fmt: skip


@theories
@pytest.mark.parametrize("load", WORKING, ids=lambda load: type(load).__name__)
def test_nodal_forces_do_the_work_of_the_load(load, theory, rng):
    system = system_with([], [load], PLATE, n=3, theory=theory)
    change = rng.normal(size=system.n_dofs)
    at, weights = points_on(load)
    u = sk.Solution(system, system.undeformed + change).displacement(at)
    f = load.force(*at.T).T if callable(load.force) else np.broadcast_to(load.force, u.shape)
    work = weights @ (f * u).sum(axis=1)
    assert np.isclose(system.external_force(system.undeformed) @ change, work, rtol=1e-11)
    assert not np.isclose(weights @ (f * u)[:, :2].sum(axis=1), work, rtol=1e-3)


@theories
def test_a_line_on_an_edge_is_the_edge(theory):
    forces = [system_with([], [load], PLATE, n=3, theory=theory) for load in (
        sk.EdgeLoad("right", FORCE), sk.LineLoad((2.5, 0.7), (2.5, -0.3), FORCE))]  # fmt: skip
    edge, line = (system.external_force(system.undeformed) for system in forces)
    assert np.abs(edge - line).max() < SUMS


@theories
def test_edge_moment_is_a_moment(theory):
    moment = np.array([0.3, -0.7, 0.0])
    system = system_with([], [sk.EdgeMoment("right", moment)], PLATE, n=3, theory=theory)
    force, total = virtual_work(system, system.external_force(system.undeformed))
    assert np.abs(force).max() < SUMS and np.allclose(total, moment, atol=SUMS)
    # It turns with the normal: in a state turned by a right angle about y the same moment, other forces.
    turned = system.undeformed.reshape(-1, 4, 3) @ np.array([[0, 0, 1.0], [0, 1, 0], [-1, 0, 0]])
    forces = system.external_force(turned.ravel()).reshape(-1, 4, 3)
    assert np.isclose(np.cross(turned, forces).sum(axis=(0, 1))[1], moment[1], atol=SUMS)


def test_stiffness_of_an_edge_moment(rng):
    """The symmetric part of the derivative of the residual, and all of it while the strip bends in its plane."""
    system = system_with([], [sk.EdgeMoment("right", (0.0, -300.0, 0.0))], n=1)
    planar = system.undeformed.reshape(-1, 4, 3).copy()
    planar[:, :, [0, 2]] += 0.1 * rng.normal(size=(4, 4, 2))
    spatial = planar + 0.1 * rng.normal(size=planar.shape)

    def residual(q):
        return system.internal_force(q) - system.external_force(q)

    for state, symmetric in ((planar, True), (spatial, False)):
        q, eps = state.ravel(), 1e-5
        numeric = np.array([residual(q + e) - residual(q - e) for e in eps * np.eye(system.n_dofs)]).T / (2 * eps)
        tangent = system.tangent(q).to_scipy().toarray()
        within = np.tile([True, False, True], system.n_dofs // 3)
        # Differences of a cubic: eps^2, and rounding over eps, against the stiffness of membranes.
        close = 1e-8 * np.abs(tangent).max()
        assert np.abs(tangent - (numeric + numeric.T) / 2).max() < close
        if symmetric:
            assert np.abs((tangent - numeric)[np.ix_(within, within)]).max() < close
        assert (np.abs(numeric - numeric.T)[np.ix_(within, within)].max() < close) == symmetric


def test_load_that_varies_over_the_surface():
    system = system_with([], [sk.SurfaceLoad(lambda x, y: (0 * x, 0 * x, x * y))], UNIT, n=3)
    force, moment = virtual_work(system, system.external_force(system.undeformed))
    assert np.allclose(force, [0, 0, 1 / 4], atol=SUMS) and np.allclose(moment, [1 / 6, -1 / 6, 0], atol=SUMS)


def test_loads_on_a_sector():
    sector = sk.AnnulusSector(0.5, 1.0, 1.0)
    up = (0, 0, 1.0)
    loads = [(0.375, sk.SurfaceLoad(up)), (1.0, sk.EdgeLoad("outer", up)), (0.5, sk.EdgeLoad("end", up))]
    for expected, load in loads:
        found = [system_with([], [load], sector, n=n) for n in (4, 8)]
        error = [abs(virtual_work(s, s.external_force(s.undeformed))[0][2] / expected - 1) for s in found]
        # The arc is made of cubics: order 4, or straight edges: exact.
        assert error[1] < SUMS or (error[1] < 1e-6 and error[0] / error[1] > 12)


def test_reactions_balance_the_loads():
    loads = [HEAVY, sk.EdgeLoad("right", (30.0, 20.0, 0)), sk.PointForce((0.61, 0.37), (0, 0, 100.0))]
    total = np.array([30.0, 20.0, 2100.0])
    system = system_with([sk.Clamp("left"), sk.Roller("right")], loads, n=4)
    for factor in (1.0, 0.5):
        solution = sk.solve(system, load_factor=factor, rtol=1e-10).unwrap()
        assert np.abs(solution.reactions() + factor * total).max() < 1e-9 * total.max()
        parts = solution.reactions("left") + solution.reactions("right")
        assert np.allclose(parts, solution.reactions(), rtol=0, atol=1e-9)


@pytest.mark.parametrize("load", [1e-3, 2000.0])
def test_reactions_of_the_linear_answer_balance_the_load(load):
    system = system_with([sk.Clamp("left"), sk.Roller("right")], [sk.SurfaceLoad((0, 0, load))], n=4)
    solution = sk.solve_linear(system)
    assert np.abs(solution.displacements).max() < 1.2 * 0.1 * load / 2000.0  # at 2000 Pa about the thickness
    # Rounding of the membrane stiffness 1e5 N/m is 1e-11 N; a linear answer has no other error.
    assert np.allclose(solution.reactions(), [0, 0, -load], rtol=0, atol=1e-8 * load + 1e-9)


# --- free motions ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("supports,message", [
    ([], "translation along x.*translation along z.*rotation about x.*rotation about z"),
    ([sk.Pin((0.5, 0.5))], "leave free rotation about x, rotation about y, rotation about z;"),
    ([sk.Pin((0.0, 0.0))], r"leave free rotation about the line .*, rotation .*, rotation .*through \(0, 0, 0\)"),
    ([sk.Pin([(0.0, 0.5), (1.0, 0.5)])], "leave free rotation about x;"),
    ([sk.Pin([(0.0, 0.0), (1.0, 1.0)])], r"free rotation about the line .*0.5, 0.5, 0.* along \(0.7071, 0.7071, 0\);"),
    ([sk.Roller("boundary")], "leave free translation along x, translation along y, rotation about z;"),
    ([sk.SimpleSupport("left")], r"leave free rotation about the line through \(0, 0.5, 0\) along \(0, -?1, 0\);"),
], ids=["nothing", "point", "corner", "line", "diagonal", "roller", "hinge"])  # fmt: skip
def test_free_motions_are_named(supports, message):
    for solve in (sk.solve, sk.solve_linear):
        with pytest.raises(InputError, match=message):
            solve(system_with(supports, [HEAVY]))


# --- mistakes --------------------------------------------------------------------------------------------------------

NAN = float("nan")
BOWTIE = skfem.MeshQuad(np.array([[0.0, 1, 1, 0], [0, 0, 1, 1]]), np.array([[0], [2], [1], [3]]), sort_t=False)


def test_names_and_points_can_be_mixed():
    system = system_with([sk.Pin(["left", (1.0, 0.5)])])
    held = np.flatnonzero(system.constraints.fixed[:, :3].all(axis=1))
    assert set(held) == {*system.geometry.nodes_on("left"), *system.geometry.nodes_on((1.0, 0.5))}


MISTAKES = {
    "empty place": (lambda: system_with([sk.Clamp([])]), r"place \[\]: give the name"),
    "number as a place": (lambda: system_with([sk.Clamp(5)]), "place 5: give the name"),
    "two components": (lambda: system_with([], [sk.SurfaceLoad(lambda x, y: (x, y))]), "must return three components"),
    "not a support": (lambda: system_with([None]), "supports: None is not a support"),
    "no displacement": (lambda: sk.Prescribed("left", None), "give three entries"),
    "no material": (lambda: sk.Problem(sk.Rectangle(1.0, 1.0), 0.1, None), "material = None: give a law"),
    "one thickness point": (lambda: sk.Full(n_thickness=0), "n_thickness = 0"),
    "depth": (lambda: sk.solve_linear(system_with([sk.Clamp("left")])).position((1, 0.5), z=5), "outside the plate"),
    "unknown name": (lambda: system_with([sk.Clamp("lefft")]), "no boundary 'lefft'.*'bottom'.*'left'"),
    "unknown name of a load": (lambda: system_with([], [sk.EdgeLoad("lefft", FORCE)]), "no boundary 'lefft'"),
    "no edge": (lambda: system_with([], [sk.EdgeLoad((0.0, 0.0), FORCE)]), "no edge of the boundary"),
    "no node": (lambda: system_with([sk.Pin((0.3, 0.5))]), r"point \(0\.3, 0\.5\): no node.*nearest.*\(0\.5, 0\.5\)"),
    "nowhere true": (lambda: system_with([sk.Pin(lambda x, y: x > 2)]), "true at no node"),
    "point outside": (lambda: system_with([], [sk.PointForce((1.5, 0.5), FORCE)]), r"point \(1\.5, 0\.5\) lies out"),
    "disk outside": (lambda: system_with([], [sk.DiskForce((0.95, 0.5), 0.1, FORCE)]), "reaches over the edge"),
    "symmetry at a point": (lambda: system_with([sk.Symmetry((0.0, 0.0))]), "needs an edge"),
    "kind": (lambda: sk.SimpleSupport("left", kind="medium"), "'soft'.*'hard'"),
    "no direction": (lambda: sk.Roller("left", (0, 0, 0)), "needs a direction"),
    "nan direction": (lambda: sk.Roller("left", (0, NAN, 0)), "direction"),
    "two entries": (lambda: sk.Prescribed("left", (0.0, 1.0)), "three entries"),
    "nan displacement": (lambda: sk.Prescribed("left", (NAN, None, None)), "displacement.*finite"),
    "nan surface load": (lambda: sk.SurfaceLoad((0, 0, NAN)), "force.*finite"),
    "nan from a function": (lambda: system_with([], [sk.SurfaceLoad(lambda x, y: (x, x, NAN * x))]), "force.*finite"),
    "nan edge load": (lambda: sk.EdgeLoad("left", (0, NAN, 0)), "force.*finite"),
    "nan moment": (lambda: sk.EdgeMoment("left", (0, NAN, 0)), "moment.*finite"),
    "nan point": (lambda: sk.PointForce((NAN, 0), FORCE), r"at\[0\].*finite"),
    "nan gravity": (lambda: sk.Gravity((0, 0, NAN)), "acceleration.*finite"),
    "radius": (lambda: sk.DiskForce((0.5, 0.5), 0.0, FORCE), "radius = 0.0 m"),
    "thickness": (lambda: system_with(thickness=0.0), "thickness = 0.0 m.*greater than zero"),
    "nan thickness": (lambda: system_with(thickness=NAN), "thickness"),
    "no list": (lambda: sk.Problem(UNIT, 0.1, MATERIAL, sk.Clamp("left")), "supports: give a list"),
    "theory": (lambda: sk.Problem(UNIT, 0.1, MATERIAL).on(sk.meshes.uniform(UNIT, 1, 1), "ful"), "unknown.*full"),
    "mesh outside": (lambda: system_with(mesh=skfem.MeshQuad().scaled(2.0)), "outside the surface"),
    "inverted quad": (lambda: system_with(surface=sk.Plane(), mesh=BOWTIE), "element 0 with corners"),
    "line without length": (lambda: sk.LineLoad((0.1, 0.2), (0.1, 0.2), FORCE), "two different ends"),
    "line outside": (lambda: system_with([], [sk.LineLoad((0.5, 0.5), (1.5, 0.5), FORCE)]), "lies outside the surface"),
    "nan line": (lambda: sk.LineLoad((0, NAN), (1, 1), FORCE), "start.*finite"),
    "pressure": (lambda: sk.FollowerPressure(NAN), "pressure.*finite"),
    "pressure vector": (lambda: sk.FollowerPressure((0, 0, 1.0)), "pressure.*give one number"),
    "history": (lambda: sk.FollowerPressure(1.0, history=2.0), "history"),
    "temperature": (lambda: sk.Temperature((1.0, 2.0)), "change.*one number or a function"),
    "nan gradient": (lambda: sk.Temperature(0.0, NAN), "gradient.*finite"),
    "temperature shape": (lambda: system_with([], [sk.Temperature(lambda x, y: np.ones(7))]), "must return"),
    "negative spring": (lambda: sk.Spring("left", (0, -1.0, 0)), "not negative"),
    "no spring": (lambda: sk.Spring("left", (0, 0, 0)), "one of them is positive"),
    "two stiffnesses": (lambda: sk.Spring("left", (1.0, 2.0)), "stiffness.*give 3 numbers"),
    "unknown edge of a spring": (lambda: system_with([sk.Spring("lefft", (1.0, 1, 1))]), "no boundary 'lefft'"),
    "foundation": (lambda: sk.Foundation(0.0), "stiffness = 0.0 N/m3.*greater than zero"),
    "foundation without direction": (lambda: sk.Foundation(1.0, (0, 0, 0)), "direction in which it pushes"),
    "flat foundation direction": (lambda: sk.Foundation(1.0, (0, 1.0)), "direction"),
    "load factor": (lambda: sk.solve(system_with([sk.Clamp("left")]), load_factor=NAN), "load_factor"),
}


@pytest.mark.parametrize("case", MISTAKES)
def test_mistakes_are_named(case):
    make, message = MISTAKES[case]
    with pytest.raises(InputError, match="(?s)" + message):
        make()


def test_a_hard_roller_in_the_surface_is_refused_where_the_normal_follows_the_edge():
    """It would hold the slope of the edge at nodes alone, and less on finer meshes."""
    problem = sk.Problem(sk.Rectangle(2.0, 1.0), 0.02, sk.Isotropic(1e9, 0.3, 1.0),
                         [sk.Clamp("left"), sk.Roller("top", (1.0, 0.0, 0.0), kind="hard")])  # fmt: skip
    mesh = sk.meshes.uniform(problem.surface, 4, 2)
    with pytest.raises(sk.InputError, match=r"kind='hard'.*hold the deflection too"):
        problem.on(mesh, "kirchhoff")
    assert problem.on(mesh, "full").n_dofs
    upright = sk.Problem(problem.surface, 0.02, problem.material, [sk.Clamp("left"), sk.Roller("top", kind="hard")])
    assert upright.on(mesh, "kirchhoff").n_dofs


def test_a_hard_roller_askew_to_the_surface_comes_with_a_warning_that_points_here():
    flat, roof = sk.Rectangle(1.0, 1.5), sk.CylinderSector(2.0, 1.0, 1.4, -0.7)
    for surface, direction, askew in (
        (flat, (2.0, 1.0, -1.0), True), (flat, (0.1, 0.0, -1.0), False), (roof, (1.0, 0.6, 0.6), True),
        (roof, (0, 1.0, 0), False),
    ):  # fmt: skip
        sides = [surface.sides[0], surface.sides[1]]
        problem = sk.Problem(surface, 0.1, MATERIAL, [sk.Roller(sides, direction, kind="hard")])
        mesh = sk.meshes.uniform(surface, 2, 4)
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            problem.on(mesh, "full")
            problem.on(mesh, "kirchhoff")
        assert [w.category for w in said] == ([sk.OutOfDepth] if askew else [])
        assert all(w.filename == __file__ and "askew" in str(w.message) for w in said)


def test_the_answer_with_such_a_roller_depends_on_the_mesh():
    """So that the warning is worth its words: with more nodes, and conforming functions, it gets stiffer."""
    surface, found = sk.Rectangle(1.3, 1.3), []
    for n in (2, 4, 8):
        supports = [sk.Clamp("left"), sk.Roller("boundary", (1.0, -2.0, 0.5), kind="hard")]
        problem = sk.Problem(surface, 0.26, MATERIAL, supports, [sk.PointForce((0.65, 0.65), (0.0, 0.0, 50.0))])
        with pytest.warns(sk.OutOfDepth):
            system = problem.on(sk.meshes.uniform(surface, n, n), sk.Kirchhoff(assumed=False))
            found.append(sk.solve_linear(system).strain_energy)
    assert found[2] < 0.9 * found[1] < 0.81 * found[0]


# ----------------------------------------------------------------------------------------------- points in a row on an edge

HOLDERS = [
    sk.Pin, sk.Clamp, sk.SimpleSupport, sk.Roller, lambda where: sk.Prescribed(where, (None, None, 0.01)),
]  # fmt: skip


@pytest.mark.parametrize("kind", HOLDERS)
@pytest.mark.parametrize("theory", ["full", "kirchhoff"])
def test_points_in_a_row_do_not_hold_the_edge(kind, theory):
    surface = sk.CylinderSector(1.0, 2.0, 1.5)
    mesh = sk.meshes.uniform(surface, 4, 3)
    row = [(2.0, 0.0), (2.0, 1.0), (2.0, 0.5)]  # neighbours, in any order
    problem = sk.Problem(surface, 0.02, sk.Isotropic(1e7, 0.3, 1e3), [kind(row)])
    with pytest.warns(sk.OutOfDepth, match=r"where.*three or more.*\(2, 0.5\).*give its name, or a function") as raised:
        problem.on(mesh, theory)
    assert raised[0].filename == __file__, "it points to the line of the user"


@pytest.mark.parametrize("where", [
    "corners", [(0.0, 0.0), (3.0, 0.0), (0.0, 2.0), (3.0, 2.0)], [(0.0, 0.0), (1.0, 0.0)], (1.0, 0.0),
    [(0.0, 0.0), (2.0, 0.0), (3.0, 1.0)], [(1.0, 1.0), (2.0, 1.0), (1.0, 0.0)], [(1.0, 0.0), (0.0, 0.0), (0.0, 1.0)],
    "bottom", lambda x, y: y < 1e-9, ["bottom", (0.0, 1.0), (0.0, 2.0)],
])  # fmt: skip
def test_other_points_and_edges_do_not_warn(where):
    surface = sk.Rectangle(3.0, 2.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sk.Problem(surface, 0.05, sk.Isotropic(1e7, 0.3, 1e3), [sk.Pin(where)]).on(sk.meshes.uniform(surface, 3, 2))


WIDE = [
    (sk.Pin, "full"), (sk.NoRotation, "kirchhoff"), (lambda w: sk.Prescribed(w, (None, None, lambda x, y: y)), "full"),
    (lambda w: sk.EdgeLoad(w, (0.0, 0.0, 1.0)), "kirchhoff"), (lambda w: sk.EdgeMoment(w, (0.0, 1.0, 0.0)), "full"),
]  # fmt: skip


@pytest.mark.parametrize(("kind", "theory"), WIDE)
def test_a_function_with_a_wide_tolerance_is_told(kind, theory):
    surface = sk.CylinderSector(1.0, 2.0, 1.5)
    mesh = sk.meshes.uniform(surface, 4, 3, openings=[((1.0, 1.5), (0.5, 1.0))])

    def made(where):
        item = kind(where)
        part = {"supports": [item]} if hasattr(item, "rows") else {"loads": [item]}
        return sk.Problem(surface, 0.02, sk.Isotropic(1e7, 0.3, 1e3), **part).on(mesh, theory)

    with pytest.warns(sk.OutOfDepth, match=r"3 edges of the boundary and at 2 nodes inside.*\(0\.5, 0\.5\)") as told:
        made(lambda x, y: (x < 0.6) & (y > 0.4))
    assert len(told) == 1 and told[0].filename == __file__
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        made(lambda x, y: x < 1e-9)
        made("openings")
        if "supports" in kind("left").__module__:
            made(lambda x, y: x > -1.0)  # everywhere is no accident, and neither is a patch inside
            made(lambda x, y: (abs(x - 1.5) < 0.6) & (abs(y - 0.75) < 0.3) & (x > 1.6))


def test_points_around_an_opening_and_across_a_seam_are_in_a_row():
    tube, plate = sk.CylinderSector(1.0, 2.0, 2 * math.pi, closed=True), sk.Rectangle(4.0, 4.0)
    for surface, mesh, where in (
        (tube, sk.meshes.uniform(tube, 2, 16), [(0.0, k * math.pi / 8) for k in (15, 0, 1)]),
        (plate, sk.meshes.uniform(plate, 8, 8, openings=[((1, 3), (1, 3))]), [(1.0, 1.0), (1.5, 1.0), (2.0, 1.0)]),
    ):
        with pytest.warns(sk.OutOfDepth, match="neighbours along one edge"):
            sk.Problem(surface, 0.02, sk.Isotropic(1e7, 0.3, 1e3), [sk.Roller(where)]).on(mesh)
