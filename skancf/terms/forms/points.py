"""Where a form is integrated: points of elements or of edges, and the way between the unknowns and the jets there."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from skancf.elements.quad_ancf import square_quadrature
from skancf.elements.reference import CORNERS
from skancf.errors import InputError
from skancf.functions import is_function, true_at
from skancf.history import Case
from skancf.kernels.constants import AXES, FUNCTIONS
from skancf.layout.geometry import Geometry
from skancf.showing import short
from skancf.terms.forms.fields import THICK, THIN, VELOCITY, Fields, Jet
from skancf.theories.full.theory import D1, D2, R1, R2, D
from skancf.theories.full.theory import jet_table as thick_table
from skancf.theories.kirchhoff.theory import jet_table as thin_table

AT_ONCE = 8192
"""Points that a form is called with at a time: enough to forget the cost of a call, few enough for the cache."""


@dataclass(frozen=True, eq=False)
class Chunk:
    """Some elements, and the points in them.

    Attributes
    ----------
    geometry : Geometry
    elements : (m,) int array
    points : (2, n) or (m, 2, n) array
        In the reference square.
    weights : (m, n) array
        Of the integral over the undeformed surface or edge.
    given : dict
        The parameters ``x`` (2, m, n), and on edges the direction ``along`` (2, m, n) in the parameter plane.
    """

    geometry: Geometry
    elements: np.ndarray
    points: np.ndarray
    weights: np.ndarray
    given: dict[str, np.ndarray]

    __repr__ = short

    @property
    def names(self) -> tuple[str, ...]:
        """The vectors of the jet."""
        return THICK if self.geometry.theory.directors else THIN

    @cached_property
    def tables(self) -> dict[str, np.ndarray]:
        """The 16 local functions' part in each vector of the jet: (m, 16, n) each."""
        return _tables(self.geometry, self.elements, self.points)

    def jet(self, local: np.ndarray, rates: np.ndarray | None = None) -> dict[str, np.ndarray]:
        """The jet (3, m, n) each of local vectors (m, 16, 3), and of their rates the velocity."""
        out = {name: _of_local(local, self.tables[name]) for name in self.names}
        return out if rates is None else {**out, VELOCITY: _of_local(rates, self.tables["r"])}

    @cached_property
    def undeformed(self) -> Fields:
        return Fields(self.jet(self.geometry.undeformed_local[self.elements]), None, self.given, Case())

    def fields(self, jet: Jet, case: Case) -> Fields:
        return Fields(jet, self.undeformed, self.given, case)

    def forces(self, gradient: dict[str, np.ndarray]) -> np.ndarray:
        """Forces on the local vectors, (m, 16, 3), of a derivative (3, m, n) with respect to each vector of the jet."""
        out = np.zeros((len(self.elements), FUNCTIONS, AXES))
        for name, each in gradient.items():
            out += self.tables[name] @ (np.moveaxis(each, 0, 2) * self.weights[:, :, None])
        return out

    def matrices(self, second: np.ndarray, rows: list[str], columns: list[str]) -> np.ndarray:
        """Matrices (m, 48, 48) on the local vectors, component by component, of second derivatives (rows, 3, columns, 3, m,
        n)."""
        m, n = self.weights.shape
        left = np.stack([self.tables[name] for name in rows], axis=2).reshape(m, FUNCTIONS, -1)
        right = np.stack([self.tables["r" if name == VELOCITY else name] for name in columns], axis=2)
        # (m, row, point, i, j, column function): what is left is one product of matrices for each element.
        weighted = second * self.weights
        half = np.einsum("kiljep,eblp->ekpijb", weighted, right, optimize=True).reshape(m, len(rows) * n, -1)
        out = (left @ half).reshape(m, FUNCTIONS, AXES, AXES, FUNCTIONS)
        return np.asarray(out.transpose(0, 2, 1, 3, 4).reshape(m, AXES * FUNCTIONS, AXES * FUNCTIONS))


def _of_local(local: np.ndarray, table: np.ndarray) -> np.ndarray:
    return np.moveaxis(local.swapaxes(1, 2) @ table, 1, 0)


def _tables(geometry: Geometry, elements: np.ndarray, points: np.ndarray) -> dict[str, np.ndarray]:
    """Derivatives with respect to the parameters, made of those in the reference square."""
    shape = (FUNCTIONS, *(points.shape[:1] if points.ndim == 3 else ()), points.shape[-1])
    flat = np.moveaxis(points, -2, 0).reshape(2, -1)
    directors = geometry.theory.directors
    of_reference = (thick_table if directors else thin_table)(flat).reshape(5, *shape)
    value = geometry.theory.position_table(flat)[0].reshape(shape)

    def over_elements(table: np.ndarray) -> np.ndarray:
        return np.moveaxis(table, 1, 0) if table.ndim == 3 else np.broadcast_to(table, (len(elements), *table.shape))

    G = np.moveaxis(np.linalg.inv(np.moveaxis(jacobian(geometry, elements, points), (0, 1), (-2, -1))), (-2, -1), (0, 1))
    one, two = (over_elements(each) for each in of_reference[[R1, R2]])
    out = {"r": over_elements(value), **_slopes("r", one, two, G)}
    if directors:
        one, two, value = (over_elements(each) for each in of_reference[[D1, D2, D]])
        return {**out, "d": value, **_slopes("d", one, two, G)}
    r11, r22, r12 = (over_elements(each) for each in of_reference[2:])
    for name, i, j in (("r_xx", 0, 0), ("r_xy", 0, 1), ("r_yy", 1, 1)):
        a11, a22, a12 = G[0, i] * G[0, j], G[1, i] * G[1, j], G[0, i] * G[1, j] + G[1, i] * G[0, j]
        out[name] = r11 * a11[:, None] + r22 * a22[:, None] + r12 * a12[:, None]
    return out


def _slopes(name: str, one: np.ndarray, two: np.ndarray, G: np.ndarray) -> dict[str, np.ndarray]:
    return {f"{name}_{way}": one * G[0, i][:, None] + two * G[1, i][:, None] for i, way in enumerate("xy")}


def jacobian(geometry: Geometry, elements: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Derivatives of the parameters with respect to the reference square, (2, 2, m, n)."""
    xi, eta = points.reshape(-1, *points.shape[-2:]).swapaxes(0, 1)
    slopes = [np.stack([(2 * a - 1) * np.where(b, eta, 1 - eta), (2 * b - 1) * np.where(a, xi, 1 - xi)]) for a, b in CORNERS]
    return np.einsum("dce,cken->dken", geometry.mesh.p[:, geometry.mesh.t[:, elements]], np.stack(slopes))


def chunks_of(geometry: Geometry, where: Any, n: int) -> list[Chunk]:
    """The points of a place: None for the whole surface, a function of (x, y) for a part of it, else edges of the boundary.

    Raises
    ------
    InputError
        For a place without edges or points.
    """
    if where is None or is_function(where):
        return list(_on_surface(geometry, where, n))
    return list(_on_edges(geometry, geometry.facets_on(where), n))


def _on_surface(geometry: Geometry, where: Any, n: int) -> Iterator[Chunk]:
    found = [part for group in _rules(geometry, n) for part in _inside(geometry, where, *group)]
    if not found:
        raise InputError("where: the function of (x, y) is true at no integration point of the surface; give one that "
                         "is true on a part of it, or the name of an edge")  # fmt: skip
    yield from found


def _rules(geometry: Geometry, n: int) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Elements that share n x n Gauss points, and those with points of their own: with points and weights."""
    kinds, points, weights = geometry.integration.kinds, geometry.integration.points, geometry.integration.weights
    shared, own = np.flatnonzero(kinds == 0), np.flatnonzero(kinds)
    yield (shared, *square_quadrature(n))
    yield own, points[kinds[own]], weights[kinds[own]]


def _inside(
    geometry: Geometry, where: Any, elements: np.ndarray, points: np.ndarray, weights: np.ndarray
) -> Iterator[Chunk]:
    """Those of the elements in which the place is."""
    of_each = points.ndim == 3
    for some in _split(np.arange(len(elements)), points.shape[-1]) if elements.size else ():
        its, at = elements[some], points[some] if of_each else points
        x = geometry.parameters(at, its)
        inside = np.ones(x.shape[1:], bool)
        if where is not None:
            inside = true_at("where", where, x.reshape(2, -1)).reshape(inside.shape)
        keep = np.flatnonzero(inside.any(axis=1))
        if keep.size:
            its, at = its[keep], at[keep] if of_each else at
            area = np.abs(np.linalg.det(np.moveaxis(jacobian(geometry, its, at), (0, 1), (-2, -1))))
            share = weights[some][keep] if of_each else weights
            yield _measured(geometry, its, at, share * area * inside[keep], {"x": x[:, keep]})


def _on_edges(geometry: Geometry, facets: np.ndarray, n: int) -> Iterator[Chunk]:
    points, tangents, weights = geometry.edge_points(facets, n)
    elements = geometry.mesh.f2t[0, facets]
    for some in _split(np.arange(len(facets)), n):
        at, its = points[some], elements[some]
        way = np.einsum("dken,ek->den", jacobian(geometry, its, at), tangents[some]) * geometry.side[its][:, None]
        length = np.sqrt((way**2).sum(axis=0))
        given = {"x": geometry.parameters(at, its), "along": way / length}
        yield _measured(geometry, its, at, weights * length, given)


def _split(items: np.ndarray, n: int) -> list[np.ndarray]:
    return np.array_split(items, max(1, -(-len(items) * n // AT_ONCE)))


def _measured(
    geometry: Geometry, elements: np.ndarray, points: np.ndarray, weights: np.ndarray, given: dict[str, np.ndarray]
) -> Chunk:
    """With the area of the undeformed surface, or its length along an edge."""
    chunk = Chunk(geometry, elements, points, weights, given)
    w = chunk.undeformed
    if "along" in given:
        along = w.r_x * given["along"][0] + w.r_y * given["along"][1]
        weights *= np.sqrt((along**2).sum(axis=0))
    else:
        weights *= w.da
    return chunk
