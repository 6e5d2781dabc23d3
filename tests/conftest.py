"""Fixtures that several test files share."""

import numpy as np
import pytest

SEED = 7


@pytest.fixture
def rng() -> np.random.Generator:
    """Each test sees the same numbers, alone or after others."""
    return np.random.default_rng(SEED)
