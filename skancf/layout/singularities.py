"""Where what acts or holds leaves derivatives of a solution without a limit: said by loads and supports themselves."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from skancf.equality import by_value
from skancf.errors import InputError, finite, shown, vector
from skancf.functions import is_function
from skancf.layout.geometry import Geometry
from skancf.layout.places import NONE
from skancf.showing import short
from skancf.tolerances import SAME_POINT

KINDS = ("force", "moment", "position", "part", "normal", "tilt", "mirror")
"""Of singularities: see :class:`Singularity`."""
HOLDING = ("position", "part", "normal", "mirror")
"""Those of supports."""


@by_value
@dataclass(frozen=True, eq=False)
class Singularity:
    r"""What a load or support does that is not smooth: where, and by what.

    Loads and supports only say what acts. Which numbers have no limit then is known elsewhere, from the kind and the theory.

    Parameters
    ----------
    kinds : str or several of them
        ``"force"`` and ``"moment"``; of supports ``"position"``, held in all directions, ``"part"``, held in some directions
        only or elastically, ``"normal"``, the normal (director) held, ``"tilt"``, its tilt along an edge held, and
        ``"mirror"``, a plane of symmetry.
    points : (2,) or (2, n)
        Of the parameter plane: single points at which it acts, and ends of edges and lines along which it acts.
    words : str
        What it is, as messages say it: ``"a PointForce"``.
    vector : (3,), optional
        The force (N) or moment (N m) at each point: a single point at which one acts needs it.
    single : bool or (n,) bool array
        Which of the points are single ones.
    facets : (m,) int array
        Boundary facets of the mesh along which it acts.
    line : (2, 2) array, optional
        Columns: ends of a straight line of the parameter plane along which it acts.
    at_rest : bool
        Whether it acts in statics too, as a dashpot and an impulse do not.
    moves : bool
        Whether it is elsewhere at other times.

    Raises
    ------
    InputError
        For an unknown kind, invalid points, and a force or moment at a single point without its vector.

    Examples
    --------
    >>> sk.supports.Singularity("force", (0.5, 0.5), "a Screw", vector=(0.0, 0.0, -20.0)).points
    array([[0.5],
           [0.5]])
    """

    kinds: Any
    points: Any
    words: str
    vector: Any = None
    single: Any = True
    facets: np.ndarray = field(default_factory=lambda: NONE)
    line: np.ndarray | None = None
    at_rest: bool = True
    moves: bool = False

    __repr__ = short

    def __post_init__(self) -> None:
        kinds = (self.kinds,) if isinstance(self.kinds, str) else tuple(self.kinds)
        if not kinds or not set(kinds) <= set(KINDS):
            raise InputError(f"kinds = {shown(self.kinds)}: of a singularity choose among {list(KINDS)}")
        points = finite("points", self.points)
        points = points[:, None] if points.shape == (2,) else points
        if points.ndim != 2 or len(points) != 2:
            raise InputError(f"points of shape {points.shape}: give a point (x, y) of the parameter plane, or (2, n)")
        single = np.broadcast_to(np.asarray(self.single, dtype=bool), points.shape[1:])
        if single.any() and {"force", "moment"} & set(kinds) and self.vector is None:
            raise InputError(f"vector: missing; {self.words} at a single point needs its force or moment, three numbers")
        given = {"kinds": kinds, "points": points, "single": single}
        if self.vector is not None:
            given["vector"] = vector("vector", self.vector, 3)
        for name, value in given.items():
            object.__setattr__(self, name, value)

    @property
    def holds(self) -> bool:
        """Whether it is a support's."""
        return any(kind in HOLDING for kind in self.kinds)

    @property
    def alone(self) -> np.ndarray:
        """The single points, (2, n)."""
        return np.asarray(self.points[:, self.single])

    def pushes(self, kind: str) -> bool:
        """Whether it is a force, or a moment, that is not zero, at single points and in statics too."""
        return kind in self.kinds and self.at_rest and bool(self.single.any()) and bool(np.any(self.vector))


def at_place(
    geometry: Geometry, where: Any, kinds: str | Sequence[str], words: str, single: bool = True, at_rest: bool = True
) -> list[Singularity]:
    """What acts at a place: at the ends of its boundary edges, and at its nodes that are on none, single points.

    Adjacent nodes at which a function is true are a line, or a part of the surface, and no single points.
    Nothing where ``where`` is no place of this mesh, as one of a user's own class may mean something else by that name.
    """
    try:
        nodes, facets = geometry.points_and_facets(where)
    except InputError:
        return []
    mesh, corners = geometry.mesh, geometry.mesh.facets[:, facets]
    once = np.flatnonzero(np.bincount(corners.ravel(), minlength=mesh.p.shape[1]) == 1)
    others = np.setdiff1d(nodes, geometry.ties.node_of[corners])
    apart = np.full(len(others), single)
    if single and _has_function(where):
        apart &= ~beside_each_other(geometry, others)
    points = np.hstack([mesh.p[:, once], mesh.p[:, geometry.ties.representative[others]]])
    alone = np.concatenate([np.zeros(len(once), dtype=bool), apart])
    return [Singularity(kinds, points, words, single=alone, facets=np.asarray(facets), at_rest=at_rest)]


def places_of(found: Iterable[Singularity]) -> np.ndarray:
    """Single points (2, n) of the parameter plane at which something acts at rest too."""
    return np.hstack([np.empty((2, 0)), *[each.alone for each in found if each.at_rest]])


def nodes_at(geometry: Geometry, points: np.ndarray) -> np.ndarray:
    """Nodes at points (2, n) of the parameter plane, each once, hanging ones and points of no node not counted."""
    places, (wide, high) = geometry.mesh.p, SAME_POINT * np.ptp(geometry.mesh.p, axis=1)
    order = np.argsort(places[0])
    first, last = (np.searchsorted(places[0, order], points[0] + side * wide) for side in (-1, 1))
    near = (order[a:b] for a, b in zip(first, last, strict=True))
    here = [nodes[np.abs(places[1, nodes] - y) < high] for nodes, y in zip(near, points[1], strict=True)]
    found = np.unique(geometry.ties.node_of[np.concatenate([NONE, *here])])
    return np.asarray(found[found >= 0])


def beside_each_other(geometry: Geometry, nodes: np.ndarray) -> np.ndarray:
    """Which nodes share an edge of the mesh with another one of them, (n,)."""
    node_of, hanging = geometry.ties.node_of, geometry.hanging
    among = np.isin(node_of, nodes)
    among[hanging.nodes] = among[hanging.ends].all(axis=0)  # held where the ends of their edge are
    ends = geometry.mesh.facets
    ends = node_of[ends[:, among[ends].all(axis=0)]]
    return np.isin(nodes, ends[:, ends[0] != ends[1]])


def _has_function(where: Any) -> bool:
    """Whether a place is found anew by a function on each mesh, or a part of it."""
    return is_function(where) or (isinstance(where, list | tuple) and any(_has_function(part) for part in where))
