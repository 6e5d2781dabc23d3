"""Laminates off their reference surface: weight at the centre of mass, and mass that is not there."""

import warnings

import numpy as np
import pytest

import skancf as sk

E, RHO, T = 210e9, 7800.0, 0.02
STRIP = sk.Rectangle(1.0, 0.1)


def laminate(offset, young=E, thickness=T):
    return sk.Laminate([sk.Layer(sk.Isotropic(young, 0.0, RHO), thickness)], offset=offset)


def strip(material, acceleration, theory="kirchhoff", n=(8, 1)):
    problem = sk.Problem(STRIP, material=material, supports=[sk.Clamp("left")], loads=[sk.Gravity(acceleration)])
    return problem.on(sk.meshes.uniform(STRIP, *n), theory)


@pytest.mark.parametrize("theory", ["kirchhoff", "full"])
def test_weight_along_a_strip_with_an_offset_does_not_bend_it(theory):
    solution = sk.solve_linear(strip(laminate(0.2), (10.0, 0, 0), theory))
    u, expected = solution.displacement((1.0, 0.05)), RHO * 10.0 / (2 * E)
    # Condition 1e10 of a thin strip.
    assert np.allclose(u, [expected, 0, 0], atol=1e-5 * expected)
    if theory == "kirchhoff":
        # Rounding of a difference of moments N / 5 over a step.
        assert np.abs(solution.shear_forces()).max() < 1e-5 * RHO * T * 10.0
        assert solution.shear_share < 1e-9


def test_a_leaning_strip_is_the_same_from_any_surface():
    """Small deflections of its mid-plane, under weight along and across it."""
    ends = []
    for offset in (0.0, 2 * T):
        solution = sk.solve_linear(strip(laminate(offset), (0.01, 0, -0.001)))
        ends.append(solution.displacement((1.0, 0.05), z=offset))
    # Normals turn with the sine of the slope, 1e-7, and condition 1e8.
    assert np.allclose(ends[1], ends[0], rtol=1e-6, atol=1e-6 * abs(ends[0][0]))


@pytest.mark.parametrize("mirrored", [False, True])
def test_stiffness_of_eccentric_weight_is_the_derivative_of_its_force(mirrored, rng):
    """Of either numbering of the corners; and the force is the derivative of the work at the centre of mass."""
    surface, offset, acceleration = sk.SphereSector(1.0, (0.6, 1.4), 0.9), 0.2, np.array([3.0, -2.0, 5.0])
    mesh = sk.meshes.uniform(surface, 2, 1)
    if mirrored:
        mesh = type(mesh)(mesh.p, mesh.t[[0, 3, 2, 1]])
    free = sk.Problem(surface, material=laminate(offset, 1.0), loads=[sk.Gravity(tuple(acceleration))])
    system = free.on(mesh, "kirchhoff")
    (load,), shape = system.loads, (-1, 4, 3)
    q, eps = system.undeformed + 0.02 * rng.normal(size=system.n_dofs), 1e-6
    unit = eps * np.eye(system.n_dofs)
    numeric = np.array([load.force(q + e, None, sk.Case()) - load.force(q - e, None, sk.Case()) for e in unit])
    numeric = numeric.T / (2 * eps)
    blocks = system.blocks()
    load.add_tangent(q, None, sk.Case(), blocks)
    stiffness = blocks.matrix().to_scipy().toarray()
    # Rounding over the step, and its square.
    assert np.abs(stiffness - numeric).max() < 1e-7 * np.abs(stiffness).max()
    sections, theory = system.assembly.sections, system.geometry.theory
    weights = sections.moments[sections.shape][:, 0]
    # The sphere's normal points outwards: the surface through the centre of mass is larger. Cubics are not quite round.
    assert np.allclose(weights, RHO * T * sections.areas[sections.shape] * (1 + offset) ** 2, rtol=0.02)

    def work(q):
        local = system.geometry.local(q.reshape(shape))
        r = np.einsum("ap,eai->eip", theory.position_table(theory.quadrature[0])[0], local)
        centre = r + offset * theory.normals(local, theory.quadrature[0], system.geometry.side)
        return np.einsum("i,eip,ep->", acceleration, centre, weights)

    step = eps * rng.normal(size=system.n_dofs)
    difference = (work(q + step) - work(q - step)) / 2
    assert np.isclose(difference, system.external_force(q) @ step, rtol=1e-6)


def test_motion_with_the_mass_off_the_surface_comes_with_a_warning():
    """From a hundredth of the thickness on; not in theory full, whose mass is where it is."""
    eccentric = strip(laminate(0.011 * T), (0, 0, -1.0), n=(2, 1))
    with pytest.warns(sk.OutOfDepth, match="centre of mass"):
        sk.modes(eccentric, 1)
    with pytest.warns(sk.OutOfDepth, match="centre of mass"):
        sk.simulate(eccentric, 1e-4, dt=1e-4, progress=False)
    with pytest.warns(sk.OutOfDepth, match="too stiff on coarse meshes"):
        full = strip(laminate(0.2), (0, 0, -1.0), "full", n=(2, 1))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sk.modes(strip(laminate(0.009 * T), (0, 0, -1.0), n=(2, 1)), 1)
        sk.modes(full, 1)


def test_full_off_its_surface_says_that_it_locks():
    def tip(theory, n):
        problem = sk.Problem(STRIP, material=laminate(2.5 * T), supports=[sk.Clamp("left")],
                             loads=[sk.EdgeLoad("right", (0.0, 0.0, -1000.0))])  # fmt: skip
        return sk.solve_linear(problem.on(sk.meshes.uniform(STRIP, n, 1), theory)).displacement((1.0, 0.05))[2]

    beam = -1000.0 / (3 * E * T**3 / 12)
    with pytest.warns(sk.OutOfDepth, match="too stiff on coarse meshes"):
        coarse = tip("full", 8)
    assert coarse / beam < 0.95 and tip("kirchhoff", 8) == pytest.approx(beam, rel=1e-6)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        strip(laminate(0.0), (0.0, 0.0, -1.0), "full")


@pytest.mark.parametrize("direction", [0, 90])
def test_layers_of_unlike_stiffness_are_off_their_surface_too(direction):
    """A stiff skin on soft foam: the surface is through the middle of the layers, and that of the stiffness is not."""
    skin = sk.Orthotropic((1e9, 1e9, 1e9), (0.0, 0.0, 0.0), (5e8, 5e8, 5e8), 1000.0)
    foam = sk.Isotropic(1e5, 0.0, 100.0)

    def tip(layers, theory, n):
        problem = sk.Problem(STRIP, material=sk.Laminate(layers), supports=[sk.Clamp("left")],
                             loads=[sk.EdgeLoad("right", (0.0, 0.0, -1e-3))])  # fmt: skip
        return sk.solve_linear(problem.on(sk.meshes.uniform(STRIP, n, 1), theory)).displacement((1.0, 0.05))[2]

    skinned = [sk.Layer(skin, 1e-3, direction), sk.Layer(foam, 9e-3)]
    with pytest.warns(sk.OutOfDepth, match="neutral surface"):
        coarse = tip(skinned, "full", 12)
    assert coarse / tip(skinned, "kirchhoff", 12) < 0.9
    balanced = [sk.Layer(skin, 1e-3, direction), sk.Layer(foam, 8e-3), sk.Layer(skin, 1e-3, direction)]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        tip(balanced, "full", 2)
