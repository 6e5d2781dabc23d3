"""Marking: which elements an indicator takes, with ties, in time."""

import time

import numpy as np
import pytest

from skancf.adaptive import AllElements, Below, Doerfler, FixedFraction, Maximum, Never
from skancf.errors import InputError

POLICIES = [Doerfler(), Maximum(), FixedFraction(), AllElements(), Below(), Never()]
VALUES = np.array([1.0, 8.0, 0.0, 3.0, 4.0])


@pytest.mark.parametrize(
    "policy, expected",
    [
        (Doerfler(0.5), [1]),
        (Doerfler(0.51), [1, 4]),
        (Doerfler(0.75), [1, 4]),
        (Doerfler(1.0), [0, 1, 3, 4]),
        (Maximum(0.5), [1, 4]),
        (Maximum(0.501), [1]),
        (Maximum(1.0), [1]),
        (FixedFraction(0.4), [1, 4]),
        (FixedFraction(0.41), [1, 3, 4]),
        (FixedFraction(1.0), [0, 1, 3, 4]),
        (AllElements(), [0, 1, 2, 3, 4]),
        (Below(0.5), [0, 2]),
        (Below(), [2]),
        (Never(), []),
    ],
)
def test_what_is_marked(policy, expected):
    assert policy.marked(VALUES).tolist() == expected


def smallest_set(values, share):
    """The plain way: one element after the other, largest first."""
    taken, total = [], 0.0
    for k in np.argsort(-values):
        if total >= share * values.sum():
            break
        taken.append(int(k))
        total += values[k]
    return sorted(taken)


def test_doerfler_takes_the_smallest_set():
    rng = np.random.default_rng(3)
    for _ in range(200):
        values, share = rng.random(rng.integers(1, 40)) ** 4, rng.uniform(0.05, 0.95)
        assert Doerfler(share).marked(values).tolist() == smallest_set(values, share)


def test_values_that_differ_by_rounding_are_marked_together():
    rng = np.random.default_rng(4)
    quarter = rng.random(50)
    four = np.concatenate([quarter * (1 + 1e-13 * rng.normal(size=50)) for _ in range(4)])
    for policy in (Doerfler(0.3), Maximum(0.7), FixedFraction(0.13), Below(0.5)):
        marked = policy.marked(four)
        assert marked.size and (np.bincount(marked % 50) % 4 == 0).all(), policy
    # Without the rule a symmetric set would be cut through.
    assert len(smallest_set(four, 0.3)) % 4 or (np.bincount(np.array(smallest_set(four, 0.3)) % 50) % 4).any()
    assert FixedFraction(0.1).marked(np.ones(10)).size == 10


def test_nothing_to_mark():
    for policy in POLICIES:
        assert policy.marked(np.zeros(6)).tolist() == (list(range(6)) if policy == AllElements() else [])
        assert policy.marked([]).size == 0


@pytest.mark.parametrize("policy", POLICIES)
def test_indicators_that_cannot_be_used(policy):
    with pytest.raises(InputError, match=r"indicators\[1\] = -2.0: .* must not be negative"):
        policy.marked([1.0, -2.0])
    with pytest.raises(InputError, match=r"indicators\[0\].*not finite"):
        policy.marked([np.nan, 1.0])
    with pytest.raises(InputError, match=r"shape \(2, 2\): give one number for each element"):
        policy.marked(np.ones((2, 2)))


SHARES = [(Doerfler, "share"), (Maximum, "factor"), (FixedFraction, "fraction"), (Below, "factor")]


@pytest.mark.parametrize("kind, name", SHARES)
@pytest.mark.parametrize("value", [0.0, -0.5, 1.01])
def test_shares_out_of_range(kind, name, value):
    with pytest.raises(InputError, match=f"{name} = {value}: give a number greater than 0 and at most 1"):
        kind(value)
    with pytest.raises(InputError, match=f"{name} = nan"):
        kind(float("nan"))


@pytest.mark.parametrize("policy", POLICIES)
def test_a_hundred_thousand_elements_in_milliseconds(policy):
    values = np.random.default_rng(5).random(100_000) ** 8
    times = []
    for _ in range(20):
        start = time.perf_counter()
        policy.marked(values)
        times.append(time.perf_counter() - start)
    # About 1 ms on an idle machine; the best of twenty, with room for a busy one.
    assert min(times) < 5e-3
