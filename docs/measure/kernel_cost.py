"""What an evaluation costs, by the number of Gauss points through the thickness: the table of decision 0001.

From the folder of the repository, in half a minute on one core:

    SKANCF_THREADS=1 .venv/bin/python docs/measure/kernel_cost.py

It writes docs/decisions/kernel_cost.csv. Times are the best of many, in microseconds per element: a busy
machine only ever adds to them.
"""

import csv
import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

os.environ.setdefault("SKANCF_THREADS", "1")

import skancf as sk

TABLE = Path(__file__).resolve().parent.parent / "decisions" / "kernel_cost.csv"
CELLS = 40


def microseconds(call: Callable[[], Any], repeats: int = 40) -> float:
    call()
    spent = []
    for _ in range(repeats):
        start = time.perf_counter()
        call()
        spent.append(time.perf_counter() - start)
    return 1e6 * min(spent) / CELLS**2


def main() -> None:
    rows: list[list[object]] = []
    for points in (2, 3, 5, 9, 17):
        plate = sk.Problem(sk.Rectangle(1.0, 1.0), 0.01, sk.Isotropic(70e9, 0.3, 2700.0))
        start = time.perf_counter()
        system = plate.on(sk.meshes.uniform(plate.surface, CELLS, CELLS), sk.Full(n_thickness=points))
        setting_up = time.perf_counter() - start
        q = system.undeformed * 1.01
        stresses = system.stresses(q)
        rows.append(
            [
                points,
                f"{microseconds(lambda s=system, q=q: s.internal_force(q)):.1f}",
                f"{microseconds(lambda s=system, q=q, t=stresses: s.tangent(q, stresses=t)):.1f}",
                f"{1e3 * setting_up:.0f}",
            ]
        )
    head = ["points through the thickness", "residual (us)", "tangent (us)", "set-up of 1600 elements (ms)"]
    with TABLE.open("w", newline="", encoding="utf-8") as stream:
        csv.writer(stream, lineterminator="\n").writerows([head, *rows])
    print(head, *rows, sep="\n")


if __name__ == "__main__":
    main()
