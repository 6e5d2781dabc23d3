"""Which elements may be assembled at the same time."""

from collections.abc import Callable
from typing import Any

import numpy as np

from skancf.threads import n_threads, pool

CHUNKS = 16
SMALLEST_CHUNK = 64


class Schedule:
    """Elements in strips; strips of one phase share no node and run at the same time.

    The order of additions does not depend on the number of threads, so results are the same to the last bit.
    """

    def __init__(self, nodes: np.ndarray, centres: np.ndarray):
        along = int(np.argmax(np.ptp(centres, axis=1)))
        n_elements = len(nodes)
        self.order = np.lexsort((centres[1 - along], centres[along])).astype(np.int32)
        n_chunks = max(1, min(CHUNKS, n_elements // SMALLEST_CHUNK))
        edges = np.linspace(0, n_elements, n_chunks + 1).astype(int)
        chunk = np.empty(n_elements, dtype=int)
        chunk[self.order] = np.repeat(np.arange(n_chunks), np.diff(edges))
        colours = _colours(chunk, nodes, n_chunks)
        self.phases = [
            [(int(edges[c]), int(edges[c + 1])) for c in np.flatnonzero(colours == colour)]
            for colour in range(colours.max() + 1)
        ]

    def run(self, kernel: Callable[..., None], *arguments: Any) -> None:
        """``kernel(start, stop, order, *arguments)`` over all elements."""
        threads = n_threads() if len(self.order) >= 2 * SMALLEST_CHUNK else 1
        for phase in self.phases:
            if threads == 1 or len(phase) == 1:
                for start, stop in phase:
                    kernel(start, stop, self.order, *arguments)
            else:
                jobs = [pool(threads).submit(kernel, start, stop, self.order, *arguments) for start, stop in phase]
                for job in jobs:
                    job.result()


def _colours(chunk: np.ndarray, nodes: np.ndarray, n_chunks: int) -> np.ndarray:
    """A colour for each chunk, different for chunks that share a node."""
    touches = np.zeros((nodes.max() + 1, n_chunks), dtype=np.int32)
    touches[nodes.ravel(), np.repeat(chunk, nodes.shape[1])] = 1
    shared = touches.T @ touches > 0
    colours = np.full(n_chunks, -1)
    for c in range(n_chunks):
        taken = set(colours[:c][shared[c, :c]])
        colours[c] = next(k for k in range(n_chunks) if k not in taken)
    return colours
