"""Corrections of earlier iterations, put to use: Anderson's acceleration."""

import numpy as np

from skancf.tolerances import ROUNDED_PRODUCT

WINDOW = 6


class Anderson:
    r"""Improves corrections :math:`g = -K^{-1} R` with those before, as long as the factors of K stay.

    The last differences :math:`\Delta g` are combined so that :math:`g - \Delta g\,\gamma` is smallest in the norm of K,
    whose products are those of corrections and residuals; the step is :math:`g - (\Delta u + \Delta g) \gamma`. For linear
    equations it is GMRES preconditioned with K, so that a tangent of an earlier step, or without its skew part, does.

    References
    ----------
    D. G. Anderson, Iterative procedures for nonlinear integral equations, J. ACM 12 (1965) 547-560; H. F. Walker and P. Ni,
    Anderson acceleration for fixed-point iterations, SIAM J. Numer. Anal. 49 (2011) 1715-1735.
    """

    def __init__(self) -> None:
        self.restart()

    def restart(self) -> None:
        """Forget what belongs to other factors."""
        self.steps: list[np.ndarray] = []
        self.corrections: list[np.ndarray] = []
        self.residuals: list[np.ndarray] = []
        self.last: tuple[np.ndarray, np.ndarray] | None = None

    def step(self, correction: np.ndarray, residual: np.ndarray) -> np.ndarray:
        """The step to take from where ``correction`` was computed."""
        if self.last is not None:
            self.corrections.append(correction - self.last[0])
            self.residuals.append(residual - self.last[1])
        self.last = correction, residual
        del self.steps[:-WINDOW], self.corrections[:-WINDOW], self.residuals[:-WINDOW]
        taken = correction
        if self.corrections:
            products = -np.array([[g @ r for r in self.residuals] for g in self.corrections])
            sides = -np.array([g @ residual for g in self.corrections])
            sizes, vectors = np.linalg.eigh(0.5 * (products + products.T))
            use = sizes > ROUNDED_PRODUCT * sizes[-1]
            factors = vectors[:, use] @ ((vectors[:, use].T @ sides) / sizes[use])
            for factor, step, change in zip(factors, self.steps, self.corrections, strict=True):
                taken = taken - factor * (step + change)
        self.steps.append(taken)
        return taken
