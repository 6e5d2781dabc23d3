"""Charts of adaptivity: meshes from level to level, errors against cost, estimates against errors."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import skfem

from skancf.arguments import row, sequence, texts
from skancf.atomic import AnyPath
from skancf.errors import InputError, finite, number, vector
from skancf.output.canvas import BAND, INK, done, draw_curves, figure_for, legend, panel, plane_axes, require_axes
from skancf.output.colours import colour_map, marked_style
from skancf.output.curves import Curves, curves_of
from skancf.output.plane import cell_outlines, drawable, edge_curves, to_plane
from skancf.surfaces import Surface

PANEL, PER_ROW = 2.9, 4
"""Width of a panel (inches), and how many stand side by side."""
# Markers on more would hide the mesh.
FEW_ELEMENTS = 400
DECADES = 6
"""Shown of values; indicators that vanish but for rounding have the lowest colour."""


def mesh_levels(
    meshes: Sequence[skfem.MeshQuad],
    path: AnyPath | None = None,
    *,
    surface: Surface | None = None,
    titles: Sequence[str] | None = None,
    values: Sequence[Any] | None = None,
    label: str = "indicator",
    ax: Any = None,
) -> Any:
    """Meshes side by side, with elements coloured by their level, or by values of their own on a logarithmic scale.

    The colours mean the same in all panels. On meshes of few elements the hanging nodes are marked.

    Parameters
    ----------
    meshes : sequence of skfem.MeshQuad
        In the parameter plane. Elements of meshes without levels have level 0.
    path : str or Path, optional
        ``*.png``, ``*.pdf`` or ``*.svg``. Default: no file, and the axes are returned to draw on.
    surface : Surface, optional
        Where the points of the parameter plane lie in space; x and y are drawn. Default: the parameter plane itself.
    titles : sequence of str, optional
        One for each mesh. Default: the numbers of elements and nodes.
    values : sequence of (n_elements,) arrays, optional
        For each mesh at least 0, for example squared errors of :func:`skancf.recovery_indicator`. The colours span six
        decades at most.
    label : str
        What the values mean, with their unit.
    ax : sequence of matplotlib axes, optional
        Draw on these, one for each mesh. Default: on those of a new figure.

    Returns
    -------
    Path, or without a path an array of matplotlib axes

    Raises
    ------
    InputError
        Without meshes, for another number of titles or values, and for values that are negative or all zero.

    Examples
    --------
    >>> plate = sk.Rectangle(1.0, 1.0)
    >>> tree = sk.meshes.quadtree(sk.meshes.uniform(plate, 2, 2), plate)
    >>> panels = sk.output.mesh_levels([tree, tree.refined([0])])
    """
    from matplotlib.cm import ScalarMappable

    texts(label=label)
    meshes = sequence("meshes", meshes, skfem.MeshQuad, "meshes, as in [level.mesh for level in result.levels]")
    for mesh in meshes:
        drawable(mesh, surface)
    if not meshes:
        raise InputError("meshes: the sequence is empty; give at least one")
    if titles is None:
        titles = [f"{mesh.t.shape[1]} elements, {mesh.p.shape[1]} nodes" for mesh in meshes]
    titles = sequence("titles", titles, str, "texts")
    _check_number("titles", titles, meshes)
    if values is None:
        shown, colours = _levels(meshes)
        bar = {"label": "level", "ticks": np.unique(np.concatenate(shown))}
    else:
        if not isinstance(values, Sequence | np.ndarray) or isinstance(values, str | bytes):
            raise InputError(f"values: a {type(values).__name__}; give a list of arrays, one for each mesh")
        _check_number("values", values, meshes)
        shown, colours = _logarithmic(meshes, values)
        bar = {"label": label}
    edges = [edge_curves(mesh, surface) for mesh in meshes]
    grid = _level_panels(edges, path) if ax is None else _given_panels(ax, meshes)
    for axes, mesh, curves, title, colouring in zip(grid, meshes, edges, titles, shown, strict=True):
        _draw_cells(axes, cell_outlines(mesh, surface), colouring, colours)
        draw_curves(axes, curves, float(np.clip(8 / np.sqrt(mesh.t.shape[1]), 0.15, 0.7)), INK)
        _mark_hanging(axes, mesh, surface)
        axes.set_title(title, fontsize=10)
        plane_axes(axes)
        axes.locator_params(nbins=5)
    figure = grid[0].figure
    figure.colorbar(ScalarMappable(**colours), ax=list(grid), shrink=0.85, **bar)
    marked = [axes for axes in grid if axes.get_legend_handles_labels()[0]]
    if ax is None:
        _outer_labels(grid)
        if marked:
            figure.legend(handles=marked[0].get_legend_handles_labels()[0], loc="outside lower center", frameon=False)
    elif marked:
        marked[0].legend(frameon=True)
    return done(grid, path)


def _level_panels(edges: Sequence[np.ndarray], path: AnyPath | None) -> np.ndarray:
    """Axes of a new figure, one for each mesh, that have the shape of the meshes."""
    rows = -(-len(edges) // PER_ROW)
    columns = -(-len(edges) // rows)
    across, up = np.ptp(np.concatenate(edges).reshape(-1, 2), axis=0)
    figure = figure_for(path, PANEL * columns + 1.5, max(rows * (PANEL * up / across + 0.5) + 0.7, 2.5))
    # Panels to scale do not fill their places.
    figure.set_layout_engine("compressed")
    grid = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False).ravel()
    for unused in grid[len(edges) :]:
        unused.remove()
    return np.asarray(grid[: len(edges)])


def _given_panels(ax: Any, meshes: Sequence[skfem.MeshQuad]) -> np.ndarray:
    grid = np.array(ax if isinstance(ax, Sequence | np.ndarray) else [ax], dtype=object).ravel()
    if len(grid) != len(meshes):
        raise InputError(f"ax: {len(grid)} for {len(meshes)} meshes; give one for each")
    for axes in grid:
        require_axes(axes)
    return grid


def _outer_labels(grid: np.ndarray) -> None:
    """Labels at the left of each row and below the last mesh of each column."""
    columns = len({axes.get_subplotspec().colspan.start for axes in grid})
    for k, axes in enumerate(grid):
        axes.label_outer()
        if k + columns >= len(grid):
            axes.set_xlabel("x (m)")
            axes.tick_params(labelbottom=True)


def convergence(
    curves: Mapping[str, tuple[Any, Any]],
    path: AnyPath | None = None,
    *,
    xlabel: str = "degrees of freedom",
    ylabel: str = "relative error",
    slopes: Sequence[float] | None = None,
    title: str = "",
    ax: Any = None,
) -> Any:
    """Errors against degrees of freedom, or seconds, on logarithmic axes.

    Parameters
    ----------
    curves : mapping from label to (x, error)
        Errors that are not positive cannot be drawn and are left out.
    path : str or Path, optional
        ``*.png``, ``*.pdf`` or ``*.svg``. Default: no file, and the axes are returned to draw on.
    xlabel, ylabel : str
    slopes : sequence of float, optional
        Triangles of these slopes are drawn to compare with, as in ``(-1, -2)``: the steeper ones below the curves, the
        others above.
    title : str
    ax : matplotlib axes, optional
        Draw on these. Default: on those of a new figure.

    Returns
    -------
    Path, or without a path the matplotlib axes

    Raises
    ------
    InputError
        For curves of two lengths, for curves without a positive value, and for a slope of zero.

    Examples
    --------
    >>> axes = sk.output.convergence({"uniform": ([100, 400, 1600], [1e-2, 2.5e-3, 6e-4])}, slopes=[1.0])
    """
    texts(xlabel=xlabel, ylabel=ylabel, title=title)
    triangles: list[float] = [] if slopes is None else row("slopes", slopes).tolist()
    given = curves_of(curves)
    keep = {text: (x > 0) & (error > 0) for text, (x, error) in given.items()}
    drawn = {text: (x[keep[text]], error[keep[text]]) for text, (x, error) in given.items() if keep[text].any()}
    if not drawn:
        raise InputError("curves: no positive values to draw on logarithmic axes; give at least one error above zero")
    axes = panel(ax, path, 7.0, 5.0)
    axes.set(xscale="log", yscale="log", xlabel=xlabel, ylabel=ylabel, title=title)
    _draw_triangles(axes, list(drawn.values()), triangles)
    _draw_marked(axes, drawn)
    _legend_below(axes, ax)
    return done(axes, path)


def effectivity(
    curves: Mapping[str, tuple[Any, Any]],
    path: AnyPath | None = None,
    *,
    band: tuple[float, float] = (0.9, 1.1),
    xlabel: str = "degrees of freedom",
    title: str = "",
    ax: Any = None,
) -> Any:
    """How right an estimate is: estimated over true errors, which shall come to lie in a band about 1.

    The scale of the ratio is logarithmic where the ratios and the band span more than a factor of 10 and none is negative.

    Parameters
    ----------
    curves : mapping from label to (x, ratio)
        Degrees of freedom and the estimate over the true error.
    path : str or Path, optional
        ``*.png``, ``*.pdf`` or ``*.svg``. Default: no file, and the axes are returned to draw on.
    band : (2,) tuple
        Ratios between which an estimate is good; shaded.
    xlabel, title : str
    ax : matplotlib axes, optional
        Draw on these. Default: on those of a new figure.

    Returns
    -------
    Path, or without a path the matplotlib axes

    Raises
    ------
    InputError
        For curves of two lengths, x that is not positive, no curves at all, and a band that does not hold 1.

    Examples
    --------
    >>> axes = sk.output.effectivity({"goal": ([100, 400, 1600], [0.93, 0.98, 1.01])})
    """
    texts(xlabel=xlabel, title=title)
    low, high = vector("band", band, 2).tolist()
    if not 0 < low <= 1 <= high:
        raise InputError(f"band = {band}: give a smaller and a larger ratio about 1, both greater than zero")
    drawn = curves_of(curves)
    if not drawn:
        raise InputError("curves: the sequence is empty; give at least one")
    for text, (x, _) in drawn.items():
        if not (x > 0).all():
            raise InputError(f"{text!r}: x = {x.min()} cannot be drawn on a logarithmic axis; give numbers above zero")
    ratios = np.concatenate([ratio for _, ratio in drawn.values()])
    axes = panel(ax, path, 7.0, 4.5)
    axes.axhline(1.0, color=INK, linewidth=1.0)
    axes.set(xscale="log", xlabel=xlabel, ylabel="estimated error / true error", title=title)
    if ratios.min() > 0 and max(ratios.max(), high) > 10 * min(ratios.min(), low):
        axes.set_yscale("log")
        axes.yaxis.set_major_formatter("{x:g}")
    _draw_marked(axes, drawn)
    axes.axhspan(low, high, color="#b0b0b0", alpha=0.35, linewidth=0, label=f"{low:g} to {high:g}")
    _legend_below(axes, ax)
    return done(axes, path)


def _check_number(name: str, given: Sequence[Any], meshes: Sequence[skfem.MeshQuad]) -> None:
    if getattr(given, "shape", None) == ():
        raise InputError(f"{name} = {given!r}: give a list, one for each mesh")
    if len(given) != len(meshes):
        raise InputError(f"{name}: {len(given)} for {len(meshes)} meshes; give one for each")


def _levels(meshes: Sequence[skfem.MeshQuad]) -> tuple[list[np.ndarray], dict[str, Any]]:
    """Levels of the elements of each mesh, and their colours."""
    from matplotlib import colormaps
    from matplotlib.colors import BoundaryNorm, ListedColormap

    levels = [np.asarray(getattr(mesh, "levels", np.zeros(mesh.t.shape[1], dtype=int))) for mesh in meshes]
    low, high = min(part.min() for part in levels), max(part.max() for part in levels)
    # Light, so that the edges of all levels are seen.
    colours = ListedColormap(colormaps["YlGnBu"](np.linspace(0.05, 0.65, high - low + 1)))
    return levels, {"norm": BoundaryNorm(np.arange(low, high + 2) - 0.5, colours.N), "cmap": colours}


def _logarithmic(meshes: Sequence[skfem.MeshQuad], values: Sequence[Any]) -> tuple[list[np.ndarray], dict[str, Any]]:
    """Values of the elements of each mesh, those out of range at its end, and their colours."""
    from matplotlib.colors import LogNorm

    fields = [finite(f"values[{k}]", part) for k, part in enumerate(values)]
    for k, (field, mesh) in enumerate(zip(fields, meshes, strict=True)):
        if field.shape != mesh.t.shape[1:]:
            raise InputError(f"values[{k}] has shape {field.shape}: give one for each of the {mesh.t.shape[1]} elements")
        if (field < 0).any():
            raise InputError(f"values[{k}] has {field.min()}: negative values have no place on a logarithmic scale")
    every = np.concatenate(fields)
    if not every.any():
        raise InputError("values: all are zero, and have no place on a logarithmic scale; give at least one above zero")
    low = max(every[every > 0].min(), every.max() * 10.0**-DECADES)
    # A constant is a colour in the middle.
    apart = 2.0 if low == every.max() else 1.0
    norm = LogNorm(low / apart, every.max() * apart)
    return [np.maximum(field, low) for field in fields], {"norm": norm, "cmap": colour_map(0, 1)}


def _draw_cells(axes: Any, outlines: np.ndarray, values: np.ndarray, colours: dict[str, Any]) -> None:
    from matplotlib.collections import PolyCollection

    axes.add_collection(PolyCollection(list(outlines), array=values, edgecolors="face", linewidths=0.2, **colours))


def _mark_hanging(axes: Any, mesh: skfem.MeshQuad, surface: Surface | None) -> None:
    hanging = getattr(mesh, "hanging", np.empty(0, dtype=int))
    if hanging.size and mesh.t.shape[1] <= FEW_ELEMENTS:
        places = to_plane(surface, mesh.p[:, hanging])
        size = float(np.clip(32 / np.sqrt(mesh.t.shape[1]), 2.0, 4.5))
        axes.plot(*places, "o", color=BAND, markersize=size, markeredgecolor="white", markeredgewidth=size / 7, zorder=5,
                  label="hanging node")  # fmt: skip


def _draw_marked(axes: Any, curves: Curves) -> None:
    """Curves with markers, and a grid."""
    for k, (label, (x, y)) in enumerate(curves.items()):
        axes.plot(x, y, label=label, **marked_style(k))
    axes.grid(True, which="major", color="#d0d0d0", linewidth=0.7)


def _legend_below(axes: Any, given: Any) -> None:
    entries = len(axes.get_legend_handles_labels()[0])
    # Long enough for every pattern of a line.
    columns = 2 if entries == 4 else min(3, entries)
    legend(axes, given, ncols=columns, handlelength=3.2)


def _draw_triangles(axes: Any, drawn: Sequence[tuple[np.ndarray, np.ndarray]], slopes: Sequence[float]) -> None:
    """Right triangles next to the curves, the steeper half of the slopes below them."""
    steep_first = sorted(number("slopes", slope) for slope in slopes)
    if 0 in steep_first:
        raise InputError("slopes: a slope of 0 makes no triangle; leave it out")
    logarithms = [np.log(pair)[:, np.argsort(pair[0])] for pair in drawn]
    every = np.concatenate(logarithms, axis=1)
    (start, bottom), (end, top) = every.min(axis=1), every.max(axis=1)
    if start == end:
        return
    width, gap = 0.2 * (end - start), 0.05 * (top - bottom) or 0.1
    half = (len(steep_first) + 1) // 2
    for side, group in ((-1, steep_first[:half]), (1, steep_first[half:])):
        for k, slope in enumerate(group):
            middle = start + (end - start) * (k + 1) / (len(group) + 1)
            x = np.linspace(middle - width / 2, middle + width / 2, 50)
            # How far each curve is above the line, the more the farther on its side.
            above = np.array([np.interp(x, *points) - slope * (x - x[0]) for points in logarithms])
            height = side * ((side * above).max() + gap)
            _draw_triangle(axes, x[[0, -1]], height + slope * (x[[0, -1]] - x[0]), slope, side)


def _draw_triangle(axes: Any, x: np.ndarray, y: np.ndarray, slope: float, side: int) -> None:
    """Between two points and the corner away from the curves; coordinates are logarithms."""
    first = slope * side > 0
    corner = (x[0] if first else x[1]), (y.max() if side > 0 else y.min())
    rim = np.exp(np.array([[x[0], y[0]], [x[1], y[1]], corner])).T
    axes.fill(*rim, facecolor="#ececec", edgecolor="#606060", linewidth=1.0)
    axes.annotate(f"slope {slope:g}", np.exp((corner[0], y.mean())), xytext=(-5 if first else 5, 0),
                  textcoords="offset points", color="#404040", ha="right" if first else "left", va="center")  # fmt: skip
