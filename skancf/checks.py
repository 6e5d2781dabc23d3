"""What was checked about a result, after it was computed and by other means than those that found it."""

from collections.abc import Iterable
from dataclasses import dataclass

from skancf.showing import short, summary


@dataclass(frozen=True)
class Check:
    """One number that must not be larger than its bound.

    Attributes
    ----------
    name : str
        What was compared, for example "balance of forces".
    value, bound : float
        Relative to what ``name`` compares with; a value that is not a number fails.
    advice : str
        What to do where it fails.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.0, density=7850.0)
    >>> pull = sk.EdgeLoad("right", (0.0, 0.0, 100.0))
    >>> strip = sk.Problem(sk.Rectangle(1.0, 0.1), 0.01, steel, supports=[sk.Clamp("left")], loads=[pull])
    >>> system = strip.on(sk.meshes.uniform(strip.surface, 4, 1), "kirchhoff")
    >>> check = sk.solve(system).checks[0]
    >>> print(check.name, check.passed)
    residual in the energy norm, of that of the strain True
    """

    name: str
    value: float
    bound: float
    advice: str = ""

    __repr__ = short

    @property
    def passed(self) -> bool:
        return bool(self.value <= self.bound)

    @summary
    def __str__(self) -> str:
        word = "holds" if self.passed else "FAILED"
        return f"{self.name}: {self.value:.1e}, at most {self.bound:.1e}: {word}"


def failures(checks: Iterable[Check]) -> str:
    """What failed and what to do, in sentences; nothing where all hold."""
    return " ".join(
        f"Check failed: {c.name} is {c.value:.1e}, at most {c.bound:.1e} is allowed. {c.advice}".strip()
        for c in checks if not c.passed
    )  # fmt: skip
