"""Rows of an array that stay in their HDF5 file until they are asked for."""

from pathlib import Path
from typing import Any

import numpy as np

from skancf.errors import InputError
from skancf.rows import Rows

ID = "id"
"""Attribute of a file, by which one is told from another that took its place."""


class FileRows(Rows):
    """A dataset of a file that is opened when it is needed."""

    def __init__(self, path: Path, name: str, file_id: str, shape: tuple[int, ...], dtype: Any) -> None:
        super().__init__(shape, dtype)
        self.path, self.name, self.file_id = path, name, file_id
        self._dataset: Any = None
        self.moved: np.ndarray | float = 0.0
        """Added to each row."""

    @classmethod
    def of(cls, dataset: Any) -> "FileRows":
        """Of a dataset in an open file."""
        file = dataset.file
        return cls(Path(file.filename).absolute(), dataset.name, file.attrs[ID].decode(), dataset.shape, dataset.dtype)

    def __getstate__(self) -> dict[str, Any]:
        return {**vars(self), "_dataset": None}

    def read(self, numbers: np.ndarray) -> np.ndarray:
        """Rows of the file.

        Raises
        ------
        InputError
            Where the file is gone, has become another one, or is damaged.
        """
        try:
            dataset = self._open()
            step = int(numbers[1] - numbers[0]) if len(numbers) > 1 else 1
            if step > 0 and (np.diff(numbers) == step).all():
                return np.asarray(dataset[int(numbers[0]) : int(numbers[-1]) + 1 : step] + self.moved)
            return np.stack([dataset[int(k)] + self.moved for k in numbers])
        except (OSError, KeyError, RuntimeError, ValueError) as wrong:
            if isinstance(wrong, InputError):
                raise
            raise InputError(f"file '{self.path}': {self.name} cannot be read ({wrong}); bring the file back") from wrong

    def _open(self) -> Any:
        if self._dataset is None:
            import h5py

            file = h5py.File(self.path, "r")
            if file.attrs[ID].decode() != self.file_id:
                raise InputError(f"file '{self.path}': is another one than was loaded; load it again")
            self._dataset = file[self.name]
        return self._dataset
