"""Whether an energy of one's own is one: analytic, of a body that is at rest and stable, and the same when compiled."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numba.core.errors import NumbaError

from skancf.errors import InputError, shown
from skancf.functions import Noted
from skancf.materials.hyperelastic.own_kernels import TINY_STEP
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


def check_energy(law: Any) -> None:
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
    _check_rest(law, max(found))


def _check_derivative(law: Any, arguments: np.ndarray, names: Sequence[str], k: int) -> float:
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
                         "real, conj and cases that depend on them, powers such as x**3 of what may be negative as "
                         "x * x * x, and check that it is smooth")  # fmt: skip
    return largest


def _try_in_python(law: Any, row: np.ndarray) -> None:
    """InputError for parameters that are not there, which compiled functions do not look for, and for other numbers than
    those of the compiled function."""
    try:
        value = complex(getattr(law.energy, "py_func", law.energy)(*map(complex, row), law._numbers))
    except IndexError as wrong:
        raise InputError(f"energy: it asks for more than the {len(law._numbers)} parameters that were given ({wrong})"
                         ) from wrong  # fmt: skip
    except Exception:
        return  # the compiler says what is wrong, or nothing is
    compiled = _complex(law, row.tolist())
    if abs(compiled - value) > SAME_VALUE * abs(value):
        raise InputError(f"energy: compiled it is {compiled.real:.9g}, and as it stands {value.real:.9g}, at the same "
                         "deformation: an array or a number that it takes from around it has changed since it was compiled; "
                         "hand such over as parameters")  # fmt: skip


def _invariants(states: np.ndarray) -> np.ndarray:
    a, b, c, d = states.T
    p = a * b - d * d
    return np.column_stack([a + b + c, p + c * (a + b), np.sqrt(p * c)])


def _complex(law: Any, row: Sequence[float], imaginary: int = -1, step: float = 0.0) -> complex:
    """The energy at some arguments, one of which has an imaginary part."""
    arguments = [complex(value, step if k == imaginary else 0.0) for k, value in enumerate(row)]
    try:
        with Noted("energy"), np.errstate(all="ignore"):
            value = law._compiled_energy(*arguments, law._numbers)
    except (NumbaError, NotImplementedError) as wrong:
        raise InputError(f"energy: numba cannot compile it for complex numbers ({_cause(wrong)}); write it with numbers, "
                         "numpy functions such as np.log, other functions that are compiled (@numba.njit), and entries of "
                         "the parameters") from wrong  # fmt: skip
    if not isinstance(value, int | float | complex | np.number):
        raise InputError(f"energy: it returned {shown(value)}; it must return one number")
    return complex(value)


def _cause(wrong: Exception) -> str:
    """What a compiler says, in one line, without where in itself it was."""
    lines = [line.strip(" -") for line in str(wrong).splitlines()]
    said = [line for line in lines if line and not line.startswith(ABOUT_ITSELF)]
    return said[0].rstrip(":") if said else type(wrong).__name__


ABOUT_ITSELF = ("Failed in", "File ", "During:", "[1]", "[2]", "Overload", "Traceback", "<numba")
"""Beginnings of lines in which the compiler speaks of itself."""


def _check_rest(law: Any, largest: float) -> None:
    energy, ga, gb, gd, gc, _, _, _, cc = law._rest[:9]
    found = law.respond(np.array([[1.0], [1.0], [0.0]]))
    D = law.in_plane_stiffness()
    scale = np.abs(D).max()
    if scale < SAME_VALUE * largest:
        raise InputError(f"energy: the undeformed state has no stiffness, {scale:.3g} Pa, and its derivatives elsewhere are "
                         f"{largest:.3g}; it must grow with the square of small strains, as mu / 2 (I1 - 3) does")
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
