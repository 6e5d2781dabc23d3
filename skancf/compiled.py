"""Options of compiled functions."""

OPTIONS = {
    "cache": True,
    "nogil": True,
    "error_model": "numpy",
    # Everything but the flags that would let the compiler assume away NaN and infinity.
    "fastmath": {"contract", "reassoc", "nsz", "arcp"},
}
"""Of those that are called from Python."""
INNER = {**OPTIONS, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}
"""Of those that only compiled functions call: without entry points they compile in half the time."""
