"""Quadratic bricks with 20 nodes through the thickness of a plate or shell, one for each layer.

Nodes stand on *lines* through the thickness: at each corner of an element and in the middle of each of its sides. At a
corner a layer has three nodes on the line, in the middle of a side two. What acts on the reference surface acts on a line
by weights that integrate over the thickness,

.. math:: \\int f(z) \\, N_k(z) \\, dz, \\qquad f = \\alpha + \\beta z,

so that a force, or what a support holds, is spread over it and has no point of its own in the brick.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp

from skancf.errors import InputError
from skancf.layout.patches import edge_numbers
from skancf.surfaces import normal
from skancf.tolerances import SEVEN_DIGITS

LINES = np.array([[0.0, 1.0, 1.0, 0.0, 0.5, 1.0, 0.5, 0.0], [0.0, 0.0, 1.0, 1.0, 0.0, 0.5, 1.0, 0.5]])
"""Local coordinates of the lines of an element: its corners, then the middles of its sides."""
TURNED = [0, 3, 2, 1, 7, 6, 5, 4]
"""The same lines the other way round."""


def serendipity(points: np.ndarray) -> np.ndarray:
    """Shape functions (8, ...) of the lines at local points (2, ...) of an element."""
    xi, eta = 2 * points - 1
    middles = [(1 - xi**2) * (1 - eta) / 2, (1 - eta**2) * (1 + xi) / 2, (1 - xi**2) * (1 + eta) / 2,
               (1 - eta**2) * (1 - xi) / 2]  # fmt: skip
    a, b = 2 * LINES[:, :4] - 1
    corners = [(1 + p * xi) * (1 + q * eta) / 4 * (p * xi + q * eta - 1) for p, q in zip(a, b, strict=True)]
    return np.stack([*corners, *middles])


@dataclass(frozen=True, eq=False)
class Bricks:
    """The bricks of a system.

    Attributes
    ----------
    system : System
    corners, middles : (n_corners, 2 n_layers + 1) and (n_middles, n_layers + 1) int arrays
        Nodes of the lines from bottom to top, from 0.
    lines : (8, n_elements) int array
        Of each element, numbered counter-clockwise where the normal points up; corners come first.
    heights : (n_lines, n_layers + 1) array
        Of the interfaces above the reference surface (m).
    at, places, normals : (2, n_lines), (3, n_lines) and (3, n_lines) arrays
        Parameters of the lines, their places in space and the unit normals there.
    """

    system: Any
    corners: np.ndarray
    middles: np.ndarray
    lines: np.ndarray
    heights: np.ndarray
    at: np.ndarray
    places: np.ndarray
    normals: np.ndarray

    @classmethod
    def of(cls, system: Any) -> "Bricks":
        """Those of a system.

        Raises
        ------
        InputError
            For hanging nodes, poles, and a thickness that jumps.
        """
        geometry = system.geometry
        if geometry.hanging.nodes.size:
            raise InputError("system: its mesh has hanging nodes, which bricks cannot have; put the problem on a mesh "
                             "without them, such as sk.meshes.uniform or sk.meshes.graded")  # fmt: skip
        if geometry.ties.poles:
            raise InputError("system: a side of its surface shrinks to a point, where bricks would have no volume; end the "
                             "surface before it")  # fmt: skip
        of_edge = np.unique(edge_numbers(geometry), return_inverse=True)[1].ravel()
        lines = np.concatenate([geometry.ties.node_of[geometry.mesh.t], geometry.n_nodes + of_edge[geometry.mesh.t2f]])
        at = geometry.parameters(LINES)
        heights = _heights(system, lines)
        n, layers = len(heights), heights.shape[1] - 1
        corners = np.arange(geometry.n_nodes * (2 * layers + 1)).reshape(geometry.n_nodes, -1)
        middles = corners.size + np.arange((n - len(corners)) * (layers + 1)).reshape(-1, layers + 1)
        first = np.unique(lines.T.ravel(), return_index=True)[1]
        at = at.reshape(2, -1)[:, first]
        turned = geometry.side < 0
        lines[:, turned] = lines[TURNED][:, turned]
        places = np.asarray(geometry.surface.position(*at), float)
        return cls(system, corners, middles, lines, heights, at, places, normal(geometry.surface, *at))

    @property
    def n_layers(self) -> int:
        return self.heights.shape[1] - 1

    @property
    def n_nodes(self) -> int:
        return int(self.corners.size + self.middles.size)

    @cached_property
    def levels(self) -> np.ndarray:
        """Heights of all nodes above the reference surface (n_nodes,) (m)."""
        n, z = len(self.corners), self.heights
        at_corners = np.empty(self.corners.shape)
        at_corners[:, ::2], at_corners[:, 1::2] = z[:n], (z[:n, 1:] + z[:n, :-1]) / 2
        return np.concatenate([at_corners.ravel(), z[n:].ravel()])

    @cached_property
    def line_of(self) -> np.ndarray:
        """The line of each node, (n_nodes,)."""
        n = len(self.corners)
        return np.concatenate([np.repeat(np.arange(n), self.corners.shape[1]),
                               np.repeat(n + np.arange(len(self.middles)), self.middles.shape[1])])  # fmt: skip

    @property
    def points(self) -> np.ndarray:
        """Places of all nodes, (n_nodes, 3) (m)."""
        return np.asarray((self.places[:, self.line_of] + self.levels * self.normals[:, self.line_of]).T)

    def elements(self, layer: int) -> np.ndarray:
        """Nodes (n_elements, 20) of the bricks of a layer, in the order of CalculiX and Abaqus."""
        corners, middles = self.lines[:4], self.lines[4:] - len(self.corners)
        low, high = 2 * layer, 2 * layer + 2
        rows = [self.corners[corners, low], self.corners[corners, high], self.middles[middles, layer],
                self.middles[middles, layer + 1], self.corners[corners, low + 1]]  # fmt: skip
        return np.concatenate(rows).T

    @cached_property
    def weights(self) -> tuple[sp.csr_matrix, sp.csr_matrix]:
        """Of the nodes for the displacement of the reference surface at each line and for the change of the director,
        each (n_lines, n_nodes)."""
        once, times = np.zeros((2, self.n_nodes))
        for line_nodes, z in ((self.corners, self.heights[: len(self.corners)]),
                              (self.middles, self.heights[len(self.corners) :])):  # fmt: skip
            _integrate(line_nodes, z, once, times)
        m0, m1, m2 = (np.bincount(self.line_of, each) for each in (once, once * self.levels, times * self.levels))
        determinant = m0 * m2 - m1**2
        out = []
        for alpha, beta in ((m2 / determinant, -m1 / determinant), (-m1 / determinant, m0 / determinant)):
            value = alpha[self.line_of] * once + beta[self.line_of] * times
            out.append(sp.csr_matrix((value, (self.line_of, np.arange(self.n_nodes))), (len(m0), self.n_nodes)))
        return out[0], out[1]

    def at_points(self, elements: np.ndarray, points: np.ndarray) -> sp.csr_matrix:
        """Weights (m n, n_lines) of lines at local points (m, 2, n) of elements (m,)."""
        flipped = self.system.geometry.side[elements] < 0
        lines = np.where(flipped, self.lines[TURNED][:, elements], self.lines[:, elements])
        shapes = serendipity(points.swapaxes(0, 1))
        m, n = shapes.shape[1:]
        row = np.broadcast_to(np.arange(m * n).reshape(m, n), shapes.shape)
        column = np.broadcast_to(lines[:, :, None], shapes.shape)
        return sp.csr_matrix((shapes.ravel(), (row.ravel(), column.ravel())), (m * n, len(self.heights)))

    def lines_of_facets(self, facets: np.ndarray) -> np.ndarray:
        """The lines in the middles of facets (m,) of the mesh."""
        mesh = self.system.geometry.mesh
        element = mesh.f2t[0, facets]
        side = np.argmax(mesh.t2f[:, element] == facets, axis=0)
        flipped = self.system.geometry.side[element] < 0
        return np.asarray(self.lines[np.where(flipped, 7 - side, 4 + side), element])


def _integrate(nodes: np.ndarray, z: np.ndarray, once: np.ndarray, times: np.ndarray) -> None:
    """Add the integrals of each node's shape function, and of it times z, over the lines."""
    quadratic = nodes.shape[1] > z.shape[1]
    for layer in range(z.shape[1] - 1):
        low, high = z[:, layer], z[:, layer + 1]
        h = high - low
        if quadratic:
            parts = [(0, 1 / 6, low / 6), (1, 4 / 6, (low + high) / 3), (2, 1 / 6, high / 6)]
        else:
            parts = [(0, 1 / 2, (2 * low + high) / 6), (1, 1 / 2, (low + 2 * high) / 6)]
        for k, share, moment in parts:
            at = nodes[:, (2 if quadratic else 1) * layer + k]
            once[at] += share * h
            times[at] += moment * h


def _heights(system: Any, lines: np.ndarray) -> np.ndarray:
    """Of the interfaces on each line, (n_lines, n_layers + 1)."""
    given = np.asarray(system.assembly.section.at(LINES).z)
    z = np.broadcast_to(given, (*lines.T.shape, given.shape[-1]))
    thin = np.diff(z, axis=-1) <= 0
    if thin.any():
        raise InputError("zones: they have different numbers of layers, which bricks cannot join; give all as many")
    low, high = np.full((lines.max() + 1, z.shape[-1]), np.inf), np.full((lines.max() + 1, z.shape[-1]), -np.inf)
    np.minimum.at(low, lines.T, z)
    np.maximum.at(high, lines.T, z)
    jump = (high - low).max(axis=1) > SEVEN_DIGITS * (high[:, -1] - low[:, 0])
    if jump.any():
        element = np.flatnonzero(jump[lines].any(axis=0))[0]
        x, y = system.geometry.parameters(np.array([[0.5], [0.5]]), np.array([element]))[:, 0, 0]
        raise InputError(f"thickness or offset: its faces or layers jump beside the element at ({x:.6g}, {y:.6g}), where "
                         "bricks would not meet; let the thickness change over a strip of elements")  # fmt: skip
    return (low + high) / 2
