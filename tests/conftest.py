"""Fixtures that several test files share, and what tests need to run in several processes."""

import os

if "PYTEST_XDIST_WORKER" in os.environ:
    # The processes have the cores; this comes before numpy is loaded. A test of threads sets them itself.
    for variable in ("SKANCF_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        os.environ.setdefault(variable, "1")

import numpy as np
import pytest

SEED = 7


@pytest.fixture
def rng() -> np.random.Generator:
    """Each test sees the same numbers, alone or after others."""
    return np.random.default_rng(SEED)


def pytest_xdist_auto_num_workers() -> int:
    """As many processes as this one may use cores, physical or not; on one core the tests run without others."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return cores if cores > 1 else 0
