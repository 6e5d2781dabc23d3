r"""Exact elasticity of layered strips in cylindrical bending under :math:`q \sin(\pi x / a)` on the top face.

N. J. Pagano, Exact solutions for composite laminates in cylindrical bending, J. Compos. Mater. 3 (1969) 398-411: plane
strain, ends that carry no axial stress and do not sink. The amplitudes of :math:`u, w, \sigma_{zz}, \tau_{xz}` in a layer
follow a linear system, whose exponential carries them from face to face.
"""

import numpy as np
from scipy.linalg import expm


def layer_system(law: np.ndarray, p: float) -> np.ndarray:
    """d/dz of (u, w, s_zz, t_xz) in a layer with a law (6, 6), orthotropic along x: (4, 4)."""
    c11, c13, c33, g = law[0, 0], law[0, 2], law[2, 2], law[4, 4]
    return np.array([
        [0, -p, 0, 1 / g],
        [c13 * p / c33, 0, 1 / c33, 0],
        [0, 0, 0, p],
        [p * p * (c11 - c13**2 / c33), 0, -p * c13 / c33, 0],
    ])  # fmt: skip


def deflection(laws: list[np.ndarray], thicknesses: list[float], a: float, n: int = 64) -> tuple[float, np.ndarray]:
    """w in the middle of the section for q = 1, and the shear stress at n heights of each layer over the shear force."""
    p, whole, half = np.pi / a, np.eye(4), sum(thicknesses) / 2
    for law, t in zip(laws, thicknesses, strict=True):
        whole = expm(layer_system(law, p) * t) @ whole
    state = np.zeros(4)
    state[:2] = np.linalg.solve(whole[2:, :2], [1.0, 0.0])
    shear, below, middle = [], 0.0, np.nan
    for law, t in zip(laws, thicknesses, strict=True):
        system = layer_system(law, p)
        if below <= half <= below + t:
            middle = (expm(system * (half - below)) @ state)[1]
        shear.append([(expm(system * s) @ state)[3] for s in (np.arange(n) + 0.5) * t / n])
        state, below = expm(system * t) @ state, below + t
    stress = np.array(shear)
    return middle, stress / (stress.mean(axis=1) @ thicknesses)
