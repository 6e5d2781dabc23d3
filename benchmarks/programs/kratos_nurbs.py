"""The scenes as Kirchhoff-Love shells of Kratos on one B-spline patch of degree three."""

from collections.abc import Callable
from math import pi
from typing import Any

import KratosMultiphysics as Kratos
import KratosMultiphysics.IgaApplication  # registers the element
import numpy as np

from benchmarks.programs.kratos_shell import Shell
from benchmarks.programs.program import Outcome
from benchmarks.scenes import Scene

DEGREE = 3


class Line:
    """B-splines over spans of [0, 1], uniform or fine, for forces at points, at its "start", its "end" or "both"."""

    def __init__(self, spans: int, fine: str = "", power: float = 2.0) -> None:
        t = np.linspace(0, 1, spans + 1)
        if fine == "both":
            t = np.where(t < 0.5, (2 * t) ** power, 2 - (2 - 2 * t) ** power) / 2
        elif fine:
            t = t**power if fine == "start" else 1 - (1 - t) ** power
        self.count = spans + DEGREE
        self.knots = np.concatenate([np.zeros(DEGREE), t, np.ones(DEGREE)])
        self.points = np.array([self.knots[k + 1 : k + DEGREE + 1].mean() for k in range(self.count)])
        self.shares = (self.knots[DEGREE + 1 :] - self.knots[: self.count]) / (DEGREE + 1)

    def values(self, x: float) -> Any:
        """Of all functions, by the recursion over the degree."""
        t = self.knots
        at = min(int(np.searchsorted(t, x, "right")) - 1, self.count - 1)
        basis = np.zeros(len(t) - 1)
        basis[at] = 1.0
        for p in range(1, DEGREE + 1):
            for k in range(at - p, at + 1):
                left = (x - t[k]) / (t[k + p] - t[k]) * basis[k] if t[k + p] > t[k] else 0.0
                right = (t[k + p + 1] - x) / (t[k + p + 1] - t[k + 1]) * basis[k + 1] if t[k + p + 1] > t[k + 1] else 0.0
                basis[k] = left + right
        return basis[: self.count]


class Patch(Shell):
    """Over the unit square; ``place`` maps its points (k, 2) to (k, 3). The patch interpolates it. Control points (i, j)."""

    builder = Kratos.ResidualBasedBlockBuilderAndSolver
    lumped = False

    def __init__(self, data: Any, place: Callable[[Any], Any], lines: tuple[Line, Line], **options: bool) -> None:
        self.lines = u, v = lines
        at = np.stack(np.meshgrid(u.points, v.points, indexing="ij"), -1)
        inverses = [np.linalg.inv([line.values(x) for x in line.points]) for line in self.lines]
        wanted = place(at.reshape(-1, 2)).reshape(u.count, v.count, 3)
        controls = np.einsum("ia,jb,abc->ijc", *inverses, wanted)
        self.index = np.arange(u.count * v.count).reshape(v.count, u.count).T
        self.equal: dict[tuple[int, str], tuple[int, str]] = {}
        super().__init__(data, "", controls.transpose(1, 0, 2).reshape(-1, 3), np.zeros((0, 4), int), **options)
        nodes = Kratos.NodesVector()
        for k in range(1, self.part.NumberOfNodes() + 1):
            nodes.append(self.part.GetNode(k))
        knots = [Kratos.Vector(line.knots[1:-1].tolist()) for line in self.lines]
        self.surface = Kratos.NurbsSurfaceGeometry3D(nodes, DEGREE, DEGREE, *knots)
        points = Kratos.GeometriesVector()
        self.surface.CreateQuadraturePointGeometries(points, 3)
        for k in range(len(points)):
            self.part.CreateNewElement("Shell3pElement", k + 1, points[k], self.properties)

    def symmetric(self, edge: Any, next_row: Any, axis: str) -> None:
        """A plane of symmetry normal to the axis: the edge stays in it and the patch crosses it at a right angle."""
        self.fix(edge, axis)
        for a, b in zip(edge.tolist(), next_row.tolist(), strict=True):
            for other in "XYZ".replace(axis, ""):
                self.equal[self.root((b, other))] = self.root((a, other))

    def root(self, key: tuple[int, str]) -> tuple[int, str]:
        while self.equal.get(key, key) != key:
            key = self.equal[key]
        return key

    def constrain(self) -> None:
        """States the equal components, those of fixed ones as fixed."""
        fixed = {(k - 1, name[-1]) for k, name in self.fixed}
        roots = {self.root(key) for key in fixed}
        number = 0
        for key in list(self.equal):
            (a, axis), (b, _) = self.root(key), key
            if (a, axis) == key:
                continue
            variable = getattr(Kratos, f"DISPLACEMENT_{axis}")
            if (a, axis) in roots:
                self.fix([b], axis)
                self.fix([a], axis)
            else:
                number += 1
                master, slave = self.part.GetNode(a + 1), self.part.GetNode(b + 1)
                self.part.CreateNewMasterSlaveConstraint(
                    "LinearMasterSlaveConstraint", number, master, variable, slave, variable, 1.0, 0.0
                )
        self.constraints = number

    @property
    def dofs(self) -> int:
        return 3 * self.part.NumberOfNodes() - len(self.fixed) - self.constraints

    def at(self, x: float, y: float) -> Any:
        """Weights of the control points."""
        return np.outer(self.lines[1].values(y), self.lines[0].values(x)).ravel()

    def displacement_at(self, x: float, y: float) -> Any:
        return self.at(x, y) @ self.displacements()


Result = tuple[dict[str, Any], Patch]


def solve(scene: Scene, n: int) -> Outcome:
    values, patch = MODELS[scene.name](scene, n)
    return Outcome(values, patch.dofs, f"{patch.steps} steps, {patch.iterations} iterations" if patch.steps else "")


def plane(length: float, width: float) -> Callable[[Any], Any]:
    return lambda x: np.column_stack([length * x[:, 0], width * x[:, 1], np.zeros(len(x))])


def end_shear(scene: Scene, n: int) -> Result:
    d = scene.data
    patch = Patch(d, plane(d["length"], d["width"]), (Line(n), Line(1)))
    patch.fix(patch.index[0], "XYZ")
    patch.fix(patch.index[1], "YZ")
    patch.load(patch.index[-1], np.outer(patch.lines[1].shares, [0, 0, d["force"]]))
    patch.constrain()
    patch.static(1, tolerance=1e-5)
    u, _, w = patch.displacement_at(1.0, 0.5).tolist()
    return {"u": -u, "w": w}, patch


def hemisphere(scene: Scene, n: int) -> Result:
    d, half = scene.data, scene.data["force"] / 2

    def place(x: Any) -> Any:
        across, up = pi / 2 * x[:, 0], (pi / 2 - d["hole"]) * x[:, 1]
        return d["radius"] * np.column_stack([np.cos(up) * np.cos(across), np.cos(up) * np.sin(across), np.sin(up)])

    patch = Patch(d, place, (Line(n, "both", 1.5), Line(n, "start", 1.5)))
    a, b = patch.index[0, 0], patch.index[-1, 0]
    patch.symmetric(patch.index[0], patch.index[1], "Y")
    patch.symmetric(patch.index[-1], patch.index[-2], "X")
    patch.fix([patch.index[n // 2, 0]], "Z")
    patch.load([a, b], [[half, 0, 0], [0, -half, 0]])
    patch.constrain()
    patch.static(8, tolerance=1e-4)
    return {"outwards": float(patch.displacement(a)[0]), "inwards": -float(patch.displacement(b)[1])}, patch


def hinged_roof(scene: Scene, n: int) -> Result:
    d = scene.data

    def place(x: Any) -> Any:
        angle = pi / 2 - d["half_angle"] * (1 - x[:, 1])
        return np.column_stack([d["half_length"] * x[:, 0], d["radius"] * np.cos(angle), d["radius"] * np.sin(angle)])

    patch = Patch(d, place, (Line(n, "end"), Line(n, "end")), pressing=True)
    patch.fix(patch.index[:, 0], "XYZ")
    patch.symmetric(patch.index[:, -1], patch.index[:, -2], "Y")
    patch.symmetric(patch.index[-1], patch.index[-2], "X")
    patch.constrain()
    deflections = [d[f"deflection_{k}"] for k in range(len(scene.quantities))]
    forces = patch.press(patch.index[-1, -1], deflections, force=100.0, tolerance=1e-4)
    return {f"force_{k}": 4 * force for k, force in enumerate(forces)}, patch


def corner_plate(scene: Scene, n: int) -> Result:
    """The plate only bends: displacements in its plane are held."""
    d, side = scene.data, scene.data["side"] / 2
    patch = Patch(d, plane(side, side), (Line(n, "start"), Line(n, "start")))
    patch.fix(patch.index.ravel(), "XY")
    patch.fix([patch.index[-1, -1]], "Z")
    patch.symmetric(patch.index[0], patch.index[1], "X")
    patch.symmetric(patch.index[:, 0], patch.index[:, 1], "Y")
    patch.load([patch.index[0, 0]], [[0, 0, d["force"] / 4]])
    patch.constrain()
    patch.linear()
    return {key: float(patch.displacement(k)[2]) for key, k in (("centre", 0), ("edge", patch.index[0, -1]))}, patch


# By trial; the ruler did not converge with steps of 1.25e-4.
TIME_STEPS = {
    "paper": {4: 0.01, 6: 0.005, 8: 0.005, 12: 0.0025, 16: 0.0025},
    "free_ruler": {8: 6.25e-5, 12: 6.25e-5, 16: 6.25e-5, 24: 3.125e-5},
}


def paper_example(scene: Scene, n: int) -> Result:
    d, half = scene.data, scene.data["side"] / 2
    patch = Patch(d, plane(half, half), (Line(n), Line(n)), moving=True)
    patch.fix([0], "XYZ")
    patch.symmetric(patch.index[-1], patch.index[-2], "X")
    patch.symmetric(patch.index[:, -1], patch.index[:, -2], "Y")
    patch.load([patch.index[-1, -1]], [[0, 0, d["force"] / 4]])
    patch.constrain()
    points = {"centre": patch.at(1, 1), "quarter": patch.at(0.5, 0.5), "edge": patch.at(1, 0)}
    return follow(scene, patch, points, TIME_STEPS["paper"][n], lambda t: 1.0, 0.1, 0.0)


def free_ruler(scene: Scene, n: int) -> Result:
    d = scene.data
    patch = Patch(d, plane(d["length"], d["width"]), (Line(n), Line(1)), moving=True)
    patch.load(patch.index[-1], np.outer(patch.lines[1].shares, [d["force_x"], 0, d["force_z"]]))
    patch.constrain()
    points = {"near": patch.at(0, 0.5), "far": patch.at(1, 0.5)}

    def pulse(t: float) -> float:
        return max(0.0, min(t / d["peak"], (d["over"] - t) / (d["over"] - d["peak"])))

    return follow(scene, patch, points, TIME_STEPS["free_ruler"][n], pulse, 1e-3, -0.1)


def follow(
    scene: Scene, patch: Patch, points: dict[str, Any], size: float, factor: Any, tolerance: float, bossak: float
) -> Result:
    """The series that are named by a point, or by a point and an axis."""
    nodes = np.flatnonzero(sum(abs(weights) for weights in points.values()) > 0)
    rows = patch.march(scene.times, size, factor, nodes, tolerance, bossak, "sparse_lu")
    series = {key: np.einsum("k,tkx->tx", weights[nodes], rows) for key, weights in points.items()}
    values = {}
    for name in scene.quantities:
        point, _, axis = name.partition("_")
        values[name] = series[point][:, "xyz".index(axis or "z")].tolist()
    return values, patch


MODELS: dict[str, Callable[[Scene, int], Result]] = {
    "end_shear": end_shear, "hemisphere": hemisphere, "hinged_roof": hinged_roof, "corner_plate": corner_plate,
    "paper_2n": paper_example, "paper_20n": paper_example, "free_ruler": free_ruler,
}  # fmt: skip
