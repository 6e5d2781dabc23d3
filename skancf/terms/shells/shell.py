"""What the assemblies of all theories share: compiled kernels that run over the elements."""

from abc import abstractmethod
from collections.abc import Callable
from typing import Any, ClassVar

import numpy as np

from skancf.kernels.schedule import Schedule
from skancf.layout.geometry import Geometry
from skancf.layout.zones import SectionsOnMesh
from skancf.materials import Section
from skancf.materials.section import stress_of


class CompiledAssembly:
    """See :class:`skancf.terms.protocols.Assembly`. A theory gives its kernels, sections, and what they read."""

    residual_kernel: ClassVar[Callable[..., None]]
    stress_kernel: ClassVar[Callable[..., None]]
    tangent_kernel: ClassVar[Callable[..., None]]
    assumes_membrane: ClassVar[bool] = False
    recovers_bending: ClassVar[bool] = False
    linear: ClassVar[bool] = True
    sections: Any
    _tables: Any
    _elements: Any

    def __init__(self, geometry: Geometry, section: Section | SectionsOnMesh, schedule: Schedule):
        self.geometry, self.section, self.schedule = geometry, section, schedule

    @property
    def areas(self) -> np.ndarray:
        return np.asarray(self.sections.areas[self.sections.shape])

    @abstractmethod
    def force_of(self, q: np.ndarray, stresses: np.ndarray) -> np.ndarray:
        """Nodal forces of stresses at the integration points."""

    def internal_force(self, q: np.ndarray) -> np.ndarray:
        out = np.zeros_like(self.geometry.undeformed)
        self.schedule.run(type(self).residual_kernel, q, self._tables, self.geometry.maps, self._elements, out)
        return out

    def stresses(self, q: np.ndarray, change: np.ndarray | None, keep_strains: bool) -> tuple[np.ndarray, np.ndarray]:
        shape = (self.geometry.n_elements, *self.sections.reference.shape[1:])
        strains, out = np.empty(shape if keep_strains else (0, 0, 0)), np.empty(shape)
        change = np.empty((0, 4, 3)) if change is None else change
        self.schedule.run(
            type(self).stress_kernel, q, change, self._tables, self.geometry.maps, self._elements, strains, out
        )
        return strains, out

    def strain_energy(self, q: np.ndarray, initial: np.ndarray | None = None, thermal: float = 0.0) -> float:
        strains, stresses = self.stresses(q, None, keep_strains=True)
        energy = 0.5 * float(np.vdot(strains, stresses))
        return energy if initial is None else energy + (thermal - float(np.vdot(initial, strains)))

    def tangent(self, q: np.ndarray, stresses: np.ndarray, slots: np.ndarray, out: np.ndarray, plain: bool = False) -> None:
        elements = self.plain_elements if plain else self._elements
        self.schedule.run(type(self).tangent_kernel, q, stresses, self._tables, self.geometry.maps, elements, slots, out)

    def stress_of(
        self, strains: np.ndarray, section: Section, z: Any, temperature: np.ndarray | None = None, small: bool = False
    ) -> np.ndarray:
        free = np.zeros(6) if temperature is None else self._free_in(section, z, temperature)
        return stress_of(section.of_layer(section.stiffness, z), strains - free)

    @staticmethod
    def _free_in(section: Section, z: Any, temperature: np.ndarray) -> np.ndarray:
        """Free strain of a temperature change T0 + z T1 (2, m, n) in a section, (m, n, 6)."""
        return section.thermal_strain(z, *temperature)

    def small_stresses(self, q: np.ndarray, change: np.ndarray | None = None) -> np.ndarray:
        return self.stresses(q, change, keep_strains=False)[1]

    def exact_work(self, q0: np.ndarray, q1: np.ndarray) -> np.ndarray | None:
        return None

    def refusal(self) -> str | None:
        return None

    @property
    def plain_elements(self) -> Any:
        """What the kernels read where membrane strains are taken as they are; the same where none are assumed."""
        return self._elements
