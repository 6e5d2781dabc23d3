"""Rows of an array that stay in their file until they are asked for."""

from pathlib import Path
from typing import Any

import numpy as np

from skancf.errors import InputError

ID = "id"
"""Attribute of a file, by which one is told from another that took its place."""


class Rows:
    """An array in a file, of which indexing reads what it gives: rows by number, slice or mask.

    Examples
    --------
    >>> motion = sk.load("long_run.h5")  # doctest: +SKIP
    >>> motion.segments[0].q[10:20]  # doctest: +SKIP
    """

    def __init__(self, path: Path, name: str, file_id: str, shape: tuple[int, ...], dtype: Any) -> None:
        self.path, self.name, self.file_id, self.shape, self.dtype = path, name, file_id, shape, np.dtype(dtype)
        self._dataset: Any = None

    @classmethod
    def of(cls, dataset: Any) -> "Rows":
        """Of a dataset in an open file."""
        file = dataset.file
        return cls(Path(file.filename).absolute(), dataset.name, file.attrs[ID].decode(), dataset.shape, dataset.dtype)

    @property
    def ndim(self) -> int:
        return len(self.shape)

    @property
    def size(self) -> int:
        return int(np.prod(self.shape))

    def __len__(self) -> int:
        return self.shape[0]

    def __repr__(self) -> str:
        return f"Rows({self.shape} in '{self.path}')"

    def __getstate__(self) -> dict[str, Any]:
        return {**vars(self), "_dataset": None}

    def __getitem__(self, key: Any) -> np.ndarray:
        """Read from the file.

        Raises
        ------
        InputError
            Where the file is gone, has become another one, or is damaged.
        """
        rows, rest = (key[0], key[1:]) if isinstance(key, tuple) else (key, ())
        index = np.arange(len(self))[rows]
        try:
            if not index.ndim:
                return np.asarray(self._open()[int(index)])[rest or ...]
            if not len(index):
                return np.empty((0, *self.shape[1:]), self.dtype)[(slice(None), *rest)]
            step = int(index[1] - index[0]) if len(index) > 1 else 1
            even = step > 0 and bool((np.diff(index) == step).all())
            found = self._open()[slice(int(index[0]), int(index[-1]) + 1, step)] if even else self._each(index)
        except (OSError, KeyError, RuntimeError, ValueError) as wrong:
            raise InputError(f"file '{self.path}': {self.name} cannot be read ({wrong}); bring the file back") from wrong
        return np.asarray(found[(slice(None), *rest)])

    def _each(self, index: np.ndarray) -> np.ndarray:
        return np.stack([self._open()[int(k)] for k in index])

    def __array__(self, dtype: Any = None, copy: Any = None) -> np.ndarray:
        return self[:] if dtype is None else self[:].astype(dtype)

    def _open(self) -> Any:
        if self._dataset is None:
            import h5py

            file = h5py.File(self.path, "r")
            if file.attrs[ID].decode() != self.file_id:
                raise InputError(f"file '{self.path}': is another one than was loaded; load it again")
            self._dataset = file[self.name]
        return self._dataset
