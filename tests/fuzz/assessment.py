"""What oracles share: what a refusal may be, what rounding may do, and how a failure is told."""

import re
import warnings
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from hypothesis import reject

import skancf as sk
from skancf.linear import DirectSolver

REFUSALS = re.compile("|".join([
    "supports leave free",  # a rigid motion
    "kind=.hard.",  # a hard roller in the surface
    "hangs in the middle of a larger element's edge",
    r"Symmetry\(",  # an edge in no plane, or crossed askew
    "prescribe different values for the same coordinate",
    "outside the surface",  # a load in an opening
    "no node of the mesh is there",  # a support in one
    "reaches over the edge of the surface",
    "a disk cannot cover one",  # a pole
    "the surface folds at element",
    "this surface has none",  # corners of a slit, for one
]))  # fmt: skip
"""Statements that the strategies make and that are wrong, by their messages. Any other refusal is a finding."""

seen: Counter[str] = Counter()
"""How often what happened, for the reader of a long run."""

EPS = float(np.finfo(float).eps)


@contextmanager
def stated() -> Iterator[None]:
    """Where problems are stated and solved: known refusals end the example, warnings about the theory's depth are silent."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", sk.OutOfDepth)
        try:
            yield
        except sk.InputError as refusal:
            if not REFUSALS.search(str(refusal)):
                raise
            seen["refused"] += 1
            reject()
        except sk.DidNotConverge as lost:
            # Honest: a small-deflection answer that lost its digits.
            if "lost digits" not in str(lost):
                raise
            seen["lost digits"] += 1
            reject()
        except sk.SingularMatrix:
            # Honest: some supports leave a mechanism, and films are singular to rounding.
            seen["singular"] += 1
            reject()


def solved(case: Any, numbering: int | None = None) -> sk.Solution:
    """The small-deflection answer."""
    with stated():
        return sk.solve_linear(case.system(numbering))


def bounded(what: str, value: float, bound: float) -> None:
    """AssertionError with both numbers unless value <= bound."""
    assert value <= bound, f"{what}: {value:.3g}, at most {bound:.3g}"


def change_of(solution: sk.Solution) -> np.ndarray:
    """Small change of the nodal coordinates, (n_dofs,)."""
    return solution.change


def stored(solution: sk.Solution) -> np.ndarray:
    """A displacement is the difference of two places, each known to eps of the coordinates X: so much of it is unknown."""
    places = np.abs(nodal(solution.system.undeformed))
    return 2 * EPS * np.broadcast_to(places.max(axis=(0, 2))[None, :, None], places.shape).ravel()


def nothing(solution: sk.Solution) -> float:
    """Energy of rounded coordinates, which is what is left under loads that do no work."""
    lost = stored(solution)
    return float(lost @ (abs(solution.system.stiffness().to_scipy()) @ lost))


def rounding(solution: sk.Solution) -> float:
    r"""What rounding of the stiffness and of stored coordinates does to the energy :math:`u \cdot K u`, relatively.

    Each term is rounded to some hundred eps, as it is a sum itself; where membrane terms cancel, as in a thin shell that
    bends, their sum is (L/h)^2 times smaller. A part :math:`\delta` of u that is lost costs :math:`\delta \cdot K u` and
    :math:`\delta \cdot K \delta`.
    """
    change, lost = change_of(solution), stored(solution)
    matrix = solution.system.stiffness().to_scipy()
    force, sizes_of = matrix @ change, abs(matrix)
    energy = abs(float(change @ force))
    terms = 300 * EPS * float(np.abs(change) @ (sizes_of @ np.abs(change)))
    terms += float(lost @ np.abs(force)) + float(lost @ (sizes_of @ lost))
    return terms / energy if energy else 0.0


def unsure(solution: sk.Solution) -> float:
    """How far rounding of K u, by eps of its terms with signs by chance, moves nodes: a measured condition (m)."""
    system, change = solution.system, change_of(solution)
    terms = EPS * (abs(system.stiffness().to_scipy()) @ np.abs(change))
    rng = np.random.default_rng(0)
    with DirectSolver(system.pattern, system.constraints) as solver:
        solver.factor(system.stiffness())
        moved = [solver.solve(terms * rng.choice([-1.0, 1.0], terms.size)) for _ in range(3)]
    # Each entry of K is a sum of about a hundred terms itself.
    return 100 * float(np.abs(nodal(np.concatenate(moved))[:, 0]).max())


def nodal(vector: np.ndarray) -> np.ndarray:
    return vector.reshape(-1, 4, 3)


def sizes(vectors: np.ndarray) -> float:
    """Sum of the lengths of forces (n, 3)."""
    return float(np.linalg.norm(vectors, axis=1).sum())
