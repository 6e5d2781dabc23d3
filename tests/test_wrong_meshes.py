"""Meshes and surfaces that would give right answers to another problem are refused, and right ones are not."""

import warnings
from math import pi

import numpy as np
import pytest
import skfem

import skancf as sk
from skancf.errors import InputError
from skancf.layout.geometry import Geometry
from skancf.meshes import check_mesh, graded, quadtree, tensor, uniform
from skancf.meshes.snap import onto_bounds
from skancf.theories import theory_named

PLATE = sk.Rectangle(2.0, 1.0, origin=(-0.5, 3.0))
RING = sk.AnnulusSector(1.0, 2.0, angle=2 * pi, closed=True)
TUBE = sk.CylinderSector(1.0, 2.0, 2 * pi, closed=True)
BALL = sk.SphereSector(1.0, (0.0, pi), 2 * pi, closed=True)
HOLE = [((0.0, 0.5), (3.25, 3.5))]

MESHES = {
    "uniform": (PLATE, uniform(PLATE, 8, 4)),
    "tensor": (PLATE, tensor(PLATE, [-0.5, -0.49, 0.1, 0.2, 1.1, 1.5], [3.0, 3.3, 3.35, 3.8, 4.0])),
    "graded": (PLATE, graded(PLATE, [sk.meshes.Region((0.3, 3.3), (0.1, 0.1), 4.0)], nodes=200)),
    "ring": (RING, uniform(RING, 4, 12)),
    "tube": (TUBE, uniform(TUBE, 4, 8)),
    "ball": (BALL, uniform(BALL, 8, 6)),
    "openings": (PLATE, uniform(PLATE, 8, 4, openings=HOLE)),
}
families = pytest.mark.parametrize("family", MESHES)


def put(surface, mesh):
    return Geometry(mesh, surface, theory_named("full"))


def plain(family):
    surface, mesh = MESHES[family]
    return surface, skfem.MeshQuad(mesh.p, mesh.t, sort_t=False)


def inner_element(mesh):
    """One without nodes of the boundary, where there is such, else the one in the middle."""
    free = ~np.isin(mesh.t, mesh.boundary_nodes()).any(axis=0)
    return int(np.argmax(free)) if free.any() else mesh.nelements // 2


def made(mesh, p=None, t=None):
    return skfem.MeshQuad(mesh.p if p is None else p, mesh.t if t is None else t, sort_t=False)


@families
def test_right_meshes_are_accepted_however_they_are_numbered(family, rng):
    surface, mesh = MESHES[family]
    put(surface, mesh)
    order, nodes = rng.permutation(mesh.nelements), rng.permutation(mesh.p.shape[1])
    p = np.empty_like(mesh.p)
    p[:, nodes] = mesh.p
    t = nodes[mesh.t[:, order]]
    for corners in (t, np.roll(t, 1, axis=0), t[::-1], np.where(np.arange(len(order)) % 2, t, t[::-1])):
        check_mesh(made(mesh, p, corners))


def test_right_quadtrees_are_accepted():
    for family in ("uniform", "ring", "tube", "ball", "openings"):
        surface, mesh = MESHES[family]
        tree = quadtree(mesh, surface).refined([0, 5]).refined([3])
        assert len(tree.hanging)
        put(surface, tree)


def test_holes_and_notches_of_any_outline_are_accepted():
    mesh = uniform(PLATE, 8, 8)
    middle = mesh.p[:, mesh.t].mean(axis=1)
    for hole in (np.hypot(middle[0] - 0.5, middle[1] - 3.5) < 0.3, (abs(middle - [[0.5], [3.5]]) < 0.2).all(axis=0)):
        assert hole.any()
        put(PLATE, mesh.restrict(np.flatnonzero(~hole)))
    put(PLATE, uniform(PLATE, 8, 4, openings=[((-0.5, 0.0), (3.25, 3.5)), ((1.0, 1.5), (3.75, 4.0))]))
    # A surface without bounds has no size of its own.
    put(sk.Plane(), mesh.restrict(np.flatnonzero(middle[0] + middle[1] < 3.8)))


@families
@pytest.mark.parametrize("turn", ["same", "rolled", "mirrored"])
def test_an_element_twice(family, turn):
    surface, mesh = plain(family)
    for k in (inner_element(mesh), 0, mesh.nelements - 1):
        again = {"same": mesh.t[:, k], "rolled": np.roll(mesh.t[:, k], 1), "mirrored": mesh.t[::-1, k]}[turn]
        with pytest.raises(InputError, match=f"elements {k} and {mesh.nelements} .*twice"):
            put(surface, made(mesh, t=np.column_stack([mesh.t, again])))


@families
def test_an_element_twice_with_nodes_of_its_own(family):
    surface, mesh = plain(family)
    for k in (inner_element(mesh), 0):
        p = np.column_stack([mesh.p, mesh.p[:, mesh.t[:, k]]])
        t = np.column_stack([mesh.t, np.arange(4) + mesh.p.shape[1]])
        with pytest.raises(InputError, match="overlap"):
            put(surface, made(mesh, p, t))


def test_a_large_element_over_small_ones():
    mesh = uniform(PLATE, 8, 4)

    def node(x, y):
        return np.argmin(np.hypot(mesh.p[0] - x, mesh.p[1] - y))

    for low, high in (((0.0, 3.25), (0.5, 3.75)), ((-0.5, 3.0), (0.0, 3.5)), ((-0.5, 3.0), (1.5, 4.0))):
        large = [node(*low), node(high[0], low[1]), node(*high), node(low[0], high[1])]
        with pytest.raises(InputError, match="overlap"):
            put(PLATE, made(mesh, t=np.column_stack([mesh.t, large])))
        with pytest.raises(InputError, match="overlap"):
            check_mesh(made(mesh, t=np.column_stack([mesh.t, large])))


@families
def test_an_element_that_partly_overlaps_others(family):
    surface, mesh = plain(family)
    k = inner_element(mesh)
    corners = mesh.p[:, mesh.t[:, k]]
    p = np.column_stack([mesh.p, corners + 0.3 * np.ptp(corners, axis=1, keepdims=True)])
    with pytest.raises(InputError, match="overlap"):
        put(surface, made(mesh, p, np.column_stack([mesh.t, np.arange(4) + mesh.p.shape[1]])))


@families
def test_folded_elements(family):
    """A node beyond its neighbours turns elements over, or makes them not convex; exchanged corners make a bow-tie."""
    surface, mesh = plain(family)
    k = inner_element(mesh)
    across = mesh.p[:, mesh.t[2, k]] - mesh.p[:, mesh.t[0, k]]
    p, t = mesh.p.copy(), mesh.t.copy()
    p[:, t[0, k]] += 0.8 * across
    t[:, k] = t[[0, 2, 1, 3], k]
    flat = mesh.p.copy()
    flat[:, mesh.t[0, k]] = flat[:, mesh.t[1, k]]
    for wrong in (made(mesh, p), made(mesh, t=t), made(mesh, flat)):
        with pytest.raises(InputError, match="not convex quads"):
            put(surface, wrong)


@families
@pytest.mark.parametrize("gap", [0.0, 1e-12, 3e-10])
def test_a_slit_of_nodes_at_one_place(family, gap):
    surface, mesh = plain(family)
    # Along the mesh line nearest to the middle, over a part of it or from end to end.
    lines = np.unique(mesh.p[0])
    line = lines[len(lines) // 2]
    right = mesh.p[0, mesh.t].mean(axis=0) > line
    on = np.flatnonzero(mesh.p[0] == line)
    for some in (on, on[np.argsort(mesh.p[1, on])][1:-1], on[:2]):
        p = np.column_stack([mesh.p, mesh.p[:, some] + [[gap * np.ptp(mesh.p[0])], [0.0]]])
        number = np.arange(mesh.p.shape[1])
        number[some] = mesh.p.shape[1] + np.arange(len(some))
        t = np.where(right, number[mesh.t], mesh.t)
        with pytest.raises(InputError, match=r"both at \(.*merge them.*openings="):
            put(surface, made(mesh, p, t))


@families
def test_unused_nodes(family):
    surface, mesh = plain(family)
    with pytest.raises(InputError, match="belong to no element"):
        put(surface, made(mesh, np.column_stack([mesh.p, mesh.p.mean(axis=1)])))


@families
@pytest.mark.parametrize("axis", [0, 1])
def test_a_part_of_the_surface(family, axis):
    surface, mesh = plain(family)
    middle = mesh.p[axis, mesh.t].mean(axis=0)
    for keep in (middle < np.median(middle), middle > middle.min() * (1 + 1e-9 * np.sign(middle.min()))):
        part = mesh.restrict(np.flatnonzero(keep))
        check_mesh(part)
        with pytest.raises(InputError, match=r"covers [\d.]+ % of the surface.*openings="):
            put(surface, part)


def test_the_share_that_is_covered_is_named_and_a_notch_is_an_opening_by_name():
    mesh = uniform(PLATE, 8, 4)
    with pytest.raises(InputError, match="covers 50 %"):
        put(PLATE, mesh.restrict(np.flatnonzero(mesh.p[0, mesh.t].mean(axis=0) < 0.5)))
    with pytest.raises(InputError, match="covers 50 %"):
        put(PLATE, quadtree(uniform(sk.Rectangle(1.0, 1.0, origin=(-0.5, 3.0)), 4, 4)).refined([1]))
    middle = mesh.p[:, mesh.t].mean(axis=1)
    notch = mesh.restrict(np.flatnonzero((middle[0] < 1.0) | (middle[1] < 3.5)))
    with pytest.raises(InputError, match=r"covers 87\.5 %"):
        put(PLATE, notch)
    put(PLATE, notch.with_boundaries({"opening": lambda x: (x[0] > 0.99) & (x[1] > 3.49)}))


def test_pieces_and_hinges():
    mesh = uniform(PLATE, 8, 4)
    middle = mesh.p[:, mesh.t].mean(axis=1)
    apart = mesh.restrict(np.flatnonzero((middle[0] < 0) | (middle[0] > 1)))
    one = np.flatnonzero((middle[0] < 0.5) & (middle[1] < 3.5) | (middle[0] > 0.5) & (middle[1] > 3.5))
    corner = mesh.restrict(one)
    bridge = mesh.restrict(np.union1d(one, np.flatnonzero((middle[1] < 3.25) | (middle[0] > 1.25))))
    for surface in (PLATE, sk.Plane()):
        for wrong in (apart, corner):
            with pytest.raises(InputError, match="2 pieces without a common edge"):
                put(surface, wrong)
        with pytest.raises(InputError, match="a hinge"):
            put(surface, bridge)


def test_a_strip_that_winds_over_itself():
    """Every edge and node is right, and the middle is covered twice."""
    angle = np.linspace(0, 2.3 * pi, 40)
    p = np.concatenate([r * np.stack([np.cos(angle), np.sin(angle)]) for r in (1.0, 2.0)], axis=1)
    p *= 1 + 0.05 * np.tile(angle, 2)
    k = np.arange(39)
    with pytest.raises(InputError, match="overlap"):
        put(sk.Plane(), skfem.MeshQuad(p, np.stack([k, k + 1, k + 41, k + 40])))
    k = np.arange(30)
    put(sk.Plane(), skfem.MeshQuad(p, np.stack([k, k + 1, k + 41, k + 40])).remove_unused_nodes())


# --- nodes beside the bounds -----------------------------------------------------------------------------------------


@families
def test_single_precision_lies_on_the_bounds(family):
    surface, mesh = MESHES[family]
    for p in (mesh.p.astype(np.float32), mesh.p.astype(np.float32).astype(float)):
        moved = onto_bounds(skfem.MeshQuad(p, mesh.t, sort_t=False), surface.bounds)
        for axis, bounds in enumerate(surface.bounds):
            for bound in bounds:
                assert ((moved.p[axis] == bound) == (np.abs(mesh.p[axis] - bound) < 1e-9)).all()
        ours, theirs = put(surface, moved), put(surface, mesh)
        assert len(ours.ties.poles) == len(theirs.ties.poles)
        assert ours.n_nodes == theirs.n_nodes


def test_names_are_kept_and_far_or_fine_nodes_are_not_moved():
    mesh = uniform(PLATE, 4, 2)
    p = mesh.p + 3e-8
    moved = onto_bounds(skfem.MeshQuad(p, mesh.t, _boundaries=mesh.boundaries), PLATE.bounds)
    assert moved.boundaries.keys() == mesh.boundaries.keys()
    assert onto_bounds(mesh, PLATE.bounds) is mesh
    with pytest.raises(InputError, match="outside the surface"):
        onto_bounds(skfem.MeshQuad(mesh.p + 3e-6, mesh.t), PLATE.bounds)
    thin = tensor(PLATE, [-0.5, -0.5 + 1e-7, 1.5], [3.0, 4.0])
    assert onto_bounds(thin, PLATE.bounds) is thin


def test_a_quadtree_of_single_precision():
    mesh = uniform(RING, 3, 7)
    tree = quadtree(skfem.MeshQuad(mesh.p.astype(np.float32), mesh.t), RING).refined([2])
    assert put(RING, tree).n_nodes < tree.p.shape[1]
    blind = quadtree(skfem.MeshQuad((mesh.p * (1 + 4e-8)).astype(np.float32), mesh.t))
    plate = sk.Problem(RING, 0.01, sk.Isotropic(1e5, 0.3, 1.0))
    with pytest.raises(InputError, match=r"outside the surface.*quadtree\(mesh, surface\)"):
        plate.on(blind)


def test_what_to_do_with_a_mesh_that_cannot_be_adapted():
    mesh = uniform(PLATE, 4, 4)
    p = mesh.p.copy()
    p[:, np.setdiff1d(np.arange(p.shape[1]), mesh.boundary_nodes())] += 0.05
    law, load = sk.Isotropic(1e5, 0.3, 1.0), sk.SurfaceLoad((0, 0, 1.0))
    plate = sk.Problem(PLATE, 0.05, law, [sk.SimpleSupport("boundary")], [load])
    wrong = made(mesh, p)
    with pytest.raises(InputError, match=r"a quadtree.* needs sides along x and y.*without adapting") as told:
        sk.adapt(plate, sk.Displacement(at=(0.5, 3.5)), mesh=wrong, theory="full")
    assert "or take theory" not in str(told.value)
    plate.on(wrong, theory="full")


@pytest.mark.parametrize("origin", [(0.0, 0.0), (123.4, -17.3), (1234.567, 4321.4)])
@pytest.mark.parametrize("unit", [1e-9, 1.0, 1e6])
def test_single_precision_far_from_the_origin(origin, unit):
    """Nodes are beside the bounds by more than a millionth of the range, and beside their lines if it also computes."""
    plate = sk.Rectangle(5.0 * unit, 3.0 * unit, origin=(origin[0] * unit, origin[1] * unit))
    mesh, rng = uniform(plate, 4, 3), np.random.default_rng(5)
    off = np.float32(1) + rng.choice([-1, 0, 1], mesh.p.shape).astype(np.float32) * np.float32(2.0**-23)
    problem = sk.Problem(plate, 0.1 * unit, sk.Isotropic(1e5, 0.3, 1.0))
    for p in (mesh.p.astype(np.float32), mesh.p.astype(np.float32) * off):
        rough = skfem.MeshQuad(p, mesh.t, sort_t=False, _boundaries=mesh.boundaries)
        for system in (problem.on(rough), problem.on(rough, "kirchhoff"), problem.on(quadtree(rough, plate).refined([1]))):
            for axis, bounds in enumerate(plate.bounds):
                assert (system.mesh.p[axis].min(), system.mesh.p[axis].max()) == bounds
        for axis in (0, 1):
            assert len(np.unique(problem.on(rough, "kirchhoff").mesh.p[axis])) == (5, 4)[axis]


@pytest.mark.parametrize("theory", ["full", "kirchhoff"])
def test_points_mean_the_nodes_that_single_precision_moved(theory):
    plate = sk.Rectangle(1.0, 0.7, origin=(40.1, -0.3))
    mesh = uniform(plate, 7, 3)
    rough = skfem.MeshQuad(mesh.p.astype(np.float32), mesh.t, sort_t=False)
    problem = sk.Problem(plate, 0.1, sk.Isotropic(1e5, 0.3, 1.0))
    geometry = problem.on(rough, theory).geometry
    for node, point in enumerate(mesh.p.T):
        assert geometry.node_at(point) == geometry.ties.node_of[node]
    for off in (1e-3, 1e-4):
        with pytest.raises(InputError, match="no node of the mesh is there"):
            geometry.node_at(mesh.p[:, 9] + off)
    # Not where nodes are that close together.
    fine = problem.on(tensor(plate, [40.1, 40.1 + 1e-7, 41.1], [-0.3, 0.4])).geometry
    with pytest.raises(InputError, match="no node of the mesh is there"):
        fine.node_at((40.1 + 5e-8, -0.3))


def test_what_is_askew_by_more_than_rounding_is_left_and_named():
    plate = sk.Problem(PLATE, 0.1, sk.Isotropic(1e5, 0.3, 1.0))
    mesh = uniform(PLATE, 4, 4)
    inner = np.setdiff1d(np.arange(mesh.p.shape[1]), mesh.boundary_nodes())
    for off in (1e-5, 0.02):
        p = mesh.p.copy()
        p[:, inner[1]] += off
        askew = made(mesh, p)
        assert plate.on(askew).mesh is askew
        with pytest.raises(InputError, match="no aligned rectangles"):
            plate.on(askew, "kirchhoff")
    assert plate.on(mesh, "kirchhoff").mesh is mesh
    # A mesh whose elements are themselves that small keeps them.
    fine = np.concatenate([[0.0], np.geomspace(1e-10, 1.0, 12)])
    graded_far = tensor(PLATE, 2 * fine - 0.5, fine + 3.0)
    assert plate.on(graded_far, "kirchhoff").mesh is graded_far


@pytest.mark.parametrize("family", ["ring", "tube", "ball"])
def test_seams_of_single_precision(family, rng):
    surface, mesh = MESHES[family]
    off = rng.choice([-1, 0, 1], mesh.p.shape) * 2.0**-23
    rough = skfem.MeshQuad((mesh.p * (1 + off)).astype(np.float32), mesh.t, sort_t=False)
    problem = sk.Problem(surface, 0.1, sk.Isotropic(1e5, 0.3, 1.0))
    for theory in ("full", "kirchhoff"):
        assert problem.on(rough, theory).geometry.n_nodes == problem.on(mesh, theory).geometry.n_nodes


def test_names_on_another_side_than_that_of_the_surface_are_told():
    centred = sk.Rectangle(2.0, 2.0, origin=(-1.0, -1.0))
    plate = sk.Problem(centred, 0.1, sk.Isotropic(1e5, 0.3, 1.0), [sk.Clamp("left")])
    mesh = uniform(centred, 4, 4)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        plate.on(mesh)
        plate.on(skfem.MeshQuad(mesh.p, mesh.t).with_defaults().refined())
    for p, there in ((mesh.p * [[-1], [1]], "x = 1, .* 'right'"), (mesh.p[::-1], "y = -1, .* 'bottom'")):
        turned = skfem.MeshQuad(p, mesh.t, _boundaries=mesh.boundaries)
        with pytest.warns(sk.OutOfDepth, match=f"boundary 'left' of the mesh lies on {there}"):
            plate.on(turned)
    # A name of the user's own that is elsewhere, or on a part of the side.
    plate.on(skfem.MeshQuad(mesh.p, mesh.t).with_boundaries({"left": lambda x: (x[0] == -1) & (x[1] > 0)}))
    plate.on(skfem.MeshQuad(mesh.p, mesh.t).with_boundaries({"left": lambda x: x[0] < 0, "here": lambda x: x[1] == 1}))


# --- derivatives -----------------------------------------------------------------------------------------------------


class Own:
    """A shallow paraboloid."""

    factor = np.ones(5)

    def position(self, x, y):
        return np.stack([x, y, 0.1 * x * x + 0.2 * x * y - 0.05 * y * y])

    def derivatives(self, x, y):
        one, zero = np.ones_like(x), np.zeros_like(x)
        f = self.factor
        return np.stack([one, zero, f[0] * (0.2 * x + 0.2 * y)]), np.stack([zero, one, f[1] * (0.2 * x - 0.1 * y)])

    def second_derivatives(self, x, y):
        zero = np.zeros_like(x)
        return tuple(np.stack([zero, zero, f * c + zero]) for f, c in zip(self.factor[2:], (0.2, 0.2, -0.1), strict=True))


def test_derivatives_that_contradict_the_position_are_refused():
    mesh = skfem.MeshQuad.init_tensor(np.linspace(0, 2, 5), np.linspace(0, 1, 4))
    put(Own(), mesh)
    for k, name in enumerate(("X_x", "X_y", "X_xx", "X_xy", "X_yy")):
        for wrong in (-1.0, 0.0, 1.05):
            surface = Own()
            surface.factor = np.where(np.arange(5) == k, wrong, 1.0)
            with pytest.raises(InputError, match=rf"give {name} = .* at \(x, y\) = .* differences give"):
                put(surface, mesh)


def test_derivatives_by_differences_are_accepted_wherever_the_surface_is():
    class Differences(Own):
        h = 1e-5

        def position(self, x, y):
            return Own.position(self, x, y) + self.origin

        def derivatives(self, x, y):
            h = self.h
            return tuple((self.position(x + a, y + b) - self.position(x - a, y - b)) / (2 * h) for a, b in ((h, 0), (0, h)))

        def second_derivatives(self, x, y):
            h = 1e-3
            (xx, xy), yy = (
                [(p - m) / (2 * h) for p, m in zip(self.derivatives(x + h, y), self.derivatives(x - h, y), strict=True)],
                (self.derivatives(x, y + h)[1] - self.derivatives(x, y - h)[1]) / (2 * h),
            )
            return xx, xy, yy

    mesh = skfem.MeshQuad.init_tensor(np.linspace(0, 2, 5), np.linspace(0, 1, 4))
    for origin in (0.0, 10.0):
        surface = Differences()
        surface.origin = origin
        put(surface, mesh)


def test_a_mapped_surface_with_derivatives_of_its_own():
    class Wrong(sk.MappedSurface):
        def second_derivatives(self, x, y):
            xx, xy, yy = super().second_derivatives(x, y)
            return yy, xy, xx

    surface = Wrong(lambda x, y: (x, y, 0.2 * np.sin(3 * x) * y), ((0.0, 1.0), (0.0, 1.0)))
    with pytest.raises(InputError, match="second_derivatives give X_xx"):
        put(surface, uniform(surface, 4, 4))


def waves(amplitude, number, length=1.0):
    """A wavy sheet over a square, with its derivatives."""
    k, a, L = number, amplitude, length

    class Waves:
        def position(self, x, y):
            return np.stack([x, y, a * L * np.sin(k * x / L) * np.cos(k * y / L)])

        def derivatives(self, x, y):
            one, zero = np.ones_like(x), np.zeros_like(x)
            c, s = a * k * np.cos(k * x / L) * np.cos(k * y / L), a * k * np.sin(k * x / L) * np.sin(k * y / L)
            return np.stack([one, zero, c]), np.stack([zero, one, -s])

        def second_derivatives(self, x, y):
            zero, c = np.zeros_like(x), a * k * k / L
            xx, xy = -c * np.sin(k * x / L) * np.cos(k * y / L), -c * np.cos(k * x / L) * np.sin(k * y / L)
            return tuple(np.stack([zero, zero, v]) for v in (xx, xy, xx))

    return Waves


@pytest.mark.parametrize("corner", [(0, 0), (1, 0), (0, 1), (1, 1)])
def test_derivatives_that_are_wrong_in_a_corner_only(corner):
    base, length = waves(0.05, 5.0, 30.0), 30.0
    mesh = skfem.MeshQuad.init_tensor(np.linspace(0, length, 7), np.linspace(0, length, 9))

    def there(x, y):
        return (np.abs(x / length - corner[0]) < 0.04) & (np.abs(y / length - corner[1]) < 0.04)

    second = ("second_derivatives", ("X_xx", "X_xy", "X_yy"), 0.01)
    for method, names, size in (("derivatives", ("X_x", "X_y"), 0.05), second):
        for k, name in enumerate(names):

            def wrong(self, x, y, method=method, k=k, size=size):
                found = [v.copy() for v in getattr(base, method)(self, x, y)]
                found[k][2] += size * there(x, y)
                return tuple(found)

            with pytest.raises(InputError, match=rf"give {name} = .* at \(x, y\) = .* differences give"):
                put(type("Wrong", (base,), {method: wrong})(), mesh)


@pytest.mark.parametrize("number", [0.7, 4.0, 15.0])
@pytest.mark.parametrize("length", [1e-6, 1.0, 1e5])
def test_noise_of_a_millionth_is_no_contradiction(number, length, rng):
    base = waves(0.05, number, length)
    mesh = skfem.MeshQuad.init_tensor(np.linspace(0, length, 14), np.linspace(0, length, 12))

    def noise(of):
        return 1e-6 * rng.uniform(-1, 1, of.shape)

    class Noisy(base):
        def derivatives(self, x, y):
            return tuple(v + noise(v) for v in super().derivatives(x, y))

        def second_derivatives(self, x, y):
            return tuple(v + noise(v) / length for v in super().second_derivatives(x, y))

    class Rough(base):
        def position(self, x, y):
            found = super().position(x, y)
            return found + noise(found) * length

    class Forward(base):
        """As many write it."""

        def derivatives(self, x, y):
            h, here = 1e-7 * length, self.position(x, y)
            return (self.position(x + h, y) - here) / h, (self.position(x, y + h) - here) / h

    for surface in (base, Noisy, Rough, Forward):
        put(surface(), mesh)
        with pytest.raises(InputError, match="give X_xy"):
            put(type("Wrong", (surface,), {"second_derivatives": lambda self, x, y: (
                lambda xx, xy, yy: (xx, -xy, yy))(*super(type(self), self).second_derivatives(x, y))})(), mesh)  # fmt: skip


def test_a_surface_is_asked_within_the_mesh_only():
    class Cap:
        """A half sphere, which ends not far from the mesh."""

        def position(self, x, y):
            assert (x * x + y * y < 1).all()
            return np.stack([x, y, np.sqrt(1 - x * x - y * y)])

        def derivatives(self, x, y):
            z, one, zero = self.position(x, y)[2], np.ones_like(x), np.zeros_like(x)
            return np.stack([one, zero, -x / z]), np.stack([zero, one, -y / z])

        def second_derivatives(self, x, y):
            z, o = self.position(x, y)[2], np.zeros_like(x)
            return tuple(np.stack([o, o, v]) for v in (-1 / z - x * x / z**3, -x * y / z**3, -1 / z - y * y / z**3))

    u, v = (square := skfem.MeshQuad.init_tensor(*[np.linspace(-0.99, 0.99, 8)] * 2)).p
    put(Cap(), made(square, 0.97 * np.stack([u * np.sqrt(1 - v * v / 2), v * np.sqrt(1 - u * u / 2)])))


def test_exact_derivatives_that_are_wrong_between_the_places_a_mapped_surface_looks_at():
    def slopes(x, y):
        bump = 0.1 * np.exp(-(((x - 0.36) / 0.02) ** 2) - ((y - 0.52) / 0.02) ** 2)
        return (np.ones_like(x), np.zeros_like(x), y + bump), (np.zeros_like(x), np.ones_like(x), x)

    surface = sk.MappedSurface(lambda x, y: (x, y, x * y), ((0.0, 1.0), (0.0, 1.0)), exact_derivatives=slopes)
    with pytest.raises(InputError, match="derivatives give X_x"):
        put(surface, uniform(surface, 25, 25))


MALFORMED = [
    ({"position": lambda self, x, y: [x, y, 0 * x]}, "position is a list"),
    ({"position": lambda self, x, y: np.stack([x, y, 0 * x], axis=-1)}, r"position is an array of shape \(\d+, 3\)"),
    ({"position": lambda self, x, y: np.stack([x, y, np.where(x > 1.8, np.nan, 0.0)])}, r"position is .*nan.* finite"),
    ({"derivatives": lambda self, x, y: Own.derivatives(self, x, y)[:1]}, "derivatives return .*must return X_x, X_y"),
    ({"derivatives": lambda self, x, y: Own.derivatives(self, x, y)[::-1]}, "derivatives give X_x = .*differences"),
    ({"second_derivatives": lambda self, x, y: (None, None, None)}, "X_xx of second_derivatives is a NoneType"),
    ({"second_derivatives": lambda self, x, y: Own.second_derivatives(self, x, y)[1:]}, "must return X_xx, X_xy, X_yy"),
]


@pytest.mark.parametrize(("change", "words"), MALFORMED)
def test_surfaces_that_return_something_else(change, words):
    mesh = skfem.MeshQuad.init_tensor(np.linspace(0, 2, 5), np.linspace(0, 1, 4))
    with pytest.raises(InputError, match=f"surface: .*{words}"):
        put(type("Changed", (Own,), change)(), mesh)


def test_the_thin_theory_asks_for_second_derivatives():
    class First:
        position, derivatives, factor = Own.position, Own.derivatives, Own.factor

    mesh = skfem.MeshQuad.init_tensor(np.linspace(0, 2, 5), np.linspace(0, 1, 4))
    put(First(), mesh)
    with pytest.raises(InputError, match="second_derivatives, which theory 'kirchhoff' needs"):
        Geometry(mesh, First(), theory_named("kirchhoff"))


# --- seams -----------------------------------------------------------------------------------------------------------


class Shell:
    """A cylinder, or a part of one."""

    bounds, sides, closed = ((0.0, 2.0), (0.0, 2 * pi)), ("low", "high", "from", "to"), (False, True)
    turns, climb = 1.0, 0.0

    def position(self, x, y):
        angle = self.turns * y
        return np.stack([np.cos(angle), np.sin(angle), x + self.climb * y])

    def derivatives(self, x, y):
        angle, zero = self.turns * y, np.zeros_like(x)
        along = [-self.turns * np.sin(angle), self.turns * np.cos(angle), self.climb + zero]
        return np.stack([zero, zero, zero + 1]), np.stack(along)

    def second_derivatives(self, x, y):
        zero, bent = np.zeros_like(x), -(self.turns**2) * self.position(x, y)
        bent[2] = 0.0
        return np.stack([zero] * 3), np.stack([zero] * 3), bent


@pytest.mark.parametrize("change", [{"turns": 0.25}, {"climb": 0.1}, {"closed": (True, True)}, {"turns": 1.001}])
def test_surfaces_that_are_said_to_be_closed_and_are_not(change):
    surface = type("Changed", (Shell,), change)()
    put(Shell(), uniform(Shell(), 3, 8))
    with pytest.raises(InputError, match=r"closed in [xy], but X differs by .* between the two ends"):
        put(surface, uniform(surface, 3, 8))


SLIT = [
    type("Open", (Shell,), {"closed": (False, False)})(),
    sk.CylinderSector(1.0, 2.0, 2 * pi),
    sk.AnnulusSector(1.0, 2.0, 2 * pi, start=0.3),
]


@pytest.mark.parametrize("surface", SLIT, ids=["own", "tube", "ring"])
def test_a_slit_that_nobody_names_is_told(surface):
    law, names, mesh = sk.Isotropic(1e5, 0.3, 1.0), surface.sides, uniform(surface, 3, 8)

    def on(*supports, loads=()):
        return sk.Problem(surface, 0.05, law, supports, loads).on(mesh)

    for supports in ([sk.Clamp(names[0])], [sk.Clamp("boundary")], [sk.Pin([names[0], names[1]])]):
        with pytest.warns(sk.OutOfDepth, match=f"'{names[2]}' and '{names[3]}' .* not joined.*closed=True") as told:
            on(*supports)
        assert len(told) == 1 and told[0].filename == __file__
    # Whoever names one of its edges knows of the slit.
    end = surface.bounds[1][1]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        on(sk.Clamp(names[2]))
        on(sk.Pin(lambda x, y: y > end - 1e-9), loads=[sk.EdgeLoad(names[0], (0, 0, 1.0))])
        on(sk.Clamp(names[0]), loads=[sk.EdgeLoad(names[3], (0, 0, 1.0))])


@families
def test_whole_surfaces_have_no_slit(family):
    surface, mesh = MESHES[family]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sk.Problem(surface, 0.05, sk.Isotropic(1e5, 0.3, 1.0)).on(mesh)
