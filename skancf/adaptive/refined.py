"""A coarse system and a refined one: fields between them, and what is left of errors there."""

from functools import cached_property
from typing import Any

import numpy as np

from skancf.adaptive.blunt import NOWHERE, Blunt
from skancf.adaptive.grow import SMALLEST, may_be_quartered
from skancf.adaptive.interpolation import Interpolation, ancestors_in
from skancf.adaptive.quantities import SectionForce
from skancf.adaptive.rings import Halvings, Pair, halvings
from skancf.adaptive.singular import images, singular_points, touching
from skancf.errors import finite
from skancf.layout.singularities import nodes_at
from skancf.materials import Section
from skancf.meshes import MeshQuadTree
from skancf.system.system import System
from skancf.theories import left_per_halving

AT_POLES = 1 / 4
"""Part of an error that is left on quartered elements at a pole, whose membrane strains are no assumed ones."""
AT_JUMPS, AT_ASSUMED_JUMPS = 1 / 2, 2 / 3
"""The same at a line where the membrane stiffness jumps: strains jump there, and slopes at nodes do not. Assumed membrane
strains feel it the more the finer they are, down to elements as long as the plate is thick."""
EXTRA = 4
"""Refinements beyond the first at singular points, where one halves an error that it divides by sixteen elsewhere."""
MOST = 12
"""Elements of the refined mesh per element of the mesh."""


def enriched_mesh(system: System, points: np.ndarray, smallest: float = SMALLEST, blunt: Blunt = NOWHERE) -> Any:
    """Every element quartered, and those at singular points (2, n) :data:`EXTRA` times more."""
    mesh = system.mesh
    leaves = mesh.leaves.refined(np.arange(mesh.nelements))
    for _ in range(EXTRA):
        if len(leaves) > MOST * (mesh.nelements + MOST):
            break  # more singular points than elements
        at_points = touching(leaves, images(system.geometry, leaves, points))
        room = may_be_quartered(leaves, system.geometry.surface, smallest / 4, blunt)
        leaves = leaves.refined(at_points[room[at_points]])
    return mesh.regrown(leaves)


class Refined:
    """A coarse system, a refined one, and fields between them.

    Attributes
    ----------
    coarse, system : System
        The same problem on the mesh and on the refined one.
    points : (2, n) array
        Singular ones, of the problem and of the quantity.
    """

    def __init__(
        self, coarse: System, mesh: MeshQuadTree | None = None, quantity: Any = None, smallest: float = SMALLEST,
        blunt: Blunt = NOWHERE,
    ) -> None:  # fmt: skip
        self.coarse, self.points, self._quantity = coarse, singular_points(coarse, quantity), quantity
        fine_mesh = enriched_mesh(coarse, self.points, smallest, blunt) if mesh is None else mesh
        self.system: System = coarse.problem.on(fine_mesh, coarse.geometry.theory)
        self._up = Interpolation.of(coarse, self.system)
        self._down = Interpolation.of(self.system, coarse)

    def halvings(self, *pairs: Pair, before: Halvings | None = None) -> Halvings:
        """What a halving leaves at the singular points of the problem, by energies of answers and weights here, and by
        ``before``, that of a coarser mesh, where there are too few rings."""
        return halvings(self.coarse, self.system, singular_points(self.coarse), pairs, before)

    def left(self, halved: Halvings) -> np.ndarray:
        """Part of what each element contributes to an error that is left on the refined mesh, (n_elements,).

        By the order of the theory, at poles :data:`AT_POLES`; at lines where the membrane stiffness jumps, and at singular
        points no less than the power of what one halving leaves there.
        """
        coarse, fine, geometry = self.coarse.mesh.leaves, self.system.mesh.leaves, self.coarse.geometry
        left = np.full(len(coarse), left_per_halving(geometry.theory))
        left[geometry.at_poles] = AT_POLES
        deepest = np.zeros(len(coarse), dtype=int)
        np.maximum.at(deepest, ancestors_in(coarse, fine), fine.cells.level)
        halved_by = deepest - coarse.cells.level
        section = self.coarse.assembly.section
        if not isinstance(section, Section):
            lines, theory = section.beside_jumps, geometry.theory
            at_lines = AT_ASSUMED_JUMPS if theory.assumed and not theory.directors else AT_JUMPS
            left[lines] = np.maximum(left[lines], at_lines ** halved_by[lines])
        there, once = halved.of(coarse, self.points)
        left[there] = np.maximum(left[there], once ** halved_by[there])
        return left

    def up(self, q: np.ndarray) -> np.ndarray:
        """Nodal coordinates of the same field on the refined mesh."""
        return self._up.field(q)

    def down(self, q: np.ndarray) -> np.ndarray:
        """Nodal coordinates on the coarse mesh of a field's interpolant."""
        return self._down.field(q)

    def surplus(self, weight: np.ndarray) -> np.ndarray:
        """What of a field on the refined mesh the coarse one cannot have, (n_fine,).

        A weight that is singular at a node has slopes and a twist there that are those of the smallest element, and say
        nothing of larger ones: its interpolant has none.
        """
        coarse = self.coarse.layout.nodal(self.down(weight))
        coarse[self._at_quantity, 1:] = 0.0
        return weight - self.up(coarse.ravel())

    @cached_property
    def _at_quantity(self) -> np.ndarray:
        """Coarse nodes at the point of a section force, at most one."""
        if not isinstance(self._quantity, SectionForce) or self._quantity.at is None:
            return np.empty(0, dtype=int)
        geometry = self.coarse.geometry
        return nodes_at(geometry, geometry.within(finite("at", self._quantity.at)[:, None]))

    def shares(self, products: np.ndarray) -> np.ndarray:
        """Sizes of products (n_fine,) of residual and weight, node by node, shared among the coarse elements there."""
        geometry = self.system.geometry
        sizes = np.abs(self.system.layout.blocks(products)[: geometry.n_nodes].sum(axis=1))
        nodes = geometry.ties.node_of[geometry.mesh.t]
        valence = np.bincount(nodes[nodes >= 0], minlength=len(sizes))
        parts = np.where(nodes >= 0, (sizes / np.maximum(valence, 1))[nodes], 0.0).sum(axis=0)
        coarse = self.coarse.mesh
        return np.bincount(ancestors_in(coarse.leaves, geometry.mesh.leaves), parts, minlength=coarse.nelements)

    def is_new(self) -> np.ndarray:
        """Which nodes of the refined mesh the coarse one does not have, (n_fine_blocks,)."""
        fine, coarse = self.system.geometry, self.coarse.geometry
        old = coarse.mesh.leaves.forest.point_keys(coarse.mesh.leaves.cells).ravel()
        new = fine.mesh.leaves.forest.point_keys(fine.mesh.leaves.cells).ravel()
        out = np.zeros(self.system.layout.n_blocks, dtype=bool)
        out[fine.ties.node_of[fine.mesh.t.ravel()[~np.isin(new, old)]]] = True
        return out
