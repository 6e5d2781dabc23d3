"""What all charts share: figures, colours, saving."""

from pathlib import Path
from typing import Any

import numpy as np

from skancf.arguments import whole
from skancf.atomic import AnyPath, check_file, replacing
from skancf.errors import InputError, vector
from skancf.output.colours import colour_limits, colour_map

INK, BAND = "#303030", "#D55E00"


def new_figure(width: float, height: float) -> Any:
    """A figure (inches) that belongs to no window."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), dpi=150, layout="constrained")


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
