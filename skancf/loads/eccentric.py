"""Dead forces at a height above the reference surface of theory `kirchhoff`."""

import numpy as np

from skancf.history import Case, History
from skancf.kernels.constants import LOCAL
from skancf.loads.acting import DeadLoad
from skancf.materials import Section
from skancf.terms.blocks import OnElements
from skancf.terms.protocols import Assembly
from skancf.theories.kirchhoff.point import dot, dual, unit_normal


class DeadLoadOnNormals(DeadLoad):
    r"""A dead force (n_nodes, 4, 3), and one per area times its height above the surface, s, on the normals: weight.

    The work of s per area is :math:`s \cdot n`. With :math:`\delta n = -a^\gamma (n \cdot \delta r_{,\gamma})` the force on
    :math:`r_{,\gamma}` is :math:`-(s \cdot a^\gamma) n`, and

    .. math:: s \cdot \delta^2 n = 2 (s \cdot a^\lambda) (n \cdot \delta r_{,\gamma}) (a^\gamma \cdot
        \delta r_{,\lambda}) - (s \cdot n)\, a^{\gamma\lambda} (n \cdot \delta r_{,\gamma}) (n \cdot \delta
        r_{,\lambda}).
    """

    follows = True

    def __init__(self, assembly: Assembly, nodal: np.ndarray, acceleration: np.ndarray, history: History | None):
        super().__init__(nodal, history)
        self.geometry, self.section, sections = assembly.geometry, assembly.section, assembly.sections
        centre = sections.moments[sections.shape][:, 1]  # areas, of the surface there, times the first moment
        self.s, self.acceleration = acceleration, acceleration
        if isinstance(self.section, Section):
            self.s, centre = self.section.first_moment * acceleration, centre / self.section.first_moment
        self.areas = centre * self.geometry.side[:, None]

    def _surface(self, q: np.ndarray, case: Case) -> tuple[np.ndarray, ...]:
        """n, a^1 and a^2; s at a time with the areas, and s . a^1 and s . a^2."""
        jet = self.geometry.jets(self.geometry.local(q))[:2]
        duals, s = dual(jet), np.multiply.outer(case.amplitude(self.history) * self.s, self.areas)
        return unit_normal(jet), duals, s, np.stack([dot(s, a) for a in duals])

    def couple(self, case: Case, points: np.ndarray, elements: np.ndarray) -> np.ndarray:
        moment = self.section.at(points, elements).first_moment
        return np.asarray(case.amplitude(self.history) * np.multiply.outer(self.acceleration, moment))

    def force(self, q: np.ndarray, case: Case) -> np.ndarray:
        n, _, _, along = self._surface(q, case)

        def on_normals(points: np.ndarray, e: np.ndarray) -> np.ndarray:
            slopes = self.geometry.theory.slope_table(points)
            return -np.einsum("gap,gep,iep->eai", slopes, along[:, e], n[:, e], optimize=True)

        found = self.geometry.integration.gathered(on_normals)
        return super().force(q, case) + self.geometry.nodal(found, np.arange(self.geometry.n_elements))

    def add_stiffness(self, q: np.ndarray, case: Case, blocks: OnElements) -> None:
        if blocks.skew:
            return
        n, duals, s, along = self._surface(q, case)
        metric = np.einsum("giep,liep->glep", duals, duals)
        parts = along, duals, dot(s, n), metric, n

        def half(points: np.ndarray, e: np.ndarray) -> np.ndarray:
            """Half of s . delta^2 n is the product of the normal parts with others."""
            slopes, (l, a, sn, g, m) = self.geometry.theory.slope_table(points), (part[..., e, :] for part in parts)
            others = np.einsum("lep,giep,lbp->geibp", l, a, slopes, optimize=True)
            others -= 0.5 * np.einsum("ep,glep,iep,lbp->geibp", sn, g, m, slopes, optimize=True)
            return np.einsum("gap,iep,gejbp->eiajb", slopes, m, others, optimize=True).reshape(-1, LOCAL, LOCAL)

        found = self.geometry.integration.gathered(half)
        blocks.add(np.arange(self.geometry.n_elements), -(found + found.swapaxes(1, 2)))
