"""Colours that mean the same to colour-blind readers, in pictures and in charts."""

from typing import Any

import numpy as np

from skancf.tolerances import SAME_VALUE

# The colours of Okabe and Ito; line patterns differ besides.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
PATTERNS = ("-", "--", "-.", (0, (1, 1)), (0, (5, 1, 1, 1, 1, 1)))


def line_style(k: int) -> dict[str, Any]:
    """Colour and pattern of the k-th line."""
    return {"color": COLOURS[k % len(COLOURS)], "linestyle": PATTERNS[k % len(PATTERNS)], "linewidth": 1.8}


def marked_style(k: int) -> dict[str, Any]:
    """The same with markers."""
    return {**line_style(k), "marker": "osD^v<>"[k % 7], "markersize": 6}


def two_signs(low: float, high: float) -> bool:
    """Whether both signs matter: neither end is below a twentieth of the other."""
    return low < 0 < high and min(-low, high) > 0.05 * max(-low, high)


def colour_limits(low: float, high: float) -> tuple[float, float]:
    """Limits for a field: symmetric about zero where both signs matter, apart for a constant."""
    largest = max(abs(low), abs(high))
    if two_signs(low, high):
        return -largest, largest
    # Rounding errors about a constant are a constant.
    if high - low <= SAME_VALUE * largest:
        margin = 0.01 * largest or 1.0
        return low - margin, high + margin
    return low, high


def colour_map(low: float, high: float) -> Any:
    """Blue to red for both signs, else blue-green-yellow without the darkest, on which no line would be seen."""
    from matplotlib import colormaps
    from matplotlib.colors import ListedColormap

    if two_signs(low, high):
        return colormaps["RdBu_r"]
    return ListedColormap(colormaps["viridis"](np.linspace(0.22, 1, 256)))
