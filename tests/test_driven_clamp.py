"""Nodes that move with a rigid body: exactly, without strain, and not against other supports."""

import warnings

import numpy as np
import pytest
from problems import SURFACES

import skancf as sk
from skancf.errors import InputError
from skancf.history import check_covers

theories = pytest.mark.parametrize("theory", ["kirchhoff", "full"])
UNIT = sk.Rectangle(1.0, 1.0)
AXIS, THROUGH = np.array([1.0, 2.0, -2.0]), np.array([0.3, -0.2, 0.5])


def angle(t):
    return 2.0 * t**2


def shift(t):
    return (0.1 * t, 0.0, -0.3 * t**2)


def rotation(turn, axis=AXIS):
    """The exponential series of the spin's matrix, summed to rounding."""
    spin = turn * np.cross(np.eye(3), axis / np.linalg.norm(axis))
    total, term = np.eye(3), np.eye(3)
    for k in range(1, 60):
        term = term @ spin / k
        total = total + term
    return total


def everywhere(x, y):
    return np.ones_like(x, dtype=bool)


def system_on(theory, supports, surface=UNIT, mesh=None, loads=()):
    mesh = sk.meshes.uniform(surface, 3, 3) if mesh is None else mesh
    return sk.Problem(surface, 0.05, sk.Isotropic(1e6, 0.3, 1000.0), supports, loads).on(mesh, theory)


def moved(system, t, nodes=slice(None), turn=None):
    """Nodal vectors that follow the body."""
    nodal, turned = system.undeformed.reshape(-1, 4, 3), rotation(angle(t) if turn is None else turn)
    out = nodal @ turned.T
    out[:, 0] = THROUGH + (nodal[:, 0] - THROUGH) @ turned.T + shift(t)
    return out[nodes]


@theories
@pytest.mark.parametrize("case", [*SURFACES, "hanging"])
def test_the_whole_plate_driven_turns_without_strain(theory, case):
    surface, nx, ny = SURFACES.get(case, (UNIT, 2, 2))
    mesh = sk.meshes.uniform(surface, nx, ny)
    if case == "hanging":
        mesh = sk.meshes.quadtree(mesh).refined([0])
    system = system_on(theory, [sk.DrivenClamp(everywhere, tuple(AXIS), tuple(THROUGH), angle, shift)], surface, mesh)
    assert system.constraints.n_free == 0
    for t in (0.0, 0.3, 1.7):
        q = system.undeformed + system.prescribed(sk.Case(time=t))
        assert np.allclose(q.reshape(-1, 4, 3), moved(system, t), rtol=0, atol=1e-13)
        # Rounding of the strains, 1e-15, squared times stiffness and volume.
        assert system.strain_energy(q) < 1e-20
    assert angle(1.7) > 5, "more than half a turn"
    linear = system.undeformed + system.prescribed(sk.Case(time=0.3)) + 1e-3 * moved(system, 1.7).ravel()
    assert system.strain_energy(linear) > 1e-6


@theories
def test_at_an_edge_all_vectors_follow_and_the_rest_is_free(theory):
    system = system_on(theory, [sk.DrivenClamp("left", tuple(AXIS), tuple(THROUGH), angle, shift)])
    edge, nodal = system.geometry.nodes_on("left"), (-1, 4, 3)
    q = (system.undeformed + system.prescribed(sk.Case(time=0.8))).reshape(nodal)
    assert np.allclose(q[edge], moved(system, 0.8, edge), rtol=0, atol=1e-14)
    assert system.constraints.fixed[edge].all() and system.constraints.n_free == 12 * (16 - 4)
    rest = np.setdiff1d(np.arange(16), edge)
    assert np.array_equal(q[rest], system.undeformed.reshape(nodal)[rest])


@theories
def test_one_or_the_other(theory):
    turning = system_on(theory, [sk.DrivenClamp("left", tuple(AXIS), tuple(THROUGH), angle)])
    moving = system_on(theory, [sk.DrivenClamp("left", displacement=shift)])
    edge = turning.geometry.nodes_on("left")
    both = moved(turning, 0.8, edge)
    both[:, 0] -= shift(0.8)
    found = (turning.undeformed + turning.prescribed(sk.Case(time=0.8))).reshape(-1, 4, 3)[edge]
    assert np.allclose(found, both, rtol=0, atol=1e-14)
    change = moving.prescribed(sk.Case(time=0.8)).reshape(-1, 4, 3)[edge]
    assert np.allclose(change[:, 0], shift(0.8), rtol=1e-14) and not change[:, 1:].any()


@theories
@pytest.mark.filterwarnings("ignore:DrivenClamp")
def test_in_statics_it_stands_at_rest(theory):
    load = sk.SurfaceLoad((0.0, 0.0, -1.0))
    driven = system_on(theory, [sk.DrivenClamp("left", displacement=shift, angle=angle)], loads=[load])
    assert not driven.prescribed().any()
    tip, clamped = (sk.solve_linear(s).displacement((1.0, 0.5))[2]
                    for s in (driven, system_on(theory, [sk.Clamp("left")], loads=[load])))  # fmt: skip
    assert tip < 0 and np.isclose(tip, clamped, rtol=0.05), "a clamp that does not stretch is a little stiffer"


@theories
def test_a_run_follows_it(theory):
    system = system_on(theory, [sk.DrivenClamp("left", tuple(AXIS), tuple(THROUGH), angle, lambda t: (0, 0, t**2))])
    motion = sk.simulate(system, 0.2, rtol=1e-3, outputs=5, progress=False)
    edge = system.geometry.nodes_on("left")
    for t, q in zip(motion.times[1:], motion.q[1:], strict=True):
        expected = moved(system, t, edge)
        expected[:, 0] += np.array([0, 0, t**2]) - shift(t)
        # Between steps states are cubics.
        assert np.allclose(q.reshape(-1, 4, 3)[edge], expected, rtol=0, atol=1e-4)
    assert np.allclose(motion.q[-1].reshape(-1, 4, 3)[edge], expected, rtol=0, atol=1e-12)
    assert np.abs(expected - system.undeformed.reshape(-1, 4, 3)[edge]).max() > 0.05


def test_tables_that_do_not_cover_a_run():
    for options in ({"angle": sk.Table([0.0, 1.0], [0.0, 1.0])}, {"displacement": Known()}):
        system = system_on("full", [sk.DrivenClamp("left", **options)])
        check_covers(system.histories(), 0.0, 1.0)
        with pytest.raises(InputError, match=f"{next(iter(options))} from t = 0 to 1 s does not cover the run"):
            check_covers(system.histories(), 0.0, 2.0)


class Known:
    span = (0.0, 1.0)

    def __call__(self, t):
        return (t, 0.0, 0.0)


@theories
@pytest.mark.parametrize("other", [sk.Pin("left"), sk.Clamp("bottom"), sk.Prescribed("left", (0.1, None, None)),
                                   sk.Symmetry("bottom"), sk.DrivenClamp("left", angle=lambda t: 2 * t)],
                         ids=["pin", "clamp", "prescribed", "symmetry", "another"])  # fmt: skip
def test_conflicts_are_refused(theory, other):
    driven = sk.DrivenClamp("left", tuple(AXIS), tuple(THROUGH), angle)
    with pytest.raises(InputError, match="prescribe different values for the same coordinate"):
        system_on(theory, [driven, other])


@theories
def test_what_agrees_is_no_conflict(theory):
    """A pin on the axis, and a roller along the axis."""
    supports = [sk.DrivenClamp("left", angle=angle), sk.Pin((0.0, 0.0)), sk.Roller("bottom")]
    system = system_on(theory, supports)
    assert np.allclose(system.prescribed(sk.Case(time=0.5)).reshape(-1, 4, 3)[system.geometry.node_at((0.0, 0.0)), 0], 0.0)


@pytest.mark.parametrize(("build", "words"), [
    (lambda: sk.DrivenClamp("left"), "without angle and displacement"),
    (lambda: sk.DrivenClamp("left", angle=0.3), "angle = 0.3: give a function of time"),
    (lambda: sk.DrivenClamp("left", displacement=(0, 0, 1.0)), "displacement = .*give a function of time"),
    (lambda: sk.DrivenClamp("left", axis=(0, 0, 0), angle=angle), "axis = .*direction"),
    (lambda: sk.DrivenClamp("left", through=(0, 0), angle=angle), "through = .*3 numbers"),
    (lambda: system_on("full", [sk.DrivenClamp("left", angle=lambda t: np.nan)]).prescribed(sk.Case(time=0.5)),
     r"angle at t = 0\.5 = nan"),
    (lambda: system_on("full", [sk.DrivenClamp("left", displacement=lambda t: (t, t))]).prescribed(sk.Case(time=0.5)),
     r"displacement at t = 0\.5 = .*3 numbers"),
    (lambda: system_on("full", [sk.DrivenClamp("nowhere", angle=angle)]), "no boundary 'nowhere'"),
])  # fmt: skip
def test_mistakes(build, words):
    with pytest.raises(InputError, match=words):
        build()


ENTRIES = {
    "solve": lambda system: sk.solve(system).solution,
    "solve by arc length": lambda system: sk.solve(system, follow=True).solution,
    "solve_linear": sk.solve_linear,
    "trace": lambda system: sk.trace(system, until=1.0).solution,
    "adapt": lambda system: sk.adapt(system.problem, sk.Displacement(at=(1.0, 0.5)), theory="kirchhoff", rtol=1e-2).solution,
}
PULLED = [sk.EdgeLoad("right", (-50.0, 0.0, -1e-3))]


@pytest.mark.parametrize("entry", ENTRIES)
def test_statics_without_a_time_says_so_once_and_with_one_takes_it(entry):
    def driven(static=None):
        clamp = sk.DrivenClamp("left", angle=lambda t: 0.3 + t, displacement=lambda t: (0.0, 0.0, 0.1 * t**2), static=static)
        return system_on("kirchhoff", [clamp], loads=PULLED)

    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        solution = ENTRIES[entry](driven())
    told = [one for one in told if "membrane strains" not in str(one.message)]  # the mesh is coarse for that load
    assert len(told) == 1 and told[0].category is sk.OutOfDepth and told[0].filename == __file__
    assert "statics has no time" in str(told[0].message) and "static=" in str(told[0].message)
    edge = solution.system.geometry.nodes_on("left")
    assert np.array_equal(solution.q.reshape(-1, 4, 3)[edge], solution.system.undeformed.reshape(-1, 4, 3)[edge])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", ".*membrane strains")  # the mesh is coarse for that load
        moved_there = ENTRIES[entry](driven(1.0))
    y = np.array([0.0, 0.5, 1.0])
    expected = np.stack([-np.sin(1.3) * y, np.cos(1.3) * y - y, np.full(3, 0.1)], axis=1)
    assert np.allclose(moved_there.displacement([(0.0, eta) for eta in y]), expected, atol=1e-9)


@pytest.mark.parametrize("ask", [
    lambda s: sk.modes(s, 2), lambda s: sk.buckling(s, 1),
    lambda s: sk.adapt(s.problem, sk.Eigenfrequency(0), theory="kirchhoff", rtol=0.1),
    lambda s: sk.adapt(s.problem, sk.BucklingLoad(0), theory="kirchhoff", rtol=0.1),
])  # fmt: skip
def test_modes_and_buckling_say_it_too(ask):
    def driven(**options):
        return system_on("kirchhoff", [sk.DrivenClamp("left", angle=lambda t: 3.0 * t, **options)], loads=PULLED)

    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        ask(driven())
    assert [(w.category, w.filename) for w in told] == [(sk.OutOfDepth, __file__)]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ask(driven(static=0.0))
