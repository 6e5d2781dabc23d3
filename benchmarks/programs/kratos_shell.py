"""A shell model in Kratos: nodes, elements, supports, forces, and its solution in one, in load or in time steps."""

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import KratosMultiphysics as Kratos
import KratosMultiphysics.LinearSolversApplication  # registers the direct solver
import KratosMultiphysics.StructuralMechanicsApplication as Structural
import numpy as np
from KratosMultiphysics import VariableUtils

DUALS = {"DISPLACEMENT": "REACTION", "ROTATION": "REACTION_MOMENT"}
STATE = (Kratos.DISPLACEMENT, Kratos.ROTATION)


def quiet() -> None:
    Kratos.Logger.GetDefaultOutput().SetSeverity(Kratos.Logger.Severity.WARNING)
    Kratos.ParallelUtilities.SetNumThreads(1)


def component(name: str, axis: str) -> Any:
    return getattr(Kratos, f"{name}_{axis}")


def linear_solver(kind: str) -> Any:
    return Kratos.LinearSolverFactory().Create(Kratos.Parameters(f'{{"solver_type": "{kind}"}}'))


def grid(columns: Any, rows: Any) -> tuple[Any, Any]:
    """Parameters (k, 2) of the nodes of a tensor mesh and the corners (m, 4) of its quadrilaterals."""
    points = np.stack(np.meshgrid(columns, rows, indexing="ij"), -1).reshape(-1, 2)
    index = np.arange(len(points)).reshape(len(columns), len(rows))
    return points, np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], -1).reshape(-1, 4)


class Shell:
    """A mesh of elements of one kind; triangles halve the quadrilaterals. Nodes are counted from 0."""

    builder = Kratos.ResidualBasedEliminationBuilderAndSolver

    def __init__(
        self, data: Any, element: str, points: Any, quads: Any, moving: bool = False, pressing: bool = False
    ) -> None:
        self.model = Kratos.Model()
        part = self.part = self.model.CreateModelPart("shell", 2)
        variables = [*STATE, Kratos.REACTION, Kratos.REACTION_MOMENT, Kratos.VOLUME_ACCELERATION]
        variables += [Structural.POINT_LOAD, Structural.POINT_MOMENT]
        if moving:
            variables += [Kratos.VELOCITY, Kratos.ACCELERATION, Kratos.ANGULAR_VELOCITY, Kratos.ANGULAR_ACCELERATION]
        if pressing:
            variables += [Structural.LOAD_FACTOR, Structural.PRESCRIBED_DISPLACEMENT]
        for variable in variables:
            part.AddNodalSolutionStepVariable(variable)
        part.ProcessInfo[Kratos.DOMAIN_SIZE] = 3
        properties = self.properties = part.GetProperties()[1]
        properties[Kratos.YOUNG_MODULUS], properties[Kratos.POISSON_RATIO] = data["young"], data["poisson"]
        properties[Kratos.THICKNESS], properties[Kratos.DENSITY] = data["thickness"], data.get("density", 1.0)
        # Bossak's scheme integrates no angular acceleration: with the rotary inertia of the consistent mass in the matrix
        # but not in the residual, small steps do not converge.
        properties[Kratos.COMPUTE_LUMPED_MASS_MATRIX] = True
        properties[Kratos.CONSTITUTIVE_LAW] = Structural.LinearElasticPlaneStress2DLaw()
        for k, (x, y, z) in enumerate(points.tolist(), 1):
            part.CreateNewNode(k, x, y, z)
        corners = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]) if element.endswith("3N") else quads
        for k, nodes in enumerate((corners + 1).tolist(), 1):
            part.CreateNewElement(element, k, nodes, properties)
        for name, dual in DUALS.items():
            for axis in "XYZ":
                VariableUtils().AddDof(component(name, axis), component(dual, axis), part)
        self.forces: list[tuple[Any, Any, Any]] = []
        self.fixed: set[tuple[int, str]] = set()
        self.steps = self.iterations = 0

    def fix(self, nodes: Iterable[int], displacement: str = "", rotation: str = "") -> None:
        names = [("DISPLACEMENT", axis) for axis in displacement] + [("ROTATION", axis) for axis in rotation]
        numbers = [int(k) + 1 for k in nodes]
        for name, axis in names:
            variable = component(name, axis)
            for k in numbers:
                self.part.GetNode(k).Fix(variable)
            self.fixed.update((k, name + axis) for k in numbers)

    def load(self, nodes: Iterable[int], vectors: Any, moment: bool = False) -> None:
        """Dead forces, or moments, (k, 3) at nodes, at load factor one."""
        variable, kind = (Structural.POINT_MOMENT, "Moment") if moment else (Structural.POINT_LOAD, "Load")
        for k, vector in zip(nodes, np.asarray(vectors, dtype=float), strict=True):
            self.part.CreateNewCondition(f"Point{kind}Condition3D1N", len(self.forces) + 1, [int(k) + 1], self.properties)
            self.forces.append((self.part.GetNode(int(k) + 1), variable, vector))

    def factor(self, value: float) -> None:
        for node, variable, vector in self.forces:
            node.SetSolutionStepValue(variable, (value * vector).tolist())

    @property
    def dofs(self) -> int:
        return 6 * self.part.NumberOfNodes() - len(self.fixed)

    def displacement(self, node: int) -> Any:
        return np.array(self.part.GetNode(int(node) + 1).GetSolutionStepValue(Kratos.DISPLACEMENT))

    def displacements(self) -> Any:
        return np.array(self.state()[0]).reshape(-1, 3)

    def state(self) -> list[Any]:
        return [VariableUtils().GetSolutionStepValuesVector(self.part.Nodes, variable, 0, 3) for variable in STATE]

    def linear(self) -> None:
        """One step from rest."""
        self.factor(1.0)
        builder = self.builder(linear_solver("sparse_lu"))
        scheme = Kratos.ResidualBasedIncrementalUpdateStaticScheme()
        strategy = Kratos.ResidualBasedLinearStrategy(self.part, scheme, builder, False, False, False, False)
        strategy.SetEchoLevel(0)
        self.part.CloneTimeStep(1.0)
        strategy.Solve()

    def newton(self, scheme: Any, tolerance: float, iterations: int, solver: str = "sparse_lu") -> None:
        """``tolerance``: of the last correction relative to all displacements. Residuals cost these elements a tangent."""
        criterion = Kratos.DisplacementCriteria(tolerance, 1e-14)
        criterion.SetEchoLevel(0)
        builder = self.builder(linear_solver(solver))
        self.strategy = Kratos.ResidualBasedNewtonRaphsonStrategy(
            self.part, scheme, criterion, builder, iterations, False, False, True
        )
        self.strategy.SetEchoLevel(0)
        self.strategy.Initialize()

    def step(self, time: float, apply: Callable[[float], Any]) -> bool:
        """From the last state to this time; the state is as before if the iteration fails."""
        before = self.state()
        self.part.CloneTimeStep(time)
        apply(time)
        try:
            self.strategy.InitializeSolutionStep()
            self.strategy.Predict()
            converged = self.strategy.SolveSolutionStep()
        except RuntimeError:
            converged = False
        self.iterations += self.part.ProcessInfo[Kratos.NL_ITERATION_NUMBER]
        if converged and np.isfinite(np.array(self.state())).all():
            self.strategy.FinalizeSolutionStep()
            self.steps += 1
            return True
        for variable, values in zip(STATE, before, strict=True):
            VariableUtils().SetSolutionStepValuesVector(self.part.Nodes, variable, values, 0)
        VariableUtils().UpdateCurrentPosition(self.part.Nodes)
        return False

    def static(self, steps: int, tolerance: float, iterations: int = 20) -> None:
        """To load factor one; a step that fails is halved."""
        self.newton(Kratos.ResidualBasedIncrementalUpdateStaticScheme(), tolerance, iterations)
        at, size = 0.0, 1.0 / steps
        while at < 1 - 1e-9:
            if self.step(min(at + size, 1.0), self.factor):
                at += size
            elif size < 1e-3:
                raise RuntimeError(f"no convergence beyond load factor {at:g}")
            else:
                size /= 2

    def press(self, node: int, deflections: Sequence[float], force: float, tolerance: float) -> list[float]:
        """The forces that hold a node at these downward deflections, a step each; the unknown is in units of ``force``."""
        place = self.part.GetNode(int(node) + 1)
        place.AddDof(Structural.LOAD_FACTOR, Structural.PRESCRIBED_DISPLACEMENT)
        held = self.part.CreateNewCondition("DisplacementControlCondition3D1N", 1, [int(node) + 1], self.properties)
        held.SetValue(Structural.POINT_LOAD, [0.0, 0.0, -force])
        self.newton(Kratos.ResidualBasedIncrementalUpdateStaticScheme(), tolerance, 20)
        forces = []
        for deflection in deflections:
            if not self.step(deflection, lambda w: held.SetValue(Structural.PRESCRIBED_DISPLACEMENT, -w)):
                raise RuntimeError(f"no convergence at deflection {deflection:g}")
            forces.append(force * place.GetSolutionStepValue(Structural.LOAD_FACTOR))
        return forces

    def march(
        self,
        times: Sequence[float],
        size: float,
        factor: Callable[[float], float],
        nodes: Iterable[int],
        tolerance: float,
        bossak: float,
        solver: str,
    ) -> Any:
        """Displacements (times, nodes, 3) at times that are multiples of the step.

        Bossak's scheme: with 0 it is Newmark's average acceleration, below 0 it damps what the steps do not resolve.
        """
        settings = f'{{"damp_factor_m": {bossak}, "newmark_beta": 0.25, "projection_variables_list": []}}'
        self.newton(Structural.StructuralMechanicsBossakScheme(Kratos.Parameters(settings)), tolerance, 15, solver)
        wanted, nodes, rows, at = {round(t / size) for t in times}, list(nodes), [], 0.0
        # A first step of almost no length finds the accelerations under a force that acts at once.
        plan = [(0, 1e-4 * size)] if factor(0.0) else []
        plan += [(k, k * size) for k in range(1, round(times[-1] / size) + 1)]
        for k, time in plan:
            self.part.ProcessInfo[Kratos.DELTA_TIME] = time - at
            if not self.step(time, lambda t: self.factor(factor(t))):
                raise RuntimeError(f"no convergence at {time:g} s with steps of {size:g} s")
            at = time
            if k in wanted:
                rows.append([self.displacement(node) for node in nodes])
        return np.array(rows)
