"""Sections that vary, in all that is done with a problem: large deflections, paths, eigenvalues, motion, meshes, files."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.linalg import eigh

import skancf as sk
from skancf import output
from skancf.errors import InputError

L, B, H, E, RHO = 1.0, 0.1, 0.01, 2e11, 7800.0
STRIP = sk.Rectangle(L, B)
LAW = sk.Isotropic(E, 0.0, RHO)
EI = E * B * H**3 / 12
PAD = sk.Zone("pad", ((0.25, 0.5), (0.0, B)), thickness=lambda x, y: 2 * tapered(x, y))
theories = pytest.mark.parametrize("theory", ["full", "kirchhoff"])
quiet = pytest.mark.filterwarnings("ignore::skancf.errors.OutOfDepth")


def tapered(x, y):
    return H * (1 - 0.5 * x / L)


def thick(x):
    return tapered(x, 0) * (2 if 0.25 < x < 0.5 else 1)


def strip(loads=(), zones=(PAD,), supports=("left",), **more):
    return sk.Problem(STRIP, tapered, LAW, [sk.Clamp(where) for where in supports], list(loads), zones=list(zones), **more)


def tree(n=8, m=1):
    return sk.meshes.quadtree(sk.meshes.with_lines(STRIP, n, m, [PAD]), STRIP)


def integral(function, low=0.0, high=1.0):
    points = [x for x in (0.25, 0.5) if low < x < high]
    return quad(function, low, high, points=points or None, limit=200, epsabs=1e-13)[0]


# --- statics ---------------------------------------------------------------------------------------------------------


def rolled(turn, n=200):
    """The tip of a strip under an end moment M whose root sees the angle M L / EI = ``turn``: theta' = M / EI(x)."""
    x, w = np.polynomial.legendre.leggauss(8)
    edges = np.linspace(0, L, 4 * n + 1)
    theta = position = 0.0
    for a, b in pairwise(edges):
        at, weight = (a + b) / 2 + (b - a) / 2 * x, (b - a) / 2 * w
        bent = turn / L / np.array([thick(s) / H for s in at]) ** 3
        inside = theta + bent.mean() * (at - a)  # to (b - a)^2
        position = position + weight @ np.exp(1j * inside)
        theta += weight @ bent
    return position


def test_a_tapered_strip_rolls_up():
    """By solve and along a path to the same, and both to a beam's curve. The strip is so thin that the square of curvature
    times thickness, which stretches its middle, is less than the error."""
    turn, less = 1.2, 0.1
    load = sk.EdgeMoment("right", (0, -turn * EI * less**3 / L / B, 0))
    pad = sk.Zone("pad", PAD.where, thickness=lambda x, y: 2 * less * tapered(x, y))
    problem = sk.Problem(STRIP, lambda x, y: less * tapered(x, y), LAW, [sk.Clamp("left")], [load], zones=[pad])
    exact, errors = rolled(turn), []
    for n in (8, 16):
        system = problem.on(sk.meshes.with_lines(STRIP, n, 1, [pad]), "kirchhoff")
        result = sk.solve(system)
        assert result.ok
        found = result.solution.position((L, B / 2))
        errors.append(abs(found[0] + 1j * found[2] - exact))
        along = sk.trace(system, until=1.0)
        assert np.allclose(along.solution.position((L, B / 2)), found, atol=1e-8)
    assert abs(exact.imag) > 0.5 and errors[1] < 1e-4 and errors[0] / errors[1] > 3


@quiet
@theories
def test_fields_are_those_of_each_zone(theory):
    """Moments, which are continuous, stresses and strains at the faces, and pictures of them, across borders."""
    state = sk.solve_linear(strip([sk.EdgeMoment("right", (0, -1.0, 0))]).on(tree(16), theory))
    middle = np.array([[0.5], [0.5]])
    x = state.system.geometry.parameters(middle)[0, :, 0]
    h = np.array([thick(s) for s in x])
    close = {"rtol": 2e-3 if theory == "kirchhoff" else 1.5e-2}
    assert np.allclose(state.recovered_section_forces(middle)[:, 3, 0], -1.0, **close)
    for z, sign in (("top", -1), ("bottom", 1)):
        assert np.allclose(state.stresses(middle, z)[:, 0, 0], sign * 6 / h**2, **close)
        assert np.allclose(state.strains(middle, z)[:, 0, 0], sign * 6 / h**2 / E, **close)
    shown = output.fields.values(state, "thickness", 2, None)
    at = output.sample(state, 2).points[:, 0]
    inside = (np.abs(at - 0.25) > 1e-9) & (np.abs(at - 0.5) > 1e-9)
    assert np.allclose(shown[inside], [thick(s) for s in at[inside]], rtol=1e-5)


def test_files_have_the_thickness(tmp_path):
    system = strip().on(tree(), "kirchhoff")
    data = output.read(output.write(sk.Solution(system, system.undeformed), tmp_path / "a.vtu", subdivisions=2))
    assert data.point_data["thickness"].max() == pytest.approx(2 * tapered(0.25, 0), rel=1e-5)
    plain = sk.Problem(STRIP, H, LAW).on(sk.meshes.uniform(STRIP, 2, 1), "kirchhoff")
    file = output.write(sk.Solution(plain, plain.undeformed), tmp_path / "b.vtu", subdivisions=1)
    assert "thickness" not in output.read(file).point_data


# --- eigenvalues -----------------------------------------------------------------------------------------------------


def ritz(weight):
    """Of beams that are clamped at 0: eigenvalues of the stiffness against the mass, or a compressive force. Curvatures are
    Legendre polynomials between the places where the thickness jumps."""
    joints, at, w = (0, 0.25, 0.5, 1.0), *np.polynomial.legendre.leggauss(24)
    x = np.concatenate([a + (b - a) * (at + 1) / 2 for a, b in pairwise(joints)])
    w = np.concatenate([(b - a) * w / 2 for a, b in pairwise(joints)])
    shapes = []
    for a, b in pairwise(joints):
        for k in range(9):
            bent = np.polynomial.Legendre.basis(k, [a, b])
            slope = bent.integ(lbnd=a)
            value = slope.integ(lbnd=a)
            inside, end = (x > a) & (x < b), np.clip(x, a, b)
            shapes.append([value(end) + slope(b) * np.maximum(x - b, 0), slope(end), np.where(inside, bent(x), 0.0)])
    values, slopes, bent = np.moveaxis(shapes, 1, 0)
    h = np.array([thick(s) for s in x])
    K = bent * (w * E * B * h**3 / 12) @ bent.T
    other = values * (w * RHO * B * h) @ values.T if weight == "mass" else slopes * w @ slopes.T
    return 1 / eigh(other, K, eigvals_only=True)[::-1]


@quiet
def test_modes_and_their_adapted_frequency():
    exact = np.sqrt(ritz("mass")[0]) / 2 / np.pi
    found = [sk.modes(strip().on(tree(n), "kirchhoff"), 1).frequencies[0] for n in (4, 8)]
    errors = np.abs(np.array(found) / exact - 1)
    assert errors[1] < 5e-6 and errors[0] / errors[1] > 10
    adapted = sk.adapt(strip(), sk.Eigenfrequency(0), rtol=1e-4)
    assert adapted.ok and abs(adapted.value / exact - 1) < 1e-4
    assert set(adapted.solution.system.mesh.p[0]) >= {0.25, 0.5}


@quiet
@theories
def test_a_column_with_a_pad_buckles(theory):
    exact = ritz("slope")[0]
    problem = strip([sk.EdgeLoad("right", (-1 / B, 0, 0))])
    found = [sk.buckling(problem.on(tree(n), theory), 1).load_factors[0] for n in (8, 32)]
    errors = np.abs(np.array(found) / exact - 1)
    assert errors[1] < {"kirchhoff": 1e-5, "full": 2e-3}[theory] and errors[0] > 4 * errors[1]
    assert abs(exact / (np.pi**2 / 4 * EI) - 1) > 0.2  # not that of the root's section
    if theory == "kirchhoff":
        adapted = sk.adapt(problem, sk.BucklingLoad(), rtol=1e-3)
        assert adapted.ok and abs(adapted.value / exact - 1) < 1e-3


# --- motion ----------------------------------------------------------------------------------------------------------


@quiet
@theories
def test_a_free_plate_keeps_energy_and_momenta(theory):
    free = strip(supports=())
    system = free.on(tree(), theory)
    spin = sk.RigidVelocity((0.5, 0.0, 1.0), (30.0, 20.0, 50.0), about=(0.4, 0.05, 0.0))
    motion = sk.simulate(system, 0.02, dt=5e-4, velocity=spin, rho_inf=1.0, newton_rtol=1e-10, progress=False, outputs=3)
    ledger = motion.ledger
    assert motion.ok and motion.at(0.02).strain_energy > 0
    for momentum in (ledger.linear, ledger.angular):
        assert np.abs(momentum - momentum[0]).max() < 1e-9 * np.abs(momentum[0]).max()
    assert np.abs(ledger.balance).max() < 1e-9 * ledger.kinetic[0]
    # Its mass is that of the function.
    assert system.inertia.total == pytest.approx(RHO * B * integral(thick), rel=1e-12)
    assert ledger.linear[0] == pytest.approx(spin_momentum(spin), rel=1e-6)


def spin_momentum(spin):
    """Of the strip, by its mass and its centre."""
    mass, first = (RHO * B * integral(lambda x, k=k: thick(x) * x**k) for k in (0, 1))
    return mass * (np.array(spin.velocity) + np.cross(spin.spin, np.array([first / mass, B / 2, 0]) - [0.4, 0.05, 0.0]))


@quiet
@pytest.mark.parametrize("rule", [sk.GeneralizedAlpha(), sk.Trapezoidal(), sk.ImplicitMidpoint(), sk.EnergyMomentum()])
def test_rules_find_the_first_frequency(rule):
    problem = strip()
    system = problem.on(tree(), "kirchhoff")
    first = sk.modes(system, 1)
    start = first.shape(0, size=1e-4)
    period = 1 / first.frequencies[0]
    motion = sk.simulate(system, period, dt=period / 100, rule=rule, start=start, progress=False, outputs=101, balance=None)
    w = np.array([state.displacement((L, B / 2))[2] for state in motion.states]) / 1e-4
    assert np.abs(w * np.sign(w[0]) - np.cos(2 * np.pi * motion.times / period)).max() < 0.02


@quiet
def test_meshes_that_follow_keep_the_lines_and_runs_go_on_from_files(tmp_path):
    blow = sk.SurfaceLoad((0, 0, 4e4), history=sk.Pulse(0.002))
    problem = strip([blow], damping=sk.Damping(stiffness=2e-5))
    options = {"rtol": 1e-2, "progress": False, "outputs": 6, "follow": sk.Follow(0.08, every=4, max_dofs=4000)}
    motion = sk.simulate(problem.on(tree(4), "kirchhoff"), 0.01, checkpoint=tmp_path / "run", **options)
    assert motion.ok and len(motion.segments) > 1
    for part in motion.segments:
        zones, x = part.system.assembly.section.zones, part.system.mesh.p[0, part.system.mesh.t]
        inside = (x.min(axis=0) >= 0.25) & (x.max(axis=0) <= 0.5)
        assert np.array_equal(zones == 0, inside) and inside.sum() * 4 >= 0.9 * len(zones) * 0.5
    ledger = motion.ledger
    assert abs(ledger.balance[-1]) < 1e-6 * ledger.turnover[-1]
    again = sk.read_motion(problem.on(tree(4), "kirchhoff"), tmp_path / "run")
    assert np.array_equal(again.at(0.01).q, motion.at(0.01).q)
    other = sk.Problem(STRIP, lambda x, y: tapered(x, y) + 1e-6 * x, LAW, [sk.Clamp("left")], [blow], problem.damping,
                       zones=[PAD])  # fmt: skip
    with pytest.raises(InputError, match="its run has another"):
        sk.read_motion(other.on(tree(4), "kirchhoff"), tmp_path / "run")


@quiet
def test_elements_are_not_merged_over_a_border():
    """The border is no line of the coarse mesh; the first elements may be merged in either zone, but not over it."""
    plate = sk.Rectangle(1.0, 1.0)
    zone = sk.Zone("rib", ((0.0, 0.25), (0.0, 1.0)), thickness=2 * H)
    problem = sk.Problem(plate, H, sk.Isotropic(E, 0.3, RHO), [], [sk.Impulse((0.7, 0.7), (0, 0, 0.05))], zones=[zone],
                         damping=sk.Damping(stiffness=3e-3))  # fmt: skip
    mesh = sk.meshes.quadtree(sk.meshes.uniform(plate, 2, 2), plate).refined().refined()
    motion = sk.simulate(problem.on(mesh, "kirchhoff"), 0.05, rtol=1e-2, progress=False, outputs=3,
                         follow=sk.Follow(2.0, every=3))  # fmt: skip
    assert motion.ok, motion.message
    last = motion.segments[-1].system
    assert last.geometry.n_elements < 40 and 0.25 in last.mesh.p[0] and set(last.mesh.p[0]) <= {0, 0.25, 0.5, 0.75, 1}
    static = sk.Problem(plate, H, sk.Isotropic(E, 0.3, RHO), [sk.Clamp("left")], [sk.EdgeLoad("right", (0, 0, 1.0))],
                        zones=[zone])  # fmt: skip
    found = sk.adapt(static, sk.Displacement((1.0, 0.5), (0, 0, 1.0)), rtol=1e-4, mesh=mesh, coarsening=sk.AllElements(),
                     marking=sk.FixedFraction(0.05), max_levels=4)  # fmt: skip
    assert found.levels[1].coarsened > 0 and 0.25 in found.solution.system.mesh.p[0]


@quiet
@theories
def test_states_go_to_other_meshes(theory):
    """The shape stays on a finer one, sections are asked for anew, and so the strain energy is nearly the same."""
    coarse = strip([sk.EdgeMoment("right", (0, -40.0, 0))])
    state = sk.solve(coarse.on(tree(), theory)).unwrap()
    fine = coarse.on(state.system.mesh.refined(np.arange(state.system.mesh.nelements)), theory)
    moved = sk.remap(state, fine, settle=False)
    there = sk.transfer(state, fine)
    assert np.allclose(moved.q, there.q, atol=1e-12)
    points = np.array([[0.1, 0.3, 0.9], [0.05, 0.02, 0.08]]).T
    assert np.allclose(there.position(points), state.position(points), atol=1e-12)
    if theory == "kirchhoff":
        assert there.strain_energy == pytest.approx(state.strain_energy, rel=2e-3)
    assert (fine.assembly.section.zones == 0).sum() == 4 * (state.system.assembly.section.zones == 0).sum()


# --- what is left out ------------------------------------------------------------------------------------------------


@quiet
@pytest.mark.parametrize("zones", [(), (PAD,)])
def test_what_shear_changes_is_by_the_local_thickness(zones):
    """Of a deflection the integral of Q z / (k G h); and of theory "auto" the choice."""
    load, tip = sk.EdgeLoad("right", (0, 0, 1.0)), sk.Displacement((L, B / 2), (0, 0, 1.0))
    state = sk.solve_linear(strip([load], zones).on(tree(16), "kirchhoff"))
    height = thick if zones else lambda x: tapered(x, 0)
    shear = integral(lambda x: 1 / (5 / 6 * E / 2 * height(x)))
    # Free edges twist, which a beam does not know: a hundredth.
    assert sk.theory_error(state, tip).value == pytest.approx(shear, rel=0.03)
    uniform = sk.Problem(STRIP, H, LAW, [sk.Clamp("left")], [load])
    assert sk.theory_error(sk.solve_linear(uniform.on(tree(16), "kirchhoff")), tip).value < 0.9 * shear
    # As a load on a part that is as thick as it is long.
    block = sk.Zone("block", ((0.75, L), (0.0, B)), thickness=0.2)
    on_block = sk.Problem(STRIP, 0.1, LAW, [sk.Clamp(["left", "right"])], [sk.SurfaceLoad((0, 0, 1.0))], zones=[block])
    thin = sk.Problem(STRIP, H, LAW, [sk.Clamp(["left", "right"])], [sk.SurfaceLoad((0, 0, 1.0))])
    mesh = sk.meshes.with_lines(STRIP, 16, 1, [block])
    assert on_block.on(mesh, "auto").choice.theory == "full" and thin.on(mesh, "auto").choice.theory == "kirchhoff"


def test_a_thick_zone_off_the_surface_is_told_of():
    zone = sk.Zone("rib", ((0.5, L), (0.0, B)), thickness=4 * H, offset=1.5 * H)
    problem = sk.Problem(STRIP, H, LAW, [sk.Clamp("left")], zones=[zone])
    with pytest.warns(sk.OutOfDepth, match=r"'full' with the stiffness of its layers 0.015 m off"):
        problem.on(sk.meshes.with_lines(STRIP, 4, 1, [zone]), "full")
    with pytest.warns(sk.OutOfDepth, match=r"the centre of mass is 0.015 m off, with a thickness of 0.04 m"):
        sk.modes(problem.on(sk.meshes.with_lines(STRIP, 4, 1, [zone]), "kirchhoff"), 1)


@quiet
@theories
def test_heat_bends_zones_by_their_own_laws(theory):
    """Two materials under one gradient: free curvatures are those of their expansions, whatever they are thick."""
    cold, hot = (sk.Orthotropic((young,) * 3, (0.0,) * 3, (young / 2,) * 3, RHO, expansion=(alpha, 0.0, 0.0))
                 for young, alpha in ((E, 1e-5), (E / 3, 2e-5)))  # fmt: skip
    zone = sk.Zone("hot", ((0.5, L), (0.0, B)), material=hot)
    problem = sk.Problem(STRIP, tapered, cold, [sk.Clamp("left")], [sk.Temperature(0.0, 10.0)], zones=[zone])
    found = sk.solve_linear(problem.on(sk.meshes.with_lines(STRIP, 8, 1, [zone]), theory)).displacement((L, B / 2))[2]
    expected = -(1e-4 * 0.5 * 0.75 + 2e-4 * 0.5 * 0.25)
    assert found == pytest.approx(expected, rel=1e-9 if theory == "kirchhoff" else 2e-2)


@pytest.mark.parametrize("theory", ["kirchhoff", "full"])
def test_recovery_knows_borders(theory):
    """Moments along a border jump with the stiffness. Polynomials across it would take that for an error of a hundredth of
    the energy on any mesh; those of each side see errors that fall with the mesh, as the energy's does."""
    plate, h = sk.Rectangle(1.0, 1.0), 0.01
    zone = sk.Zone("patch", ((0.25, 0.75), (0.25, 0.75)), thickness=2 * h)
    problem = sk.Problem(plate, h, sk.Isotropic(E, 0.3, RHO), [sk.Clamp("boundary")], [sk.SurfaceLoad((0, 0, 1e3))],
                         zones=[zone])  # fmt: skip
    seen, energies = [], []
    for n in (8, 16, 32):
        state = sk.solve_linear(problem.on(sk.meshes.quadtree(sk.meshes.uniform(plate, n, n), plate), theory))
        energies.append(state.strain_energy)
        seen.append(sk.recovery_indicator(state).sum() / state.strain_energy)
    assert seen[1] < seen[0] / 3 and seen[2] < seen[1] / 3
    if theory == "kirchhoff":
        true = np.array([1 - energy / 5.77304e-3 for energy in energies[:2]])  # extrapolated from 64 x 64 elements
        assert (seen[:2] > true).all() and (seen[:2] < 3 * true).all()


# --- seams and poles -------------------------------------------------------------------------------------------------

TUBE = sk.CylinderSector(1.0, 1.0, angle=2 * np.pi, closed=True)


def patched(centre, theory="kirchhoff", turn=0.0):
    """A tube with a thicker patch about an angle, and a force there."""
    zone = sk.Zone("patch", ((0.25, 0.75), (centre - np.pi / 4, centre + np.pi / 4)), thickness=0.04)
    force = 1e3 * np.array([0.0, np.cos(centre + turn), np.sin(centre + turn)])
    problem = sk.Problem(TUBE, 0.02, sk.Isotropic(E, 0.3, RHO), [sk.Clamp("left")],
                         [sk.SurfaceLoad(tuple(force))], zones=[zone])  # fmt: skip
    return problem.on(sk.meshes.with_lines(TUBE, 4, 16, [zone]), theory)


@theories
def test_a_zone_goes_over_a_seam(theory):
    energies = [sk.solve_linear(patched(centre, theory)).strain_energy for centre in (np.pi, 0.0, 4 * np.pi)]
    assert np.allclose(energies, energies[0], rtol=1e-9)
    section = patched(0.0).assembly.section
    assert (section.zones == 0).sum() == 8 and section.borders.sum() == 12 and section.beside_jumps.sum() > 8
    other = sk.Zone("other", ((0.5, 1.0), (2 * np.pi - 0.1, 2 * np.pi)), thickness=0.01)
    zone = sk.Zone("patch", ((0.25, 0.75), (-0.5, 0.5)), thickness=0.04)
    problem = sk.Problem(TUBE, 0.02, LAW, zones=[zone, other])
    with pytest.raises(InputError, match=r"'patch' and 'other' overlap, near \(x, y\) = \(0.6\d*, 6.2"):
        problem.on(sk.meshes.with_lines(TUBE, 4, 8, [zone, other]))


def test_a_jump_at_a_seam_is_told_of():
    mesh = sk.meshes.uniform(TUBE, 2, 8)
    for given in ({"thickness": lambda x, y: 0.01 * (1 + y)}, {"thickness": 0.01, "offset": lambda x, y: 0.001 * y}):
        with pytest.warns(sk.OutOfDepth, match=r"jump at the seam, from y = 6.28319 to 0, at x = 0.25"):
            sk.Problem(TUBE, material=LAW, **given).on(mesh, "kirchhoff")
    smooth = sk.Problem(TUBE, lambda x, y: 0.01 * (2 + np.cos(y)), LAW)
    halves = [sk.Zone(name, ((0.0, 1.0), (a, a + np.pi)), lambda x, y: 0.01 * (1 + y)) for name, a in
              (("one", 0.0), ("two", np.pi))]  # fmt: skip
    for problem in (smooth, sk.Problem(TUBE, material=LAW, zones=halves)):
        assert problem.on(mesh, "kirchhoff").assembly.section.zones.size == 16


def test_a_zone_about_a_pole():
    cap = sk.SphereSector(1.0, (0.0, 1.0), 2 * np.pi, closed=True)
    zone = sk.Zone("crown", ((0.0, 0.5), (-10.0, 10.0)), thickness=0.02)
    system = sk.Problem(cap, 0.01, LAW, [sk.Clamp("bottom")], [sk.FollowerPressure(1e4)], zones=[zone]).on(
        sk.meshes.with_lines(cap, 8, 12, [zone]), "kirchhoff")  # fmt: skip
    areas = 2 * np.pi * (1 - np.cos([0.5, 1.0]))
    assert system.inertia.total == pytest.approx(RHO * 0.01 * areas.sum(), rel=3e-4)
    assert sk.solve(system).ok


# --- faces that are too steep ----------------------------------------------------------------------------------------


def wedge(angle):
    """Stress at the faces of a wedge of so much half its angle, bent by a force at its tip, over that of a beam."""
    s, c = np.sin(angle), np.cos(angle)
    return s**3 / (1.5 * c * (angle - s * c))


def test_steep_faces_are_told_of():
    for slope in (0.1, 0.3):
        assert wedge(np.arctan(slope)) - 1 == pytest.approx(slope**2 / 5, rel=0.1)
    mesh = sk.meshes.uniform(STRIP, 8, 1)

    def told(**given):
        with pytest.warns(sk.OutOfDepth, match=r"near \(x, y\) = \(0") as caught:
            sk.Problem(STRIP, material=LAW, **given).on(mesh, "kirchhoff")
        return str(caught[0].message)

    assert "faces 0.40 against that: stress and stiffness have some 3 %" in told(thickness=lambda x, y: 1 - 0.8 * x)
    assert "has the slope 0.20 against the surface" in told(thickness=H, offset=lambda x, y: 0.2 * x)
    # An inclined plate bends as one of the thickness that heights along the normal have, too stiff by the cube of a cosine.
    assert 1 - np.cos(np.arctan(0.2)) ** 3 == pytest.approx(1.5 * 0.2**2, rel=0.05)
