"""Meshes of quads: corner numberings, distortion."""

import numpy as np
import skfem


def uneven() -> skfem.MeshQuad:
    """Two by two rectangles of four different shapes, corners numbered clockwise."""
    return skfem.MeshQuad.init_tensor([0.0, 0.3, 1.0], [0.0, 0.6, 0.9])


def renumbered(mesh: skfem.MeshQuad, turns: int = 0, mirror: bool = False) -> skfem.MeshQuad:
    """The same quads, element e starting at corner e + turns, run through the other way round if mirror."""
    t = mesh.t[::-1] if mirror else mesh.t
    t = np.stack([np.roll(t[:, e], e + turns) for e in range(t.shape[1])], axis=1)
    return skfem.MeshQuad(mesh.p, t, sort_t=False)


def distorted(mesh: skfem.MeshQuad, amount: float = 0.15) -> skfem.MeshQuad:
    """Every node moved by up to ``amount`` of the smallest edge, by numbers that are always the same."""
    edges = mesh.p[:, mesh.facets[1]] - mesh.p[:, mesh.facets[0]]
    smallest = np.sqrt((edges**2).sum(axis=0)).min()
    moved = mesh.p + amount * smallest * np.random.default_rng(3).uniform(-1, 1, mesh.p.shape)
    return skfem.MeshQuad(moved, mesh.t, sort_t=False)


def area(mesh: skfem.MeshQuad) -> float:
    """Of all quads: half the product of the diagonals."""
    corner = mesh.p[:, mesh.t]
    (a, b), (c, d) = corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1]
    return float(np.abs(a * d - b * c).sum() / 2)


ALIGNED = {
    "counter-clockwise": skfem.MeshQuad().refined(1),
    "clockwise": uneven(),
    "quarter turns": renumbered(uneven(), turns=1),
    "quarter turns, mirrored": renumbered(uneven(), turns=2, mirror=True),
}
GENERAL = {
    "distorted": distorted(uneven()),
    "distorted, mirrored": renumbered(distorted(uneven()), turns=3, mirror=True),
    "strongly distorted": distorted(skfem.MeshQuad().refined(1), 0.35),
}
ALL = {**ALIGNED, **GENERAL}
