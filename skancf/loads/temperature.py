"""Temperature changes."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from skancf.arguments import plain
from skancf.equality import by_value
from skancf.errors import InputError, finite
from skancf.functions import is_function, values_at
from skancf.history import Case, History, check_history
from skancf.loads.acting import Acting
from skancf.showing import short
from skancf.terms.protocols import Assembly


@by_value
@dataclass(frozen=True)
class Temperature:
    r"""A temperature change :math:`T(x, y, z) = T_0 + z T_1`, which strains the material by its ``expansion``.

    Of linear laws :math:`\alpha T` is a part of Green's strain; a law at a point is stretched by :math:`1 + \alpha T`, see
    :mod:`skancf.materials.free_stretch`.

    Parameters
    ----------
    change : float or callable
        :math:`T_0`, at the reference surface (K): constant, or a function of the parameters (x, y).
    gradient : float or callable
        :math:`T_1`, through the thickness (K/m).

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0, expansion=12e-6)
    >>> plate = sk.Problem(sk.Rectangle(1.0, 1.0), 0.01, steel, [sk.Clamp("left")], [sk.Temperature(gradient=1000.0)])
    >>> solution = sk.solve_linear(plate.on(sk.meshes.uniform(plate.surface, 4, 4), "kirchhoff"))
    >>> print(f"{1000 * solution.displacement((1.0, 0.5))[2]:.2f} mm")  # 10 K between its faces
    -6.60 mm
    """

    change: Any = 0.0
    gradient: Any = 0.0
    history: History | None = None

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        check_history(self.history)
        for name, value in (("change", self.change), ("gradient", self.gradient)):
            if not is_function(value) and np.ndim(finite(name, value)):
                raise InputError(f"{name} = {value}: give one number or a function of (x, y)")

    def on(self, assembly: Assembly) -> "Heating":
        return Heating(assembly, self)

    def values(self, at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """T0 and T1 at parameters (2, ...), each (...)."""
        one, two = (values_at(name, getattr(self, name), at) for name in ("change", "gradient"))
        return one, two


class Heating(Acting):
    """A temperature change on a mesh."""

    def __init__(self, assembly: Assembly, load: Temperature):
        self.load, self.history, self.geometry = load, load.history, assembly.geometry
        self.initial_stress = assembly.thermal_stresses(lambda points: load.values(self.geometry.parameters(points)))

    def initial_stresses(self, case: Case) -> np.ndarray:
        return np.asarray(case.amplitude(self.history) * self.initial_stress)

    def temperature(self, points: np.ndarray, case: Case) -> np.ndarray:
        return np.asarray(case.amplitude(self.history) * np.stack(self.load.values(self.geometry.parameters(points))))
