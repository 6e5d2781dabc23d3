"""What a direct solver offers to :class:`skancf.linear.solver.DirectSolver`."""

from typing import ClassVar, Protocol

import numpy as np

from skancf.linear.pattern import BlockPattern


class Backend(Protocol):
    """Factors of a symmetric matrix with a unit diagonal, up to signs.

    The calls come in the order ``symbolic`` once, then ``factor`` and ``solve`` any number of times.
    """

    name: ClassVar[str]
    """How a user asks for it."""

    advice: ClassVar[str]
    """What to do where it is not available."""

    @classmethod
    def available(cls) -> bool:
        """Can it run on this machine?"""

    @classmethod
    def description(cls) -> str:
        """Its name with all that its last bits depend on."""

    def symbolic(self, pattern: BlockPattern) -> None:
        """Keep all that depends on the pattern alone."""

    @property
    def memory(self) -> int:
        """Bytes that :meth:`factor` and :meth:`solve` will take besides those in use now, known after ``symbolic``."""

    def factor(self, values: np.ndarray, careful: bool = False) -> None:
        """Factor the matrix with these (n_blocks, block, block) values; they stay unchanged until the next call.

        With ``careful`` the pivots are chosen for accuracy, at whatever time it takes.

        Raises
        ------
        SingularMatrix
            When there are no factors.
        """

    def solve(self, b: np.ndarray) -> np.ndarray:
        """A^-1 b with the last factors; (n,) to a new array (n,)."""

    @property
    def negative_pivots(self) -> int:
        """Number of negative eigenvalues, from the signs of the pivots."""

    @property
    def perturbed_pivots(self) -> int:
        """Number of pivots that were too small and have been replaced."""

    def close(self) -> None:
        """Give the memory back; harmless when called twice."""
