"""Names of boundaries and subdomains that stay exact while elements are split and merged."""

from dataclasses import dataclass

import numpy as np
import skfem

from skancf.meshes.forest import STEPS, Cells, Leaves
from skancf.showing import short


@dataclass(frozen=True)
class Names:
    """Named sides (4, n_elements) and elements (n_elements,) as masks."""

    sides: dict[str, np.ndarray]
    elements: dict[str, np.ndarray]

    __repr__ = short

    @classmethod
    def of(cls, mesh: skfem.MeshQuad) -> "Names":
        sides, elements, none = {}, {}, np.empty(0, dtype=int)
        for name, facets in (mesh.boundaries or {}).items():
            mask = np.zeros(mesh.nfacets, dtype=bool)
            mask[np.asarray(facets)] = True
            halves, wholes = getattr(mesh, "divided", (none, none))
            mask[wholes] = np.bincount(wholes, mask[halves], mesh.nfacets)[wholes] == 2
            sides[name] = mask[mesh.t2f]
        for name, members in (mesh.subdomains or {}).items():
            elements[name] = np.zeros(mesh.nelements, dtype=bool)
            elements[name][np.asarray(members)] = True
        return cls(sides, elements)

    def uniform(self, sisters: np.ndarray) -> np.ndarray:
        """Whether sisters (4, m) can be merged without a loss: all are in a subdomain or none, both halves of a side have a
        name or neither, and no side between them has one. (m,)"""
        fine = np.ones(sisters.shape[1], dtype=bool)
        for mask in self.elements.values():
            fine &= (mask[sisters] == mask[sisters[0]]).all(axis=0)
        for mask in self.sides.values():
            for side in range(4):
                one, two = sisters[[side, (side + 1) % 4]]
                fine &= mask[side, one] == mask[side, two]
                fine &= ~(mask[(side + 2) % 4, one] | mask[(side + 2) % 4, two])
        return fine

    def carried(self, old: Leaves, new: Leaves) -> "Names":
        """The names on the leaves of another mesh: of a split leaf to what it became, of merged ones to their parent."""
        source, cells = old.find(new.cells), new.cells
        outer, lost = np.ones((4, len(new)), dtype=bool), source < 0
        while lost.any() and cells.level.max() > 0:
            outer &= _outer(cells) | ~lost
            cells = cells.parents
            source = np.where(lost, old.find(cells), source)
            lost = source < 0
        merged = np.flatnonzero(lost)
        sisters = old.find(new.cells.take(merged).children).reshape(-1, 4)
        source[merged], outer[:, merged] = sisters[:, 0], True
        elements = {name: mask[source] for name, mask in self.elements.items()}
        sides = {}
        for name, mask in self.sides.items():
            carried = mask[:, source] & outer
            for side in range(4):
                carried[side, merged] = mask[side, sisters[:, side]]
            sides[name] = carried
        return Names(sides, elements)

    def on(self, mesh: skfem.MeshQuad) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
        """Facets and elements of a tree by name; of an edge between two levels its halves."""
        facets = {name: np.unique(mesh.t2f[mask]) for name, mask in self.sides.items()}
        return (
            {name: found[found < mesh.f2t.shape[1]].astype(np.int32) for name, found in facets.items()},
            {name: np.flatnonzero(mask).astype(np.int32) for name, mask in self.elements.items()},
        )


def _outer(cells: Cells) -> np.ndarray:
    """Whether each side of a cell is on the side of its parent, (4, n)."""
    x, y = cells.corner
    return np.stack([(x == (dx > 0)) if dx else (y == (dy > 0)) for dx, dy in STEPS])
