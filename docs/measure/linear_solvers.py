"""Fill of uniform and graded meshes, and Newton's method with factors kept: two tables of decision 0012.

From the folder of the repository, in two minutes:

    .venv/bin/python docs/measure/linear_solvers.py [fill] [reuse]

They go to docs/decisions/fill.csv and factor_reuse.csv. Fill is counted, and differs with the version of a solver only.
"""

import csv
import sys
from collections.abc import Iterator
from math import pi, radians
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT))  # for the meshes of the benchmark

import skancf as sk  # noqa: E402
import skancf.statics.cascade as cascade  # noqa: E402
from benchmarks.solvers import graded, shell, uniform  # noqa: E402
from skancf.linear import DirectSolver, available_backends, dissection  # noqa: E402
from skancf.linear.pardiso import ANALYSE, RELEASE, _Handle  # noqa: E402
from skancf.linear.rslab import Rslab  # noqa: E402
from skancf.statics import equilibrium  # noqa: E402
from skancf.system.system import System  # noqa: E402

COUNT_ENTRIES = 17
GATES = (0.0, 1e-4, 1e-3, 1e-2)
STEPS = sk.HalveAndGrow(first=0.05, growth=1.0)


def fill() -> Iterator[dict[str, Any]]:
    """Entries of the factor per unknown, by the order of elimination of each solver."""
    problem = shell()
    for name, mesh in (
        ("uniform", uniform(problem, 40)), ("graded", graded(problem, 20_000)),
        ("uniform", uniform(problem, 80)), ("graded", graded(problem, 80_000)),
        ("uniform", uniform(problem, 160)), ("graded", graded(problem, 300_000)),
    ):  # fmt: skip
        system = problem.on(mesh, "kirchhoff")
        pattern, n = system.pattern, system.n_dofs
        row: dict[str, Any] = {"mesh": name, "unknowns": n, "hanging nodes": len(mesh.hanging)}
        if "mkl" in available_backends():
            handle = _Handle(pattern)
            handle.settings[COUNT_ENTRIES] = -1
            handle.run(ANALYSE)
            row["mkl"] = round(int(handle.settings[COUNT_ENTRIES]) * pattern.block**2 / n)
            handle.run(RELEASE)
        if "rslab" in available_backends():
            other = Rslab()
            other.symbolic(pattern)
            row["rslab"] = round(other._symbolic.factor_nnz / n)
        row["superlu"] = round(dissection.fill(pattern, dissection.nested_dissection(pattern)) / n)
        yield row


class Keeping(DirectSolver):
    """Keeps its factors while the residual is below a gate, and counts those it computes."""

    keep = False
    factors = 0

    def factor(self, matrix: Any) -> None:
        if not (Keeping.keep and self._factored):
            Keeping.factors += 1
            super().factor(matrix)


def scenes() -> Iterator[tuple[str, System, sk.HalveAndGrow | None]]:
    strip = sk.Problem(
        sk.Rectangle(10.0, 1.0), 0.1, sk.Isotropic(1.2e6, 0.0, 1.0), [sk.Clamp("left")], [sk.EdgeLoad("right", (0, 0, 4.0))]
    )
    pulled, pushed = (pi / 2, 0.0), (pi / 2, pi / 2)
    hemisphere = sk.Problem(
        sk.SphereSector(10.0, (radians(18), pi / 2), pi / 2), 0.04, sk.Isotropic(6.825e7, 0.3, 1.0),
        [sk.Symmetry("start"), sk.Symmetry("end"), sk.Roller(pulled)],
        [sk.PointForce(pulled, (200.0, 0, 0)), sk.PointForce(pushed, (0, -200.0, 0))],
    )  # fmt: skip
    ring = sk.AnnulusSector(6.0, 10.0, 2 * pi)
    annulus = sk.Problem(ring, 0.03, sk.Isotropic(21e6, 0.0, 1.0), [sk.Clamp("start")], [sk.EdgeLoad("end", (0, 0, 0.8))])
    for name, problem, shape in (("strip, end shear", strip, (16, 2)), ("hemisphere", hemisphere, (16, 16))):
        system = problem.on(sk.meshes.uniform(problem.surface, *shape), "kirchhoff")
        yield f"{name}, one step", system, None
        yield f"{name}, 20 steps", system, STEPS
    yield "slit annulus, one step", annulus.on(sk.meshes.uniform(ring, 4, 24), "kirchhoff"), None


def reuse() -> Iterator[dict[str, Any]]:
    """Iterations and factorisations where factors are kept from a relative residual on."""
    plain = cascade.newton

    def newton(*arguments: Any, **options: Any) -> Any:
        Keeping.keep = False

        def watch(_: int, norm: float) -> None:
            Keeping.keep = norm < gate

        return plain(*arguments, watch=watch, **options)

    cascade.newton, equilibrium.DirectSolver = newton, Keeping
    for name, system, control in scenes():
        row: dict[str, Any] = {"scene": name}
        for gate in GATES:
            Keeping.factors = 0
            result = sk.solve(system, control=control)
            result.unwrap()
            row[f"from {gate:g}" if gate else "never"] = f"{result.iterations} / {Keeping.factors}"
        yield row


def main() -> None:
    tables = {"fill": (fill, "fill"), "reuse": (reuse, "factor_reuse")}
    for name in sys.argv[1:] or tables:
        make, file = tables[name]
        rows = []
        for row in make():
            print(row, flush=True)
            rows.append(row)
        with (ROOT / "docs/decisions" / f"{file}.csv").open("w", newline="", encoding="utf-8") as out:
            writer = csv.DictWriter(out, rows[0], lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)


if __name__ == "__main__":
    main()
