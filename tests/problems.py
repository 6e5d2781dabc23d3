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
