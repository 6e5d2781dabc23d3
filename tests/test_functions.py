"""Users' functions of place: what they may be, and what is said about others."""

import math

import numpy as np
import pytest

import skancf as sk
from skancf.functions import called, measured, true_at, values_at

AT = np.random.default_rng(0).uniform(size=(2, 4, 5))


@pytest.mark.parametrize("function", [
    lambda x, y: (0.0, 0.0, -np.sin(x) * y),
    lambda x, y: np.stack([0 * x, 0 * x, -np.sin(x) * y]),
    lambda x, y: (0, 0, -math.sin(x) * y),
    lambda x, y: [0, 0, -math.sin(x) * y if x >= 0 else 1.0],
])  # fmt: skip
def test_functions_of_arrays_and_of_numbers_give_the_same(function):
    assert np.allclose(values_at("force", function, AT, 3), [0 * AT[0], 0 * AT[0], -np.sin(AT[0]) * AT[1]], atol=1e-15)


def test_numbers_and_constants():
    assert np.allclose(values_at("stiffness", lambda x, y: math.exp(x), AT), np.exp(AT[0]), rtol=1e-15)
    assert values_at("stiffness", 2.0, AT).shape == (4, 5)
    assert np.array_equal(values_at("force", (1, 2, 3), AT, 3)[:, 1, 2], [1, 2, 3])


@pytest.mark.parametrize("given, components, words", [
    (lambda x, y: (x, y), 3, "force of shape .2, 4, 5.*three components first"),
    (lambda x, y: np.moveaxis(np.stack([x, x, y]), 0, -1), 3, "force of shape .4, 5, 3.*three components"),
    (lambda x, y: x[0], 3, "force of shape .5.*three components"),
    (lambda x, y: x[:3], None, "force of shape .3, 5.*one number"),
    (lambda x, y: (0, 0, np.log(x - x)), 3, "force.*-inf: not finite"),
    (lambda x, y: (0, 0, "1"), 3, "force = '1': not a number"),
    ("12", None, "force = '12': not a number"),
    (lambda x, y: x + 1j, None, "force has entries.*j.*not a number"),
    (lambda x, y: None, None, "force = None: not a number"),
    (lambda x, y: (x, None, y), 3, "force = None: not a number"),
])  # fmt: skip
@pytest.mark.filterwarnings("ignore:divide by zero")
def test_wrong_values_are_named(given, components, words):
    with pytest.raises(sk.InputError, match=words):
        values_at("force", given, AT, components)


@pytest.mark.parametrize("function", [lambda x: x, lambda x, y: {}["key"], lambda x, y: 1 // 0])
def test_what_a_function_raises_passes_with_a_note(function):
    with pytest.raises((TypeError, KeyError, ZeroDivisionError)) as raised:
        values_at("pressure", function, AT)
    assert any("given as pressure" in note for note in raised.value.__notes__)


NODES = np.array([[0.0, 1.0, 1.0, 2.0], [0.0, 0.0, 3.0, 1.0]])


@pytest.mark.parametrize("function", [
    lambda x, y: (x > 0.5) & (y < 2),
    lambda x, y: x > 0.5 and y < 2,
    lambda x, y: math.floor(x) >= 1 and y < 2,
    lambda x, y: np.where((x > 0.5) & (y < 2), 1.0, 0.0),
    lambda x, y: (x > 0.5) * 2 * (y < 2),
    lambda x, y: [bool(one) for one in (x > 0.5) & (y < 2)],
])  # fmt: skip
def test_functions_that_are_true_somewhere(function):
    assert true_at("where", function, NODES).tolist() == [False, True, False, True]
    assert true_at("where", lambda x, y: True, NODES).all()


@pytest.mark.parametrize("function", [
    lambda x, y: x, lambda x, y: None, lambda x, y: "left", lambda x, y: np.full_like(x, np.nan), lambda x, y: (x > 0)[:2],
    lambda x, y: np.ones((4, 2), bool), lambda x, y: ([True], [True, False]), lambda x, y: 1j * x,
])  # fmt: skip
def test_what_is_neither_true_nor_false_is_named(function):
    with pytest.raises(sk.InputError, match=r"where: the function.*must return True or False for each point, here .4,."):
        true_at("where", function, NODES)


def test_functions_of_time_and_place_that_raise_pass_with_a_note():
    for ask in (lambda f: called("history", f, 1.0), lambda f: true_at("history", f, NODES)):
        with pytest.raises(ZeroDivisionError) as raised:
            ask(lambda *_: 1 // 0)
        assert any("given as history" in note for note in raised.value.__notes__)


def test_a_function_that_stops_an_iteration_drops_no_support():
    """Inside a generator StopIteration would end it, as if there were no more supports."""

    def stop(x, y):
        return next(iter(()))

    plate = sk.Rectangle(1.0, 1.0)
    mesh = sk.meshes.uniform(plate, 2, 2)
    for support in (sk.Pin(stop), sk.Clamp(stop), sk.Prescribed("right", lambda x, y: stop(x, y))):
        with pytest.raises(RuntimeError, match="StopIteration") as raised:
            sk.Problem(plate, 0.01, sk.Isotropic(1e7, 0.3, 1.0), [sk.Clamp("left"), support]).on(mesh)
        assert raised.value.__notes__


def test_a_function_that_changes_its_arguments_changes_nothing_else():
    def spoil(x, y):
        x *= 0.0
        y -= 5.0
        return 0 * x

    def where(x, y):
        found = np.abs(x - 1.0) < 1e-9
        x[:] = 0.0
        return found

    plate = sk.Rectangle(1.0, 1.0)
    mesh = sk.meshes.uniform(plate, 2, 2)
    before = mesh.p.copy()
    loads = [sk.EdgeLoad(where, lambda x, y: (spoil(x, y), 0.0, 1.0)), sk.FollowerPressure(spoil), sk.Temperature(spoil)]
    spoilt = sk.Problem(plate, 0.01, sk.Isotropic(1e7, 0.3, 1.0), [sk.Clamp("left")], loads).on(mesh)
    assert np.array_equal(spoilt.mesh.p, before)
    right = sk.Problem(plate, 0.01, sk.Isotropic(1e7, 0.3, 1.0), [sk.Clamp("left")], [sk.EdgeLoad("right", (0, 0, 1.0))])
    assert np.array_equal(sk.solve_linear(spoilt).q, sk.solve_linear(right.on(mesh)).q)
    mapped = sk.MappedSurface(lambda x, y: (x + 0.0, y + 0.0, spoil(x, y)), ((0.0, 1.0), (0.0, 1.0)))
    assert np.allclose(mapped.position(*before), [*before, 0 * before[0]])


def test_a_record_that_changes_the_state_changes_a_copy():
    plate = sk.Rectangle(1.0, 1.0)
    problem = sk.Problem(plate, 0.01, sk.Isotropic(1e7, 0.3, 1.0), [sk.Clamp("left")], [sk.Gravity()])
    system = problem.on(sk.meshes.uniform(plate, 2, 2))

    def moved(state):
        q = state.q
        q -= system.undeformed  # in place, by mistake
        return float(np.abs(q).max())

    plain, recorded = (sk.simulate(system, 0.02, dt=0.01, record=record, progress=False) for record in (None, {"a": moved}))
    assert np.array_equal(plain.at(0.02).q, recorded.at(0.02).q)
    once, again = recorded.history(moved), recorded.history(moved)
    assert np.array_equal(once, again) and once[-1] == pytest.approx(recorded.records["a"][1][-1], rel=1e-12)


@pytest.mark.parametrize("value", [None, "1.0", {}, [1.0, None], [[1.0], [1.0, 2.0]], (v for v in (1.0,)), object(), b"1"])
def test_what_is_no_quantity_of_a_state_is_named(value):
    with pytest.raises(sk.InputError, match=r"quantity: the function returned .*an array of numbers"):
        measured("quantity", lambda state: value, None)


def test_what_callbacks_raise_has_a_note():
    plate = sk.Rectangle(1.0, 1.0)
    problem = sk.Problem(plate, 0.01, sk.Isotropic(1e7, 0.3, 1.0), [sk.Clamp("left")], [sk.Gravity()])
    mesh = sk.meshes.quadtree(sk.meshes.uniform(plate, 2, 2))
    motion = sk.simulate(problem.on(mesh, "kirchhoff"), 0.01, dt=0.01, progress=False)
    calls = {
        "quantity": lambda f: motion.history(f),
        "record['a']": lambda f: sk.simulate(motion.system, 0.01, dt=0.01, record={"a": f}, progress=False),
        "indicator": lambda f: sk.adapt(problem, sk.Displacement((1.0, 0.5)), rtol=1e-9, mesh=mesh, indicator=f, linear=True,
                                        progress=False),
    }  # fmt: skip
    for name, call in calls.items():
        with pytest.raises(ZeroDivisionError) as raised:
            call(lambda state: 1 // 0)
        assert any(note.endswith(f"given as {name}") for note in raised.value.__notes__), name
