"""CalculiX (ccx): one layer of quadratic bricks with reduced integration, a process for each run.

Its shell element S8R is expanded to the same brick, tied to the shell's nodes by further equations.
"""

import subprocess
from math import pi
from typing import Any

from benchmarks.programs.calculix_bricks import Bricks, slab
from benchmarks.programs.program import Outcome, Program, Variant
from benchmarks.scenes import Scene

# Time steps for each number of elements along the longer side.
STEPS: dict[str, dict[float, int]] = {
    "paper_2n": {2: 50, 4: 100, 6: 140, 8: 200},
    "paper_20n": {2: 50, 4: 100, 6: 140, 8: 200},
    "free_ruler": {4: 100, 6: 200, 8: 300, 10: 400, 12: 800, 16: 1600},
}
SIZES = {
    "end_shear": (4, 6, 8, 10, 14, 20, 28), "roll_up": (8, 10, 12, 16, 24), "hemisphere": (4, 6, 8, 12, 16, 24),
    "hinged_roof": (2, 3, 4, 6, 8, 12), "l_shape": (8, 12, 16, 24, 32, 48, 64, 96),
    "corner_plate": (2, 3, 4, 6, 8, 12, 16, 24, 32),
}  # fmt: skip
VARIANTS = {
    "solid": Variant("CalculiX, C3D20R", "thick", {**SIZES, **{name: tuple(steps) for name, steps in STEPS.items()}})
}


def prepare() -> None:
    import numpy  # noqa: F401


def version() -> str:
    told = subprocess.run(["ccx", "-v"], capture_output=True, text=True, check=False).stdout.split()
    return f"CalculiX {told[-1]}"


def run(scene: Scene, variant: str, size: float) -> Outcome:
    return SOLVERS[scene.name](scene, int(size))


def strip(scene: Scene, n: int) -> Outcome:
    """Without a Poisson effect nothing moves across the strip; holding that keeps one row of elements from twisting."""
    d = scene.data
    bricks = Bricks(slab(n, 1, d["length"], d["width"], d["thickness"]), d)
    bricks.fix(bricks.ids[:-1], 2)
    bricks.fix(bricks.ids[0], 1, 3)
    if scene.name == "end_shear":
        bricks.fix(bricks.ids[-1], 2)
        load = bricks.end_load(3, d["force"])
    else:
        # The end stays plane; its moment turns the node that carries its rotations.
        centre, turn = bricks.count + 1, bricks.count + 2
        face = bricks.ids[-1][bricks.ids[-1] > 0].tolist()
        x, y = d["length"], d["width"] / 2
        bricks.lines += ["*NODE", f"{centre},{x},{y},0", f"{turn},{x},{y},0", "*NSET,NSET=END", *map(str, face)]
        bricks.lines += [
            f"*RIGID BODY,NSET=END,REF NODE={centre},ROT NODE={turn}",
            "*BOUNDARY",
            f"{centre},2",
            f"{turn},1",
            f"{turn},3",
        ]
        load = [f"{turn},2,{-d['moment']!r}"]
    # The moment in 40 equal increments, the fastest of 1 ... 40: longer ones are cut, and again and again.
    first = 1.0 if scene.name == "end_shear" else 0.025
    bricks.step("*STATIC", f"{first},1.,1e-5,{first}", "*CLOAD", *load, out=[bricks.ids[-1, 0, 1]])
    blocks, note = bricks.solve()
    _, u, _, w = blocks[-1][1][0]
    return bricks.outcome({"u": -u, "w": w}, note)


def hemisphere(scene: Scene, n: int) -> Outcome:
    import numpy as np

    d, m = scene.data, 2 * n + 1
    polar, around, r = np.meshgrid(
        np.linspace(d["hole"], pi / 2, m),
        np.linspace(0, pi / 2, m),
        d["radius"] + d["thickness"] * np.linspace(-0.5, 0.5, 3),
        indexing="ij",
    )
    bricks = Bricks(
        r[..., None] * np.stack([np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around), np.cos(polar)], -1), d
    )
    bricks.fix(bricks.ids[:, 0], 2)
    bricks.fix(bricks.ids[:, -1], 1)
    a, b = bricks.ids[-1, 0, 1], bricks.ids[-1, -1, 1]
    bricks.fix(bricks.ids[-1, :1, 1], 3)
    half = d["force"] / 2
    bricks.step("*STATIC", "0.05,1.,1e-5,0.05", "*CLOAD", f"{a},1,{half!r}", f"{b},2,{-half!r}", out=[a, b])
    blocks, note = bricks.solve()
    rows = {int(row[0]): row[1:] for row in blocks[-1][1]}
    return bricks.outcome({"outwards": rows[a][0], "inwards": -rows[b][1]}, note)


def hinged_roof(scene: Scene, n: int) -> Outcome:
    """The hinges hold the mean of the top and the bottom, which leaves the edge free to turn."""
    import numpy as np

    d, m = scene.data, 2 * n + 1
    x, angle, r = np.meshgrid(
        np.linspace(0, d["half_length"], m), np.linspace(-d["half_angle"], 0, m),
        d["radius"] + d["thickness"] * np.linspace(-0.5, 0.5, 3), indexing="ij",
    )  # fmt: skip
    bricks = Bricks(np.stack([x, r * np.sin(angle), r * np.cos(angle)], -1), d)
    low, top = bricks.ids[:, 0, 0], bricks.ids[:, 0, 2]
    bricks.fix(bricks.ids[:, 0, 1], 1, 2, 3)
    bricks.fix(bricks.ids[:, -1], 2)
    bricks.fix(bricks.ids[-1, 1:], 1)
    bricks.fix(bricks.ids[-1, 0, ::2], 1)
    pairs = [(a, b, dof) for a, b in zip(low.tolist(), top.tolist(), strict=True) for dof in (1, 2, 3)]
    # The last two are in the plane of symmetry already.
    pairs.remove((low[-1], top[-1], 1))
    bricks.lines += [f"*EQUATION\n2\n{a},{dof},1.,{b},{dof},1." for a, b, dof in pairs]
    bricks.held += len(pairs)
    crown = bricks.ids[-1, -1, 1]
    for k in range(len(scene.quantities)):
        pressed = ("*BOUNDARY", f"{crown},3,3,{-d[f'deflection_{k}']!r}")
        bricks.step("*STATIC", "1.,1.,1e-5,1.", *pressed, out=[crown], what="RF")
    blocks, note = bricks.solve()
    return bricks.outcome({f"force_{k}": -4 * block[1][0][3] for k, block in enumerate(blocks)}, note)


def l_shape(scene: Scene, n: int) -> Outcome:
    """The work of the load is twice the strain energy."""
    import numpy as np

    d = scene.data
    points = slab(n, n, 2.0, 2.0, d["thickness"]) - np.array([1.0, 1.0, 0.0])
    middle = points[1::2, 1::2, 1:2]
    bricks = Bricks(points, d, keep=(middle[..., 0] < 0) | (middle[..., 1] > 0))
    bricks.fix(edge(bricks.ids), 1, 2, 3)
    bricks.step(
        "*STATIC", "*DLOAD", f"EALL,P1,{d['pressure']!r}", "*EL PRINT,ELSET=EALL,TOTALS=ONLY", "ELSE", geometry=False
    )
    blocks, _ = bricks.solve()
    return bricks.outcome({"volume": 2 * blocks[-1][1][0][0] / d["pressure"]})


def corner_plate(scene: Scene, n: int) -> Outcome:
    d, half = scene.data, scene.data["side"] / 2
    bricks = Bricks(slab(n, n, half, half, d["thickness"]), d)
    ids = bricks.ids
    bricks.fix(ids[0], 1)
    bricks.fix(ids[:, 0], 2)
    bricks.fix(ids[-1:, -1, 1], 3)
    centre, edge_node = ids[0, 0, 1], ids[0, -1, 1]
    bricks.step("*STATIC", "*CLOAD", f"{centre},3,{d['force'] / 4!r}", out=[centre, edge_node], geometry=False)
    blocks, _ = bricks.solve()
    rows = {int(row[0]): row[3] for row in blocks[-1][1]}
    return bricks.outcome({"centre": rows[centre], "edge": rows[edge_node]})


def edge(ids: Any) -> Any:
    """The nodes on the boundary of the L, once each."""
    import numpy as np

    half = ids.shape[0] // 2
    sides = [ids[0], ids[:, -1], ids[: half + 1, 0], ids[half, : half + 1], ids[half:, half], ids[-1, half:]]
    return np.unique(np.concatenate([side.ravel() for side in sides]))


def paper_example(scene: Scene, n: int) -> Outcome:
    d, half = scene.data, scene.data["side"] / 2
    bricks = Bricks(slab(n, n, half, half, d["thickness"]), d)
    ids = bricks.ids
    bricks.fix(ids[:1, 0, 1], 1, 2, 3)
    bricks.fix(ids[-1], 1)
    bricks.fix(ids[:, -1], 2)
    if n % 2:
        raise ValueError(f"{n} elements along half a side: an even number puts a node at a quarter")
    points = {"centre": (ids[-1, -1, 1], 2), "quarter": (ids[n, n, 1], 2), "edge": (ids[-1, 0, 1], 2)}
    return moving(scene, bricks, [f"{ids[-1, -1, 1]},3,{d['force'] / 4!r}"], STEPS[scene.name][n], points)


def free_ruler(scene: Scene, n: int) -> Outcome:
    """Nothing moves across it, as in the strips."""
    d = scene.data
    bricks = Bricks(slab(n, 1, d["length"], d["width"], d["thickness"]), d)
    bricks.fix(bricks.ids, 2)
    bricks.lines += ["*AMPLITUDE,NAME=PULSE", f"0.,0.,{d['peak']!r},1.,{d['over']!r},0.,1.,0."]
    load = bricks.end_load(1, d["force_x"]) + bricks.end_load(3, d["force_z"])
    near, far = bricks.ids[0, 0, 1], bricks.ids[-1, 0, 1]
    points = {"near_x": (near, 0), "near_z": (near, 2), "far_x": (far, 0), "far_z": (far, 2)}
    return moving(scene, bricks, load, STEPS["free_ruler"][n], points, ",AMPLITUDE=PULSE")


def moving(
    scene: Scene, bricks: Bricks, load: list[str], steps: int, points: dict[str, tuple[Any, int]], option: str = ""
) -> Outcome:
    """Equal steps of the alpha method, and the series between them. A number in a deck has at most 20 characters."""
    import numpy as np

    end = scene.data["end"]
    out = sorted({int(node) for node, _ in points.values()})
    bricks.step("*DYNAMIC,DIRECT,ALPHA=-0.05", f"{end / steps:.12g},{end!r}", "*CLOAD" + option, *load, out=out, every=1)
    blocks, note = bricks.solve()
    times = [0.0, *(time for time, _ in blocks)]
    series = {key: [0.0] for key in points}
    for _, rows in blocks:
        now = {int(row[0]): row[1:] for row in rows}
        for key, (node, axis) in points.items():
            series[key].append(now[int(node)][axis])
    return bricks.outcome({key: np.interp(scene.times, times, row).tolist() for key, row in series.items()}, note)


SOLVERS = {
    "end_shear": strip, "roll_up": strip, "hemisphere": hemisphere, "hinged_roof": hinged_roof, "l_shape": l_shape,
    "corner_plate": corner_plate, "paper_2n": paper_example, "paper_20n": paper_example, "free_ruler": free_ruler,
}  # fmt: skip
PROGRAM = Program("CalculiX", VARIANTS, prepare, version, run, environment="calculix")
