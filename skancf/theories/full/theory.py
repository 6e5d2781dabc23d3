r"""Theory `full`: the fully parameterised plate, Green-Lagrange strain of :math:`\mathbf r(x, y) + z\,\mathbf d(x, y)`.

The jet of a point is the five vectors :math:`r_{,1}, r_{,2}, d_{,1}, d_{,2}, d`, derivatives with respect to the
reference square. The covariant strain with respect to :math:`(\xi, \eta, z)` is a polynomial in z, exactly,

.. math::
    E_{ab} = e^0_{ab} + z e^1_{ab} + z^2 e^2_{ab}, \qquad 2 E_{a3} = s^0_a + z s^1_a, \qquad E_{33} = t,

whose 14 coefficients are the strains of this theory. They are quadratic in the jet: ``TERMS`` lists them. The law is
integrated through the thickness once per mesh, so a point costs the same for any number of thickness points.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from skancf.arguments import flag, whole
from skancf.elements.quad_ancf import square_quadrature
from skancf.elements.reference import ancf_functions, of_points
from skancf.kernels.constants import FUNCTIONS
from skancf.materials import Section
from skancf.materials.shear import warn_if_layers_bend_alone
from skancf.showing import short
from skancf.theories.full.nodes import N_POSITION, DirectorNodes
from skancf.theories.full.validity import warn_if_off
from skancf.vectors import cross

R1, R2, D1, D2, D = range(5)
TERMS = np.array([
    (0, R1, R1), (1, R2, R2), (2, R1, R2),                # e0_11, e0_22, 2 e0_12
    (3, R1, D1), (4, R2, D2), (5, R1, D2), (5, R2, D1),   # e1_11, e1_22, 2 e1_12
    (6, D1, D1), (7, D2, D2), (8, D1, D2),                # e2_11, e2_22, 2 e2_12
    (9, R1, D), (10, R2, D),                              # s0_1, s0_2
    (11, D1, D), (12, D2, D),                             # s1_1, s1_2
    (13, D, D),                                           # t
])  # fmt: skip
"""Rows (strain, a, b): the strain has the term jet[a] . jet[b], halved where a = b, less its undeformed value."""
N_STRAINS = 14
N_IN_PLANE = 9
"""The strains from here on, shear and thickness, are the ones that may be assumed."""

# Covariant components (i, j) of each strain, and its power of z.
COMPONENTS = [(0, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1), (0, 1, 1), (0, 0, 2), (1, 1, 2), (0, 1, 2),
              (0, 2, 0), (1, 2, 0), (0, 2, 1), (1, 2, 1), (2, 2, 0)]  # fmt: skip
VOIGT = [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)]

# Sampling points of the assumed strains. Shear along xi uses those with eta on an edge, shear along eta those with xi
# on an edge, the thickness strain the corners.
SAMPLES = np.array([(0, 0), (1, 0), (1, 1), (0, 1), (0.5, 0), (1, 0.5), (0.5, 1), (0, 0.5)]).T
FAMILY = (0, 1, 0, 1, 2)
"""Which interpolation s0_1, s0_2, s1_1, s1_2 and t have: that of shear along xi, shear along eta, thickness."""
FAMILY_SAMPLES = [(0, 1, 2, 3, 4, 6), (0, 1, 2, 3, 5, 7), (0, 1, 2, 3)]


def strain(jet: np.ndarray) -> np.ndarray:
    """The strains before those of the undeformed state are subtracted: (5, 3, ...) to (14, ...)."""
    out = np.zeros((N_STRAINS, *jet.shape[2:]), jet.dtype)
    for k, a, b in TERMS:
        out[k] += (0.5 if a == b else 1.0) * np.einsum("i...,i...->...", jet[a], jet[b])
    return out


@of_points
def jet_table(points: np.ndarray) -> np.ndarray:
    """The 16 local functions' part in the jet at points (2, n): shape (5, 16, n).

    Local functions are the 12 of r (r, r_xi, r_eta corner by corner), then the 4 of d.
    """
    table = np.zeros((5, FUNCTIONS, points.shape[1]))
    value, along_xi, along_eta = (ancf_functions(points[0], points[1], order) for order in [(0, 0), (1, 0), (0, 1)])
    table[R1, :N_POSITION], table[R2, :N_POSITION] = (part[:, :3].reshape(N_POSITION, -1) for part in (along_xi, along_eta))
    table[D1, N_POSITION:], table[D2, N_POSITION:], table[D, N_POSITION:] = along_xi[:, 3], along_eta[:, 3], value[:, 3]
    return table


@of_points
def position_table(points: np.ndarray) -> np.ndarray:
    """Values of the local functions at points (2, n): shape (2, 16, n); first axis r, d."""
    value = ancf_functions(*points)
    table = np.zeros((2, FUNCTIONS, points.shape[1]))
    table[0, :N_POSITION], table[1, N_POSITION:] = value[:, :3].reshape(N_POSITION, -1), value[:, 3]
    return table


@of_points
def interpolation(points: np.ndarray) -> np.ndarray:
    r"""Interpolation of the assumed strains from the sampling points: shape (3 families, 8 samples, n).

    The shear strains along xi are sampled at :math:`\xi = 0, \tfrac12, 1` on the edges :math:`\eta = 0, 1`, and
    interpolated quadratically in xi and linearly in eta; those along eta likewise with the two exchanged. The thickness
    strain is sampled at the corners and interpolated bilinearly.
    """

    def linear(s: np.ndarray, at: float) -> np.ndarray:
        return s if at == 1 else 1 - s

    def quadratic(s: np.ndarray, at: float) -> np.ndarray:
        return 4 * s * (1 - s) if at == 0.5 else (2 * s - 1) * (s if at == 1 else s - 1)

    (xi, eta), table = points, np.zeros((3, SAMPLES.shape[1], points.shape[1]))
    for family, (along_xi, along_eta) in enumerate([(quadratic, linear), (linear, quadratic), (linear, linear)]):
        for s in FAMILY_SAMPLES[family]:
            table[family, s] = along_xi(xi, SAMPLES[0, s]) * along_eta(eta, SAMPLES[1, s])
    return table


@dataclass(frozen=True)
class Full(DirectorNodes):
    """The fully parameterised plate.

    Parameters
    ----------
    assumed : bool
        Assumed transverse shear and thickness strains, which do not lock; False is the plain element of the literature.
    n_thickness : int
        Gauss points through the thickness of each layer; 3 are exact for flat plates.

    Notes
    -----
    4 x 4 Gauss points in the plane are exact for the mass matrix and for all but the highest terms of the energy.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> system = plate.on(sk.meshes.uniform(plate.surface, 4, 4), sk.Full())
    >>> locking = plate.on(sk.meshes.uniform(plate.surface, 4, 4), sk.Full(assumed=False))
    >>> middles = [sk.solve_linear(each).displacement((0.5, 0.5))[2] for each in (system, locking)]
    >>> print(*(f"{1000 * w:.3f} mm" for w in middles))
    -0.063 mm -0.007 mm
    """

    assumed: bool = True
    n_thickness: int = 3

    name = "full"
    order = 2
    shear = True
    softest = 1e-5
    bytes_per_element, bytes_per_shape = 12_500, 330_000

    __repr__ = short

    def __post_init__(self) -> None:
        flag("assumed", self.assumed)
        # Of many points the search for their places takes long, and no section needs them.
        object.__setattr__(self, "n_thickness", whole("n_thickness", self.n_thickness, most=64))

    def warn_of(self, section: Section, reach: float) -> None:
        """Warns where layers are off the surface, and where they bend one by one."""
        warn_if_off(section)
        warn_if_layers_bend_alone(section, reach)

    def position_table(self, points: np.ndarray) -> np.ndarray:
        """Values of the local functions of r and d at points (2, n): (2, 16, n)."""
        return position_table(points)

    def nodal_table(self, points: np.ndarray) -> np.ndarray:
        """r, r_1, r_2 and r_z of the local functions at points (2, n): (4, 16, n)."""
        r, d = position_table(points)
        return np.stack([r, *self.slope_table(points), d])

    def slope_table(self, points: np.ndarray) -> np.ndarray:
        """r_1 and r_2 of the local functions at points (2, n): (2, 16, n)."""
        return jet_table(points)[[R1, R2]]

    def normals(self, local: np.ndarray, points: np.ndarray, side: np.ndarray) -> np.ndarray:
        """The director (n_elements, 3, n)."""
        return np.einsum("ap,eai->eip", position_table(points)[1], local, optimize=True)

    def normal_rates(self, local: np.ndarray, rates: np.ndarray, points: np.ndarray, side: np.ndarray) -> np.ndarray:
        """Rate of the director (n_elements, 3, n)."""
        return self.normals(rates, points, side)

    def bases(self, local: np.ndarray, points: np.ndarray, side: np.ndarray, z: Any) -> np.ndarray:
        """Tangent vectors at a height z, or one for each place, and the director: columns of (n_elements, n, 3, 3)."""
        r1, r2, d1, d2, d = self.jets(local, points)
        return np.moveaxis(np.stack([r1 + z * d1, r2 + z * d2, d]), (0, 1), (-1, -2))

    @cached_property
    def quadrature(self) -> tuple[np.ndarray, np.ndarray]:
        """Integration points (2, 16) of the reference square and their weights."""
        return square_quadrature(4)

    @cached_property
    def samples(self) -> np.ndarray:
        """Points (2, n_samples) where shear and thickness strains are taken."""
        return SAMPLES if self.assumed else self.quadrature[0]

    def sampling(self) -> tuple[np.ndarray, np.ndarray]:
        """How the integration points get their shear and thickness strains.

        Returns
        -------
        interpolation : (5, n_samples, 16) array
            Weight of each sampling point, for s0_1, s0_2, s1_1, s1_2, t. The plain element's is the identity.
        rows : (n_rows, 2) int array
            The strain and the sampling point of each sampled strain.
        """
        if self.assumed:
            tables = interpolation(self.quadrature[0])
            rows = [(k, s) for k, family in enumerate(FAMILY) for s in FAMILY_SAMPLES[family]]
            return np.stack([tables[family] for family in FAMILY]), np.array(rows)
        n = self.samples.shape[1]
        return np.stack([np.eye(n)] * 5), np.array([(k, s) for k in range(5) for s in range(n)])

    def jets(self, local: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Jets (5, 3, n_elements, n) of local vectors (n_elements, 16, 3) at points (2, n)."""
        table = jet_table(points)
        return (np.moveaxis(local, 2, 0).reshape(-1, FUNCTIONS) @ table).reshape(5, 3, len(local), points.shape[1])

    def strains(self, local: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Strains (n_elements, 14, n) at points (2, n), before those of the undeformed state are subtracted."""
        out = np.moveaxis(strain(self.jets(local, points)), 0, 1)
        if self.assumed:
            sampled, tables = strain(self.jets(local, SAMPLES)), interpolation(points)
            for k, family in enumerate(FAMILY, start=N_IN_PLANE):
                out[:, k] = sampled[k] @ tables[family]
        return out

    def strain_forces(self, local: np.ndarray, points: np.ndarray, stresses: np.ndarray) -> np.ndarray:
        """Forces on the local vectors (n_elements, 16, 3) that do the work of stresses (n_elements, 14, n) on
        :meth:`strains`."""
        out = np.zeros_like(local)
        samples, tables = (SAMPLES, interpolation(points)) if self.assumed else (points, [np.eye(points.shape[1])] * 3)
        for at, first, last in ((points, 0, N_IN_PLANE), (samples, N_IN_PLANE, N_STRAINS)):
            jets, on_jets = self.jets(local, at), np.zeros((5, 3, len(local), at.shape[1]))
            for k, a, b in TERMS[(TERMS[:, 0] >= first) & (TERMS[:, 0] < last)]:
                stress = stresses[:, k] if first == 0 else stresses[:, k] @ tables[FAMILY[k - first]].T
                factor = 0.5 if a == b else 1.0
                on_jets[a] += factor * stress * jets[b]
                on_jets[b] += factor * stress * jets[a]
            out += np.einsum("jap,jiep->eai", jet_table(at), on_jets, optimize=True)
        return out


def covariant_to_local(jet: np.ndarray, first: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    r"""From the 14 strains to the strain in the local frame at depth z.

    With :math:`F = [g_1, g_2, g_3]`, :math:`g_a = R_{,a} + z D_{,a}, g_3 = D` in the local frame, and
    :math:`A = F^{-1}`, :math:`E = A^T E_{cov} A`.

    Parameters
    ----------
    jet : (5, 3, ...) array
        Jet of the undeformed state.
    first : (3, ...) array
        Direction 1 of the local frame before it is made orthogonal to the normal.
    z : (n_z,) or (n_z, ...) array
        For all places, or for each of them.

    Returns
    -------
    P : (n_z, 6, 14, ...) array
        Strain in Voigt order 11, 22, 33, 23, 13, 12 per unit of each of the 14 strains.
    volume : (n_z, ...) array
        det F, volume per unit of reference square and depth.
    """
    frame = local_frame(jet, first)
    r1, r2, d1, d2, d = jet
    matrices, volumes = [], []
    for depth in z:
        basis = np.stack([r1 + depth * d1, r2 + depth * d2, d])
        F = np.einsum("ki...,ji...->...kj", frame, basis)
        A = np.linalg.inv(F)
        volumes.append(np.abs(np.linalg.det(F)))
        matrices.append(voigt_rows(A, depth))
    return np.stack(matrices), np.stack(volumes)


def local_frame(jet: np.ndarray, first: np.ndarray) -> np.ndarray:
    """Rows e1, e2, e3, shape (3, 3, ...): e3 the undeformed normal on the side of the director, e1 nearest to first."""
    n = cross(jet[0], jet[1])
    n = n * np.sign((n * jet[D]).sum(axis=0))
    n = n / np.sqrt((n * n).sum(axis=0))
    e1 = first - n * (n * first).sum(axis=0)
    e1 = e1 / np.sqrt((e1 * e1).sum(axis=0))
    return np.stack([e1, cross(n, e1), n])


def voigt_rows(A: np.ndarray, z: float) -> np.ndarray:
    out = np.empty((6, N_STRAINS, *A.shape[:-2]))
    for row, (p, q) in enumerate(VOIGT):
        double = 1.0 if p == q else 2.0
        for k, (i, j, power) in enumerate(COMPONENTS):
            product = (A[..., i, p] * A[..., j, q] + A[..., j, p] * A[..., i, q]) / 2
            out[row, k] = double * z**power * product
    return out


def section_stiffness(jet: np.ndarray, first: np.ndarray, section: Section, n_z: int) -> tuple[np.ndarray, np.ndarray]:
    r"""The law integrated through the thickness, for the 14 strains.

    .. math:: \hat D = \int P(z)^T C P(z) \det F \, dz

    Parameters
    ----------
    jet : (5, 3, ...) array
        Jet of the undeformed state.
    first : (3, ...) array
        Tangent along the parameter x.
    section : Section
        One for all places, or one for each of them.
    n_z : int
        Gauss points through each layer; 3 are exact for a flat plate.

    Returns
    -------
    stiffness : (..., 14, 14) array
        Per unit of reference square.
    moments : (3, ...) array
        Integrals of the density times det F, z det F, z^2 det F over z: what mass and dead loads need.
    """
    stiffness, moments = np.zeros((*jet.shape[2:], N_STRAINS, N_STRAINS)), np.zeros((3, *jet.shape[2:]))
    z, w, laws = section.through(n_z)
    points = (part.reshape(-1, n_z, *part.shape[1:]) for part in (z, w))
    of = "" if section.places is None else "..."
    for law, density, z, w in zip(laws[::n_z], np.moveaxis(section.density, -1, 0), *points, strict=True):
        P, volume = covariant_to_local(jet, first, z)
        stiffness += np.einsum(f"zpk...,{of}pq,zql...,z...,z{of}->...kl", P, law, P, volume, w, optimize=True)
        moments += density * np.stack([np.einsum(f"z...,z{of}->...", volume, w * z**k) for k in range(3)])
    return stiffness, moments
