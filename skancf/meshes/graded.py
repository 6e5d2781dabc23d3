"""Meshes that are fine in some regions, with smooth transitions."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import skfem

from skancf.arguments import sequence, whole
from skancf.errors import InputError, number, shown
from skancf.memory import require_mesh
from skancf.meshes.counts import shape_for
from skancf.meshes.fineness import Pair, coarse_lengths, fractions, pair
from skancf.meshes.openings import Opening
from skancf.meshes.placing import LARGEST_RATIO, place, place_natural
from skancf.meshes.region import REGION, Region, Regions
from skancf.meshes.sizes import Sizes
from skancf.meshes.tensor import bounded, bounds_of, tensor
from skancf.surfaces import Surface
from skancf.tolerances import ONE_PLACE


def graded(
    surface: Surface,
    regions: Sequence[Region],
    *,
    nodes: int | None = None,
    shape: tuple[int, int] | None = None,
    coarse: float | Pair | None = None,
    finest: float = 0.25,
    growth: float = 1.5,
    transition: float | Pair = 0.0,
    openings: Sequence[Opening] = (),
) -> skfem.MeshQuad:
    r"""Rectangles over ``surface.bounds`` that are small in ``regions`` and grow geometrically to a coarse length.

    In each direction of the parameter plane every region asks for elements of length

    .. math:: l_n = l_0 \max\bigl(\text{finest}, (\sigma_i / \bar\sigma)^{-1/2}\bigr)

    on its interval, ``l_0`` is the coarse length elsewhere, and lengths in between form the geometric progression of
    :func:`progression`, whose factor q is at most ``growth``. Where intervals or transitions overlap, the finer
    length wins; so transitions may meet below the coarse length or end at the boundary. On a sector of an annulus the
    same holds for radii and central angles.

    Give at most one of ``nodes``, ``shape`` and ``coarse``; without any, the coarse length is that of the mesh on which
    the regions were found. With the first two the coarse length, and the fine ones
    with it, are scaled until the count is exact.

    Parameters
    ----------
    surface : BoundedSurface
        Gives bounds, names of sides, and the lengths that tell square cells from slender ones.
    regions : sequence of Region
        None of them: a uniform mesh.
    nodes : int, optional
        Total number of nodes, (nx + 1)(ny + 1); nx : ny is chosen closest to cells of equal coarse length in space.
    shape : (2,) tuple of int, optional
        Number of cells nx, ny.
    coarse : float or (2,) tuple, optional
        Element length l_0 away from the regions, for both or each direction (units of the parameter plane).
    finest : float
        Smallest l_n / l_0, between 0 and 1.
    growth : float
        Largest factor q between neighbouring lengths of a transition, greater than 1 and at most 2.
    transition : float or (2,) tuple
        Smallest length of a transition, for both or each direction (units of the parameter plane); a longer one has
        a gentler q. 0: as short as ``growth`` allows.
    openings : sequence of ((x0, x1), (y0, y1))
        Rectangles left out, as in :func:`uniform`; a region at their corners gives their sides mesh lines.

    Returns
    -------
    skfem.MeshQuad
        A tensor-product mesh whose neighbouring lengths differ by a factor of at most 2. A node lies on the centre of
        each region, unless that would distort cells further or spoil the symmetry of a symmetric set of regions (a
        centre in the middle of an odd number of cells).

    Raises
    ------
    InputError
        For values out of range, a region centred outside the bounds, and a number of nodes that is no product of
        suitable counts (the message names the nearest that are).
    NotEnoughMemory
        For more elements than a system would fit for, before any memory is taken.

    Notes
    -----
    A product of two rows of nodes carries the fineness of a region along whole strips, so it also refines
    where strips of different regions cross.

    References
    ----------
    Research on local mesh refine method based on absolute nodal coordinate formulation, eqs. (7) and (8).

    Examples
    --------
    >>> plate = sk.Rectangle(1.0, 1.0)
    >>> corner = sk.meshes.Region(centre=(0.0, 0.0), half_size=(0.1, 0.1), ratio=4.0)
    >>> mesh = sk.meshes.graded(plate, [corner], shape=(8, 8))
    >>> print(np.unique(mesh.p[0]).round(3))
    [0.    0.073 0.153 0.269 0.415 0.561 0.708 0.854 1.   ]
    """
    regions = sequence("regions", regions, Region, REGION) if not isinstance(regions, Regions) else regions
    if nodes is None and shape is None and coarse is None and isinstance(regions, Regions):
        coarse = regions.cell
    _check_choice(nodes, shape, coarse)
    along_x, along_y = (
        _along(direction, surface, regions, finest=finest, growth=growth, transition=transition) for direction in (0, 1)
    )
    if coarse is not None:
        length_x, length_y = coarse_lengths(coarse, bounds_of(surface))
        require_mesh(max(1, round(along_x.count(length_x))) * max(1, round(along_y.count(length_y))))
        row_x, row_y = place_natural(along_x, length_x), place_natural(along_y, length_y)
    else:
        if nodes is not None:
            require_mesh(whole("nodes", nodes, least=4))
        nx, ny = shape_for(bounded(surface), along_x, along_y, nodes) if nodes is not None else _shape(shape)
        require_mesh(nx * ny)
        row_x, row_y = place(along_x, nx), place(along_y, ny)
    return tensor(surface, row_x, row_y, openings)


def _along(
    direction: int, surface: Surface, regions: Sequence[Region], *, finest: float, growth: float, transition: Any
) -> Sizes:
    """The wanted lengths in one direction."""
    shares = fractions(regions, finest)
    growth = number("growth", growth)
    if not 1 < growth <= LARGEST_RATIO:
        raise InputError(f"growth = {growth}: neighbouring lengths may grow by a factor greater than 1 and at most 2")
    ramp = pair("transition", transition)[direction]
    if ramp < 0:
        raise InputError(f"transition = {transition}: give a length of at least 0 (0: as short as growth allows)")
    low, high = bounds_of(surface)[direction]
    if ramp > high - low:
        raise InputError(f"transition = {ramp} along {'xy'[direction]}: longer than the side L = {high - low} in which "
                         "lengths must go from l_0 to l_n; give a shorter one, or 0 for the shortest")  # fmt: skip
    return Sizes(
        low=low,
        high=high,
        centres=np.array([_inside(region, direction, low, high) for region in regions]),
        half_sizes=np.array([region.half_size[direction] for region in regions], float),
        fractions=shares,
        growth=growth,
        transition=ramp,
    )


def _inside(region: Region, direction: int, low: float, high: float) -> float:
    """A coordinate of the region's centre; the bound itself where it is a rounding error away."""
    at, rounding = region.centre[direction], ONE_PLACE * (high - low)
    if not low - rounding <= at <= high + rounding:
        raise InputError(
            f"region centre {region.centre}: {'xy'[direction]} = {at} lies outside ({low}, {high}); "
            "centres must lie on the surface, only their half sizes may reach over it"
        )
    return low if at <= low + rounding else high if at >= high - rounding else at


def _check_choice(*choices: Any) -> None:
    given = sum(choice is not None for choice in choices)
    if given != 1:
        raise InputError(
            f"{given} of nodes, shape and coarse are given: give one of them "
            "(none only with regions that remember their mesh, as stress_regions returns them)"
        )


def _shape(shape: Any) -> tuple[int, int]:
    try:
        counts = () if isinstance(shape, str | bytes | bytearray | set | dict) else tuple(shape)
    except TypeError:
        counts = ()
    if len(counts) != 2:
        raise InputError(f"shape = {shown(shape)}: give the two numbers of cells (nx, ny)")
    nx, ny = counts
    return whole("nx", nx), whole("ny", ny)
