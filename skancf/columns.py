"""Columns of tables that users bring: DataFrames, files of comma-separated values, mappings and structured arrays."""

import csv
import os
import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from skancf.arguments import mapping
from skancf.atomic import as_path
from skancf.errors import InputError, finite, shown
from skancf.tabular import Tabular

TABLE = "a DataFrame, a mapping from names to columns, a structured array, or the path of a .csv file"
HEAD = re.compile(r"^\s*(.*?)\s*(?:[(\[]([^()\[\]]*)[)\]])?\s*$", re.DOTALL)
"""A name and, in brackets, a unit."""
COMMON = {"N", "s", "K", "rad", "1", "-", ""}
SYSTEMS = (
    {"m", "Pa", "N/m2", "N/m^2", "N/m²", "N m", "Nm", "N*m", "N·m", *COMMON},
    {"mm", "MPa", "N/mm2", "N/mm^2", "N/mm²", "N mm", "Nmm", "N*mm", "N·mm", *COMMON},
)
"""Units that belong together, so that none needs a factor."""


def columns(
    name: str, table: Any, wanted: Sequence[str], optional: Sequence[str] = (), titles: Mapping[str, str] | None = None
) -> dict[str, np.ndarray]:
    """Columns of a table as finite floats, by the names that are wanted; optional ones only where they are there.

    A title may have a unit behind the name, as in ``"fx (N)"``. Units of one table must belong together: m, N and Pa, or mm,
    N and MPa.

    Parameters
    ----------
    name : str
        The argument, as messages call it.
    table
        Anything with ``columns`` or ``keys()`` and ``[]``, a structured array, or the path of a ``.csv`` file.
    wanted, optional : sequences of str
    titles : mapping, optional
        From names to the titles that columns have in the table, where they are others.

    Raises
    ------
    InputError
        For what is no table, a column that is missing, entries that are no finite numbers, with their column and row,
        columns of different lengths, and units that do not belong together.
    """
    table = _table(name, table)
    known = {str(title): title for title in _titles(name, table)}
    other = mapping("titles", {} if titles is None else titles, "names and titles of columns, as in {'fx': 'Force X'}")
    for column in other:
        if column not in (*wanted, *optional):
            raise InputError(f"titles: {shown(column)} is not asked for; the names are {', '.join((*wanted, *optional))}")
    found, units = {}, {}
    for column in (*wanted, *optional):
        title = _title(name, column, other.get(column), list(known), column in wanted)
        if title is not None:
            found[column], units[title] = _floats(name, title, table[known[title]]), _parts(title)[1]
    lengths = {column: len(values) for column, values in found.items()}
    if len(set(lengths.values())) > 1:
        raise InputError(f"{name}: its columns have the lengths {lengths}; give as many rows to each")
    if not any(set(units.values()) <= system for system in SYSTEMS):
        raise InputError(f"{name}: the units of {', '.join(map(repr, units))} do not belong together; convert the columns "
                         "to m, N, Pa and N m, or to mm, N, MPa and N mm, angles to rad")  # fmt: skip
    return found


def _parts(title: str) -> tuple[str, str]:
    """Name and unit in a title."""
    match = HEAD.match(title)
    assert match
    return match[1], (match[2] or "").strip()


def _table(name: str, table: Any) -> Any:
    """A table, read if it is the path of one."""
    if isinstance(table, Tabular):
        return {f"{column} [{table.units[column]}]": values for column, values in table.columns.items()}
    if not isinstance(table, str | os.PathLike):
        return table
    file = as_path(name, table)
    if file.suffix.lower() != ".csv":
        raise InputError(f"{name} = '{file}': its name ends in '{file.suffix}'; give {TABLE}")
    try:
        with file.open(newline="", encoding="utf-8-sig") as stream:
            rows = [row for row in csv.reader(stream, delimiter=_delimiter(stream.readline(), stream)) if any(row)]
    except (OSError, UnicodeDecodeError, csv.Error) as wrong:
        raise InputError(f"{name} = '{file}': cannot be read as comma-separated values ({wrong})") from wrong
    if not rows:
        raise InputError(f"{name} = '{file}': is empty; give a first line with the titles of the columns")
    head = rows[0]
    for k, row in enumerate(rows[1:]):
        if len(row) != len(head):
            raise InputError(f"{name} = '{file}': row {k} has {len(row)} entries, and there are {len(head)} titles")
    return {title: [row[k] for row in rows[1:]] for k, title in enumerate(head)}


def _delimiter(first: str, stream: Any) -> str:
    """What separates the titles in the first line; the stream is at its beginning again."""
    stream.seek(0)
    return max(",;\t", key=first.count)


def _titles(name: str, table: Any) -> Sequence[Any]:
    kind = getattr(table, "dtype", None)
    found = getattr(table, "columns", None)
    if found is None and kind is not None:
        found = getattr(kind, "names", None)
    if found is None and isinstance(table, Mapping):
        found = table.keys()
    if found is None or callable(found) or isinstance(table, type) or not hasattr(table, "__getitem__"):
        raise InputError(f"{name} = {shown(table)}: give {TABLE}")
    return list(found)


def _title(name: str, column: str, other: Any, known: list[str], needed: bool) -> str | None:
    """The title of a column: that which was given, the name itself, or the name with a unit."""
    if other is not None:
        matching = [title for title in known if other in (title, _parts(title)[0])]
    else:
        matching = [title for title in known if _parts(title)[0] == column]
    if len(matching) > 1:
        raise InputError(f"{name}: the columns {', '.join(map(repr, matching))} are all {column!r}; keep one of them")
    if not matching and (needed or other is not None):
        has = ", ".join(map(repr, known)) or "none"
        raise InputError(f"{name}: has no column {(other or column)!r}; its columns are {has}")
    return matching[0] if matching else None


def _floats(name: str, title: str, values: Any) -> np.ndarray:
    """A column as finite floats, (n,); text that is a number will do, as a file has it."""
    try:
        entries = np.asarray(values)
    except Exception as wrong:
        raise InputError(f"{name}: column {title!r} is no column of numbers ({wrong})") from wrong
    if entries.ndim != 1:
        raise InputError(f"{name}: column {title!r} has the shape {entries.shape}; give one number for each row")
    if entries.dtype.kind in "iuf" and np.isfinite(entries).all():
        return finite(f"{name}: column {title!r}", entries)
    out = np.empty(len(entries))
    for row, entry in enumerate(entries.tolist()):
        try:
            out[row] = float(entry) if not isinstance(entry, bool) else np.nan
        except (TypeError, ValueError):
            out[row] = np.nan
        if not np.isfinite(out[row]):
            raise InputError(f"{name}: column {title!r}, row {row}: {shown(entry)} is no finite number")
    return finite(f"{name}: column {title!r}", out)
