r"""Two edges that stay together and may turn against each other.

The gap is averaged over segments of the edge against Legendre polynomials of degree 0 and 1, and vanishes at both ends,

.. math:: \int_{s_j} \psi_k \, (r_A - r_B) \, ds = 0, \qquad r_A = r_B \text{ at the ends},

so that meshes of the two sides need not match; where they do, the gap vanishes all along. The multipliers make the force per
length :math:`\sum_k \lambda_k \psi_k(s)` that side B exerts on side A, and forces at the ends.
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import scipy.sparse as sp

from skancf.arguments import plain, text
from skancf.conditions.condition import Condition, Joint
from skancf.conditions.edges import Chain, segments, side_by_side
from skancf.conditions.rows import cells_of, extent_of, in_space
from skancf.elements.quad_ancf import gauss
from skancf.equality import by_value
from skancf.errors import InputError, shown, warn
from skancf.functions import Noted, is_function
from skancf.history import Case
from skancf.kernels.constants import AXES
from skancf.layout.geometry import Geometry
from skancf.layout.layout import Layout
from skancf.showing import short
from skancf.tolerances import ONE_PLACE, SEVEN_DIGITS

POINTS = 4
"""Gauss points between two knots of either edge."""


@by_value
@dataclass(frozen=True)
class Hinge(Joint):
    """Two edges of the surface that lie on each other stay together there, and turn freely.

    So a sheet that is bent until two of its sides meet becomes a tube with a hinge along it. Elements of the two edges need
    not match. At the ends positions are equal, too, for plates exert forces at corners.

    Parameters
    ----------
    first, second
        Places of the boundary, each one run of edges: names such as ``"start"`` and ``"end"``, or functions of (x, y).
    name : str
        By which results and messages know it.

    Raises
    ------
    InputError
        On a mesh: for places that are no single run of edges, and for edges that do not meet undeformed, with the distance.

    Warns
    -----
    OutOfDepth
        On a mesh, where the surface leaves a gap of up to a hundredth of the edge, which is closed.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> slit = sk.CylinderSector(radius=0.5, length=0.2, angle=2 * np.pi)
    >>> ring = sk.Problem(slit, 0.005, steel, [sk.Pin([(0.0, np.pi / 2)])], conditions=[sk.Hinge("start", "end")])
    >>> system = ring.on(sk.meshes.uniform(slit, 2, 12), "kirchhoff")
    >>> print(system.conditions.n, "multipliers")
    18 multipliers
    """

    first: Any
    second: Any
    name: str = "hinge"

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        text("name", self.name)
        for name in ("first", "second"):
            where = getattr(self, name)
            if not (isinstance(where, str) or is_function(where)):
                raise InputError(f"{name} = {shown(where)}: give the name of an edge, or a function of (x, y) that is true "
                                 "on it")  # fmt: skip

    @property
    def wheres(self) -> dict[str, Any]:
        """The two edges."""
        return {"first": self.first, "second": self.second}

    def on(self, shell: Any, layout: Layout) -> "Gap":
        seam = Seam.of(shell.geometry, self)
        rows = shell.in_layout(seam.weights)
        return Gap(self.name, sp.csr_matrix(rows), seam, extent_of(layout))

    def gap(self, geometry: Geometry) -> sp.csr_matrix:
        """That of its edges: interpolated by two meshes, they miss each other a little."""
        seam = Seam.of(geometry, self)
        if seam.apart > SEVEN_DIGITS * seam.ends[-1]:
            warn(f"{self.name}: edges {shown(self.first)} and {shown(self.second)} of the surface miss each other by up to "
                 f"{seam.apart:.4g} m, and nodes there are moved to close the gap, without stress; let the surface close by "
                 "itself, as by an angle of 2 pi")  # fmt: skip
        return seam.weights


@dataclass(frozen=True, eq=False)
class Seam:
    """Where two edges of a mesh are joined.

    Attributes
    ----------
    ends : (n + 1,) array
        Arc length at the ends of the segments (m).
    weights : (2 n + 2, 4 n_nodes) sparse array
        Of nodal vectors, for the gap: averages of degree 0 and 1 on each segment, and at both ends of the edge.
    sizes : (2 n + 2,) array
        The same of a gap of one: by what a row grows with the length of its segment.
    apart : float
        By how much the surface misses itself there at most (m).
    """

    ends: np.ndarray
    weights: sp.csr_matrix
    sizes: np.ndarray
    apart: float

    __repr__ = short

    @classmethod
    def of(cls, geometry: Geometry, hinge: Hinge) -> "Seam":
        names = (f"{hinge.name}: edges {shown(hinge.first)}", shown(hinge.second))
        first, other = (_chain(geometry, name, where) for name, where in hinge.wheres.items())
        if np.isin(first.facets, other.facets).any():
            raise InputError(f"{hinge.name}: {shown(hinge.first)} and {shown(hinge.second)} have edges in common; name two "
                             "different edges")  # fmt: skip
        second, apart = side_by_side(first, other, names)
        ends, knots = segments(first.knots, second.knots)
        points, weights = gauss(POINTS)
        s = (knots[:-1, None] + np.diff(knots)[:, None] * points).ravel()
        ds = (np.diff(knots)[:, None] * weights).ravel()
        tests = legendre(s, ends)
        gap = tests.multiply(ds) @ _gap_rows(geometry, first, second, s)
        sizes = np.asarray(abs(tests) @ ds)
        tips = np.empty(0) if first.closed else np.array([0.0, ends[-1]])
        rows = sp.vstack([gap, _gap_rows(geometry, first, second, tips)], format="csr")
        rows.eliminate_zeros()
        return cls(ends, rows, np.concatenate([sizes, np.ones(len(tips))]), apart)


def _chain(geometry: Geometry, name: str, where: Any) -> Chain:
    with Noted(name):
        return Chain.of(geometry, where)


def legendre(s: np.ndarray, ends: np.ndarray) -> sp.csr_matrix:
    """Values (2 n, m) at arc lengths (m,) of 1 and of x from -1 to 1 on each of n segments."""
    n = len(ends) - 1
    which = np.clip(np.searchsorted(ends, s, side="right") - 1, 0, n - 1)
    x = 2 * (s - ends[which]) / np.diff(ends)[which] - 1
    column = np.arange(len(s))
    return sp.csr_matrix((np.concatenate([np.ones(len(s)), x]), (np.concatenate([2 * which, 2 * which + 1]),
                         np.tile(column, 2))), shape=(2 * n, len(s)))  # fmt: skip


def _gap_rows(geometry: Geometry, first: Chain, second: Chain, s: np.ndarray) -> sp.csr_matrix:
    """Weights (n, 4 n_nodes) that make the gap at arc lengths (n,) of the first edge."""
    scale = second.knots[-1] / first.knots[-1]
    return geometry.position_rows(*first.local(*first.at(s))) - geometry.position_rows(*second.local(*second.at(s * scale)))


class Gap(Condition):
    """The condition of a :class:`Hinge`, on weights (m, 4 n_blocks) of the gap."""

    def __init__(self, name: str, weights: sp.csr_matrix, seam: Seam, extent: float) -> None:
        self.name, self.n, self.seam = name, AXES * weights.shape[0], seam
        self.scales = np.repeat(seam.sizes, AXES) * extent
        self._cells, self._gradient = cells_of(weights), in_space(weights)

    def couples(self) -> np.ndarray:
        return self._cells

    def value(self, q: np.ndarray, case: Case) -> np.ndarray:
        return np.asarray(self._gradient @ q)

    def gradient(self, q: np.ndarray) -> sp.csr_matrix:
        return self._gradient

    def rows(self) -> list[str]:
        ends = self.seam.ends
        of = [f"gap from {a:.4g} to {b:.4g} m" for a, b in pairwise(ends) for _ in (0, 1)]
        of += ["gap at its begin", "gap at its end"][: self.n // AXES - len(of)]
        return [f"{each}, {axis}" for each in of for axis in "xyz"]

    def carried(self, multipliers: np.ndarray, onto: Condition) -> np.ndarray:
        """The same force per length: on each segment of the other mesh its best straight line, by least squares."""
        assert isinstance(onto, Gap)
        here, there = self.seam.ends, onto.seam.ends * (self.seam.ends[-1] / onto.seam.ends[-1])
        knots = np.unique(np.concatenate([here, there]))
        points, weights = gauss(2)
        s = (knots[:-1, None] + np.diff(knots)[:, None] * points).ravel()
        ds = (np.diff(knots)[:, None] * weights).ravel()
        of_segments, at_ends = np.split(multipliers.reshape(-1, AXES), [2 * (len(here) - 1)])
        tests = legendre(s, there).multiply(ds)
        norms = np.outer(np.diff(there), [1.0, 1.0 / 3.0]).ravel()  # of Legendre polynomials
        projected = (tests @ (legendre(s, here).T @ of_segments)) / norms[:, None]
        return np.concatenate([projected, at_ends]).ravel()

    def resultant(self, direction: np.ndarray | None) -> np.ndarray:
        """As :attr:`HingeForce.total`."""
        if direction is None:
            raise InputError(f"condition {self.name!r}: the force of a hinge has three components; give a direction")
        weights, n = np.zeros(self.n // AXES), len(self.seam.ends) - 1
        weights[: 2 * n : 2], weights[2 * n :] = np.diff(self.seam.ends), 1.0
        return -np.outer(weights, direction).ravel()

    def forces(self, multipliers: np.ndarray) -> "HingeForce":
        return HingeForce(self.seam.ends, multipliers.reshape(-1, AXES))


@by_value
@dataclass(frozen=True, eq=False)
class HingeForce:
    """What the second edge of a hinge exerts on the first.

    Attributes
    ----------
    ends : (n + 1,) array
        Arc length at the ends of the segments (m).
    multipliers : (2 n + 2, 3) array
        Of the averages of degree 0 and 1 on each segment (N/m), and at both ends (N); with no ends where the edge is closed.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> slit = sk.CylinderSector(radius=0.5, length=0.2, angle=2 * np.pi)
    >>> ring = sk.Problem(
    ...     slit, 0.005, steel, supports=[sk.Pin([(0.0, np.pi / 2), (0.2, np.pi / 2)]), sk.Pin([(0.0, np.pi)])],
    ...     loads=[sk.EdgeLoad("end", (0.0, 0.0, 10.0))], conditions=[sk.Hinge("start", "end")],
    ... )
    >>> force = sk.solve_linear(ring.on(sk.meshes.uniform(slit, 2, 12), "kirchhoff")).conditions["hinge"]
    >>> print(f"{force.total[2]:.2f} N")
    1.68 N
    """

    ends: np.ndarray
    multipliers: np.ndarray

    __repr__ = short

    def per_length(self, s: Any) -> np.ndarray:
        """Force per length (N/m) at arc lengths s of the first edge, () or (m,): (3,) or (m, 3). They count from its end
        with the smaller x, or y where both have one x."""
        places = np.atleast_1d(np.asarray(s, float))
        slack = ONE_PLACE * self.ends[-1]
        if not ((places >= -slack) & (places <= self.ends[-1] + slack)).all():
            raise InputError(f"s = {shown(s)}: the hinge goes from 0 to {self.ends[-1]:.6g} m")
        found = -legendre(places, self.ends).T @ self.multipliers[: 2 * (len(self.ends) - 1)]
        return np.asarray(found[0] if np.ndim(s) == 0 else found)

    @property
    def at_ends(self) -> np.ndarray:
        """Forces at both ends of the edge, (2, 3) (N); (0, 3) where it is closed."""
        return -self.multipliers[2 * (len(self.ends) - 1) :]

    @property
    def total(self) -> np.ndarray:
        """The whole force, (3,) (N)."""
        means = self.multipliers[: 2 * (len(self.ends) - 1) : 2]
        return np.asarray(self.at_ends.sum(axis=0) - np.diff(self.ends) @ means)
