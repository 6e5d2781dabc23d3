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
    >>> sk.output.save_table("deflections.csv", {"t": [0.0, 0.1], "w": [0.0, 2.5]}).name
    'deflections.csv'
    >>> print(open("deflections.csv").read().strip())
    t,w
    0.0,0.0
    0.1,2.5
    """
    return Columns(columns).to_csv(path)
