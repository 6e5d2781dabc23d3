"""Arrays whose rows are read when they are asked for."""

from abc import ABC, abstractmethod
from typing import Any

import numpy as np


class Rows(ABC):
    """An array somewhere else, of which indexing reads what it gives: rows by number, slice, numbers or mask.

    ``np.asarray`` reads all of it.

    Parameters
    ----------
    shape : tuple of int
    dtype
    """

    def __init__(self, shape: tuple[int, ...], dtype: Any = float) -> None:
        self.shape, self.dtype = tuple(shape), np.dtype(dtype)

    @abstractmethod
    def read(self, numbers: np.ndarray) -> np.ndarray:
        """Rows (n, ...) of some numbers (n,), n at least one; InputError where they are gone or damaged."""

    @property
    def ndim(self) -> int:
        return len(self.shape)

    @property
    def size(self) -> int:
        return int(np.prod(self.shape))

    @property
    def nbytes(self) -> int:
        return self.size * self.dtype.itemsize

    def __len__(self) -> int:
        return self.shape[0]

    def __repr__(self) -> str:
        return f"{type(self).__name__} of shape {self.shape}"

    def __getitem__(self, key: Any) -> np.ndarray:
        first, *rest = key if isinstance(key, tuple) else (key,)
        numbers = np.arange(len(self))[first]
        if not numbers.ndim:
            return np.asarray(self.read(numbers[None])[0][tuple(rest)])
        found = self.read(numbers) if len(numbers) else np.empty((0, *self.shape[1:]), self.dtype)
        return np.asarray(found[(slice(None), *rest)])

    def __array__(self, dtype: Any = None, copy: Any = None) -> np.ndarray:
        return self[:] if dtype is None else self[:].astype(dtype)
