"""How far assumptions reach through the library: the table of decision 0024.

From the folder of the repository, in some seconds, with a checkout of the commit to compare with:

    git worktree add ../before b8844c1
    .venv/bin/python docs/measure/open_core.py ../before

It writes docs/decisions/open_core.csv: of each assumption the files and the places in the library that make it.
"""

import re
import sys
from pathlib import Path

import tables

HERE = Path(__file__).resolve().parents[2]
ASSUMPTIONS = {
    "strides of the unknowns": r"reshape\(-1, 4, 3\)|reshape\(-1, 12\)|(?<!-)\b12 \*|// 12|\b48\b|\b144\b|np\.eye\(12\)|"
                               r"\(12, 12\)",
    "which theory it is": r"theory\.twist|twist: bool|SYSTEM\[|SHAPE\[|LEFT\[|SOFTEST\[|isinstance\([^)]*FullAssembly|"
                          r"cast\((Full|Kirchhoff)",
    "slots and blocks of the matrix": r"slots: np\.ndarray, out: np\.ndarray|self\._slots|, slots, out\)",
    "time and load factor, apart": r"time: float \| None = None, factor|self\.load_factor, self\.time|factor, time|"
                                   r"time: float \| None\b",
    "classes of loads and supports": r"isinstance\([^)]*(PointForce|PointMoment|Clamp|NoRotation|DrivenClamp|EdgeMoment|Pin|"
                                     r"Roller|SimpleSupport|Spring|Dashpot|Gravity)\b",
    "is the answer linear": r"state\.linear\b|self\.linear\b|better\.linear\b|solution\.linear\b",
    "how it ended": r"Status\.CONVERGED|MotionStatus\.FINISHED|Outcome\.REACHED|\.converged\b|\.finished\b|"
                    r"\.reached\b(?!\()",
}  # fmt: skip
PURE = re.compile(
    r"^(kernels|theories|layout|assembly/(full|thin)/|assembly/(local|panels|geometry|places|maps|hanging|ties)\b)"
)
"""Rooms that may know strides and theories: kernels, theories and the layout, under their names of both trees."""


def reach(tree: Path, pattern: str) -> tuple[int, int]:
    """Files of the library outside of its pure rooms in which a pattern is, and places."""
    counts = [
        len(re.findall(pattern, _code(path.read_text()))) for path in sorted((tree / "skancf").rglob("*.py"))
        if not PURE.match(path.relative_to(tree / "skancf").as_posix())
    ]  # fmt: skip
    return sum(n > 0 for n in counts), sum(counts)


def _code(source: str) -> str:
    """Without docstrings and comments, which may speak of anything."""
    return re.sub(r'"""[\s\S]*?"""|#[^\n]*', "", source)


def main() -> None:
    before = Path(sys.argv[1])
    rows = []
    for name, pattern in ASSUMPTIONS.items():
        (files, places), (now, left) = reach(before, pattern), reach(HERE, pattern)
        rows.append([name, f"{files}", f"{places}", f"{now}", f"{left}"])
    tables.write("open_core.csv", "assumption; files before; places before; files now; places now", rows)


if __name__ == "__main__":
    main()
