"""Results as tables: named columns of one length, with their units, for pandas and for files."""

import csv
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from skancf.atomic import AnyPath, check_file, replacing
from skancf.errors import InputError, shown
from skancf.optional import needed
from skancf.showing import summary

if TYPE_CHECKING:
    import pandas as pd

Column = tuple[Any, str]
"""Values (n,), and their unit: empty where they have none."""


TALL, WIDE = 10, 8
"""Rows and columns of a table that are shown as text."""


def _brief(value: Any) -> str:
    return f"{value:.5g}" if isinstance(value, float) else str(value)


class Tabular:
    """Base of results that are tables; ``print`` shows the first rows.

    A class that is one says in ``_table`` what its columns are, by name: values (n,) and their unit.
    """

    def _table(self) -> Mapping[str, Column]:
        """Columns by name."""
        raise NotImplementedError

    @property
    def columns(self) -> dict[str, np.ndarray]:
        """Values by name, each (n,)."""
        return {name: np.asarray(values) for name, (values, _) in self._table().items()}

    @property
    def units(self) -> dict[str, str]:
        """Units by name of the column; empty for numbers without one."""
        return {name: unit for name, (_, unit) in self._table().items()}

    def rows(self) -> Iterator[dict[str, Any]]:
        """The rows of the table, each a dict from the name of a column to a number or text."""
        columns = self.columns
        for values in zip(*(column.tolist() for column in columns.values()), strict=True):
            yield dict(zip(columns, values, strict=True))

    @summary
    def __str__(self) -> str:
        """The first rows and columns as text, with their units."""
        columns, units = self.columns, self.units
        names = list(columns)[:WIDE]
        heads = [f"{name} ({units[name]})" if units[name] else name for name in names]
        first = (columns[name][:TALL].tolist() for name in names)
        rows = [[_brief(value) for value in row] for row in zip(*first, strict=True)]
        widths = [max(map(len, column)) for column in zip(heads, *rows, strict=True)]
        lines = ["  ".join(text.rjust(width) for text, width in zip(row, widths, strict=True)) for row in (heads, *rows)]
        n = len(next(iter(columns.values()), ()))
        left = [f"{n - TALL} more rows"] * (n > TALL) + [f"{len(columns) - WIDE} more columns"] * (len(columns) > WIDE)
        return "\n".join([*lines, *([f"... and {' and '.join(left)}"] if left else [])])

    def to_dataframe(self) -> "pd.DataFrame":
        """The table as a pandas DataFrame; ``frame.attrs["units"]`` has the units by name of the column.

        Raises
        ------
        SkancfError
            Where pandas is not installed.

        Examples
        --------
        >>> plate = sk.Problem(sk.Rectangle(1.0, 1.0), 0.01, sk.Isotropic(2e11, 0.3, 7800), [sk.Clamp("boundary")])
        >>> frame = sk.modes(plate.on(sk.meshes.uniform(plate.surface, 4, 4)), 3).to_dataframe()
        >>> list(frame.columns), frame.attrs["units"]["frequency"]
        (['mode', 'frequency', 'omega', 'eigenvalue'], 'Hz')
        """
        frame = needed("pandas", "to_dataframe", "tables").DataFrame(self.columns)
        frame.attrs["units"] = self.units
        return frame

    def to_csv(self, path: AnyPath) -> Path:
        """Write the table as comma-separated values, the first line with names and units, as in ``u3 [m]``.

        Numbers are written in full: reading gives them back exactly. An older file stays as it was until the new one is
        whole.

        Parameters
        ----------
        path : str or Path
            ``*.csv``.

        Raises
        ------
        InputError
            For a file that cannot be written.

        Examples
        --------
        >>> import tempfile
        >>> folder = tempfile.TemporaryDirectory()
        >>> path = sk.output.Columns({"u3": [0.0, 0.25]}, {"u3": "m"}).to_csv(folder.name + "/history.csv")
        >>> print(path.read_text().split())
        ['u3', '[m]', '0.0', '0.25']
        >>> folder.cleanup()
        """
        file = check_file(path, ".csv")
        columns, units = self.columns, self.units
        with replacing(file) as part, part.open("w", newline="", encoding="utf-8") as stream:
            lines = csv.writer(stream, lineterminator="\n")
            lines.writerow([f"{name} [{units[name]}]" if units[name] else name for name in columns])
            lines.writerows(zip(*(column.tolist() for column in columns.values()), strict=True))
        return file


class Columns(Tabular):
    """A table of given columns.

    Parameters
    ----------
    columns : mapping from name to (n,) array
        At least one, all of one length.
    units : mapping from name to text, optional
        Of some of the columns.

    Raises
    ------
    InputError
        For columns of different lengths or none at all, and for units of a column that is not there.

    Examples
    --------
    >>> table = sk.output.Columns({"time": [0.0, 0.1], "u3": [0.0, 2e-3]}, {"time": "s", "u3": "m"})
    >>> [row["u3"] for row in table.rows()]
    [0.0, 0.002]
    """

    def __init__(self, columns: Mapping[str, Any], units: Mapping[str, str] | None = None) -> None:
        for name, value in (("columns", columns), ("units", {} if units is None else units)):
            if not isinstance(value, Mapping):
                raise InputError(f"{name} = {shown(value)}: give names and values, as in {{'u3': values}}")
        arrays = {name: _column(name, column) for name, column in columns.items()}
        shapes = {name: array.shape for name, array in arrays.items()}
        if not shapes or any(len(shape) != 1 for shape in shapes.values()) or len(set(shapes.values())) > 1:
            raise InputError(f"columns have shapes {shapes}: give at least one, each a list of the same length")
        given = dict(units or {})
        for name, unit in given.items():
            if name not in arrays or not isinstance(unit, str):
                raise InputError(f"units[{shown(name)}] = {shown(unit)}: give texts for columns among {list(arrays)}")
        self._content = {name: (array, given.get(name, "")) for name, array in arrays.items()}

    def _table(self) -> Mapping[str, Column]:
        return self._content

    @summary
    def __repr__(self) -> str:
        titles = [f"{name} [{unit}]" if unit else str(name) for name, (_, unit) in self._content.items()]
        return f"Columns({len(next(iter(self._content.values()))[0])} rows: {', '.join(titles)})"


def _column(name: Any, values: Any) -> np.ndarray:
    try:
        return np.asarray(values)
    except ValueError as wrong:
        raise InputError(f"columns[{name!r}] = {shown(values)}: give a list of numbers ({wrong})") from wrong


def of_objects(objects: Iterable[Any], **units: str) -> Columns:
    """A table of attributes of objects, one row each, with their units."""
    items = list(objects)
    return Columns({name: [getattr(item, name) for item in items] for name in units}, units)


AXES = ("x", "y", "z")


def spread(name: str, values: Any, unit: str) -> dict[str, Column]:
    """Columns of values (n,), or of each component of (n, ...): ``name_x``, ``name_y``, ``name_z`` of vectors in space,
    numbers from 1 on of others."""
    array = np.asarray(values)
    if array.ndim <= 1:
        return {name: (array, unit)}
    flat = array.reshape(len(array), -1)
    numbers = AXES if flat.shape[1] == 3 else range(1, flat.shape[1] + 1)
    return {f"{name}_{k}": (column, unit) for k, column in zip(numbers, flat.T, strict=True)}
