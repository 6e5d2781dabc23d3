"""Rigid motions of a layout, and which of them nothing holds."""

from typing import Any

import numpy as np
import scipy.sparse as sp

from skancf.layout.layout import Layout
from skancf.tolerances import ONE_DIRECTION, PARALLEL, ROUNDED_PRODUCT

AXES = np.eye(3)


def rigid_motions(layout: Layout, size: float) -> np.ndarray:
    """The six rigid motions of the undeformed state, translations by ``size`` and rotations about the centre by one, linear:
    (6, n_dofs)."""
    centred = layout.arms(layout.undeformed, layout.positions(layout.undeformed).mean(axis=0))
    modes = np.zeros((6, *centred.shape))
    for i, axis in enumerate(AXES):
        modes[i, layout.moving, 0] = size * axis
        modes[3 + i] = np.cross(axis, centred)
    return modes.reshape(6, -1)


def free_rigid_motions(system: Any) -> list[str]:
    """The rigid motions that constraints, and the structure's terms but for the shell, leave free, in words."""
    layout, constraints, foundation = system.layout, system.constraints, system.foundation
    positions, scales = layout.positions(layout.undeformed), layout.scales
    centre = positions.mean(axis=0)
    size = float(np.abs(positions - centre).max())
    modes = rigid_motions(layout, size)
    fixed, sizes = constraints.fixed.ravel(), scales.copy()
    if constraints.frame_nodes.size:
        sizes[constraints.frame_nodes] = np.linalg.norm(constraints.frames * scales[constraints.frame_nodes, None], axis=2)
    held = np.array([(constraints.to_frame(mode) / sizes.ravel())[fixed] for mode in modes])
    if foundation is not None:
        resisting = np.array([scales.ravel() * (foundation @ mode) for mode in modes])
        terms = max(float(np.abs(scales.ravel() * (foundation.sizes() @ np.abs(mode))).max()) for mode in modes)
        resisting[np.abs(resisting) < ROUNDED_PRODUCT * terms] = 0.0  # of terms between parts of the structure
        held = np.hstack([held, resisting / (np.abs(resisting).max() or 1.0)])
    if system.conditions:
        held = np.hstack([held, _held_by(system.conditions.gradient(system.undeformed), modes)])
    vectors, sizes, _ = np.linalg.svd(np.hstack([held, np.zeros((6, 6))]), full_matrices=False)
    free = vectors[:, sizes < PARALLEL * max(1.0, sizes[0])].T
    pure = [i for i in range(6) if not held.size or np.abs(held[i]).max() < PARALLEL]
    rest = free - free[:, pure] @ np.eye(6)[pure] if pure else free
    _, sizes, rows = np.linalg.svd(rest) if rest.size else (None, np.zeros(0), np.zeros((0, 6)))
    others = rows[: int((sizes > ONE_DIRECTION).sum())]
    names = [f"translation along {'xyz'[i]}" if i < 3 else f"rotation about {'xyz'[i - 3]}" for i in pure]
    return names + [_motion_in_words(row[:3] * size, row[3:], centre) for row in others]


def _held_by(gradient: sp.csr_matrix, modes: np.ndarray) -> np.ndarray:
    """What rigid motions (6, n_dofs) make of conditions, (6, n), in the sizes of their terms; those between parts of the
    body make nothing."""
    sizes = (abs(gradient) @ np.abs(modes.T)).max(axis=1, initial=0.0)
    found = (gradient @ modes.T) / np.where(sizes > 0, sizes, 1.0)[:, None]
    return np.asarray(np.where(np.abs(found) > ROUNDED_PRODUCT, found, 0.0).T)


def _motion_in_words(translation: np.ndarray, rotation: np.ndarray, centre: np.ndarray) -> str:
    """A rigid motion given by the translation of the centre and the rotation about it."""

    def text(v: np.ndarray) -> str:
        return "(" + ", ".join(f"{x + 0.0:.4g}" for x in np.round(v, 12)) + ")"

    turn = np.linalg.norm(rotation)
    if turn * np.linalg.norm(centre) < PARALLEL * np.linalg.norm(translation) or turn < ROUNDED_PRODUCT:
        return f"translation along {text(translation / np.linalg.norm(translation))}"
    axis = rotation / turn
    point = centre + np.cross(rotation, translation) / turn**2
    slide = "" if abs(axis @ translation) < PARALLEL * np.linalg.norm(translation) else " with a slide along it"
    return f"rotation about the line through {text(point)} along {text(axis)}{slide}"
