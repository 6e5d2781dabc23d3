"""Users' functions of place: what they may be, and what is said about others."""

import math

import numpy as np
import pytest

import skancf as sk
from skancf.functions import values_at

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
