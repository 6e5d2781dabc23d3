"""The trapezoidal rule."""

from dataclasses import dataclass

from skancf.dynamics.newmark import Newmark


@dataclass(frozen=True)
class Trapezoidal(Newmark):
    r"""The trapezoidal rule (Newmark's with beta = 1/4, gamma = 1/2): a reference, not a choice.

    .. math:: M a_{n+1} + f_{int}(q_{n+1}) = f_{ext}(q_{n+1}, t_{n+1})

    It damps nothing and is stable without limit in linear problems; in large rotations its energy grows and a run blows up.
    With conditions it is refused: their multipliers would alternate from step to step, and grow.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.0, density=7850.0)
    >>> pull = sk.EdgeLoad("right", (0.0, 0.0, 100.0))
    >>> strip = sk.Problem(sk.Rectangle(1.0, 0.1), 0.01, steel, supports=[sk.Clamp("left")], loads=[pull])
    >>> system = strip.on(sk.meshes.uniform(strip.surface, 4, 1), "kirchhoff")
    >>> motion = sk.simulate(system, 0.005, rule=sk.Trapezoidal(), dt=2e-4, progress=False)
    >>> print(motion.status.value, len(motion.steps))
    finished 25
    """

    alpha_m = 0.0
    alpha_f = 0.0
    beta = 0.25
    gamma = 0.5
