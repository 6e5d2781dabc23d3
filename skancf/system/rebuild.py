"""Systems as values: compared, and built again from what they were built of for copies, other processes and files."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import skfem
from skfem.generic_utils import OrientedBoundary

from skancf.equality import same, same_mesh


class Rebuilt:
    """What is equal where its problem, mesh and theory are, and is copied by building it again.

    Neither factors nor compiled code are copied. ``rebuilt`` takes what :meth:`__reduce__` gives.
    """

    choice: Any = None
    rebuilt: Callable[..., Any]
    problem: Any
    mesh: Any
    geometry: Any
    terms: Any
    undeformed: np.ndarray

    def __eq__(self, other: object) -> bool:
        if self is other or not isinstance(other, Rebuilt):
            return self is other
        theories = self.geometry.theory, other.geometry.theory
        return same(*theories) and same_mesh(self.mesh, other.mesh) and same(self.problem, other.problem)

    def __hash__(self) -> int:
        return hash((self.undeformed.size, self.undeformed[:12].tobytes()))

    def __reduce__(self) -> Any:
        parts = self.problem, Bare.of(self.mesh), self.geometry.theory, self.terms.state(), self.choice
        return self.rebuilt, parts


class Bare:
    """A plain mesh without what scikit-fem has computed of it, parts of which cannot be pickled."""

    def __init__(self, p: np.ndarray, t: np.ndarray, boundaries: Mapping[str, Any], subdomains: Mapping[str, Any]) -> None:
        self.p, self.t, self.boundaries, self.subdomains = p, t, dict(boundaries), dict(subdomains)

    @classmethod
    def of(cls, mesh: skfem.MeshQuad) -> Any:
        """The mesh itself where it is one of this library, which pickles as it is."""
        if type(mesh) is not skfem.MeshQuad:
            return mesh
        sides = (mesh.boundaries or {}).items()
        named = {name: (np.asarray(facets), getattr(facets, "ori", None)) for name, facets in sides}
        return cls(mesh.p, mesh.t, named, mesh.subdomains or {})

    def made(self) -> skfem.MeshQuad:
        """The mesh."""
        boundaries = {name: facets if ori is None else OrientedBoundary(facets, ori)
                      for name, (facets, ori) in self.boundaries.items()}  # fmt: skip
        return skfem.MeshQuad(self.p, self.t, _boundaries=boundaries or None, _subdomains=self.subdomains or None)
