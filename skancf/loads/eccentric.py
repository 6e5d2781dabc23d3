"""Dead forces at a height above the reference surface of theory `kirchhoff`."""

from functools import cached_property

import numpy as np

from skancf.history import Case, History
from skancf.loads.acting import DeadLoad
from skancf.terms.blocks import OnElements
from skancf.terms.protocols import Assembly
from skancf.theories.kirchhoff.point import dot, dual, unit_normal


class DeadLoadOnNormals(DeadLoad):
    r"""A dead force (n_nodes, 4, 3), and one per area times its height above the surface, s (3,), on the normals.

    The work of s per area is :math:`s \cdot n`. With :math:`\delta n = -a^\gamma (n \cdot \delta r_{,\gamma})` the force on
    :math:`r_{,\gamma}` is :math:`-(s \cdot a^\gamma) n`, and

    .. math:: s \cdot \delta^2 n = 2 (s \cdot a^\lambda) (n \cdot \delta r_{,\gamma}) (a^\gamma \cdot
        \delta r_{,\lambda}) - (s \cdot n)\, a^{\gamma\lambda} (n \cdot \delta r_{,\gamma}) (n \cdot \delta
        r_{,\lambda}).
    """

    def __init__(self, assembly: Assembly, nodal: np.ndarray, s: np.ndarray, history: History | None):
        super().__init__(nodal, history)
        self.geometry, self.s, sections = assembly.geometry, s, assembly.sections
        centre = sections.moments[sections.shape][:, 1] / assembly.section.first_moment  # areas, of the surface there
        self.areas = centre * self.geometry.side[:, None]

    @cached_property
    def slopes(self) -> np.ndarray:
        """r_1 and r_2 of the local functions at the integration points, (2, 16, n_points)."""
        return self.geometry.theory.slope_table(self.geometry.theory.quadrature[0])

    def _surface(self, q: np.ndarray, case: Case) -> tuple[np.ndarray, ...]:
        """n, a^1 and a^2; s at a time with the areas, and s . a^1 and s . a^2."""
        jet = np.einsum("gap,eai->giep", self.slopes, self.geometry.local(q), optimize=True)
        duals, s = dual(jet), np.multiply.outer(self.couple(case), self.areas)
        return unit_normal(jet), duals, s, np.stack([dot(s, a) for a in duals])

    def couple(self, case: Case) -> np.ndarray:
        return np.asarray(case.amplitude(self.history) * self.s)

    def force(self, q: np.ndarray, case: Case) -> np.ndarray:
        n, _, _, along = self._surface(q, case)
        on_normals = -np.einsum("gap,gep,iep->eai", self.slopes, along, n, optimize=True)
        return super().force(q, case) + self.geometry.nodal(on_normals, np.arange(self.geometry.n_elements))

    def add_stiffness(self, q: np.ndarray, case: Case, blocks: OnElements) -> None:
        if blocks.skew:
            return
        n, duals, s, along = self._surface(q, case)
        metric = np.einsum("giep,liep->glep", duals, duals)
        # Half of s . delta^2 n is the product of the normal parts with these.
        others = np.einsum("lep,giep,lbp->geibp", along, duals, self.slopes, optimize=True)
        others -= 0.5 * np.einsum("ep,glep,iep,lbp->geibp", dot(s, n), metric, n, self.slopes, optimize=True)
        half = np.einsum("gap,iep,gejbp->eiajb", self.slopes, n, others, optimize=True).reshape(-1, 48, 48)
        blocks.add(np.arange(self.geometry.n_elements), -(half + half.swapaxes(1, 2)))
