"""Runs that are killed and go on: the table of docs/theory/restart.csv, and what a write costs.

From the folder of the repository, in some minutes:

    .venv/bin/python docs/measure/restart.py

A plate of 1024 elements runs once to its end, and once in processes that are killed by SIGKILL at random moments. For every
kill the table has the seconds since the loop in time began, the time reached on disk, and whether all pieces there are, byte
by byte, those of the other run; the last row compares all files and results of the finished runs.
"""

import csv
import random
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import skancf as sk
from skancf.dynamics.checkpoint import Writer
from skancf.dynamics.step_solver import StepSolver

KILLS, END, EVERY = 20, 0.2, 3
TABLE = Path(__file__).resolve().parent.parent / "theory" / "restart.csv"


def plate() -> sk.system.System:
    """A cantilever that is pulled up by its end, and a load that moves over it."""
    surface = sk.Rectangle(1.0, 1.0)
    path = sk.Path([0.0, END], [(0.1, 0.2), (0.9, 0.8)])
    loads = [sk.EdgeLoad("right", (0, 0, 0.5), history=sk.Ramp(0.05)), sk.MovingForce(path, (0, 0, -0.2))]
    problem = sk.Problem(surface, 0.02, sk.Isotropic(1e6, 0.3, 1000.0), [sk.Clamp("left")], loads)
    return problem.on(sk.meshes.uniform(surface, 32, 32), "kirchhoff")


def run(folder: Path, every: int = EVERY) -> sk.Motion:
    print("begun", flush=True)
    tip = {"tip": lambda state: state.displacement((1.0, 0.5))}
    return sk.simulate(plate(), END, dt=2e-3, outputs=21, record=tip, progress=False,
                       checkpoint=sk.Checkpoint(folder, every), resume=True)  # fmt: skip


def one(folder: Path) -> None:
    """A whole process: the run, and its results beside its files."""
    motion = run(folder).unwrap()
    np.savez(folder / "results.npz", times=motion.times, **motion.ledger.table(), tip=motion.records["tip"][1],
             **{f"{name}_{k}": getattr(s, name) for k, s in enumerate(motion.segments) for name in ("q", "v")})  # fmt: skip


def process(folder: Path) -> subprocess.Popen:
    started = subprocess.Popen([sys.executable, __file__, str(folder)], stdout=subprocess.PIPE, text=True)
    assert started.stdout is not None and started.stdout.readline() == "begun\n"
    return started


def equal(folder: Path, whole: Path, pattern: str) -> bool:
    """Whether files have the bytes of those of the same name."""
    return all(file.read_bytes() == (whole / file.name).read_bytes() for file in folder.glob(pattern))


def kills(rng: random.Random) -> list[tuple[int, float, float, str]]:
    system, rows = plate(), []
    with tempfile.TemporaryDirectory() as where:
        cut, whole = Path(where) / "cut", Path(where) / "whole"
        begun = time.perf_counter()
        assert process(whole).wait() == 0
        mean = (time.perf_counter() - begun) / KILLS
        for k in range(1, KILLS + 1):
            running, wait = process(cut), rng.uniform(0.5, 2.0) * mean
            time.sleep(wait)
            running.kill()
            running.wait()
            begun_once = (cut / "state.npz").exists()
            reached = float(sk.read_motion(system, cut).segments[-1].times[-1]) if begun_once else 0.0
            rows.append((k, wait, reached, "yes" if equal(cut, whole, "piece*") else "no"))
            print(rows[-1], flush=True)
        begun = time.perf_counter()
        assert process(cut).wait() == 0
        same = equal(cut, whole, "piece*") and equal(cut, whole, "r*.npz") and len(list(cut.iterdir())) == len(
            list(whole.iterdir()))  # fmt: skip
        rows.append((KILLS + 1, time.perf_counter() - begun, END, "yes" if same else "no"))
    return rows


def cost() -> None:
    """Medians of a step and of a write; under the load of other processes both grow."""
    times: dict[str, list[float]] = {"step": [], "write": []}

    def timed(kind: type, method: str, name: str) -> None:
        known = getattr(kind, method)

        def call(*args: object, **more: object) -> object:
            begun = time.perf_counter()
            out = known(*args, **more)
            times[name].append(time.perf_counter() - begun)
            return out

        setattr(kind, method, call)

    timed(StepSolver, "step", "step")
    timed(Writer, "write", "write")
    with tempfile.TemporaryDirectory() as where:
        motion = run(Path(where) / "run", every=10)
        bytes_ = sum(file.stat().st_size for file in (Path(where) / "run").iterdir())
    new = [t for t, s in zip(times["step"], motion.steps, strict=True) if s.factorisations]
    old = [t for t, s in zip(times["step"], motion.steps, strict=True) if not s.factorisations]
    kept, renewed, write = (1e3 * statistics.median(values) for values in (old, new, times["write"]))
    print(f"step {kept:.1f} ms, with new factors {renewed:.1f} ms, write {write:.1f} ms; "
          f"{bytes_ / 1e6:.1f} MB in {len(times['write'])} writes")  # fmt: skip


if __name__ == "__main__":
    if len(sys.argv) > 1:
        one(Path(sys.argv[1]))
    else:
        table = kills(random.Random(5))
        with TABLE.open("w", newline="", encoding="utf-8") as stream:
            writer = csv.writer(stream, lineterminator="\n")
            writer.writerow(["kill", "after (s)", "time reached (s)", "equal bytes"])
            writer.writerows([k, f"{wait:.2f}", f"{reached:.3f}", same] for k, wait, reached, same in table)
        cost()
