"""Prescribed coordinates, at some nodes along directions of their own."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from skancf.errors import InputError
from skancf.showing import short
from skancf.tolerances import ORTHONORMAL


@dataclass(frozen=True, eq=False)
class Constraints:
    r"""Which coordinates are prescribed, counted in nodal frames :math:`\hat q = R q`.

    Parameters
    ----------
    fixed : (n_nodes, block) bool array
        True where the coordinate of the nodal frame is prescribed.
    frame_nodes : (m,) int array, optional
        Nodes with a frame other than the identity.
    frames : (m, block, block) array, optional
        Orthogonal matrices :math:`R`, of which the rows are the directions.

    Raises
    ------
    InputError
        For shapes that do not fit, a node named twice, or a frame that is not orthogonal.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> system = plate.on(sk.meshes.uniform(plate.surface, 6, 6), "kirchhoff")
    >>> print(system.constraints.n_free < system.n_dofs)
    True
    """

    fixed: np.ndarray
    frame_nodes: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int64))
    frames: np.ndarray = field(default_factory=lambda: np.zeros(0))

    __repr__ = short

    def __post_init__(self) -> None:
        fixed = np.asarray(self.fixed)
        nodes = np.asarray(self.frame_nodes, dtype=np.int64)
        if fixed.ndim != 2 or fixed.dtype != np.bool_:
            raise InputError(f"fixed of shape {fixed.shape} and type {fixed.dtype}: give bool (n_nodes, block)")
        shape = (nodes.size, fixed.shape[1], fixed.shape[1])
        frames = np.asarray(self.frames, dtype=float) if nodes.size else np.zeros(shape)
        _check_frames(nodes, frames, fixed.shape[0], shape)
        for name, value in (("fixed", fixed), ("frame_nodes", nodes), ("frames", frames)):
            object.__setattr__(self, name, value)

    @property
    def n_free(self) -> int:
        """Number of coordinates that are not prescribed."""
        return int(self.fixed.size - np.count_nonzero(self.fixed))

    def to_frame(self, v: np.ndarray) -> np.ndarray:
        """Coordinates in nodal frames, R v; (n_nodes * block,) to the same, always a new array."""
        return self._rotate(v, "kab,kb->ka")

    def from_frame(self, v: np.ndarray) -> np.ndarray:
        """Ordinary coordinates, R^T v; (n_nodes * block,) to the same, always a new array."""
        return self._rotate(v, "kba,kb->ka")

    def free_part(self, v: np.ndarray) -> np.ndarray:
        """Projection of ``v`` on the directions that are not prescribed."""
        return self._keep(v, ~self.fixed)

    def fixed_part(self, v: np.ndarray) -> np.ndarray:
        """Projection of ``v`` on the prescribed directions."""
        return self._keep(v, self.fixed)

    @cached_property
    def free_projection(self) -> sp.csr_matrix:
        """The matrix of :meth:`free_part`, symmetric, (n_nodes * block, n_nodes * block)."""
        n, block = self.fixed.shape
        framed = np.zeros(n, bool)
        framed[self.frame_nodes] = True
        plain = np.flatnonzero((~self.fixed & ~framed[:, None]).ravel())
        kept = (self.frames.swapaxes(1, 2) * ~self.fixed[self.frame_nodes][:, None]) @ self.frames
        at = block * self.frame_nodes[:, None] + np.arange(block)
        rows, columns = (np.concatenate([plain, each.ravel()]) for each in (
            np.repeat(at[:, :, None], block, axis=2), np.repeat(at[:, None, :], block, axis=1)))  # fmt: skip
        values = np.concatenate([np.ones(len(plain)), kept.ravel()])
        return sp.csr_matrix((values, (rows, columns)), shape=(n * block, n * block))

    def of_vectors(self) -> np.ndarray:
        """Projections of each vector of three coordinates on its prescribed directions, (n_nodes, block / 3, 3, 3)."""
        n = self.fixed.shape[1] // 3
        out = self.fixed.reshape(-1, n, 3, 1) * np.eye(3)
        if self.frame_nodes.size:
            held = (self.frames.swapaxes(1, 2) * self.fixed[self.frame_nodes][:, None]) @ self.frames
            out[self.frame_nodes] = np.einsum("ngigj->ngij", held.reshape(-1, n, 3, n, 3))
        return out

    def _keep(self, v: np.ndarray, mask: np.ndarray) -> np.ndarray:
        return self.from_frame(self.to_frame(v) * mask.ravel())

    def _rotate(self, v: np.ndarray, product: str) -> np.ndarray:
        nodal = np.array(v, dtype=float).reshape(self.fixed.shape)
        if self.frame_nodes.size:
            nodal[self.frame_nodes] = np.einsum(product, self.frames, nodal[self.frame_nodes])
        return nodal.ravel()


def _check_frames(nodes: np.ndarray, frames: np.ndarray, n_nodes: int, shape: tuple[int, ...]) -> None:
    if frames.shape != shape:
        raise InputError(f"frames of shape {frames.shape}: give {shape}, one matrix per frame node")
    if np.unique(nodes).size != nodes.size or not ((nodes >= 0) & (nodes < n_nodes)).all():
        raise InputError(f"frame_nodes = {nodes}: name each node once, from 0 to {n_nodes - 1}")
    error = np.abs(np.einsum("kab,kcb->kac", frames, frames) - np.eye(shape[1])).max(axis=(1, 2), initial=0.0)
    if not (error < ORTHONORMAL).all():
        worst = int(np.argmax(error))
        raise InputError(
            f"frame of node {nodes[worst]}: R R^T differs from one by {error[worst]:.1e}; give unit, "
            "mutually orthogonal rows"
        )
