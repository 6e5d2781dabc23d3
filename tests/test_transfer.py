"""States on other meshes of a tree: exactly to finer ones, by projection to coarser ones."""

from math import pi

import numpy as np
import pytest
import skfem
from problems import SURFACES

import skancf as sk
from skancf.adaptive import transfer
from skancf.adaptive.interpolation import Interpolation, prolongation
from skancf.adaptive.remap import remap
from skancf.elements.quad_ancf import square_quadrature
from skancf.errors import InputError
from skancf.meshes import quadtree, uniform

DENSITY, THICKNESS = 2000.0, 0.05
MATERIAL = sk.Isotropic(1e6, 0.3, DENSITY)
theories = pytest.mark.parametrize("theory", ["kirchhoff", "full"])


def tree(name, factor=1):
    """Some levels, the finest at the seam and at the pole."""
    surface, *counts = SURFACES[name]
    mesh = quadtree(uniform(surface, *(factor * n for n in counts)), surface).refined([0])
    mesh = mesh.refined([mesh.levels.argmax(), 1])
    assert len(mesh.hanging) > 3 and mesh.levels.max() == 2
    return mesh


def finer(mesh):
    fine = mesh.refined(np.arange(0, mesh.nelements, 3))
    assert fine.nelements > mesh.nelements and len(fine.hanging)
    return fine


def coarser(mesh):
    coarse = mesh.coarsened(np.arange(mesh.nelements))
    assert coarse.nelements < mesh.nelements
    return coarse


def mixed(mesh):
    """Refined in one place and coarsened in another."""
    large = np.flatnonzero(mesh.levels == 0)[-1:]
    out = mesh.adapted(large, np.arange(mesh.nelements))
    old, new = mesh.leaves, out.leaves
    assert (old.find(new.cells.parents) >= 0).any() and (new.find(old.cells.parents) >= 0).any()
    return out


def system_on(name, theory, mesh, supports=(), loads=()):
    return sk.Problem(SURFACES[name][0], THICKNESS, MATERIAL, list(supports), list(loads)).on(mesh, theory)


def random_state(system, rng, size=0.1):
    motion = system.constraints.free_part(rng.normal(size=system.n_dofs))
    held = 0.5 * system.prescribed()
    change = size * system.constraints.free_part(rng.normal(size=system.n_dofs))
    return sk.Solution(system, system.undeformed + held + change, motion, time=0.25, load_factor=0.5)


def points_in(mesh, n=4):
    """Gauss points of every element: elements (m,), in the parameter plane (2, m), weights (m,)."""
    s, w = square_quadrature(n)
    low, high = mesh.p[:, mesh.t[0]], mesh.p[:, mesh.t[2]]
    at = low[:, :, None] + s[:, None] * (high - low)[:, :, None]
    weights = np.prod(high - low, axis=0)[:, None] * w
    return np.repeat(np.arange(mesh.nelements), len(w)), at.reshape(2, -1), weights.ravel()


def tables_at(system, elements, at):
    """r, r_x, r_y, and r_z in theory `full`, as functions of the local vectors: (3 or 4, 16, m)."""
    mesh, theory = system.mesh, system.geometry.theory
    low, high = mesh.p[:, mesh.t[0, elements]], mesh.p[:, mesh.t[2, elements]]
    s = np.clip((at - low) / (high - low), 0, 1)
    r, *d = theory.position_table(s)
    return np.stack([r, *(theory.slope_table(s) / (high - low)[:, None]), *d])


def fields_at(system, q, at):
    """The fields at points (2, m) of the parameter plane, (3 or 4, m, 3)."""
    elements = system.mesh.element_finder()(*at)
    local = system.geometry.local(q.reshape(-1, 4, 3), elements)
    return np.einsum("fam,mai->fmi", tables_at(system, elements, at), local)


def difference(one, two, at, velocity=False):
    """Of two states, over the size of each field."""
    values, others = (fields_at(s.system, s.velocity if velocity else s.q, at) for s in (one, two))
    return np.abs(values - others).max(axis=(1, 2)) / np.abs(values).max(axis=(1, 2))


def momentum(state):
    """Linear momentum, and angular momentum in the undeformed place about the origin: (6,)."""
    nodal = state.system.undeformed.reshape(-1, 4, 3)
    flow = (state.system.mass @ state.velocity).reshape(-1, 4, 3)
    return np.array([*flow[:, 0].sum(axis=0), *((np.cross(axis, nodal) * flow).sum() for axis in np.eye(3))])


# --- to a finer mesh -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["flat", "tube", "ring"])
@pytest.mark.parametrize("change", [finer, lambda m: m.refined(1), lambda m: m])
def test_thin_spaces_are_nested(name, change, rng):
    """Positions and both slopes of the position and of the velocity stay the same functions, across seams too."""
    mesh = tree(name)
    old, new = (system_on(name, "kirchhoff", m) for m in (mesh, change(mesh)))
    state = random_state(old, rng)
    moved = transfer(state, new)
    _, at, _ = points_in(new.mesh, 3)
    between = Interpolation(old.geometry, new.geometry)
    same = sk.Solution(new, between.field(state.q), between.field(state.velocity))
    # Sums of 16 products, twice.
    assert difference(state, same, at).max() < 1e-13 and difference(state, same, at, velocity=True).max() < 1e-13
    if name == "flat":
        assert np.array_equal(moved.q, same.q) and np.array_equal(moved.velocity, same.velocity)
    assert (moved.time, moved.load_factor, moved.linear, moved.system) == (0.25, 0.5, False, new)
    if name == "flat":
        assert np.isclose(moved.kinetic_energy, state.kinetic_energy, rtol=1e-12)
    # On curved surfaces the areas of elements are others, and the velocity is corrected.
    assert np.allclose(moved.momenta, state.momenta, rtol=0, atol=1e-12 * np.abs(state.momenta).max())
    assert np.isclose(moved.kinetic_energy, state.kinetic_energy, rtol=2e-2)


def test_a_state_at_rest_has_no_velocity_and_linear_ones_stay_linear(rng):
    mesh = tree("flat")
    old, new = (system_on("flat", "kirchhoff", m, [sk.Clamp("left")], [sk.SurfaceLoad((0, 0, 1e-3))])
                for m in (mesh, finer(mesh)))  # fmt: skip
    state = sk.solve_linear(old)
    moved = transfer(state, new)
    assert moved.velocity is None and moved.linear
    assert np.allclose(moved.displacement((0.9, 0.3)), state.displacement((0.9, 0.3)), rtol=1e-12, atol=0)
    # A nested space cannot be stiffer, and the energy is the same one.
    assert np.isclose(moved.strain_energy, state.strain_energy, rtol=1e-8)


def polynomial_state(system, powers):
    """r_z = x^i y^j, with directors that are linear."""
    (x, y), (i, j) = system.geometry.points, powers
    q = system.undeformed.reshape(-1, 4, 3).copy()
    q[:, 0, 2], q[:, 1, 2] = x**i * y**j, i * x ** max(i - 1, 0) * y**j
    q[:, 2, 2] = j * x**i * y ** max(j - 1, 0)
    q[:, 3, :2] = np.stack([x, y], axis=1)
    return sk.Solution(system, q.ravel())


TWELVE = [(i, j) for i in range(4) for j in range(4) if i + j < 4 or (i, j) in ((3, 1), (1, 3))]
CROSSED = {(2, 1), (1, 2), (3, 1), (1, 3)}


def test_what_the_full_theory_keeps():
    """All its polynomials on a conforming mesh; where nodes hang, those whose slopes across edges are linear along them."""
    even = quadtree(uniform(SURFACES["flat"][0], 2, 2))
    old = system_on("flat", "full", even)
    lost = {}
    for name, mesh in (("conforming", even.refined(1)), ("hanging", tree("flat"))):
        new = system_on("flat", "full", mesh)
        _, at, _ = points_in(mesh)
        errors = {}
        for powers in TWELVE:
            state = polynomial_state(old, powers)
            errors[powers] = difference(state, transfer(state, new), at).max()
        lost[name] = {powers for powers, error in errors.items() if error > 1e-13}
    assert lost == {"conforming": set(), "hanging": CROSSED}


def test_what_changes_in_the_full_theory(rng):
    """Positions at the new nodes, and directors everywhere, stay; positions in between change where slopes jump."""
    mesh = tree("flat")
    old, new = (system_on("flat", "full", m) for m in (mesh, finer(mesh)))
    state = random_state(old, rng)
    moved = transfer(state, new)
    assert difference(state, moved, new.geometry.points)[0] < 1e-13
    _, at, _ = points_in(new.mesh)
    r, *_, d = difference(state, moved, at)
    assert d < 1e-13 and 1e-5 < r < 1e-2
    # Slopes of an answer jump less on a finer mesh.
    errors = []
    for n in (4, 8):
        even = quadtree(uniform(SURFACES["flat"][0], n, n))
        systems = [system_on("flat", "full", m, [sk.Clamp("left")], [sk.SurfaceLoad((0, 0, 1e-3))])
                   for m in (even, even.refined(1))]  # fmt: skip
        state = sk.solve_linear(systems[0])
        _, at, _ = points_in(systems[1].mesh, 2)
        moved = transfer(state, systems[1])
        errors.append(np.abs(moved.position(at.T) - state.position(at.T)).max() / np.abs(state.displacements).max())
    assert errors[1] < errors[0] / 2.5 < 1e-3  # measured 1.9e-4 and 5.6e-5


@theories
@pytest.mark.parametrize("name", ["disc", "cap"])
def test_at_a_pole_the_deviation_falls(name, theory):
    """New nodes at a pole have slopes of directions in between, which the old mesh has interpolated.

    Measured over the largest displacement, with 8 and 16 elements around: 3e-5 and 9e-7 at most on the disc, 1e-3 and 8e-5
    (thin) or 6e-3 and 6e-4 (full) on the cap.
    """
    surface, errors = SURFACES[name][0], []
    for n in (2, 4):
        meshes = [quadtree(uniform(surface, n, 4 * n), surface)]
        meshes.append(meshes[0].refined(1))
        load = sk.SurfaceLoad(lambda x, y: (0 * x, 0 * x, 1 + x * np.cos(y)))
        # Supports would move new nodes of the edge onto the surface.
        systems = [system_on(name, theory, m, supports, [load])
                   for m, supports in zip(meshes, ([sk.Clamp(surface.sides[1])], []), strict=True)]  # fmt: skip
        state = sk.solve_linear(systems[0])
        moved = transfer(state, systems[1])
        _, at, _ = points_in(systems[1].mesh, 2)
        size = np.abs(state.displacements).max()
        errors.append(np.abs(moved.displacement(at.T) - state.displacement(at.T)).max() / size)
    assert errors[0] < 1e-2 and 1e-8 < errors[1] < errors[0] / 10


# --- to a coarser mesh ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("change", [coarser, mixed])
def test_the_projection_is_orthogonal(change, rng):
    """The integral of density t (v_new - v) . dv over a plate vanishes, before momenta are put right."""
    mesh = tree("flat")
    old, new = (system_on("flat", "kirchhoff", m, [sk.Pin("left")]) for m in (mesh, change(mesh)))
    state = random_state(old, rng)
    values = remap(state, new, state.velocity).a
    everywhere = mesh.refined()
    _, at, weights = points_in(everywhere)
    elements = new.mesh.element_finder()(*at)
    shapes = tables_at(new, elements, at)[0]

    def forces(positions):
        local = DENSITY * THICKNESS * np.einsum("m,am,mi->mai", weights, shapes, positions, optimize=True)
        return new.constraints.free_part(new.geometry.nodal(local, elements).ravel())

    before, after = fields_at(old, state.velocity, at)[0], fields_at(new, values, at)[0]
    assert np.abs(after - before).max() > 1e-2, "a coarser function"
    assert np.abs(forces(after - before)).max() < 1e-12 * np.abs(forces(before)).max()
    # Taking nodal values over is no projection.
    taken = (prolongation(old.geometry, new.geometry) @ state.velocity.reshape(-1, 3)).ravel()
    taken = new.constraints.free_part(taken)
    left = forces(fields_at(new, taken, at)[0] - before)
    assert np.abs(left).max() > 1e-3 * np.abs(forces(before)).max()


@theories
@pytest.mark.parametrize("change", [coarser, mixed])
def test_a_plain_projection_keeps_the_momenta_of_the_undeformed_place(theory, change, rng):
    """Of a flat plate: rigid motions are functions of every mesh. The kinetic energy falls."""
    mesh = tree("flat")
    old, new = (system_on("flat", theory, m) for m in (mesh, change(mesh)))
    state = random_state(old, rng)
    v = remap(state, new, state.velocity).a
    there = sk.Solution(new, new.undeformed, v)
    if theory == "kirchhoff":
        assert np.abs(momentum(there) - momentum(state)).max() < 1e-12 * np.abs(momentum(state)).max()
    assert 0.5 * state.kinetic_energy < there.kinetic_energy < state.kinetic_energy * (1 - 1e-3)
    moved = transfer(state, new)
    assert (moved.time, moved.load_factor, moved.system) == (0.25, 0.5, new)


@pytest.mark.parametrize("name", ["flat", "tube", "ring"])
@pytest.mark.parametrize("change", [finer, lambda m: m.refined(1)])
def test_up_and_down_is_the_state(name, change, rng):
    """A projection does not change what the coarse space holds; the thin one holds all of its own."""
    mesh = tree(name)
    # On a curved edge supports move new nodes onto the surface.
    supports = [sk.Pin("left")] if name == "flat" else []
    old, new = (system_on(name, "kirchhoff", m, supports) for m in (mesh, change(mesh)))
    state = random_state(old, rng)
    back = transfer(transfer(state, new), old)
    _, at, _ = points_in(mesh)
    # Condition of the mass matrix with slopes scaled by h and h^2.
    assert difference(state, back, at).max() < 1e-11 and difference(state, back, at, velocity=True).max() < 1e-11


@theories
@pytest.mark.parametrize("name", ["flat", "tube"])
def test_the_projection_is_idempotent(name, theory, rng):
    """From a mesh that is finer in one place and coarser in another, twice: what the second one holds stays."""
    mesh = tree(name)
    old, new = (system_on(name, theory, m) for m in (mesh, coarser(mesh)))
    once = transfer(random_state(old, rng), new)
    _, at, _ = points_in(new.mesh)
    again = transfer(once, new)
    assert difference(once, again, at).max() < 1e-13
    if theory == "kirchhoff":
        twice = transfer(transfer(once, old), new)
        assert difference(once, twice, at).max() < 1e-11 and difference(once, twice, at, velocity=True).max() < 1e-11


def test_polynomials_of_the_full_theory_survive_coarsening():
    even = quadtree(uniform(SURFACES["flat"][0], 2, 2))
    old, new = (system_on("flat", "full", m) for m in (even.refined(1), even))
    _, at, _ = points_in(even)
    for powers in TWELVE:
        state = polynomial_state(old, powers)
        assert difference(state, transfer(state, new), at).max() < 1e-11
    state = polynomial_state(old, (2, 2))
    assert difference(state, transfer(state, new), at)[0] > 1e-4


@theories
@pytest.mark.parametrize("change", [finer, coarser, mixed])
@pytest.mark.parametrize("name", ["flat", "tube"])
def test_supports_hold(name, theory, change, rng):
    """What is prescribed is so exactly, at the load factor of the state, and does not move."""
    mesh, (one, other) = tree(name), SURFACES[name][0].sides[:2]
    supports = [sk.Clamp(one), sk.Prescribed(other, (0.01, None, 0.02))]
    old, new = (system_on(name, theory, m, supports) for m in (mesh, change(mesh)))
    state = random_state(old, rng)
    moved = transfer(state, new)
    wanted = new.constraints.fixed_part(new.undeformed + 0.5 * new.prescribed())
    assert np.abs(wanted - new.constraints.fixed_part(new.undeformed)).max() > 1e-3
    assert np.abs(new.constraints.fixed_part(moved.q) - wanted).max() < 1e-14
    assert np.abs(new.constraints.fixed_part(moved.velocity)).max() < 1e-14
    assert (np.abs(moved.velocity) > 1e-3).any()
    y = np.linspace(*SURFACES[name][0].bounds[1], 9)
    assert np.abs(moved.displacement(np.stack([0 * y + mesh.p[0].min(), y], axis=1))).max() < 1e-13


def cut(n):
    """A tube, of which the finer half is coarsened."""
    surface = SURFACES["tube"][0]
    even = quadtree(uniform(surface, n, 4 * n), surface)
    half = even.refined(np.flatnonzero(even.p[1, even.t].mean(axis=0) < pi))
    return half, even


@theories
def test_on_curved_surfaces_the_projection_changes_the_momentum_with_the_areas(theory):
    """Those of elements: order four, with the linear directors of the full theory order two. Measured 2e-4 and 2e-5 with 8
    and 16 elements around, 2e-2 and 5e-3 in the full theory. What is transferred has its momentum back."""
    errors = []
    for n in (2, 4):
        old, new = (system_on("tube", theory, m) for m in cut(n))
        velocity = np.zeros((old.geometry.n_nodes, 4, 3))
        velocity[:, 0] = (1.0, 2.0, 3.0)
        state = sk.Solution(old, old.undeformed, velocity.ravel())
        plain = sk.Solution(new, new.undeformed, remap(state, new, state.velocity).a)
        before, after = momentum(state)[:3], momentum(plain)[:3]
        errors.append(np.abs(after - before).max() / np.abs(before).max())
        assert np.abs(momentum(transfer(state, new))[:3] - before).max() < 1e-12 * np.abs(before).max()
    assert errors[0] < {"kirchhoff": 5e-4, "full": 4e-2}[theory]
    assert 1e-8 < errors[1] < errors[0] / {"kirchhoff": 12, "full": 3.5}[theory]


# --- what is refused -----------------------------------------------------------------------------------------------------


def test_states_that_cannot_be_carried_over(rng):
    mesh = tree("flat")
    state = random_state(system_on("flat", "kirchhoff", mesh), rng)
    other = quadtree(uniform(SURFACES["flat"][0], 3, 2))
    with pytest.raises(InputError, match="grow from different coarse meshes; refine or coarsen one and the same"):
        transfer(state, system_on("flat", "kirchhoff", other))
    with pytest.raises(InputError, match="the state is one of theory 'kirchhoff', the system of 'full'"):
        transfer(state, system_on("flat", "full", mesh))
    for one, two in ((mesh, mesh.plain()), (mesh.plain(), mesh), (uniform(SURFACES["flat"][0], 2, 2), mesh)):
        plain = two if isinstance(one, type(mesh)) else one
        assert isinstance(plain, skfem.MeshQuad)
        system = system_on("flat", "kirchhoff", uniform(SURFACES["flat"][0], 2, 2))
        start, end = (state, system) if two is plain else (random_state(system, rng), state.system)
        with pytest.raises(InputError, match=r"both meshes must be quadtrees; make the coarse one by sk.meshes.quadtree"):
            transfer(start, end)


def test_a_mesh_that_was_made_twice_or_loaded_is_the_same_tree(tmp_path, rng):
    mesh = tree("tube")
    again = sk.meshes.load(sk.meshes.save(finer(mesh), tmp_path / "mesh.npz"))
    state = random_state(system_on("tube", "kirchhoff", mesh), rng)
    one, two = (transfer(state, system_on("tube", "kirchhoff", m)) for m in (again, finer(mesh)))
    assert np.array_equal(one.q, two.q) and np.abs(one.q).max() > 1
