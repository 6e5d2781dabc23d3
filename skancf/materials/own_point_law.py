"""Laws at points of the user's own classes, with what they leave out, and checked."""

from dataclasses import dataclass
from functools import cached_property
from inspect import signature
from typing import Any

import numpy as np

from skancf.equality import by_value
from skancf.errors import InputError, finite, positive, shown, vector
from skancf.functions import Noted, is_ours
from skancf.materials.law import IN_PLANE, OUT_OF_PLANE, SHEAR_CORRECTION, check_definite, corrected
from skancf.materials.point_check import COMPONENTS, STATES, check_at_rest, differences
from skancf.materials.point_law import BEYOND, FINE, PointLaw, PointResponse, deformation

SLOPE_STEP = 2.0**-15
"""Of a difference of C33 at the undeformed state."""
TOLERANCE = 1e-5
"""Of stress and stiffness, which may come from differences themselves."""


def point_law_of(material: Any) -> PointLaw:
    """A law at points as sections know it; one from outside this library is checked at a few states.

    Raises
    ------
    InputError
        For a law whose stress is not the derivative of its energy, or whose stiffness not that of its stress, and for one
        that remembers.
    """
    if is_ours(material):
        law: PointLaw = material
        return law
    own = OwnPointLaw(material)
    if getattr(material, "n_history", 0):
        raise InputError(f"material = {shown(material)}: it remembers {material.n_history} numbers of each point, and "
                         "laws with memory cannot be solved yet; give a law of the deformation alone")  # fmt: skip
    positive("material.density", own.density, "kg/m3")
    check_at_rest(material, own.at_rest)
    differences(own.respond, STATES, TOLERANCE, type(material).__name__)
    vector("material.thermal_strain()", own.thermal_strain(), 6)
    vector("material.thinning()", own.thinning(), 3)
    check_definite(own.stiffness(), type(material).__name__)
    _check_same(own)
    return own


def _check_same(own: "OwnPointLaw") -> None:
    """InputError for a stiffness of small strain that is not that of the undeformed state."""
    full = own.stiffness()
    out = full[np.ix_(OUT_OF_PLANE, OUT_OF_PLANE)]
    coupling = full[np.ix_(IN_PLANE, OUT_OF_PLANE)]
    told = full[np.ix_(IN_PLANE, IN_PLANE)] - coupling @ np.linalg.solve(out, coupling.T)
    apart, size = np.abs(told - own.plane_at_rest), np.abs(own.plane_at_rest).max()
    if apart.max() > TOLERANCE * size:
        k, l = np.unravel_index(int(np.argmax(apart)), apart.shape)
        raise InputError(
            f"material.stiffness(): in plane stress its entry {COMPONENTS[k]}, {COMPONENTS[l]} is {told[k, l]:.6g} Pa, and "
            f"that of plane_stress at the undeformed state {own.plane_at_rest[k, l]:.6g} Pa; give the same material, or "
            "leave stiffness out"
        )


def check_law(law: Any, C: Any = None, *, tolerance: float = 1e-6) -> dict[str, float]:
    """Check that energy, stress and stiffness of a law at points belong together.

    A stress that is no derivative of the energy gives a body that makes or loses energy, a stiffness that is not that of the
    stress a Newton's method that is slow or fails; neither says so by itself.

    Parameters
    ----------
    law : PointLaw
        Of this library or your own, see :class:`~skancf.materials.PointLaw`.
    C : (3, n) array, optional
        C11, C22, C12 at which to check, for example of the stretches that you expect. Default: strains of a few per cent.
    tolerance : float
        Relative difference that is an error.

    Returns
    -------
    dict
        Largest relative differences, in the size of the stiffness, of ``"stress against energy"`` and
        ``"stiffness against stress"``.

    Raises
    ------
    InputError
        Where they differ. The error is an AssertionError, too.

    Notes
    -----
    Problems check laws of your own so when they are made, at strains of a few per cent, to 1e-5.

    Examples
    --------
    >>> errors = sk.testing.check_law(sk.NeoHooke(shear=0.4e6, density=1000.0))
    >>> print(max(errors.values()) < 1e-6)
    True
    """
    positive("tolerance", tolerance)
    respond = law.respond if is_ours(law) else OwnPointLaw(law).respond
    return differences(respond, STATES if C is None else deformation(C), tolerance, type(law).__name__)


@by_value
@dataclass(frozen=True)
class OwnPointLaw:
    """A material with ``density`` and ``plane_stress(C, guess)``; what else of a law it has not, follows from these.

    Attributes
    ----------
    material
        ``plane_stress`` returns a :class:`~skancf.materials.PointResponse`, or energy (n,), stress (3, n), stiffness (6, n)
        and C33 (n,).
    """

    material: Any
    n_history = 0

    @property
    def density(self) -> Any:
        if not hasattr(self.material, "density"):
            raise InputError(f"material = {shown(self.material)}: a law at points has a density (kg/m3); this has none")
        return self.material.density

    @property
    def limit(self) -> str:
        return str(getattr(self.material, "limit", ""))

    def respond(self, C: np.ndarray, guess: np.ndarray | None = None, history: np.ndarray | None = None) -> PointResponse:
        """Plane stress; values that are not finite are told by a code."""
        n = C.shape[1]
        with Noted("material.plane_stress"), np.errstate(all="ignore"):
            given = self.material.plane_stress(C.copy(), *([guess] if self._takes_guess else []))
        parts = given if isinstance(given, tuple) else [getattr(given, name, None) for name in _PARTS]
        shapes = [() if part is None else np.shape(part) for part in parts]
        if len(parts) != 4 or shapes != [(n,), (3, n), (6, n), (n,)]:
            raise InputError(f"material.plane_stress: it returned {shown(given)}; give a PointResponse, or energy (n,), "
                             f"stress (3, n), stiffness (6, n) and C33 (n,), here with n = {n}")  # fmt: skip
        for name, part in zip(_PARTS, parts, strict=True):
            if np.asarray(part).dtype.kind not in "iuf":
                raise InputError(f"material.plane_stress: its {name} is {shown(part)}; give real numbers")
        energy, stress, stiffness, c33 = (np.array(part, dtype=float) for part in parts)
        wrong = ~np.isfinite(energy + stress.sum(axis=0) + stiffness.sum(axis=0) + c33)
        code = np.where(wrong, BEYOND, FINE)
        own = getattr(given, "code", None)
        if own is not None:
            code = np.where(np.asarray(own) != FINE, own, code)
        for part in (energy, stress, stiffness, c33):
            part[..., code != FINE] = np.nan
        return PointResponse(energy, stress, stiffness, c33, code)

    @cached_property
    def _takes_guess(self) -> bool:
        """Whether ``plane_stress`` takes a guess of C33, too."""
        try:
            signature(self.material.plane_stress).bind(None, None)
        except TypeError:
            return False
        except ValueError:  # of compiled functions that do not say
            return True
        return True

    @cached_property
    def at_rest(self) -> PointResponse:
        return self.respond(np.array([[1.0], [1.0], [0.0]]))

    @property
    def plane_at_rest(self) -> np.ndarray:
        """D of the undeformed state, (3, 3)."""
        return np.asarray(self.at_rest.stiffness[:, 0][np.array([[0, 3, 4], [3, 1, 5], [4, 5, 2]])])

    def stiffness(self) -> np.ndarray:
        """C of small strain, shape (6, 6), of plane stress; without its own, moduli across are guessed by those in it."""
        if callable(getattr(self.material, "stiffness", None)):
            own = finite("material.stiffness()", self.material.stiffness())
            if own.shape != (6, 6):
                raise InputError(f"material.stiffness() of shape {own.shape}: a law is a 6 x 6 matrix")
            return own
        plane = self.plane_at_rest
        full = np.diag([0.0, 0.0, max(plane[0, 0], plane[1, 1]), plane[2, 2], plane[2, 2], 0.0])
        full[np.ix_([0, 1, 5], [0, 1, 5])] = plane
        return corrected(full, SHEAR_CORRECTION)

    def thermal_strain(self) -> np.ndarray:
        """Free strain per kelvin, shape (6,); none without its own."""
        own = getattr(self.material, "thermal_strain", None)
        return finite("material.thermal_strain()", own()) if callable(own) else np.zeros(6)

    def thinning(self) -> np.ndarray:
        """Strain 33 per unit of 11, 22, 12, of small strain: (3,)."""
        if callable(getattr(self.material, "thinning", None)):
            return finite("material.thinning()", self.material.thinning())
        unit = SLOPE_STEP * np.eye(3)
        ones = np.array([[1.0], [1.0], [0.0]])
        up, down = (self.respond(ones + sign * unit).stretch33 for sign in (1, -1))
        return np.asarray((up - down) / (2 * SLOPE_STEP) * [1.0, 1.0, 0.5])


_PARTS = ("energy", "stress", "stiffness", "stretch33")
