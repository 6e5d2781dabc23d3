"""Shell problems that several test files share."""

from math import pi, radians

import skancf as sk

PULLED, PUSHED = (pi / 2, 0.0), (pi / 2, pi / 2)


def hemisphere(thickness: float = 0.04, force: float = 1.0) -> sk.Problem:
    """A quarter of a hemisphere with a hole of 18 degrees, pulled along x and pushed along y by ``force`` per quarter."""
    return sk.Problem(
        sk.SphereSector(10.0, (radians(18), pi / 2), pi / 2), thickness, sk.Isotropic(6.825e7, 0.3, 1.0),
        [sk.Symmetry("start"), sk.Symmetry("end"), sk.Roller(PULLED)],
        [sk.PointForce(PULLED, (force, 0, 0)), sk.PointForce(PUSHED, (0, -force, 0))],
    )  # fmt: skip


SURFACES = {
    "flat": (sk.Rectangle(1.0, 0.8), 2, 2),
    "tube": (sk.CylinderSector(1.0, 1.0, 2 * pi, closed=True), 2, 4),
    "ring": (sk.AnnulusSector(0.5, 1.0, 2 * pi, closed=True), 2, 4),
    "cap": (sk.SphereSector(1.0, (0.0, 0.8), 2 * pi, closed=True), 2, 4),
    "disc": (sk.AnnulusSector(0.0, 1.0, 2 * pi, closed=True), 2, 4),
}  # fmt: skip
"""A surface of each kind, and the elements of a coarse mesh in both directions."""
