"""What the adaptive loop found: every mesh, the number with its error bar, and why it stopped."""

from dataclasses import dataclass

import numpy as np

from skancf.adaptive.theory_error import TheoryError
from skancf.checks import Check
from skancf.equality import by_value
from skancf.errors import warn
from skancf.meshes import MeshQuadTree
from skancf.showing import in_a_notebook, in_brackets, looked_at, short, summary
from skancf.solution import Solution
from skancf.solving import Status
from skancf.tabular import Column, Tabular


@by_value
@dataclass(frozen=True)
class Level:
    """One mesh of the loop.

    Attributes
    ----------
    mesh : MeshQuadTree
    n_elements, n_dofs, n_hanging : int
        ``n_dofs`` counts nodal coordinates, held ones included.
    value : float
        Of the quantity.
    error : float
        Estimate of limit minus value.
    bar : float
        Size of the error, as :attr:`AdaptiveResult.error_bar` is for the best mesh.
    indicators : (n_elements,) array
        Those by which elements were marked.
    iterations : int
        Newton iterations.
    restarted : bool
        The state of the mesh before led nowhere here, and the load was applied anew.
    rejected : bool
        Merging elements made the estimate worse; the level was taken back.
    coarsened : int
        Elements that are larger here than on the mesh before.
    note : str
        What the solve met on its way here, such as a state that was not stable.
    nested : bool
        The error is from the values on this and the two meshes before, each of which has every element of the last
        quartered, without a dual weight; indicators are the parts that are left of those before.
    seconds : dict
        For ``assemble``, ``solve``, ``estimate`` and ``mark`` (the next mesh).

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> for level in sk.adapt(plate, sk.StrainEnergy(), rtol=1e-2, linear=True).levels:
    ...     print(level.n_elements, f"{level.value:.4f} J")
    16 0.0100 J
    52 0.0101 J
    """

    mesh: MeshQuadTree
    n_dofs: int
    value: float
    error: float
    indicators: np.ndarray
    iterations: int
    restarted: bool
    coarsened: int
    seconds: dict[str, float]
    rejected: bool = False
    note: str = ""
    nested: bool = False
    bar: float = float("nan")

    __repr__ = short

    @property
    def n_elements(self) -> int:
        return int(self.mesh.nelements)

    @property
    def n_hanging(self) -> int:
        return len(self.mesh.hanging)

    @property
    def total_seconds(self) -> float:
        """Of the level."""
        return sum(self.seconds.values())


@by_value
@dataclass(frozen=True)
class AdaptiveResult(Tabular):
    """Outcome of :func:`adapt`; as a table its meshes, see :class:`~skancf.tabular.Tabular`.

    Attributes
    ----------
    value : float
        The quantity on the best mesh.
    error_bar : float
        Size of the estimated distance to its limit, and of rounding.
    corrected : float
        The value with the estimate added: usually nearer to the limit, but without an error bar of its own.
    solution : Solution
        The state on that mesh (of a frequency or buckling load its mode).
    levels : tuple of Level
        Every mesh, rejected ones too.
    status : Status
    message : str
        Why it stopped, if the accuracy was not reached; and what solves met on their way.
    unit : str
        Of a problem in SI units.
    checks : tuple of Check
        Of the state on that mesh.
    theory_error : TheoryError or None
        By how much transverse shear, which theory `kirchhoff` leaves out, would change the value: no part of the error bar,
        which is that of the mesh. None of an analysis of the user's own.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> result = sk.adapt(plate, sk.Displacement(at=(0.5, 0.5)), rtol=1e-2, linear=True)
    >>> print(result.ok, result.unit, len(result.levels) > 0)
    True m True
    """

    value: float
    error_bar: float
    corrected: float
    solution: Solution
    levels: tuple[Level, ...]
    status: Status
    message: str
    unit: str
    checks: tuple[Check, ...] = ()
    theory_error: TheoryError | None = None

    __repr__, _repr_html_, view = in_brackets, in_a_notebook, looked_at

    def _table(self) -> dict[str, Column]:
        units = {"n_elements": "", "n_dofs": "", "n_hanging": "", "value": self.unit, "error": self.unit, "bar": self.unit,
                 "iterations": "", "total_seconds": "s", "rejected": "", "restarted": "", "coarsened": "", "nested": "",
                 "note": ""}  # fmt: skip
        return {name: ([getattr(level, name) for level in self.levels], unit) for name, unit in units.items()}

    @property
    def ok(self) -> bool:
        """Whether the value is as accurate as asked."""
        return self.status.ok

    @property
    def is_zero(self) -> bool:
        """Is the value no larger than its error bar? Then the number may be zero, and the bar tells how near to it it is.

        That is as accurate as asked where the bar is within ``atol``, or within ``rtol`` times the sizes of contributions
        that cancel in it: the :attr:`~skancf.adaptive.Estimate.scale` of the estimate.
        """
        return abs(self.value) <= self.error_bar

    @summary
    def __str__(self) -> str:
        n, zero = self.solution.system.n_dofs, ", and zero lies within it" if self.is_zero else ""
        said = f"{self.value:.8g} +- {self.error_bar:.2g} {self.unit}".rstrip() + self._left_out()
        return f"{said} ({n} nodal coordinates; {self.status.value}{zero})"

    def _as_solution(self) -> Solution:
        if not self.ok:
            warn(f"this state is not as accurate as asked: {self.message or self.status.value}")
        return self.solution

    def _left_out(self) -> str:
        """What the theory leaves out, in words."""
        error = self.theory_error
        if error is None or error.value == 0:
            return ""
        if np.isnan(error.value):
            return " (mesh), and what the theory leaves out cannot be told"
        return f" (mesh), and the theory leaves out about {error.value:+.2g} {self.unit}".rstrip()

    def table(self) -> str:
        """One line for each mesh."""
        lines = [f"{'elements':>9}{'dofs':>9}{'hanging':>9}{'value':>16}{'error':>11}{'iterations':>12}{'seconds':>9}"]
        for level in self.levels:
            note = (" rejected" if level.rejected else "") + (" restarted" if level.restarted else "")
            lines.append(
                f"{level.n_elements:>9}{level.n_dofs:>9}{level.n_hanging:>9}{level.value:>16.8g}{level.error:>11.1e}"
                f"{level.iterations:>12}{level.total_seconds:>9.2f}{note}"
            )
        return "\n".join(lines)
