"""What holds for vibrations."""

from dataclasses import replace
from typing import Any

import numpy as np

import skancf as sk
from fuzz.assessment import EPS, bounded, stated
from fuzz.case import Case
from fuzz.transforms import in_frame, in_units

CLOSE = 1e-7
"""Lanczos' method is asked for 1e-10 of the eigenvalues, three digits more."""


def vibrating(case: Case, n: int = 4, numbering: int | None = None) -> sk.Modes:
    unloaded = replace(case, problem=replace(case.problem, loads=[]))
    with stated():
        return sk.modes(unloaded.system(numbering), n)


def noise(modes: sk.Modes) -> float:
    """Rounding of the eigenvalues, whose terms cancel as those of the energy do, relative to the largest."""
    matrix, shapes = modes.state.system.stiffness().to_scipy(), modes.shapes
    terms = (np.abs(shapes) * (abs(matrix) @ np.abs(shapes).T).T).sum(axis=1)
    return 100 * EPS * float(terms.max())


def same(one: sk.Modes, two: sk.Modes) -> None:
    size = float(np.abs(one.eigenvalues).max())
    error = CLOSE * size + noise(one) + noise(two)
    bounded("eigenvalues", float(np.abs(one.eigenvalues - two.eigenvalues).max()), error)


def restated(given: tuple[Case, Any, tuple[float, float], int]) -> None:
    """Frequencies are the same in another frame, in other units and with other numbers."""
    case, (turn, shift), (length, force), seed = given
    modes = vibrating(case)
    same(modes, vibrating(in_frame(case, turn, shift)))
    same(modes, vibrating(in_units(case, length, force)))
    same(modes, vibrating(case, numbering=seed))


def rigid(case: Case) -> None:
    """A free body has its six rigid motions, and no other without stiffness."""
    modes = vibrating(case, 8)
    assert modes.n_rigid == 6 and modes.n_unstable == 0, (
        f"{modes.n_rigid} rigid and {modes.n_unstable} unstable motions; eigenvalues {modes.eigenvalues}"
    )
