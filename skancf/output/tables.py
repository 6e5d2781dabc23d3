"""Columns of numbers as text."""

import csv
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from skancf.arguments import mapping
from skancf.atomic import AnyPath, check_file, replacing
from skancf.errors import InputError, shown


def _column(title: Any, values: Any) -> np.ndarray:
    try:
        return np.asarray(values)
    except ValueError as wrong:
        raise InputError(f"columns[{title!r}] = {shown(values)}: give a list of numbers ({wrong})") from wrong


def save_table(path: AnyPath, columns: Mapping[str, Any]) -> Path:
    """Write columns as comma-separated values, such as the history of a displacement.

    Parameters
    ----------
    path : str or Path
        ``*.csv``.
    columns : mapping from title to (n,) array
        Titles should name the unit, as in ``"u3 (m)"``. Numbers are written in full: reading gives them back exactly.

    Returns
    -------
    Path

    Raises
    ------
    InputError
        For columns of different lengths, none at all, or a file that cannot be written.
    """
    mapping("columns", columns, "titles and columns, as in {'u3 (m)': values}")
    arrays = {title: _column(title, column) for title, column in columns.items()}
    shapes = {title: array.shape for title, array in arrays.items()}
    if not shapes or any(len(shape) != 1 for shape in shapes.values()) or len(set(shapes.values())) > 1:
        raise InputError(f"columns have shapes {shapes}: give at least one, each a list of the same length")
    file = check_file(path, ".csv")
    with replacing(file) as part, part.open("w", newline="", encoding="utf-8") as stream:
        rows = csv.writer(stream, lineterminator="\n")
        rows.writerow(arrays)
        rows.writerows(zip(*(array.tolist() for array in arrays.values()), strict=True))
    return file
