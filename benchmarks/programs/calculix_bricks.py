"""Input decks of one layer of quadratic bricks for CalculiX, and what comes back."""

import os
import subprocess
import tempfile
from pathlib import Path
from typing import Any

from benchmarks.programs.program import Outcome

# Iterations before an increment is given up: the defaults (4, 8, 9, 16, 10, 4, -, 5) cut steps that would converge.
PATIENCE = "*CONTROLS,PARAMETERS=TIME INCREMENTATION\n30,60,9,100,10,4,,30,,"
CORNERS = [(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (0, 0, 2), (2, 0, 2), (2, 2, 2), (0, 2, 2)]
MIDDLES = [(1, 0, 0), (2, 1, 0), (1, 2, 0), (0, 1, 0), (1, 0, 2), (2, 1, 2), (1, 2, 2), (0, 1, 2), (0, 0, 1), (2, 0, 1),
           (2, 2, 1), (0, 2, 1)]  # fmt: skip


class Bricks:
    """An input deck: bricks on a lattice of half their size; (i, j, k) is a node if at most one of the three is odd."""

    def __init__(self, points: Any, data: Any, keep: Any = None) -> None:
        import numpy as np

        shape = points.shape[:3]
        nx, ny, nz = ((m - 1) // 2 for m in shape)
        i, j, k = np.indices((nx, ny, nz))
        if keep is not None:
            i, j, k = i[keep], j[keep], k[keep]
        i, j, k = (2 * index.ravel() for index in (i, j, k))
        number = np.arange(1, points[..., 0].size + 1).reshape(shape)
        cells = np.stack([number[i + a, j + b, k + c] for a, b, c in CORNERS + MIDDLES], 1)
        used = np.unique(cells)
        renumber = np.zeros(number.size + 1, dtype=int)
        renumber[used] = np.arange(1, used.size + 1)
        # 0 where the lattice has no node.
        self.ids, self.count, self.held = renumber[number], used.size, 0
        cells, where = renumber[cells], points.reshape(-1, 3)[used - 1]
        rows = np.column_stack([np.arange(1, used.size + 1), where]).ravel().tolist()
        lines = [
            "*NODE,NSET=NALL",
            ("%d,%.12g,%.12g,%.12g\n" * used.size % tuple(rows))[:-1],
            "*ELEMENT,TYPE=C3D20R,ELSET=EALL",
        ]
        form = ",".join(["%d"] * 16) + ",\n" + ",".join(["%d"] * 5) + "\n"
        lines.append(
            (form * len(cells) % tuple(np.column_stack([np.arange(1, len(cells) + 1), cells]).ravel().tolist()))[:-1]
        )
        lines += ["*MATERIAL,NAME=M", "*ELASTIC", f"{data['young']!r},{data['poisson']!r}"]
        if "density" in data:
            lines += ["*DENSITY", repr(data["density"])]
        self.lines = [*lines, "*SOLID SECTION,ELSET=EALL,MATERIAL=M"]

    def fix(self, ids: Any, *dofs: int) -> None:
        ids = ids[ids > 0].tolist()
        self.lines += ["*BOUNDARY", *(f"{node},{dof}" for node in ids for dof in dofs)]
        self.held += len(ids) * len(dofs)

    def end_load(self, dof: int, total: float) -> list[str]:
        """Spread evenly over the face at the far end of the first direction: -1/12 at its corners, 1/3 between."""
        face = self.ids[-1]
        shares = {(j, k): (-1 / 12 if j % 2 == k % 2 == 0 else 1 / 3) for j in range(3) for k in range(3) if face[j, k]}
        return [f"{face[at]},{dof},{total * share!r}" for at, share in shares.items()]

    def step(
        self, kind: str, *lines: str, out: Any = None, what: str = "U", geometry: bool = True, every: int = 10**6
    ) -> None:
        head = "*STEP,NLGEOM,INC=100000" if geometry else "*STEP"
        wanted = []
        if out is not None:
            wanted = ["*NSET,NSET=OUT", *map(str, out), f"*NODE PRINT,NSET=OUT,FREQUENCY={every}", what]
        self.lines += [head, *([PATIENCE] if geometry else []), kind, *lines, *wanted, "*END STEP"]

    def solve(self) -> tuple[list[tuple[float, list[list[float]]]], str]:
        """What ``*NODE PRINT`` tells: for each output its time and its rows; and a note."""
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "job"
            path.with_suffix(".inp").write_text("\n".join(self.lines) + "\n")
            done = subprocess.run(
                ["ccx", "job"],
                cwd=folder,
                capture_output=True,
                text=True,
                check=False,
                env={**os.environ, "OMP_NUM_THREADS": "1"},
            )
            if done.returncode or "*ERROR" in done.stdout:
                raise RuntimeError("ccx: " + " ".join(done.stdout.split("*ERROR")[-1].split())[:200])
            steps = len(path.with_suffix(".sta").read_text().splitlines()) - 2 if path.with_suffix(".sta").exists() else 0
            told = path.with_suffix(".dat").read_text()
        blocks: list[tuple[float, list[list[float]]]] = []
        for line in told.splitlines():
            if "time" in line:
                blocks.append((float(line.split()[-1]), []))
            elif line.strip() and blocks:
                blocks[-1][1].append([float(word) for word in line.split()])
        return blocks, f"{steps} increments, {done.stdout.count(' iteration ')} iterations"

    def outcome(self, values: dict[str, Any], note: str = "") -> Outcome:
        return Outcome(values, 3 * self.count - self.held, note)


def slab(nx: int, ny: int, lx: float, ly: float, thickness: float) -> Any:
    import numpy as np

    axes = (np.linspace(0, lx, 2 * nx + 1), np.linspace(0, ly, 2 * ny + 1), thickness * np.linspace(-0.5, 0.5, 3))
    return np.stack(np.meshgrid(*axes, indexing="ij"), -1)
