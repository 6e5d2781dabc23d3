"""The scenes as models of Kratos, and what is read off their solutions."""

from collections.abc import Callable
from math import pi
from typing import Any

import numpy as np

from benchmarks.programs.kratos_shell import Shell, grid
from benchmarks.programs.program import Outcome
from benchmarks.scenes import Scene

QUADS_THIN = "ShellThinElementCorotational3D4N"
TRIANGLES_THIN = "ShellThinElementCorotational3D3N"
# The class that ShellThickElementCorotational3D4N was up to 10.4.0. In 10.4.4 the element of that name corrupts memory.
QUADS_THICK = "LegacyThickShellCorotationalElement3D4N"
# Where triangles are more accurate than quadrilaterals on the same nodes; on the hemisphere they are less, and less robust.
TRIANGLES = ("l_shape", "corner_plate", "hinged_roof", "paper_2n", "paper_20n")

Result = tuple[dict[str, Any], Shell]


def solve(scene: Scene, variant: str, n: int) -> Outcome:
    element = QUADS_THICK if variant == "thick" else TRIANGLES_THIN if scene.name in TRIANGLES else QUADS_THIN
    values, shell = MODELS[scene.name](scene, element, n)
    return Outcome(values, shell.dofs, f"{shell.steps} steps, {shell.iterations} iterations" if shell.steps else "")


def flat(parameters: Any) -> Any:
    return np.column_stack([parameters, np.zeros(len(parameters))])


def symmetric(shell: Shell, nodes: Any, axis: str) -> None:
    """On a plane of symmetry normal to the axis."""
    shell.fix(nodes, axis, "XYZ".replace(axis, ""))


def strip(scene: Scene, element: str, n: int, wide: int, moving: bool = False) -> tuple[Shell, Any, Any]:
    """With n by ``wide`` elements; with the nodes of the loaded end and their shares of a load that is even along it."""
    d = scene.data
    points, quads = grid(np.linspace(0, d["length"], n + 1), np.linspace(0, d["width"], wide + 1))
    share = np.full((wide + 1, 1), 1 / wide)
    share[[0, -1]] /= 2
    return Shell(d, element, flat(points), quads, moving), np.arange(wide + 1) + n * (wide + 1), share


def end_of(shell: Shell, end: Any) -> dict[str, float]:
    """The middle of the end: between the middle nodes if there is none."""
    u = (shell.displacement(end[(len(end) - 1) // 2]) + shell.displacement(end[len(end) // 2])) / 2
    return {"u": -float(u[0]), "w": float(u[2])}


def end_shear(scene: Scene, element: str, n: int) -> Result:
    """Wider than one element if fine: the shear flexibility of the thick one grows with its longest side."""
    wide = max(1, round(n / 12))
    shell, end, share = strip(scene, element, n, wide)
    shell.fix(range(wide + 1), "XYZ", "XYZ")
    shell.load(end, share * [0.0, 0.0, scene.data["force"]])
    thin_steps = 1 if n <= 12 else 2 if n <= 32 else 4
    shell.static(1 if element == QUADS_THICK else thin_steps, tolerance=1e-5)
    return end_of(shell, end), shell


def roll_up(scene: Scene, element: str, n: int) -> Result:
    shell, end, share = strip(scene, element, n, 1)
    shell.fix((0, 1), "XYZ", "XYZ")
    shell.load(end, share * [0.0, -scene.data["moment"], 0.0], moment=True)
    shell.static(2 if element == QUADS_THICK else 4, tolerance=1e-5)
    return end_of(shell, end), shell


def hemisphere(scene: Scene, element: str, n: int) -> Result:
    d, half = scene.data, scene.data["force"] / 2
    points, quads = grid(np.linspace(0, pi / 2, n + 1), (pi / 2 - d["hole"]) * np.linspace(0, 1, n + 1))
    across, up = points.T
    places = d["radius"] * np.column_stack([np.cos(up) * np.cos(across), np.cos(up) * np.sin(across), np.sin(up)])
    shell = Shell(d, element, places, quads)
    a, b, middle = 0, n * (n + 1), (n // 2) * (n + 1)
    symmetric(shell, range(n + 1), "Y")
    symmetric(shell, range(b, b + n + 1), "X")
    shell.fix([middle], "Z")
    shell.load([a, b], [[half, 0, 0], [0, -half, 0]])
    coarse, fine = (10, 5) if element == QUADS_THICK else (8, 6)
    shell.static(coarse if n < 24 else fine, tolerance=1e-4)
    return {"outwards": float(shell.displacement(a)[0]), "inwards": -float(shell.displacement(b)[1])}, shell


def hinged_roof(scene: Scene, element: str, n: int) -> Result:
    """The crown is held by a condition of displacement control."""
    d = scene.data
    points, quads = grid(np.linspace(0, d["half_length"], n + 1), pi / 2 - d["half_angle"] * np.linspace(1, 0, n + 1))
    along, angle = points.T
    places = np.column_stack([along, d["radius"] * np.cos(angle), d["radius"] * np.sin(angle)])
    crown = len(points) - 1
    shell = Shell(d, element, places, quads, pressing=True)
    shell.fix(range(0, len(points), n + 1), "XYZ")
    symmetric(shell, range(n, len(points), n + 1), "Y")
    symmetric(shell, range(n * (n + 1), len(points)), "X")
    forces = shell.press(crown, [d[f"deflection_{k}"] for k in range(len(scene.quantities))], force=100.0, tolerance=1e-4)
    return {f"force_{k}": 4 * force for k, force in enumerate(forces)}, shell


def l_shape(scene: Scene, element: str, n: int) -> Result:
    """Fine at the re-entrant corner. The plate only bends: displacements in its plane are held."""
    d = scene.data
    half = np.linspace(0, 1, n + 1) ** 1.5
    line = np.concatenate([-half[:0:-1], half])
    points, quads = grid(line, line)
    centres = points[quads].mean(axis=1)
    quads = quads[~((centres[:, 0] > 0) & (centres[:, 1] < 0))]
    sides = points[quads[:, 2]] - points[quads[:, 0]]
    area = np.zeros(len(points))
    np.add.at(area, quads, (sides[:, 0] * sides[:, 1] / 4)[:, None])
    used = np.flatnonzero(area)
    number = np.full(len(points), -1)
    number[used] = np.arange(len(used))
    (x, y), area = points[used].T, area[used]
    shell = Shell(d, element, flat(points[used]), number[quads])
    boundary = (abs(x) == 1) | (abs(y) == 1) | ((x == 0) & (y <= 0)) | ((y == 0) & (x >= 0))
    inner = np.flatnonzero(~boundary)
    shell.fix(np.flatnonzero(boundary), "XYZ", "XYZ")
    shell.fix(inner, "XY", "Z")
    shell.load(inner, np.outer(area[inner] * d["pressure"], [0, 0, 1]))
    shell.linear()
    return {"volume": float(area @ shell.displacements()[:, 2])}, shell


def corner_plate(scene: Scene, element: str, n: int) -> Result:
    """The plate only bends: displacements in its plane are held."""
    d, side = scene.data, scene.data["side"] / 2
    line = np.linspace(0, side, n + 1)
    points, quads = grid(line, line)
    shell = Shell(d, element, flat(points), quads)
    shell.fix(range(len(points)), "XY", "Z")
    shell.fix(range(n + 1), "", "Y")
    shell.fix(range(0, len(points), n + 1), "", "X")
    shell.fix([len(points) - 1], "Z")
    shell.load([0], [[0, 0, d["force"] / 4]])
    shell.linear()
    return {"centre": float(shell.displacement(0)[2]), "edge": float(shell.displacement(n)[2])}, shell


# Steps for each size, by trial; at 16 and 24 the plate's step still matters about as much as the mesh.
TIME_STEPS = {
    "paper": {8: 0.01, 12: 0.005, 16: 0.005, 24: 0.0025, 32: 0.0025},
    "free_ruler": {8: 1.25e-4, 12: 1.25e-4, 16: 1.25e-4, 24: 6.25e-5, 32: 3.125e-5, 48: 2.5e-5},
}


def paper_example(scene: Scene, element: str, n: int) -> Result:
    d, half = scene.data, scene.data["side"] / 2
    line = np.linspace(0, half, n + 1)
    points, quads = grid(line, line)
    shell = Shell(d, element, flat(points), quads, moving=True)
    centre, edge = len(points) - 1, n * (n + 1)
    shell.fix([0], "XYZ")
    symmetric(shell, range(edge, centre + 1), "X")
    symmetric(shell, range(n, centre + 1, n + 1), "Y")
    shell.load([centre], [[0, 0, d["force"] / 4]])
    nodes = {"centre": centre, "quarter": (n // 2) * (n + 2), "edge": edge}
    # Faster here than the direct solver. The error was the same to three digits with corrections below 1e-3 instead of a
    # tenth of the displacements, which takes nearly twice the iterations.
    rows = shell.march(scene.times, TIME_STEPS["paper"][n], lambda t: 1.0, nodes.values(), 0.1, 0.0, "sparse_cg")
    return {key: rows[:, k, 2].tolist() for k, key in enumerate(nodes)}, shell


def free_ruler(scene: Scene, element: str, n: int) -> Result:
    d, wide = scene.data, 2
    shell, end, share = strip(scene, element, n, wide, moving=True)
    shell.load(end, share * [d["force_x"], 0, d["force_z"]])

    def pulse(t: float) -> float:
        return max(0.0, min(t / d["peak"], (d["over"] - t) / (d["over"] - d["peak"])))

    nodes = {"near": wide // 2, "far": end[wide // 2]}
    # Conjugate gradients fail here, and so do long steps without damping.
    rows = shell.march(scene.times, TIME_STEPS["free_ruler"][n], pulse, nodes.values(), 1e-2, -0.1, "sparse_lu")
    components = [(f"{key}_{axis}", k, j) for k, key in enumerate(nodes) for axis, j in (("x", 0), ("z", 2))]
    return {name: rows[:, k, j].tolist() for name, k, j in components}, shell


MODELS: dict[str, Callable[[Scene, str, int], Result]] = {
    "end_shear": end_shear, "roll_up": roll_up, "hemisphere": hemisphere, "hinged_roof": hinged_roof, "l_shape": l_shape,
    "corner_plate": corner_plate, "paper_2n": paper_example, "paper_20n": paper_example, "free_ruler": free_ruler,
}  # fmt: skip
