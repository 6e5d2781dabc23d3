"""What all charts share: figures, colours, saving."""

from pathlib import Path
from typing import Any

import numpy as np

from skancf.arguments import having, whole
from skancf.atomic import AnyPath, check_file, replacing
from skancf.errors import InputError, vector
from skancf.output.colours import colour_limits, colour_map

INK, BAND = "#303030", "#D55E00"


def new_figure(width: float, height: float) -> Any:
    """A figure (inches) that belongs to no window."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), dpi=150, layout="constrained")


AXES = "axes of matplotlib, as in figure, axes = plt.subplots()"


def panel(ax: Any, path: AnyPath | None, width: float, height: float) -> Any:
    """Axes to draw on: the given ones, or those of a new figure (inches)."""
    if ax is None:
        return figure_for(path, width, height).subplots()
    return require_axes(ax)


def require_axes(ax: Any) -> Any:
    """InputError for what is no axes."""
    having("ax", ax, ("add_collection", "annotate", "set_title"), AXES)
    return ax


def figure_for(path: AnyPath | None, width: float, height: float) -> Any:
    """A new figure: one of pyplot, which shows it, where it goes to no file."""
    if path is not None:
        return new_figure(width, height)
    from matplotlib import pyplot

    return pyplot.figure(figsize=(width, height), layout="constrained")


def legend(axes: Any, given: Any, **options: Any) -> None:
    """Below the axes of a figure of our own; within given axes, whose figure is the user's."""
    if given is None:
        axes.figure.legend(loc="outside lower center", frameon=False, **options)
    else:
        axes.legend(frameon=True)


def done(axes: Any, path: AnyPath | None) -> Any:
    """The file in which the figure of axes, or of an array of axes, is now; without a path the axes."""
    if path is None:
        return axes
    first = axes.flat[0] if isinstance(axes, np.ndarray) else axes
    # The whole figure, also of axes in a part of it.
    return save(first.figure.canvas.figure, path)


def save(figure: Any, path: AnyPath) -> Path:
    """Write a figure, whole or not at all."""
    file = check_file(path, ".png", ".pdf", ".svg")
    with replacing(file) as part:
        figure.savefig(part, bbox_inches="tight", pad_inches=0.1)
    return file


def contour_colours(values: np.ndarray, limits: tuple[float, float] | None, levels: int) -> dict[str, Any]:
    """About the asked number of levels between limits, and their colours."""
    from matplotlib.ticker import MaxNLocator

    levels = whole("levels", levels, most=1000)
    if limits is None:
        low, high = colour_limits(float(values.min()), float(values.max()))
    else:
        low, high = vector("limits", limits, 2).tolist()
        if not low < high:
            raise InputError(f"limits = {limits}: give the smaller value first")
    return {"levels": MaxNLocator(levels).tick_values(low, high), "cmap": colour_map(low, high)}


def draw_curves(axes: Any, curves: Any, width: float, colour: str) -> None:
    """Polylines (m, n, 2)."""
    from matplotlib.collections import LineCollection

    axes.add_collection(LineCollection(list(curves), colors=colour, linewidths=width))
    axes.autoscale_view()


def plane_axes(axes: Any) -> None:
    """Both directions to the same scale, in metres."""
    axes.set(aspect="equal", xlabel="x (m)", ylabel="y (m)")
    axes.margins(0.05)


def plane_height(width: float, curves: np.ndarray) -> float:
    """Height (inches) of a panel of this width for curves (m, n, 2) drawn to scale, with room for titles."""
    across, up = np.ptp(curves.reshape(-1, 2), axis=0)
    return float(np.clip((width - 1.5) * up / across + 1.2, 2.4, 9.0))
