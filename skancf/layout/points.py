"""Integration points of elements: the Gauss points that all share, or 16 of an element's own."""

from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any

import numpy as np

from skancf.errors import InputError, finite
from skancf.kernels.constants import POINTS

Own = Mapping[int, tuple[Any, Any]]
"""Points (2, 16) of the reference square and weights (16,) of some elements, by their number."""


class IntegrationPoints:
    """Points and weights of all elements, by kinds; the first one are the Gauss points that the others share.

    Parameters
    ----------
    n_elements : int
    gauss : tuple of (2, 16) and (16,) arrays
        Points of the reference square and their weights.
    own : mapping, optional
        Elements that have points of their own, such as those that an outline cuts.

    Attributes
    ----------
    kinds : (n_elements,) int array
    points : (n_kinds, 2, 16) array
    weights : (n_kinds, 16) array

    Raises
    ------
    InputError
        For an element that does not exist, and for points or weights that are not 16, outside of the element or negative.
    """

    def __init__(self, n_elements: int, gauss: tuple[np.ndarray, np.ndarray], own: Own | None = None):
        known: dict[bytes, int] = {}
        rules = [gauss]
        self.kinds = np.zeros(n_elements, dtype=np.int64)
        for element, (points, weights) in sorted((own or {}).items()):
            rule = _checked(element, n_elements, points, weights)
            kind = known.setdefault(b"".join(part.tobytes() for part in rule), len(rules))
            if kind == len(rules):
                rules.append(rule)
            self.kinds[element] = kind
        self.points, self.weights = (np.stack(parts) for parts in zip(*rules, strict=True))

    @property
    def shared(self) -> bool:
        """Have all elements the Gauss points?"""
        return len(self.points) == 1

    @cached_property
    def local(self) -> np.ndarray:
        """Local points (2, 16) of all elements, or those of each, (n_elements, 2, 16)."""
        return self.of(self.kinds)

    def of(self, kinds: np.ndarray) -> np.ndarray:
        """Local points of elements of these kinds (m,), as :attr:`local`."""
        return np.asarray(self.points[0] if self.shared else self.points[kinds])

    def gathered(
        self, function: Callable[[np.ndarray, np.ndarray], np.ndarray], kinds: np.ndarray | None = None, axis: int = 0
    ) -> np.ndarray:
        """Values of a function of local points (2, 16) and of the elements (m,) that have them, along an axis of its own.

        ``kinds`` (n,) are those of other things than the elements, such as classes of them.
        """
        kinds = self.kinds if kinds is None else kinds
        if self.shared:
            return function(self.points[0], np.arange(len(kinds)))
        groups = [np.flatnonzero(kinds == kind) for kind in range(len(self.points))]
        parts = [function(points, group) for points, group in zip(self.points, groups, strict=True) if group.size]
        return np.take(np.concatenate(parts, axis=axis), np.argsort(np.concatenate(groups), kind="stable"), axis=axis)


def _checked(element: int, n_elements: int, points: Any, weights: Any) -> tuple[np.ndarray, np.ndarray]:
    name = f"points of element {element}"
    if not 0 <= element < n_elements:
        raise InputError(f"{name}: the mesh has elements 0 to {n_elements - 1}")
    at, shares = finite(name, points), finite(f"weights of {name}", weights)
    if at.shape != (2, POINTS) or shares.shape != (POINTS,):
        raise InputError(f"{name}: of shapes {at.shape} and {shares.shape}; give {POINTS} points of the reference square, "
                         f"(2, {POINTS}), and as many weights; a point with a weight of zero fills up")  # fmt: skip
    if (np.abs(at - 0.5) > 0.5).any() or (shares < 0).any() or not shares.any():
        raise InputError(f"{name}: give points of the reference square, from 0 to 1, and weights that are not negative")
    return at, shares
