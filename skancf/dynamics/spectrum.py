"""Histories as frequencies, compared with natural frequencies."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.polynomial import polynomial

from skancf.arguments import choice, whole
from skancf.equality import by_value
from skancf.errors import InputError, finite, number, shown
from skancf.memory import require_much
from skancf.showing import counted, in_a_notebook, in_brackets, summary
from skancf.statics import Modes
from skancf.tabular import Column, Tabular, spread
from skancf.tolerances import EQUIDISTANT, NO_SERIES, TINY

# Half the main lobe of each window: how far apart two frequencies are told apart, in units of 1 / length.
LOBES = {"boxcar": 1, "hann": 2, "hamming": 2, "blackman": 3, "blackmanharris": 4, "flattop": 5}
DEGREES = {None: -1, "constant": 0, "linear": 1}
FEWEST = 8
# Other times are resampled to at most this many times their number: steps grow from a tiny first one.
OVERSAMPLING = 16


@dataclass(frozen=True)
class Match:
    """A peak and the nearest natural frequency.

    Attributes
    ----------
    frequency, amplitude : float
        Of the peak (Hz, unit of the history).
    nearest : int
        Number of the nearest natural frequency, from 0 on as in ``Modes.shape``.
    natural : float
        That frequency (Hz).
    modes : tuple of int
        All that lie within the resolution of the peak: none, one, or several that the history does not tell apart.
    highest : float, optional
        The highest natural frequency that was given (Hz), where others that were not given may be as near to the peak.
    """

    frequency: float
    amplitude: float
    nearest: int
    natural: float
    modes: tuple[int, ...]
    highest: float | None = None

    __repr__ = in_brackets

    @property
    def difference(self) -> float:
        """Of the peak from the nearest natural frequency, relative to that."""
        return self.frequency / self.natural - 1

    @property
    def found(self) -> bool:
        """Whether one of the given natural frequencies lies within the resolution of the peak."""
        return len(self.modes) > 0

    @property
    def resolved(self) -> bool:
        """Whether exactly one does."""
        return len(self.modes) == 1

    @summary
    def __str__(self) -> str:
        text = f"{self.frequency:.6g} Hz: mode {self.nearest}, {self.natural:.6g} Hz, {self.difference:+.2%}"
        if not self.found:
            text = f"{text}; not within the resolution"
        elif not self.resolved:
            text = f"{text}; modes {self.modes} not resolved"
        return text if self.highest is None else f"{text}; none above {self.highest:.6g} Hz is given: ask for more modes"


@by_value
@dataclass(frozen=True)
class Spectrum(Tabular):
    r"""Outcome of :func:`spectrum`; a table, see :class:`~skancf.tabular.Tabular`.

    Attributes
    ----------
    frequencies : (m,) array
        From 0 to ``nyquist`` (Hz), ``padding`` of them per 1 / length of the history.
    amplitudes : (m,) or (m, k) array
        One-sided and in the unit of the history: :math:`A \sin(2 \pi f t)` has a peak of height A at f.
    resolution : float
        Distance of frequencies that are told apart (Hz): half the main lobe of the window, 2 / length for Hann's.
    nyquist : float
        The highest frequency (Hz).
    padding : int

    Examples
    --------
    >>> times = np.linspace(0.0, 1.0, 1001)
    >>> found = sk.spectrum(times, np.sin(2 * np.pi * 50.0 * times))
    >>> print([f"{match.frequency:.1f} Hz" for match in found.compare([49.0, 120.0], count=1)])
    ['50.0 Hz']
    """

    frequencies: np.ndarray
    amplitudes: np.ndarray
    resolution: float
    nyquist: float
    padding: int

    __repr__, _repr_html_ = in_brackets, in_a_notebook

    @summary
    def __str__(self) -> str:
        columns = counted(int(np.prod(self.amplitudes.shape[1:], dtype=int)), "column")
        return (
            f"Spectrum: up to {self.nyquist:.4g} Hz, {columns}, tells frequencies {self.resolution:.3g} Hz apart; "
            f"largest amplitude {self.total.max():.4g} at {self.frequencies[self.total.argmax()]:.4g} Hz"
        )

    def _table(self) -> dict[str, Column]:
        return {"frequency": (self.frequencies, "Hz"), **spread("amplitude", self.amplitudes, "")}

    @property
    def total(self) -> np.ndarray:
        """Amplitudes of all columns together, the root of the sum of their squares, (m,)."""
        return np.asarray(np.linalg.norm(self.amplitudes.reshape(len(self.frequencies), -1), axis=1))

    def peaks(self, count: int | None = None, prominence: float = 0.01) -> tuple[np.ndarray, np.ndarray]:
        """Frequencies (Hz) and amplitudes of the largest peaks of ``total``, in ascending order of frequency.

        Looked for at multiples of 1 / length, where the side lobes of the window have no peaks of their own, and found
        between them by a parabola through the logarithms of three padded amplitudes.

        Parameters
        ----------
        count : int, optional
            How many at most; default all.
        prominence : float
            How far a peak stands out from its surroundings at least, as a share of the largest.
        """
        if count is not None:
            count = whole("count", count, floats=True)
        prominence = number("prominence", prominence)
        if not 0 <= prominence < 1:
            raise InputError(f"prominence = {prominence}: give a share of the largest peak, at least 0 and less than 1")
        from scipy.signal import find_peaks  # not at the top: it takes as long to load as all else

        fine, p = self.total, self.padding
        coarse = fine[::p]
        at, about = find_peaks(coarse, prominence=0)
        at = at[about["prominences"] >= prominence * coarse[at].max(initial=0)]
        at = np.array([k * p - p + np.argmax(fine[k * p - p : k * p + p + 1]) for k in at], dtype=int)
        low, mid, high = np.log(np.maximum(fine[at[:, None] + [-1, 0, 1]], TINY)).T
        shift = 0.5 * (low - high) / np.minimum(low - 2 * mid + high, -TINY)
        frequencies = self.frequencies[at] + shift * (self.frequencies[at] - self.frequencies[at - 1])
        amplitudes = np.exp(mid - 0.25 * (low - high) * shift)
        kept = np.sort(np.argsort(-amplitudes, kind="stable")[: None if count is None else int(count)])
        return frequencies[kept], amplitudes[kept]

    def compare(self, natural: Any, *, count: int | None = None, prominence: float = 0.01) -> tuple[Match, ...]:
        """Each peak with the natural frequency nearest to it, of those that are given.

        Of a peak that reaches above the highest of them by its resolution, it is said that there may be nearer ones.

        Parameters
        ----------
        natural : Modes or (n,) array
            Outcome of :func:`skancf.modes`, or frequencies (Hz). Those that are not positive, of rigid or unstable motions,
            are passed over.
        count, prominence
            See :meth:`peaks`.
        """
        numbers, known = natural_frequencies(natural)
        matches = []
        for frequency, amplitude in zip(*self.peaks(count, prominence), strict=True):
            away = np.abs(known - frequency)
            k, within = int(np.argmin(away)), numbers[away <= self.resolution]
            matches.append(
                Match(
                    float(frequency),
                    float(amplitude),
                    int(numbers[k]),
                    float(known[k]),
                    tuple(within.tolist()),
                    float(known.max()) if frequency + self.resolution > known.max() else None,
                )
            )
        return tuple(matches)


def spectrum(
    times: Any,
    values: Any,
    *,
    window: str = "hann",
    detrend: str | None = "constant",
    begin: float | None = None,
    end: float | None = None,
    padding: int = 8,
) -> Spectrum:
    """Amplitudes of a history at its frequencies, as in ``sk.spectrum(*motion.records["tip"])``.

    The highest frequency is half the sampling rate of the history's own samples, at their longest interval. What the motion
    contains above it is seen as a lower frequency, which the history itself cannot show: record more often and compare.
    Times that are not equidistant, as adaptive steps are, are resampled by a cubic spline at their shortest interval, or
    a sixteenth of the mean one if that is longer; this takes up to half a percent off an amplitude at five samples per
    period, and up to a sixth at two and a half.

    Parameters
    ----------
    times : (n,) array
        Ascending (s), at least 8.
    values : (n,) or (n, k) array
        Any quantities, for example those of ``Motion.records`` or ``Motion.displacement``.
    window : str
        ``"hann"`` for most; ``"boxcar"`` resolves twice as much, but its peaks disturb each other; ``"blackman"``, and more
        so ``"blackmanharris"``, show small peaks next to large ones; ``"flattop"`` is for amplitudes read without
        interpolation, and its frequencies are coarse; or ``"hamming"``.
    detrend : str or None
        What is removed before: the mean, ``"constant"``, or a straight line, ``"linear"``; fitted with the window as weight,
        so that few periods do not tilt it.
    begin, end : float, optional
        Part of the history (s).
    padding : int
        Number of frequencies per 1 / length.

    Returns
    -------
    Spectrum

    Raises
    ------
    InputError
        For times that do not ascend, values that are not finite or of another number, and too few samples.

    Examples
    --------
    >>> times = np.linspace(0.0, 1.0, 1001)
    >>> found = sk.spectrum(times, np.sin(2 * np.pi * 50.0 * times))
    >>> print(f"{found.frequencies[np.argmax(found.amplitudes)]:.1f} Hz")
    50.0 Hz
    """
    if not isinstance(window, str) or window not in LOBES:
        raise InputError(f"window = {shown(window)}: give one of {', '.join(LOBES)}")
    choice("detrend", detrend, tuple(DEGREES))
    padding = whole("padding", padding, floats=True)
    from scipy.signal import get_window  # not at the top: it takes as long to load as all else

    t, x = _part(*_history(times, values), begin, end)
    longest = np.diff(t).max()
    t, x = _equidistant(t, x)
    # Values with zeros behind them, their transform, and its size.
    require_much(40 * padding * x.size, f"padding = {padding}", f"a spectrum of {x.size} values", "take less padding")
    n, dt = len(t), (t[-1] - t[0]) / (len(t) - 1)
    weights = get_window(window, n)
    x = _without_trend(x, weights, DEGREES[detrend])
    amplitudes = 2 / weights.sum() * np.abs(np.fft.rfft((weights * x.T).T, int(padding) * n, axis=0))
    amplitudes[0] /= 2
    frequencies = np.fft.rfftfreq(int(padding) * n, dt)
    nyquist = 0.5 / longest
    kept = frequencies <= nyquist * (1 + EQUIDISTANT)
    return Spectrum(frequencies[kept], amplitudes[kept], LOBES[window] / (n * dt), float(nyquist), int(padding))


def natural_frequencies(natural: Any) -> tuple[np.ndarray, np.ndarray]:
    """Numbers and values (Hz) of the positive ones of modes, or of frequencies (Hz)."""
    known = finite("natural frequencies", natural.frequencies if isinstance(natural, Modes) else natural)
    if known.ndim != 1 or not (known > 0).any():
        raise InputError(f"natural frequencies = {known}: give modes, or a list of frequencies (Hz), some above zero")
    numbers = np.flatnonzero(known > 0)
    return numbers, known[numbers]


def _history(times: Any, values: Any) -> tuple[np.ndarray, np.ndarray]:
    t, x = finite("times", times), finite("values", values)
    if t.ndim != 1 or x.ndim not in (1, 2) or x.shape[:1] != t.shape or not x.size:
        raise InputError(f"values of shape {x.shape} at times of shape {t.shape}: give n times, and n values or n rows of k")
    back = np.flatnonzero(np.diff(t) <= 0)
    if back.size:
        k = back[0]
        raise InputError(f"times[{k + 1}] = {t[k + 1]} s after {t[k]} s: times must ascend; sort them, keep one of equals")
    return t, x


def _part(t: np.ndarray, x: np.ndarray, begin: float | None, end: float | None) -> tuple[np.ndarray, np.ndarray]:
    """What lies between two times of the history."""
    for name, given in (("begin", begin), ("end", end)):
        if given is not None and len(t) and not t[0] <= number(name, given) <= t[-1]:
            raise InputError(f"{name} = {given} s: the history is known from {t[0]} to {t[-1]} s; give a time between")
    if begin is not None and end is not None and not begin < end:
        raise InputError(f"begin = {begin} s, end = {end} s: give the earlier time first")
    inside = (t >= (-np.inf if begin is None else begin)) & (t <= (np.inf if end is None else end))
    if inside.sum() < FEWEST:
        raise InputError(f"times: {inside.sum()} samples to use; a spectrum needs {FEWEST}: record more often, or longer")
    return t[inside], x[inside]


def _equidistant(t: np.ndarray, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    from scipy.interpolate import CubicSpline  # not at the top: few runs need it, and it is slow to load

    intervals = np.diff(t)
    mean = intervals.mean()
    if np.abs(intervals - mean).max() <= EQUIDISTANT * mean:
        return t, x
    number_of = min(int(np.ceil((t[-1] - t[0]) / intervals.min())), OVERSAMPLING * len(intervals))
    even = np.linspace(t[0], t[-1], number_of + 1)
    return even, CubicSpline(t, x)(even)


def _without_trend(x: np.ndarray, weights: np.ndarray, degree: int) -> np.ndarray:
    """Values less their polynomial of this degree, zero where nothing but rounding is left."""
    if degree < 0:
        return x
    s = np.linspace(-1, 1, len(x))
    trend = polynomial.polyval(s, polynomial.polyfit(s, x, degree, w=np.sqrt(np.maximum(weights, 0)))).T
    rest = x - trend
    return np.where(np.abs(rest).max(axis=0) > NO_SERIES * np.abs(x).max(axis=0), rest, 0.0)
