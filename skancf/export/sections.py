"""Materials of bricks, and the axes of those that have some."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from skancf.errors import InputError
from skancf.export.bricks import Bricks
from skancf.functions import is_function
from skancf.materials import Isotropic, Laminate, Orthotropic
from skancf.materials.field import SectionField
from skancf.surfaces import normal
from skancf.vectors import cross

MIDDLE = np.array([[0.5], [0.5]])


@dataclass(frozen=True, eq=False)
class Group:
    """Bricks of one layer that have one material and one frame.

    Attributes
    ----------
    layer : int
    elements : (m,) int array
    material : Isotropic or Orthotropic
    axes : (2, 3) array or None
        The material's axes 1 and 2; None for an isotropic one.
    """

    layer: int
    elements: np.ndarray
    material: Any
    axes: np.ndarray | None


def groups(bricks: Bricks) -> list[Group]:
    """All of a system, layer by layer.

    Raises
    ------
    InputError
        For materials that are not exported.
    """
    section, geometry = bricks.system.problem.section, bricks.system.geometry
    if isinstance(section, SectionField):
        zones = bricks.system.assembly.section.zones
        given = {int(zone): _layers(section.given[zone].material) for zone in np.unique(zones)}
    else:
        zones, given = np.zeros(geometry.n_elements, dtype=int), {0: _layers(bricks.system.problem.material)}
    at = geometry.parameters(MIDDLE)[:, :, 0]
    one = geometry.surface.derivatives(*at)[0]
    one, n = one / np.linalg.norm(one, axis=0), normal(geometry.surface, *at)
    frame = np.stack([one, cross(n, one)]).transpose(2, 0, 1)
    out = []
    for layer in range(bricks.n_layers):
        for zone, layers in given.items():
            elements = np.flatnonzero(zones == zone)
            material, angle = layers[layer]
            if isinstance(material, Isotropic):
                out.append(Group(layer, elements, material, None))
                continue
            c, s = np.cos(angle), np.sin(angle)
            axes = np.einsum("ij,ejk->eik", np.array([[c, s], [-s, c]]), frame[elements])
            kinds, which = np.unique(axes.round(9).reshape(len(axes), -1), axis=0, return_inverse=True)
            for kind, own in enumerate(kinds.reshape(-1, 2, 3)):
                out.append(Group(layer, elements[which.ravel() == kind], material, own + 0.0))
    return out


def _layers(material: Any) -> list[tuple[Any, float]]:
    """Material and angle of each layer."""
    if is_function(material):
        raise InputError("material: a function of place is not exported; take zones with one material each")
    if isinstance(material, Laminate):
        found = [(layer.material, layer.angle + getattr(layer.material, "angle", 0.0)) for layer in material.layers]
    else:
        found = [(material, getattr(material, "angle", 0.0))]
    for each, _ in found:
        if type(each) not in (Isotropic, Orthotropic):
            raise InputError(f"material: class {type(each).__name__} is not exported; Isotropic, Orthotropic and a "
                             "Laminate of them are")  # fmt: skip
    return found


def cards(material: Any, name: str, density: bool, expansion: bool) -> list[str]:
    """A material in the words of CalculiX."""
    lines = [f"*MATERIAL,NAME={name}"]
    if isinstance(material, Isotropic):
        lines += ["*ELASTIC", f"{material.young:.12g},{material.poisson:.12g}"]
        kind, values = "ISO", [material.expansion]
    else:
        constants = [*material.young, *material.poisson, *material.shear]
        lines += [
            "*ELASTIC,TYPE=ENGINEERING CONSTANTS",
            ",".join(f"{v:.12g}" for v in constants[:8]),
            f"{constants[8]:.12g}",
        ]
        kind, values = "ORTHO", [*material.expansion]
    if expansion:
        lines += [f"*EXPANSION,TYPE={kind}", ",".join(f"{v:.12g}" for v in values)]
    return lines + ["*DENSITY", f"{material.density:.12g}"] * density
