"""What is checked about a motion when its run ends."""

import numpy as np

from skancf.checks import Check, failures
from skancf.dynamics.ledger import Ledger
from skancf.dynamics.motion import Motion
from skancf.errors import warn
from skancf.tolerances import SAME_VALUE

MOMENTA = "momentum without a source"
NOT_FOLLOWED = 0.1
"""Part of the strain energy that a rule may take out before it is said."""
MISSED = 0.02
"""Part of a load's impulse that steps of a control without an asked error may miss before it is said."""


def checks_of(
    ledger: Ledger, *, mass: float, size: float, missed: float, noise: float, balance: float | None, rtol: float | None
) -> tuple[Check, ...]:
    r"""Balances of energy and momenta, the impulse of loads, and what the rule took out.

    Energy without a source is compared with the largest energy E of any kind, linear momentum without one with
    :math:`\sqrt{2 m T}`, T being the largest kinetic energy, or with itself where that is more, angular momentum with that
    times the size of the body, or itself, and numerical dissipation with the largest strain energy. What rounding may leave
    is allowed on top.

    Parameters
    ----------
    ledger : Ledger
    mass, size : float
        Of the body (kg, m).
    missed : float
        The largest part of a load's impulse that the steps missed.
    noise : float
        Energy that is rounding (J).
    balance : float or None
        Tolerance of the balances; None: they are not checked.
    rtol : float or None
        The asked error, if one was asked.
    """
    found = []
    if balance is not None:
        found.append(Check(
            "energy without a source", float(np.abs(ledger.balance).max()) / (float(ledger.turnover[-1]) + noise / balance),
            balance,
            "Take shorter steps (a smaller rtol or dt), or rule=EnergyMomentum(), which keeps the balance.",
        ))  # fmt: skip
        moved, unknown = (np.sqrt(2 * mass * energy) for energy in (float(ledger.kinetic.max()), noise))
        for k, (name, arm) in enumerate((("linear", 1.0), ("angular", size))):
            own = max(float(np.linalg.norm(getattr(ledger, part), axis=1).max()) for part in (name, f"{name}_impulse"))
            left = np.linalg.norm(ledger.momentum_balance[:, k], axis=1).max()
            found.append(Check(
                f"{name} {MOMENTA}", float(left) / (max(own, arm * moved) + arm * unknown / balance), balance,
                "Take shorter steps (a smaller rtol or dt), or rule=EnergyMomentum(), which keeps momenta.",
            ))  # fmt: skip
    found.append(Check(
        "impulse of a load that the steps missed", missed, MISSED if rtol is None else max(2 * rtol, SAME_VALUE),
        "The steps are too long for a load's function of time: take rtol instead of dt, or give the function knots where it "
        "jumps.",
    ))  # fmt: skip
    found.append(Check(
        "numerical dissipation over the largest strain energy",
        float(ledger.numerical[-1]) / max(float(ledger.strain.max()), noise), NOT_FOLLOWED,
        "The motion is followed, vibrations of the stress that are as large as that are not: a smaller rtol or dt follows "
        "them.",
    ))  # fmt: skip
    return tuple(found)


def warn_of(motion: Motion) -> None:
    """Warn of a motion that reached its end and failed a check."""
    failed = failures(motion.checks) if motion.ok else ""
    if failed:
        warn(failed)
