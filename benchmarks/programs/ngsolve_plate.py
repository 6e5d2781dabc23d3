"""The linear Kirchhoff plate in NGSolve by Hellan-Herrmann-Johnson elements, the moments eliminated element by element."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np


def corner_mesh(outline: Sequence[tuple[float, float, str]], size: float, levels: Mapping[tuple[float, float], int]) -> Any:
    """Triangles inside a polygon: its points with the names of the sides that begin there.

    ``levels``: at these points so many rings of elements follow that are smaller by half each.
    """
    import ngsolve as ng
    from netgen.geom2d import SplineGeometry

    geometry = SplineGeometry()
    points = [geometry.AppendPoint(x, y, hpref=1.0 if (x, y) in levels else 0.0) for x, y, _ in outline]
    for k, (_, _, name) in enumerate(outline):
        geometry.Append(["line", points[k], points[(k + 1) % len(points)]], bc=name)
    mesh = ng.Mesh(geometry.GenerateMesh(maxh=size))
    mesh.RefineHP(levels=max(levels.values()), factor=0.5)
    return mesh


class Plate:
    """Deflection w, moments and rotations of the edges; add to ``load`` and ``force``, then solve."""

    def __init__(self, mesh: Any, order: int, data: Mapping[str, float], fixed: str = "", clamped: str = ""):
        import ngsolve as ng

        self.mesh = mesh
        young, nu, t = data["young"], data["poisson"], data["thickness"]
        deflections = ng.H1(mesh, order=order, dirichlet=fixed)
        moments = ng.HDivDiv(mesh, order=order - 1, discontinuous=True)
        self.space = deflections * moments * ng.NormalFacetFESpace(mesh, order=order - 1, dirichlet=clamped)
        (w, m, alpha), (self.v, n, beta) = self.space.TnT()
        normal = ng.specialcf.normal(2)
        compliance = 12 * (1 + nu) / (young * t**3)

        def turned(m: Any, w: Any, alpha: Any) -> Any:
            return (alpha - ng.Grad(w)) * normal * (m * normal) * normal

        self.form = ng.BilinearForm(self.space, symmetric=True, condense=True)
        hesse = ng.InnerProduct(m, self.v.Operator("hesse")) + ng.InnerProduct(n, w.Operator("hesse"))
        self.form += hesse * ng.dx
        self.form += -compliance * (ng.InnerProduct(m, n) - nu / (1 + nu) * ng.Trace(m) * ng.Trace(n)) * ng.dx
        self.form += (turned(m, self.v, beta) + turned(n, w, alpha)) * ng.dx(element_boundary=True)
        self.load = ng.LinearForm(self.space)
        self.z = ng.GridFunction(self.space)
        self.force = self.z.vec.CreateVector()
        self.force[:] = 0
        self.held = ng.BitArray(self.space.ndof)
        self.held.Clear()

    def at(self, corner: tuple[float, float]) -> int:
        """The deflection of the node at a point."""
        import ngsolve as ng

        points = np.array([v.point for v in self.mesh.vertices])
        nearest = int(np.linalg.norm(points - corner, axis=1).argmin())
        if np.linalg.norm(points[nearest] - corner) > 1e-9:
            raise ValueError(f"no node at {corner}")
        return int(self.space.components[0].GetDofNrs(ng.NodeId(ng.VERTEX, nearest))[0])

    def solve(self) -> Any:
        """The deflection."""
        form, z, force = self.form.Assemble(), self.z.vec, self.force
        force += self.load.Assemble().vec
        force += form.harmonic_extension_trans * force
        z.data = form.mat.Inverse(self.free, "sparsecholesky") * force
        z += form.harmonic_extension * z
        z += form.inner_solve * force
        return self.z.components[0]

    @property
    def free(self) -> Any:
        return self.space.FreeDofs(True) & ~self.held

    @property
    def dofs(self) -> int:
        return int(sum(self.free))
