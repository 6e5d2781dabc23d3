"""Every public name has an example in its docstring, which runs and prints what it shows."""

import doctest
import importlib
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import skancf as sk

API = Path(__file__).resolve().parent.parent / "docs" / "api" / "index.rst"
FLAGS = doctest.NORMALIZE_WHITESPACE | doctest.ELLIPSIS


def public() -> Iterator[tuple[str, Any]]:
    """Names on the page of public names, and what they are."""
    module = "skancf"
    for line in API.read_text(encoding="utf-8").splitlines():
        if found := re.match(r"\.\. currentmodule:: (\S+)", line):
            module = found[1]
        elif found := re.match(r"   ([A-Za-z_][\w.]*)$", line):
            yield f"{module}.{found[1]}", named(f"{module}.{found[1]}")


def named(dotted: str) -> Any:
    """What a name means to who types it: an attribute before a file of that name."""
    first, *rest = dotted.split(".")
    found: Any = importlib.import_module(first)
    path = first
    for part in rest:
        path += f".{part}"
        found = getattr(found, part) if hasattr(found, part) else importlib.import_module(path)
    return found


NAMES = dict(public())


def examples(thing: Any) -> list[doctest.DocTest]:
    """Of a function or class and its own methods, those with at least one line to run."""
    finder = doctest.DocTestFinder(recurse=isinstance(thing, type))
    found = finder.find(thing, getattr(thing, "__name__", "thing"), globs={"sk": sk, "np": np})
    return [test for test in found if test.examples]


@pytest.mark.parametrize("name", NAMES)
def test_an_example_prints_what_it_shows(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    tests = examples(NAMES[name])
    assert tests, f"{name}: give its docstring a section Examples"
    runner = doctest.DocTestRunner(optionflags=FLAGS, verbose=False)
    for test in tests:
        told: list[str] = []
        assert runner.run(test, out=told.append).failed == 0, "".join(told)


def test_the_comparison_can_fail():
    def wrong() -> None:
        """
        >>> 1 + 1
        3
        """

    runner = doctest.DocTestRunner(optionflags=FLAGS, verbose=False)
    assert runner.run(examples(wrong)[0], out=lambda text: None).failed == 1
    assert len(NAMES) > 150
