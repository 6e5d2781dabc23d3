"""A problem from a file."""

import textwrap

from skancf.atomic import AnyPath

WIDTH = 100
"""Characters of a line."""


def solve_file(path: AnyPath, folder: AnyPath | None = None) -> int:
    """Solve the problem in a TOML file and say what was written; 1 where the analysis did not reach what was asked for."""
    from skancf.storage import run_file

    done = run_file(path, folder, progress=True)
    for said in (str(done.result), done.message):
        if said:
            print(textwrap.fill(said, WIDTH))
    for file in done.files:
        print(f"-> {file}")
    for note in done.notes:
        print(f"not written: {note}")
    return 0 if done.ok else 1
