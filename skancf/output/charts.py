"""Charts of meshes, fields and histories."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import skfem

from skancf.arguments import flag, mapping, sequence, texts
from skancf.atomic import AnyPath
from skancf.errors import vector
from skancf.meshes import Region
from skancf.meshes.region import REGION
from skancf.output.canvas import BAND, INK, contour_colours, draw_curves, new_figure, plane_axes, plane_height, save
from skancf.output.colours import line_style
from skancf.output.curves import Curves, panels_of
from skancf.output.plane import drawable, edge_curves, label_place, region_outline, subdivided, to_plane
from skancf.surfaces import Surface


def mesh_chart(
    mesh: skfem.MeshQuad,
    path: AnyPath,
    surface: Surface | None = None,
    regions: Iterable[Region] = (),
    points: Mapping[str, Any] | None = None,
    title: str | None = None,
) -> Path:
    """Draw a mesh, with the regions in which it is fine.

    Parameters
    ----------
    mesh : skfem.MeshQuad
        In the parameter plane.
    path : str or Path
        ``*.png``, ``*.pdf`` or ``*.svg``.
    surface : Surface, optional
        Where the points of the parameter plane lie in space; x and y are drawn. Default: the parameter plane itself.
    regions : iterable of Region
        Outlined and labelled with their ratios.
    points : mapping from name to (2,) point of the parameter plane, optional
    title : str, optional
        Default: the numbers of elements and nodes.

    Returns
    -------
    Path
    """
    drawable(mesh, surface)
    texts(title=title)
    regions = sequence("regions", regions, Region, REGION)
    if points is not None:
        mapping("points", points, "names and points of the parameter plane, as in points={'tip': (1.0, 0.5)}")
    curves = edge_curves(mesh, surface)
    figure = new_figure(7.5, plane_height(7.5, curves))
    axes = figure.subplots()
    draw_curves(axes, curves, 0.6, INK)
    for k, region in enumerate(regions):
        outline = region_outline(mesh, surface, region)
        axes.fill(*outline, facecolor=BAND, alpha=0.25)
        axes.plot(*outline, color=BAND, linewidth=1.8, label=None if k else "region to refine, with its stress ratio")
        _write_at(axes, label_place(mesh, surface, region), f"{region.ratio:.3g}", (0, 0))
    for name, at in (points or {}).items():
        place = to_plane(surface, vector(f"points[{name!r}]", at, 2))
        axes.plot(*place, "o", color="#0072B2", markersize=7, markeredgecolor="white", zorder=6)
        _write_at(axes, place, name, (8, 8))
    if axes.get_legend_handles_labels()[0]:
        figure.legend(loc="outside lower center", frameon=False)
    axes.set_title(f"{mesh.t.shape[1]} elements, {mesh.p.shape[1]} nodes" if title is None else title)
    plane_axes(axes)
    return save(figure, path)


def field_chart(
    mesh: skfem.MeshQuad,
    values: Any,
    path: AnyPath,
    label: str,
    *,
    surface: Surface | None = None,
    title: str = "",
    limits: tuple[float, float] | None = None,
    levels: int = 14,
    show_mesh: bool = True,
) -> Path:
    """Filled contours of nodal values, bilinear in between.

    Parameters
    ----------
    mesh : skfem.MeshQuad
        In the parameter plane; of a system it is ``system.geometry.mesh``.
    values : (n_nodes,) array
        For example ``solution.nodal_stresses(z="top")[:, 0]``.
    path : str or Path
        ``*.png``, ``*.pdf`` or ``*.svg``.
    label : str
        What the colours mean, with its unit, as in ``"S11, top face (Pa)"``.
    surface : Surface, optional
        See :func:`mesh_chart`.
    title : str
    limits : (2,) tuple, optional
        Smallest and largest value of the colours; values beyond have the colour of the end.
    levels : int
        Number of colours, about.
    show_mesh : bool

    Returns
    -------
    Path
    """
    drawable(mesh, surface)
    texts(label=label, title=title)
    flag("show_mesh", show_mesh)
    curves = edge_curves(mesh, surface)
    figure = new_figure(7.5, plane_height(7.5, curves))
    axes = figure.subplots()
    triangles, fine = subdivided(mesh, values, surface)
    options = contour_colours(fine, limits, levels)
    drawn = axes.tricontourf(triangles, np.clip(fine, options["levels"][0], options["levels"][-1]), **options)
    drawn.set_edgecolor("face")
    figure.colorbar(drawn, ax=axes, label=label, shrink=0.85)
    if show_mesh:
        draw_curves(axes, curves, 0.35, "#404040")
    axes.set_title(title)
    plane_axes(axes)
    return save(figure, path)


def histories_chart(
    times: Any, histories: Mapping[str, Any], path: AnyPath, *, ylabel: str, title: str = "", xlabel: str = "time (s)"
) -> Path:
    """Quantities against time, in one panel or several.

    Parameters
    ----------
    times : (n,) array
        Times (s).
    histories : mapping from label to (n,) array or (times, values)
        A tuple has times of its own, for example those of a reference. Or a mapping from the name of a panel to such a
        mapping.
    path : str or Path
        ``*.png``, ``*.pdf`` or ``*.svg``.
    ylabel : str
        With the unit, as in ``"u3 (m)"``.
    title, xlabel : str

    Returns
    -------
    Path
    """
    texts(ylabel=ylabel, title=title, xlabel=xlabel)
    panels = panels_of(times, histories)
    columns = 1 if len(panels) <= 3 else 2
    rows = -(-len(panels) // columns)
    figure = new_figure(7.5 if columns == 1 else 11, 4.2 if rows == 1 else 2.7 * rows)
    grid = figure.subplots(rows, columns, sharex=True, squeeze=False).ravel()
    for k, axes in enumerate(grid):
        if k >= len(panels):
            axes.remove()
            continue
        name, curves = panels[k]
        _draw_histories(axes, curves)
        axes.set(ylabel=ylabel, title=name)
        if k + columns >= len(panels):
            axes.set_xlabel(xlabel)
            axes.tick_params(labelbottom=True)
    _legend(figure, grid[: len(panels)], panels)
    figure.suptitle(title)
    return save(figure, path)


def _draw_histories(axes: Any, curves: Curves) -> None:
    for k, (label, (x, y)) in enumerate(curves.items()):
        # Few points are data to compare with, seen as points.
        axes.plot(x, y, label=label, marker="o" if len(x) <= 60 else "", markersize=4, **line_style(k))
    axes.grid(True, color="#d0d0d0", linewidth=0.7)
    axes.margins(x=0.01)


def _legend(figure: Any, grid: Sequence[Any], panels: Sequence[tuple[str, Curves]]) -> None:
    """One legend for all panels where they have the same curves, else one for each."""
    if len({tuple(curves) for _, curves in panels}) > 1 or len(panels) == 1:
        for axes in grid:
            axes.legend(frameon=True)
        return
    handles, labels = grid[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=min(len(labels), 4), frameon=False)


def _write_at(axes: Any, place: np.ndarray, text: str, offset: tuple[float, float]) -> None:
    box = {"boxstyle": "round,pad=0.2", "facecolor": "white", "edgecolor": "none", "alpha": 0.85}
    middle = {"ha": "center", "va": "center"} if offset == (0, 0) else {}
    axes.annotate(text, place, xytext=offset, textcoords="offset points", bbox=box, fontsize=10, zorder=5, **middle)
