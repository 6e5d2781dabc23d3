"""Shells of quadrilaterals in OpenSees."""

from typing import Any

from benchmarks.programs.program import Outcome

ELEMENTS = {  # for large displacements, for small ones
    "thin": (("ShellNLDKGQ",), ("ShellDKGQ",)),
    "thick": (("ASDShellQ4", "-corotational"), ("ASDShellQ4",)),
}


class Shell:
    """A model of nx x ny quadrilaterals over a surface given by the positions of its nodes."""

    def __init__(
        self, points: Any, data: Any, variant: str, linear: bool = False, density: float = 0.0, keep: Any = None
    ) -> None:
        import numpy as np
        import openseespy.opensees as ops

        self.ops, self.held = ops, 0
        ops.model("basic", "-ndm", 3, "-ndf", 6)
        self.tags = np.arange(1, points[..., 0].size + 1).reshape(points.shape[:2])
        corners = (self.tags[:-1, :-1], self.tags[1:, :-1], self.tags[1:, 1:], self.tags[:-1, 1:])
        self.elements = np.stack(corners, -1).reshape(-1, 4)
        if keep is not None:
            self.elements = self.elements[keep.ravel()]
        used = np.unique(self.elements)
        for tag, point in zip(used.tolist(), points.reshape(-1, 3)[used - 1].tolist(), strict=True):
            ops.node(tag, *point)
        self.nodes = used.size
        ops.section("ElasticMembranePlateSection", 1, data["young"], data["poisson"], data["thickness"], density)
        name, *options = ELEMENTS[variant][linear]
        for tag, nodes in enumerate(self.elements.tolist(), 1):
            ops.element(name, tag, *nodes, 1, *options)

    def fix(self, tags: Any, *flags: int) -> None:
        """Every node once."""
        for tag in tags.ravel().tolist():
            self.ops.fix(tag, *flags)
            self.held += sum(flags)

    def load(self, loads: dict[int, tuple[float, ...]], *series: Any) -> None:
        self.ops.timeSeries(*(series or ("Linear", 1)))
        self.ops.pattern("Plain", 1, 1)
        for tag, load in loads.items():
            self.ops.load(tag, *load)

    def solver(self, integrator: tuple[Any, ...], analysis: str, *test: Any) -> None:
        ops = self.ops
        ops.constraints("Plain")
        ops.numberer("RCM")
        ops.system("UmfPack")
        ops.test(*test)
        ops.algorithm("Newton")
        ops.integrator(*integrator)
        ops.analysis(analysis)

    def at(self, tag: Any, dof: int) -> float:
        return float(self.ops.nodeDisp(int(tag), dof))

    def step(self, *arguments: float) -> int:
        """One step; its iterations."""
        if self.ops.analyze(1, *arguments):
            raise RuntimeError(f"no convergence at load factor or time {self.ops.getTime():g}")
        return int(self.ops.testIter())

    def outcome(self, values: dict[str, Any], note: str = "") -> Outcome:
        return Outcome(values, 6 * self.nodes - self.held, note)


def flat(nx: int, ny: int, lx: float, ly: float) -> Any:
    import numpy as np

    points = np.zeros((nx + 1, ny + 1, 3))
    points[..., 0], points[..., 1] = np.linspace(0.0, lx, nx + 1)[:, None], np.linspace(0.0, ly, ny + 1)
    return points
