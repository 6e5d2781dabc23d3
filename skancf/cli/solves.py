"""A problem from a file."""

from skancf.atomic import AnyPath


def solve_file(path: AnyPath, folder: AnyPath | None = None) -> int:
    """Solve the problem in a TOML file and say what was written; 1 where the analysis did not reach what was asked for."""
    from skancf.storage import run_file

    done = run_file(path, folder, progress=True)
    print(done.result)
    if done.message:
        print(done.message)
    for file in done.files:
        print(f"-> {file}")
    for note in done.notes:
        print(f"not written: {note}")
    return 0 if done.ok else 1
