"""The flat plate."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from skancf.equality import by_value
from skancf.surfaces.protocol import parameters


@by_value
@dataclass(frozen=True)
class Plane:
    """The plane z = 0 with x and y as parameters, for any mesh of it.

    Its boundaries are the named boundaries of the mesh. Its normal is +z.

    Examples
    --------
    >>> import skfem
    >>> mesh = skfem.MeshQuad().refined(2).with_boundaries({"left": lambda x: x[0] == 0.0})
    >>> plate = sk.Problem(sk.Plane(), 0.01, sk.Isotropic(70e9, 0.3, 2700.0), [sk.Clamp("left")])
    >>> plate.on(mesh, theory="full").n_dofs
    300
    """

    def position(self, x: Any, y: Any) -> np.ndarray:
        x, y = parameters(x, y)
        return np.stack([x, y, np.zeros_like(x)])

    def derivatives(self, x: Any, y: Any) -> tuple[np.ndarray, np.ndarray]:
        zero = np.zeros(np.broadcast(x, y).shape)
        return np.stack([zero + 1, zero, zero]), np.stack([zero, zero + 1, zero])

    def second_derivatives(self, x: Any, y: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        shape = (3, *np.broadcast(x, y).shape)
        return np.zeros(shape), np.zeros(shape), np.zeros(shape)

    @property
    def closed(self) -> tuple[bool, bool]:
        return False, False
