"""Strains, stresses and section forces of a state at local points of its elements."""

from collections.abc import Callable
from typing import Any

import numpy as np

from skancf.elements.reference import CORNERS
from skancf.errors import InputError, finite, shown
from skancf.layout.patches import averages_at_nodes
from skancf.materials import Section
from skancf.materials.heights import Depth, depth_of, unlike_faces
from skancf.recovered import section_forces, strain_excess
from skancf.thinness import BILINEAR, shear_forces
from skancf.tolerances import ONE_PLACE
from skancf.true_stress import TrueStresses

# Strains of both faces that differ by no more than this part of the largest are one: there is no depth to choose.
ONE_STRAIN = 1e-3
Elements = np.ndarray | None
"""Numbers (m,) of some elements; None for all."""


class LocalFields(TrueStresses):
    """Fields of a state at points of the reference square of every element; a base of :class:`~skancf.Solution`.

    Each method takes some elements, (m,), instead of all as its last argument. At places of the parameter plane there are
    :meth:`~skancf.Solution.at` and :meth:`~skancf.Solution.along`.
    """

    system: Any
    model: Any
    unknowns: Any
    case: Any
    q: Any

    def strains(self, points: np.ndarray, z: Depth | None = None, elements: Elements = None) -> np.ndarray:
        """Green-Lagrange strain in the local frame at points (2, n) of every element and depth z: (n_elements, n, 6).

        Order 11, 22, 33, 23, 13, 12, shear strains doubled. In theory `kirchhoff` the strain 33 (and 23, 13 of an oblique
        law) is the one that leaves no stress, and those in the surface have, where it is curved, the lengths at z and the
        stretch that balances bending.

        Parameters
        ----------
        points : (2, n) array
            In the reference square.
        z : float or {"top", "middle", "bottom"}
            Height above the reference surface (m); where the thickness varies, names are the faces and the middle of each
            place. It may be left out where strain and law do not change through the thickness.

        Raises
        ------
        InputError
            Without z in a state that is bent, or of a laminate, and for a depth outside the plate.
        """
        assembly, nodal, inside = self.system.assembly, self.system.shell.nodal, self._inside(points)
        elements = self._some(elements)
        depth = depth_of(self._section(points, elements), self._chosen(z, points, elements))
        heat = self._heat(inside, elements)
        return self._of_state(lambda q: assembly.strains(nodal(q), inside, depth, heat, self.linear, elements))

    def stresses(self, points: np.ndarray, z: Depth | None = None, elements: Elements = None) -> np.ndarray:
        """Second Piola-Kirchhoff stress in the local frame at points (2, n) of every element: (n_elements, n, 6) (Pa).

        The law is that of the layer at z, of the lower one at an interface. Points, z and errors are those of
        :meth:`strains`.
        """
        return self._stresses_of(self.strains, points, z, elements)

    def _stresses_of(
        self, strains: Callable[..., np.ndarray], points: np.ndarray, z: Depth | None, elements: Elements
    ) -> np.ndarray:
        elements = self._some(elements)
        section, z = self._section(points, elements), self._chosen(z, points, elements)
        depth, heat = depth_of(section, z), self._heat(self._inside(points), elements)
        strain = strains(points, z, elements)
        return np.asarray(self.system.assembly.stress_of(strain, section, depth, heat, small=self.linear))

    def _chosen(self, z: Depth | None, points: np.ndarray, elements: Elements) -> Depth:
        """The depth that was asked for; if none was, the reference surface where all depths have the same."""
        if z is not None:
            return z
        section = self._section(points, elements)
        section.layer_at(0.0)
        low, high = (self.strains(points, face, elements) for face in ("bottom", "top"))
        differ = np.abs(high - low).max(initial=0.0) > ONE_STRAIN * np.abs([low, high]).max(initial=0.0)
        if differ or not section.one_material:
            raise unlike_faces(section)
        return 0.0

    def _section(self, points: np.ndarray, elements: Elements) -> Section:
        """At points (2, n) of every element, or of some."""
        section: Section = self.system.assembly.section.at(self._inside(points), elements)
        return section

    def _some(self, elements: Any) -> Elements:
        """Numbers (m,) of elements, checked; None for all."""
        if elements is None:
            return None
        numbers, last = finite("elements", elements), self.system.geometry.n_elements - 1
        if (
            numbers.ndim != 1
            or not numbers.size
            or (numbers != np.round(numbers)).any()
            or (numbers < 0).any()
            or (numbers > last).any()
        ):
            raise InputError(f"elements = {shown(elements)}: give numbers of elements from 0 to {last} in a list")
        return numbers.astype(int)

    def _inside(self, points: Any) -> np.ndarray:
        """Local points (2, n) of the reference square, checked."""
        local = finite("points", points)
        if local.ndim != 2 or local.shape[0] != 2 or np.abs(local - 0.5).max(initial=0.0) > 0.5 + ONE_PLACE:
            raise InputError(
                f"points of shape {local.shape}: give points of the reference square as an array (2, n), "
                "from 0 to 1; at places of the parameter plane there are displacement and position"
            )
        return np.asarray(self.system.geometry.inside(local))

    def _heat(self, points: np.ndarray, elements: Elements) -> Any:
        """Temperature change T0 and T1, (2, m, n), or None."""
        return self.system.shell.temperature(points, self.case, elements)

    def section_forces(self, points: np.ndarray | None = None, elements: Elements = None) -> np.ndarray:
        r"""Membrane forces and moments per length in the local frame at points of every element: (n_elements, 6, n).

        :math:`N_{11}, N_{22}, N_{12}` (N/m) and :math:`M_{11}, M_{22}, M_{12}` (N), integrals of the stress and of z times
        the stress over the thickness, per length of the reference surface, which balance the loads: of a curved surface with
        the curvature b the stress counts with the lengths at its height, :math:`\sigma - z (\sigma \operatorname{tr} b -
        \tfrac12 (b \sigma + \sigma b))`.

        Parameters
        ----------
        points : (2, n) array, optional
            In the reference square. Default: the four corners.
        """
        inside, elements = self._inside(CORNERS.T if points is None else points), self._some(elements)
        forces = self.system.shell.section_forces
        return self._of_state(lambda q: forces(q, inside, self.case, self.linear, elements))

    def recovered_section_forces(self, points: np.ndarray | None = None, elements: Elements = None) -> np.ndarray:
        """Section forces as :meth:`section_forces`, in theory `full` with better moments: (n_elements, 6, n).

        Slopes of its bilinear directors are good in the middles of elements, and of first order at corners: moments come
        from polynomials through the middles; of one row of elements they tell no more across it than the row does.
        """
        inside, elements = self._inside(CORNERS.T if points is None else points), self._some(elements)
        return self._of_state(lambda q: section_forces(self.system, q, inside, self.case, self.linear, elements))

    def recovered_strains(self, points: np.ndarray, z: Depth | None = None, elements: Elements = None) -> np.ndarray:
        """Strain as :meth:`strains`, in theory `full` with curvatures as :meth:`recovered_section_forces` has them."""
        elements = self._some(elements)
        z, inside = self._chosen(z, points, elements), self._inside(points)
        strains = self.strains(points, z, elements)
        return np.asarray(strains + self._of_state(lambda q: strain_excess(self.system, q, inside, z, elements)))

    def recovered_stresses(self, points: np.ndarray, z: Depth | None = None, elements: Elements = None) -> np.ndarray:
        """Stress as :meth:`stresses`, of :meth:`recovered_strains`."""
        return self._stresses_of(self.recovered_strains, points, z, elements)

    def _of_state(self, quantity: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
        """A quantity of the nodal coordinates; of a small-deflection answer its value at rest and its linear part."""
        return np.asarray(self.model.value(quantity, self.unknowns))

    def shear_forces(self, points: np.ndarray | None = None, elements: Elements = None) -> np.ndarray:
        r"""Transverse shear forces Q1, Q2 per length in the local frame: (n_elements, 2, n) (N/m).

        In theory `kirchhoff` those that balance the moments, see :func:`skancf.thinness.shear_forces`; in `full` the
        integrals of the stresses 13 and 23 over the thickness, of a curved surface with the lengths at their height,
        :math:`\tau - z (\tau \operatorname{tr} b - b \tau)`.

        Parameters
        ----------
        points : (2, n) array, optional
            In the reference square. Default: the middle, where they are most accurate.
        """
        inside, elements = self._inside(np.array([[0.5], [0.5]]) if points is None else points), self._some(elements)
        system, case, linear = self.system, self.case, self.linear
        if system.geometry.theory.shear:
            heat = self._heat(inside, elements)
            sheared = system.assembly.shear_forces
            return self._of_state(lambda q: sheared(system.shell.nodal(q), inside, heat, linear, elements))
        forces = system.shell.section_forces
        moments = self._of_state(lambda q: forces(q, BILINEAR[0], case, linear, elements)[:, 3:])
        return shear_forces(system, self.q, moments, inside, case, elements)

    def nodal_section_forces(self) -> np.ndarray:
        """Section forces at the nodes of the mesh, means over the elements that meet there: (n_mesh_nodes, 6).

        In theory `full` they are those of :meth:`recovered_section_forces`, which has those of each side where sections
        jump, at borders of zones. At a pole each node of the mesh has the frame of its own direction.
        """
        return self._at_nodes(self.recovered_section_forces().swapaxes(1, 2))

    def _at_nodes(self, values: np.ndarray) -> np.ndarray:
        """Averages (n_mesh_nodes, k) of values (n_elements, 4, k) at corners; at a hanging node of its edge's ends."""
        return averages_at_nodes(self.system.geometry, values)

    def nodal_stresses(self, z: Depth | None = None) -> np.ndarray:
        """Stress (Pa) at z as :meth:`stresses` has it, at nodes as :meth:`nodal_section_forces`: (n_mesh_nodes, 6)."""
        return self._at_nodes(self.recovered_stresses(CORNERS.T, z))
