"""What sections that vary over a mesh must be, and what they should be: positive, flat, and one at a seam."""

import numpy as np

from skancf.elements.reference import CORNERS
from skancf.errors import warn
from skancf.layout.geometry import Geometry
from skancf.materials import SectionField
from skancf.materials.section import trace
from skancf.tolerances import ONE_PLACE

MIDDLES = np.array([[0.5, 1.0, 0.5, 0.0], [0.0, 0.5, 1.0, 0.5]])
"""Points (2, 4) in the middles of an element's sides, as ``mesh.t2f`` has them."""
JUMP = 0.01
"""Of the larger membrane stiffness, or of the thickness: a smaller difference does not count."""
INCLINED, TAPERED, LARGEST = 1.5, 0.2, 0.02
r"""What plate theory leaves out where a plate is inclined to its surface or its faces are, in squares of slopes, and the
part of stiffness or stress of which a user hears. Of an inclined plate heights along the normal of the surface are larger
than its thickness, by the inverse of a cosine, of which the bending stiffness has the cube. A wedge of half the angle a has
a stress of :math:`\sin^3 a / (1.5 \cos a (a - \sin a \cos a))` times that of a beam (J. H. Michell 1900): 1 + a^2 / 5."""


def check_sections(field: SectionField, geometry: Geometry, zones: np.ndarray) -> None:
    """Of sections that vary within zones, of elements in zones of these numbers (n_elements,).

    Raises
    ------
    InputError
        For a thickness that is not positive at a node, where nothing integrates but stresses are asked for.
    OutOfDepth
        Warned: for a plate that is inclined to its surface, for faces that are, and for a jump at a seam.
    """
    field.at(geometry.parameters(CORNERS.T), zones[:, None])
    _warn_of_slopes(field, geometry, zones)
    for axis, bounds in geometry.closed_bounds().items():
        _warn_of_seam(field, geometry, zones, axis, bounds)


def _warn_of_slopes(field: SectionField, geometry: Geometry, zones: np.ndarray) -> None:
    places = geometry.parameters(MIDDLES)
    z = field.at(places, zones[:, None]).z
    middle, half = (z[..., 0] + z[..., -1]) / 2, (z[..., -1] - z[..., 0]) / 2
    points, one, two = np.asarray(geometry.surface.position(*places)), [0, 1], [2, 3]
    length = np.linalg.norm(points[..., one] - points[..., two], axis=0)
    inclined, tapered = (np.abs(each[..., one] - each[..., two]) / length for each in (middle, half))
    left_out = INCLINED * inclined**2 + TAPERED * tapered**2
    if left_out.max() <= LARGEST:
        return
    worst = np.unravel_index(int(np.argmax(left_out)), left_out.shape)
    x, y = places[:, worst[0]].mean(axis=-1)
    warn(f"near (x, y) = ({x:.2g}, {y:.2g}) the middle of the plate has the slope {inclined[worst]:.2f} against the "
         f"surface, and its faces {tapered[worst]:.2f} against that: stress and stiffness have some "
         f"{100 * left_out[worst]:.1g} % of error there. Take a surface in the middle of the plate, a gentler taper, or a "
         "zone where the thickness jumps")  # fmt: skip


def _warn_of_seam(
    field: SectionField, geometry: Geometry, zones: np.ndarray, axis: int, bounds: tuple[float, float]
) -> None:
    mesh, (low, high) = geometry.mesh, bounds
    facets = mesh.boundary_facets()
    at = mesh.p[:, mesh.facets[:, facets]]
    facets = facets[(np.abs(at[axis] - low) < ONE_PLACE * (high - low)).all(axis=0)]
    here = mesh.p[:, mesh.facets[:, facets]].mean(axis=1)
    there = here.copy()
    here[axis], there[axis] = low, high
    sides = np.full((2, len(facets)), -1)
    for row, places in zip(sides, (here, there), strict=True):
        inside, elements, _ = geometry.locate_inside(places)
        row[inside] = zones[elements]
    same = (sides[0] == sides[1]) & (sides[0] >= 0)
    if not same.any():
        return
    one, two = (field.at(places[:, same], sides[0, same]) for places in (here, there))
    size = np.maximum(one.thickness, two.thickness)
    stiffness = [trace(each.abd()[..., :3, :3]) for each in (one, two)]
    apart = np.max([np.abs(one.z[..., 0] - two.z[..., 0]) / size, np.abs(one.z[..., -1] - two.z[..., -1]) / size,
                    np.abs(stiffness[0] - stiffness[1]) / np.maximum(*stiffness)], axis=0)  # fmt: skip
    if (apart > JUMP).any():
        name, other, at = "xy"[axis], "yx"[axis], here[1 - axis, same][int(np.argmax(apart))]
        warn(f"thickness, offset or material jump at the seam, from {name} = {high:.6g} to {low:.6g}, at {other} = "
             f"{at:.6g}; where that is meant, let two zones meet at the seam, so that the error estimate knows "
             "of it")  # fmt: skip
