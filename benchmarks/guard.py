"""Did a change make something slower by more than a fifth?

    python benchmarks/guard.py measure [--stored benchmarks/results/guard.json]
    python benchmarks/guard.py check

``check`` measures again, prints stored figures beside new ones, and exits with 1 where one is more than 20 % larger.
``guard_commits.py`` tells 5 %: it measures a commit and the working tree in turns.

Figures do not depend on the mood of the machine. Counts (calls of functions, Newton iterations, loaded modules) are the same
in every run. Ratios are CPU time over that of a calibration of a like mix, which runs in turns with it: what slows one
slows the other. Each is the smallest time of many short runs, since other work on the machine only ever adds time; and
one that is too large is measured again before it is believed.
"""

import argparse
import json
import os
import sys

# Before numpy starts its threads: CPU time of one thread is what is compared.
os.environ.update(SKANCF_THREADS="1", MKL_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1")

import cProfile
import platform
import pstats
import resource
import subprocess
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any

import numba
import numpy as np
import scipy
from llvmlite.binding import get_host_cpu_name

import skancf as sk

STORED = Path(__file__).parent / "results" / "guard.json"
SLOWER = 0.2
SECONDS = 0.8
"""For each ratio, in each pass."""
PASSES = 4
"""The smallest ratio of so many is stored, and believed where the first ones are too large: other work, which evicts what a
long piece of work has in the caches, comes and goes."""
Work = Callable[[], Any]


# What figures are compared with.


@numba.njit(cache=True, error_model="numpy", fastmath={"contract", "reassoc", "nsz", "arcp"})
def _element_loop(table: np.ndarray, vectors: np.ndarray, out: np.ndarray) -> None:
    """Small products, square roots and scattered sums, as the kernels of elements have them."""
    n_points, n_functions = table.shape
    for e in range(vectors.shape[0]):
        for p in range(n_points):
            for a in range(n_functions):
                x = y = z = 0.0
                for b in range(n_functions):
                    w = table[p, b] * table[p, a]
                    x += w * vectors[e, b, 0]
                    y += w * vectors[e, b, 1]
                    z += w * vectors[e, b, 2]
                size = 1.0 / np.sqrt(x * x + y * y + z * z + 1.0)
                out[e, a, 0] += size * x
                out[e, a, 1] += size * y
                out[e, a, 2] += size * z


def compiled() -> Work:
    rng = np.random.default_rng(0)
    table, vectors = rng.normal(size=(16, 16)), rng.normal(size=(800, 16, 3))
    out = np.zeros_like(vectors)
    return lambda: _element_loop(table, vectors, out)


def dense() -> Work:
    """Products and factors of dense matrices, and a pass over more memory than the nearest cache holds."""
    rng = np.random.default_rng(0)
    square = rng.normal(size=(160, 160))
    definite, long = square @ square.T + 160 * np.eye(160), rng.normal(size=200_000)

    def work() -> float:
        return sum(float((np.linalg.cholesky(definite) @ square).sum() + (long * long).sum()) for _ in range(2))

    return work


def python() -> Work:
    """Small arrays, containers and calls."""
    rng = np.random.default_rng(0)
    small, numbers = rng.normal(size=(3, 8, 16)), list(range(200))

    def part(k: int) -> float:
        return float(small[0, k % 8, k % 16]) + k

    def work() -> float:
        total = 0.0
        for k in range(48):
            stacked = np.stack([small[k % 3], small[(k + 1) % 3]])
            found = np.unique(np.round(stacked, 2))
            total += float(np.einsum("iep,iep->e", small, small).sum()) + found.size
            known = {number: part(number) for number in numbers}
            total += sum(known.values()) + len(sorted(known, key=lambda n: -n))
        return total

    return work


def both() -> Work:
    parts = compiled(), python(), dense()

    def work() -> None:
        for one in parts:
            one()

    return work


# What is measured.


@dataclass(frozen=True)
class Ratio:
    """CPU time of a piece of work over that of its calibration."""

    work: Work
    calibration: Work
    clock: Callable[[], float] = time.process_time

    def value(self, seconds: float) -> float:
        clock, smallest = self.clock, [np.inf, np.inf]
        self.work()
        self.calibration()
        begin, runs = clock(), 0
        while runs < 5 or clock() - begin < seconds:
            for k, work in enumerate((self.calibration, self.work)):
                start = clock()
                work()
                smallest[k] = min(smallest[k], clock() - start)
            runs += 1
        return float(smallest[1] / smallest[0])


@dataclass(frozen=True)
class Count:
    """The number of something that every run has alike."""

    count: Callable[[], int]

    def value(self, seconds: float) -> float:
        return float(self.count())


Figures = dict[str, Ratio | Count]


def calls(work: Work) -> Count:
    """Calls of functions, compiled or not; of the second run, which finds what the first one left."""

    def count() -> int:
        work()
        profile = cProfile.Profile()
        profile.runcall(work)
        return int(pstats.Stats(profile).total_calls)  # type: ignore[attr-defined]

    return Count(count)


def child(code: str) -> None:
    # As an installed package is: with its byte code at hand.
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    subprocess.run([sys.executable, "-c", code], check=True, env=environment)


def time_of_children() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def modules() -> int:
    code = "import sys, skancf; print(len(sys.modules))"
    return int(subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout)


@cache
def strip() -> sk.Problem:
    return sk.Problem(
        sk.Rectangle(10.0, 1.0), 0.1, sk.Isotropic(1.2e6, 0.0, 1.0), supports=[sk.Clamp("left")],
        loads=[sk.EdgeLoad("right", (0.0, 0.0, 4.0))],
    )  # fmt: skip


@cache
def plate() -> sk.Problem:
    return sk.Problem(
        sk.Rectangle(1.0, 1.0), 0.01, sk.Isotropic(1e7, 0.3, 1e3), supports=[sk.Clamp("boundary")],
        loads=[sk.SurfaceLoad((0.0, 0.0, -1.0))],
    )  # fmt: skip


def on(problem: sk.Problem, nx: int, ny: int, theory: str = "kirchhoff") -> Any:
    return problem.on(sk.meshes.uniform(problem.surface, nx, ny), theory)


def bent(theory: str) -> float:
    return float(sk.solve(on(strip(), 8, 1, theory)).unwrap().displacement((10.0, 0.5))[2])


def small_deflection() -> float:
    return float(sk.solve_linear(on(plate(), 8, 8)).displacement((0.5, 0.5))[2])


def motion() -> Work:
    return partial(sk.simulate, on(plate(), 4, 4), 0.02, dt=0.005, progress=False)


def estimate() -> Work:
    mesh = sk.meshes.quadtree(sk.meshes.uniform(plate().surface, 2, 2))
    state = sk.solve_linear(plate().on(mesh, "kirchhoff"))
    return partial(sk.goal_estimate, state, sk.Displacement(at=(0.5, 0.5)))


def kernel(method: str, theory: str) -> Ratio:
    system = on(plate(), 12, 12, theory)
    q = system.undeformed + 1e-4 * np.random.default_rng(0).standard_normal(system.n_dofs)
    if method == "tangent":
        return Ratio(partial(system.tangent, q, stresses=system.stresses(q)), compiled())
    return Ratio(partial(repeated, 4, getattr(system, method), q), compiled())


def linear(method: str) -> Ratio:
    from skancf.linear import DirectSolver

    system = on(plate(), 12, 12)
    matrix, force = system.stiffness(), system.external_force(system.undeformed)
    solver = DirectSolver(system.pattern, system.constraints)
    solver.factor(matrix)
    work = {"factor": partial(solver.factor, matrix), "solve": partial(repeated, 3, solver.solve, force)}
    return Ratio(work[method], dense())


def imports() -> Ratio:
    libraries = partial(child, "import numpy, numba, scipy.sparse.linalg")
    return Ratio(partial(child, "import skancf"), libraries, clock=time_of_children)


def recipes() -> dict[str, Callable[[], Ratio | Count]]:
    """What makes each figure, by name: one that cannot be made leaves the others."""
    made: dict[str, Callable[[], Ratio | Count]] = {}
    for theory in ("kirchhoff", "full"):
        made[f"residual, {theory}"] = partial(kernel, "internal_force", theory)
        made[f"stresses, {theory}"] = partial(kernel, "stresses", theory)
        made[f"tangent, {theory}"] = partial(kernel, "tangent", theory)
        work = partial(bent, theory)
        made[f"strip bent, {theory}"] = partial(lambda work: Ratio(work, both()), work)
        made[f"calls, strip bent, {theory}"] = partial(calls, work)
    made["factor"], made["solve"] = partial(linear, "factor"), partial(linear, "solve")
    made["set-up, 8 elements"] = lambda: Ratio(partial(on, strip(), 8, 1), python())
    made["calls, set-up, 8 elements"] = lambda: calls(partial(on, strip(), 8, 1))
    made["set-up, 1024 elements"] = lambda: Ratio(partial(on, plate(), 32, 32), python())
    made["small deflection"] = lambda: Ratio(small_deflection, both())
    made["calls, small deflection"] = lambda: calls(small_deflection)
    made["four steps in time"] = lambda: Ratio(motion(), both())
    made["calls, four steps in time"] = lambda: calls(motion())
    made["estimate"] = lambda: Ratio(estimate(), both())
    made["calls, estimate"] = lambda: calls(estimate())
    made["iterations, strip bent"] = lambda: Count(lambda: int(sk.solve(on(strip(), 8, 1)).iterations))
    made["import"], made["modules loaded"] = imports, lambda: Count(modules)
    return made


def all_figures() -> Figures:
    return {name: recipe() for name, recipe in recipes().items()}


def repeated(times: int, function: Callable[..., Any], *arguments: Any) -> None:
    """A short piece of work several times, so that a clock resolves it."""
    for _ in range(times):
        function(*arguments)


# Measuring and comparing.


def machine() -> dict[str, str]:
    """What figures may depend on."""
    return {
        "processor": f"{platform.machine()} {get_host_cpu_name()}", "python": platform.python_version(),
        "numpy": np.__version__, "scipy": scipy.__version__, "numba": numba.__version__,
    }  # fmt: skip


def measured(figures: Figures, seconds: float = SECONDS) -> dict[str, float]:
    passes = [{name: figure.value(seconds) for name, figure in figures.items() if isinstance(figure, Ratio)}
              for _ in range(PASSES)]  # fmt: skip
    return {name: float(f"{min(one[name] for one in passes):.4g}") if isinstance(figure, Ratio) else figure.value(seconds)
            for name, figure in figures.items()}  # fmt: skip


def measure(figures: Figures, stored: Path, seconds: float = SECONDS) -> int:
    """Write the figures of this machine."""
    from skancf.atomic import check_file, replacing

    check_file(stored, ".json")
    found = measured(figures, seconds)
    with replacing(stored) as file:
        file.write_text(json.dumps({"machine": machine(), "figures": found}, indent=1) + "\n")
    for name, value in found.items():
        print(f"{name:<32}{value:>12.6g}")
    print(f"-> {stored}")
    return 0


def check(figures: Figures, stored: Path, seconds: float = SECONDS) -> int:
    """Compare with the stored figures; 1 where something is slower than allowed, or is not among them."""
    if not stored.exists():
        print(f"{stored}: no such file; write it with: python benchmarks/guard.py measure")
        return 1
    known = json.loads(stored.read_text())
    here = machine()
    for name in (name for name in here if here[name] != known["machine"].get(name)):
        print(f"another {name}: {known['machine'].get(name)} when stored, {here[name]} here; compared all the same")
    slower = []
    print(f"{'figure':<32}{'stored':>12}{'now':>12}{'change':>10}")
    for name, figure in figures.items():
        if name not in known["figures"]:
            print(f"{name:<32}{'none':>12}{'':>12}  measure and store it")
            slower.append(name)
            continue
        before, now = known["figures"][name], figure.value(seconds)
        for _ in range(PASSES - 1 if isinstance(figure, Ratio) else 0):
            if now <= (1 + SLOWER) * before:
                break
            now = min(now, figure.value(seconds))
        late = now > (1 + SLOWER) * before
        print(row(name, before, now, late), flush=True)
        slower += [name] if late else []
    return told(slower, f"{SLOWER:.0%}")


def row(name: str, before: float, now: float, late: bool, more: str = "") -> str:
    return f"{name:<32}{before:>12.6g}{now:>12.6g}{now / before - 1:>+10.1%}{more}{'  SLOWER' if late else ''}"


def told(slower: list[str], allowed: str) -> int:
    """Say what is slower; the exit code."""
    print(f"slower by more than {allowed}: {', '.join(slower) or 'nothing'}")
    return 1 if slower else 0


def one_pass(made: dict[str, Callable[[], Ratio | Count]], seconds: float) -> dict[str, dict[str, Any]]:
    """Every figure once, ``{"ratios": ..., "counts": ..., "failed": ...}``; of one that raises, the message."""
    found: dict[str, dict[str, Any]] = {"ratios": {}, "counts": {}, "failed": {}}
    for name, recipe in made.items():
        try:
            figure = recipe()
            found["ratios" if isinstance(figure, Ratio) else "counts"][name] = figure.value(seconds)
        except Exception as error:  # noqa: PERF203
            found["failed"][name] = f"{type(error).__name__}: {error}"[:200]
    return found


def figures(tree: Path, seconds: float) -> int:
    """A line of JSON with the figures of the package in this folder, for ``guard_commits.py``."""
    if tree.resolve() not in Path(sk.__file__).resolve().parents:
        print(f"{sk.__file__} is imported, which is not below {tree}", file=sys.stderr)
        return 1
    print(json.dumps(one_pass(recipes(), seconds)))
    return 0


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("command", choices=["measure", "check", "figures"], metavar="{measure,check}")
    parser.add_argument("--stored", type=Path, default=STORED)
    parser.add_argument("--seconds", type=float, default=SECONDS, help="for each ratio, in each pass")
    parser.add_argument("--tree", type=Path, default=Path.cwd(), help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.command == "figures":
        return figures(arguments.tree, arguments.seconds)
    command = {"measure": measure, "check": check}[arguments.command]
    return command(all_figures(), arguments.stored, arguments.seconds)


if __name__ == "__main__":
    sys.exit(main())
