"""What is prescribed along an equilibrium path instead of the load factor, and where a path ends."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from skancf.arguments import instance, plain, whole
from skancf.equality import by_value
from skancf.errors import InputError, number, positive, unit_vector, vector
from skancf.linear import BlockMatrix
from skancf.showing import short
from skancf.statics.stopping import Constraint
from skancf.system.probe import probe
from skancf.tolerances import ONE_PLACE


class Measure(Protocol):
    """A control on a given system: measures how far the path went."""

    def row(self, direction: np.ndarray) -> np.ndarray:
        """The linear form, of value one on ``direction``, that a step prescribes."""

    def unit(self, along: np.ndarray, last: np.ndarray | None) -> float:
        """Factor that gives the tangent of the path unit length and sends it forward, given the last increment."""

    def left(self, q: np.ndarray) -> float:
        """How far it is to the end; infinite where the control has none."""


@dataclass(frozen=True)
class StepLength:
    """Steps that follow the number of iterations.

    Parameters
    ----------
    smallest, largest : float
        Limits of a step, relative to the first one. A step that must become smaller ends the path.
    easy : int
        Iterations for which a step keeps its length; it is multiplied by sqrt(easy / iterations), at most by ``growth``.
    growth : float
    cut : float
        Divides a failed step.

    Examples
    --------
    >>> quarter = sk.CylinderSector(radius=2540.0, length=254.0, angle=0.1, start=np.pi / 2 - 0.1)
    >>> crown = (254.0, np.pi / 2)
    >>> roof = sk.Problem(
    ...     quarter, 12.7, sk.Isotropic(young=3102.75, poisson=0.3, density=1.2e-9),
    ...     supports=[sk.Pin("start"), sk.Symmetry("end"), sk.Symmetry("right")],
    ...     loads=[sk.PointForce(crown, (0.0, 0.0, -750.0))],
    ... )
    >>> system = roof.on(sk.meshes.uniform(quarter, 4, 4), "kirchhoff")
    >>> path = sk.trace(system, sk.ArcLength(steps=sk.StepLength(growth=2.0)), until=0.3, progress=False)
    >>> print(path.load_factors[-1])
    0.3
    """

    smallest: float = 1e-4
    largest: float = 50.0
    easy: int = 5
    growth: float = 1.5
    cut: float = 2.0

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        whole("easy", self.easy, floats=True)
        for name in ("smallest", "largest"):
            positive(name, getattr(self, name))
        if not 0 < self.smallest <= 1 <= self.largest:
            raise InputError(
                f"smallest = {self.smallest}, largest = {self.largest}: both are relative to the first step, "
                "so give smallest <= 1 <= largest"
            )
        for name in ("growth", "cut"):
            if not number(name, getattr(self, name)) > 1:
                raise InputError(f"{name} = {getattr(self, name)}: give a number greater than one")

    def after(self, step: float, iterations: int) -> float:
        """Length of the next step, in units of the first one."""
        factor = np.clip(np.sqrt(self.easy / max(1, iterations)), 1 / self.cut, self.growth)
        return float(min(self.largest, step * factor))


@by_value
@dataclass(frozen=True)
class ArcLength:
    r"""Steps of given length in the displacements; the load factor follows.

    The length of an increment is :math:`\sqrt{\Delta q^T M \Delta q}` with the mass matrix, the root mean square
    displacement of the body up to a factor. It adds positions and slopes in right units, does not depend on the mesh, and
    is the same in every frame. The load factor does not enter (a cylinder, not a sphere): it has another unit, and where a
    structure is soft it would make steps long. A step prescribes the length's projection on the tangent of the path
    (Riks, 1979).

    Parameters
    ----------
    first : float
        Length of the first step, as the load factor that would move the structure so far if it stayed as stiff as it is
        at the start; negative to go against the load.
    steps : StepLength

    References
    ----------
    E. Riks, An incremental approach to the solution of snapping and buckling problems, Int. J. Solids Struct. 15 (1979).

    Examples
    --------
    >>> quarter = sk.CylinderSector(radius=2540.0, length=254.0, angle=0.1, start=np.pi / 2 - 0.1)
    >>> crown = (254.0, np.pi / 2)
    >>> roof = sk.Problem(
    ...     quarter, 12.7, sk.Isotropic(young=3102.75, poisson=0.3, density=1.2e-9),
    ...     supports=[sk.Pin("start"), sk.Symmetry("end"), sk.Symmetry("right")],
    ...     loads=[sk.PointForce(crown, (0.0, 0.0, -750.0))],
    ... )
    >>> system = roof.on(sk.meshes.uniform(quarter, 4, 4), "kirchhoff")
    >>> path = sk.trace(system, sk.ArcLength(first=0.1), until=0.3, progress=False)
    >>> print(path.load_factors[-1])
    0.3
    """

    first: float = 0.05
    steps: StepLength = StepLength()

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        if number("first", self.first) == 0:
            raise InputError("first = 0: give the load factor of the first step")
        instance("steps", self.steps, StepLength, "a StepLength")

    def on(self, system: Any, q: np.ndarray) -> Measure:
        return _Arc(system.mass, float(np.sign(self.first)))

    def first_length(self, measure: Measure, along: np.ndarray, q: np.ndarray) -> float:
        """Length of the first step, ``along`` being the displacement for a unit of the load factor."""
        return abs(self.first / measure.unit(along, None))


@by_value
@dataclass(frozen=True)
class DisplacementControl:
    """Steps of the displacement of a point; the load factor follows.

    It passes limit points of the load, and ends where that displacement turns back.

    Parameters
    ----------
    at : (2,)
        Point of the parameter plane.
    direction : (3,)
        Direction in space, of any length.
    to : float
        Displacement in that direction at which the path ends (m).
    first : float
        First step, as a part of the whole way.
    steps : StepLength

    Examples
    --------
    >>> quarter = sk.CylinderSector(radius=2540.0, length=254.0, angle=0.1, start=np.pi / 2 - 0.1)
    >>> crown = (254.0, np.pi / 2)
    >>> roof = sk.Problem(
    ...     quarter, 12.7, sk.Isotropic(young=3102.75, poisson=0.3, density=1.2e-9),
    ...     supports=[sk.Pin("start"), sk.Symmetry("end"), sk.Symmetry("right")],
    ...     loads=[sk.PointForce(crown, (0.0, 0.0, -750.0))],
    ... )
    >>> system = roof.on(sk.meshes.uniform(quarter, 4, 4), "kirchhoff")
    >>> press = sk.DisplacementControl(crown, direction=(0.0, 0.0, -1.0), to=15.0)
    >>> path = sk.trace(system, press, progress=False)
    >>> print(f"{-path.displacement(crown)[-1, 2]:.2f} mm at {path.load_factors[-1]:.2f} of the load")
    15.00 mm at 0.51 of the load
    """

    at: Sequence[float]
    direction: Sequence[float]
    to: float
    first: float = 0.05
    steps: StepLength = StepLength()

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        number("to", self.to)
        _check_place(self.at, self.direction)
        if not 0 < number("first", self.first) <= 1:
            raise InputError(f"first = {self.first}: a part of the whole way, more than 0 and at most 1")
        instance("steps", self.steps, StepLength, "a StepLength")

    def on(self, system: Any, q: np.ndarray) -> Measure:
        row = displacement_row(system, self.at, self.direction)
        way = self.to - float(row @ (q - system.undeformed))
        if way == 0:
            raise InputError(f"to = {self.to}: the point is there already; give another displacement")
        sign = float(np.sign(way))
        return _Displacement(sign * row, sign * float(row @ system.undeformed + self.to))

    def first_length(self, measure: Measure, along: np.ndarray, q: np.ndarray) -> float:
        return self.first * measure.left(q)


@by_value
@dataclass(frozen=True)
class DisplacementReached:
    """A path ends where the displacement of a point in a direction reaches a value (m).

    Parameters
    ----------
    at : (2,)
    direction : (3,)
    value : float

    Examples
    --------
    >>> quarter = sk.CylinderSector(radius=2540.0, length=254.0, angle=0.1, start=np.pi / 2 - 0.1)
    >>> crown = (254.0, np.pi / 2)
    >>> roof = sk.Problem(
    ...     quarter, 12.7, sk.Isotropic(young=3102.75, poisson=0.3, density=1.2e-9),
    ...     supports=[sk.Pin("start"), sk.Symmetry("end"), sk.Symmetry("right")],
    ...     loads=[sk.PointForce(crown, (0.0, 0.0, -750.0))],
    ... )
    >>> system = roof.on(sk.meshes.uniform(quarter, 4, 4), "kirchhoff")
    >>> end = sk.DisplacementReached(crown, direction=(0.0, 0.0, -1.0), value=15.0)
    >>> path = sk.trace(system, until=end, progress=False)
    >>> print(f"{-path.displacement(crown)[-1, 2]:.2f} mm")
    15.00 mm
    """

    at: Sequence[float]
    direction: Sequence[float]
    value: float

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        number("value", self.value)
        _check_place(self.at, self.direction)


def _check_place(at: Any, direction: Any) -> None:
    vector("at", at, 2)
    unit_vector("direction", direction, "give the direction in which the displacement counts")


def end_of_path(system: Any, until: "float | DisplacementReached", origin: np.ndarray) -> Constraint:
    """The equation that holds at the end of a path."""
    if isinstance(until, DisplacementReached):
        row = displacement_row(system, until.at, until.direction)
        return Constraint(row, 0.0, until.value + float(row @ system.undeformed), origin)
    return Constraint(np.zeros_like(origin), 1.0, number("until", until), origin)


def displacement_row(system: Any, at: Any, direction: Any) -> np.ndarray:
    """The linear form that gives the position of a point along a direction: row . q, shape (n_dofs,)."""
    return np.outer(probe(system, at).toarray()[0], unit_vector("direction", direction)).ravel()


class _Arc:
    def __init__(self, mass: BlockMatrix, sign: float):
        self.mass, self.sign = mass, sign

    def row(self, direction: np.ndarray) -> np.ndarray:
        return self.mass @ direction

    def unit(self, along: np.ndarray, last: np.ndarray | None) -> float:
        row = self.mass @ along
        if not row @ along:
            raise InputError("no path: the loads act on what supports hold, and move nothing; give a load that does work")
        sign = self.sign if last is None else np.sign(row @ last) or 1.0
        return float(sign / np.sqrt(row @ along))

    def left(self, q: np.ndarray) -> float:
        return np.inf


class _Displacement:
    def __init__(self, form: np.ndarray, end: float):
        self.form, self.end = form, end

    def row(self, direction: np.ndarray) -> np.ndarray:
        return self.form

    def unit(self, along: np.ndarray, last: np.ndarray | None) -> float:
        moved = float(self.form @ along)
        if last is None and abs(moved) <= ONE_PLACE * np.abs(self.form).sum() * np.abs(along).max():
            raise InputError(
                "DisplacementControl: the displacement of that point in that direction does not move with the load at the "
                "start; control one that does, or take ArcLength()"
            )
        return 1.0 / moved if moved else np.inf

    def left(self, q: np.ndarray) -> float:
        return self.end - float(self.form @ q)
