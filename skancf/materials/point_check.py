"""Laws at points, checked against themselves: stress is the derivative of energy, stiffness that of stress."""

from collections.abc import Callable
from typing import Any

import numpy as np

from skancf.errors import InputError, number
from skancf.materials.point_law import FINE, PAIRS, PointResponse
from skancf.tolerances import SAME_VALUE

STEP = 2.0**-13
"""Of differences in C, at two lengths and extrapolated: errors are its fourth power, 1e-16, and rounding over it, 1e-12."""
COMPONENTS = ("11", "22", "12")
FACTORS = (2.0, 2.0, 1.0)
"""Derivatives by E11, E22, 2 E12 from those by C11, C22, C12."""
STATES = np.array([
    [1.0, 1.02, 0.98, 1.05, 1.0, 0.97],
    [1.0, 0.98, 0.97, 1.0, 1.04, 1.03],
    [0.0, 0.02, -0.03, 0.01, 0.05, 0.0],
])  # fmt: skip
"""C of the undeformed state and of strains up to 0.03, which every law should bear."""


class WrongLaw(InputError, AssertionError):
    """A law that contradicts itself; the message says where, and by how much."""


def differences(
    respond: Callable[[np.ndarray, Any], PointResponse], C: np.ndarray, tolerance: float, name: str
) -> dict[str, float]:
    """Largest relative differences of a function of C and a guess of C33; InputError where one is above a tolerance."""
    found = respond(C.copy(), None)
    _check_numbers(C, found, name)
    size = np.abs(found.stiffness).max(axis=0)
    wrong = {"stress against energy": 0.0, "stiffness against stress": 0.0}
    for j, factor in enumerate(FACTORS):
        slopes = [_slope(respond, C, found, j, STEP / part) * factor for part in (1, 2)]
        slope = (4 * slopes[1] - slopes[0]) / 3
        rows = [next(m for m, pair in enumerate(PAIRS) if pair == tuple(sorted((i, j)))) for i in range(3)]
        told = np.vstack([found.stress[j][None], found.stiffness[rows]])
        for m, (what, of) in enumerate([("stress against energy", "energy"), *[("stiffness against stress", f"S{i}")
                                                                              for i in COMPONENTS]]):  # fmt: skip
            error = np.abs(slope[m] - told[m]) / size
            worst = int(np.argmax(np.where(np.isnan(error), np.inf, error)))
            wrong[what] = max(wrong[what], float(error[worst]))
            if not error[worst] <= tolerance:
                entry = f"S{COMPONENTS[j]}" if m == 0 else f"D{COMPONENTS[m - 1]}{COMPONENTS[j]}"
                at = ", ".join(f"{value:.6g}" for value in C[:, worst])
                raise WrongLaw(
                    f"{name}: {what}: at C = ({at}), {entry} is {told[m, worst]:.6g}, and the difference of {of} by the "
                    f"strain {COMPONENTS[j]} {slope[m, worst]:.6g}; look at factors of two of the shear (strain is 2 E12 = "
                    "C12), and at what C33 adds where S33 = 0"
                )
    return wrong


def _check_numbers(C: np.ndarray, found: PointResponse, name: str) -> None:
    """WrongLaw where a law has no stress, or no thickness."""
    none = ~np.isfinite(found.energy + found.stress.sum(axis=0) + found.stiffness.sum(axis=0)) | (found.code != FINE)
    wrong = none | ~(found.stretch33 > 0)
    if wrong.any():
        k = int(np.argmax(wrong))
        at = ", ".join(f"{value:.6g}" for value in C[:, k])
        what = "it has no finite energy, stress and stiffness" if none[k] else f"C33 is {found.stretch33[k]:.6g}"
        raise WrongLaw(f"{name}: at C = ({at}) {what}; it must have them, and C33 greater than zero, at the strains at "
                       "which it is checked, of a few per cent where none were given")  # fmt: skip


def _slope(
    respond: Callable[[np.ndarray, Any], PointResponse], C: np.ndarray, found: PointResponse, j: int, h: float
) -> np.ndarray:
    """Differences of energy and stress by a component of C, (4, n)."""
    unit = h * np.eye(3)[:, [j]]
    up, down = (respond(C + sign * unit, found.stretch33.copy()) for sign in (1, -1))
    return np.vstack([(up.energy - down.energy)[None], up.stress - down.stress]) / (2 * h)


def check_at_rest(law: Any, found: PointResponse) -> None:
    """InputError for an undeformed state that has energy or stress, or is not stable; ``found`` is its response."""
    name = type(law).__name__
    size = np.abs(found.stiffness[:, 0]).max()
    if found.code[0] != FINE or not size > 0 or not np.isfinite(size):
        raise WrongLaw(f"{name}: at the undeformed state, C = (1, 1, 0), it has no stress or no stiffness")
    worst = int(np.argmax(np.abs(found.stress[:, 0])))
    if abs(found.stress[worst, 0]) > SAME_VALUE * size:
        raise WrongLaw(f"{name}: the undeformed state, C = (1, 1, 0), has the stress S{COMPONENTS[worst]} = "
                       f"{found.stress[worst, 0]:.6g} Pa; it must have none")  # fmt: skip
    if abs(found.energy[0]) > SAME_VALUE * size:
        raise WrongLaw(f"{name}: the undeformed state, C = (1, 1, 0), has the energy {found.energy[0]:.6g} J/m3; subtract "
                       "it")  # fmt: skip
    number("stretch33 of the undeformed state", found.stretch33[0])
    if abs(found.stretch33[0] - 1) > SAME_VALUE:
        raise WrongLaw(f"{name}: C33 of the undeformed state is {found.stretch33[0]:.9g}; it must be 1")
