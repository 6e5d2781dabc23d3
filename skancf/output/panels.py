"""Surfaces in three-dimensional panels of matplotlib, for figures that hold more than one state."""

from typing import Any

import numpy as np

from skancf.arguments import having
from skancf.errors import InputError, finite, unit_vector, vector


def draw_cells(
    axes: Any,
    cells: Any,
    colours: Any,
    *,
    light: tuple[float, float, float] = (0.5, -0.4, 0.77),
    stretch: tuple[float, float, float] = (1.0, 1.0, 1.0),
) -> Any:
    """Draw quadrilaterals in a panel, shaded by how they face the light.

    Parameters
    ----------
    axes : matplotlib 3D axes
    cells : (m, 4, 3) array
        Corners, for example ``samples.points[samples.cells]`` of :func:`~skancf.output.sample`.
    colours : (m, 3 or 4) array
        Red, green, blue (and opacity) of each cell, from 0 to 1, for example of a colour map of matplotlib.
    light : (3,) tuple
        Direction from the surface to the light.
    stretch : (3,) tuple
        Factors of x, y and z with which the panel is drawn, so that the shades fit to what is seen.

    Returns
    -------
    matplotlib collection

    Examples
    --------
    >>> import matplotlib.pyplot as plt
    >>> figure, axes = plt.subplots(subplot_kw={"projection": "3d"})
    >>> square = np.array([[[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]], float)
    >>> cells = sk.output.draw_cells(axes, square, np.array([[0.2, 0.4, 0.8, 1.0]]))
    >>> plt.close(figure)
    """
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    having("axes", axes, ("add_collection3d", "set_axis_off"), "axes of matplotlib with projection='3d'")
    corners, shades = finite("cells", cells), finite("colours", colours).copy()
    if corners.ndim != 3 or corners.shape[1:] != (4, 3) or shades.shape not in [(len(corners), 3), (len(corners), 4)]:
        raise InputError(f"cells of shape {corners.shape} with colours of shape {shades.shape}: give (m, 4, 3) corners and "
                         "a colour for each")  # fmt: skip
    seen = corners * vector("stretch", stretch, 3)
    normals = np.cross(seen[:, 2] - seen[:, 0], seen[:, 3] - seen[:, 1])
    unit = unit_vector("light", light)
    sizes = np.linalg.norm(normals, axis=1)
    facing = np.abs(normals @ unit) / np.where(sizes > 0, sizes, 1.0)
    shades[:, :3] *= (0.65 + 0.35 * facing)[:, None]
    drawn = Poly3DCollection(corners, facecolors=shades, edgecolors=shades, linewidths=0.4, clip_on=False)
    axes.add_collection3d(drawn)
    axes.set_axis_off()
    return drawn
