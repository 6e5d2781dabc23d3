"""Velocities at the start of a run."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from skancf.arguments import plain
from skancf.equality import by_value
from skancf.errors import InputError, finite, vector
from skancf.kernels.constants import R
from skancf.layout.geometry import Geometry
from skancf.layout.layout import EVERY, nodal
from skancf.linear import BlockMatrix, Constraints, DirectSolver
from skancf.loads.acting import over_elements, values_at
from skancf.showing import short
from skancf.system.system import System


@by_value
@dataclass(frozen=True)
class RigidVelocity:
    r"""The velocity of a body that moves and turns as a whole, at any configuration.

    .. math:: \dot r = v + \omega \times (r - c), \qquad \dot r_{,k} = \omega \times r_{,k},

    the same for :math:`r_{,xy}` and :math:`r_{,z}`.

    Parameters
    ----------
    velocity : (3,)
        v, of the point c (m/s).
    spin : (3,)
        :math:`\omega` (rad/s).
    about : (3,)
        c, a point of space (m).

    Raises
    ------
    InputError
        For entries that are not finite or not three.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> thrown = sk.Problem(sk.Rectangle(0.3, 0.03), 0.001, steel)
    >>> system = thrown.on(sk.meshes.uniform(thrown.surface, 4, 1), "kirchhoff")
    >>> throw = sk.RigidVelocity(velocity=(1.0, 0.0, 2.0))
    >>> motion = sk.simulate(system, 0.02, velocity=throw, rtol=1e-2, progress=False)
    >>> print(motion.status.value)
    finished
    """

    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    spin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    about: tuple[float, float, float] = (0.0, 0.0, 0.0)

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        for name in ("velocity", "spin", "about"):
            vector(name, getattr(self, name), 3)

    def at(self, q: np.ndarray, moving: Any = EVERY) -> np.ndarray:
        """Rates of unknowns q, (n_dofs,); ``moving``: see :attr:`skancf.layout.layout.Layout.moving`."""
        return rigid_rates(q, self.velocity, self.spin, self.about, moving)


def rigid_rates(q: np.ndarray, velocity: Any, spin: Any, about: Any, moving: Any = EVERY) -> np.ndarray:
    """Rates of unknowns q that move as a rigid body, (n_dofs,): see :class:`RigidVelocity`."""
    arms = nodal(q).copy()
    arms[moving, R] -= about
    rates = np.cross(np.asarray(spin, float), arms)
    rates[moving, R] += velocity
    return rates.ravel()


Velocity = np.ndarray | RigidVelocity | Callable[[np.ndarray, np.ndarray], Any] | None
"""Rates of the nodal coordinates, of a rigid body, or of the surface as a function of the parameters (x, y)."""


def initial_velocity(system: System, q: np.ndarray, velocity: Velocity) -> np.ndarray:
    r"""Rates of the nodal coordinates, (n_dofs,).

    A function of the parameters is projected on the velocities of the surface that the mesh has, in the norm of the mass per
    area :math:`\mu`,

    .. math:: \int \mu\, \delta r \cdot \dot r\, dA = \int \mu\, \delta r \cdot f(x, y)\, dA \quad \text{for all } \delta r,

    so that its linear momentum is kept. In theory `full` directors keep their components along :math:`r_{,x}, r_{,y}` and
    the normal, which turn with the projected field: what was normal to the surface stays so at first. Supports are not
    asked.

    Parameters
    ----------
    system : System
    q : (n_dofs,) array
        Configuration that has the velocity.
    velocity : None, (n_dofs,) array, RigidVelocity or callable
        At rest; rates as they are; of a rigid body; or a function of the parameters (x, y) that returns (3, ...) (m/s).

    Raises
    ------
    InputError
        For entries that are not finite, of another number or shape.
    """
    if velocity is None:
        return np.zeros(system.n_dofs)
    if isinstance(velocity, RigidVelocity):
        return velocity.at(q, system.layout.moving)
    if callable(velocity) and not isinstance(velocity, type):
        return _projected(system, q, velocity)
    v = finite("velocity", velocity).ravel()
    if v.size != system.n_dofs:
        raise InputError(f"velocity has {v.size} entries; the system has {system.n_dofs} nodal coordinates. Give as many, a "
                         "RigidVelocity, or a function of (x, y)")  # fmt: skip
    return v


def _projected(system: System, q: np.ndarray, velocity: Callable[..., Any]) -> np.ndarray:
    geometry, sections = system.geometry, system.assembly.sections
    masses = sections.moments[sections.shape][:, 0]
    momentum = values_at(velocity, geometry.parameters(geometry.integration.local), "velocity") * masses[:, None]
    fixed = np.ones_like(system.layout.scales, dtype=bool)
    fixed[: geometry.n_nodes] = _massless(geometry)
    with DirectSolver(system.pattern, Constraints(fixed)) as solver:
        solver.factor(_mass_of_positions(system))
        v = solver.solve(system.shell.flat(over_elements(geometry, momentum[:, None])), refinements=2)
    return system.shell.flat(geometry.theory.following(system.shell.nodal(q), system.shell.nodal(v)))


def _mass_of_positions(system: System) -> BlockMatrix:
    """The mass matrix without directors."""
    sections, theory = system.assembly.sections, system.geometry.theory
    if all(theory.of_positions):
        return system.mass
    table = theory.position_table(theory.quadrature[0])[0]
    blocks = system.blocks()
    system.shell.add_gathered(sections.shape, np.einsum("ap,bp,sp->sab", table, table, sections.moments[:, 0]), blocks)
    return blocks.matrix()


def _massless(geometry: Geometry) -> np.ndarray:
    """Coordinates of which positions do not depend, (n_nodes, 12) bool: directors, and the last vector of a pole."""
    out = np.zeros_like(geometry.undeformed, dtype=bool)
    out[:, np.logical_not(geometry.theory.of_positions)] = True
    out[list(geometry.ties.poles), -1] = True
    return out.reshape(geometry.n_nodes, -1)
