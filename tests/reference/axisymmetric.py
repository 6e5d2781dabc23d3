r"""Thin rings under a uniform load q with D = 1: :math:`w = c_1 + c_2 r^2 + c_3 \ln r + c_4 r^2 \ln r + q r^4 / 64`.

Timoshenko and Woinowsky-Krieger, Theory of Plates and Shells (1959), articles 15 to 17.
"""

from collections.abc import Callable

import numpy as np


def derivatives(r: float, load: float) -> np.ndarray:
    """w and three derivatives: rows; columns: the four solutions without load, then that of the load."""
    log = np.log(r)
    return np.array([
        [1, r**2, log, r**2 * log, load * r**4 / 64],
        [0, 2 * r, 1 / r, 2 * r * log + r, load * r**3 / 16],
        [0, 2, -1 / r**2, 2 * log + 3, 3 * load * r**2 / 16],
        [0, 0, 2 / r**3, 2 / r, 6 * load * r / 16],
    ])  # fmt: skip


def conditions(edge: str, r: float, load: float, poisson: float) -> np.ndarray:
    """Two rows that vanish at an edge: "clamped", "simple" or "free"."""
    w, slope, second, third = derivatives(r, load)
    moment, shear = second + poisson * slope / r, third + second / r - slope / r**2
    return np.array({"clamped": [w, slope], "simple": [w, moment], "free": [moment, shear]}[edge])


def ring(radii: tuple[float, float], edges: tuple[str, str], load: float = 1.0, poisson: float = 0.3) -> Callable:
    """Deflection as a function of the radius."""
    rows = np.vstack([conditions(edge, r, load, poisson) for r, edge in zip(radii, edges, strict=True)])
    c = np.append(np.linalg.solve(rows[:, :4], -rows[:, 4]), 1.0)
    return lambda r: derivatives(r, load)[0] @ c


def disc_centre(edge: str, load: str, poisson: float = 0.3) -> float:
    """w D at the centre of a disc of radius 1, clamped or simply supported, under q = 1 or a centre force P = 1."""
    soft = {"clamped": (1.0, 1.0), "simple": ((5 + poisson) / (1 + poisson), (3 + poisson) / (1 + poisson))}[edge]
    return soft[0] / 64 if load == "uniform" else soft[1] / (16 * np.pi)
