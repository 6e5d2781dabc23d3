"""Lists that only grow, and what came to them as arrays."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from skancf.dynamics.named_state import as_array

SHAPES = "#shapes"
"""After the name of a column whose values have several."""


class Log(list[Any]):
    """Rows of one kind, dataclasses or mappings of numbers and arrays, that are not changed any more.

    Parameters
    ----------
    kind
        Makes a row of its values by name.
    """

    def __init__(self, kind: Callable[..., Any] = dict) -> None:
        super().__init__()
        self.kind = kind

    def since(self, n: int) -> dict[str, np.ndarray]:
        """The rows after the first n, by columns; no column without a row."""
        rows = [row if isinstance(row, dict) else vars(row) for row in self[n:]]
        columns = (_column(name, [row[name] for row in rows]) for name in (rows[0] if rows else ()))
        return {name: values for column in columns for name, values in column.items()}

    def add(self, columns: Mapping[str, np.ndarray]) -> None:
        """Append what :meth:`since` gave."""
        names = [name for name in columns if not name.endswith(SHAPES)]
        values = [_values(columns[name], columns.get(name + SHAPES)) for name in names]
        self.extend(self.kind(**dict(zip(names, row, strict=True))) for row in zip(*values, strict=True))


def _column(name: str, values: list[Any]) -> dict[str, np.ndarray]:
    column = as_array(values)
    if not column.dtype.hasobject:
        return {name: column}
    arrays = [as_array(value) for value in values]
    shapes = as_array([array.shape for array in arrays])
    return {name: np.concatenate([array.ravel() for array in arrays]), name + SHAPES: shapes}


def _values(column: np.ndarray, shapes: np.ndarray | None) -> list[Any]:
    if shapes is not None:
        parts = np.split(column, np.cumsum(shapes.prod(axis=1))[:-1])
        return [part.reshape(shape) for part, shape in zip(parts, shapes.tolist(), strict=True)]
    plain = column.ndim == 1 and column.dtype in (float, int, bool)
    return column.tolist() if plain else list(column)
