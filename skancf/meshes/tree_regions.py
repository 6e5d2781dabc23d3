"""Quadtree meshes that are fine in some regions."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import skfem

from skancf.arguments import MESH, instance, sequence, whole
from skancf.errors import InputError
from skancf.memory import require_mesh
from skancf.meshes.fineness import Pair, coarse_lengths, fractions
from skancf.meshes.forest import DEEPEST
from skancf.meshes.quadtree import MeshQuadTree, quadtree
from skancf.meshes.region import REGION, Region, Regions
from skancf.tolerances import ONE_PLACE


def refined_in(
    mesh: MeshQuadTree | skfem.MeshQuad,
    regions: Sequence[Region],
    *,
    finest: float = 0.25,
    coarse: float | Pair | None = None,
    levels: int | None = None,
) -> MeshQuadTree:
    r"""A mesh whose elements in ``regions`` are quartered until they are as small as :func:`graded` would make them.

    In each direction of the parameter plane no element that overlaps the inside of a region is longer than

    .. math:: l_n = l_0 \max\bigl(\text{finest}, (\sigma_i / \bar\sigma)^{-1/2}\bigr) .

    Quartered are those that are too long in either direction, and around them what the 2:1 balance of neighbours needs.
    Away from the regions nothing changes: there are no strips along rows and columns, but hanging nodes.

    Parameters
    ----------
    mesh : MeshQuadTree or skfem.MeshQuad
        Of aligned rectangles. Give :func:`quadtree` ``(mesh, surface)`` for a closed surface, so that neighbours across the
        seam are balanced too.
    regions : sequence of Region
        By hand or from :func:`skancf.stress_regions`. They are rectangles of the parameter plane: one that reaches
        over a closed seam ends there, and goes on behind it only if a second region says so.
    finest : float
        Smallest l_n / l_0, between 0 and 1.
    coarse : float or (2,) tuple, optional
        Length l_0, for both or each direction (units of the parameter plane). Default: the element length of the mesh on
        which the regions were found, or, where they do not remember it, the median one of this mesh.
    levels : int, optional
        Quarter the elements in the regions this many times instead, whatever their lengths.

    Returns
    -------
    MeshQuadTree
        Names of boundaries and subdomains are kept. Halving ends between :math:`l_n / 2` and :math:`l_n` in the direction
        that decides; elements that are smaller already stay.

    Raises
    ------
    InputError
        For values out of range, a region centred outside the mesh, and ``levels`` together with ``coarse``.
    NotEnoughMemory
        For more elements than a system would fit for.

    References
    ----------
    Research on local mesh refine method based on absolute nodal coordinate formulation: where to refine. Its meshes have no
    hanging nodes; the length is that of :func:`graded`.

    Examples
    --------
    >>> plate = sk.Rectangle(1.0, 1.0)
    >>> corner = sk.meshes.Region(centre=(0.0, 0.0), half_size=(0.1, 0.1))
    >>> mesh = sk.meshes.refined_in(sk.meshes.uniform(plate, 2, 2), [corner], levels=3)
    >>> mesh.nelements, len(mesh.hanging)
    (13, 6)
    """
    instance("mesh", mesh, skfem.MeshQuad, MESH)
    regions = sequence("regions", regions, Region, REGION) if not isinstance(regions, Regions) else regions
    levels = None if levels is None else whole("levels", levels, least=0, most=DEEPEST)
    if levels is not None and coarse is not None:
        raise InputError(f"levels = {levels} and coarse = {coarse}: give a number of levels or a length, not both")
    if coarse is None and isinstance(regions, Regions):
        coarse = regions.cell
    tree, shares = quadtree(mesh), fractions(regions, finest)
    finder = tree.element_finder()
    for region in regions:
        _check_centre(region, finder)
    if levels is not None:
        _require_room(tree, regions, np.full((len(regions), tree.nelements), levels))
        for _ in range(levels):
            tree = tree.refined(_overlaps(tree, regions).any(axis=0))
        return tree
    bounds = [(float(row.min()), float(row.max())) for row in tree.p]
    # (m, 2, 1): regions, directions, elements.
    wanted = np.multiply.outer(shares, coarse_lengths(_median(tree) if coarse is None else coarse, bounds))[..., None]
    _require_room(tree, regions, np.ceil(np.log2(np.maximum(1.0, (_lengths(tree) / wanted).max(axis=1))) - ONE_PLACE))
    while (marked := _overlaps(tree, regions) & (_lengths(tree) > wanted * (1 + ONE_PLACE)).any(axis=1)).any():
        tree = tree.refined(marked.any(axis=0))
    return tree


def _lengths(mesh: skfem.MeshQuad) -> np.ndarray:
    """Of the elements along x and y, (2, n_elements)."""
    return np.asarray(np.ptp(mesh.p[:, mesh.t], axis=1))


def _median(mesh: skfem.MeshQuad) -> Any:
    return np.median(_lengths(mesh), axis=1)


def _overlaps(mesh: skfem.MeshQuad, regions: Sequence[Region]) -> np.ndarray:
    """Whether each element overlaps the inside of each region, (m, n_elements); those that touch it do not."""
    centres, halves = (np.array([getattr(r, name) for r in regions]).reshape(-1, 2, 1) for name in ("centre", "half_size"))
    corners, slack = mesh.p[:, mesh.t], ONE_PLACE * np.ptp(mesh.p, axis=1)[:, None]
    apart = np.abs(corners.mean(axis=1) - centres) - halves - _lengths(mesh) / 2
    return np.asarray((apart < -slack).all(axis=1))


def _require_room(mesh: skfem.MeshQuad, regions: Sequence[Region], times: np.ndarray) -> None:
    """Refuse elements that would not fit into memory: those that quartering (m, n_elements) times puts into the regions."""
    corners = mesh.p[:, mesh.t]
    shares = np.ones(times.shape)
    for axis, (low, high) in enumerate(zip(corners.min(axis=1), corners.max(axis=1), strict=True)):
        for k, region in enumerate(regions):
            first, last = (region.centre[axis] + sign * region.half_size[axis] for sign in (-1, 1))
            shares[k] *= np.clip(np.minimum(high, last) - np.maximum(low, first), 0.0, None) / (high - low)
    # Of the largest region alone: regions may overlap.
    require_mesh(int((shares * 4.0 ** np.minimum(times, DEEPEST)).sum(axis=1).max(initial=0.0)))


def _check_centre(region: Region, finder: Any) -> None:
    try:
        finder(*np.reshape(region.centre, (2, 1)))
    except ValueError as outside:
        raise InputError(f"region centre {region.centre}: lies outside the mesh; centres must lie on elements, only "
                         "their half sizes may reach over the edge") from outside  # fmt: skip
