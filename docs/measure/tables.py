"""Tables of the decisions, for the scripts beside this one."""

import csv
from pathlib import Path
from typing import Any

OUT = Path(__file__).resolve().parent.parent / "decisions"


def write(name: str, header: str, rows: list[list[Any]]) -> None:
    """A file with the columns that ``header`` names, parted by semicolons; it is shown, too."""
    with (OUT / name).open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerows([header.split("; "), *rows])
    print((OUT / name).read_text(encoding="utf-8"))
