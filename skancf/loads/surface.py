"""Dead forces per area, and weight."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from skancf.arguments import plain
from skancf.equality import by_value
from skancf.errors import vector
from skancf.history import History, check_history
from skancf.kernels.constants import AXES, POINTS
from skancf.loads.acting import Acting, DeadLoad, Spread, check_distributed, over_elements, values_at
from skancf.loads.eccentric import DeadLoadOnNormals
from skancf.showing import short
from skancf.terms.protocols import Assembly


@by_value
@dataclass(frozen=True)
class SurfaceLoad:
    """A dead force per undeformed area (Pa), that of the elements, of order four on curved surfaces.

    Parameters
    ----------
    force : (3,) or callable
        Constant, or a function of the parameters (x, y) that returns (3, ...).

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> snow = sk.SurfaceLoad((0.0, 0.0, -1000.0))
    >>> drift = sk.SurfaceLoad(lambda x, y: (0.0, 0.0, -1000.0 * x))
    >>> slab = sk.Problem(sk.Rectangle(1.0, 1.0), 0.01, steel, supports=[sk.Clamp("boundary")], loads=[snow, drift])
    >>> solution = sk.solve_linear(slab.on(sk.meshes.uniform(slab.surface, 4, 4), "kirchhoff"))
    >>> print(f"{solution.reactions()[2]:.4f} N")
    1500.0000 N
    """

    force: Any
    history: History | None = None

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        check_distributed(self.force, self.history)

    def on(self, assembly: Assembly) -> DeadLoad:
        return DeadLoad(over_elements(assembly.geometry, self._forces(assembly)), self.history)

    def spread(self, assembly: Assembly) -> Spread:
        """The forces at the integration points."""
        elements, local = np.arange(assembly.geometry.n_elements), assembly.geometry.integration.local
        return Spread(elements, np.broadcast_to(local, (len(elements), *local.shape[-2:])), self._forces(assembly))

    def _forces(self, assembly: Assembly) -> np.ndarray:
        """At the integration points, (n_elements, 2, 3, n_points)."""
        geometry = assembly.geometry
        forces = np.zeros((geometry.n_elements, 2, AXES, POINTS))
        forces[:, 0] = values_at(self.force, geometry.parameters(geometry.integration.local)) * assembly.areas[:, None]
        return forces


@by_value
@dataclass(frozen=True)
class Gravity:
    """Dead weight of the whole plate or shell under an acceleration (m/s2), at the centre of mass of each section.

    Bodies of terms of one's own have weights of their own.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(sk.Rectangle(1.0, 1.0), 0.01, steel, supports=[sk.Clamp("left")], loads=[sk.Gravity()])
    >>> solution = sk.solve_linear(plate.on(sk.meshes.uniform(plate.surface, 4, 4), "kirchhoff"))
    >>> print(f"{solution.reactions()[2]:.2f} N")  # rho h a^2 g
    769.82 N
    """

    acceleration: tuple[float, float, float] = (0.0, 0.0, -9.80665)
    history: History | None = None

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        check_history(self.history)
        vector("acceleration", self.acceleration, 3)

    def on(self, assembly: Assembly) -> Acting:
        geometry = assembly.geometry
        moments = assembly.sections.moments[assembly.sections.shape][:, :2]
        acceleration = np.asarray(self.acceleration, float)
        nodal = over_elements(geometry, np.einsum("evp,i->evip", moments, acceleration))
        if not geometry.theory.directors and np.any(assembly.section.at(geometry.integration.local).first_moment):
            return DeadLoadOnNormals(assembly, nodal, acceleration, self.history)
        return Weight(nodal, self.history)


class Weight(DeadLoad):
    """Dead weight on a mesh; with a function of time it has no potential."""

    def weight(self) -> np.ndarray | None:
        return self.nodal if self.history is None else None
