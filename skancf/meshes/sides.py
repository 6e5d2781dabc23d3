"""What is told of the sides of a surface: names that lie elsewhere on the mesh, and two that lie on each other."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import skfem

from skancf.functions import is_function, true_at
from skancf.meshes.outline import box_of, on_box
from skancf.surfaces import closed_directions
from skancf.tolerances import ONE_PLACE

# Places along a side.
PLACES = 9


def misnamed(mesh: skfem.MeshQuad, surface: Any) -> str | None:
    """What is said of a boundary that has the name of one side of the surface and lies on another one; None without such.

    So it is where a mesh was mirrored, or its parameters exchanged.
    """
    box, names = box_of(mesh, surface.bounds), surface.sides
    for k, name in enumerate(names):
        facets = np.asarray((mesh.boundaries or {}).get(name, []), dtype=int)
        on = on_box(mesh, facets, box)[0].any(axis=2).ravel()
        if on.any() and not on[k]:
            other = int(np.argmax(on))
            here, there = (f"{'xy'[n // 2]} = {box[n // 2, n % 2]:.6g}" for n in (k, other))
            return (f"boundary {name!r} of the mesh lies on {there}, where the surface has {names[other]!r}; its "
                    f"own {name!r} is {here}. Supports and loads go where the mesh has the name: rename it, or mesh the "
                    "surface anew if the mesh was mirrored or turned")  # fmt: skip
    return None


def unjoined(mesh: skfem.MeshQuad, surface: Any, wheres: Iterable[tuple[str, Any]]) -> str | None:
    """What is said of two sides that lie on each other in space and are not joined, if no place among ``wheres``, each
    with the name of its argument, is one of them by its name or a function; None without such."""
    closed, names = closed_directions(surface), surface.sides
    for axis in (0, 1):
        if closed[axis] or not _meet(surface, axis):
            continue
        pair, bounds = names[2 * axis : 2 * axis + 2], surface.bounds[axis]
        sides = [mesh.p[:, np.abs(mesh.p[axis] - end) <= ONE_PLACE * np.ptp(bounds)] for end in bounds]
        if not any(_meant(*where, name, side) for where in wheres for name, side in zip(pair, sides, strict=True)):
            return (f"the sides {pair[0]!r} and {pair[1]!r} of the surface lie on each other and are not joined: it is slit "
                    "there, with two free edges that are part of 'boundary'. Say closed=True for a surface that is whole; "
                    "name one of the sides in a support or load where the slit is meant")  # fmt: skip
    return None


def _meet(surface: Any, axis: int) -> bool:
    """Whether the two sides at the ends of a parameter are one curve in space, and no point."""
    low, high = surface.bounds[1 - axis]
    along = np.linspace(low, high, PLACES)
    places = ([np.full(PLACES, end), along][:: 1 - 2 * axis] for end in surface.bounds[axis])
    first, second = (np.asarray(surface.position(*place)) for place in places)
    size = np.ptp(first, axis=1).max()
    return bool(size > 0 and np.abs(second - first).max() <= ONE_PLACE * size)


def _meant(argument: str, where: Any, name: str, side: np.ndarray) -> bool:
    if isinstance(where, str):
        return where == name
    if is_function(where):
        return bool(side.size and true_at(argument, where, side).all())
    return isinstance(where, Sequence) and any(_meant(argument, part, name, side) for part in where)
