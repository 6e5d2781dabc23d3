"""States in motion on other meshes of a tree: exact where asked, with their momenta, and without more energy."""

import numpy as np
import pytest
from problems import SURFACES

import skancf as sk
from skancf.adaptive import remap
from skancf.adaptive.interpolation import Interpolation
from skancf.adaptive.momenta import Momenta
from skancf.errors import InputError
from skancf.meshes import quadtree, uniform

MATERIAL = sk.Isotropic(1e6, 0.3, 2000.0)
EXACT = 1e-12
theories = pytest.mark.parametrize("theory", ["kirchhoff", "full"])
surfaces = pytest.mark.parametrize("name", ["flat", "tube", "cap"])


def tree(name):
    """Two levels, with hanging nodes and at poles."""
    surface, *counts = SURFACES[name]
    mesh = quadtree(uniform(surface, *(2 * n for n in counts)), surface).refined([0, 1, 5])
    assert len(mesh.hanging) > 2
    return mesh


def finer(mesh):
    return mesh.refined(np.arange(0, mesh.nelements, 3))


def coarser(mesh):
    """All that can be, from one that is finer everywhere."""
    return mesh.coarsened(np.arange(mesh.nelements))


def mixed(mesh):
    out = mesh.adapted(np.flatnonzero(mesh.levels == 0)[-1:], np.arange(mesh.nelements))
    assert (out.levels.max(), out.levels.min()) == (1, 0)
    return out


def on(name, mesh, theory, supports=(), thickness=0.02, loads=()):
    return sk.Problem(SURFACES[name][0], thickness, MATERIAL, list(supports), list(loads)).on(mesh, theory)


def rotation(rng):
    Q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return Q * np.sign(np.linalg.det(Q))


def turned(vectors, Q, shift=(0, 0, 0)):
    """Nodal coordinates of a body turned and moved."""
    out = vectors.reshape(-1, 4, 3) @ Q.T
    out[:, 0] += shift
    return out.ravel()


def bent(system, rng, amplitude=0.2):
    """A smooth change of shape, with a rate of it and a spin, in a place far off: every nodal vector of a cubic in space."""
    C, D = amplitude * rng.normal(size=(2, 3, 3, 3))
    Q, nodal = rotation(rng), system.undeformed.reshape(-1, 4, 3)
    x, fourth = nodal[:, 0], nodal[:, 3]

    def field(C):
        slopes = [2 * np.einsum("ijk,nj,nk->ni", C + C.swapaxes(1, 2), x, nodal[:, k]) / 2 for k in (1, 2)]
        last = np.einsum("ijk,nj,nk->ni", C + C.swapaxes(1, 2), x, fourth)
        if not system.geometry.theory.directors:
            last = last + np.einsum("ijk,nj,nk->ni", C + C.swapaxes(1, 2), nodal[:, 1], nodal[:, 2])
        return np.stack([np.einsum("ijk,nj,nk->ni", C, x, x), *slopes, last], axis=1).ravel()

    q = turned(system.undeformed + system.constraints.free_part(field(C)), Q, (3.0, -2.0, 5.0))
    spin = np.cross(rng.normal(size=3), q.reshape(-1, 4, 3))
    spin[:, 0] += rng.normal(size=3)
    return sk.Solution(system, q, turned(field(D), Q) + spin.ravel(), time=0.25)


def held(system, rng, amplitude=0.05):
    """A rough change of shape and rate on free coordinates."""
    change, v = (system.constraints.free_part(rng.normal(size=system.n_dofs)) for _ in range(2))
    return sk.Solution(system, system.undeformed + amplitude * change, v, time=0.25)


def struck(system, rng, place=(0.5, 0.4), t_end=0.05):
    """Some time after a blow."""
    x = system.undeformed.reshape(-1, 4, 3)
    v = np.zeros_like(x)
    v[:, 0, 2] = 2 * np.exp(-((x[:, 0, :2] - place) ** 2).sum(axis=1) / 0.02)
    start = system.constraints.free_part(v.ravel())
    motion = sk.simulate(system, t_end, velocity=start, outputs=4, progress=False, rtol=1e-2)
    return [sk.Solution(system, q, v, float(t)) for q, v, t in zip(motion.q, motion.v, motion.times, strict=True)][1:]


def off(change, state):
    """Change of the momenta over their sizes, those of parts included."""
    flow = (state.system.mass @ state.velocity).reshape(-1, 4, 3)
    sizes = np.abs(flow[:, 0]).sum(), (np.abs(state.q.reshape(-1, 4, 3)).max() * np.abs(flow)).sum()
    return (change.momentum / sizes).max()


# --- finer --------------------------------------------------------------------------------------------------------------


def test_finer_and_unsettled_is_exact(rng):
    """Positions, rates and accelerations at points; kinetic energy and momenta; the strain energy of strains as they are."""
    mesh = tree("flat")
    old, new = (on("flat", m, sk.Kirchhoff(assumed=False)) for m in (mesh, finer(mesh)))
    state = bent(old, rng)
    a = rng.normal(size=old.n_dofs)
    found = remap(state, new, a, settle=False)
    assert found.v is not None and found.a is not None
    points = rng.uniform(0, 1, (40, 2)) * (1.0, 0.8)
    for before, after in ((state.q, found.q), (state.velocity, found.v), (a, found.a)):
        values = [sk.Solution(s, x).position(points) for s, x in ((old, before), (new, after))]
        assert np.abs(values[0] - values[1]).max() < 1e-13 * np.abs(values[0]).max()
    change = found.change
    assert np.isclose(*change.kinetic_energy, rtol=EXACT) and off(change, state) < 1e-14
    # Three by three points integrate the strain energy of smaller elements better.
    assert np.isclose(*change.strain_energy, rtol=1e-3) and change.factor == 1 and change.moved < 1e-14
    assert np.isclose(change.raised, max(change.energy, 0), atol=EXACT * change.kinetic_energy[0])


@theories
def test_settled_a_finer_mesh_has_no_more_energy(theory, rng):
    """Assumed membrane strains let a coarse mesh bend far without stretching; the same field on smaller elements stretches.
    Measured up to 0.9e-2 and 3.5e-2 of the whole energy here; settled, 1.2e-3 and 2.5e-2, which the velocities give."""
    system = on("flat", quadtree(uniform(SURFACES["flat"][0], 12, 10)), theory, thickness=0.01)
    rises = []
    for state in struck(system, rng):
        new = on("flat", system.mesh.refined(), theory, thickness=0.01)
        plain, settled = (remap(state, new, settle=settle).change for settle in (False, True))
        energy = state.strain_energy + state.kinetic_energy
        rises.append(plain.energy / energy)
        assert settled.energy < EXACT * energy and settled.raised == 0
        assert settled.factor > {"kirchhoff": 0.995, "full": 0.95}[theory]
        assert settled.energy > -0.1 * energy
        assert off(settled, state) < EXACT and settled.moved < 1e-4
    assert max(rises) > 0.005, "positions that are the same have more energy"


@theories
@pytest.mark.parametrize("name", ["tube", "cap", "ring"])
def test_curved_bodies_move_rigidly_without_strain(name, theory, rng):
    """Turned, moved and spinning: positions and rates of the finer body are those of the same motion, on both ways."""
    mesh = tree(name)
    old, new = (on(name, m, theory) for m in (mesh, finer(mesh)))
    Q, w = rotation(rng), rng.normal(size=3)

    def moving(system):
        q = turned(system.undeformed, Q, (3.0, -2.0, 5.0))
        v = np.cross(w, q.reshape(-1, 4, 3))
        v[:, 0] += (1.0, 2.0, 3.0)
        return sk.Solution(system, q, v.ravel(), 0.0)

    for start, end in ((moving(old), moving(new)), (moving(new), moving(old))):
        between = Interpolation(start.system.geometry, end.system.geometry)
        exact, found = end.system, remap(start, end.system)
        assert np.abs(found.q - end.q).max() < 1e-12
        assert np.abs(between.rates(start.q, start.velocity) - end.velocity).max() < 1e-12 * np.abs(end.velocity).max()
        stiff = 1e6 * 0.02 * 10
        assert exact.strain_energy(found.q) < 1e-22 * stiff and off(found.change, start) < EXACT
    # Interpolated positions alone are strained.
    q = Interpolation(old.geometry, new.geometry).field(moving(old).q)
    if name != "ring":
        assert new.strain_energy(q) > 1e-8


def test_gaps_turn_with_the_body(rng):
    """Turning a state and carrying it over can be exchanged."""
    mesh = tree("tube")
    old, new = (on("tube", m, "kirchhoff") for m in (mesh, finer(mesh)))
    state, Q = bent(old, rng), rotation(rng)
    between = Interpolation(old.geometry, new.geometry)
    q, v = between.positions(turned(state.q, Q)), between.rates(turned(state.q, Q), turned(state.velocity, Q))
    assert np.abs(q - turned(between.positions(state.q), Q)).max() < 1e-12
    assert np.abs(v - turned(between.rates(state.q, state.velocity), Q)).max() < 1e-12 * np.abs(v).max()
    step = 1e-5
    ahead, behind = (between.positions(state.q + sign * step * state.velocity) for sign in (1, -1))
    assert np.abs((ahead - behind) / (2 * step) - between.rates(state.q, state.velocity)).max() < 1e-7 * np.abs(v).max()
    flat = Interpolation(*(on("flat", m, "kirchhoff").geometry for m in (tree("flat"), finer(tree("flat")))))
    some = rng.normal(size=12 * flat.old.n_nodes)
    assert np.array_equal(flat.positions(some), flat.field(some))


# --- coarser ------------------------------------------------------------------------------------------------------------


@theories
@surfaces
@pytest.mark.parametrize("change", [finer, coarser, mixed])
def test_free_bodies_keep_their_momenta(name, theory, change, rng):
    mesh = tree(name)
    old, new = (on(name, m, theory) for m in (mesh, change(mesh)))
    state = bent(old, rng)
    found = remap(state, new).change
    assert off(found, state) < EXACT and np.abs(found.momenta[0]).min() > 1e-3
    if name == "flat":
        assert found.moved < 1e-13
    assert found.energy <= EXACT * np.sum(found.strain_energy[0] + found.kinetic_energy[0]) or found.raised > 0


def test_a_projection_alone_loses_angular_momentum(rng):
    """It keeps that of the place where it projects, and positions change too."""
    mesh = tree("flat")
    old, new = (on("flat", m, "kirchhoff") for m in (mesh, coarser(mesh)))
    state = held(old, rng)
    found = remap(state, new, state.velocity)
    assert found.a is not None
    plain = new.momenta(found.q, found.a)
    lost = np.linalg.norm(plain - state.momenta, axis=1) / np.linalg.norm(state.momenta, axis=1)
    assert lost[0] < EXACT and lost[1] > 1e-3
    assert off(found.change, state) < EXACT


@theories
@pytest.mark.parametrize("supports", [[sk.Clamp("left")], [sk.Pin("boundary")], [sk.Roller("boundary", (0, 0, 1))]])
def test_supported_bodies_keep_theirs_too(theory, supports, rng):
    mesh = tree("flat")
    old, new = (on("flat", m, theory, supports) for m in (mesh, coarser(mesh)))
    state = held(old, rng)
    found = remap(state, new)
    assert found.v is not None and off(found.change, state) < EXACT
    assert not new.constraints.fixed_part(found.v).any()
    assert np.array_equal(new.constraints.fixed_part(found.q), new.constraints.fixed_part(new.undeformed))


@theories
@pytest.mark.parametrize("change", [finer, coarser, mixed])
def test_the_energy_never_rises(theory, change, rng):
    """Rough states, of which the coarse mesh keeps little: some need slower velocities, some cannot be helped."""
    mesh = tree("flat")
    factors, raised = [], 0
    for supports in ([], [sk.Clamp("left")]):
        old, new = (on("flat", m, theory, supports) for m in (mesh, change(mesh)))
        for amplitude in (0.0, 1e-4, 1e-3, 1e-2, 0.05):
            for speed in (1.0, 30.0):
                rough = held(old, rng, amplitude)
                state = sk.Solution(old, rough.q, speed * rough.velocity, time=0.25)
                found = remap(state, new).change
                energy = found.strain_energy[0] + found.kinetic_energy[0]
                if found.raised:
                    assert found.factor == 0 and found.raised == found.energy > 0
                    raised += 1
                else:
                    assert found.energy <= EXACT * energy
                assert off(found, state) < EXACT
                factors.append(found.factor)
    assert raised < len(factors) and max(factors) == 1


@theories
def test_velocities_slow_down_where_the_strain_energy_rose(theory, rng):
    """The rest of the energy is exactly there, and a rigid motion beneath stays as it is."""
    system = on("flat", tree("flat"), theory)
    state = bent(system, rng)
    momenta = Momenta(system, state.q, lambda force: force)
    least, _ = momenta.slowed(state.velocity, -1.0)
    smallest, most = system.kinetic_energy(least), state.kinetic_energy
    assert smallest < most * (1 - 1e-6)
    allowed = 0.5 * (smallest + most)
    v, factor = momenta.slowed(state.velocity, allowed)
    assert np.isclose(system.kinetic_energy(v), allowed, rtol=EXACT) and np.isclose(factor, np.sqrt(0.5), rtol=1e-6)
    assert np.allclose(system.momenta(state.q, v), state.momenta, rtol=0, atol=EXACT * np.abs(state.momenta).max())
    assert momenta.slowed(state.velocity, most)[1] == 1.0
    # Of a body that turns as a whole nothing deforms.
    nodal = np.cross((1.0, 2.0, 3.0), state.q.reshape(-1, 4, 3)).ravel()
    rigid, factor = momenta.slowed(nodal, 0.0)
    assert np.abs(rigid - nodal).max() < 1e-11 * np.abs(nodal).max()


@theories
def test_states_of_a_motion(theory, rng):
    """A coarser mesh takes them over with little change of energy, where projected positions would have much more."""
    system = on("flat", quadtree(uniform(SURFACES["flat"][0], 6, 5)).refined(), theory, thickness=0.005)
    for state in struck(system, rng, t_end=0.02):
        new = on("flat", system.mesh.coarsened(np.arange(0, system.mesh.nelements // 2)), theory, thickness=0.005)
        assert new.mesh.nelements < system.mesh.nelements
        found = remap(state, new).change
        energy = state.strain_energy + state.kinetic_energy
        assert -0.2 * energy < found.energy <= EXACT * energy and found.raised == 0
        assert off(found, state) < EXACT and found.moved < {"kirchhoff": 1e-12, "full": 1e-6}[theory]


@theories
@pytest.mark.parametrize("name", ["flat", "tube"])
def test_refined_and_coarsened_again(name, theory, rng):
    """To the last bit where nodes carry it; rates to the rounding of momenta. With settled forces to what these moved."""
    mesh = tree(name)
    old, new = (on(name, m, theory) for m in (mesh, finer(mesh)))
    state, a = bent(old, rng), rng.normal(size=old.n_dofs)
    up = remap(state, new, a, settle=False)
    back = remap(sk.Solution(new, up.q, up.v, 0.25), old, up.a)
    assert back.v is not None and np.array_equal(back.q, state.q) and np.array_equal(back.a, a)
    # Where the energy of the same positions on both meshes is not the same one.
    if back.change.factor == 1:
        assert np.abs(back.v - state.velocity).max() < {"flat": 1e-11, "tube": 1e-2}[name] * np.abs(state.velocity).max()


# --- supports that move, states at rest, what is refused -----------------------------------------------------------------


@theories
@pytest.mark.parametrize("change", [finer, coarser])
def test_moving_supports_keep_their_rate(theory, change):
    """Old and new nodes; and what an integrator's velocity differs from it stays."""
    mesh = tree("flat")
    supports = [sk.Prescribed("left", (0.0, 0.0, 0.1), history=lambda t: np.sin(3 * t))]
    old, new = (on("flat", m, theory, supports) for m in (mesh, change(mesh)))
    rate = 0.3 * np.cos(3 * 0.25)
    for off_by in (0.0, 0.01):
        v = np.zeros((old.geometry.n_nodes, 4, 3))
        v[:, 0, 2] = rate + off_by
        q = old.undeformed + old.prescribed(sk.Case(time=0.25))
        found = remap(sk.Solution(old, q, v.ravel(), time=0.25), new)
        assert found.v is not None
        edge = found.v.reshape(-1, 4, 3)[new.geometry.nodes_on("left"), 0]
        # Differences over 1e-7 s.
        assert np.allclose(edge, (0, 0, rate + off_by), rtol=0, atol=1e-6)
        assert np.array_equal(new.constraints.fixed_part(found.q - new.undeformed), new.prescribed(sk.Case(time=0.25)))
    # Nodes at which nothing was known move with the support.
    q = old.undeformed + old.prescribed(sk.Case(time=0.25))
    still = remap(sk.Solution(old, q, np.zeros(old.n_dofs), time=0.25), new)
    assert still.v is not None and np.abs(still.v).max() < 1e-6


@theories
def test_at_rest(theory, rng):
    """Nothing moves that did not, and without a velocity there is none."""
    mesh = tree("tube")
    old, new = (on("tube", m, theory) for m in (mesh, coarser(mesh)))
    found = remap(sk.Solution(old, old.undeformed), new)
    assert found.v is None and found.a is None and np.abs(found.q - new.undeformed).max() < 1e-12
    assert not found.change.kinetic_energy.any() and found.change.raised == 0


def test_what_is_refused(rng):
    system = on("flat", tree("flat"), "kirchhoff")
    other = on("flat", quadtree(uniform(SURFACES["flat"][0], 3, 2)), "kirchhoff")
    with pytest.raises(InputError, match="grow from different coarse meshes"):
        remap(held(system, rng), other)
