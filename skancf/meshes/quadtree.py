"""Meshes of aligned rectangles that are refined and coarsened element by element, with hanging nodes."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import skfem

from skancf.arguments import MESH, instance, whole
from skancf.equality import same_mesh
from skancf.errors import InputError, shown
from skancf.functions import is_function
from skancf.memory import require_mesh
from skancf.meshes.coarse import forest_of
from skancf.meshes.forest import DEEPEST, Leaves
from skancf.meshes.names import Names
from skancf.meshes.snap import onto_bounds, onto_lines
from skancf.surfaces import Surface, closed_directions
from skancf.surfaces.checks import require_surface
from skancf.tolerances import ONE_PLACE


@dataclass(repr=False)
class MeshQuadTree(skfem.MeshQuad):
    r"""A mesh grown from coarse rectangles by quartering elements, with hanging nodes.

    Neighbours differ by one level at most, over edges and corners, so that a hanging node lies in the middle of a larger
    element's edge. The space of bicubic Hermite functions on it is C1, and that of a refined mesh contains it. Make one by
    :func:`quadtree`; :meth:`refined`, :meth:`coarsened` and :meth:`adapted` give new ones.

    A node of the coarse mesh keeps its number. An edge between elements of two levels is represented by its halves, for
    which ``f2t`` names both neighbours. The larger element's whole edge is a facet of ``t2f`` only: such divided facets have
    the last numbers, and ``f2t`` ends before them, so that they count neither as interior nor as boundary.

    Attributes
    ----------
    leaves : Leaves
        The elements as cells of a forest of quadtrees.

    Examples
    --------
    >>> plate = sk.Rectangle(1.0, 1.0)
    >>> tree = sk.meshes.quadtree(sk.meshes.uniform(plate, 2, 2), plate).refined([0, 3])
    >>> print(tree.nelements, tree.levels.max(), len(tree.hanging))
    10 1 4
    """

    leaves: Any = None

    def __post_init__(self) -> None:
        super().__post_init__()
        forest = self.leaves.forest if self.leaves else None
        n = forest.points.shape[1] if forest else 0
        if forest is None or self.t.shape[1] != len(self.leaves) or not np.array_equal(self.p[:, :n], forest.points):
            raise InputError("a quadtree mesh grows from a coarse one by quadtree(mesh), and what moves or cuts it leaves "
                             "the tree: change the coarse mesh, or take the plain() copy")  # fmt: skip

    def __eq__(self, other: object) -> bool:
        return isinstance(other, skfem.Mesh) and same_mesh(self, other)

    def __reduce__(self) -> Any:
        return grown, (self.leaves, Names.of(self))

    @property
    def levels(self) -> np.ndarray:
        """How often the coarse element was quartered, for each element."""
        return np.asarray(self.leaves.cells.level)

    def plain(self) -> skfem.MeshQuad:
        """The same points and elements as a plain scikit-fem mesh, to which hanging nodes are nothing special: a field on it
        is torn at them. For what scikit-fem does with meshes; :meth:`Problem.on` refuses it."""
        return skfem.MeshQuad(self.p, self.t)

    # What differs from a conforming mesh

    @property
    def hanging(self) -> np.ndarray:
        """Nodes in the middle of a larger element's edge, (m,)."""
        return self._meeting().nodes

    @property
    def hanging_ends(self) -> np.ndarray:
        """The ends of that edge, (2, m) nodes, on the side of the smaller elements."""
        return self._meeting().ends

    def _meeting(self) -> "_Meeting":
        if not hasattr(self, "_cached_meeting"):
            self._cached_meeting = _Meeting.of(self)
        return self._cached_meeting

    def _init_facets(self) -> None:
        n, meeting = self.p.shape[1], self._meeting()
        first, second = np.sort(np.stack([self.t, np.roll(self.t, -1, axis=0)]), axis=0).astype(np.int64)
        ends = first * n + second
        keys, inverse = np.unique(ends, return_inverse=True)
        inside = ~meeting.seam
        divided = np.isin(keys, ends[(meeting.sides[inside] + 2) % 4, meeting.large[inside]])
        order = np.argsort(divided, kind="stable")
        number = np.empty_like(order)
        number[order] = np.arange(len(order))
        self._facets = np.stack(np.divmod(keys[order], n)).astype(np.int32)
        self._t2f = number[inverse].reshape(self.t.shape).astype(np.int32)

    @property
    def f2t(self) -> np.ndarray:
        """Elements on both sides of each facet that is not divided, (2, n); -1 for none."""
        if not hasattr(self, "_f2t"):
            inverse, (halves, wholes), meeting = self.build_inverse(self.t, self.t2f), self.divided, self._meeting()
            inverse[1, halves] = meeting.large[~meeting.seam]
            self._f2t = inverse[:, : self.nfacets - len(np.unique(wholes))]
        return self._f2t

    @property
    def divided(self) -> tuple[np.ndarray, np.ndarray]:
        """Halves of divided facets, (m,), and the whole of each, twice every one."""
        meeting = self._meeting()
        small, sides, large = (part[~meeting.seam] for part in (meeting.small, meeting.sides, meeting.large))
        return self.t2f[sides, small], self.t2f[(sides + 2) % 4, large]

    def facets_satisfying(self, test: Any, boundaries_only: bool = False, normal: Any = None) -> np.ndarray:
        """Facets whose middles satisfy some condition, divided ones left out: see scikit-fem."""
        undivided = np.arange(self.nfacets) < self.f2t.shape[1]
        return super().facets_satisfying(lambda x: test(x) & undivided, boundaries_only, normal)

    # Change

    def refined(self, times_or_ix: Any = 1) -> "MeshQuadTree":
        """Elements quartered, and around them what the balance of neighbours needs.

        Parameters
        ----------
        times_or_ix : int or (n,) array
            How often all are quartered; or numbers of elements, or a mask (n_elements,).

        Raises
        ------
        InputError
            For numbers of elements that there are not, and below the deepest level.
        NotEnoughMemory
            For more elements than a system would fit for.
        """
        if not isinstance(times_or_ix, int | np.integer):
            return self._adaptive(times_or_ix)
        times = whole("refined", times_or_ix, least=0, most=DEEPEST)
        require_mesh(self.nelements * 4**times)
        finer = self
        for _ in range(times):
            finer = finer._uniform()
        return finer

    def _uniform(self) -> "MeshQuadTree":
        return self._adaptive(np.arange(self.nelements))

    def _adaptive(self, elements: Any) -> "MeshQuadTree":
        marked = self._numbers("refined", elements)
        split = self.leaves.closure(marked)
        deep = split[self.levels[split] >= DEEPEST]
        if deep.size:
            where = self.p[:, self.t[:, deep[0]]].mean(axis=1)
            raise InputError(f"element {deep[0]} at ({where[0]:.6g}, {where[1]:.6g}) has level {DEEPEST}, the deepest; "
                             "begin with a finer coarse mesh")  # fmt: skip
        require_mesh(self.nelements + 3 * split.size)
        return self.regrown(self.leaves.split(split)) if split.size else self

    def coarsened(self, elements: Any) -> "MeshQuadTree":
        """A mesh in which sisters that are all among these elements are merged, once.

        Those whose parent would be more than one level larger than a neighbour stay, and those that a named boundary or
        subdomain covers in part, so that names stay exact.
        """
        sisters = self.leaves.families(self._numbers("coarsened", elements))
        sisters = sisters[:, Names.of(self).uniform(sisters)]
        # A family that stays may leave its neighbours' families without room.
        while sisters.size:
            again = self.leaves.families(np.unique(sisters))
            if again.shape == sisters.shape:
                break
            sisters = again
        return self.regrown(self.leaves.merged(sisters)) if sisters.size else self

    def adapted(self, refine: Any, coarsen: Any = ()) -> "MeshQuadTree":
        """Refined where asked and needed for balance, then coarsened where asked and possible."""
        finer = self.refined(self._numbers("refined", refine))
        kept = finer.leaves.find(self.leaves.cells.take(self._numbers("coarsened", coarsen)))
        return finer.coarsened(kept[kept >= 0])

    def regrown(self, leaves: Leaves) -> "MeshQuadTree":
        """The mesh of other leaves of the same forest, of which none is larger than the parents of these; names are kept."""
        return grown(leaves, Names.of(self).carried(self.leaves, leaves))

    def _numbers(self, what: str, elements: Any) -> np.ndarray:
        try:
            if is_function(elements):
                return self._where_true(elements)
            # By name; see scikit-fem.
            found = np.asarray(self.normalize_elements(elements) if len(np.shape(elements)) == 0 else elements)
        except Exception as wrong:
            raise InputError(f"{what}: {shown(elements)}: give element numbers, a mask or the name of a subdomain ({wrong})"
                             ) from wrong  # fmt: skip
        if found.dtype == bool and found.shape == (self.nelements,):
            return np.flatnonzero(found)
        whole = np.issubdtype(found.dtype, np.integer)
        if found.size and not (whole and found.min() >= 0 and found.max() < self.nelements):
            raise InputError(f"{what}: give element numbers from 0 to {self.nelements - 1}, not {shown(elements)}")
        return np.unique(found).astype(int)

    def _where_true(self, function: Any) -> np.ndarray:
        """Elements at whose middles a function of points (2, n) is true, as in scikit-fem."""
        found = np.asarray(function(self.p[:, self.t].mean(axis=1)))
        if found.dtype != bool or found.shape != (self.nelements,):
            raise InputError(f"the function returned {shown(found)}, not True or False for each element")
        return np.flatnonzero(found)

    # Where things are

    def element_finder(self, mapping: Any = None) -> Any:
        """A function of x and y, (n,) each, that gives the elements; ValueError where a point is in none."""
        roots = self.leaves.forest

        def finder(x: np.ndarray, y: np.ndarray) -> np.ndarray:
            root, local = self._roots_at(np.stack([x, y]))
            found = roots.covering(self.leaves, root, *local)
            if (found < 0).any():
                raise ValueError("Point is outside of the mesh.")
            return found

        return finder

    def _roots_at(self, at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The root that holds each point (2, n), -1 for none, and the place in it, (2, n) in [0, 1]."""
        forest, (lines, grid) = self.leaves.forest, self._grid()
        slack = ONE_PLACE * np.ptp(forest.points, axis=1)
        root = np.full(at.shape[1], -1)
        for sign_x in (1, -1):
            for sign_y in (1, -1):  # a point on a line belongs to either side
                moved = at + slack[:, None] * [[sign_x], [sign_y]]
                i, j = (np.searchsorted(line, x, side="right") - 1 for line, x in zip(lines, moved, strict=True))
                inside = (i >= 0) & (j >= 0) & (i < grid.shape[0]) & (j < grid.shape[1])
                found = np.where(inside, grid[np.where(inside, i, 0), np.where(inside, j, 0)], -1)
                root = np.where(root < 0, found, root)
        low, high = forest.points[:, forest.corners[0]], forest.points[:, forest.corners[2]]
        return root, np.clip((at - low[:, root]) / (high - low)[:, root], 0.0, 1.0)

    def _grid(self) -> tuple[list[np.ndarray], np.ndarray]:
        """Mesh lines of the roots in both directions, and the root in each cell between them, -1 for none."""
        if not hasattr(self, "_cached_grid"):
            forest = self.leaves.forest
            lines = [np.unique(row) for row in forest.points]
            grid = np.full([len(line) - 1 for line in lines], -1)
            first, last = ([np.searchsorted(line, forest.points[k, forest.corners[c]]) for k, line in enumerate(lines)]
                           for c in (0, 2))  # fmt: skip
            for root in range(forest.n_roots):
                grid[first[0][root] : last[0][root], first[1][root] : last[1][root]] = root
            self._cached_grid = lines, grid
        return self._cached_grid


@dataclass(frozen=True)
class _Meeting:
    """Where smaller elements lie next to a larger one.

    ``small``, ``sides``, ``large`` are (k,), two for each hanging node of one side; ``seam`` tells where the larger one is
    across a closed seam. ``nodes`` (m,) are the hanging nodes and ``ends`` (2, m) the ends of the larger edge.
    """

    small: np.ndarray
    sides: np.ndarray
    large: np.ndarray
    seam: np.ndarray
    nodes: np.ndarray
    ends: np.ndarray

    @classmethod
    def of(cls, mesh: MeshQuadTree) -> "_Meeting":
        leaves = mesh.leaves
        small, sides, corner, large = leaves.larger_beside()
        parents = leaves.cells.take(small).parents
        keys = leaves.forest.point_keys(parents)
        # The parent's corner is a corner of the sister there, or of her children.
        far_keys = keys[corner, np.arange(len(small))]
        own_keys, at = np.unique(leaves.forest.point_keys(leaves.cells), return_index=True)
        far = mesh.t.ravel()[at[np.searchsorted(own_keys, far_keys)]]
        nodes, first = np.unique(mesh.t[corner, small], return_index=True)
        # The side's other corner is the near end.
        one, two = sides, (sides + 1) % 4
        near = mesh.t[np.where(corner == one, two, one), small]
        middle = mesh.p[:, mesh.t[corner, small]]
        low, high = mesh.p[:, mesh.t[0, large]], mesh.p[:, mesh.t[2, large]]
        slack = ONE_PLACE * np.ptp(mesh.p, axis=1)[:, None]
        seam = ~((middle >= low - slack) & (middle <= high + slack)).all(axis=0)
        return cls(small, sides, large, seam, nodes.astype(int), np.stack([near, far])[:, first].astype(int))


def quadtree(mesh: skfem.MeshQuad, surface: Surface | None = None) -> MeshQuadTree:
    """A quadtree mesh from a coarse mesh of aligned rectangles. Orientations of named interior boundaries are not kept.

    Parameters
    ----------
    mesh : skfem.MeshQuad
        For example of :func:`uniform`, with openings or without. Its names of boundaries and subdomains are kept.
    surface : Surface, optional
        Tells in which directions the parameter plane is closed, so that the mesh fits across the seam.

    Raises
    ------
    InputError
        For an element that is no aligned rectangle, and for ends of a closed direction that do not match.

    Examples
    --------
    >>> plate = sk.Rectangle(1.0, 1.0)
    >>> tree = sk.meshes.quadtree(sk.meshes.uniform(plate, 2, 2), plate)
    >>> tree.refined([0]).nelements
    7
    """
    instance("mesh", mesh, skfem.MeshQuad, MESH)
    if surface is not None:
        require_surface(surface, ("position", "derivatives"))
    closed = closed_directions(surface) if surface is not None else (False, False)
    if isinstance(mesh, MeshQuadTree):
        if surface is None or closed == tuple(mesh.leaves.forest.closed):
            return mesh
        raise InputError(f"a quadtree whose directions are closed as {tuple(mesh.leaves.forest.closed)}, on a surface with "
                         f"{closed}: make it by quadtree(coarse mesh, surface)")  # fmt: skip
    bounds = getattr(surface, "bounds", None)
    if bounds is not None:
        mesh = onto_bounds(mesh, bounds)
    mesh = onto_lines(mesh)
    forest = forest_of(mesh, closed)
    coarse = skfem.MeshQuad(forest.points, forest.corners)
    names = Names.of(replace(coarse, _boundaries=_facets_by_ends(mesh, coarse), _subdomains=mesh.subdomains))
    return grown(Leaves(forest, forest.roots), names)


def grown(leaves: Leaves, names: Names | None = None) -> MeshQuadTree:
    """The mesh of some leaves, with names by their sides and numbers."""
    forest = leaves.forest
    _, first, inverse = np.unique(forest.point_keys(leaves.cells), return_index=True, return_inverse=True)
    points = np.ascontiguousarray(forest.places(leaves.cells).reshape(2, -1)[:, first])
    # Of a moved vertex the forest's own coordinates, to the last bit.
    points[:, : forest.points.shape[1]] = forest.points
    mesh: Any = MeshQuadTree(points, np.ascontiguousarray(inverse.reshape(4, -1), dtype=np.int32), leaves=leaves)
    boundaries, subdomains = names.on(mesh) if names else ({}, {})
    return replace(mesh, _boundaries=boundaries, _subdomains=subdomains) if boundaries or subdomains else mesh


def _facets_by_ends(mesh: skfem.MeshQuad, coarse: skfem.MeshQuad) -> Mapping[str, np.ndarray] | None:
    """The named facets of a mesh in the numbers of another one with the same nodes."""
    if mesh.boundaries is None:
        return None
    n = mesh.p.shape[1]
    keys = coarse.facets[0].astype(np.int64) * n + coarse.facets[1]
    order = np.argsort(keys)

    def number(facets: np.ndarray) -> np.ndarray:
        ends = np.sort(mesh.facets[:, facets], axis=0).astype(np.int64)
        return order[np.searchsorted(keys[order], ends[0] * n + ends[1])]

    return {name: number(np.asarray(facets)) for name, facets in mesh.boundaries.items()}
