"""Pressure that follows the surface."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from skancf.arguments import plain
from skancf.elements.quad_ancf import square_quadrature
from skancf.equality import by_value
from skancf.errors import number
from skancf.functions import is_function, values_at
from skancf.history import Case, History, check_history
from skancf.kernels.constants import AXES, FUNCTIONS, LOCAL
from skancf.layout.geometry import Geometry
from skancf.loads.acting import Acting
from skancf.loads.pressure_kernel import pressure_stiffness
from skancf.showing import short
from skancf.terms.blocks import OnElements
from skancf.terms.protocols import Assembly

EXACT = 5


@by_value
@dataclass(frozen=True)
class FollowerPressure:
    r"""A pressure (Pa) on the deformed area, along the deformed normal.

    .. math:: f = p \int N \, (r_{,x} \times r_{,y}) \, dx\,dy

    Positive along :math:`X_{,x} \times X_{,y}`: on a closed cylinder or sphere with outward normals it inflates.
    Its tangent is exact. The skew part of it, of a constant pressure, is an integral along the boundary and vanishes where
    that is held,

    .. math:: \tfrac12 p \oint \delta r \cdot (\Delta r \times dr).

    A pressure that varies with the place on the surface moves along with it; it has no potential.

    Parameters
    ----------
    pressure : float or callable
        p (Pa), constant or a function of the parameters (x, y).
    history : callable, optional
        Factor as a function of time.

    Raises
    ------
    InputError
        For a pressure that is not one finite number; on a mesh, for values of a function that are not.

    References
    ----------
    Schweizerhof and Ramm (1984), Computers & Structures 18, 1099-1114.

    Examples
    --------
    >>> rubber = sk.Isotropic(young=1e6, poisson=0.45, density=1100.0)
    >>> tube = sk.CylinderSector(radius=0.5, length=1.5, angle=2 * np.pi, closed=True)
    >>> hose = sk.Problem(tube, 0.01, rubber, [sk.Clamp("left"), sk.Clamp("right")], [sk.FollowerPressure(1000.0)])
    >>> solution = sk.solve(hose.on(sk.meshes.uniform(tube, 8, 12), "kirchhoff")).unwrap()
    >>> print(f"{1000 * solution.displacement((0.75, np.pi / 2))[2]:.1f} mm outwards")
    19.7 mm outwards
    """

    pressure: Any
    history: History | None = None

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        if not is_function(self.pressure):
            number("pressure", self.pressure)
        check_history(self.history)

    def on(self, assembly: Assembly) -> Acting:
        if is_function(self.pressure) or not assembly.geometry.integration.shared:
            return VaryingPressure(assembly, self.pressure, self.history)
        return PressureOnSurface(assembly, self.pressure, self.history)


class PressureOnSurface(Acting):
    """A follower pressure on all elements."""

    def __init__(self, assembly: Assembly, pressure: float, history: History | None):
        self.geometry, self.pressure, self.history = assembly.geometry, pressure, history
        theory, geometry = self.geometry.theory, self.geometry
        # N r_x x r_y is of degree 8; the boundary integral of the skew part is that of exact integrals only.
        points, self.weights = square_quadrature(EXACT)
        self.values, self.slopes = theory.position_table(points)[0], theory.slope_table(points)
        facets = geometry.boundary
        self.edges = geometry.mesh.f2t[0, facets]
        self.edge_points, self.edge_tangents, self.edge_weights = geometry.edge_points(facets, EXACT)

    def _amount(self, case: Case) -> np.ndarray:
        """Pressure of each element along r_1 x r_2, (n_elements,)."""
        return np.asarray(case.amplitude(self.history) * self.pressure * self.geometry.side)

    def force(self, q: np.ndarray, case: Case) -> np.ndarray:
        geometry = self.geometry
        one, two = np.einsum("gap,eai->gpei", self.slopes, geometry.local(q), optimize=True)
        along = np.cross(one, two) * (self._amount(case) * self.weights[:, None])[:, :, None]
        return geometry.nodal(np.einsum("ap,pei->eai", self.values, along, optimize=True), np.arange(geometry.n_elements))

    def add_stiffness(self, q: np.ndarray, case: Case, blocks: OnElements) -> None:
        if blocks.skew:
            self._add_skew(q, case, blocks)
            return
        blocks.run(pressure_stiffness, q, self._amount(case), self.values * self.weights, self.slopes, self.geometry.maps)

    def _add_skew(self, q: np.ndarray, case: Case, blocks: OnElements) -> None:
        if not len(self.edges):
            return
        geometry, matrices = self.geometry, np.zeros((len(self.edges), AXES, FUNCTIONS, AXES, FUNCTIONS))
        vectors, amount = geometry.local(q, self.edges), self._amount(case)[self.edges]
        for k, points in enumerate(self.edge_points):
            N = geometry.theory.position_table(points)[0]
            slopes = geometry.theory.slope_table(points)
            dr = np.einsum("g,gan,ai->in", self.edge_tangents[k], slopes, vectors[k]) * self.edge_weights
            # u . (v x dr) = -u . (dr x v); minus the derivative of the force has the opposite sign.
            cross = 0.5 * amount[k] * np.cross(np.eye(3)[:, :, None], dr[:, None], axis=0)  # (i, j, n) of e_j x dr
            matrices[k] = -np.einsum("an,ijn,bn->iajb", N, cross, N)
        blocks.add(self.edges, matrices.reshape(-1, LOCAL, LOCAL))


class VaryingPressure(Acting):
    r"""A follower pressure on all elements, a function of place.

    The force on a local function is :math:`\int p N (r_1 \times r_2)`, and minus its derivative is taken as it is. Elements
    with integration points of their own take those.
    """

    def __init__(self, assembly: Assembly, pressure: Any, history: History | None):
        self.geometry, self.history = assembly.geometry, history
        integration = self.geometry.integration
        rules = [square_quadrature(EXACT), *zip(integration.points[1:], integration.weights[1:], strict=True)]
        groups = [np.flatnonzero(integration.kinds == kind) for kind in range(len(rules))]
        self.parts = [_Part(self.geometry, e, *rule, pressure) for e, rule in zip(groups, rules, strict=True) if e.size]

    def force(self, q: np.ndarray, case: Case) -> np.ndarray:
        amplitude, local = case.amplitude(self.history), self.geometry.local(q)
        found = [part.forces(local[part.elements], amplitude) for part in self.parts]
        return self.geometry.nodal(np.concatenate(found), np.concatenate([part.elements for part in self.parts]))

    def add_stiffness(self, q: np.ndarray, case: Case, blocks: OnElements) -> None:
        amplitude, local = case.amplitude(self.history), self.geometry.local(q)
        for part in self.parts:
            blocks.add(part.elements, part.matrices(local[part.elements], amplitude))


class _Part:
    """A pressure on elements with the same points."""

    def __init__(self, geometry: Geometry, elements: np.ndarray, points: np.ndarray, weights: np.ndarray, pressure: Any):
        theory, self.elements = geometry.theory, elements
        self.values, self.slopes = theory.position_table(points)[0], theory.slope_table(points)
        along = weights * geometry.side[elements, None]
        self.amounts = values_at("pressure", pressure, geometry.parameters(points, elements)) * along

    def _tangents(self, local: np.ndarray) -> np.ndarray:
        """r_1 and r_2 at the points, (2, n_elements, n_points, 3)."""
        return np.einsum("gap,eai->gepi", self.slopes, local, optimize=True)

    def forces(self, local: np.ndarray, amplitude: float) -> np.ndarray:
        """On the local vectors (n_elements, 16, 3)."""
        along = np.cross(*self._tangents(local)) * (amplitude * self.amounts)[:, :, None]
        return np.einsum("ap,epi->eai", self.values, along)

    def matrices(self, local: np.ndarray, amplitude: float) -> np.ndarray:
        """Minus the derivative of the force, (n_elements, 48, 48), component by component."""
        one, two = self._tangents(local)
        amounts, axes = amplitude * self.amounts, np.eye(AXES)[:, None, None]
        # (j, e, p, i): r_1 x e_j with the slope along 2, and e_j x r_2 with that along 1.
        turned = np.stack([np.cross(axes, two), np.cross(one, axes)]) * amounts[:, :, None]
        full = -np.einsum("ap,gjepi,gbp->eiajb", self.values, turned, self.slopes, optimize=True)
        return full.reshape(-1, LOCAL, LOCAL)
