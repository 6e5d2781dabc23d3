"""Problems of every kind and scale, made by chance: the bounded part of ``make fuzz``, always the same examples."""

import pytest
from fuzz.broken import BROKEN
from fuzz.properties import PROPERTIES
from fuzz.run import Failure, run


@pytest.mark.parametrize("name", PROPERTIES)
def test_what_must_hold_holds_for_problems_made_by_chance(name):
    run(name, PROPERTIES[name])


@pytest.mark.parametrize("name, broken", BROKEN, ids=lambda given: getattr(given, "__name__", given))
def test_a_broken_library_is_caught(name, broken, monkeypatch):
    broken(monkeypatch)
    with pytest.raises(Failure) as caught:
        run(name, PROPERTIES[name], shrink=False)
    assert type(caught.value.error) is AssertionError  # the oracle's, none of Python's


def test_every_oracle_can_fail():
    assert {name for name, _ in BROKEN} == set(PROPERTIES)
