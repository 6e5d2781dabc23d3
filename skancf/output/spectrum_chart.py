"""Amplitudes against frequency, with the natural frequencies."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from skancf.arguments import instance, mapping, texts
from skancf.atomic import AnyPath
from skancf.dynamics.spectrum import Spectrum, natural_frequencies
from skancf.errors import InputError, positive
from skancf.output.canvas import INK, done, legend, panel
from skancf.output.colours import line_style
from skancf.tolerances import TINY

DECADES = 5
"""Shown of amplitudes."""
# Shares of the width below which two numbers would overlap: the upright ones of peaks, and those of modes.
BESIDE_PEAK, BESIDE_MODE = 0.025, 0.035


def spectrum_chart(
    spectra: Spectrum | Mapping[str, Spectrum],
    path: AnyPath | None = None,
    modes: Any = None,
    limit: float | None = None,
    *,
    title: str = "",
    ylabel: str = "amplitude",
    ax: Any = None,
) -> Any:
    """Amplitudes on a logarithmic scale against frequency, the peaks with their frequencies.

    Parameters
    ----------
    spectra : Spectrum or mapping from label to Spectrum
        Of histories of several columns the totals are drawn.
    path : str or Path, optional
        ``*.png``, ``*.pdf`` or ``*.svg``. Default: no file, and the axes are returned to draw on.
    modes : Modes or (n,) array, optional
        Natural frequencies (Hz), drawn as vertical lines with the numbers of the modes, from 0 on, above.
    limit : float, optional
        Highest frequency shown (Hz). Default: a third above the highest peak.
    title : str
    ylabel : str
        With the unit, as in ``"amplitude of u3 (m)"``.
    ax : matplotlib axes, optional
        Draw on these. Default: on those of a new figure.

    Returns
    -------
    Path, or without a path the matplotlib axes

    Raises
    ------
    InputError
        Without spectra, and for spectra that are zero everywhere.

    Examples
    --------
    >>> times = np.linspace(0.0, 1.0, 1001)
    >>> found = sk.spectrum(times, np.sin(2 * np.pi * 50.0 * times))
    >>> axes = sk.output.spectrum_chart(found, limit=100.0)
    """
    texts(title=title, ylabel=ylabel)
    example = "a Spectrum, or labels and spectra, as in {'tip': sk.spectrum(times, values)}"
    drawn = {"": spectra} if isinstance(spectra, Spectrum) else dict(mapping("spectra", spectra, example))
    for label, each in drawn.items():
        instance(f"spectra[{label!r}]", each, Spectrum, "a Spectrum")
    if not drawn:
        raise InputError("spectra: the sequence is empty; give at least one")
    largest = max(float(each.total.max()) for each in drawn.values())
    if not largest > 0:
        raise InputError("spectra: all amplitudes are zero, and have no place on a logarithmic scale; nothing moved")
    peaks = [each.peaks() for each in drawn.values()]
    highest = max(each.nyquist for each in drawn.values())
    if limit is None:
        limit = min(highest, 4 / 3 * float(np.concatenate([at for at, _ in peaks]).max(initial=0))) or highest
    limit = positive("limit", limit, "Hz")
    axes = panel(ax, path, 7.5, 4.5)
    axes.set(yscale="log", xlim=(0, limit), ylim=(largest * 10.0**-DECADES, largest * 20), xlabel="frequency (Hz)",
             ylabel=ylabel, title=title)  # fmt: skip
    axes.grid(True, color="#e4e4e4", linewidth=0.7)
    if modes is not None:
        _draw_modes(axes, *natural_frequencies(modes), limit)
    for k, ((label, each), (at, amplitudes)) in enumerate(zip(drawn.items(), peaks, strict=True)):
        style = {**line_style(k), "linewidth": 1.3}
        axes.plot(*_outline(each, at), label=label, **style)
        axes.plot(at, amplitudes, "o", color=style["color"], markersize=4, markeredgecolor="white", markeredgewidth=0.6)
    _label_peaks(axes, np.concatenate(peaks, axis=1).T, limit)
    if len(drawn) > 1 or "" not in drawn:
        legend(axes, ax, ncols=min(len(drawn), 4))
    return done(axes, path)


def _outline(spectrum: Spectrum, peaks: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """All amplitudes about the peaks, elsewhere those at multiples of 1 / length: without the side lobes of the window."""
    away = np.abs(spectrum.frequencies[:, None] - peaks).min(axis=1, initial=np.inf)
    shown = (away < spectrum.resolution / 2) | (np.arange(len(away)) % spectrum.padding == 0)
    return spectrum.frequencies[shown], np.maximum(spectrum.total[shown], TINY)


def _draw_modes(axes: Any, numbers: np.ndarray, natural: np.ndarray, limit: float) -> None:
    """A line for each, and one text for those that are close together."""
    shown = natural <= limit
    numbers, natural = numbers[shown], natural[shown]
    for at in natural:
        axes.axvline(at, color=INK, linewidth=0.6, alpha=0.6, zorder=1)
    if not natural.size:
        return
    order = np.argsort(natural)
    groups = np.split(order, np.flatnonzero(np.diff(natural[order]) > BESIDE_MODE * limit) + 1)
    above = axes.secondary_xaxis("top", xlabel="mode")
    above.set_xticks([natural[group].mean() for group in groups], [_range(numbers[group]) for group in groups], fontsize=9)
    above.tick_params(length=0)


def _range(numbers: np.ndarray) -> str:
    return str(numbers[0]) if len(numbers) == 1 else f"{numbers.min()}–{numbers.max()}"


def _label_peaks(axes: Any, peaks: np.ndarray, limit: float) -> None:
    """Frequencies of the peaks, rows of frequency and amplitude; the larger one's of two that would overlap."""
    box = {"boxstyle": "round,pad=0.1", "facecolor": "white", "edgecolor": "none", "alpha": 0.85}
    labelled: list[float] = []
    for at, amplitude in sorted(peaks.tolist(), key=lambda peak: -peak[1]):
        if at <= limit and all(abs(at - other) > BESIDE_PEAK * limit for other in labelled):
            labelled.append(at)
            axes.annotate(f"{at:#.4g}".rstrip("."), (at, amplitude), xytext=(0, 6), textcoords="offset points",
                          rotation=90, ha="center", va="bottom", fontsize=9, zorder=6, bbox=box)  # fmt: skip
