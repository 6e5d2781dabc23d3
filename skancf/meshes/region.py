"""Where a mesh shall be fine."""

from collections.abc import Iterable
from dataclasses import dataclass

from skancf.arguments import plain, sequence
from skancf.equality import by_value
from skancf.errors import InputError, number, vector
from skancf.showing import listed, short

REGION = "regions, as stress_regions finds them or as in [Region((0.5, 0.5), (0.1, 0.1))]"


@by_value
@dataclass(frozen=True)
class Region:
    r"""A rectangle of the parameter plane in which the mesh shall be fine.

    Parameters
    ----------
    centre : (2,) tuple
        The node whose stress is the largest around (units of the parameter plane).
    half_size : (2,) tuple
        Half the lengths of the rectangle, positive. It may reach over the bounds of the surface.
    ratio : float
        :math:`\sigma_i / \bar\sigma > 1`, the degree of stress concentration. The larger, the finer; 4 halves elements.
    value : float, optional
        :math:`\sigma_i` itself, for reports.

    Raises
    ------
    InputError
        For entries that are not finite, sizes that are not positive and a ratio that is not greater than 1.

    Examples
    --------
    >>> corner = sk.meshes.Region(centre=(0.0, 0.0), half_size=(0.1, 0.1), ratio=4.0)
    >>> mesh = sk.meshes.graded(sk.Rectangle(1.0, 1.0), [corner], nodes=81)
    >>> print(mesh.nvertices)
    81
    """

    centre: tuple[float, float]
    half_size: tuple[float, float]
    ratio: float = 4.0
    value: float | None = None

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        vector("centre", self.centre, 2)
        if not (vector("half_size", self.half_size, 2) > 0).all():
            raise InputError(f"half_size = {self.half_size}: give two lengths greater than zero")
        if not number("ratio", self.ratio) > 1:
            raise InputError(
                f"ratio = {self.ratio}: a region is where the stress exceeds its mean; "
                "give a ratio greater than 1 or leave the region out"
            )
        if self.value is not None:
            number("value", self.value)


class Regions(tuple[Region, ...]):
    """Regions found on a mesh, with the lengths (2,) of its elements in the parameter plane as ``cell``.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(sk.Rectangle(1.0, 1.0), 0.02, steel, [sk.Pin("corners")], [sk.SurfaceLoad((0, 0, -1000.0))])
    >>> solution = sk.solve_linear(plate.on(sk.meshes.uniform(plate.surface, 8, 8), "kirchhoff"))
    >>> regions = sk.stress_regions(solution, z="top")
    >>> print(len(regions), regions.cell)
    4 (0.125, 0.125)
    """

    cell: tuple[float, float]

    __repr__ = listed

    def __new__(cls, regions: Iterable[Region], cell: tuple[float, float]) -> "Regions":
        self = super().__new__(cls, sequence("regions", regions, Region, REGION))
        if not (vector("cell", cell, 2) > 0).all():
            raise InputError(f"cell = {cell}: give two lengths greater than zero")
        self.cell = cell
        return self
