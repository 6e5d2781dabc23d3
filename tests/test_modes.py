"""Frequencies and linear buckling loads against known values."""

import warnings

import numpy as np
import pytest

import skancf as sk
from skancf.errors import InputError
from skancf.history import FULL
from skancf.linear import BlockMatrix, BlockPattern, Constraints
from skancf.statics.modes import checked_count

YOUNG, DENSITY, LENGTH, THICKNESS = 1e6, 1000.0, 10.0, 0.1
RIGIDITY = YOUNG * THICKNESS**3 / 12
EULER = np.pi**2 * RIGIDITY / (4 * LENGTH**2)
CLAMPED = (sk.Clamp("left"),)


def strip(n, supports=CLAMPED, loads=()):
    problem = sk.Problem(sk.Rectangle(LENGTH, 1.0), THICKNESS, sk.Isotropic(YOUNG, 0.0, DENSITY), supports, loads)
    return problem.on(sk.meshes.uniform(problem.surface, n, 1))


def plate(n, thickness, supports=(), loads=()):
    problem = sk.Problem(sk.Rectangle(1.0, 1.0), thickness, sk.Isotropic(YOUNG, 0.3, DENSITY), supports, loads)
    return problem.on(sk.meshes.uniform(problem.surface, n, n))


def plate_rigidity(thickness):
    return YOUNG * thickness**3 / (12 * (1 - 0.3**2))


def orthonormal(shapes, matrix):
    return np.array([[a @ (matrix @ b) for a in shapes] for b in shapes])


# --- frequencies -----------------------------------------------------------------------------------------------------


def test_cantilever_strip():
    """(beta L)^2 of a clamped-free beam: 1.8751, 4.6941; shear and rotary inertia take less than 1e-3 off at L/h = 100."""
    expected = np.array([1.87510407, 4.69409113]) ** 2
    errors = []
    for n in (8, 16, 32):
        modes = sk.modes(strip(n), 2)
        found = modes.omega * np.sqrt(DENSITY * THICKNESS / RIGIDITY) * LENGTH**2
        errors.append(found / expected - 1)
        assert modes.n_rigid == modes.n_unstable == 0
        assert np.allclose(modes.frequencies, modes.omega / (2 * np.pi))
    # Of order h^2, until what shear takes off is seen.
    assert (np.array(errors[0]) / errors[1] > 4.0).all()
    assert (np.abs(errors[-1]) < [2e-4, 1e-3]).all()


def test_simply_supported_plate_and_its_equal_pair():
    """pi^2 (m^2 + n^2) (Leissa, 1973), of which (1, 2) and (2, 1) are equal; a/h = 50 lowers them by 0.1 to 0.4 %."""
    thickness = 0.02
    modes = sk.modes(plate(16, thickness, [sk.SimpleSupport("boundary", "hard")]), 4)
    found = modes.omega * np.sqrt(DENSITY * thickness / plate_rigidity(thickness)) / np.pi**2
    assert found == pytest.approx([2, 5, 5, 8], rel=2e-2)
    assert found[1] == pytest.approx(found[2], rel=1e-8), "equal, on a mesh with the same symmetry"
    assert np.allclose(orthonormal(modes.shapes, modes.state.system.mass), np.eye(4), atol=1e-8)


@pytest.mark.parametrize("thickness", [0.02, 0.001])
def test_free_plate_has_six_rigid_modes(thickness):
    """Lowest of a free square plate, nu = 0.3: 13.468, 19.596, 24.270, 34.801 twice (Leissa, 1973)."""
    system = plate(12, thickness)
    modes = sk.modes(system, 11)
    assert modes.n_rigid == 6 and (modes.omega[:6] == 0).all() and modes.n_unstable == 0
    found = modes.omega[6:] * np.sqrt(DENSITY * thickness / plate_rigidity(thickness))
    # Shear takes 0.6 % off at a/h = 50; the mesh is good to 1 %.
    assert found == pytest.approx([13.468, 19.596, 24.270, 34.801, 34.801], rel=2e-2)
    # The six are rigid motions: no strain energy in any of them, of a size that would otherwise be seen.
    stiffness = system.tangent(system.undeformed)
    assert all(phi @ (stiffness @ phi) < 1e-6 * modes.eigenvalues[6] for phi in modes.shapes[:6])
    assert np.allclose(orthonormal(modes.shapes, system.mass), np.eye(11), atol=1e-6)


def test_a_stretched_strip_is_a_string_with_stiffness():
    """omega^2 = k^4 E I / (rho A) + k^2 T / (rho A) with k = n pi / L, for a beam on two hinges under tension T."""
    tension = 50.0
    hinges = [sk.Pin("left"), sk.Roller("right"), sk.Roller("left", (0, 1, 0))]
    system = strip(32, hinges, [sk.EdgeLoad("right", (tension, 0, 0))])
    state = sk.solve(system).unwrap()
    k = np.arange(1, 4) * np.pi / LENGTH
    bent, stretched = (k**4 * RIGIDITY + k**2 * force for force in (0.0, tension))
    middle = np.array([[x, 0.5] for x in np.linspace(0, LENGTH, 33)])
    for modes, expected in ((sk.modes(system, 10), bent), (sk.modes(system, 10, state=state), stretched)):
        lifts = [modes.shape(i).displacement(middle) - modes.state.displacement(middle) for i in range(10)]
        # Bending modes: the middle line moves up and down. The others twist or move in the plane.
        bending = [i for i, u in enumerate(lifts) if np.abs(u[:, 2]).max() > 10 * np.abs(u[:, :2]).max()][:3]
        # 32 elements: 1.3e-3 in the third bending mode; the strain of 5e-4 stretches the strip by as much.
        assert modes.eigenvalues[bending] * DENSITY * THICKNESS == pytest.approx(expected, rel=3e-3)
    assert (stretched > 1.5 * bent).all(), "the tension matters"


def test_an_unstable_state_shows_negative_eigenvalues():
    """A straight column at 30 times its Euler load has three modes below: 1, 9 and 25 times Euler."""
    system = strip(16, loads=[sk.EdgeLoad("right", (-30 * EULER, 0, 0))])
    result = sk.solve(system, relax=False)
    modes = sk.modes(system, 4, state=result.solution)
    assert modes.n_unstable == 3 == result.negative_pivots
    assert (modes.eigenvalues[:3] < 0).all() and modes.eigenvalues[3] > 0 and (np.diff(modes.eigenvalues) > 0).all()
    assert (modes.omega[:3] < 0).all() and np.allclose(modes.omega**2, np.abs(modes.eigenvalues))
    # One mode asked for, and the most negative one is found although it is farthest from zero.
    assert sk.modes(system, 1, state=result.solution).eigenvalues[0] == pytest.approx(modes.eigenvalues[0], rel=1e-6)


@pytest.mark.parametrize("theory", ["full", "kirchhoff"])
def test_modes_about_a_linear_answer_have_the_stiffness_of_buckling(theory):
    """Of a bent and pressed strip: its linear tip moves by its length, and second-order stresses of that would swamp all."""

    def loaded(factor):
        problem = sk.Problem(
            sk.Rectangle(LENGTH, 1.0), THICKNESS, sk.Isotropic(YOUNG, 0.0, DENSITY), CLAMPED,
            [sk.EdgeLoad("right", (-EULER * factor, 0, 2 * EULER * factor))],
        )  # fmt: skip
        return problem.on(sk.meshes.uniform(problem.surface, 8, 1), theory)

    critical = sk.buckling(loaded(1.0), 1).load_factors[0]
    assert critical == pytest.approx(1.0, rel=1e-2), "the bending has no part in it"
    at_rest = sk.modes(loaded(1.0), 1).eigenvalues[0]
    for share in (0.0, 0.5, 1.0):
        system = loaded(share * critical)
        modes = sk.modes(system, 2, state=sk.solve_linear(system))
        # omega^2 falls to zero, almost linearly: the first mode is not quite the buckled shape, which makes 4 % halfway.
        assert modes.eigenvalues[0] == pytest.approx((1 - share) * at_rest, rel=5e-2, abs=1e-6 * at_rest)
    second_order = sk.Solution(system, sk.solve_linear(system).q)
    assert sk.modes(system, 1, state=second_order).eigenvalues[0] > 10 * at_rest, "what a linear answer does not have"


def test_loads_that_follow_a_free_edge_come_with_a_warning():
    """Only the symmetric part of their tangent is counted. On held edges there is no other."""
    follows = [sk.FollowerPressure(0.01)]
    free, held = plate(4, 0.05, CLAMPED, follows), plate(4, 0.05, [sk.Clamp("boundary")], follows)
    with pytest.warns(sk.OutOfDepth, match="flutter is not found"):
        sk.modes(free, 1, state=sk.solve(free).unwrap())
    with pytest.warns(sk.OutOfDepth, match="flutter is not found"):
        sk.buckling(free, 1)
    with warnings.catch_warnings():
        warnings.simplefilter("error", sk.OutOfDepth)
        sk.modes(free, 1)
        sk.modes(held, 1, state=sk.solve(held).unwrap())
        sk.buckling(held, 1)


def test_modes_in_nodal_frames():
    """A plate held along one diagonal direction or the other, its mirror image."""
    along, across = (
        sk.modes(plate(4, 0.05, [sk.Roller("boundary"), sk.Roller("left", (1, s, 0)), sk.Roller("right", (1, s, 0))]), 3)
        for s in (1, -1)
    )
    assert along.state.system.constraints.frame_nodes.size > 0
    assert np.allclose(along.eigenvalues, across.eigenvalues, rtol=1e-8, atol=1e-8)
    for phi in along.shapes:
        assert np.abs(along.state.system.constraints.fixed_part(phi)).max() < 1e-12


def test_all_modes_of_few_coordinates_by_full_matrices():
    """Two masses on springs: omega^2 = 1 and 3."""

    class Springs:
        pattern = BlockPattern.from_cells(np.zeros((1, 1), int), 1, 2, np.zeros((2, 1)))
        constraints = Constraints(np.zeros((1, 2), bool))
        undeformed = np.zeros(2)
        mass = BlockMatrix(pattern, np.eye(2)[None])

        def stiffness(self):
            return BlockMatrix(self.pattern, np.array([[[2.0, -1.0], [-1.0, 2.0]]]))

    modes = sk.modes(Springs(), 2)
    assert np.allclose(modes.eigenvalues, [1, 3]) and np.allclose(np.abs(modes.shapes), np.sqrt(0.5))


def test_shapes_are_states_for_pictures():
    modes = sk.modes(strip(4), 1)
    assert np.linalg.norm(modes.shape(0, 0.5).displacements, axis=0).max() == pytest.approx(0.5)
    assert modes.shape(0).displacement((LENGTH, 0.5))[2] != 0
    with pytest.raises(InputError, match="size = -1"):
        modes.shape(0, -1)


@pytest.mark.parametrize("n", [0, 2.5, 10**6])
def test_a_number_of_modes_that_cannot_be(n):
    with pytest.raises(InputError, match=f"n = {n}"):
        sk.modes(strip(2), n)
    assert checked_count(2, strip(2).constraints) == 2


# --- buckling --------------------------------------------------------------------------------------------------------


def test_euler_column():
    """(2 k - 1)^2 times pi^2 E I / (4 L^2) for a clamped-free column."""
    errors = []
    for n in (8, 16, 32):
        result = sk.buckling(strip(n, loads=[sk.EdgeLoad("right", (-EULER, 0, 0))]), 2)
        errors.append(result.load_factors / [1, 9] - 1)
    # Of order h^2 from above, until what shear and shortening take off is seen: 5e-5 and 2e-5, nine times that in mode two.
    assert (np.array(errors[0]) / errors[1] > 4.0).all() and (np.array(errors[1]) > 0).all()
    assert (np.abs(errors[-1]) < [1e-4, 1e-3]).all()
    tip, middle = result.shape(0, 1.0).displacement([(LENGTH, 0.5), (LENGTH / 2, 0.5)])[:, 2]
    assert middle / tip == pytest.approx(1 - np.cos(np.pi / 4), rel=1e-2), "w = 1 - cos(pi x / 2 L)"


def uniaxial(n, thickness, stress=1.0):
    """A simply supported square plate pressed along x, free to widen."""
    held = [sk.Roller("boundary", kind="hard"), sk.Prescribed([(0.0, 0.0)], (0, 0, None)),
            sk.Prescribed([(1.0, 0.0)], (None, 0, None))]  # fmt: skip
    return plate(n, thickness, held, [sk.EdgeLoad("left", (stress, 0, 0)), sk.EdgeLoad("right", (-stress, 0, 0))])


def test_plate_under_uniaxial_compression():
    """N = k pi^2 D / b^2 with k = 4, and 6.25 for two half waves; shear at a/h = 50 takes 0.45 % off the first."""
    thickness = 0.02
    found = sk.buckling(uniaxial(16, thickness), 2).load_factors / (np.pi**2 * plate_rigidity(thickness))
    assert found == pytest.approx([4.0 / 1.0045, 6.25 / 1.007], rel=1e-2)  # 16 elements a side: 0.3 and 0.1 %
    coarse = sk.buckling(uniaxial(8, thickness), 1).load_factors[0] / (np.pi**2 * plate_rigidity(thickness))
    assert abs(found[0] - 3.982) < abs(coarse - 3.982)


def test_equal_pressure_on_all_sides_has_an_equal_pair():
    """N = (m^2 + n^2) pi^2 D / b^2: 2, and 5 twice."""
    thickness = 0.02
    held = [sk.Roller("boundary", kind="hard"), sk.Prescribed([(0.5, 0.5)], (0, 0, None)),
            sk.Prescribed([(1.0, 0.5)], (None, 0, None))]  # fmt: skip
    sides = {"left": (1, 0, 0), "right": (-1, 0, 0), "bottom": (0, 1, 0), "top": (0, -1, 0)}
    system = plate(12, thickness, held, [sk.EdgeLoad(side, force) for side, force in sides.items()])
    result = sk.buckling(system, 3)
    found = result.load_factors / (np.pi**2 * plate_rigidity(thickness))
    assert found == pytest.approx([2, 5, 5], rel=2e-2)  # as in the test before, on a coarser mesh
    assert found[1] == pytest.approx(found[2], rel=1e-8)
    assert np.allclose(orthonormal(result.shapes, system.tangent(system.undeformed)), np.eye(3), atol=1e-6)


def test_tension_never_buckles_and_says_so():
    system = strip(8, loads=[sk.EdgeLoad("right", (EULER, 0, 0))])
    result = sk.buckling(system, 3)
    assert result.load_factors.size == 0 and "no positive load factor" in result.message and len(result.shapes) == 0
    other = sk.buckling(system, 2, signs="both")
    pressed = sk.buckling(strip(8, loads=[sk.EdgeLoad("right", (-EULER, 0, 0))]), 2)
    assert np.allclose(other.load_factors, -pressed.load_factors, rtol=1e-8) and other.message == ""


def test_stiffness_of_the_loads_buckles_too():
    """Loads alone, without stress: (2 - lambda) (2 - lambda / 2) = 0."""

    class Springs:
        pattern = BlockPattern.from_cells(np.zeros((1, 1), int), 1, 2, np.zeros((2, 1)))
        constraints = Constraints(np.zeros((1, 2), bool))
        undeformed = np.zeros(2)

        def prescribed(self, time=None):
            return np.zeros(2)

        def external_force(self, q, case=None):
            return np.ones(2)

        def stresses(self, q, change=None):
            return np.zeros(0)

        def stiffness(self):
            return BlockMatrix(self.pattern, 2 * np.eye(2)[None])

        def tangent(self, q, case=FULL, stresses=None):
            return BlockMatrix(self.pattern, (2 * np.eye(2) - case.factor * np.diag([1.0, 0.5]))[None])

    assert sk.buckling(Springs(), 2).load_factors == pytest.approx([2.0, 4.0], rel=1e-12)


def test_a_pressing_support_buckles_as_a_force_does():
    """The shortening of the same force, given as a displacement of the end: Euler's column with the end guided."""
    shortening = EULER * LENGTH / (YOUNG * THICKNESS)
    pushed = strip(8, [sk.Clamp("left"), sk.Prescribed("right", (-shortening, None, None))])
    pressed = strip(8, loads=[sk.EdgeLoad("right", (-EULER, 0, 0))])
    assert np.allclose(sk.buckling(pushed, 2).load_factors, sk.buckling(pressed, 2).load_factors, rtol=1e-3)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: sk.buckling(strip(4)), "nothing loads"),
        (lambda: sk.buckling(strip(4, [sk.Pin("left")])), "leave free"),
        (lambda: sk.buckling(strip(4), signs="negative"), "signs = 'negative'"),
        (lambda: sk.buckling(strip(4), 0), "n = 0"),
    ],
)
def test_inputs_that_cannot_be_used(make, message):
    with pytest.raises(InputError, match=message):
        make()


def tube(n, assumed=True):
    """A slice of a long tube under pressure that stays normal to it; t = R / 50, nu = 0."""
    surface = sk.CylinderSector(1.0, 0.25, 2 * np.pi, closed=True)
    middle = [sk.Prescribed([(0.0, angle)], held) for angle, held in
              ((0.0, (None, None, 0)), (np.pi / 2, (None, 0, None)), (np.pi, (None, None, 0)))]  # fmt: skip
    problem = sk.Problem(surface, 0.02, sk.Isotropic(210e9, 0.0, 7800.0), [sk.Roller("left", (1, 0, 0)), *middle],
                         [sk.FollowerPressure(-210e9 * 0.02**3 / 12)])  # fmt: skip
    return problem.on(sk.meshes.uniform(surface, 1, n), sk.Kirchhoff(assumed=assumed))


def test_both_kinds_of_membrane_strain_may_be_above_the_truth():
    """A ring under pressure: p R^3 / E I = k^2 - 1 in k waves (Levy, 1884), 3 and 8; dead pressure would give k^2."""
    assumed, plain = (sk.buckling(tube(8, kind), 4).load_factors[[0, 2]] for kind in (True, False))
    assert (assumed > [3.03, 8.3]).all() and (plain > assumed).all()
    coarse = sk.buckling(tube(8), 4).message
    assert "too coarse" in coarse and "between" not in coarse and "less than both" in coarse
    fine = sk.buckling(tube(32), 4)
    # From above as h^4: 5e-4 and 9e-4 are left.
    assert fine.load_factors == pytest.approx([3, 3, 8, 8], rel=2e-3) and fine.message == ""
