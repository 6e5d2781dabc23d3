"""Problems of every kind and scale, made by chance: the bounded part of ``make fuzz``, always the same examples."""

import pytest
from fuzz.properties import PROPERTIES
from fuzz.run import run


@pytest.mark.parametrize("name", PROPERTIES)
def test_what_must_hold_holds_for_problems_made_by_chance(name):
    run(name, PROPERTIES[name])
