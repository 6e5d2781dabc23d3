r"""The wanted element length along one direction of a graded mesh.

About every region the length is small and constant, then it grows *linearly* with the distance up to the coarse length:

.. math:: h(x) = \min\Bigl(l_0,\ \min_i\,(l_i + g_i\, d_i(x))\Bigr)

with :math:`d_i` the distance to interval i. Cells of size h along a ramp of slope g are in geometric progression,
:math:`q = e^g`, because :math:`dx/ds = h` gives :math:`h = l e^{g s}` at the s-th cell. So this is the transition of
:func:`skancf.meshes.progression`, in a form that needs no case for overlapping intervals (the finer one wins), for
ramps that meet before they are coarse, or for ramps that leave the domain.
"""

from dataclasses import dataclass
from math import log

import numpy as np

from skancf.showing import short

# Constant lengths and ramps are followed exactly. A bend in between is known to this fraction of the domain: sampling
# moves it a little, but makes nothing steeper.
SAMPLES = 1024


@dataclass(frozen=True)
class Sizes:
    """Intervals of small elements along one direction, and how lengths grow between them.

    Parameters
    ----------
    low, high : float
        Ends of the domain.
    centres, half_sizes, fractions : (m,) arrays
        Intervals centre -+ half_size and their lengths as a fraction of the coarse one, 0 < fraction < 1.
    growth : float
        Largest ratio q of neighbouring lengths.
    transition : float
        Smallest length of a ramp; 0: as steep as ``growth`` allows.
    """

    low: float
    high: float
    centres: np.ndarray
    half_sizes: np.ndarray
    fractions: np.ndarray
    growth: float
    transition: float = 0.0

    __repr__ = short

    def slopes(self, coarse: float) -> np.ndarray:
        """g_i = ln q, smaller where the ramp from fine to coarse has to be longer: (m,)."""
        steepest = np.full(self.centres.shape, log(self.growth))
        if self.transition == 0:
            return steepest
        return np.minimum(steepest, (1 - self.fractions) * coarse / self.transition)

    def wanted(self, x: np.ndarray, coarse: float) -> np.ndarray:
        """h(x): (n,) -> (n,)."""
        distance = np.maximum(np.abs(x[:, None] - self.centres) - self.half_sizes, 0)
        ramps = self.fractions * coarse + self.slopes(coarse) * distance
        return ramps.min(axis=1, initial=coarse)

    def line(self, coarse: float) -> "CellLine":
        """The domain measured in cells."""
        intervals = [self.centres, self.centres - self.half_sizes, self.centres + self.half_sizes]
        x = np.concatenate([np.linspace(self.low, self.high, SAMPLES + 1), *intervals])
        x = np.unique(np.clip(x, self.low, self.high))
        return CellLine.of(x, self.wanted(x, coarse))

    def count(self, coarse: float) -> float:
        """Cells in the domain, not yet a whole number; falls with the coarse length."""
        return float(self.line(coarse).s[-1])


@dataclass(frozen=True)
class CellLine:
    r"""Positions x, wanted lengths h (linear in between) and cells counted from the left, :math:`s = \int dx / h`."""

    x: np.ndarray
    h: np.ndarray
    s: np.ndarray

    __repr__ = short

    @classmethod
    def of(cls, x: np.ndarray, h: np.ndarray) -> "CellLine":
        # The integral of 1/h over a linear piece is dx ln(b/a) / (b - a).
        cells = np.diff(x) / (h[:-1] * exprel(np.log(h[1:] / h[:-1])))
        return cls(x, h, np.concatenate([[0.0], np.cumsum(cells)]))

    def cells_at(self, x: np.ndarray) -> np.ndarray:
        """s(x) for positions that are among the samples."""
        return self.s[np.searchsorted(self.x, x)]

    def position(self, s: np.ndarray) -> np.ndarray:
        """x(s), the inverse."""
        i = np.clip(np.searchsorted(self.s, s, side="right") - 1, 0, self.s.size - 2)
        ahead = s - self.s[i]
        rate = np.log(self.h[i + 1] / self.h[i]) / (self.s[i + 1] - self.s[i])
        return self.x[i] + self.h[i] * ahead * exprel(rate * ahead)


def exprel(z: np.ndarray) -> np.ndarray:
    """(e^z - 1) / z, which is 1 at zero."""
    return np.divide(np.expm1(z), z, out=np.ones_like(z), where=z != 0)
