"""The error of a number that leaving shear out makes, from thin fields alone."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from skancf.adaptive.estimate import check_quantity, given_way, gradient_of, value_of
from skancf.adaptive.interpolation import multipliers_on
from skancf.adaptive.quantities import Quantity, SectionForce, StrainEnergy
from skancf.conditions.solver import curved
from skancf.errors import InputError
from skancf.linear import DirectSolver, check_backend
from skancf.progress import Bar, ShowProgress, check_progress
from skancf.showing import short
from skancf.solution import Solution
from skancf.states import StateLike, solution_of
from skancf.statics.conditioned import factored_about, rows_of, solved
from skancf.statics.corrections import skew_part
from skancf.thinness import Fields, ShearForm, moment_rates

SOUND = 0.2
"""Part of a number up to which the estimate is good; beyond it terms of second order count, and only its size is meant."""
LARGE = 0.1
"""Membrane strain from which on a law at points has another shear stiffness than that of the undeformed state."""


@dataclass(frozen=True)
class TheoryError:
    """By how much leaving transverse shear out changes a number.

    Attributes
    ----------
    value : float
        The number of a plate with shear less that of the thin theory, to first order, in the unit of the quantity. NaN where
        it cannot be told.
    share : float
        That over the number; NaN where that is zero.
    sound : bool
        Is it an estimate to count on, not an order of magnitude only?
    note : str
        Why it is not, or cannot be told.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> system = plate.on(sk.meshes.uniform(plate.surface, 6, 6), "kirchhoff")
    >>> missing = sk.theory_error(sk.solve_linear(system))
    >>> print(missing.sound, f"{100 * missing.share:.2f} % of the energy")
    True 0.27 % of the energy
    """

    value: float
    share: float
    sound: bool = True
    note: str = ""

    __repr__ = short


NOTHING = TheoryError(0.0, 0.0)


def unknown(why: str) -> TheoryError:
    """That it cannot be told."""
    return TheoryError(float("nan"), float("nan"), False, why)


def theory_error(
    solution: StateLike, quantity: Quantity | None = None, *, backend: str = "auto", progress: ShowProgress = True
) -> TheoryError:
    r"""By how much transverse shear, which theory `kirchhoff` leaves out, would change a number.

    With the dual weight z of the number, the answer to :math:`\partial J / \partial q` with the tangent of the state,

    .. math:: J_{\text{with shear}} - J \approx F(u, z), \qquad U_{\text{with shear}} - U \approx F(u, z) - \tfrac12 F(u, u)

    for a quantity and for the strain energy, with the form F of :mod:`skancf.thinness.form`. Nothing thick is computed; it
    takes one solve, for the energy of a small-deflection answer under loads alone, where z = u, none. It is good while it is
    less than a fifth of the number. In theory `full` it is zero.

    Parameters
    ----------
    solution : Solution, or a result that stands for one
        An equilibrium.
    quantity : Quantity, optional
        Default: the strain energy.
    backend : str
        Of the linear solver.
    progress : bool or callable
        A bar, nothing, or a function that is told of each part; see :class:`~skancf.Progress`.

    Raises
    ------
    InputError
        For a section force at a point, whose dual weight is too singular; take its mean over two elements or more each way,
        ``SectionForce(..., within=...)``. For a state of a motion, and what is no state or quantity.
    SingularMatrix
        Where the tangent of the state is singular.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> system = plate.on(sk.meshes.uniform(plate.surface, 6, 6), "kirchhoff")
    >>> missing = sk.theory_error(sk.solve_linear(system), sk.Displacement(at=(0.5, 0.5)))
    >>> print(f"{100 * missing.share:.2f} % of the deflection")
    0.19 % of the deflection
    """
    solution = solution_of("solution", solution)
    check_backend(backend)
    check_progress(progress)
    quantity = StrainEnergy() if quantity is None else quantity
    check_quantity(quantity)
    if solution.system.geometry.theory.shear:
        return NOTHING
    if solution.velocity is not None or solution.time is not None:
        raise InputError("the error of the theory is that of an equilibrium, and this is a state of a motion; give one of "
                         "solve or solve_linear")  # fmt: skip
    if isinstance(quantity, SectionForce) and quantity.at is not None:
        raise InputError(f"SectionForce({quantity.component!r}, at={quantity.at}): what the theory leaves out of a section "
                         "force at a point cannot be told by its dual weight, which is too singular there; give a mean over "
                         "two elements or more each way, SectionForce(..., within=((x0, x1), (y0, y1)))")  # fmt: skip
    with Bar("error of the theory", 2, progress) as bar:
        form, fields = solution.shear_fields()
        bar.next("shear of the state")
        change = form.product(fields, _dual(form, solution, quantity, backend))
        bar.next("dual weight")
    if isinstance(quantity, StrainEnergy):
        change -= 0.5 * form.product(fields, fields)
    notes = (_coarse(quantity, solution), _stretched(solution))
    return assessed(change, value_of(quantity, solution), "; ".join(note for note in notes if note))


def theory_error_or_why(solution: Solution, quantity: Quantity, backend: str) -> TheoryError:
    """:func:`theory_error`, or the reason why it cannot be given."""
    try:
        return theory_error(solution, quantity, backend=backend, progress=False)
    except Exception as none:  # a user's quantity may fail in many ways, and the rest of a result is there
        return unknown(str(none))


def of_eigenvalue(value: float, share: float) -> TheoryError:
    """That of a frequency or buckling load, of which a part changes."""
    return assessed(value * share, value) if np.isfinite(share) else unknown("the motion has no stiffness, or is not stable")


def assessed(change: float, value: float, note: str = "") -> TheoryError:
    """A change of a number as its error, said to be of an order of magnitude only where it is large."""
    if np.isnan(change):
        return unknown("its fields are no numbers somewhere; take a finer mesh")
    if change == 0:
        return replace(NOTHING, sound=not note, note=note)
    share = change / value if value else float("nan")
    if not abs(change) < SOUND * abs(value):
        large = f"of an order of magnitude only, as it is no less than {SOUND:g} of the number"
        note = f"{note}; {large}" if note else large
    return TheoryError(change, share, not note, note)


def _dual(form: ShearForm, state: Solution, quantity: Any, backend: str) -> Fields:
    """Fields of the dual weight."""
    system = state.system
    at = state.about
    if isinstance(quantity, StrainEnergy) and _is_loaded_alone(state):
        weight = state.change
    else:
        lift = quantity.lift(state) if hasattr(quantity, "lift") else None
        weight = _weight(state, quantity, lift, backend)
        if lift is not None:
            weight = weight - lift
    fields = form.fields(moment_rates(system, at, weight))
    # The weight of the energy is the answer to the loads themselves, eccentric weight and moments on edges among them.
    return form.loaded(fields, state.q) if isinstance(quantity, StrainEnergy) else fields


def _is_loaded_alone(state: Solution) -> bool:
    """Is the dual weight of the energy the answer itself? In small deflections without moved supports and free strains, and
    with conditions that do not move."""
    system, start = state.system, state.system.undeformed
    moved = system.prescribed().any() or not system.conditions.met(system.conditions.value(start))
    return state.linear and not moved and not system.shell.heats


def _weight(state: Solution, quantity: Any, lift: np.ndarray | None, backend: str) -> np.ndarray:
    """With conditions a motion that keeps them, or that changes them as a motion ``lift`` of supports does."""
    system, model, x = state.system, state.model, state.unknowns
    tangent, skew = model.tangent(x, state.case), skew_part(model, x, state.load_factor)
    if not state.linear:
        tangent = curved(system, tangent, x, multipliers_on(state, system))
    with DirectSolver(system.pattern, system.constraints, backend) as solver:
        factors = factored_about(system, solver, tangent, None if skew is None else -skew, state.about)
        values = given_way(quantity, state, lift, lambda change: rows_of(factors, change))
        return solved(factors, gradient_of(quantity, state), values)[0]


def _stretched(state: Solution) -> str:
    """That a law at points is far from its small strain."""
    assembly: Any = state.system.assembly
    if assembly.linear or state.linear:
        return ""
    strains = assembly.section_strains(state.system.shell.nodal(state.q), np.array([[0.5], [0.5]]))[0][..., :3]
    largest = float(np.abs(strains).max())
    if largest < LARGE:
        return ""
    return (f"of an order of magnitude only, as the shear stiffness is that of the undeformed material, and membrane "
            f"strains reach {largest:.2g}")  # fmt: skip


def _coarse(quantity: Any, state: Solution) -> str:
    """That a mean is over too few elements."""
    if not (isinstance(quantity, SectionForce) and quantity.within is not None):
        return ""
    geometry, (elements, _, _) = state.system.geometry, quantity.weights(state.system)
    corners = geometry.mesh.p[:, geometry.mesh.t[:, elements]]
    starts = corners.min(axis=1) / np.ptp(geometry.mesh.p, axis=1)[:, None]
    if min(len(np.unique(np.round(start, 9))) for start in starts) >= 2:
        return ""
    return "of an order of magnitude only, as the mean is over one element across"
