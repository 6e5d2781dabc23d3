"""What laws of rubber have in common."""

from abc import abstractmethod
from functools import cached_property
from math import inf
from typing import Any

import numpy as np

from skancf.arguments import plain
from skancf.errors import InputError, number, positive
from skancf.materials.hyperelastic.kernels import RESULTS
from skancf.materials.hyperelastic.solid_kernels import SOLID_RESULTS
from skancf.materials.isotropic import Isotropic
from skancf.materials.law import SHEAR_CORRECTION, corrected
from skancf.materials.point_law import PointResponse, deformation, require_solid


class Rubber:
    """A law with an energy, elastic and without memory. Those of this library derive from it.

    They give ``parameters``, ``compiled`` and ``_at_points``.
    """

    density: float
    expansion: float
    n_history = 0
    angle = 0.0
    shear_correction = SHEAR_CORRECTION
    limit = ""
    """What deformations the law has no energy for."""
    incompressible: bool
    """Whether volume cannot change."""
    made_compressible = "it poisson = 0.49 or less"
    """What it would need for a volume that changes."""
    parameters: Any
    """The numbers that ``compiled`` takes; of a law of invariants of this library the first is the bulk modulus."""
    compiled: Any
    """Compiled, at one point: (C11, C22, C12, guess of C33 or 0, parameters) to energy, S11, S22, S12, the six numbers of D,
    C33 and a code. For callers that are compiled themselves."""
    _at_points: Any
    _in_solids: Any = None

    @cached_property
    def _numbers(self) -> np.ndarray:
        return np.array(self.parameters, dtype=float)

    def respond(self, C: np.ndarray, guess: np.ndarray | None = None, history: np.ndarray | None = None) -> PointResponse:
        """Plane stress, without an error where it has no solution.

        Parameters
        ----------
        C : (3, n) array
            C11, C22, C12.
        guess : (n,) array, optional
            Of C33, for example the last answer's. What is not greater than zero is no guess.
        history : (0, n) array, optional

        Returns
        -------
        PointResponse
        """
        n = C.shape[1]
        out = np.empty((RESULTS, n))
        self._at_points(C, np.zeros(n) if guess is None else guess, self._numbers, out)
        return PointResponse(out[0], out[1:4], out[4:10], out[10], out[11].astype(np.int64))

    def plane_stress(self, C: Any, guess: Any = None) -> PointResponse:
        """Plane stress: energy, stress, stiffness and C33 of each point.

        Parameters
        ----------
        C : (3, n) array
            C11, C22, C12 of the right Cauchy-Green tensor in the frame of the surface.
        guess : (n,) array, optional
            Of C33.

        Raises
        ------
        BeyondLaw
            For a deformation that the law has no stress for, with the index of the point.
        """
        C = deformation(C)
        if guess is not None:
            guess = np.ascontiguousarray(np.broadcast_to(np.asarray(guess, dtype=float), C.shape[1:]))
        return self.respond(C, guess).checked(self, C)

    def respond3d(self, C: Any) -> PointResponse:
        """Energy, stress and stiffness in three dimensions.

        Parameters
        ----------
        C : (6, n) array
            Components 11, 22, 33, 23, 13, 12 of the right Cauchy-Green tensor.

        Returns
        -------
        PointResponse
            With ``stress`` (6, n), and ``stiffness`` (21, n) in the order of :data:`skancf.materials.point_law.PAIRS_3D`.
            What has no stress is told by its ``code``.

        Raises
        ------
        InputError
            For an incompressible law, whose pressure no deformation tells, and for one that is not of invariants.
        """
        require_solid(self)
        C = deformation(C, 6)
        out = np.empty((SOLID_RESULTS, C.shape[1]))
        self._in_solids(C, self._numbers, out)
        return PointResponse(out[0], out[1:7], out[7:28], C[2].copy(), out[28].astype(np.int64))

    def in_plane_stiffness(self) -> np.ndarray:
        """D of plane stress at the undeformed state, rows and columns 11, 22, 12: (3, 3) (Pa)."""
        return self.stiffness()[np.ix_([0, 1, 5], [0, 1, 5])]

    @abstractmethod
    def stiffness(self) -> np.ndarray:
        """C of small strain, shape (6, 6), of plane stress as of :class:`~skancf.Isotropic`."""

    def thermal_strain(self) -> np.ndarray:
        """Free strain per kelvin, shape (6,)."""
        return self.expansion * np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])


class OfInvariants(Rubber):
    """An isotropic law with a shear modulus, and Poisson's ratio or a bulk modulus if it is compressible."""

    poisson: float | None
    bulk: float | None

    def __post_init__(self) -> None:
        plain(self)
        positive("density", self.density, "kg/m3")
        number("expansion", self.expansion)
        self._check()
        if self.bulk is not None:
            positive("bulk", self.bulk, "Pa")
            if self.poisson is not None:
                raise InputError(f"poisson = {self.poisson}, bulk = {self.bulk}: one follows from the other; give one, or "
                                 "none for an incompressible law")  # fmt: skip
        nu = self.rest_poisson
        if not -1 < nu <= 0.5:
            raise InputError(f"poisson = {nu}: a law of rubber needs -1 < poisson <= 0.5")

    @abstractmethod
    def _check(self) -> None:
        """InputError for parameters of its own."""

    @property
    @abstractmethod
    def shear_modulus(self) -> float:
        """Of small strain (Pa)."""

    @property
    def incompressible(self) -> bool:  # type: ignore[override]
        """Whether volume cannot change."""
        return bool(np.isinf(self.bulk_modulus))

    @property
    def rest_poisson(self) -> float:
        """Poisson's ratio of small strain; 0.5 of an incompressible law."""
        if self.bulk is None:
            return 0.5 if self.poisson is None else number("poisson", self.poisson)
        ratio = self.bulk / self.shear_modulus
        return (3 * ratio - 2) / (6 * ratio + 2)

    @property
    def bulk_modulus(self) -> float:
        """Of small strain (Pa); infinite of an incompressible law."""
        if self.bulk is not None:
            return self.bulk
        nu = self.rest_poisson
        return inf if nu == 0.5 else 2 * self.shear_modulus * (1 + nu) / (3 - 6 * nu)

    def stiffness(self) -> np.ndarray:
        r"""C of small strain, shape (6, 6), of plane stress.

        C33 of an incompressible law is infinite; what stands there is the in-plane :math:`E / (1 - \nu^2)`, for theories
        that have no strain across.
        """
        nu, shear = self.rest_poisson, self.shear_modulus
        young = 2 * shear * (1 + nu)
        if nu < 0.5:
            return Isotropic(young, nu, self.density, shear_correction=self.shear_correction).stiffness()
        plate = young / (1 - nu**2)
        full = np.diag([plate, plate, plate, shear, shear, shear])
        full[0, 1] = full[1, 0] = nu * plate
        return corrected(full, self.shear_correction)

    def thinning(self) -> np.ndarray:
        """Strain 33 per unit of 11, 22, 12 in plane stress, of small strain: (3,)."""
        nu = self.rest_poisson
        return -nu / (1 - nu) * np.array([1.0, 1.0, 0.0])
