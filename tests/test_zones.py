"""Zones: stepped beams, layups, lines of meshes, borders that the estimate sees, and what is wrong with them."""

import numpy as np
import pytest
from scipy.integrate import quad

import skancf as sk
from skancf.errors import InputError
from skancf.materials import Section

L, B, H, E, RHO = 1.0, 0.1, 0.01, 2e11, 7800.0
STRIP = sk.Rectangle(L, B)
TUBE = sk.CylinderSector(1.0, 1.0, angle=2 * np.pi, closed=True)
LAW = sk.Isotropic(E, 0.0, RHO)
DOUBLER = sk.Zone("doubler", ((0.3, 0.5), (-1.0, 1.0)), thickness=2 * H)
MIDDLE = np.array([[0.5], [0.5]])
theories = pytest.mark.parametrize("theory", ["full", "kirchhoff"])


def strip(zones=(DOUBLER,), n=10, theory="kirchhoff", loads=(), **more):
    given = {"thickness": H, "material": LAW} | more
    problem = sk.Problem(STRIP, supports=[sk.Clamp("left")], loads=list(loads), zones=list(zones), **given)
    return problem.on(sk.meshes.with_lines(STRIP, n, 1, problem.zones), theory)


def stepped(start, end, stiffer=8.0):
    """w / P of a cantilever whose EI is ``stiffer`` between two places."""

    def part(a, b):
        return quad(lambda x: (L - x) ** 2, a, b)[0]

    return (part(0, start) + part(start, end) / stiffer + part(end, L)) / (E * B * H**3 / 12)


@theories
def test_a_plate_with_a_doubler_is_a_stepped_beam(theory):
    end = sk.EdgeLoad("right", (0, 0, 1 / B))
    system = strip(n=20, theory=theory, loads=[end])
    state = sk.solve_linear(system)
    # In kirchhoff cubics are exact; full is too stiff by h^2, and too soft by shear.
    tolerance = 1e-10 if theory == "kirchhoff" else 1e-3
    assert state.displacement((L, B / 2))[2] == pytest.approx(stepped(0.3, 0.5), rel=tolerance)
    assert len(system.assembly.sections.law) == 2
    assert system.inertia.total == pytest.approx(RHO * B * H * 1.2, rel=1e-13)
    x = system.mesh.p[0, system.mesh.t].mean(axis=0)
    half = np.where((x > 0.3) & (x < 0.5), H, H / 2)
    bent = -(L - x) / (B * (2 * half) ** 3 / 12) * half
    # Of recovered stresses in full, which end where the zone does.
    for z, sign in (("top", 1), ("bottom", -1)):
        assert np.allclose(state.recovered_stresses(MIDDLE, z)[:, 0, 0], sign * bent, rtol=1e-5)
    assert np.allclose(state.stresses(MIDDLE, H / 4)[:, 0, 0], bent * H / 4 / half, rtol=1e-8)


def test_layups_by_zone():
    """Plies along and across the strip, each as long as the other one: the stiffness of either part is that of its layup."""
    ply = sk.Orthotropic((4 * E, E, E), (0.0, 0.0, 0.0), (E / 2, E / 2, E / 2), RHO)
    along, both = ([sk.Layer(ply, H / len(angles), a) for a in angles] for angles in ([0.0], [np.pi / 2, 0.0, np.pi / 2]))
    zones = [sk.Zone("root", ((0.0, 0.5), (0.0, B)), material=sk.Laminate(both)),
             sk.Zone("tip", ((0.5, L), (0.0, B)), material=sk.Laminate(along))]  # fmt: skip
    system = strip(zones, thickness=None, material=None, loads=[sk.EdgeLoad("right", (0, 0, 1 / B))])
    # D of the cross-ply from its outer and inner thirds.
    root = (26 * 1 + 1 * 4) / 27
    expected = stepped(0.5, L, 4.0) + (1 / root - 1) * quad(lambda x: (L - x) ** 2, 0, 0.5)[0] / (E * B * H**3 / 12)
    assert sk.solve_linear(system).displacement((L, B / 2))[2] == pytest.approx(expected, rel=1e-10)
    sections = system.assembly.section
    assert sections.at(MIDDLE).z.shape[-1] == 4 and [len(each.density) for each in sections.samples()] == [3, 1]


def test_a_doubler_on_one_side_is_off_the_surface():
    """Its mid-plane is above: the plate bends as a beam whose centroid jumps, the sum of both parts' parallel axes."""
    zone = sk.Zone("patch", ((0.5, L), (0.0, B)), thickness=2 * H, offset=H / 2)
    pull = sk.EdgeMoment("right", (0, -1.0 / B, 0))
    found = sk.solve_linear(strip([zone], loads=[pull]))
    bending = E * B * H**3 / 12
    slopes = 0.5 / bending, 0.5 / (8 * bending)
    expected = slopes[0] * (0.25 + 0.5) + slopes[1] * 0.25
    assert abs(found.displacement((L, B / 2))[2]) == pytest.approx(expected, rel=1e-2)
    # Where the centroid is off the surface, the surface is strained: by the slope times the offset.
    assert abs(found.displacement((L, B / 2))[0]) == pytest.approx(slopes[1] * H / 2, rel=2e-2)


# --- meshes ----------------------------------------------------------------------------------------------------------


def test_lines_are_where_zones_end():
    mesh = sk.meshes.with_lines(STRIP, 7, 3, [sk.Zone("a", ((0.31, 0.42), (-1, 0.07)), thickness=H)], x=[0.9])
    x, y = (np.unique(row) for row in mesh.p)
    assert {0.31, 0.42, 0.9} <= set(x) and 0.07 in y
    assert abs(len(x) - 8) <= 2 and np.ptp(mesh.p, axis=1) == pytest.approx([L, B])
    assert np.array_equal(sk.meshes.with_lines(STRIP, 4, 2).p, sk.meshes.uniform(STRIP, 4, 2).p)
    opened = sk.meshes.with_lines(STRIP, 4, 2, openings=[((0.4, 0.6), (0.03, 0.05))])
    assert "opening" in opened.boundaries


def test_thin_rows_beside_lines():
    """On both sides of ends that are inside, over seams too; not where a zone is too narrow for them."""
    zones = [sk.Zone("a", ((0.0, 0.3), (0.0, B)), thickness=H), sk.Zone("b", ((0.5, 0.51), (0.0, B)), thickness=H)]
    x = np.unique(sk.meshes.with_lines(STRIP, 4, 1, zones, beside=0.01).p[0])
    assert np.allclose([at for at in (0.29, 0.3, 0.31, 0.49, 0.5, 0.51, 0.52) if np.abs(x - at).min() < 1e-12],
                       [0.29, 0.3, 0.31, 0.49, 0.5, 0.51, 0.52])  # fmt: skip
    assert np.diff(x).min() > 0.0099 and x[1] > 0.05 and x[-2] < 0.95
    seam = sk.Zone("c", ((0.0, 1.0), (-0.5, 0.0)), thickness=H)
    y = np.unique(sk.meshes.with_lines(TUBE, 2, 8, [seam], beside=0.1).p[1])
    for at in (0.1, 2 * np.pi - 0.1, 2 * np.pi - 0.4, 2 * np.pi - 0.6):
        assert np.abs(y - at).min() < 1e-12
    with pytest.raises(InputError, match="beside = 0"):
        sk.meshes.with_lines(STRIP, 4, 1, zones, beside=0)


def test_quadtrees_keep_the_lines():
    problem = sk.Problem(STRIP, H, LAW, [sk.Clamp("left")], zones=[DOUBLER])
    tree = sk.meshes.quadtree(sk.meshes.with_lines(STRIP, 4, 1, problem.zones), STRIP).refined([1, 3])
    sections = problem.on(tree, "kirchhoff").assembly.section
    middle = tree.p[:, tree.t].mean(axis=1)
    assert np.array_equal(sections.zones == 0, (middle[0] > 0.3) & (middle[0] < 0.5))
    # A border that is divided on one side only is one, whole and in its parts.
    at = tree.p[0, tree.facets]
    assert np.array_equal(np.flatnonzero(sections.borders), np.flatnonzero(((at == 0.3) | (at == 0.5)).all(axis=0)))
    assert sections.borders.sum() > 2 and sections.beside_jumps.any() and not sections.beside_jumps.all()


# --- jumps of the membrane stiffness ---------------------------------------------------------------------------------

THICK = sk.Zone("thick", ((0.5, L), (0.0, B)), thickness=2 * H)
STRETCH = 1e-6


def bar(n, theory):
    """A strip of two thicknesses that is stretched, whose end moves by 3/4 of what the thin one would."""
    pull = sk.EdgeLoad("right", (E * H * STRETCH, 0.0, 0.0))
    problem = sk.Problem(STRIP, H, LAW, [sk.Clamp("left")], [pull], zones=[THICK])
    tree = sk.meshes.quadtree(sk.meshes.with_lines(STRIP, n, 1, problem.zones), STRIP)
    return sk.solve_linear(problem.on(tree, theory))


@pytest.mark.parametrize("theory", ["full", sk.theories.Kirchhoff(assumed=False)])
def test_a_jump_of_membrane_stiffness_is_of_order_one_and_the_estimate_sees_it(theory):
    errors = []
    for n in (4, 8, 16):
        state = bar(n, theory)
        errors.append(0.75 - state.displacement((L, B / 2))[0] / STRETCH)
        seen = sk.goal_estimate(state, sk.Displacement((L, B / 2), (1.0, 0.0, 0.0)))
        assert 0.9 < seen.error / STRETCH / errors[-1] < 1.1
        assert seen.bar / STRETCH > errors[-1]
    # Slopes of nodes on the line are one, and strains jump there.
    assert np.allclose(errors, np.multiply(0.75, [6.5e-3, 3.2e-3, 1.6e-3]), rtol=0.12)


def test_assumed_membrane_strains_hardly_feel_it():
    """What their assumption leaves out counts as little as it does against locking: less than 0.04 of thickness over length,
    which is what a step in the thickness changes in the solid anyway."""
    errors = [0.75 - bar(n, "kirchhoff").displacement((L, B / 2))[0] / STRETCH for n in (4, 8, 16, 32, 64)]
    assert 0 < max(errors) < 0.04 * H / L
    assert errors[0] < 1e-2 * (0.75 - bar(4, sk.theories.Kirchhoff(assumed=False)).displacement((L, B / 2))[0] / STRETCH)


@pytest.mark.parametrize("offset", [0.0, 0.5])
def test_error_bars_hold_where_assumed_strains_begin_to_feel_the_line(offset):
    """Elements a few times as long as the plate is thick: a finer mesh has the same error, and the estimate hardly sees it.
    A doubler on one side bends the strip where it is pulled, and strains it where it is bent."""
    h, moment = 0.04, offset > 0
    zone = sk.Zone("thick", ((0.5, L), (0.0, B)), thickness=2 * h, offset=offset * h)
    load = sk.EdgeMoment("right", (0, -1.0, 0)) if moment else sk.EdgeLoad("right", (1.0, 0.0, 0.0))
    exact = (3 / 8 + 1 / 64) / (E * h**3 / 12) if moment else 0.75 / (E * h)
    end = sk.Displacement((L, B / 2), (0, 0, 1.0) if moment else (1.0, 0, 0))
    errors = []
    for n in (4, 8, 16, 32, 64):
        problem = sk.Problem(STRIP, h, LAW, [sk.Clamp("left")], [load], zones=[zone])
        tree = sk.meshes.quadtree(sk.meshes.with_lines(STRIP, n, 1, problem.zones), STRIP)
        seen = sk.goal_estimate(sk.solve_linear(problem.on(tree, "kirchhoff")), end)
        errors.append(exact / seen.value - 1)
        assert errors[-1] < seen.bar / seen.value
    assert max(errors[1:3]) > 1.5 * errors[0] and seen.bar / seen.value < 2 * errors[-1]


@pytest.mark.filterwarnings("ignore:theory 'full'")
@pytest.mark.parametrize("theory", ["full", sk.theories.Kirchhoff(assumed=False)])
def test_the_estimate_sees_what_an_offset_that_jumps_costs(theory):
    zone = sk.Zone("patch", ((0.5, L), (0.0, B)), thickness=2 * H, offset=H / 2)
    problem = sk.Problem(STRIP, H, LAW, [sk.Clamp("left")], [sk.EdgeMoment("right", (0, -1.0 / B, 0))], zones=[zone])
    exact, errors = 0.375 + 1 / 64, []
    for n in (8, 16, 32):
        tree = sk.meshes.quadtree(sk.meshes.with_lines(STRIP, n, 1, problem.zones), STRIP)
        seen = sk.goal_estimate(sk.solve_linear(problem.on(tree, theory)), sk.Displacement((L, B / 2), (0, 0, 1.0)))
        errors.append(exact / (E * B * H**3 / 12) - seen.value)
        assert 0.8 < seen.error / errors[-1] < 1.1 and seen.bar > errors[-1]
    assert np.allclose(np.divide(errors[:-1], errors[1:]), 2.0, rtol=0.05)


@pytest.mark.parametrize("theory", ["full", sk.theories.Kirchhoff(assumed=False)])
def test_thin_rows_cure_a_jump(theory):
    """The error is that of elements as wide as the row, whatever the others are; estimate and bar know."""
    pull, end = sk.EdgeLoad("right", (E * H * STRETCH, 0.0, 0.0)), sk.Displacement((L, B / 2), (1.0, 0.0, 0.0))
    problem, errors = sk.Problem(STRIP, H, LAW, [sk.Clamp("left")], [pull], zones=[THICK]), []
    for beside in (None, H / 2, H / 4):
        tree = sk.meshes.quadtree(sk.meshes.with_lines(STRIP, 8, 1, problem.zones, beside=beside), STRIP)
        seen = sk.goal_estimate(sk.solve_linear(problem.on(tree, theory)), end)
        errors.append(0.75 - seen.value / STRETCH)
        assert 0.9 < seen.error / STRETCH / errors[-1] < 1.1 and seen.bar / STRETCH > errors[-1]
    assert errors[0] > 20 * errors[1] and errors[1] / errors[2] == pytest.approx(2.0, rel=0.02)


def test_a_thin_row_around_a_doubler_in_a_sheet():
    """In two dimensions, with twice the unknowns: an eighth of the error, against a finer mesh with a thinner row."""
    plate, h = sk.Rectangle(1.0, 1.0), 0.01
    zone = sk.Zone("patch", ((0.25, 0.75), (0.25, 0.75)), thickness=2 * h)
    problem = sk.Problem(plate, h, sk.Isotropic(E, 0.3, RHO), [sk.Clamp("left")], [sk.EdgeLoad("right", (1e3, 0, 0))],
                         zones=[zone])  # fmt: skip

    def stretched(n, beside):
        return sk.solve_linear(problem.on(sk.meshes.with_lines(plate, n, n, [zone], beside=beside), "full")).displacement(
            (1.0, 0.5))[0]  # fmt: skip

    fine = stretched(24, h / 4)
    assert abs(stretched(8, h / 2) / fine - 1) < abs(stretched(8, None) / fine - 1) / 7 < 7e-4


def test_adaptivity_goes_to_the_line():
    pull = sk.EdgeLoad("right", (E * H * STRETCH, 0.0, 0.0))
    problem = sk.Problem(STRIP, H, LAW, [sk.Clamp("left")], [pull], zones=[THICK])
    found = sk.adapt(problem, sk.Displacement((L, B / 2), (1.0, 0.0, 0.0)), rtol=1e-3, theory="full")
    assert found.ok and abs(found.value / STRETCH / 0.75 - 1) < 1e-3
    mesh = found.solution.system.mesh
    smallest = np.ptp(mesh.p[:, mesh.t], axis=1)[0]
    finest = np.flatnonzero(smallest < 1.01 * smallest.min())
    at = mesh.p[0, mesh.t[:, finest]]
    assert (np.abs(at - 0.5).min(axis=0) < 2.01 * smallest.min()).all() and smallest.max() > 4 * smallest.min()


# --- bad input -------------------------------------------------------------------------------------------------------


def zone(name="a", where=((0.0, 0.5), (0.0, B)), **given):
    return sk.Zone(name, where, **(given or {"thickness": H}))


WRONG = {
    "overlap": (lambda: strip([zone(), zone("b", ((0.4, 0.6), (0.0, 0.05)))]), "'a' and 'b' overlap, near .*0.45, 0.025"),
    "functions overlap": (lambda: strip([zone(where=lambda x, y: x < 0.5), zone("b", lambda x, y: x < 0.3)]), "'a' and 'b'"),
    "gap": (lambda: strip([zone("a", material=LAW, thickness=H), zone("b", ((0.7, 1.0), (0, B)), thickness=H, material=LAW)],
                          thickness=None, material=None), "none holds .*next to 'a' and 'b'"),
    "no line": (lambda: sk.Problem(STRIP, H, LAW, zones=[zone()]).on(sk.meshes.uniform(STRIP, 3, 1)),
                r"'a' ends at x = 0.5, .*element 1 reaches from x = 0.333333 to 0.666667; put .*with_lines"),
    "cut": (lambda: strip([zone(where=lambda x, y: x < 0.33)]), "'a' ends inside element 3"),
    "nowhere": (lambda: strip([zone(where=((2.0, 3.0), (0.0, B)))]), "'a': no element .*x from 0 to 1"),
    "twice": (lambda: strip([zone(), zone("a", ((0.6, 1.0), (0.0, B)))]), "two have the name 'a'"),
    "nothing": (lambda: sk.Zone("a", ((0.0, 0.5), (0.0, B))), "'a': its section is that of the problem"),
    "rectangle": (lambda: zone(where=((0.5, 0.0), (0.0, B))), "x from 0.5 to 0.0 is empty"),
    "shape": (lambda: zone(where=(0.0, 0.5)), r"where of zone 'a' = \(0.0, 0.5\)"),
    "name": (lambda: zone(""), "it is empty"),
    "no list": (lambda: sk.Problem(STRIP, H, LAW, zones=zone()), "list of zones"),
    "thickness": (lambda: strip([zone(thickness=-H)]), "zone 'a': thickness = -0.01"),
    "place": (lambda: strip([zone(thickness=lambda x, y: 0.3 - x)]), r"zone 'a': thickness = -0.2 at \(x, y\) = \(0.5"),
    "sliver": (lambda: strip([zone(material=LAW), zone("b", ((0.5 + 1e-6, L), (0, B)), material=LAW)], thickness=H,
                             material=None), r"none holds \(x, y\) = \(0.5"),
    "complex": (lambda: zone(where=((0, 1j), (0, 1))), "not a number, but complex"),
    "not finite": (lambda: zone(where=((0, np.nan), (0, 1))), "nan: not finite"),
    "a number": (lambda: strip([zone(where=lambda x, y: x)]), "where of zone 'a': .* must return True or False"),
    "no material": (lambda: strip([zone()], thickness=None, material=None), "zone 'a': material = None"),
    "over a seam": (lambda: sk.Problem(TUBE, H, LAW, zones=[zone(where=((0, 1), (-0.5, 0.5)))]).on(
        sk.meshes.uniform(TUBE, 2, 8)), "'a' ends at y = 5.78319, which is no line"),
    "a turn and more": (lambda: sk.Problem(TUBE, H, LAW, zones=[zone(where=((0, 0.3), (-9, 9)))]).on(
        sk.meshes.uniform(TUBE, 2, 8)), "'a' ends at x = 0.3, which is no line"),
    "laminate": (lambda: strip([zone(material=sk.Laminate([sk.Layer(LAW, H)]), thickness=H)]), "zone 'a': thickness = 0.01"),
}  # fmt: skip


@pytest.mark.parametrize("case", WRONG)
def test_wrong_zones_are_named(case):
    build, message = WRONG[case]
    with pytest.raises(InputError, match=message):
        build()


def test_a_zone_takes_from_the_problem_what_it_does_not_say():
    zones = [zone(thickness=2 * H), zone("b", ((0.6, 1), (0, B)), offset=0.0)]
    problem = sk.Problem(STRIP, H, LAW, offset=0.001, zones=zones)
    found = problem.on(sk.meshes.with_lines(STRIP, 10, 1, problem.zones)).assembly.section.at(MIDDLE)
    assert isinstance(found, Section)
    assert np.allclose(found.z[[0, 5, 9], 0], [[0.001 - H, 0.001 + H], [0.001 - H / 2, 0.001 + H / 2], [-H / 2, H / 2]])
