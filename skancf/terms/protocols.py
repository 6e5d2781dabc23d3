"""What a system knows of a theory on a mesh, and of prescribed coordinates."""

from collections.abc import Callable
from typing import Any, ClassVar, Protocol

import numpy as np

from skancf.history import Case
from skancf.kernels.schedule import Schedule
from skancf.layout.geometry import Geometry
from skancf.layout.zones import SectionsOnMesh
from skancf.materials import Section

Heat = Callable[[np.ndarray], Any]
"""A temperature change T0 + z T1, the two (n_elements, n), at local points (2, n) or those of each element."""


class Assembly(Protocol):
    """A theory on a mesh. Nodal vectors q and forces have the shape (n_nodes, 4, 3); stresses hold the weights."""

    geometry: Geometry
    section: Section | SectionsOnMesh
    sections: Any
    schedule: Schedule
    assumes_membrane: ClassVar[bool]
    """Whether membrane strains are assumed; then it has ``membrane_rest``, what they leave out, and ``rest_energy``."""
    recovers_bending: ClassVar[bool]
    """Whether moments are good in the middles of elements only; then it has ``bending_forces`` and ``bending_strains``, the
    part of section forces and strains that makes them so."""
    linear: ClassVar[bool]
    """Whether stresses are linear in the strains."""

    @property
    def areas(self) -> np.ndarray:
        """Weights times area of the undeformed elements at the integration points, (n_elements, n_points)."""

    def internal_force(self, q: np.ndarray) -> np.ndarray:
        """Derivative of the strain energy."""

    def force_of(self, q: np.ndarray, stresses: np.ndarray) -> np.ndarray:
        """Forces that do the work of given stresses (n_elements, n_strains, n_points)."""

    def force_between(self, q0: np.ndarray, q1: np.ndarray, stresses: np.ndarray) -> np.ndarray:
        """Forces f of given stresses with f . (q1 - q0) = stresses . (strains(q1) - strains(q0)) and no moment."""

    def stresses(self, q: np.ndarray, change: np.ndarray | None, keep_strains: bool) -> tuple[np.ndarray, np.ndarray]:
        """Strains (or nothing) and stresses, extrapolated linearly along ``change``."""

    def strain_energy(self, q: np.ndarray, initial: np.ndarray | None = None, thermal: float = 0.0) -> float:
        """Energy of the strains (J), less the work of ``initial`` stresses on them, with their own, ``thermal``."""

    def tangent(self, q: np.ndarray, stresses: np.ndarray, slots: np.ndarray, out: np.ndarray, plain: bool = False) -> None:
        """Add the tangent with given stresses to the upper blocks ``out``; ``plain``: with no membrane strain assumed."""

    @property
    def mass_shapes(self) -> np.ndarray:
        """Mass matrix of each class of elements, (n_shapes, 16, 16)."""

    def thermal_stresses(self, temperature: Heat) -> np.ndarray:
        """Stresses that hold back a temperature change T0 + z T1."""

    def thermal_energy(self, temperature: Heat) -> float:
        """Energy of those stresses on the free strain of the temperature change, the largest it can have."""

    def section_forces(
        self,
        q: np.ndarray,
        points: np.ndarray,
        temperature: np.ndarray | None,
        *,
        small: bool = False,
        elements: np.ndarray | None = None,
    ) -> np.ndarray:
        """N and M in the local frame at points (2, n) of every element, or of some, (m,): (m, 6, n).

        The temperature change is T0 and T1 there, (2, m, n), or None; ``small``: to first order in it and in the
        change of the undeformed state.
        """

    def section_force_gradient(
        self, q: np.ndarray, elements: np.ndarray, points: np.ndarray, weights: np.ndarray
    ) -> np.ndarray:
        """Derivative (n_nodes, 4, 3) of the sum of weights (m, 6, n) times N and M at points (2, n) of elements (m,)."""

    def strains(
        self,
        q: np.ndarray,
        points: np.ndarray,
        z: Any,
        temperature: np.ndarray | None,
        small: bool = False,
        elements: np.ndarray | None = None,
    ) -> np.ndarray:
        """Strain in the local frame at a depth, or one for each place, (m, n, 6), temperature, ``small`` and elements as in
        :meth:`section_forces`."""

    def shear_forces(
        self,
        q: np.ndarray,
        points: np.ndarray,
        temperature: np.ndarray | None,
        small: bool = False,
        elements: np.ndarray | None = None,
    ) -> np.ndarray:
        """Transverse shear forces of a theory that has shear strains, (m, 2, n), arguments as in :meth:`section_forces`."""

    def stress_of(
        self, strains: np.ndarray, section: Section, z: Any, temperature: np.ndarray | None = None, small: bool = False
    ) -> np.ndarray:
        """Second Piola-Kirchhoff stress of strains (m, n, 6) at a depth of a section, or at one for each place; temperature
        and ``small`` as in :meth:`section_forces`."""

    def small_stresses(self, q: np.ndarray, change: np.ndarray | None = None) -> np.ndarray:
        """As :meth:`stresses` by the law of small strain, which is that of the undeformed state."""

    def exact_work(self, q0: np.ndarray, q1: np.ndarray) -> np.ndarray | None:
        """What the mean of the stresses of two states needs besides to do the work of the energy on the change of the
        strains; None where laws are linear, and the mean does it."""

    def refusal(self) -> str | None:
        """Why and where a law had no stress for the state that it was asked for last; None where it had."""


class Prescription(Protocol):
    """Prescribed coordinates in time.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> system = plate.on(sk.meshes.uniform(plate.surface, 6, 6), "kirchhoff")
    >>> print(system.prescription.values(sk.Case()).shape)
    (588,)
    """

    def histories(self) -> list[Any]:
        """Its functions of time, among them None for one that is constant."""

    def values(self, case: Case) -> np.ndarray:
        """Change of the prescribed coordinates from the undeformed state, (n_dofs,), zero along free directions."""
