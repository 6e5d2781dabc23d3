"""Options of compiled functions."""

OPTIONS = {
    "cache": True,
    "nogil": True,
    "error_model": "numpy",
    # Everything but the flags that would let the compiler assume away NaN and infinity.
    "fastmath": {"contract", "reassoc", "nsz", "arcp"},
}
"""Of those that are called from Python."""
INNER = {**OPTIONS, "forceinline": True, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}
"""Of those that only compiled functions call: without entry points they compile in half the time.

Inlined by the compiler: of a function that is called, each caller's file of machine code has a copy, optimised there, and
whichever was loaded first is taken; so last bits would differ between a process that compiles and one that loads.
"""
