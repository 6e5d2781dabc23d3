"""Plates of Exudyn's thin element, what holds and loads them, and its solvers."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from benchmarks.scenes import Scene

GAUSS = 3**-0.5
X, Y, Z = range(3)
# A node has a position r and the slopes r_x and r_y.
NODE = 9


class Plate:
    """Elements over a grid of two parameters.

    Parameters
    ----------
    x, y : array
        The parameters of the grid lines.
    surface : callable, optional
        From arrays x and y to r, r_x and r_y, three components each; a flat plate if None.
    inside : callable, optional
        From the middles of the elements to which of them exist.
    """

    def __init__(
        self, scene: Scene, x: Any, y: Any, reduced: bool, surface: Any = None, inside: Any = None, density: float = 0.0
    ) -> None:
        import exudyn as exu
        from exudyn.itemInterface import NodePointGround, NodePointSlope12, ObjectANCFThinPlate

        self.system = exu.SystemContainer()
        self.mbs = self.system.AddSystem()
        d = scene.data
        elastic = d["young"] / (1 - d["poisson"] ** 2) * np.array(
            [[1, d["poisson"], 0], [d["poisson"], 1, 0], [0, 0, (1 - d["poisson"]) / 2]]
        )  # fmt: skip
        section: dict[str, Any] = {"thickness": d["thickness"], "density": density, "useReducedOrderIntegration": int(reduced)}
        for key, factor in (("strainCoefficients", d["thickness"]), ("curvatureCoefficients", d["thickness"] ** 3 / 12)):
            section[key] = exu.Matrix3DList()
            section[key].Append(factor * elastic)

        shape = (len(y), len(x))
        coordinates, lengths = placed(*np.meshgrid(x, y), surface)
        index = np.arange(shape[0] * shape[1]).reshape(shape)
        cells = corners(index).reshape(-1, 4)
        # The element wants its slopes scaled from unit vectors to derivatives by its own parameters from 0 to 1.
        scales = [corners(lengths[k]) * step for k, step in enumerate((np.diff(x)[:, None], np.diff(y)[:, None, None]))]
        scales = [scale.reshape(-1, 4) for scale in scales]
        if inside is not None:
            keep = inside(*np.meshgrid((x[1:] + x[:-1]) / 2, (y[1:] + y[:-1]) / 2)).ravel()
            cells, scales = cells[keep], [scale[keep] for scale in scales]
        used = np.zeros(index.size, dtype=bool)
        used[cells] = True
        self.points = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
        # Number of the node at each point of the grid, -1 where there is none.
        self.index = np.where(used, np.cumsum(used) - 1, -1).reshape(shape)
        self.nodes = [self.mbs.AddNode(NodePointSlope12(referenceCoordinates=q)) for q in coordinates.reshape(-1, NODE)[used].tolist()]
        self.points = self.points[used]
        numbers = self.index.ravel()[cells]
        self.elements = [
            self.mbs.AddObject(
                ObjectANCFThinPlate(nodeNumbers=[self.nodes[i] for i in cell], slopesScalingX=sx, slopesScalingY=sy, **section)
            )
            for cell, sx, sy in zip(numbers.tolist(), *(scale.tolist() for scale in scales), strict=True)
        ]
        self.fixed: dict[tuple[int, int], Any] = {}
        self.ground = self.marker(self.mbs.AddNode(NodePointGround()), 0)

    def marker(self, node: Any, coordinate: int) -> Any:
        from exudyn.itemInterface import MarkerNodeCoordinate

        return self.mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate))

    def fix(self, nodes: Iterable[int], position: Sequence[int] = (), slope_x: Sequence[int] = (), slope_y: Sequence[int] = ()) -> Any:
        """Components of positions and slopes that stay; returns the last constraint."""
        from exudyn.itemInterface import ObjectConnectorCoordinate

        coordinates = [*position, *(3 + c for c in slope_x), *(6 + c for c in slope_y)]
        wanted = dict.fromkeys((int(node), c) for node in nodes for c in coordinates)
        # A coordinate that is held twice makes the system singular.
        for node, c in [key for key in wanted if key not in self.fixed]:
            markers = [self.ground, self.marker(self.nodes[node], c)]
            self.fixed[node, c] = self.mbs.AddObject(ObjectConnectorCoordinate(markerNumbers=markers))
        return self.fixed[next(reversed(wanted))]

    def mirror(self, nodes: Iterable[int], axis: int, along: str) -> None:
        """Symmetry about the plane normal to a coordinate axis, on a line of nodes along the first or the second parameter."""
        others = [c for c in range(3) if c != axis]
        crossing, line = ("slope_x", "slope_y") if along == "y" else ("slope_y", "slope_x")
        self.fix(nodes, position=[axis], **{crossing: others, line: [axis]})

    def force(self, node: int, vector: Sequence[float]) -> None:
        from exudyn.itemInterface import LoadForceVector, MarkerNodePosition

        marker = self.mbs.AddMarker(MarkerNodePosition(nodeNumber=self.nodes[node]))
        self.mbs.AddLoad(LoadForceVector(markerNumber=marker, loadVector=vector))

    def end_force(self, vector: Sequence[float], factor: Any = None) -> None:
        """Spread evenly over the right edge of a strip that is one element wide. Two points integrate it exactly."""
        from exudyn.itemInterface import LoadForceVector, MarkerBodyPosition

        half = [f / 2 for f in vector]
        timed = {} if factor is None else {"loadVectorUserFunction": lambda mbs, t, load: [factor(t) * f for f in load]}
        for eta in (-GAUSS, GAUSS):
            marker = self.mbs.AddMarker(MarkerBodyPosition(bodyNumber=self.elements[-1], localPosition=[1.0, eta, 0.0]))
            self.mbs.AddLoad(LoadForceVector(markerNumber=marker, loadVector=half, **timed))

    def end_moment(self, vector: Sequence[float]) -> None:
        """Spread evenly over the right edge of a strip that is one element wide."""
        from exudyn.itemInterface import LoadTorqueVector, MarkerNodeRigid

        for node in self.index[:, -1]:
            marker = self.mbs.AddMarker(MarkerNodeRigid(nodeNumber=self.nodes[node]))
            self.mbs.AddLoad(LoadTorqueVector(markerNumber=marker, loadVector=[m / 2 for m in vector]))

    def surface_load(self, vector: Sequence[float]) -> None:
        """Per area, as the weight of a plate whose mass per area is one."""
        from exudyn.itemInterface import LoadMassProportional, MarkerBodyMass

        for element in self.elements:
            marker = self.mbs.AddMarker(MarkerBodyMass(bodyNumber=element))
            self.mbs.AddLoad(LoadMassProportional(markerNumber=marker, loadVector=vector))

    def displacement(self, node: int) -> Any:
        import exudyn as exu

        return self.mbs.GetNodeOutput(self.nodes[node], exu.OutputVariableType.Displacement)

    @property
    def free(self) -> int:
        return NODE * len(self.nodes) - len(self.fixed)


def placed(x: Any, y: Any, surface: Any) -> tuple[Any, Any]:
    """Positions and unit slopes (..., 9) at the points of a grid, and the lengths of the slopes (2, ...)."""
    if surface is None:
        zero, one = np.zeros_like(x), np.ones_like(x)
        return np.stack([x, y, zero, one, zero, zero, zero, one, zero], axis=-1), np.stack([one, one])
    r, r_x, r_y = (np.stack(np.broadcast_arrays(*v, x)[:3], axis=-1) for v in surface(x, y))
    lengths = np.linalg.norm([r_x, r_y], axis=-1)
    return np.concatenate([r, r_x / lengths[0][..., None], r_y / lengths[1][..., None]], axis=-1), lengths


def corners(grid: Any) -> Any:
    """The values of a grid at the corners of its cells, counterclockwise."""
    return np.stack([grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]], axis=-1)


def settings(kind: str = "EigenSparse") -> Any:
    """One thread, a sparse solver, no files."""
    import exudyn as exu

    s = exu.SimulationSettings()
    s.linearSolver.solverType = getattr(exu.LinearSolverType, kind)
    s.linearSolver.reuseAnalyzedPattern = True
    s.linearSolver.showCausingItems = False
    s.parallel.numberOfThreads = 1
    s.solution.file.write = False
    s.staticSolver.verboseMode = 0
    return s


def static(plate: Plate, steps: int = 1, rtol: float = 1e-3, linear: bool = False, **others: Any) -> str:
    """Solves for the full load; returns a note."""
    s = settings()
    solver = s.staticSolver
    solver.numberOfLoadSteps = steps
    solver.newton.relativeTolerance = rtol
    # Else the tolerance is relative to the large residual after a first iteration that bends a plate and stretches it.
    solver.newton.adaptInitialResidual = False
    solver.computeLoadsJacobian = others.pop("follow", False)
    if linear:
        solver.newton.active = False
    for key, value in others.items():
        setattr(solver, key, value)
    plate.mbs.SolveStatic(s, updateInitialValues=True)
    done = plate.mbs.sys["staticSolver"]
    return f"{done.it.currentStepIndex - 1} steps, {done.it.newtonStepsCount} iterations"


def simulate(plate: Plate, scene: Scene, every: int, watched: Sequence[int], rtol: float = 1e-2) -> tuple[Any, str]:
    """Displacements (times, nodes, 3) at the scene's times with ``every`` equal steps from one to the next, and a note.

    One matrix is factorised, for the first step, and used as long as the iterations with it converge.
    """
    import exudyn as exu
    from exudyn.itemInterface import SensorNode

    how = {"storeInternal": True, "outputVariableType": exu.OutputVariableType.Displacement, "writeToFile": False}
    sensors = [plate.mbs.AddSensor(SensorNode(nodeNumber=plate.nodes[node], **how)) for node in watched]
    plate.mbs.Assemble()
    s = settings()
    s.solution.sensors.writePeriod = scene.times[-1] / len(scene.times)
    solver = s.timeIntegration
    solver.endTime = scene.times[-1]
    solver.numberOfSteps = every * len(scene.times)
    solver.newton.relativeTolerance = rtol
    solver.newton.adaptInitialResidual = False
    solver.newton.useModifiedNewton = True
    solver.generalizedAlpha.spectralRadius = 0.9
    plate.mbs.SolveDynamic(s)
    series = np.stack([plate.mbs.GetSensorStoredData(sensor) for sensor in sensors], axis=1)
    if series.shape[0] != len(scene.times) + 1 or not np.allclose(series[1:, 0, 0], scene.times):
        raise RuntimeError(f"{len(series) - 1} stored times, {len(scene.times)} asked for")
    it = plate.mbs.sys["dynamicSolver"].it
    note = f"{it.currentStepIndex - 1} steps, {it.newtonStepsCount} iterations, {it.newtonJacobiCount} matrices"
    return series[1:, :, 1:], note
