"""The trapezoidal rule."""

from dataclasses import dataclass

from skancf.dynamics.newmark import Newmark


@dataclass(frozen=True)
class Trapezoidal(Newmark):
    r"""The trapezoidal rule (Newmark's with beta = 1/4, gamma = 1/2): a reference, not a choice.

    .. math:: M a_{n+1} + f_{int}(q_{n+1}) = f_{ext}(q_{n+1}, t_{n+1})

    It damps nothing and is stable without limit in linear problems; in large rotations its energy grows and a run blows up.
    With conditions it is refused: their multipliers would alternate from step to step, and grow.
    """

    alpha_m = 0.0
    alpha_f = 0.0
    beta = 0.25
    gamma = 0.5
