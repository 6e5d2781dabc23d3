"""An energy of the user's own."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from inspect import signature
from typing import Any

import numba
import numpy as np
from numba.core.errors import NumbaError

from skancf.arguments import flag, function, plain
from skancf.errors import InputError, finite, number, positive, shown
from skancf.functions import Noted
from skancf.materials.hyperelastic.law import Rubber
from skancf.materials.hyperelastic.own_kernels import TINY_STEP, Kernels, kernels_of
from skancf.materials.law import corrected
from skancf.tolerances import ROUNDED_SUM, SAME_VALUE

EXAMPLE = "a function of (I1, I2, J, parameters) or of (C11, C22, C33, C12, parameters)"
DIFFERENCE = 2.0**-17
"""A real step: the third root of rounding, for a difference of two values."""
NOT_EQUAL = 1e-5
"""What a derivative and a difference may differ by, of the largest."""
STATES = np.array([
    [1.0, 1.0, 1.0, 0.0], [1.21, 0.9, 0.85, 0.0], [0.8, 1.3, 1.05, 0.1], [1.1, 1.15, 0.9, -0.2], [1.5, 0.75, 0.95, 0.05],
])  # fmt: skip
"""C11, C22, C33, C12 at which an energy is tried."""


@dataclass(frozen=True)
class Hyperelastic(Rubber):
    r"""A law with an energy of your own, of the invariants of C or of its components.

    Stress and stiffness are its derivatives, by steps into the complex plane: exact to ten and more digits. So the function
    is called with complex numbers, and must be analytic: without ``abs``, ``max``, ``real``, and roots of what is zero. It
    is compiled by numba.

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

    def __post_init__(self) -> None:
        plain(self)
        function("energy", self.energy, EXAMPLE)
        given = [self.parameters] if np.ndim(self.parameters) == 0 else self.parameters
        array = finite("parameters", given).copy()
        if array.ndim != 1:
            raise InputError(f"parameters of shape {array.shape}: give a row of numbers")
        array.flags.writeable = False
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
        return self.energy if hasattr(self.energy, "py_func") else _compiled(self.energy)

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


def check_energy(law: Hyperelastic) -> None:
    """InputError for an energy that cannot be differentiated by complex steps, or is no energy of a stable body at rest."""
    states = STATES.copy()
    if law.incompressible:
        states[:, 2] = 1 / (states[:, 0] * states[:, 1] - states[:, 3] ** 2)
    arguments = states if law.of_components else _invariants(states)
    _try_in_python(law, arguments[1])
    names = ("C11", "C22", "C33", "C12") if law.of_components else ("I1", "I2", "J")
    held = ("C33" if law.of_components else "J") if law.incompressible else ""
    found = [_check_derivative(law, arguments, names, k) for k in range(len(names)) if names[k] != held]
    if not max(found):
        raise InputError("energy: its derivatives are zero; it must grow with the deformation")
    _check_rest(law)


def _check_derivative(law: Hyperelastic, arguments: np.ndarray, names: Sequence[str], k: int) -> float:
    """The largest derivative by argument k; InputError where a complex step and a difference are not one."""
    wrong, largest, noise = (0.0, ""), 0.0, 0.0
    for row in arguments:
        unit = DIFFERENCE * np.eye(len(row))[k]
        found = _complex(law, row, k, TINY_STEP).imag / TINY_STEP
        up, down = (_complex(law, row + sign * unit).real for sign in (1, -1))
        difference = (up - down) / (2 * DIFFERENCE)
        where = ", ".join(f"{name} = {value:.4g}" for name, value in zip(names, row, strict=True))
        if not np.isfinite([found, difference]).all():
            raise InputError(f"energy: it, or its derivative by {names[k]}, is not finite at {where}; it must have both "
                             "near the undeformed state, write it without roots and logarithms of zero")  # fmt: skip
        largest, noise = max(largest, abs(found), abs(difference)), max(noise, abs(up), abs(down))
        wrong = max(wrong, (abs(found - difference), f"the derivative by {names[k]} at {where} is {found:.6g} by a complex "
                            f"step and {difference:.6g} by a difference"))  # fmt: skip
    if wrong[0] > NOT_EQUAL * largest + ROUNDED_SUM * noise / DIFFERENCE:
        raise InputError(f"energy: derivatives are taken by complex steps, and {wrong[1]}; write it without abs, max, min, "
                         "real, conj and cases that depend on them, and check that it is smooth")  # fmt: skip
    return largest


def _try_in_python(law: Hyperelastic, row: np.ndarray) -> None:
    """InputError for parameters that are not there, which compiled functions do not look for."""
    try:
        getattr(law.energy, "py_func", law.energy)(*map(complex, row), law._numbers)
    except IndexError as wrong:
        raise InputError(f"energy: it asks for more than the {len(law._numbers)} parameters that were given ({wrong})"
                         ) from wrong  # fmt: skip
    except Exception:
        return  # the compiler says what is wrong, or nothing is


def _invariants(states: np.ndarray) -> np.ndarray:
    a, b, c, d = states.T
    p = a * b - d * d
    return np.column_stack([a + b + c, p + c * (a + b), np.sqrt(p * c)])


def _complex(law: Hyperelastic, row: Sequence[float], imaginary: int = -1, step: float = 0.0) -> complex:
    """The energy at some arguments, one of which has an imaginary part."""
    arguments = [complex(value, step if k == imaginary else 0.0) for k, value in enumerate(row)]
    try:
        with Noted("energy"), np.errstate(all="ignore"):
            value = law._compiled_energy(*arguments, law._numbers)
    except (NumbaError, NotImplementedError) as wrong:
        first = next((line.strip() for line in str(wrong).splitlines() if line.strip()), type(wrong).__name__)
        raise InputError(f"energy: numba cannot compile it for complex numbers ({first}); write it with numbers, "
                         "numpy functions such as np.log, and entries of the parameters") from wrong  # fmt: skip
    if not isinstance(value, int | float | complex | np.number):
        raise InputError(f"energy: it returned {shown(value)}; it must return one number")
    return complex(value)


def _check_rest(law: Hyperelastic) -> None:
    energy, ga, gb, gd, gc, _, _, _, cc = law._rest[:9]
    found = law.respond(np.array([[1.0], [1.0], [0.0]]))
    D = law.in_plane_stiffness()
    scale = np.abs(D).max()
    slopes = {"C11": ga, "C22": gb, "C12": gd} | ({} if law.incompressible else {"C33": gc})
    if law.incompressible and not law.of_components:
        slopes = {"S11": found.stress[0, 0], "S22": found.stress[1, 0]}
    name, worst = max(slopes.items(), key=lambda item: abs(item[1]))
    if not law.incompressible or law.of_components:
        name = f"the derivative by {name}"
    if not abs(worst) <= SAME_VALUE * scale:
        raise InputError(f"energy: the undeformed state has stress, {name} is {worst:.6g} Pa at C = 1; change the energy so "
                         "that it has a minimum there, as mu / 2 (I1 - 3) - mu ln J has")  # fmt: skip
    if abs(energy) > SAME_VALUE * scale:
        raise InputError(f"energy: it is {energy:.6g} J/m3 in the undeformed state; subtract that: a body at rest has "
                         "no strain energy")  # fmt: skip
    lowest = float(np.linalg.eigvalsh(D)[0]) if np.isfinite(D).all() else np.nan
    if not lowest > SAME_VALUE * scale or (not law.incompressible and not cc > 0):
        raise InputError(f"energy: the undeformed state is not stable, some strain releases energy (smallest eigenvalue "
                         f"{lowest:.6g} Pa of D, and {4 * cc:.6g} Pa across); check signs and parameters")  # fmt: skip
