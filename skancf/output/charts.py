"""Charts of meshes, fields and histories."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import skfem

from skancf.arguments import flag, mapping, sequence, texts
from skancf.atomic import AnyPath
from skancf.errors import InputError, vector
from skancf.meshes import Region
from skancf.meshes.region import REGION
from skancf.output.canvas import (
    BAND,
    INK,
    contour_colours,
    done,
    draw_curves,
    figure_for,
    legend,
    panel,
    plane_axes,
    plane_height,
)
from skancf.output.colours import line_style
from skancf.output.curves import Curves, panels_of
from skancf.output.plane import drawable, edge_curves, label_place, region_outline, subdivided, to_plane
from skancf.surfaces import Surface


def mesh_chart(
    mesh: skfem.MeshQuad,
    path: AnyPath | None = None,
    surface: Surface | None = None,
    regions: Iterable[Region] = (),
    points: Mapping[str, Any] | None = None,
    title: str | None = None,
    *,
    ax: Any = None,
) -> Any:
    """Draw a mesh, with the regions in which it is fine.

    Parameters
    ----------
    mesh : skfem.MeshQuad
        In the parameter plane.
    path : str or Path, optional
        ``*.png``, ``*.pdf`` or ``*.svg``. Default: no file, and the axes are returned to draw on.
    surface : Surface, optional
        Where the points of the parameter plane lie in space; x and y are drawn. Default: the parameter plane itself.
    regions : iterable of Region
        Outlined and labelled with their ratios.
    points : mapping from name to (2,) point of the parameter plane, optional
    title : str, optional
        Default: the numbers of elements and nodes.
    ax : matplotlib axes, optional
        Draw on these. Default: on those of a new figure.

    Returns
    -------
    Path, or without a path the matplotlib axes

    Examples
    --------
    >>> mesh = sk.meshes.uniform(sk.Rectangle(2.0, 1.0), 8, 4)
    >>> axes = sk.output.mesh_chart(mesh, title="A coarse mesh")
    """
    drawable(mesh, surface)
    texts(title=title)
    regions = sequence("regions", regions, Region, REGION)
    if points is not None:
        mapping("points", points, "names and points of the parameter plane, as in points={'tip': (1.0, 0.5)}")
    curves = edge_curves(mesh, surface)
    axes = panel(ax, path, 7.5, plane_height(7.5, curves))
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
        legend(axes, ax)
    axes.set_title(f"{mesh.t.shape[1]} elements, {mesh.p.shape[1]} nodes" if title is None else title)
    plane_axes(axes)
    return done(axes, path)


def field_chart(
    mesh: skfem.MeshQuad,
    values: Any,
    path: AnyPath | None = None,
    label: str = "",
    *,
    surface: Surface | None = None,
    title: str = "",
    limits: tuple[float, float] | None = None,
    levels: int = 14,
    show_mesh: bool = True,
    ax: Any = None,
) -> Any:
    """Filled contours of nodal values, bilinear in between.

    Parameters
    ----------
    mesh : skfem.MeshQuad
        In the parameter plane; of a system it is ``system.geometry.mesh``.
    values : (n_nodes,) array
        For example ``solution.nodal_stresses(z="top")[:, 0]``.
    path : str or Path, optional
        ``*.png``, ``*.pdf`` or ``*.svg``. Default: no file, and the axes are returned to draw on.
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
    ax : matplotlib axes, optional
        Draw on these. Default: on those of a new figure.

    Returns
    -------
    Path, or without a path the matplotlib axes

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> system = plate.on(sk.meshes.uniform(plate.surface, 6, 6), "kirchhoff")
    >>> deflection = sk.solve_linear(system).displacements[2]
    >>> axes = sk.output.field_chart(system.mesh, deflection, label="w (m)")
    """
    drawable(mesh, surface)
    texts(label=label, title=title)
    flag("show_mesh", show_mesh)
    curves = edge_curves(mesh, surface)
    axes = panel(ax, path, 7.5, plane_height(7.5, curves))
    triangles, fine = subdivided(mesh, values, surface)
    options = contour_colours(fine, limits, levels)
    drawn = axes.tricontourf(triangles, np.clip(fine, options["levels"][0], options["levels"][-1]), **options)
    drawn.set_edgecolor("face")
    axes.figure.colorbar(drawn, ax=axes, label=label, shrink=0.85)
    if show_mesh:
        draw_curves(axes, curves, 0.35, "#404040")
    axes.set_title(title)
    plane_axes(axes)
    return done(axes, path)


def histories_chart(
    times: Any,
    histories: Mapping[str, Any],
    path: AnyPath | None = None,
    *,
    ylabel: str,
    title: str = "",
    xlabel: str = "time (s)",
    ax: Any = None,
) -> Any:
    """Quantities against time, in one panel or several.

    Parameters
    ----------
    times : (n,) array
        Times (s).
    histories : mapping from label to (n,) array or (times, values)
        A tuple has times of its own, for example those of a reference. Or a mapping from the name of a panel to such a
        mapping.
    path : str or Path, optional
        ``*.png``, ``*.pdf`` or ``*.svg``. Default: no file, and the axes are returned to draw on.
    ylabel : str
        With the unit, as in ``"u3 (m)"``.
    title, xlabel : str
    ax : matplotlib axes, optional
        Draw on these, one panel only. Default: on those of a new figure.

    Returns
    -------
    Path, or without a path the matplotlib axes, of several panels an array of them

    Examples
    --------
    >>> times = np.linspace(0.0, 1.0, 101)
    >>> axes = sk.output.histories_chart(times, {"tip": np.sin(9.0 * times)}, ylabel="deflection (m)")
    """
    texts(ylabel=ylabel, title=title, xlabel=xlabel)
    panels = panels_of(times, histories)
    if ax is not None and len(panels) > 1:
        raise InputError(f"ax: one panel, but histories has {len(panels)}; leave ax out, or draw each on axes of its own")
    columns = 1 if len(panels) <= 3 else 2
    rows = -(-len(panels) // columns)
    size = 7.5 if columns == 1 else 11, 4.2 if rows == 1 else 2.7 * rows
    if len(panels) == 1:
        axes = panel(ax, path, *size)
        _draw_histories(axes, panels[0][1])
        axes.set(ylabel=ylabel, title=panels[0][0] or title, xlabel=xlabel)
        axes.legend(frameon=True)
        return done(axes, path)
    figure = figure_for(path, *size)
    every = figure.subplots(rows, columns, sharex=True, squeeze=False).ravel()
    for unused in every[len(panels) :]:
        unused.remove()
    grid = every[: len(panels)]
    for k, (axes, (name, curves)) in enumerate(zip(grid, panels, strict=True)):
        _draw_histories(axes, curves)
        axes.set(ylabel=ylabel, title=name)
        if k + columns >= len(panels):
            axes.set_xlabel(xlabel)
            axes.tick_params(labelbottom=True)
    _legend(figure, grid, panels)
    figure.suptitle(title)
    return done(grid, path)


def _draw_histories(axes: Any, curves: Curves) -> None:
    for k, (label, (x, y)) in enumerate(curves.items()):
        # Few points are data to compare with, seen as points.
        axes.plot(x, y, label=label, marker="o" if len(x) <= 60 else "", markersize=4, **line_style(k))
    axes.grid(True, color="#d0d0d0", linewidth=0.7)
    axes.margins(x=0.01)


def _legend(figure: Any, grid: Sequence[Any], panels: Sequence[tuple[str, Curves]]) -> None:
    """One legend for all panels where they have the same curves, else one for each."""
    if len({tuple(curves) for _, curves in panels}) > 1:
        for axes in grid:
            axes.legend(frameon=True)
        return
    handles, labels = grid[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=min(len(labels), 4), frameon=False)


def _write_at(axes: Any, place: np.ndarray, text: str, offset: tuple[float, float]) -> None:
    box = {"boxstyle": "round,pad=0.2", "facecolor": "white", "edgecolor": "none", "alpha": 0.85}
    middle = {"ha": "center", "va": "center"} if offset == (0, 0) else {}
    axes.annotate(text, place, xytext=offset, textcoords="offset points", bbox=box, fontsize=10, zorder=5, **middle)
