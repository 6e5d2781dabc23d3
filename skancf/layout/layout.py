"""Which unknowns there are: blocks of twelve numbers, four vectors of three components each.

A block is a node of a plate (r, r_x, r_y and the fourth vector of its theory), a second block of one, or a body (r and three
directors). Blocks stand part by part, those of the plate first.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from skancf.errors import InputError, finite
from skancf.kernels.constants import AXES, BLOCK, VECTORS, R
from skancf.showing import short

EVERY = slice(None)
"""Index of all blocks."""


@dataclass(frozen=True, eq=False)
class Part:
    """Blocks that belong together.

    Parameters
    ----------
    name : str
    undeformed : (n, 4, 3) array
        Values of the unknowns in the undeformed state.
    scales : (n, 12) array
        The size in which each unknown counts, a power of two if scaling is to leave no rounding.
    places : (n, 3) array
        Where the blocks are in space, for the order of elimination and for messages.
    held : (n, 12) bool array, optional
        Unknowns that stay as they are. Default: none.
    moves : bool
        Whether the first vector of each block is a place in space, which a translation of everything moves. False for a
        second block of a node, all of whose vectors only turn.
    nodal : bool
        Whether there is one block for each node of the plate, whose field is interpolated as that of the plate is when the
        mesh changes. Blocks of other parts are the same on all meshes.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> system = plate.on(sk.meshes.uniform(plate.surface, 6, 6), "kirchhoff")
    >>> part = system.layout.parts[0]
    >>> print(part.name)
    plate
    """

    name: str
    undeformed: np.ndarray
    scales: np.ndarray
    places: np.ndarray
    held: np.ndarray | None = None
    moves: bool = True
    nodal: bool = False

    __repr__ = short

    def __post_init__(self) -> None:
        if not isinstance(self.name, str):
            raise InputError(f"name of a part = {self.name!r}: give a text")
        n = np.size(self.undeformed) // BLOCK
        shapes = {"undeformed": (n, VECTORS, AXES), "scales": (n, BLOCK), "places": (n, AXES)}
        for name, shape in shapes.items():
            value = finite(f"{name} of part {self.name!r}", getattr(self, name))
            if value.shape != shape:
                raise InputError(f"{name} of part {self.name!r}, of shape {value.shape}: give finite numbers, {shape}")
            object.__setattr__(self, name, value)
        if not (self.scales > 0).all():
            raise InputError(f"scales of part {self.name!r}: the size of an unknown is greater than zero")
        held = np.zeros((n, BLOCK), bool) if self.held is None else np.asarray(self.held)
        if held.shape != (n, BLOCK) or held.dtype != bool:
            raise InputError(f"held of part {self.name!r}, of shape {held.shape}: give bool of shape {(n, BLOCK)}")
        object.__setattr__(self, "held", held)

    def __len__(self) -> int:
        return len(self.undeformed)


class Layout:
    """Which unknowns there are, their numbers, undeformed values and views.

    Parameters
    ----------
    parts : sequence of Part
        With names of their own.

    Attributes
    ----------
    undeformed : (n_blocks, 4, 3) array
    scales : (n_blocks, 12) array
    places : (n_blocks, 3) array
    n_blocks, n_dofs : int
        Blocks, and unknowns, held ones included.
    shape : tuple
        Of all vectors, (n_blocks, 4, 3).
    moves : (n_blocks,) bool array
        Blocks whose first vector is a place in space, which a translation of everything moves; ``moving`` is the same as an
        index.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> system = plate.on(sk.meshes.uniform(plate.surface, 6, 6), "kirchhoff")
    >>> layout = system.layout
    >>> print(layout.n_blocks, layout.n_dofs, [part.name for part in layout.parts])
    49 588 ['plate']
    """

    moving: Any

    def __init__(self, parts: Sequence[Part]) -> None:
        names = [part.name for part in parts]
        if len(set(names)) < len(names):
            twice = next(name for name in names if names.count(name) > 1)
            raise InputError(f"two parts have the name {twice!r}; give each a name of its own")
        self.parts = tuple(parts)
        ends = np.cumsum([len(part) for part in parts]).tolist()
        starts = [0, *ends[:-1]]
        self._whole = names[0] if len(names) == 1 else None
        self._slices = {name: slice(*ends) for name, *ends in zip(names, starts, ends, strict=True)}
        self.undeformed, self.scales, self.places, self.held = (
            _joined([getattr(part, name) for part in parts]) for name in ("undeformed", "scales", "places", "held")
        )
        self.n_blocks, self.n_dofs, self.shape = ends[-1], BLOCK * ends[-1], self.undeformed.shape
        moves = np.repeat([part.moves for part in self.parts], [len(part) for part in self.parts])
        self.moves, self.moving = moves, EVERY if all(part.moves for part in parts) else moves

    def part(self, name: str) -> slice:
        """The blocks of a part.

        Raises
        ------
        InputError
            For a name that no part has.
        """
        if name not in self._slices:
            raise InputError(f"part {name!r}: the layout has {', '.join(map(repr, self._slices))}")
        return self._slices[name]

    def name_of(self, block: int) -> str:
        """The part to which a block belongs."""
        return next(name for name, part in self._slices.items() if part.start <= block < part.stop)

    def nodal(self, q: np.ndarray, name: str | None = None) -> np.ndarray:
        """Vectors (n_blocks, 4, 3) of unknowns (n_dofs,), a view where q is contiguous; of one part, or of all.

        Raises
        ------
        InputError
            For another number of unknowns.
        """
        if type(q) is not np.ndarray or q.dtype.char not in "dD" or not q.flags.c_contiguous:
            q = np.ascontiguousarray(q, dtype=complex if np.iscomplexobj(q) else float)
        if q.size != self.n_dofs:
            raise InputError(f"a vector of {q.size} nodal coordinates; this system has {self.n_dofs}, 12 per node")
        blocks = q.reshape(self.shape)
        return blocks if name is None or name == self._whole else blocks[self.part(name)]

    def flat(self, nodal: np.ndarray, name: str | None = None) -> np.ndarray:
        """Unknowns (n_dofs,) of vectors (n, 4, 3) of all blocks, or of those of one part and zero elsewhere."""
        if name is None or name == self._whole:
            return nodal.ravel()
        out = np.zeros(self.shape, nodal.dtype)
        out[self.part(name)] = nodal
        return out.ravel()

    def blocks(self, q: np.ndarray) -> np.ndarray:
        """Unknowns (n_dofs,) block by block, (n_blocks, 12)."""
        return q.reshape(-1, BLOCK)

    def dofs(self, name: str) -> slice:
        """Numbers of the unknowns of a part."""
        blocks = self.part(name)
        return slice(BLOCK * blocks.start, BLOCK * blocks.stop)

    def positions(self, q: np.ndarray) -> np.ndarray:
        """Those vectors of unknowns (n_dofs,) that a translation moves, (n, 3)."""
        return self.nodal(q)[self.moving, R]

    def arms(self, q: np.ndarray, about: np.ndarray) -> np.ndarray:
        """Vectors (n_blocks, 4, 3) of unknowns, a copy, positions from a point (3,)."""
        out = self.nodal(q).copy()
        out[self.moving, R] -= about
        return out


def _joined(arrays: Sequence[np.ndarray | None]) -> np.ndarray:
    return np.asarray(arrays[0] if len(arrays) == 1 else np.concatenate([np.asarray(a) for a in arrays]))


def vectors(q: np.ndarray) -> np.ndarray:
    """Vectors of unknowns one after another, (n, 3), a view."""
    return q.reshape(-1, AXES)


def nodal(q: np.ndarray) -> np.ndarray:
    """Vectors (n, 4, 3) of unknowns (12 n,) of blocks, a view."""
    return q.reshape(-1, VECTORS, AXES)
