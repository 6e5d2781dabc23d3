"""Where is the stress concentrated? The search for regions to refine."""

from typing import Any

import numpy as np

from skancf.errors import InputError, finite, number, positive
from skancf.meshes.region import Region
from skancf.tolerances import SAME_VALUE


def find_regions(
    points: Any,
    sigma: Any,
    *,
    spacing: float,
    positions: Any = None,
    cell: float | tuple[float, float] | None = None,
    radius: float = 2.0,
    size: float = 1.0,
    cap: float = 2.0,
) -> tuple[Region, ...]:
    r"""A region about every node whose stress exceeds the mean and is the largest within a sphere about it.

    With :math:`\rho_i = \sigma_i / \bar\sigma` and :math:`\bar\sigma` the mean over all nodes, node i with
    :math:`\rho_i > 1` looks at all nodes within

    .. math:: r_0 = \text{radius} \cdot \text{spacing} \cdot \min(\sqrt{\rho_i}, \text{cap})

    and if none of them has a larger value, the rectangle of half size
    :math:`\text{size} \cdot \text{cell} \cdot \min(\sqrt{\rho_i}, \text{cap})` about it becomes a region. Every node
    looks at its own sphere only, so a low peak may stand within the wider sphere of a higher one. Of equal values (to
    1e-9) the first in order wins, and those within its reach are no regions of their own.

    Parameters
    ----------
    points : (2, n) array
        Nodes in the parameter plane.
    sigma : (n,) array
        The measure of stress at the nodes, at least 0 (any unit).
    spacing : float
        Distance of neighbouring nodes, in the unit of ``positions``.
    positions : (3, n) array, optional
        Nodes in space, where the sphere lies. Default: ``points``.
    cell : float or (2,) tuple, optional
        Element lengths in the parameter plane. Default: ``spacing``.
    radius, size : float
        Of the sphere in spacings, and half the region's in elements, at :math:`\rho_i = 1`.
    cap : float
        Largest factor by which concentration enlarges them, at least 1.

    Returns
    -------
    tuple of Region
        In the order of the nodes; empty for a constant or zero ``sigma``.

    Raises
    ------
    InputError
        For values that are not finite, a negative ``sigma``, shapes that do not fit, and sizes that are not positive.

    References
    ----------
    Research on local mesh refine method based on absolute nodal coordinate formulation, "The searching of refinement
    region", with the square root as its positive correlation.

    Examples
    --------
    >>> points = np.array(np.meshgrid(np.linspace(0, 1, 11), np.linspace(0, 1, 11))).reshape(2, -1)
    >>> sigma = 1.0 + 9.0 * np.exp(-50 * ((points - 0.5) ** 2).sum(axis=0))
    >>> regions = sk.find_regions(points, sigma, spacing=0.1)
    >>> print([tuple(np.round(region.centre, 2).tolist()) for region in regions])
    [(0.5, 0.5)]
    """
    points, sigma, positions = _check_nodes(points, sigma, positions)
    reach = positive("radius", radius) * positive("spacing", spacing)
    cell_x, cell_y = _check_cell(spacing if cell is None else cell)
    half = positive("size", size)
    if not number("cap", cap) >= 1:
        raise InputError(f"cap = {cap}: give a factor of at least 1")
    mean = sigma.mean()
    factor = np.minimum(np.sqrt(sigma / mean), cap) if mean > 0 else np.ones_like(sigma)
    return tuple(
        Region(
            centre=(float(points[0, i]), float(points[1, i])),
            half_size=(float(half * cell_x * factor[i]), float(half * cell_y * factor[i])),
            ratio=float(sigma[i] / mean),
            value=float(sigma[i]),
        )
        for i in find_peaks(positions, sigma, reach * factor)
    )


def find_peaks(positions: np.ndarray, sigma: np.ndarray, reach: np.ndarray) -> list[int]:
    """Nodes above the mean whose value is the largest within their ``reach``: (d, n), (n,), (n,) -> indices."""
    from scipy.spatial import cKDTree  # not at the top: it is slow to load

    above = np.flatnonzero(sigma > sigma.mean() * (1 + SAME_VALUE))
    around = cKDTree(positions.T).query_ball_point(positions[:, above].T, reach[above] * (1 + SAME_VALUE))
    is_peak = np.zeros(sigma.size, bool)
    for i, others in zip(above, around, strict=True):
        larger = sigma[others] > sigma[i] * (1 + SAME_VALUE)
        # On a plateau (of equals) that already has a peak within reach, no second one.
        equal_peak = is_peak[others] & (sigma[others] >= sigma[i] * (1 - SAME_VALUE))
        is_peak[i] = not (larger.any() or equal_peak.any())
    return [int(i) for i in np.flatnonzero(is_peak)]


def _check_nodes(points: Any, sigma: Any, positions: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    points, sigma = finite("points", points), finite("sigma", sigma)
    if points.ndim != 2 or points.shape[0] != 2 or points.shape[1] == 0:
        raise InputError(f"points has shape {points.shape}: give nodes of the parameter plane as an array (2, n)")
    if sigma.shape != points.shape[1:]:
        raise InputError(f"sigma has shape {sigma.shape}: give one value for each of the {points.shape[1]} nodes")
    if (sigma < 0).any():
        worst = int(np.argmin(sigma))
        raise InputError(
            f"sigma[{worst}] = {sigma[worst]}: the measure of stress must not be negative; take absolute values"
        )
    positions = points if positions is None else finite("positions", positions)
    if positions.ndim != 2 or positions.shape[1] != sigma.size:
        raise InputError(f"positions has shape {positions.shape}: give the {sigma.size} nodes in space as (3, n)")
    return points, sigma, positions


def _check_cell(cell: Any) -> tuple[float, float]:
    lengths = finite("cell", cell)
    if lengths.shape not in ((), (2,)) or not (lengths > 0).all():
        raise InputError(f"cell = {cell}: give one element length greater than zero, or one for each direction")
    x, y = np.broadcast_to(lengths, 2).tolist()
    return x, y
