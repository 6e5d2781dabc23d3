"""The energy-momentum rule, which takes energy only out of what steps do not resolve."""

from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp

from skancf.arguments import plain
from skancf.conditions.sums import Conditions
from skancf.dynamics.midpoint import ImplicitMidpoint
from skancf.dynamics.state import State
from skancf.errors import InputError, number
from skancf.history import Case
from skancf.linear import BlockMatrix
from skancf.system.system import System
from skancf.terms.shell import Shell, total
from skancf.tolerances import NEWTON_DAMPED, NEWTON_EXACT

LEAST = 1 / 3
"""The smallest spectral radius that a real dissipation has."""


@dataclass(frozen=True)
class EnergyMomentum(ImplicitMidpoint):
    r"""The midpoint rule with an internal force that does the work of its stresses exactly, and dissipation of order three.

    .. math::
        M \frac{v_{n+1} - v_n}{\Delta t} + D\varepsilon^T S = f_{ext}(q_{1/2}, t_{1/2}), \qquad
        D\varepsilon \cdot u = \varepsilon_{n+1} - \varepsilon_n, \\
        S = \tfrac12 (S_n + S_{n+1}) + \chi\,[(S_{n+1} - S_n) - r\,(S_n - S_{n-1})], \qquad
        r = \min(1, \Delta t_{n+1} / \Delta t_n), \qquad \chi = \frac{\rho_\infty (1 - \rho_\infty)}{2 (1 + \rho_\infty)^2}

    Linear and angular momentum are kept to what Newton's method leaves, at any step. So is energy with ``rho_inf = 1``; with
    less it never grows: :math:`E_n + \tfrac12\chi\,|\Delta\varepsilon_n|^2` falls in every step of constant length by
    :math:`\tfrac12\chi\,|\Delta\varepsilon_{n+1} - \Delta\varepsilon_n|^2` in the norm of the law, which is little for what
    steps resolve (damping ratio :math:`\chi (\omega \Delta t)^3 / 4`) and most of it for what they do not. The ledger books
    it as numerical dissipation. A step that is longer than the one before is damped to first order, by
    :math:`\chi\,(\Delta t_{n+1} - \Delta t_n)` of the rate of stresses, and so is the first one, and the first after a jump.
    A body that turns at a constant strain loses nothing.

    With a law at points, which is not linear, the mean of the stresses has a part besides, with which it does the work of
    the law's energy on the change of the strains: energy and momenta are kept as well. The dissipation then has the stresses
    of small strain, :math:`\chi\,C\,[\Delta\varepsilon_{n+1} - r\,\Delta\varepsilon_n]`, so that it never raises the
    energy, whatever the law.

    In theory `full` strains are quadratic in q and :math:`D\varepsilon` is their gradient at the middle; in `kirchhoff` it
    is the :func:`~skancf.theories.kirchhoff.point.discrete_gradient` at each integration point.

    Parameters
    ----------
    rho_inf : float
        Spectral radius at infinite frequency, from 1/3, which damps most, to 1, which keeps energy: then what steps do not
        resolve is kept too, and may make Newton's method need shorter steps.

    Raises
    ------
    InputError
        For another ``rho_inf``.

    References
    ----------
    J. C. Simo and N. Tarnow, The discrete energy-momentum method, ZAMP 43 (1992) 757-792; F. Armero and I. Romero, On the
    formulation of high-frequency dissipative time-stepping algorithms for nonlinear dynamics, Part II, Comput. Methods Appl.
    Mech. Eng. 190 (2001) 6783-6824, for other ways to the same end.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.0, density=7850.0)
    >>> pull = sk.EdgeLoad("right", (0.0, 0.0, 100.0))
    >>> strip = sk.Problem(sk.Rectangle(1.0, 0.1), 0.01, steel, supports=[sk.Clamp("left")], loads=[pull])
    >>> system = strip.on(sk.meshes.uniform(strip.surface, 4, 1), "kirchhoff")
    >>> motion = sk.simulate(system, 0.005, rule=sk.EnergyMomentum(rho_inf=1.0), rtol=1e-2, progress=False)
    >>> print(motion.status.value)
    finished
    """

    rho_inf: float = 0.8

    symmetric = False
    balance = 1e-3

    def __post_init__(self) -> None:
        plain(self)
        if not LEAST <= number("rho_inf", self.rho_inf) <= 1:
            raise InputError(f"rho_inf = {self.rho_inf}: the energy-momentum rule has a spectral radius from 1/3 to 1; "
                             "GeneralizedAlpha goes down to 0")  # fmt: skip

    @property
    def chi(self) -> float:
        r""":math:`\chi`, 1/16 at most."""
        return 0.5 * self.rho_inf * (1 - self.rho_inf) / (1 + self.rho_inf) ** 2

    @property
    def newton_rtol(self) -> float:  # type: ignore[override]
        """What is to keep energy goes to its last digits."""
        return NEWTON_EXACT if self.rho_inf == 1 else NEWTON_DAMPED

    @property
    def error_constant(self) -> float:
        return 1 / 12 + 0.5 * self.chi

    def end(self, u: np.ndarray, start: State, dt: float) -> State:
        end = super().end(u, start, dt)
        return replace(end, cache={"step": (u, start.cache)})

    def tangent_at(self, u: np.ndarray, start: State) -> tuple[np.ndarray, np.ndarray]:
        """The discrete gradient is nearly that of the middle; the stresses change with the end."""
        return start.q + 0.5 * u, start.q + u

    def gradient(self, conditions: Conditions, u: np.ndarray, start: State, dt: float) -> sp.csr_matrix:
        """The discrete gradient: multipliers do no work over the step."""
        return conditions.between(start.q, start.q + u)

    def stresses(
        self, system: System, u: np.ndarray, start: State, dt: float, change: np.ndarray | None = None
    ) -> np.ndarray:
        r"""S with those of the material's damping, :math:`\beta\,(S_{n+1} - S_n) / \Delta t`."""
        before = _at_start(system, start)
        after = _at_end(system, u, start, dt) if change is None else system.stresses(start.q + u, change, _end(start, dt))
        if not system.assembly.linear:
            return self._of_points(system, u, start, dt, before, after)
        more = system.shell.retardation / dt + self.chi
        stresses = (0.5 - more) * before + (0.5 + more) * after
        last = self._last_change(system, start, dt)
        return stresses if last is None else stresses - self.chi * last

    def _of_points(
        self, system: System, u: np.ndarray, start: State, dt: float, before: np.ndarray, after: np.ndarray
    ) -> np.ndarray:
        """S of laws at points."""
        case, end = Case(time=start.time), _end(start, dt)
        parts = [0.5 * (before + after), system.shell.exact_work(start.q, start.q + u, case, end),
                 self.numerical_stresses(system, u, start, dt)]  # fmt: skip
        if system.shell.retardation:
            parts.append(self.viscous_stresses(system, u, start, dt))
        return np.asarray(total(parts))

    def viscous_stresses(self, system: System, u: np.ndarray, start: State, dt: float) -> np.ndarray:
        return np.asarray(system.shell.retardation / dt * self._change(system, u, start, dt))

    def numerical_stresses(self, system: System, u: np.ndarray, start: State, dt: float) -> np.ndarray | None:
        if not self.chi:
            return None
        change = self._change(system, u, start, dt)
        last = self._last_change(system, start, dt)
        return self.chi * (change if last is None else change - last)

    def _change(self, system: System, u: np.ndarray, start: State, dt: float) -> np.ndarray:
        """Of the stresses over the step by the law of small strain, which damp."""
        if system.assembly.linear:
            return _at_end(system, u, start, dt) - _at_start(system, start)
        return system.shell.small_stresses(start.q + u) - system.shell.small_stresses(start.q)

    def _last_change(self, system: System, start: State, dt: float) -> np.ndarray | None:
        """r times the change of the stresses in the step that led here; None after a jump or a change of the mesh."""
        if not self.chi or start.before is None:
            return None
        if "last change" not in start.cache and not system.assembly.linear:
            of = system.shell.small_stresses
            start.cache["last change"] = of(start.q) - of(start.before)
        if "last change" not in start.cache:
            at_start = _at_start(system, start)
            before = start.cache.pop("stresses before", None)
            start.cache["last change"] = at_start - (system.stresses(start.before) if before is None else before)
        return min(1.0, dt / start.dt) * start.cache["last change"]

    def force_of(self, shell: Shell, u: np.ndarray, start: State, dt: float, stresses: np.ndarray) -> np.ndarray:
        return shell.force_between(start.q, start.q + u, stresses)

    def others_force(self, system: System, u: np.ndarray, start: State, dt: float) -> np.ndarray:
        case = Case(time=self.at_stage(u, start, dt)[1])
        return system.others.between(start.q, start.q + u, self.rate(u, start, dt), case)

    def internal_force(self, system: System, u: np.ndarray, start: State, dt: float) -> np.ndarray:
        stresses, initial = self.stresses(system, u, start, dt), system.shell.initial_stresses(Case(time=start.time))
        if initial is not None:
            stresses = stresses - 0.5 * (initial + system.shell.initial_stresses(Case(time=start.time + dt)))
        force = self.force_of(system.shell, u, start, dt, stresses)
        return force + self.others_force(system, u, start, dt) if system.others else force

    def stiffness(self, system: System, u: np.ndarray, start: State, dt: float, stresses: np.ndarray) -> BlockMatrix:
        stiffer = 1 + 2 * (system.shell.retardation / dt + self.chi)
        case = Case(time=start.time + 0.5 * dt)
        tangent = system.tangent(start.q + 0.5 * u, case, stresses, stiffer, self.rate(u, start, dt))
        tangent.values[:] *= 0.5
        return tangent


def _at_start(system: System, start: State) -> np.ndarray:
    """Stresses of a state; those that the step to it has computed are not computed again."""
    cache = start.cache
    if "stresses" not in cache:
        u, earlier = cache.pop("step", (None, {}))
        known, stresses = earlier.get("end", (None, None))
        cache["stresses before"] = earlier.get("stresses")
        case = Case(time=start.time)
        cache["stresses"] = system.stresses(start.q, None, case) if known is None or known is not u else stresses
    return np.asarray(cache["stresses"])


def _end(start: State, dt: float) -> Case:
    return Case(time=start.time + dt)


def _at_end(system: System, u: np.ndarray, start: State, dt: float) -> np.ndarray:
    """Stresses after an increment, computed once for it."""
    if start.cache.get("end", (None,))[0] is not u:
        start.cache["end"] = u, system.stresses(start.q + u, None, _end(start, dt))
    return np.asarray(start.cache["end"][1])
