"""What loads and supports say of the regularity of solutions, what follows from it, and that numbers bear it out."""

from typing import Any

import numpy as np
import pytest

import skancf as sk
from skancf.adaptive import drift, no_limit
from skancf.adaptive.refined import enriched_mesh
from skancf.adaptive.singular import singular_points, touching
from skancf.errors import InputError
from skancf.loads import Singularity
from skancf.loads.acting import Acting, at_points
from skancf.recovered import cuts
from skancf.supports import Support
from skancf.supports.conditions import Row
from skancf.system.regularity import singularities
from skancf.terms import Addition, Term

PLATE, MIDDLE, DOWN = sk.Rectangle(1.0, 1.0), (0.5, 0.5), (0.0, 0.0, -1.0)
THEORIES = ["kirchhoff", "full"]
theories = pytest.mark.parametrize("theory", THEORIES)
MOVED: Any = {"displacement": lambda t: (0.0, 0.0, t)}
CLAMPED, MOMENT = sk.Clamp("left"), sk.PointMoment(MIDDLE, (0.0, 1.0, 0.0))
AT_MIDDLE, TIP = sk.SectionForce("M11", at=MIDDLE), sk.Displacement((1.0, 0.5))


def inner_line(x, y):
    return abs(x - 0.5) < 1e-9


def hub(x, y):
    return (abs(x - 0.5) < 0.26) & (abs(y - 0.5) < 0.26)


def on(theory, supports=(CLAMPED,), loads=(), n=4, thickness=0.1):
    problem = sk.Problem(PLATE, thickness, sk.Isotropic(1.0, 0.3, 1.0), list(supports), list(loads))
    return problem.on(sk.meshes.uniform(PLATE, n, n), theory)


# --- what they say ---------------------------------------------------------------------------------------------------

SAID = {
    "PointForce": (sk.PointForce(MIDDLE, DOWN), {"force"}, 1, 1),
    "PointMoment": (MOMENT, {"moment"}, 1, 1),
    "MovingForce": (sk.MovingForce(lambda t: (0.3 + t, 0.5), DOWN), {"force"}, 1, 1),
    "MovingForce outside": (sk.MovingForce(lambda t: (t - 0.3, 0.5), DOWN), {"force"}, 0, 0),
    "MovingLine": (sk.MovingLine(lambda t: (0.3 + t, 0.5), (0.6, 0.6), DOWN), {"force"}, 2, 0),
    "LineLoad": (sk.LineLoad((0.1, 0.2), (0.6, 0.2), DOWN), {"force"}, 2, 0),
    "EdgeLoad": (sk.EdgeLoad("right", DOWN), {"force"}, 2, 0),
    "EdgeMoment": (sk.EdgeMoment("right", (0.0, 1.0, 0.0)), {"moment"}, 2, 0),
    "Impulse": (sk.Impulse(MIDDLE, DOWN), {"force"}, 1, 1),
    "EdgeImpulse": (sk.EdgeImpulse("right", DOWN), {"force"}, 2, 0),
    "DiskForce": (sk.DiskForce(MIDDLE, 0.1, DOWN), set(), 0, 0),
    "Gravity": (sk.Gravity(), set(), 0, 0),
    "SurfaceLoad": (sk.SurfaceLoad(DOWN), set(), 0, 0),
    "FollowerPressure": (sk.FollowerPressure(1.0), set(), 0, 0),
    "Temperature": (sk.Temperature(1.0), set(), 0, 0),
    "Clamp": (sk.Clamp("right"), {"position", "normal"}, 2, 0),
    "Pin": (sk.Pin(["right", MIDDLE]), {"position"}, 3, 1),
    "SimpleSupport": (sk.SimpleSupport("right", "hard"), {"position", "tilt"}, 2, 0),
    "Roller": (sk.Roller(MIDDLE), {"part"}, 1, 1),
    "NoRotation": (sk.NoRotation(MIDDLE), {"normal"}, 1, 1),
    "Symmetry": (sk.Symmetry("right"), {"mirror"}, 2, 0),
    "DrivenClamp": (sk.DrivenClamp([MIDDLE, (0.25, 0.5)], **MOVED), {"position", "normal"}, 2, 2),
    "hub": (sk.DrivenClamp(hub, **MOVED), {"position", "normal"}, 9, 0),
    "inner line": (sk.Pin(inner_line), {"position"}, 5, 0),
    "Prescribed": (sk.Prescribed(MIDDLE, (0.0, None, 0.1)), {"part"}, 1, 1),
    "Prescribed wholly": (sk.Prescribed(MIDDLE, lambda x, y: (x, y, 0.1)), {"position"}, 1, 1),
    "Prescribed rotation": (sk.Prescribed(MIDDLE, rotation=(0.0, 0.1, 0.0)), {"normal"}, 1, 1),
    "Spring": (sk.Spring(MIDDLE, (0, 0, 1.0)), {"part"}, 1, 1),
    "Dashpot": (sk.Dashpot(MIDDLE, (0, 0, 1.0)), {"part"}, 1, 1),
    "Foundation": (sk.Foundation(1.0), set(), 0, 0),
}  # fmt: skip


@theories
@pytest.mark.parametrize("name", SAID)
def test_what_each_says(name, theory):
    """Its kinds, how many points, and how many of them are single."""
    item, kinds, points, single = SAID[name]
    system = on(theory, [item], []) if hasattr(item, "rows") else on(theory, [], [item])
    found = singularities(system)
    assert {kind for each in found for kind in each.kinds} == kinds
    assert sum(each.points.shape[1] for each in found) == points
    assert sum(each.alone.shape[1] for each in found) == single
    assert all(type(item).__name__ in each.words for each in found)
    assert all(each.at_rest == (name not in ("Impulse", "EdgeImpulse", "Dashpot")) for each in found)
    assert set(SAID) > {kind.__name__ for kind in sk.supports.ALL + sk.loads.ALL}


def test_the_place_of_a_load_that_moves_is_that_of_the_time():
    load = sk.MovingForce(sk.Path([0.0, 1.0], [(0.2, 0.5), (0.6, 0.5)]), DOWN)
    (there,) = singularities(on("full", loads=[load]), sk.history.Case(time=0.5))[1:]
    assert there.moves and np.allclose(there.points.T, [(0.4, 0.5)])


@pytest.mark.parametrize(("build", "words"), [
    (lambda: Singularity("forces", MIDDLE, "a Screw"), "kinds = 'forces'.*force"),
    (lambda: Singularity((), MIDDLE, "a Screw"), "kinds"),
    (lambda: Singularity("normal", (0.5, 0.5, 0.5), "a Screw"), r"points of shape \(3,\)"),
    (lambda: Singularity("normal", (0.5, np.nan), "a Screw"), "points.*not finite"),
    (lambda: Singularity("force", MIDDLE, "a Screw"), "vector: missing; a Screw at a single point"),
    (lambda: Singularity("force", MIDDLE, "a Screw", (1.0, 2.0)), "vector.*give 3 numbers"),
])  # fmt: skip
def test_mistakes(build, words):
    with pytest.raises(InputError, match=words):
        build()


# --- what follows ----------------------------------------------------------------------------------------------------

POINT = {
    "driven": sk.DrivenClamp(MIDDLE, **MOVED),
    "rotation": sk.Prescribed(MIDDLE, (0, 0, 0), rotation=(0.0, 0.1, 0.0)),
    "clamped": sk.Clamp(MIDDLE),
}


@theories
@pytest.mark.parametrize("support", POINT)
def test_a_normal_held_at_a_single_point(support, theory):
    system = on(theory, [POINT[support]])
    assert "(0.5, 0.5)" in drift(system) and ("normal is held" in drift(system)) == (theory == "kirchhoff")
    assert f"{type(POINT[support]).__name__} holds this single point" in no_limit(AT_MIDDLE, system)


@theories
@pytest.mark.parametrize("support", [sk.DrivenClamp("left", **MOVED), sk.DrivenClamp(hub, **MOVED), sk.Clamp(hub),
                                     sk.Pin(inner_line), sk.Dashpot(MIDDLE, (0, 0, 1.0))])  # fmt: skip
def test_what_is_no_single_point(support, theory):
    """Edges, a part of the surface, a line that a function finds on each mesh; and dashpots hold nothing at rest."""
    system = on(theory, [support])
    assert drift(system) is None and no_limit(AT_MIDDLE, system) is None
    assert drift(on("full", [sk.Pin([(0.5, 0.25), MIDDLE])])), "points that are neighbours on this mesh alone"


def test_points_that_an_edge_holds_anyway():
    corner, edge = (0.0, 0.0), "left"
    for holding in (sk.Clamp(edge), sk.Pin(edge), sk.DrivenClamp(edge, **MOVED), sk.Prescribed(edge, (0.0, 0.0, 0.0))):
        assert drift(on("full", [holding, sk.Spring(corner, (1.0, 1.0, 1.0))])) is None
    assert drift(on("full", [sk.Roller(edge), sk.Roller(corner)]))
    assert drift(on("kirchhoff", [sk.Clamp(edge), sk.NoRotation(corner)])) is None
    assert drift(on("kirchhoff", [sk.Pin(edge), sk.NoRotation(corner)]))


@theories
def test_a_moment_at_a_point(theory):
    system, about_it = on(theory, loads=[MOMENT]), sk.Rotation(MIDDLE, (1.0, 0.0, 0.0))
    assert "a PointMoment acts there, (0, 1, 0) N m" in no_limit(AT_MIDDLE, system)
    for quantity, place in ((about_it, "there"), (sk.StrainEnergy(), r"at (0.5, 0.5)")):
        assert f"a PointMoment {place} turns its point" in no_limit(quantity, system)
    for quantity in (sk.Displacement(MIDDLE), sk.Rotation(MIDDLE, (0.0, 1.0, 0.0)), sk.Rotation((0.5, 0.6), (1.0, 0, 0))):
        assert no_limit(quantity, system) is None
    assert no_limit(about_it, on(theory, loads=[sk.PointMoment(MIDDLE, (0.0, 0.0, 0.0))])) is None
    assert "PointMoment" in no_limit(sk.SectionForce("M12", at=(1.0, 1.0)), on(theory, loads=[
        sk.PointMoment((1.0, 1.0), (0.0, 1.0, 0.0))])), "no twisting moment of a free corner carries it"  # fmt: skip


def test_a_load_that_moves_counts_where_it_stands_in_statics():
    system = on("full", loads=[sk.MovingForce(lambda t: (0.5 + t, 0.5), DOWN)])
    assert "a MovingForce" in no_limit(AT_MIDDLE, system) and "a MovingForce" in no_limit(sk.Displacement(MIDDLE), system)
    with pytest.raises(sk.NoLimit, match="MovingForce"):
        sk.adapt(system.problem, sk.StrainEnergy(), 1e-2, linear=True, theory="full")
    assert not cuts(system).nodes.size or not near(system, cuts(system).nodes, MIDDLE), "moments are recovered at any time"


def near(system, nodes, at) -> bool:
    return bool((np.abs(system.mesh.p[:, nodes].T - at).max(axis=1) < 1e-9).any())


# --- numbers ---------------------------------------------------------------------------------------------------------


def half_loaded(x, y):
    return np.stack([0 * x, 0 * x, 1e-6 * (x > 0.5)])


def growth(quantity, theory, supports, load) -> float:
    """The last change between meshes of 8, 16 and 32 elements a side, over the one before it."""
    systems = (on(theory, supports, [load], n, 0.5) for n in (8, 16, 32))
    coarse, middle, fine = (quantity.value(sk.solve_linear(system)) for system in systems)
    return (fine - middle) / (middle - coarse)


HALF = sk.SurfaceLoad(half_loaded)
LEGS = sk.Spring([(x, y) for x in (0.25, 0.75) for y in (0.25, 0.75)], (10.0, 10.0, 10.0))
# Measured 0.997, 0.997 and 0.998 twice with theory `kirchhoff`, and 0.91 with `full`.
GROW = {
    "driven": (TIP, "kirchhoff", [POINT["driven"]], HALF),
    "rotation": (TIP, "kirchhoff", [POINT["rotation"], sk.Roller("bottom", (1.0, 0.0, 0.0))], HALF),
    "turns": (sk.Rotation(MIDDLE, (1, 0, 0)), "kirchhoff", [CLAMPED], sk.PointMoment(MIDDLE, (0, 1e-6, 0))),
    "energy": (sk.StrainEnergy(), "kirchhoff", [CLAMPED], sk.PointMoment(MIDDLE, (0, 1e-6, 0))),
    "legs": (sk.Displacement(MIDDLE), "full", [LEGS], sk.SurfaceLoad((0, 0, 1e-6))),
}
# Measured 0.55, 0.22, 0.22, 0.25 and 0.43.
LIMIT = {
    "hub": (TIP, "kirchhoff", [sk.DrivenClamp(hub, **MOVED)], HALF),
    "edge": (TIP, "kirchhoff", [sk.DrivenClamp("left", **MOVED)], HALF),
    "moved": (sk.Displacement(MIDDLE), "kirchhoff", [CLAMPED], sk.PointMoment(MIDDLE, (0, 1e-6, 0))),
    "legs": (sk.Displacement(MIDDLE), "kirchhoff", [LEGS], sk.SurfaceLoad((0, 0, 1e-6))),
    "line": (TIP, "full", [sk.Pin(inner_line), sk.Pin("left")], HALF),
}


@pytest.mark.filterwarnings("ignore::skancf.OutOfDepth")
@pytest.mark.parametrize("name", [f"{name} grows" for name in GROW] + list(LIMIT))
def test_the_numbers_bear_it_out(name):
    """What grows with a logarithm changes by the same amount each time; what has a limit by less and less. Each is warned
    of, or refused, or neither."""
    grows = name.endswith("grows")
    quantity, theory, supports, load = GROW[name.removesuffix(" grows")] if grows else LIMIT[name]
    found = growth(quantity, theory, supports, load)
    assert found > 0.85 if grows else found < 0.6
    system = on(theory, supports, [load])
    assert bool(drift(system) or no_limit(quantity, system)) == grows


# --- of a user's own -------------------------------------------------------------------------------------------------


class Screw:
    """A point force as a user may write it, in an attribute ``at`` of another meaning too."""

    at = "some time"

    def __init__(self, place, force):
        self.place, self.force = place, force

    def on(self, assembly):
        return ScrewOnMesh(assembly.geometry, self)


class ScrewOnMesh(Acting):
    def __init__(self, geometry, screw):
        element, local = geometry.locate(screw.place)
        self.screw, self.nodal = screw, at_points([element], local[None], np.array([screw.force])).nodal(geometry)

    def force(self, q, case):
        return case.amplitude(None) * self.nodal

    def singularities(self, case):
        return [Singularity("force", self.screw.place, "a Screw", self.screw.force)]


class Silent(ScrewOnMesh):
    singularities = Acting.singularities


class Foot(Support):
    """Holds the deflection at a node, by a row of its own, and says so."""

    where = 3.0

    def __init__(self, place, says=True):
        self.place, self.says = place, says

    def rows(self, geometry):
        return [Row(self._node(geometry), np.eye(12)[2])]

    def singularities(self, geometry):
        return [Singularity("part", self.place, "a Foot")] if self.says else []

    def _node(self, geometry):
        return int(np.argmin(np.linalg.norm(geometry.mesh.p.T - self.place, axis=1)))


@theories
def test_a_load_of_ones_own(theory):
    """As the library's own, in rules and on the meshes of :func:`skancf.adapt`."""
    own, ours = (on(theory, loads=[load]) for load in (Screw((0.4, 0.5), DOWN), sk.PointForce((0.4, 0.5), DOWN)))
    assert np.array_equal(singular_points(own), singular_points(ours))
    for quantity in (sk.SectionForce("M11", at=(0.4, 0.5)), sk.Displacement((0.4, 0.5)), sk.StrainEnergy(), TIP):
        theirs = no_limit(quantity, ours)
        assert no_limit(quantity, own) == (theirs and theirs.replace("PointForce", "Screw"))
    assert np.array_equal(own.loads.places(), ours.loads.places())
    mine, known = (sk.adapt(system.problem, TIP, 0.1, linear=True, theory=theory, mesh=system.mesh)
                   for system in (own, ours))  # fmt: skip
    assert mine.value == known.value and np.array_equal(mine.solution.system.mesh.t, known.solution.system.mesh.t)


def test_the_mesh_is_refined_where_it_says():
    quiet = type("Quiet", (Screw,), {"on": lambda self, assembly: Silent(assembly.geometry, self)})
    depths = []
    for kind in (Screw, quiet):
        problem = on("kirchhoff", loads=[kind(MIDDLE, DOWN)]).problem
        system = problem.on(sk.meshes.quadtree(sk.meshes.uniform(PLATE, 4, 4)), "kirchhoff")
        mesh = enriched_mesh(system, singular_points(system))
        depths.append(mesh.levels[touching(mesh.leaves, np.array([MIDDLE]).T)].max())
    assert depths == [5, 1], "every element once, and those at the screw four times more"
    with pytest.raises(sk.NoLimit, match="a Screw acts there"):
        sk.adapt(on("kirchhoff", loads=[Screw(MIDDLE, DOWN)]).problem, AT_MIDDLE, 1e-2, linear=True)


@pytest.mark.filterwarnings("ignore::skancf.OutOfDepth")
def test_a_support_of_ones_own():
    """In a static solve, in :func:`skancf.adapt`, and in modes as the library's own; it says what a roller says."""
    load = [sk.SurfaceLoad((0, 0, -1e-3))]
    own, ours = (on("full", [CLAMPED, support], load) for support in (Foot(MIDDLE), sk.Roller(MIDDLE)))
    assert np.array_equal(sk.solve_linear(own).q, sk.solve_linear(ours).q)
    assert np.array_equal(sk.modes(own, 3).eigenvalues, sk.modes(ours, 3).eigenvalues)
    assert drift(own) == drift(ours) and np.array_equal(singular_points(own), singular_points(ours))
    assert no_limit(AT_MIDDLE, own) == no_limit(AT_MIDDLE, ours).replace("Roller", "Foot")
    mesh = own.mesh
    with pytest.warns(sk.OutOfDepth, match=r"single points, \(0.5, 0.5\)"):
        mine = sk.adapt(own.problem, TIP, 0.2, linear=True, theory="full", mesh=mesh)
    assert mine.value == sk.adapt(ours.problem, TIP, 0.2, linear=True, theory="full", mesh=mesh).value
    assert drift(on("full", [CLAMPED, Foot(MIDDLE, says=False)], load)) is None


class Pillar(Addition, Term):
    """A spring at a node as an energy of one's own."""

    def on(self, shell, layout):
        self.node = int(shell.geometry.nodes_on(MIDDLE)[0])
        self.at, self.n_dofs, self.start = 12 * self.node + 2, layout.n_dofs, layout.undeformed.ravel()
        return self

    def couples(self):
        return np.array([[self.node]])

    def force(self, q, v, case):
        out = np.zeros(self.n_dofs)
        out[self.at] = 5.0 * (q - self.start)[self.at]
        return out

    def add_tangent(self, q, v, case, blocks):
        matrix = np.zeros((1, 12, 12))
        matrix[0, 2, 2] = 5.0
        blocks.add(self.couples(), matrix)

    def energy(self, q, case):
        return 2.5 * float((q - self.start)[self.at]) ** 2

    def singularities(self, case):
        return [Singularity("part", MIDDLE, "a Pillar")]


def test_a_term_of_ones_own():
    plate, load = on("full"), sk.SurfaceLoad((0, 0, -1e-3))
    own = sk.Problem(PLATE, 0.1, sk.Isotropic(1.0, 0.3, 1.0), [CLAMPED], [load], terms=[Pillar()]).on(plate.mesh, "full")
    ours = on("full", [CLAMPED, sk.Spring(MIDDLE, (0, 0, 5.0))], [load])
    assert np.allclose(sk.solve_linear(own).q, sk.solve_linear(ours).q, rtol=0, atol=1e-9)
    assert drift(own) == drift(ours) and np.array_equal(singular_points(own), singular_points(ours))
    assert no_limit(AT_MIDDLE, own) == no_limit(AT_MIDDLE, ours).replace("Spring", "Pillar")


@pytest.mark.parametrize("found", [None, [MIDDLE], "force"])
def test_what_is_no_singularity_is_named(found):
    foot = type("Wrong", (Foot,), {"singularities": lambda self, geometry: found})
    with pytest.raises(InputError, match=r"support\.singularities of .*give a list"):
        singularities(on("full", [foot(MIDDLE)]))
    screw = type("WrongOnMesh", (ScrewOnMesh,), {"singularities": lambda self, case: found})
    load = type("WrongLoad", (Screw,), {"on": lambda self, assembly: screw(assembly.geometry, self)})
    with pytest.raises(InputError, match=r"load\.singularities of .*give a list"):
        singularities(on("full", loads=[load(MIDDLE, DOWN)]))


def test_what_a_place_says_without_a_word():
    """A support of one's own with a place counts as before: held there, and ``holds`` says more."""
    own = type("Glue", (Support,), {"where": MIDDLE, "rows": lambda self, geometry: []})
    (said,) = singularities(on("full", [own()]))
    assert said.kinds == ("part",) and said.words == "a Glue"
    both = type("Adhesive", (own,), {"holds": ("position", "normal"), "kind": "hard"})
    (said,) = singularities(on("full", [both()]))
    assert said.kinds == ("position", "normal", "tilt") and said.words == "an Adhesive"
