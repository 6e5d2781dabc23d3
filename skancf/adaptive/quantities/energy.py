"""The strain energy."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skancf.states import StateLike, solution_of


@dataclass(frozen=True)
class StrainEnergy:
    r"""Strain energy of a state (J), that of springs and foundations included:
    :attr:`Solution.strain_energy <skancf.Solution.strain_energy>`.

    .. math:: \tfrac12 \int (\varepsilon - \lambda \varepsilon_T) \cdot C (\varepsilon - \lambda \varepsilon_T) \, dV

    Its gradient is the internal force without what holds back the free strain :math:`\lambda \varepsilon_T` of a temperature
    change; for a small-deflection answer, whose energy is of second order, the stiffness times the change.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> system = plate.on(sk.meshes.uniform(plate.surface, 6, 6), "kirchhoff")
    >>> print(f"{sk.StrainEnergy().value(sk.solve_linear(system)):.4f} J")
    0.0101 J
    """

    unit: ClassVar[str] = "J"

    def value(self, state: StateLike) -> float:
        """The energy."""
        state = solution_of("state", state)
        return float(state.strain_energy)

    def scale(self, state: StateLike) -> float:
        """The largest energy that the temperature change can cause, which free expansion takes back."""
        state = solution_of("state", state)
        return state.system.shell.thermal_energy(state.case)

    def gradient(self, state: StateLike) -> np.ndarray:
        r""":math:`\partial J / \partial q`, (n_dofs,)."""
        state = solution_of("state", state)
        force = state.model.internal_force(state.unknowns, None, state.case)
        initial = state.system.shell.initial_stress_force(state.about, state.case, state.linear)
        return np.asarray(force if initial is None else force - initial)
