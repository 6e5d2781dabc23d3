"""Columns of numbers as text."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from skancf.atomic import AnyPath
from skancf.tabular import Columns


def save_table(path: AnyPath, columns: Mapping[str, Any]) -> Path:
    """Write columns as comma-separated values, such as the history of a displacement.

    Results write their own, by ``to_csv``: see :class:`~skancf.tabular.Tabular`.

    Parameters
    ----------
    path : str or Path
        ``*.csv``.
    columns : mapping from title to (n,) array
        Titles should name the unit, as in ``"u3 [m]"``. Numbers are written in full: reading gives them back exactly.

    Returns
    -------
    Path

    Raises
    ------
    InputError
        For columns of different lengths, none at all, or a file that cannot be written.

    Examples
    --------
    >>> file = sk.output.save_table("deflections.csv", {"n": [4, 8], "deflection": [1.02, 1.01]})
    >>> print(file.read_text().splitlines()[0])
    n,deflection
    """
    return Columns(columns).to_csv(path)
