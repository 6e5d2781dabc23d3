"""The nonlinear Koiter shell of Neunteufel and Schoeberl in NGSolve: Hellan-Herrmann-Johnson moments, Regge strains.

Neunteufel, M., Schoeberl, J. (2019) The Hellan-Herrmann-Johnson method for nonlinear shells. Computers and Structures 225.
Neunteufel, M., Schoeberl, J. (2021) Avoiding membrane locking with Regge interpolation. CMAME 373.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

SOLVER = "pardiso"


class DidNotConverge(RuntimeError):
    """Newton's iteration, or its steps, came to no end."""


def surface_mesh(mapping: Callable[..., Any], counts: tuple[int, int], order: int, flat: bool) -> Any:
    """Quadrilaterals over the unit square, curved to the order; sides left, right, bottom and top of the square."""
    import netgen.meshing as netgen
    import ngsolve as ng

    mesh = ng.Mesh(netgen.SurfaceGeometry(mapping).GenerateMesh(quads=True, nx=counts[0], ny=counts[1]))
    if not flat:
        mesh.Curve(order)
    return mesh


class Shell:
    """Displacement u, moments m (eliminated element by element) and rotations of the edges.

    ``fixed``: for x, y and z the sides that do not move, ``clamped`` those that do not turn, ``mirrors`` those that lie in
    a plane of symmetry. Edge weights J / |F t| measure curvature per undeformed length on edges, too, as elements do.
    """

    def __init__(self, mesh: Any, order: int, data: Any, flat: bool, fixed: Sequence[str] = ("", "", ""), clamped: str = "",
                 mirrors: str = "", density: float = 0.0):  # fmt: skip
        import ngsolve as ng

        self.mesh, self.flat = mesh, flat
        t, young, nu = data["thickness"], data["young"], data["poisson"]
        displacement = ng.VectorH1(mesh, order=order, **{f"dirichlet{c}_bbnd": s for c, s in zip("xyz", fixed, strict=True)})
        moments = ng.HDivDivSurface(mesh, order=order - 1, discontinuous=True)
        turned = "|".join(s for s in (clamped, mirrors) if s)
        rotations = ng.NormalFacetSurface(mesh, order=order - 1, dirichlet_bbnd=turned)
        forces = ng.HCurlCurl(mesh, order=order - 1, discontinuous=True)
        self.space = displacement * moments * rotations * forces
        u, m, alpha, n = self.space.TrialFunction()
        m, alpha, n = m.Trace(), alpha.Trace(), n.Trace()
        self.z = ng.GridFunction(self.space)
        self.u = self.z.components[0]

        normal, tangent = ng.specialcf.normal(3), ng.specialcf.tangential(3)
        conormal = ng.Cross(normal, tangent)
        plane = ng.Id(3) - ng.OuterProduct(normal, normal)
        gradient = ng.Grad(u).Trace() + plane
        area = ng.Cof(gradient) * normal
        stretch = ng.Norm(area)
        now = 1 / stretch * area
        edge = gradient * tangent
        edge_stretch = ng.Norm(edge)
        along = 1 / edge_stretch * edge
        curvature = (u.Operator("hesseboundary").trans * now).Reshape((3, 3))
        if not flat:
            curvature = curvature + (1 - normal * now) * ng.Grad(normal)
        strain = 0.5 * (gradient.trans * gradient - plane)

        # The normal of an edge is measured from the mean of both sides at the last step.
        self.everywhere = mesh.Boundaries(".*")
        facets = ng.VectorFacetSurface(mesh, order=order - 1)
        self.mean, first = ng.GridFunction(facets), ng.GridFunction(facets)
        first.Set(normal, dual=True, definedon=self.everywhere)
        self.mean.vec.data = first.vec
        self.normal_now = self._mean_normal(clamped, mirrors, normal, conormal, plane)
        upright = ng.Normalize(self.mean - (along * self.mean) * along)
        angle = ng.acos(ng.Cross(now, along) * upright) - ng.acos(conormal * ng.Normalize(first))

        # Forces as unknowns of each element instead of interpolated strains: as accurate, and a third of the iterations.
        stretching = (1 + nu) / (young * t) * (ng.InnerProduct(n, n) - nu / (1 + nu) * ng.Trace(n) ** 2)
        membrane = 2 * ng.InnerProduct(n, strain) - stretching
        bending = 12 * (1 + nu) / (young * t**3) * (ng.InnerProduct(m, m) - nu / (1 + nu) * ng.Trace(m) ** 2)
        self.form = ng.BilinearForm(self.space, symmetric=True, condense=True)
        edges = ng.ds(element_boundary=True)
        bent = ng.InnerProduct(curvature, m) - 0.5 * bending
        for energy, measure in (
            (0.5 * membrane, ng.ds), (bent, ng.ds),
            (stretch / edge_stretch * (angle + alpha * conormal) * m[conormal, conormal], edges),
        ):  # fmt: skip
            ng.ngsglobals.symbolic_integrator_uses_diff = not flat and energy is bent
            self.form += ng.Variation(energy * measure).Compile()
        ng.ngsglobals.symbolic_integrator_uses_diff = False
        self.inertia, self.expected = ng.Parameter(0.0), ng.GridFunction(displacement)
        self.density = density * t
        if density:
            off = u - self.expected
            self.form += ng.Variation(0.5 * self.inertia * self.density * ng.InnerProduct(off, off) * ng.ds)
        self.load = self.z.vec.CreateVector()
        self.load[:] = 0
        self.conormal = conormal
        self.held = ng.BitArray(self.space.ndof)
        self.held.Clear()
        self.iterations = self.steps = 0

    def _mean_normal(self, clamped: str, mirrors: str, normal: Any, conormal: Any, plane: Any) -> Any:
        import ngsolve as ng

        now = ng.Normalize(ng.Cof(plane + ng.Grad(self.u)) * normal)
        marks = []
        for names in (clamped, mirrors):
            mark = ng.GridFunction(ng.FacetSurface(self.mesh, order=0))
            if names:
                mark.Set(1, definedon=self.mesh.BBoundaries(names))
            marks.append(mark)
        return (1 - marks[0]) * now - marks[1] * (now * conormal) * conormal + marks[0] * normal

    def at(self, corner: Sequence[float], axis: int) -> int:
        """The coordinate of the displacement of the node at a point of the undeformed surface."""
        import ngsolve as ng

        points = np.array([v.point for v in self.mesh.vertices])
        nearest = int(np.linalg.norm(points - np.asarray(corner), axis=1).argmin())
        if np.linalg.norm(points[nearest] - corner) > 1e-6 * (1 + np.abs(points).max()):
            raise ValueError(f"no node at {corner}")
        component = self.space.components[0].components[axis]
        return int(self.space.components[0].Range(axis).start + component.GetDofNrs(ng.NodeId(ng.VERTEX, nearest))[0])

    def displacement(self, x: float, y: float, z: float) -> Any:
        import ngsolve as ng

        return np.array(self.u(self.mesh(x, y, z, ng.BND)))

    def spread(self, density: Any) -> None:
        """Adds a dead load: a density times the test functions, over a measure."""
        import ngsolve as ng

        form = ng.LinearForm(self.space)
        form += density
        self.load += form.Assemble().vec

    def hold(self, dof: int) -> None:
        """Its value is prescribed."""
        self.held[dof] = True

    def equilibrium(self, factor: float, prescribed: dict[int, float], rtol: float, limit: int = 12) -> int:
        """Newton's iteration from the present state, each of its systems without the moments."""
        import ngsolve as ng

        z, form = self.z.vec, self.form
        free = ng.BitArray(self.space.FreeDofs(True)) & ~self.held
        jump, residual, step = z.CreateVector(), z.CreateVector(), z.CreateVector()
        jump[:] = 0
        for dof, value in prescribed.items():
            jump[dof] = value - z[dof]
        before = np.inf
        for iteration in range(limit):
            self.mean.Set(self.normal_now, dual=True, definedon=self.everywhere)
            self.z.components[2].vec[:] = 0
            form.AssembleLinearization(z)
            form.Apply(z, residual)
            residual *= -1
            residual += factor * self.load
            residual += form.harmonic_extension_trans * residual
            residual -= form.mat * jump
            step.data = form.mat.Inverse(free, SOLVER) * residual
            step += jump
            step += form.harmonic_extension * step
            step += form.inner_solve * residual
            jump[:] = 0
            z += step
            self.iterations += 1
            change, size = self.largest(step), self.largest(z)
            # It may grow once, from the linear solution to the first with forces.
            if not change < (3 if iteration < 2 else 1) * max(before, size if iteration < 2 else 0.0):
                raise DidNotConverge(f"Newton: a change of {change:.1e} follows on {before:.1e}")
            before = change
            if change < rtol * size:
                return iteration + 1
        raise DidNotConverge(f"Newton: change {change:.1e} of {size:.1e} after {limit} iterations")

    def largest(self, vector: Any) -> float:
        """Of the coordinates of the displacement."""
        return float(np.abs(vector.FV().NumPy()[: self.space.components[0].ndof]).max())

    def move(self, end: float, steps: int, factor: Callable[[float], float], seen: Any, times: Sequence[float],
             bossak: float = -0.05, rtol: float = 1e-4) -> dict[str, list[float]]:  # fmt: skip
        """Newmark's method with Bossak's damping, equal steps; displacements of points over the times."""
        import ngsolve as ng

        dt, beta, gamma = end / steps, 0.25 * (1 - bossak) ** 2, 0.5 - bossak
        space = self.space.components[0]
        self.inertia.Set((1 - bossak) / (beta * dt**2))
        w, v = space.TnT()
        mass = ng.BilinearForm(space, symmetric=True)
        mass += self.density * ng.InnerProduct(w, v) * ng.ds
        free = ng.BitArray([self.space.FreeDofs()[k] and not self.held[k] for k in range(space.ndof)])
        accelerations, velocities, old = (self.u.vec.CreateVector() for _ in range(3))
        loads = self.u.vec.CreateVector()
        loads.FV().NumPy()[:] = factor(0.0) * self.load.FV().NumPy()[: space.ndof]
        accelerations.data = mass.Assemble().mat.Inverse(free, "sparsecholesky") * loads
        u, a, v, before, expected = (x.FV().NumPy() for x in (self.u.vec, accelerations, velocities, old, self.expected.vec))
        v[:] = 0
        watched = [self.at(point, axis) for point, axis in seen.values()]
        path = np.zeros((steps + 1, 2, len(watched)))
        for k in range(steps):
            before[:] = u
            path[k] = u[watched], v[watched]
            ballistic = u + dt * v + dt**2 * (0.5 - beta) * a
            expected[:] = ballistic - beta * dt**2 * bossak / (1 - bossak) * a
            self.equilibrium(factor((k + 1) * dt), {}, rtol)
            self.steps += 1
            new = (u - ballistic) / (beta * dt**2)
            v += dt * ((1 - gamma) * a + gamma * new)
            a[:] = new
        path[steps] = u[watched], v[watched]
        return dict(zip(seen, hermite(path, dt, np.asarray(times)).T.tolist(), strict=True))

    def reaction(self, dof: int) -> float:
        """The force that holds a coordinate."""
        residual = self.z.vec.CreateVector()
        self.form.Apply(self.z.vec, residual)
        return float(residual[dof])

    @property
    def dofs(self) -> int:
        """Displacements and rotations: what is left when the moments and forces of each element are eliminated."""
        return sum(self.space.FreeDofs(True)) - sum(self.held)

    @property
    def note(self) -> str:
        return f"{self.steps} steps, {self.iterations} iterations"

    def follow(self, targets: Sequence[float], go: Callable[[float, float], int], first: float, rtol: float = 1e-4) -> Any:
        """Yields at each of the targets; steps grow where iterations are few and are halved where they fail.

        Iterations converge quadratically: what is left after a change of ``rtol`` is less than its square. Between targets
        the change may be larger.
        """
        level, step, last = 0.0, first, self.z.vec.CreateVector()
        for target in targets:
            while level < target:
                last.data = self.z.vec
                reach = target if level + 1.2 * step > target else level + step
                try:
                    count = go(reach, rtol if reach == target else 1e-2)
                except DidNotConverge:
                    self.z.vec.data = last
                    step = 0.5 * (reach - level)
                    if step < 1e-4 * targets[-1]:
                        raise
                    continue
                self.steps += 1
                step *= 1.4 if count <= 4 else 1.0 if count <= 6 else 0.7
                level = reach
            yield target


def hermite(path: Any, dt: float, times: Any) -> Any:
    """Cubic interpolation of positions and velocities ``path[:, 0]``, ``path[:, 1]`` in equal steps."""
    k = np.minimum((times / dt).astype(int), len(path) - 2)
    s = (times / dt - k)[:, None]
    (x0, v0), (x1, v1) = np.moveaxis(path[k], 1, 0), np.moveaxis(path[k + 1], 1, 0)
    return x0 * (1 + 2 * s) * (1 - s) ** 2 + x1 * s**2 * (3 - 2 * s) + dt * (v0 * s * (1 - s) ** 2 - v1 * s**2 * (1 - s))
