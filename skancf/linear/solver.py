"""The one interface to direct solvers: constraints, scaling, factors, refinement."""

import numpy as np

from skancf import memory
from skancf.errors import InputError, SingularMatrix, SkancfError, shown, warn
from skancf.linear.backend import Backend
from skancf.linear.constraints import Constraints
from skancf.linear.matrix import BlockMatrix
from skancf.linear.pardiso import Pardiso
from skancf.linear.pattern import BlockPattern
from skancf.linear.rslab import Rslab
from skancf.linear.scaling import ScaledSystem
from skancf.linear.superlu import SuperLU
from skancf.tolerances import LEFT_BY_REFINEMENT, REFINED, REGULAR_MATRIX, RIGID, SINGULAR_MATRIX

# Fastest first: "auto" takes the first that is available.
BACKENDS: tuple[type[Backend], ...] = (Pardiso, Rslab, SuperLU)

# Makes a singular matrix regular, and leaves its free motions the softest ones by far.
NEARBY = 1e-9
ADVICE = "look for a part without support, a free rigid motion, or a mechanism"
# A first correction of this relative size means that the factors hardly have a digit right.
POOR = 1e-3
MOST = 12


def available_backends() -> tuple[str, ...]:
    """Names of the solvers that run on this machine, fastest first.

    Examples
    --------
    >>> print("superlu" in sk.linear.available_backends())
    True
    """
    return tuple(backend.name for backend in BACKENDS if backend.available())


class DirectSolver:
    """Factors of symmetric matrices with one pattern and one set of constraints.

    Parameters
    ----------
    pattern : BlockPattern
    constraints : Constraints
    backend : str
        ``"mkl"``, ``"rslab"``, ``"superlu"``, or ``"auto"`` for the fastest that is available.

    Raises
    ------
    InputError
        For a solver that does not exist or is not available.
    NotEnoughMemory
        Before any is taken.

    Attributes
    ----------
    constraints : Constraints
    lost : float
        What is left of the last answer, relatively, where refinement came to an end without digits; zero elsewhere.

    Notes
    -----
    Order and layout of the factors are found once, here; :meth:`factor` only computes numbers.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> system = plate.on(sk.meshes.uniform(plate.surface, 6, 6), "kirchhoff")
    >>> with sk.linear.DirectSolver(system.pattern, system.constraints) as solver:
    ...     solver.factor(system.tangent(system.undeformed))
    ...     change = solver.solve(system.external_force(system.undeformed, sk.Case()))
    >>> print(f"{1000 * change.reshape(-1, 12)[:, 2].min():.4f} mm")
    -0.0658 mm
    """

    def __init__(self, pattern: BlockPattern, constraints: Constraints, backend: str = "auto") -> None:
        self._backend = _choose(backend)()
        self.constraints = constraints
        self._system = ScaledSystem(pattern, constraints)
        self._backend.symbolic(pattern)
        memory.require(self.memory, f"{pattern.shape[0]} unknowns", f"a matrix and its factors by {self._backend.name}")
        self._probe = np.random.default_rng(0).standard_normal(self._system.scale.size)
        self._factored = self._closed = False
        self.lost = 0.0

    @property
    def backend_name(self) -> str:
        """Name of the solver in use."""
        return self._backend.name

    @property
    def description(self) -> str:
        """Its name with all that its last bits depend on."""
        return self._backend.description()

    @property
    def memory(self) -> int:
        """Bytes that the first factorisation will take: factors, the scaled matrix, and the one to be assembled."""
        return self._backend.memory + 2 * self._system.values.nbytes

    @property
    def negative_pivots(self) -> int:
        """Number of negative eigenvalues of the matrix, restricted to the coordinates that are not prescribed."""
        self._require_factors()
        return self._backend.negative_pivots

    @property
    def perturbed_pivots(self) -> int:
        """Number of pivots that the solver had to replace; refinement makes up for them."""
        self._require_factors()
        return self._backend.perturbed_pivots

    def factor(self, matrix: BlockMatrix) -> None:
        """Compute the factors of ``matrix``.

        Raises
        ------
        SingularMatrix
            When it is singular. The message names the node and the coordinate that move freely.
        """
        if self._closed:
            raise SkancfError("the solver is closed: make a new one")
        self._factored = self._careful = False
        self._system.update(matrix)
        try:
            self._backend.factor(self._system.values)
        except SingularMatrix as none:
            raise SingularMatrix(self._nearby_motion()) from none
        self._check_regular()
        self._factored = True

    def solve(self, rhs: np.ndarray, refinements: int = 1) -> np.ndarray:
        """Solve A x = rhs on the free coordinates.

        Parameters
        ----------
        rhs : (n_nodes * block,) array
            In ordinary coordinates; its prescribed part is ignored.
        refinements : int
            Steps of iterative refinement with a matrix of entries. One with a :class:`~skancf.linear.matrix.Form` has digits
            that its factors have not: then the answer is refined until no digit changes.

        Returns
        -------
        (n_nodes * block,) array
            In ordinary coordinates; its prescribed part is zero.
        """
        self._require_factors()
        if np.shape(rhs) != (self._system.scale.size,):
            raise InputError(f"right-hand side of shape {np.shape(rhs)}: give ({self._system.scale.size},)")
        b = self._system.restrict(rhs)
        x = self._backend.solve(b)
        last, self.lost = 1.0, 0.0
        for _ in range(MOST if self._system.form else refinements):
            correction = self._backend.solve(b - self._system.multiply(x))
            size = _size(correction) / (_size(x) or 1.0)
            if not self._careful and not size <= POOR:
                self._factor_carefully()
                return self.solve(rhs, refinements)
            if self._system.form and not size < 0.5 * last:
                self.lost = size
                break
            x += correction
            if self._system.form and size * size < REFINED * last:
                break
            last = size
        return self._system.expand(x)

    def warn_if_lost(self) -> None:
        """A warning where corrections of the last answer did not shrink: factors have lost all digits of a part of it."""
        if self.lost > LEFT_BY_REFINEMENT:
            warn(
                f"a linear solve has lost digits: corrections of its answer stay at {self.lost:.1g} of it, for the factors "
                "of the stiffness are rounding along some motion. Look for elements that are many thousand times as long "
                "as wide, and for a thickness below a millionth of the size; theory 'kirchhoff' bears more than 'full'"
            )

    def close(self) -> None:
        """Give the memory of the factors back; the solver cannot be used again."""
        self._factored, self._closed = False, True
        self._backend.close()

    def __enter__(self) -> "DirectSolver":
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def _require_factors(self) -> None:
        if not self._factored:
            raise SkancfError("no factors: call factor(matrix) first, and look at the error it raised if it did")

    def _factor_carefully(self) -> None:
        self._careful = True
        self._backend.factor(self._system.values, careful=True)

    def _check_regular(self) -> None:
        """Raise if inverse iteration finds a motion that the matrix does not resist.

        A pivot that should be zero is often mere rounding, for which neither solver reports anything.
        """
        x = self._backend.solve(self._probe)
        if _size(x) * REGULAR_MATRIX < _size(self._probe):
            return
        form = self._system.form
        for _ in range(3):
            x /= np.abs(x).max()
            force, sizes = self._system.multiply(x), self._system.multiply_sizes(x)
            resists = (abs(form.energy(self._system.expand(x))) > RIGID * float(np.abs(x) @ sizes) if form
                       else _size(force) > SINGULAR_MATRIX * _size(sizes))  # fmt: skip
            if not resists:
                raise SingularMatrix(self._describe(x))
            # Removes what replaced pivots add: they change the factors, not the product.
            x -= self._backend.solve(force)

    def _nearby_motion(self) -> str:
        """What moves freely in a matrix without factors: the softest motion once its diagonal is a little stiffer."""
        self._system.values[self._system.pattern.diagonal_slots] += NEARBY * np.eye(self._system.pattern.block)
        try:
            self._backend.factor(self._system.values)
            return self._describe(self._backend.solve(self._probe))
        except SingularMatrix:
            return f"the matrix is singular: {ADVICE}"

    def _describe(self, x: np.ndarray) -> str:
        if not np.isfinite(x).all():
            return f"the matrix is singular: {ADVICE}"
        node, coordinate = divmod(int(np.argmax(np.abs(x))), self._system.pattern.block)
        place = ", ".join(f"{x:.4g}" for x in self._system.pattern.coordinates[:, node])
        return f"the matrix is singular, node {node} at ({place}) moves freely, most in coordinate {coordinate}: {ADVICE}"


def _size(v: np.ndarray) -> float:
    """Euclidean norm. Without BLAS, of which the waiting threads slow the next call of the solver down by a third."""
    with np.errstate(over="ignore", invalid="ignore"):
        return float(np.sqrt((v * v).sum()))


def check_backend(name: str) -> None:
    """InputError for a solver that does not exist or is not available."""
    _choose(name)


def _choose(name: str) -> type[Backend]:
    if isinstance(name, str) and name == "auto":
        return next(backend for backend in BACKENDS if backend.available())
    known = {backend.name: backend for backend in BACKENDS}
    if not isinstance(name, str) or name not in known:
        raise InputError(f"backend = {shown(name)}: choose 'auto' or one of {sorted(known)}")
    if not known[name].available():
        raise InputError(f"backend = {name!r} is not available: {known[name].advice}, or choose 'auto'")
    return known[name]
