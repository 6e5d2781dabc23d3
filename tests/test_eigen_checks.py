"""What is checked of modes and buckling loads, and that the checks can fail."""

import importlib
import warnings

import numpy as np
import pytest

import skancf as sk
from skancf.statics import eigen_checks

# The package gives their functions the same names.
modes_module, buckling_module = (importlib.import_module(f"skancf.statics.{name}") for name in ("modes", "buckling"))

STEEL = sk.Isotropic(210e9, 0.3, 7800.0)


HARD = (sk.SimpleSupport("boundary", "hard"),)


def on(surface, thickness, n, supports=(), loads=(), theory="kirchhoff"):
    return sk.Problem(surface, thickness, STEEL, supports, loads).on(sk.meshes.uniform(surface, *n), theory)


def square(n=6, supports=HARD, loads=(), theory="kirchhoff"):
    return on(sk.Rectangle(1.0, 1.0), 0.01, (n, n), supports, loads, theory)


def squeezed(n=6):
    held = [sk.Roller("boundary", kind="hard"), sk.Prescribed([(0.5, 0.5)], (0, 0, None)),
            sk.Prescribed([(1.0, 0.5)], (None, 0, None))]  # fmt: skip
    sides = {"left": (1, 0, 0), "right": (-1, 0, 0), "bottom": (0, 1, 0), "top": (0, -1, 0)}
    return square(n, held, [sk.EdgeLoad(side, 1e4 * np.array(force)) for side, force in sides.items()])


def tube(supports=(), loads=()):
    return on(sk.CylinderSector(1.0, 2.0, 2 * np.pi, closed=True), 0.02, (3, 16), supports, loads)


def passed(result):
    assert [check.name for check in result.checks if not check.passed] == []
    assert len(result.checks) == 3
    return result


# --- as many motions without stiffness as there are -----------------------------------------------------------------------


@pytest.mark.parametrize("n", [1, 3, 6, 7, 10])
@pytest.mark.parametrize("theory", ["full", "kirchhoff"])
def test_a_free_plate_has_six_whatever_is_asked(theory, n):
    found = passed(sk.modes(on(sk.Rectangle(2.0, 1.0), 0.01, (4, 3), theory=theory), n))
    assert found.n_rigid == 6 and found.n_unstable == 0 and len(found.eigenvalues) == n
    assert ("a group of 6" in found.note) == (n < 6)


@pytest.mark.parametrize(
    ("system", "rigid"),
    [
        (tube(), 6),
        (on(sk.Rectangle(1.0, 1.0), 0.01, (4, 4), [sk.Pin("left")]), 1),  # turns about its edge
        (on(sk.Rectangle(1.0, 1.0), 0.01, (4, 4), [sk.Roller("boundary")]), 3),  # slides in its plane
    ],
)
def test_free_motions_of_other_bodies(system, rigid):
    assert {passed(sk.modes(system, n)).n_rigid for n in (1, 2, 5, 9)} == {rigid}


def test_states_beyond_buckling_have_all_their_negative_eigenvalues():
    """An even pressure on all sides, 6.5 times the first load 2: (m^2 + n^2) = 2, 5, 5, 8, 10, 10 lie below 13."""
    first = sk.buckling(squeezed(8), 1).load_factors[0]
    system = squeezed(8)
    state = sk.Solution(system, sk.solve_linear(system).q, linear=True)
    state = sk.Solution(system, system.undeformed + 6.2 * first * (state.q - system.undeformed), linear=True,
                        load_factor=6.2 * first)  # fmt: skip
    assert [passed(sk.modes(system, n, state=state)).n_unstable for n in (1, 3, 8)] == [6, 6, 6]


# --- groups ----------------------------------------------------------------------------------------------------------------


def test_a_pair_that_is_cut_is_said():
    for find in (lambda n: sk.modes(square(), n), lambda n: sk.buckling(squeezed(), n)):
        one, two, three = (passed(find(n)) for n in (1, 2, 3))
        assert one.note == three.note == "" and "ask for n = 3" in two.note


def test_pairs_of_a_tube_with_held_ends():
    system = tube([sk.Clamp("left"), sk.Clamp("right")])
    found = passed(sk.modes(system, 8)).eigenvalues
    # Waves round a tube come twice, as sine and cosine.
    assert np.allclose(found[0::2], found[1::2], rtol=1e-6)
    assert [bool(passed(sk.modes(system, n)).note) for n in (1, 2, 3, 4)] == [True, False, True, False]


def test_a_pair_on_a_mesh_without_its_symmetry_is_a_group_too():
    surface = sk.Rectangle(1.0, 1.0)
    found = passed(sk.modes(on(surface, 0.01, (9, 10), [sk.SimpleSupport("boundary", "hard")]), 2))
    assert "ask for n = 3" in found.note


@pytest.mark.parametrize("signs", ["positive", "both"])
def test_shear_buckles_a_plate_to_both_sides(signs):
    """The load factors of pure shear are as many negative as positive ones, of the same size."""
    sides = {"left": (0, -1, 0), "right": (0, 1, 0), "bottom": (-1, 0, 0), "top": (1, 0, 0)}
    held = [sk.Roller("boundary", kind="hard"), sk.Prescribed([(0.0, 0.0)], (0, 0, None)),
            sk.Prescribed([(1.0, 0.0)], (None, 0, None))]  # fmt: skip
    system = square(6, held, [sk.EdgeLoad(side, 1e4 * np.array(force)) for side, force in sides.items()])
    factors = passed(sk.buckling(system, 4, signs=signs)).load_factors
    if signs == "positive":
        assert (factors > 0).all() and (np.diff(factors) > 0).all()
    else:
        assert np.allclose(np.sort(factors[:2]), [-abs(factors[0]), abs(factors[0])], rtol=1e-6)


# --- curved parameters and prestress ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("theory", ["full", "kirchhoff"])
def test_a_clamped_disc_with_a_pole_has_its_pairs(theory):
    """omega a^2 sqrt(rho t / D) = 10.216, 21.26 and 34.88 twice each, 39.77 (Leissa, Vibration of Plates, table 2.1)."""
    a, t = 2.0, 0.01
    disc = sk.AnnulusSector(0.0, a, 2 * np.pi, closed=True)
    system = on(disc, t, (7, 16), [sk.Clamp("outer")], theory=theory)
    unit = np.sqrt(STEEL.young * t**2 / (12 * (1 - STEEL.poisson**2) * STEEL.density)) / a**2
    found = passed(sk.modes(system, 6))
    # Seven elements along the radius; those of theory full are of a lower order.
    tolerance = 2e-3 if theory == "kirchhoff" else 4e-2
    assert found.omega / unit == pytest.approx([10.216, 21.26, 21.26, 34.88, 34.88, 39.77], rel=tolerance)
    assert found.n_rigid == found.n_unstable == 0 and not found.note
    for n in (1, 2, 3, 4):
        fewer = passed(sk.modes(system, n))
        assert np.allclose(fewer.eigenvalues, found.eigenvalues[:n], rtol=1e-8)
        assert bool(fewer.note) == (n in (2, 4))


@pytest.mark.parametrize("theory", ["full", "kirchhoff"])
@pytest.mark.parametrize("n", [1, 4, 7])
def test_modes_about_a_state_of_large_displacements(theory, n):
    """Of a strip that is bent far over: each the same, however many are asked for."""
    strip = on(sk.Rectangle(2.0, 0.2), 0.002, (10, 1), [sk.Clamp("left")], [sk.EdgeLoad("right", (0, 0, 200.0))], theory)
    state = sk.solve(strip).unwrap()
    assert np.abs(state.displacement((2.0, 0.1))).max() > 1.0, "far over"
    whole, found = passed(sk.modes(strip, 9, state=state)), passed(sk.modes(strip, n, state=state))
    assert np.allclose(found.eigenvalues, whole.eigenvalues[:n], rtol=1e-8)
    assert found.n_unstable == 0 and not np.allclose(found.eigenvalues, sk.modes(strip, n).eigenvalues, rtol=1e-2)


def test_modes_that_are_missing_about_a_prestressed_disc_are_said(monkeypatch):
    disc = sk.AnnulusSector(0.0, 1.0, 2 * np.pi, closed=True)
    system = on(disc, 0.005, (4, 12), [sk.Clamp("outer")], [sk.SurfaceLoad((0.0, 0.0, 3e4))])
    state = sk.solve(system).unwrap()
    assert np.abs(state.displacement((0.2, 0.0))[2]) > 0.005, "more than its thickness, so that the membrane carries"
    whole = passed(sk.modes(system, 3, state=state))
    assert whole.eigenvalues[0] > 1.5 * sk.modes(system, 1).eigenvalues[0], "it stiffens"
    monkeypatch.setattr(modes_module, "lanczos", deaf_to(system, whole.shapes[1]))
    with pytest.warns(sk.OutOfDepth, match=r"found, .* by the signs of the pivots.*missing"):
        found = sk.modes(system, 2, state=state)
    assert [check.passed for check in found.checks] == [True, True, False]


# --- bounds ----------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("tolerance", [1e-2, 1e-4, 1e-10])
def test_the_bound_is_one(tolerance):
    exact = sk.modes(square(), 5).eigenvalues
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", sk.OutOfDepth)
        rough = sk.modes(square(), 5, tolerance=tolerance)
    assert np.abs(rough.eigenvalues / exact - 1).max() <= max(rough.checks[0].value, 1e-11)


def wrong_shapes(lanczos, part=1e-3):
    def spoilt(*args, **options):
        values, shapes = lanczos(*args, **options)
        return values, shapes + part * np.roll(shapes, 1, axis=0)

    return spoilt


def test_wrong_shapes_are_found(monkeypatch):
    both = (modes_module, lambda: sk.modes(square(), 2)), (buckling_module, lambda: sk.buckling(squeezed(), 2))
    for module, find in both:
        monkeypatch.setattr(module, "lanczos", wrong_shapes(modes_module.lanczos))
        with pytest.warns(sk.OutOfDepth, match="relative error of the eigenvalues"):
            found = find()
        assert not found.checks[0].passed and not found.checks[1].passed
        monkeypatch.undo()


# --- missing ones ----------------------------------------------------------------------------------------------------------


def forgetful(lanczos, which, times):
    """Lanczos' method without one of its answers, so many times."""
    calls = []

    def forgets(matrix, **options):
        values, shapes = lanczos(matrix, **options)
        calls.append(None)
        if len(calls) > times or len(values) < 2:
            return values, shapes
        keep = np.arange(len(values)) != np.argsort(which * values)[0]
        return values[keep], shapes[keep]

    return forgets


@pytest.mark.parametrize("n", [1, 4])
def test_what_a_search_forgets_once_is_found_by_the_next(monkeypatch, n):
    whole = sk.modes(square(), n).eigenvalues, sk.buckling(squeezed(), n).load_factors
    monkeypatch.setattr(modes_module, "lanczos", forgetful(modes_module.lanczos, 1, 1))
    found = passed(sk.modes(square(), n))
    # The first call of a buckling search asks for one number only.
    monkeypatch.setattr(buckling_module, "lanczos", forgetful(buckling_module.lanczos, -1, 2))
    loads = passed(sk.buckling(squeezed(), n))
    assert np.allclose(found.eigenvalues, whole[0], rtol=1e-9) and np.allclose(loads.load_factors, whole[1], rtol=1e-9)


def deaf_to(system, shape):
    """Lanczos' method that never sees one shape."""
    lanczos = modes_module.lanczos

    def deaf(matrix, **options):
        values, shapes = lanczos(matrix, **options)
        if options.get("which") == "LM":  # a first look at the size of load factors
            return values, shapes
        like = np.abs([v @ options["M"].matvec(shape) for v in shapes])
        like /= np.sqrt([v @ options["M"].matvec(v) for v in shapes]) * np.sqrt(shape @ options["M"].matvec(shape))
        return values[like < 0.5], shapes[like < 0.5]

    return deaf


@pytest.mark.parametrize("lost", [0, 3])
def test_what_no_search_finds_is_said(monkeypatch, lost):
    plate, pressed = square(), squeezed()
    shape, buckle = sk.modes(plate, 5).shapes[lost], sk.buckling(pressed, 5).shapes[lost]
    monkeypatch.setattr(modes_module, "lanczos", deaf_to(plate, shape))
    with pytest.warns(sk.OutOfDepth, match=r"found, .* by the signs of the pivots.*missing"):
        found = sk.modes(plate, 4)
    assert [check.passed for check in found.checks] == [True, True, False]
    monkeypatch.setattr(buckling_module, "lanczos", deaf_to(pressed, buckle))
    with pytest.warns(sk.OutOfDepth, match=r"found, .* by the signs of the pivots.*missing"):
        loads = sk.buckling(pressed, 4)
    assert [check.passed for check in loads.checks] == [True, True, False]


def test_an_adaptive_number_does_not_rest_on_a_failed_check(monkeypatch):
    """The first mesh is an error; a later one ends the loop as failed, with what was found before."""
    problem = square().problem
    shape_lost = forgetful(modes_module.lanczos, 1, 10**6)
    monkeypatch.setattr(modes_module, "lanczos", shape_lost)
    with pytest.raises(sk.DidNotConverge, match="missing"):
        sk.adapt(problem, sk.Eigenfrequency(0), rtol=1e-2)
    monkeypatch.undo()
    meshes = []

    def later(matrix, **options):
        meshes.append(matrix.shape)
        return (shape_lost if len(set(meshes)) > 1 else modes_module_lanczos)(matrix, **options)

    modes_module_lanczos = modes_module.lanczos
    monkeypatch.setattr(modes_module, "lanczos", later)
    result = sk.adapt(problem, sk.Eigenfrequency(0), rtol=1e-7, max_levels=3)
    assert not result.ok and result.status.name == "FAILED" and "missing" in result.message
    monkeypatch.setattr(buckling_module, "lanczos", forgetful(modes_module_lanczos, -1, 10**6))
    with pytest.raises(sk.DidNotConverge, match="missing"):
        sk.adapt(squeezed().problem, sk.BucklingLoad(3), rtol=1e-2)


@pytest.mark.parametrize("size", [1e-12, 1.0, 1e9])
def test_a_load_of_any_size_buckles_as_exactly(size):
    """As small against the stiffness as 1e-20: the difference of the tangents alone would be rounding."""
    loads = [sk.EdgeLoad("right", (-size, 0, 0))]
    found = passed(sk.buckling(on(sk.Rectangle(1.0, 1.0), 0.1, (6, 6), [sk.Clamp("left")], loads, "full"), 3))
    one = sk.buckling(on(sk.Rectangle(1.0, 1.0), 0.1, (6, 6), [sk.Clamp("left")],
                         [sk.EdgeLoad("right", (-1e8, 0, 0))], "full"), 3)  # fmt: skip
    assert found.load_factors * size == pytest.approx(one.load_factors * 1e8, rel=1e-9)


def test_gaps():
    values = np.array([-2.0, 0.0, 0.0, 1.0, 1.0005, 2.0])
    assert [eigen_checks.gap_after(values, n) for n in range(1, 6)] == [1, 3, 3, 5, 5]
    assert eigen_checks.gap_after(values, 6) is None
    assert "a group of 2, 1 to 2" in eigen_checks.group_note("mode", values, 2, 3)
    assert eigen_checks.group_note("mode", values, 3, 3) == ""
