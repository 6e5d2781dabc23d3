"""Impulses: forces so short that only what they do to the momentum counts."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from skancf.arguments import plain
from skancf.equality import by_value
from skancf.errors import number, vector
from skancf.functions import is_function
from skancf.history import Case
from skancf.layout.singularities import Singularity, at_place
from skancf.loads.acting import Acting, at_points
from skancf.loads.edge import on_edges
from skancf.showing import short
from skancf.terms.protocols import Assembly


@by_value
@dataclass(frozen=True)
class Impulse:
    r"""An impulse (N s) at a point of the parameter plane: at its time velocities jump, positions do not.

    .. math:: M (v^+ - v^-) = \int f \, dt

    It is no force at any time: statics does not see it, and to dynamics it adds a jump. A force that lasts is a
    :class:`PointForce` with a :class:`Pulse`.

    Parameters
    ----------
    at : (2,)
        Point of the parameter plane.
    impulse : (3,)
        Force times time.
    time : float
        When it strikes (s).

    Raises
    ------
    InputError
        For entries that are not finite or of another number; on a mesh, for a point outside the surface.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> blow = sk.Impulse((1.0, 0.05), (0.0, 0.0, -0.1))
    >>> hit = sk.Problem(sk.Rectangle(1.0, 0.1), 0.01, steel, supports=[sk.Clamp("left")], loads=[blow])
    >>> motion = sk.simulate(hit.on(sk.meshes.uniform(hit.surface, 4, 1), "kirchhoff"), 2e-3, rtol=1e-2, progress=False)
    >>> print(motion.status.value)
    finished
    """

    at: tuple[float, float]
    impulse: tuple[float, float, float]
    time: float = 0.0

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        vector("at", self.at, 2)
        vector("impulse", self.impulse, 3)
        number("time", self.time)

    def on(self, assembly: Assembly) -> "Blow":
        geometry = assembly.geometry
        element, local = geometry.locate(self.at)
        nodal = at_points([element], local[None], np.array([self.impulse], float)).nodal(geometry)
        at = geometry.within(np.asarray(self.at, float)[:, None])
        return Blow(nodal, float(self.time), [Singularity("force", at, "an Impulse", self.impulse, at_rest=False)])


@by_value
@dataclass(frozen=True)
class EdgeImpulse:
    """An impulse per undeformed length (N s/m) along boundary edges; in all else as :class:`Impulse`.

    Parameters
    ----------
    where
        Place, as for :class:`EdgeLoad`.
    impulse : (3,) or callable
        Constant, or a function of the parameters (x, y) that returns (3, ...).
    time : float
        When it strikes (s).

    Raises
    ------
    InputError
        For entries that are not finite or of another number; on a mesh, for a place without an edge.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> blow = sk.EdgeImpulse("right", (0.0, 0.0, -1.0))
    >>> hit = sk.Problem(sk.Rectangle(1.0, 0.1), 0.01, steel, supports=[sk.Clamp("left")], loads=[blow])
    >>> motion = sk.simulate(hit.on(sk.meshes.uniform(hit.surface, 4, 1), "kirchhoff"), 2e-3, rtol=1e-2, progress=False)
    >>> print(motion.status.value)
    finished
    """

    where: Any
    impulse: Any
    time: float = 0.0

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        if not is_function(self.impulse):
            vector("impulse", self.impulse, 3)
        number("time", self.time)

    def on(self, assembly: Assembly) -> "Blow":
        spread = on_edges(assembly.geometry, self.where, self.impulse, "impulse")
        ends = at_place(assembly.geometry, self.where, "force", "an EdgeImpulse", single=False, at_rest=False)
        return Blow(spread.nodal(assembly.geometry), float(self.time), ends)


class Blow(Acting):
    """An impulse (n_nodes, 4, 3) at a time."""

    def __init__(self, nodal: np.ndarray, time: float, singular: list[Singularity]):
        self.nodal, self.time, self.singular = nodal, time, singular

    def singularities(self, case: Case) -> list[Singularity]:
        return self.singular

    def impulse(self, q: np.ndarray) -> tuple[float, np.ndarray]:
        return self.time, self.nodal
