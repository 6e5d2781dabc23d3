"""Laminates: layers of any law, each turned by its own angle."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from skancf.arguments import plain
from skancf.equality import by_value
from skancf.errors import InputError, number, positive, shown
from skancf.materials.law import Law, require_law, stiffness_of, thinning_of, turned, turned_strain, turned_thinning
from skancf.materials.made import stack
from skancf.materials.point_law import is_point_law
from skancf.materials.section import Section
from skancf.materials.shear import with_shear_of_equilibrium
from skancf.showing import short


@by_value
@dataclass(frozen=True)
class Layer:
    """A layer of a laminate.

    Parameters
    ----------
    material : Law
        For example :class:`~skancf.Orthotropic`.
    thickness : float
        m.
    angle : float
        Turn about the normal, added to the material's own angle (radians).

    Raises
    ------
    InputError
        For a thickness that is not positive, an angle that is not finite, and a material that is no law.

    Examples
    --------
    >>> ply = sk.Orthotropic(young=(138e9, 9e9, 9e9), poisson=(0.3, 0.3, 0.4), shear=(7e9, 7e9, 3.2e9), density=1600.0)
    >>> cross = sk.Laminate([sk.Layer(ply, 0.125e-3, angle) for angle in (0, np.pi / 2, np.pi / 2, 0)])
    >>> print(f"{1000 * cross.section().thickness} mm")
    0.5 mm
    """

    material: Law
    thickness: float
    angle: float = 0.0

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        if is_point_law(self.material):
            raise InputError(f"layers of {type(self.material).__name__}: laminates of laws at points are not there yet; "
                             "give such a law to a plate of one layer, or a linear one to the layer")  # fmt: skip
        require_law(self.material)
        positive("thickness of a layer", self.thickness, "m")
        number("angle", self.angle)

    def stiffness(self) -> np.ndarray:
        """C, shape (6, 6), in the frame of the surface (Pa)."""
        return turned(stiffness_of(self.material), self.angle)

    def thermal_strain(self) -> np.ndarray:
        """Free strain per kelvin, shape (6,), in the frame of the surface."""
        return turned_strain(self.material.thermal_strain(), self.angle)


@by_value
@dataclass(frozen=True)
class Laminate:
    """Perfectly bonded layers; in a problem it stands for the material and the thickness.

    Parameters
    ----------
    layers : sequence of Layer
        From bottom to top.
    offset : float
        Height of the laminate's mid-plane above the reference surface (m).

    Raises
    ------
    InputError
        For no layers, an invalid layer, and an offset that is not finite.

    Notes
    -----
    The transverse shear stiffness of the layers together is that of shear stresses in equilibrium (Whitney 1973, Rohwer
    1988), whatever the layup: :func:`skancf.materials.shear.equilibrium_stiffness`. A law's ``shear_correction`` other than
    5/6 scales its shear modulus by its ratio to 5/6, and equal layers are one layer. Transverse shear stresses S13 and S23
    are constant in a layer; those of all layers sum to the shear force.

    On curved surfaces lengths and areas are those at the height of the layers: theory `kirchhoff` has them to first order in
    thickness over radius, and warns where that is not small; theory `full` integrates.

    Weight acts at the centre of mass of the layers. In theory `kirchhoff` the mass is in the reference surface, whatever the
    offset: vibration and motion come with a warning where that is more than a hundredth of the thickness off. Surface and
    edge loads act at the reference surface, per its area and length.

    Examples
    --------
    >>> ply = sk.Orthotropic(young=(177e9, 10.8e9, 10.8e9), poisson=(0, 0, 0), shear=(7.6e9, 7.6e9, 8.5e9), density=1600)
    >>> cross_ply = sk.Laminate([sk.Layer(ply, 0.25e-3), sk.Layer(ply, 0.25e-3, angle=np.pi / 2)])
    >>> plate = sk.Problem(surface=sk.Rectangle(0.5, 0.5), material=cross_ply, supports=[sk.Clamp("left")])
    """

    layers: Sequence[Layer]
    offset: float = 0.0

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        if not isinstance(self.layers, Sequence) or isinstance(self.layers, str | bytes) or not len(self.layers):
            raise InputError(f"layers = {shown(self.layers)}: give a list of layers, as in [Layer(material, thickness)]")
        object.__setattr__(self, "layers", tuple(self.layers))
        for layer in self.layers:
            if not isinstance(layer, Layer):
                raise InputError(f"layers: {shown(layer)} is not a layer; give Layer(material, thickness, angle)")
        number("offset", self.offset)

    def section(self) -> Section:
        """The layers in the frame of the surface, at their heights above the reference surface.

        Their transverse shear moduli are scaled so that their sum is the shear stiffness of equilibrium.
        """
        tops = np.cumsum([0.0] + [layer.thickness for layer in self.layers])
        return with_shear_of_equilibrium(stack(
            tops - tops[-1] / 2 + self.offset, [layer.stiffness() for layer in self.layers],
            [layer.material.density for layer in self.layers], [layer.thermal_strain() for layer in self.layers],
            [turned_thinning(thinning_of(layer.material), layer.angle) for layer in self.layers],
        ))  # fmt: skip
