"""Threads of this process: how many, and the pool that compiled loops share."""

import os
from concurrent.futures import ThreadPoolExecutor
from functools import cache


def n_threads() -> int:
    """Threads to use: the cores of this process, or the environment variable ``SKANCF_THREADS``."""
    wanted = os.environ.get("SKANCF_THREADS", "")
    if wanted.isdigit() and int(wanted) > 0:
        return int(wanted)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@cache
def pool(n: int) -> ThreadPoolExecutor:
    """A pool of n threads, made once."""
    return ThreadPoolExecutor(n, thread_name_prefix="skancf")
