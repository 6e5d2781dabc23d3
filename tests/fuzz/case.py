"""A case: a problem, a mesh by fractions of the parameter plane, a theory. Its ``repr`` is Python that makes it again."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import skfem

import skancf as sk


@dataclass(frozen=True)
class Mesh:
    """Mesh lines at fractions of the bounds; elements at ``refined`` points are quartered in turn, lines (i0, i1, j0, j1)
    bound an opening."""

    x: tuple[float, ...]
    y: tuple[float, ...]
    refined: tuple[tuple[float, float], ...] = ()
    opening: tuple[int, int, int, int] | None = None

    def on(self, surface: Any, numbering: int | None = None) -> skfem.MeshQuad:
        """The mesh of a surface; with a seed, its nodes, elements and corners are numbered by chance."""
        (x0, x1), (y0, y1) = surface.bounds
        x, y = x0 + np.array(self.x) * (x1 - x0), y0 + np.array(self.y) * (y1 - y0)
        holes = []
        if self.opening:
            i0, i1, j0, j1 = self.opening
            holes = [((x[i0], x[i1]), (y[j0], y[j1]))]
        mesh = sk.meshes.tensor(surface, x, y, openings=holes)
        if numbering is not None:
            mesh = renumbered(mesh, np.random.default_rng(numbering))
        if self.refined:
            mesh = sk.meshes.quadtree(mesh, surface)
        for point in self.refined:
            mesh = mesh.refined([element_at(mesh, place(surface, point))])
        return mesh

    def halved(self) -> "Mesh":
        """Every element in four; not for meshes with hanging nodes."""
        opening = None if self.opening is None else tuple(2 * line for line in self.opening)
        return replace(self, x=_with_middles(self.x), y=_with_middles(self.y), opening=opening)


@dataclass(frozen=True)
class Case:
    """What is solved."""

    problem: sk.Problem
    mesh: Mesh
    theory: Any

    def system(self, numbering: int | None = None) -> Any:
        return self.problem.on(self.mesh.on(self.problem.surface, numbering), theory=self.theory)

    def with_loads(self, *loads: Any) -> "Case":
        return replace(self, problem=replace(self.problem, loads=loads))


def place(surface: Any, fractions: Any) -> tuple[float, float]:
    """A point of the parameter plane by fractions of the bounds."""
    (x0, x1), (y0, y1) = surface.bounds
    return float(x0 + fractions[0] * (x1 - x0)), float(y0 + fractions[1] * (y1 - y0))


def element_at(mesh: skfem.MeshQuad, point: tuple[float, float]) -> int:
    """The element whose middle is nearest; of equally near ones the upper right one, whatever its number."""
    middles, size = mesh.p[:, mesh.t].mean(axis=1), np.ptp(mesh.p, axis=1)
    beside = np.array(point) + size * (1e-4, 3e-4)
    return int(np.argmin(np.linalg.norm((middles - beside[:, None]) / size[:, None], axis=0)))


def renumbered(mesh: skfem.MeshQuad, rng: np.random.Generator) -> skfem.MeshQuad:
    """Nodes and elements in another order, corners begun elsewhere and run through the other way."""
    new = rng.permutation(mesh.p.shape[1])
    points = np.empty_like(mesh.p)
    points[:, new] = mesh.p
    corners = new[mesh.t][:, rng.permutation(mesh.nelements)]
    corners = np.stack([_turned(column, rng) for column in corners.T], axis=1)
    out = skfem.MeshQuad(np.ascontiguousarray(points), np.ascontiguousarray(corners))
    numbers = {tuple(pair): k for k, pair in enumerate(np.sort(out.facets, axis=0).T.tolist())}
    names = {
        name: np.array([numbers[tuple(sorted(new[mesh.facets[:, facet]].tolist()))] for facet in facets])
        for name, facets in (mesh.boundaries or {}).items()
    }
    return out.with_boundaries(names)


def _turned(corners: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    turned = np.roll(corners, rng.integers(4))
    return turned[::-1] if rng.integers(2) else turned


def _with_middles(row: tuple[float, ...]) -> tuple[float, ...]:
    lines = np.array(row)
    return tuple(np.sort(np.concatenate([lines, (lines[1:] + lines[:-1]) / 2])).tolist())
