"""The cheapest theory whose modelling error is small enough."""

from dataclasses import dataclass

from skancf.errors import InputError, SingularMatrix
from skancf.system.system import System
from skancf.thinness.form import ShearForm
from skancf.thinness.vibration import first_share


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
    """

    theory: str
    share: float
    reason: str


FREE = 1e-9
"""Of the energy of a temperature change that is held back: less than this is none."""


def share_of(product: float, energy: float, heat: float) -> float:
    """F(u, u) over twice the strain energy; zero where a temperature change of the energy ``heat`` strains a body freely, so
    that both are rounding."""
    return 0.0 if energy <= FREE * heat else product / (2 * energy)


def choose(system: System, tolerance: float) -> Choice:
    """The cheapest theory whose modelling error is below a tolerance.

    From the small-deflection answer of the thin one, without loads from its first vibration.

    Raises
    ------
    InputError
        Where there is neither: a motion is free under the loads, or nothing strains the surface.
    """
    if not _loaded(system):
        what = "without loads: leaving transverse shear and rotary inertia out changes the square of the first frequency"
        return _chosen(first_share(system), what, tolerance)
    way_out = "name the theory, 'kirchhoff' or 'full'"
    try:
        change = system.linear_change()
    except SingularMatrix as free:
        raise InputError(f"theory = 'auto' judges by a static answer, and there is none ({free}); {way_out}") from free
    energy, heat = system.linear_energy(change), system.shell.thermal_energy()
    if not (energy > 0 or heat > 0):
        raise InputError(f"theory = 'auto': nothing strains the surface, so that there is nothing to judge by; {way_out}")
    form = ShearForm(system)
    fields = form.of_state(system.undeformed + change, change)
    share = share_of(form.product(fields, fields), energy, heat)
    return _chosen(share, "leaving transverse shear out changes the strain energy", tolerance)


def _chosen(share: float, what: str, tolerance: float) -> Choice:
    name, than = ("kirchhoff", "no more than") if share <= tolerance else ("full", "more than")
    return Choice(name, share, f"theory '{name}': {what} by {100 * share:.3g} %, {than} the {100 * tolerance:.3g} % asked")


def _loaded(system: System) -> bool:
    """Does anything load the system, temperature and moved supports included?"""
    return bool(system.external_force(system.undeformed).any() or system.prescribed().any())
