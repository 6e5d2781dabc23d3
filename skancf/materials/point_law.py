r"""Laws at a point: the deformation in; energy, stress and stiffness out, for many points at once.

The deformation of a point is the right Cauchy-Green tensor C in an orthonormal frame of the undeformed surface, whose
direction 3 is the normal. Stress is the second Piola-Kirchhoff stress, energy is per undeformed volume, and strain is
:math:`E = (C - I) / 2` with doubled shear, in the order 11, 22, 12:

.. math:: S_{11} = 2 \psi_{,C_{11}}, \; S_{12} = \psi_{,C_{12}}, \quad D = \partial S / \partial (E_{11}, E_{22}, 2 E_{12}),

where C12 is one number for both C12 and C21. In plane stress C33 is such that S33 is zero, and C13 and C23 are zero.

Those of this library are compiled (:mod:`skancf.compiled`), and return codes instead of errors.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np

from skancf.equality import by_value
from skancf.errors import InputError, finite
from skancf.showing import short

PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
"""Rows and columns of the six numbers of a stiffness D: 11, 22, 12, each with itself, then 11, 22; 11, 12; 22, 12."""
PAIRS_3D = tuple((k, l) for k in range(6) for l in range(k, 6))
"""The same of the 21 numbers in three dimensions, row by row."""
FINE, FOLDED, BEYOND, NO_THICKNESS = range(4)
"""What became of a point."""
REASONS = {
    FOLDED: "the material there has no area left, or is turned inside out (C11 C22 - C12^2 must be greater than zero); take "
            "smaller steps, or look for elements that are folded",
    BEYOND: "the deformation is beyond what the law allows there, its energy is no finite number",
    NO_THICKNESS: "no thickness was found at which the stress across it is zero; the law has none for this deformation",
}  # fmt: skip


class BeyondLaw(InputError):
    """A deformation that a law has no stress for; ``point`` is the index of the first such point.

    Examples
    --------
    >>> tissue = sk.materials.Gent(shear=0.4e6, most=1.0, density=1000.0)
    >>> try:
    ...     tissue.plane_stress(np.array([[1.1, 4.0], [1.1, 4.0], [0.0, 0.0]]))
    ... except sk.materials.BeyondLaw as reason:
    ...     print(reason.point)
    1
    """

    def __init__(self, message: str, point: int):
        self.point = point
        super().__init__(message)


@by_value
@dataclass(frozen=True)
class PointResponse:
    """What a law says of n points.

    Attributes
    ----------
    energy : (n,) array
        Per undeformed volume (J/m3).
    stress : (3, n) array
        S11, S22, S12 (Pa); in three dimensions (6, n), Voigt order 11, 22, 33, 23, 13, 12.
    stiffness : (6, n) array
        D in the order of :data:`PAIRS` (Pa); in three dimensions (21, n), that of :data:`PAIRS_3D`.
    stretch33 : (n,) array
        C33, the square of the stretch across.
    code : (n,) int array, optional
        0, or why there is no stress, a key of :data:`REASONS`. There all else is not a number. Default: 0 everywhere.
    history : (n_history, n) array, optional
        What the law remembers; no rows for elastic ones.

    Examples
    --------
    >>> response = sk.NeoHooke(shear=0.4e6, density=1000.0).plane_stress(np.array([[1.0], [1.0], [0.0]]))
    >>> response.energy, response.stretch33
    (array([0.]), array([1.]))
    """

    energy: np.ndarray
    stress: np.ndarray
    stiffness: np.ndarray
    stretch33: np.ndarray
    code: Any = None
    history: Any = None

    __repr__ = short

    def __post_init__(self) -> None:
        n = np.shape(self.energy)[-1:]
        if self.code is None:
            object.__setattr__(self, "code", np.zeros(n, dtype=np.int64))
        if self.history is None:
            object.__setattr__(self, "history", np.empty((0, *n)))

    @property
    def first_failure(self) -> int | None:
        """Index of the first point that the law has no stress for."""
        return int(np.argmax(self.code != FINE)) if self.code.any() else None

    def checked(self, law: Any, C: np.ndarray) -> "PointResponse":
        """Itself; :class:`BeyondLaw` if it is not finite somewhere."""
        k = self.first_failure
        if k is not None:
            at = ", ".join(f"{value:.6g}" for value in C[:, k])
            raise BeyondLaw(f"{type(law).__name__} at point {k} of {len(self.code)}, C = ({at}): "
                            f"{why(law, int(self.code[k]))}", k)  # fmt: skip
        return self


def why(law: Any, code: int) -> str:
    """A reason in words, with the law's own limit."""
    limit = getattr(law, "limit", "")
    return REASONS[code] + (f" ({limit})" if code == BEYOND and limit else "")


@runtime_checkable
class PointLaw(Protocol):
    """A law at a point, as sections that integrate through the thickness know it.

    It is a :class:`~skancf.materials.Law` too: ``stiffness``, ``thermal_strain`` and ``thinning`` are those of small strain.

    A class of your own needs ``density`` and ``plane_stress(C, guess)`` only, which returns a :class:`PointResponse`, or
    energy (n,), stress (3, n), stiffness (6, n) and C33 (n,); the rest is taken from these. A problem checks it at small
    strains when it is made, :func:`skancf.testing.check_law` at others.

    Examples
    --------
    >>> class Hooke:
    ...     density = 1000.0
    ...
    ...     def plane_stress(self, C, guess=None):
    ...         E = np.array([(C[0] - 1) / 2, (C[1] - 1) / 2, C[2]])  # 11, 22, and twice 12
    ...         D = np.diag([2e6, 2e6, 1e6])
    ...         S = D @ E
    ...         six = np.repeat([[2e6], [2e6], [1e6], [0.0], [0.0], [0.0]], C.shape[1], axis=1)
    ...         return (E * S).sum(axis=0) / 2, S, six, np.ones(C.shape[1])
    """

    n_history: int

    @property
    def density(self) -> float:
        """Mass per undeformed volume."""

    def stiffness(self) -> np.ndarray:
        """C of small strain, shape (6, 6), in the frame of the undeformed surface, of plane stress."""

    def thermal_strain(self) -> np.ndarray:
        """Free strain per kelvin, shape (6,)."""

    def thinning(self) -> np.ndarray:
        """Strain 33 per unit of 11, 22, 12 in plane stress, of small strain: (3,)."""

    def respond(self, C: np.ndarray, guess: np.ndarray | None = None, history: np.ndarray | None = None) -> PointResponse:
        """Plane stress at C11, C22, C12 (3, n), with a first guess of C33 (n,) and what the law remembers (n_history, n).

        What is out of its range is told by :attr:`PointResponse.code`, and no error.
        """


def is_point_law(material: Any) -> bool:
    """Whether a material is a law at points, and not a matrix."""
    return not isinstance(material, type) and callable(getattr(material, "plane_stress", None))


def require_solid(law: Any) -> None:
    """InputError for a law at points that has no stress in three dimensions."""
    name = type(law).__name__
    if getattr(law, "incompressible", False):
        raise InputError(f"material = {name}: it is incompressible, and no deformation of a solid tells its pressure; give "
                         f"{getattr(law, 'made_compressible', 'it a volume that changes')}, or take theory 'kirchhoff', "
                         "where stress across is zero")  # fmt: skip
    if not callable(getattr(law, "respond3d", None)) or getattr(law, "_in_solids", law) is None:
        raise InputError(f"material = {name}: it has no stress in three dimensions, which theory 'full' needs; take a law "
                         "of invariants, such as NeoHooke with poisson = 0.45, or theory 'kirchhoff'")  # fmt: skip


def deformation(C: Any, rows: int = 3) -> np.ndarray:
    """C as (rows, n) floats."""
    array = np.ascontiguousarray(finite("C", C))
    if array.ndim != 2 or array.shape[0] != rows:
        names: Sequence[str] = ("C11, C22, C12") if rows == 3 else ("C11, C22, C33, C23, C13, C12")
        raise InputError(f"C of shape {array.shape}: give ({rows}, n) numbers, {names} of n points")
    return array
