"""Packages that only some functions need, imported when these are called."""

import importlib
from typing import Any

from skancf.errors import SkancfError


def needed(package: str, what: str, extra: str) -> Any:
    """The package, imported.

    Parameters
    ----------
    package : str
    what : str
        The function that needs it, as the message has it.
    extra : str
        The extra of this library that installs it.

    Raises
    ------
    SkancfError
        Where it is not installed; the message says how to install it.
    """
    try:
        return importlib.import_module(package)
    except ImportError as missing:
        raise SkancfError(f"{what} needs {package}: pip install 'skancf[{extra}]'") from missing
