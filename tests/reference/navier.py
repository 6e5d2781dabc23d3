r"""Series of simply supported rectangular plates, a by b, hard supports, w > 0 along the load.

Timoshenko and Woinowsky-Krieger, Theory of Plates and Shells (1959), articles 28 and 34 for thin plates; Reddy,
Mechanics of Laminated Composite Plates and Shells (2004), chapter 6, for first-order shear deformation.
"""

import numpy as np


def orders(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Odd pairs (m, n): the even ones have no part in a symmetric load."""
    odd = np.arange(1, n, 2)
    return np.meshgrid(odd, odd, indexing="ij")


def signs(m: np.ndarray, n: np.ndarray) -> np.ndarray:
    """sin(m pi / 2) sin(n pi / 2): the mode at the centre."""
    return np.sin(m * np.pi / 2) * np.sin(n * np.pi / 2)


def kirchhoff_uniform(b: float = 1.0, terms: int = 400) -> float:
    """w_c D / (q a^4)."""
    m, n = orders(terms)
    return float((16 / np.pi**6 * signs(m, n) / (m * n * (m**2 + n**2 / b**2) ** 2)).sum())


def kirchhoff_point(b: float = 1.0, terms: int = 3000) -> float:
    """w_c D / (P a^2), force at the centre. The tail falls like 1 / terms^2."""
    m, n = orders(terms)
    return float((4 / (b * np.pi**4) / (m**2 + n**2 / b**2) ** 2).sum())


def shear_deformable(bending: np.ndarray, shear: tuple[float, float], b: float = 1.0, terms: int = 200) -> float:
    """w_c for a unit uniform load and a = 1: Navier's solution with w, phi_x, phi_y of each mode.

    Parameters
    ----------
    bending : (3, 3) array
        D11, D22, D66 and the coupling D12, orthotropic along x and y: rows and columns 11, 22, 12.
    shear : (A55, A44)
        Corrected transverse shear stiffness of the planes xz and yz.
    """
    m, n = orders(terms)
    alpha, beta = m * np.pi, n * np.pi / b
    d11, d22, d12, d66 = bending[0, 0], bending[1, 1], bending[0, 1], bending[2, 2]
    a55, a44 = shear
    K = np.empty((*m.shape, 3, 3))
    K[..., 0, 0] = a55 * alpha**2 + a44 * beta**2
    K[..., 0, 1] = K[..., 1, 0] = a55 * alpha
    K[..., 0, 2] = K[..., 2, 0] = a44 * beta
    K[..., 1, 1] = d11 * alpha**2 + d66 * beta**2 + a55
    K[..., 2, 2] = d66 * alpha**2 + d22 * beta**2 + a44
    K[..., 1, 2] = K[..., 2, 1] = (d12 + d66) * alpha * beta
    q = np.zeros((*m.shape, 3, 1))
    q[..., 0, 0] = 16 / (np.pi**2 * m * n)
    return float((signs(m, n) * np.linalg.solve(K, q)[..., 0, 0]).sum())


def isotropic(young: float, poisson: float, thickness: float, factor: float = 5 / 6) -> tuple[np.ndarray, tuple]:
    """Bending and shear stiffness for :func:`shear_deformable`."""
    D = young * thickness**3 / 12 / (1 - poisson**2)
    shear = factor * young / (2 * (1 + poisson)) * thickness
    return D * np.array([[1, poisson, 0], [poisson, 1, 0], [0, 0, (1 - poisson) / 2]]), (shear, shear)


def mindlin_uniform(slenderness: float, poisson: float, factor: float = 5 / 6) -> float:
    """w_c D / (q a^4) of a square plate with a / h = slenderness."""
    bending, shear = isotropic(1.0, poisson, 1 / slenderness, factor)
    return shear_deformable(bending, shear) * bending[0, 0]


def thin_orthotropic(bending: np.ndarray, b: float = 1.0, terms: int = 200) -> float:
    """w_c for a unit uniform load and a = 1, without shear (Timoshenko and Woinowsky-Krieger, article 85)."""
    m, n = orders(terms)
    x, y = (m * np.pi) ** 2, (n * np.pi / b) ** 2
    stiffness = bending[0, 0] * x**2 + 2 * (bending[0, 1] + 2 * bending[2, 2]) * x * y + bending[1, 1] * y**2
    return float((16 / np.pi**2 * signs(m, n) / (m * n * stiffness)).sum())


def thin_field(x: np.ndarray, y: np.ndarray, terms: int = 60) -> np.ndarray:
    """w of a square plate, a = D = q = 1, on the grid of x (n,) and y (m,): (n, m)."""
    odd = np.arange(1, terms, 2)
    m, n = orders(terms)
    amplitudes = 16 / np.pi**6 / (m * n * (m**2 + n**2) ** 2)
    return np.sin(np.outer(x, odd) * np.pi) @ amplitudes @ np.sin(np.outer(odd, y) * np.pi)


def thin_uniform(b: float = 1.0, terms: int = 400) -> tuple[float, float]:
    """Half the work of the load over (q^2 a^4 b / D), and M_c / (q a^2) for nu = 0.3."""
    m, n = orders(terms)
    stiffness = (m**2 + n**2 / b**2) ** 2
    energy = (32 / np.pi**8 / (m * n) ** 2 / stiffness).sum()
    moment = (16 / np.pi**4 * signs(m, n) * (m**2 + 0.3 * n**2 / b**2) / (m * n * stiffness)).sum()
    return float(energy), float(moment)


def thin_laminate(abd: np.ndarray, b: float = 1.0, terms: int = 200) -> float:
    """w_c of a cross-ply laminate for a unit uniform load and a = 1, with edges that move along their normal only.

    Navier's solution for classical lamination theory: u = U cos sin, v = V sin cos, w = W sin sin (Jones, Mechanics of
    Composite Materials, 1999, section 5.3; Reddy, Mechanics of Laminated Composite Plates and Shells, 2004, section 6.3).

    Parameters
    ----------
    abd : (6, 6) array
        Entries 16 and 26 are zero.
    """
    m, n = orders(terms)
    alpha, beta, zero = m * np.pi, n * np.pi / b, np.zeros(m.shape)
    # Amplitudes of the strains 11, 22 (times sin sin) and 12 (times cos cos), then of the curvatures, of U, V and W.
    B = np.array([
        [-alpha, zero, zero], [zero, -beta, zero], [beta, alpha, zero],
        [zero, zero, alpha**2], [zero, zero, beta**2], [zero, zero, -2 * alpha * beta],
    ])  # fmt: skip
    K = np.einsum("ikmn,ij,jlmn->mnkl", B, abd, B)
    q = np.zeros((*m.shape, 3, 1))
    q[..., 2, 0] = 16 / (np.pi**2 * m * n)
    return float((signs(m, n) * np.linalg.solve(K, q)[..., 2, 0]).sum())
