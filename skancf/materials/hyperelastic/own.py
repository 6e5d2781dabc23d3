"""An energy of the user's own."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from inspect import signature
from types import FunctionType
from typing import Any

import numba
import numpy as np

from skancf.arguments import flag, function, plain
from skancf.equality import by_value
from skancf.errors import InputError, finite, number, positive, shown
from skancf.materials.hyperelastic.law import Rubber
from skancf.materials.hyperelastic.own_check import EXAMPLE, check_energy
from skancf.materials.hyperelastic.own_kernels import Kernels, kernels_of
from skancf.materials.law import corrected
from skancf.showing import short


@by_value
@dataclass(frozen=True)
class Hyperelastic(Rubber):
    r"""A law with an energy of your own, of the invariants of C or of its components.

    Stress and stiffness are its derivatives, by steps into the complex plane: exact to ten and more digits. So the function
    is called with complex numbers, and must be analytic: without ``abs``, ``max``, ``real``, and roots of what is zero; the
    third and higher powers of what may be negative are products, ``x * x * x``, as powers of complex numbers are rounded. It
    is compiled by numba; numbers and arrays that it takes from around it are those of the time when it is first used.

    Parameters
    ----------
    energy : callable
        Of ``(I1, I2, J, parameters)`` or ``(C11, C22, C33, C12, parameters)``, with or without ``@numba.njit``: energy per
        undeformed volume (J/m3), zero and without stress in the undeformed state. An isotropic energy is faster as one of
        invariants. Of an incompressible law J is 1, and C33 is :math:`1 / (C_{11} C_{22} - C_{12}^2)`.
    parameters : sequence of float
        Handed to it as an array.
    density : float
        Mass per undeformed volume (kg/m3).
    incompressible : bool
        Whether volume cannot change.
    expansion : float
        Coefficient of thermal expansion (1/K).
    transverse_shear : float, optional
        Shear modulus of 13 and 23 (Pa), for what is told of the shear that thin theories leave out. Default: that of 12.

    Raises
    ------
    InputError
        For a function that takes no complex numbers, is not analytic, not finite, has energy or stress in the undeformed
        state, or an unstable one.

    Examples
    --------
    >>> import numba
    >>> @numba.njit
    ... def energy(I1, I2, J, parameters):
    ...     mu, k = parameters
    ...     return 0.5 * mu * (I1 - 3.0) + k * (I1 - 3.0) ** 2
    >>> rubber = sk.Hyperelastic(energy, (0.4e6, 0.02e6), density=1000.0, incompressible=True)
    """

    energy: Callable[..., Any]
    parameters: Any
    density: float
    incompressible: bool = False
    expansion: float = 0.0
    transverse_shear: float | None = None
    limit = "the energy that was given is not finite there"
    made_compressible = "energy a term of the volume J and incompressible = False"

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        function("energy", self.energy, EXAMPLE)
        array = np.atleast_1d(finite("parameters", self.parameters))
        if array.ndim != 1:
            raise InputError(f"parameters of shape {array.shape}: give a row of numbers")
        object.__setattr__(self, "parameters", tuple(array.tolist()))
        positive("density", self.density, "kg/m3")
        number("expansion", self.expansion)
        object.__setattr__(self, "incompressible", flag("incompressible", self.incompressible))
        if self.transverse_shear is not None:
            positive("transverse_shear", self.transverse_shear, "Pa")
        check_energy(self)

    @cached_property
    def of_components(self) -> bool:
        """Whether the energy is one of components, not of invariants."""
        names = list(signature(getattr(self.energy, "py_func", self.energy)).parameters)
        if len(names) not in (4, 5):
            raise InputError(f"energy: a function of {len(names)} arguments ({', '.join(names)}); give {EXAMPLE}")
        return len(names) == 5

    @cached_property
    def _compiled_energy(self) -> Any:
        if hasattr(self.energy, "py_func"):
            return self.energy
        if not isinstance(self.energy, FunctionType):
            raise InputError(f"energy = {shown(self.energy)}: functions are compiled, and this is a "
                             f"{type(self.energy).__name__}; give a function (def or lambda), and what it needs as "
                             "parameters")  # fmt: skip
        return _compiled(self.energy)

    @cached_property
    def _kernels(self) -> Kernels:
        return kernels_of(self._compiled_energy, self.of_components, self.incompressible)

    @property
    def compiled(self) -> Any:
        return self._kernels.at_point

    @property
    def _at_points(self) -> Any:
        return self._kernels.at_points

    @property
    def _in_solids(self) -> Any:
        return self._kernels.in_solids

    @cached_property
    def _rest(self) -> tuple[float, ...]:
        """Energy, first and second derivatives by C11, C22, C12, C33 at the undeformed state."""
        return tuple(self._kernels.at_rest(self._numbers))

    def in_plane_stiffness(self) -> np.ndarray:
        """D of plane stress at the undeformed state, rows and columns 11, 22, 12: (3, 3) (Pa)."""
        found = self.respond(np.array([[1.0], [1.0], [0.0]])).stiffness[:, 0]
        return found[np.array([[0, 3, 4], [3, 1, 5], [4, 5, 2]])]

    def stiffness(self) -> np.ndarray:
        """C of small strain, shape (6, 6), of plane stress; C33 of an incompressible law is the largest in the plane."""
        plane = self.in_plane_stiffness()
        shear = plane[2, 2] if self.transverse_shear is None else self.transverse_shear
        across = max(plane[0, 0], plane[1, 1]) if self.incompressible else 4 * self._rest[8]
        full = np.diag([0.0, 0.0, across, shear, shear, 0.0])
        full[np.ix_([0, 1, 5], [0, 1, 5])] = plane
        return corrected(full, self.shear_correction)

    def thinning(self) -> np.ndarray:
        """Strain 33 per unit of 11, 22, 12 in plane stress, of small strain: (3,)."""
        if self.incompressible:
            return np.array([-1.0, -1.0, 0.0])
        cc, ac, bc, dc = self._rest[8], *self._rest[12:]
        return -np.array([ac, bc, 0.5 * dc]) / cc


_known: dict[Callable[..., Any], Any] = {}


def _compiled(energy: Callable[..., Any]) -> Any:
    """A Python function, compiled; one for each function, so that its kernels are made once."""
    if energy not in _known:
        _known[energy] = numba.njit(nogil=True, error_model="numpy")(energy)
    return _known[energy]
