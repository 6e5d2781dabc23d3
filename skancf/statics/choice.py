"""The cheapest theory whose modelling error is small enough: ``theory="auto"`` of a problem."""

from collections.abc import Callable
from dataclasses import dataclass

from skancf.errors import InputError, SingularMatrix, warn
from skancf.problem import CHOICES
from skancf.showing import short
from skancf.statics.conditioned import is_loaded
from skancf.statics.linear import small_change
from skancf.system.linearised import Linearised
from skancf.system.system import System
from skancf.theories import Full, Kirchhoff, Theory
from skancf.thinness import ShearForm, first_share, share_of


@dataclass(frozen=True)
class Choice:
    """Which theory was taken, and why.

    Attributes
    ----------
    theory : str
    share : float
        By how much leaving shear out changes the strain energy of the small-deflection answer, as a part of it; without
        loads by how much it changes the square of the first frequency. NaN where neither is there.
    reason : str

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> chosen = plate.on(sk.meshes.uniform(plate.surface, 6, 6), theory="auto").choice
    >>> print(chosen.theory)
    kirchhoff
    """

    theory: str
    share: float
    reason: str

    __repr__ = short


def choose(on: Callable[[Theory], System], tolerance: float) -> System:
    """The system of the cheapest theory whose modelling error is below a tolerance, with its ``choice``; of the thin theory,
    with a warning, where the other one is asked for and cannot be taken.

    Parameters
    ----------
    on : callable
        Gives the system with a theory.
    tolerance : float
        Of :attr:`Choice.share`.

    Raises
    ------
    InputError
        Where there is nothing to judge by: a motion is free under the loads, or nothing strains the surface.
    """
    try:
        thin = on(Kirchhoff())
    except InputError as unfit:
        choice = Choice("full", float("nan"), f"theory 'full': {unfit}")
    else:
        choice = assessed(thin, tolerance)
    if choice.share <= tolerance:
        thin.choice = choice
        return thin
    try:
        system = on(Full())
    except InputError as unfit:
        if choice.share != choice.share:
            raise
        system, choice = thin, _without_full(choice, unfit)
    system.choice = choice
    return system


def _without_full(choice: Choice, unfit: InputError) -> Choice:
    """The thin theory all the same, where the other one cannot be taken; with a warning."""
    reason = f"theory 'kirchhoff', though theory 'full' would be asked for ({choice.reason}): it cannot be taken, as {unfit}"
    warn(reason)
    return Choice("kirchhoff", choice.share, reason)


CHOICES["auto"] = choose


def assessed(system: System, tolerance: float) -> Choice:
    """Of a system of the thin theory, by its small-deflection answer, without loads by its first vibration."""
    if not is_loaded(system, system.undeformed):
        what = "without loads: leaving transverse shear and rotary inertia out changes the square of the first frequency"
        return _chosen(first_share(system), what, tolerance)
    way_out = "name the theory, 'kirchhoff' or 'full'"
    try:
        change = small_change(system)
    except SingularMatrix as free:
        raise InputError(f"theory = 'auto' judges by a static answer, which does not exist ({free}); {way_out}") from free
    model = Linearised(system)
    energy, heat = model.strain_energy(change), system.shell.thermal_energy()
    if not (energy > 0 or heat > 0):
        raise InputError(f"theory = 'auto': nothing strains the surface, so that there is nothing to judge by; {way_out}")
    form = ShearForm(system)
    fields = form.of_state(model, change)
    share = share_of(form.product(fields, fields), energy, heat)
    return _chosen(share, "leaving transverse shear out changes the strain energy", tolerance)


def _chosen(share: float, what: str, tolerance: float) -> Choice:
    name, than = ("kirchhoff", "no more than") if share <= tolerance else ("full", "more than")
    return Choice(name, share, f"theory '{name}': {what} by {100 * share:.3g} %, {than} the {100 * tolerance:.3g} % asked")
