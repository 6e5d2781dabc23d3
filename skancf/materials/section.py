r"""A section: the layers through the thickness, and what they amount to per area.

Classical lamination theory is that of R. M. Jones, *Mechanics of Composite Materials*, 2nd ed. (1999), chapter 4.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from skancf.elements.quad_ancf import gauss
from skancf.equality import by_value
from skancf.errors import InputError, finite
from skancf.materials.law import IN_PLANE, OUT_OF_PLANE, thinning
from skancf.materials.point_law import PointLaw
from skancf.showing import short
from skancf.tolerances import ROUNDED_PLACE

LEAST, MOST = 1e-80, 1e80
"""Of stiffnesses and mass per area: cubes of them times those of lengths are computed with."""
FARTHEST = 1e6
"""Heights over the thickness: of its square, the part of the bending stiffness about the middle has fewer digits."""
SHEAR = [4, 3]
"""Voigt rows of 13 and 23, in this order."""


@by_value
@dataclass(frozen=True, eq=False)
class Section:
    r"""Layers through the thickness, from bottom to top.

    Laws and expansions are in the frame of the surface, Voigt order 11, 22, 33, 23, 13, 12 with doubled shear strains.
    A temperature change is :math:`T(z) = T_0 + z T_1`: that of the reference surface and its gradient.

    It is that of a whole plate, or of many places at once, as :class:`~skancf.materials.field.SectionField` makes it: then
    all its arrays, and what it returns, have the axes of the places before their own.

    Parameters
    ----------
    z : (n + 1,) array
        Heights of the faces and interfaces above the reference surface, increasing (m).
    stiffness : (n, 6, 6) array
        C of each layer (Pa).
    density : (n,) array
        kg/m3.
    expansion : (n, 6) array
        Thermal strain of each layer (1/K).
    thinning : (n, 3) array, optional
        Strain 33 of each layer per unit of 11, 22, 12 where S33 = S23 = S13 = 0. Default: that of its stiffness, which a law
        of plane stress has no more.
    points_law : PointLaw, optional
        The law of a section that is not linear, of one layer, whose stiffness and thinning are those of small strain. None
        for linear sections.
    places : (2, ...) array, optional
        Of the parameter plane, where it is the section; then layers may have no thickness at some. Without it the section
        is everywhere the same.

    Raises
    ------
    InputError
        For heights that do not increase, and for arrays that do not fit to them.

    Examples
    --------
    >>> plate = sk.Problem(sk.Rectangle(1.0, 1.0), 0.01, sk.Isotropic(70e9, 0.3, 2700.0))
    >>> plate.section.z, plate.section.thickness
    (array([-0.005,  0.005]), 0.01)
    """

    z: np.ndarray
    stiffness: np.ndarray
    density: np.ndarray
    expansion: np.ndarray
    thinning: Any = None
    points_law: PointLaw | None = None
    places: Any = None

    __repr__ = short

    def __post_init__(self) -> None:
        if self.places is not None:
            self._check_places()
            return
        n = np.size(self.z) - 1
        for name, shape in (("z", (n + 1,)), ("stiffness", (n, 6, 6)), ("density", (n,)), ("expansion", (n, 6)),
                            ("thinning", (n, 3))):  # fmt: skip
            if name == "thinning" and self.thinning is None:
                object.__setattr__(self, name, [thinning(law) for law in self.stiffness])
            array = finite(name, getattr(self, name)).copy()
            if n < 1 or array.shape != shape:
                raise InputError(f"{name} of shape {array.shape}: a section of n layers has n + 1 heights z, and "
                                 "stiffness (n, 6, 6), density (n,), expansion (n, 6) and thinning (n, 3)")  # fmt: skip
            array.flags.writeable = False
            object.__setattr__(self, name, array)
        if not (np.diff(self.z) > 0).all():
            raise InputError(f"z = {self.z}: heights of a section increase from the bottom to the top face")
        self._check_sizes()

    def _check_places(self) -> None:
        """Arrays as they are: of a field, which made them of sections that have been checked."""
        self._check_sizes()

    def _check_sizes(self) -> None:
        """InputError for a stiffness or mass of which products are no floating-point numbers, or zero."""
        with np.errstate(all="ignore"):
            diagonal = np.diagonal(self._abd, axis1=-2, axis2=-1)
            A, D = diagonal[..., :3].max(axis=-1), diagonal[..., 3:].max(axis=-1)
        for name, value, unit in (("membrane stiffness", A, "N/m"), ("bending stiffness", D, "N m"),
                                  ("mass per area", self.mass, "kg/m2")):  # fmt: skip
            wrong = ~((np.asarray(value) >= LEAST) & (np.asarray(value) <= MOST))
            if wrong.any():
                thickness, value = (np.asarray(each)[wrong].flat[0] for each in (self.thickness, value))
                raise InputError(f"thickness = {thickness:.6g}{self.said_of(wrong)}: the {name} of the section is "
                                 f"{value:.3g} {unit}, and products of numbers beyond {LEAST:g} to {MOST:g} are no "
                                 "floating-point numbers, or zero; give thickness, moduli and density in other "
                                 "units")  # fmt: skip

        reach, thickness = np.abs(self.z).max(axis=-1), np.asarray(self.thickness)
        if (far := reach > FARTHEST * thickness).any():
            raise InputError(
                f"offset: heights of a section reach {reach[far].flat[0]:.3g} m{self.said_of(far)}, over "
                f"{FARTHEST:g} times its thickness, where bending is lost in rounding; put the surface nearer"
            )

    def at(self, points: np.ndarray, elements: np.ndarray | None = None) -> "Section":
        """The section at local points (2, n) of elements (m,): itself, which is everywhere the same. That of a field is
        :meth:`skancf.layout.zones.SectionsOnMesh.at`."""
        return self

    def samples(self) -> "list[Section]":
        """Sections of the plate that tell what there is: itself."""
        return [self]

    def at_places(self, places: Any) -> "Section":
        """The section at places of the parameter plane, (2, ...): itself."""
        return self

    def one(self, place: Any) -> "Section":
        """That of one of many places, by its index, without layers that have no thickness there."""
        if self.places is None:
            return self
        there = self.thicknesses[place] > 0
        z, others = self.z[place], (self.stiffness, self.density, self.expansion, self.thinning)
        return Section(np.append(z[:1], z[1:][there]), *(each[place][there] for each in others))

    def said_of(self, which: np.ndarray) -> str:
        """Where the first of some places is, in words; nothing of a section that is everywhere the same."""
        if self.places is None:
            return ""
        x, y = (part[which].flat[0] for part in np.broadcast_arrays(*self.places))
        return f" at (x, y) = ({x:.6g}, {y:.6g})"

    @property
    def thicknesses(self) -> np.ndarray:
        """Of the layers, (n,) (m)."""
        return np.diff(self.z)

    @property
    def thickness(self) -> Any:
        """From face to face (m)."""
        return _number(self.z[..., -1] - self.z[..., 0])

    @property
    def mass(self) -> Any:
        """Mass per area (kg/m2)."""
        return _sum(self.density, self.thicknesses)

    @property
    def first_moment(self) -> Any:
        r""":math:`\int \rho z \, dz` (kg/m); zero where it is the rounding of heights."""
        moment = _sum(self.density, self._powers()[1])
        return _unless_rounding(moment, ROUNDED_PLACE * self.mass * self.thickness)

    @property
    def second_moment(self) -> Any:
        r""":math:`\int \rho z^2 \, dz` (kg)."""
        return _sum(self.density, np.diff(self.z**3)) / 3

    @property
    def one_material(self) -> bool:
        """Whether all layers have one stiffness and one expansion."""
        return all(bool((each == np.take(each, [0], axis=-1 - axes)).all())
                   for each, axes in ((self.stiffness, 2), (self.expansion, 1)))  # fmt: skip

    def layer_at(self, z: Any) -> np.ndarray:
        """The layer that each depth belongs to, an int array of z's shape; at an interface the lower one.

        Raises
        ------
        InputError
            For a depth outside the faces.
        """
        depth, slack = finite("z", z), ROUNDED_PLACE * self.thickness
        outside = (depth < self.z[..., 0] - slack) | (depth > self.z[..., -1] + slack)
        if outside.any():
            depth, bottom, top = (np.broadcast_to(each, outside.shape)[outside].flat[0]
                                  for each in (depth, self.z[..., 0], self.z[..., -1]))  # fmt: skip
            raise InputError(f"z = {depth}: outside the plate, whose faces are at z = {bottom:.6g} "
                             f"and {top:.6g}{self.said_of(outside)}")  # fmt: skip
        if self.places is not None:
            return np.asarray((self.z[..., 1:-1] < (depth - slack)[..., None]).sum(axis=-1))
        return np.searchsorted(self.z[1:-1], depth - slack)

    def of_layer(self, values: np.ndarray, z: Any) -> np.ndarray:
        """Of values of the layers, such as :attr:`stiffness` or :attr:`expansion`, those at depths z."""
        layer = self.layer_at(z)
        if self.places is None:
            return np.asarray(values[layer])
        axis = self.z.ndim - 1
        layer = np.broadcast_to(layer, self.z.shape[:-1])[(..., *[None] * (values.ndim - axis))]
        return np.asarray(np.take_along_axis(values, layer, axis).squeeze(axis))

    def points(self, n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Gauss points of all layers, n in each: depths, weights (m) and layers, all of shape (n_layers * n,); the layers
        are one row for all places."""
        s, w = gauss(n)
        shape = (*self.z.shape[:-1], -1)
        depth = self.z[..., :-1, None] + self.thicknesses[..., None] * s
        weights = self.thicknesses[..., None] * w
        return depth.reshape(shape), weights.reshape(shape), np.repeat(np.arange(self.density.shape[-1]), n)

    def through(self, n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The same points, with their axis before those of places: depths, weights (m), and laws (..., 6, 6)."""
        z, w, layer = self.points(n)
        laws = np.take(self.stiffness, layer, axis=-3)
        return np.moveaxis(z, -1, 0), np.moveaxis(w, -1, 0), np.moveaxis(laws, -3, 0)

    def in_plane(self) -> np.ndarray:
        r"""Stiffness Q of each layer for 11, 22, 12 where :math:`S_{33} = S_{23} = S_{13} = 0`: (n, 3, 3) (Pa).

        .. math:: Q = C_{pp} - C_{pq} C_{qq}^{-1} C_{qp}, \qquad p = 11, 22, 12, \quad q = 33, 23, 13
        """
        pp, pq, qq = (self.stiffness[..., rows, :][..., cols] for rows, cols in
                      ((IN_PLANE, IN_PLANE), (IN_PLANE, OUT_OF_PLANE), (OUT_OF_PLANE, OUT_OF_PLANE)))  # fmt: skip
        return pp - pq @ np.linalg.solve(qq, pq.swapaxes(-1, -2))

    def condensed(self, z: Any) -> np.ndarray:
        """Strains 33, 23, 13 per unit of 11, 22, 12 where S33 = S23 = S13 = 0, in the layer at z: (3, 3)."""
        out = self.of_layer(self.stiffness, z)[..., OUT_OF_PLANE, :]
        return -np.linalg.solve(out[..., OUT_OF_PLANE], out[..., IN_PLANE])

    def abd(self) -> np.ndarray:
        r"""Stiffness of the section in thin-plate theory, (6, 6).

        .. math::
            \begin{bmatrix} N \\ M \end{bmatrix} = \begin{bmatrix} A & B \\ B & D \end{bmatrix}
            \begin{bmatrix} \varepsilon \\ \kappa \end{bmatrix}, \qquad (A, B, D) = \int Q \, (1, z, z^2) \, dz

        for the in-plane strain :math:`\varepsilon + z \kappa` in the order 11, 22, 12. A in N/m, B in N, D in N m.
        """
        return self._abd.copy()

    @cached_property
    def _abd(self) -> np.ndarray:
        A, B, D = np.einsum("k...l,...lij->k...ij", self._powers(), self.in_plane())
        return np.block([[A, B], [B, D]])

    @cached_property
    def neutral(self) -> Any:
        r"""Height of the surface that bending does not strain, :math:`\operatorname{tr} B / \operatorname{tr} A` (m).

        That of a layer alone, of two directions the mean; zero where it is the rounding of heights.
        """
        A, B = self._abd[..., :3, :3], self._abd[..., :3, 3:]
        return _unless_rounding(_number(trace(B) / trace(A)), ROUNDED_PLACE * self.thickness)

    def about(self, height: Any) -> "Section":
        """The same layers with heights above a parallel surface at a height (m)."""
        return replace(self, z=self.z - np.asarray(height)[..., None]) if np.any(height) else self

    @property
    def bending_thickness(self) -> Any:
        r"""Thickness of a plate of one layer whose bending is as small against its membrane stiffness (m).

        .. math:: t_b = \sqrt{12 \operatorname{tr}(D - B A^{-1} B) / \operatorname{tr} A}

        The bending stiffness is that about the plane which bending does not strain.
        """
        return _number(np.sqrt(12 * trace(self.pure_bending()) / trace(self._abd[..., :3, :3])))

    def pure_bending(self) -> np.ndarray:
        """Bending stiffness about the plane which bending does not strain, :math:`D - B A^{-1} B`: (3, 3) (N m)."""
        A, B, D = self._abd[..., :3, :3], self._abd[..., :3, 3:], self._abd[..., 3:, 3:]
        return np.asarray(D - B @ np.linalg.solve(A, B))

    def thermal_resultants(self, temperature_mid: Any, temperature_gradient: Any) -> np.ndarray:
        r"""Resultants of a temperature change that is not allowed to strain the section, with the sign turned.

        .. math:: (N_T, M_T) = \int Q \alpha \, (T_0 + z T_1) \, (1, z) \, dz

        Forces and moments are :math:`A \varepsilon + B \kappa - N_T` and :math:`B \varepsilon + D \kappa - M_T`.

        Parameters
        ----------
        temperature_mid : float or (...) array
            :math:`T_0`, at the reference surface (K).
        temperature_gradient : float or (...) array
            :math:`T_1` (K/m).

        Returns
        -------
        (6, ...) array
            :math:`N_T` (N/m), then :math:`M_T` (N), each in the order 11, 22, 12.
        """
        require_one(self)
        stress = np.einsum("lij,lj->li", self.in_plane(), self.expansion[:, IN_PLANE])
        first, second, third = self._powers() @ stress
        by_mid, by_gradient = np.concatenate([first, second]), np.concatenate([second, third])
        middle, gradient = finite("temperature_mid", temperature_mid), finite("temperature_gradient", temperature_gradient)
        return np.multiply.outer(by_mid, middle) + np.multiply.outer(by_gradient, gradient)

    def thermal_energy(self, temperature_mid: Any, temperature_gradient: Any) -> np.ndarray:
        r"""Energy per area of a temperature change that is not allowed to strain the section, (...) (J/m2).

        .. math:: \tfrac12 \int \alpha \cdot Q \alpha \, (T_0 + z T_1)^2 \, dz
        """
        require_one(self)
        alpha = self.expansion[:, IN_PLANE]
        first, second, third = self._powers() @ np.einsum("li,lij,lj->l", alpha, self.in_plane(), alpha)
        middle, gradient = finite("temperature_mid", temperature_mid), finite("temperature_gradient", temperature_gradient)
        return np.asarray(first * middle**2 / 2 + second * middle * gradient + third * gradient**2 / 2)

    def thermal_strain(self, z: Any, temperature_mid: Any, temperature_gradient: Any = 0.0) -> np.ndarray:
        r"""Free strain :math:`\alpha \, (T_0 + z T_1)` at depths z: (..., 6)."""
        change = temperature_mid + np.asarray(z, dtype=float) * temperature_gradient
        return self.of_layer(self.expansion, z) * change[..., None]

    def thermal_strain_of_one_director(self, z: Any, temperature_mid: Any, temperature_gradient: Any = 0.0) -> np.ndarray:
        r"""The same for theory `full`, whose strain 33 is one through the thickness: (..., 6).

        Where laws do not couple 33 to others, its free strain is the mean, weighted by C33: the rest would be stress S33
        that nothing can relax. It does no work on any motion.
        """
        free = self.thermal_strain(z, temperature_mid, temperature_gradient)
        if np.delete(self.stiffness[..., 2, :], 2, axis=-1).any():
            return free
        weights = self.stiffness[..., 2, 2]
        first, second, _ = (_sum(power, weights * self.expansion[..., 2]) for power in self._powers())
        free = free.copy()
        free[..., 2] = (first * temperature_mid + second * temperature_gradient) / _sum(weights, self.thicknesses)
        return free

    def shear_stiffness(self) -> np.ndarray:
        """Transverse shear stiffness k G t for 13 and 23, (2, 2) (N/m); the laws hold the shear correction factor k.

        Those of a laminate's layers are scaled so that this is the shear stiffness of equilibrium.
        """
        return np.einsum("...l,...lij->...ij", self.thicknesses, self.stiffness[..., SHEAR, :][..., SHEAR])

    def _powers(self) -> np.ndarray:
        """Integrals of 1, z, z^2 over each layer, (3, n)."""
        return np.stack([np.diff(self.z**k) / k for k in (1, 2, 3)])


def require_one(section: Any) -> None:
    """InputError for sections of many places, and for a field of them."""
    if not isinstance(section, Section) or section.places is not None:
        raise InputError("section: it is another one at each place; give that of one, as in "
                         "system.assembly.section.at_places([[x], [y]]).one(0)")  # fmt: skip


def trace(matrices: np.ndarray) -> Any:
    """Of matrices (..., 3, 3)."""
    return np.trace(matrices, axis1=-2, axis2=-1)


def stress_of(law: np.ndarray, strain: np.ndarray) -> np.ndarray:
    """Stress (..., 6) of a strain and one law (6, 6), or one for each place."""
    return np.asarray(strain @ law if law.ndim == 2 else (strain[..., None, :] @ law)[..., 0, :])


def _sum(one: np.ndarray, two: np.ndarray) -> Any:
    """Sum over layers of the products of two of their numbers: a float, or an array of all places."""
    return float(one @ two) if one.ndim == 1 == two.ndim else (one * two).sum(axis=-1)


def _number(value: np.ndarray) -> Any:
    """A float of one section, an array of those of many places."""
    return value if value.ndim else float(value)


def _unless_rounding(value: Any, rounding: Any) -> Any:
    """A value, zero where it is no larger than rounding."""
    if isinstance(value, float):
        return value if abs(value) > rounding else 0.0
    return np.where(np.abs(value) > rounding, value, 0.0)
