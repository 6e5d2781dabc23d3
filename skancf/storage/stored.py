"""Results as arrays only: what is kept of a result whose problem cannot be."""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np

from skancf.adaptive import AdaptiveResult
from skancf.checks import Check
from skancf.dynamics import Motion
from skancf.elements.reference import CORNERS
from skancf.equality import by_value
from skancf.errors import InputError
from skancf.solution import Solution
from skancf.solving import Status
from skancf.statics import BucklingResult, Modes, PathResult, StaticResult


class NotKept(InputError, AttributeError):
    """What a result that was kept as arrays cannot answer."""


class _Answers:
    """What is not among its arrays is refused by name."""

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        has = ", ".join(part.name for part in fields(self))  # type: ignore[arg-type]
        raise NotKept(f"{name}: this result was kept as arrays, without its problem, and has {has}; for all else keep the "
                      "whole result, with tables and objects of this library instead of functions")  # fmt: skip


@by_value
@dataclass(frozen=True)
class StoredState(_Answers):
    """The fields of a state, at the nodes of its mesh and at the corners of its elements.

    Attributes
    ----------
    nodes : (2, n) array
        Parameters of the mesh's nodes.
    elements : (4, m) array
        Their numbers at the corners of each element, in the order of scikit-fem.
    undeformed, displacements : (3, n) arrays
        Position and displacement of the nodes (m).
    q : (n_dofs,) array
        Nodal coordinates.
    section_forces : (m, 6, 4) array
        N11, N22, N12 (N/m), M11, M22, M12 (N) at the corners, as :meth:`skancf.Solution.section_forces`.
    stresses_bottom, stresses_top : (m, 4, 6) arrays
        At the faces, as :meth:`skancf.Solution.stresses` (Pa).
    strain_energy, kinetic_energy : float
        (J)
    velocities : (3, n) array or None
        Of the nodes (m/s).
    time : float or None
    load_factor : float
    note : str

    Examples
    --------
    >>> plate = sk.Problem(sk.Rectangle(1.0, 1.0), 0.01, sk.Isotropic(2e11, 0.3, 7800.0), [sk.Clamp("left")], [sk.Gravity()])
    >>> solution = sk.solve_linear(plate.on(sk.meshes.uniform(plate.surface, 2, 2)))
    >>> state = sk.storage.StoredState.of(solution)
    >>> state.displacements.shape, state.stresses_top.shape
    ((3, 9), (4, 4, 6))
    """

    nodes: np.ndarray
    elements: np.ndarray
    undeformed: np.ndarray
    displacements: np.ndarray
    q: np.ndarray
    section_forces: np.ndarray
    stresses_bottom: np.ndarray
    stresses_top: np.ndarray
    strain_energy: float
    kinetic_energy: float = 0.0
    velocities: np.ndarray | None = None
    time: float | None = None
    load_factor: float = 1.0
    note: str = ""

    @property
    def positions(self) -> np.ndarray:
        """Of the nodes, (3, n) (m)."""
        return self.undeformed + self.displacements

    @classmethod
    def of(cls, state: Solution) -> "StoredState":
        """Of a state with its system."""
        system, at_nodes = state.system, state.system.geometry.at_mesh_nodes
        undeformed = at_nodes(system.shell.nodal(system.undeformed))[:, 0].T
        velocities = None if state.velocity is None else at_nodes(system.shell.nodal(state.velocity))[:, 0].T
        return cls(
            system.mesh.p, system.mesh.t, undeformed, state.displacements, state.q,
            state.section_forces(), state.stresses(CORNERS.T, "bottom"), state.stresses(CORNERS.T, "top"),
            state.strain_energy, state.kinetic_energy, velocities, state.time, state.load_factor, state.note,
        )  # fmt: skip


@by_value
@dataclass(frozen=True)
class StoredFields(_Answers):
    """A result as arrays, see :func:`skancf.save` with ``what="arrays"``.

    Attributes
    ----------
    kind : str
        The class of the result.
    states : tuple of StoredState
        Of a path or a motion all that were kept; of modes their shapes.
    tables : dict of name to array
        Frequencies, load factors, the ledger of a motion, records.
    status : Status or None
    message : str
    checks : tuple of Check

    Examples
    --------
    >>> plate = sk.Problem(sk.Rectangle(1.0, 1.0), 0.01, sk.Isotropic(2e11, 0.3, 7800.0), [sk.Clamp("left")])
    >>> modes = sk.modes(plate.on(sk.meshes.uniform(plate.surface, 2, 2), "kirchhoff"), 2)
    >>> kept = sk.load(sk.save(modes, "modes.h5", what="arrays"))
    >>> kept.kind, len(kept.states), np.array_equal(kept.tables["frequencies"], modes.frequencies)
    ('Modes', 2, True)
    """

    kind: str
    states: tuple[StoredState, ...]
    tables: Mapping[str, np.ndarray] = field(default_factory=dict)
    status: Status | None = None
    message: str = ""
    checks: tuple[Check, ...] = ()

    @property
    def state(self) -> StoredState:
        """The last state."""
        return self.states[-1]

    @property
    def ok(self) -> bool:
        """Whether it was what was asked for."""
        return all(check.passed for check in self.checks) if self.status is None else self.status.ok


def fields_of_result(result: Any) -> StoredFields:
    """The arrays of a result."""
    states, tables = _parts(result)
    status, message = getattr(result, "status", None), getattr(result, "message", "")
    kept = tuple(map(StoredState.of, states))
    return StoredFields(type(result).__name__, kept, tables, status, message, getattr(result, "checks", ()))


def _parts(result: Any) -> tuple[Any, dict[str, Any]]:
    """States and tables."""
    if isinstance(result, Solution):
        return [result], {}
    if isinstance(result, StaticResult):
        return result.path or [result.solution], {"load_factors": np.array([state.load_factor for state in result.path])}
    if isinstance(result, PathResult):
        return result.solutions, {"load_factors": result.load_factors, "negative_pivots": result.negative_pivots}
    if isinstance(result, Modes):
        return map(result.shape, range(len(result.shapes))), {"frequencies": result.frequencies,
                                                              "eigenvalues": result.eigenvalues}  # fmt: skip
    if isinstance(result, BucklingResult):
        return map(result.shape, range(len(result.shapes))), {"load_factors": result.load_factors}
    if isinstance(result, Motion):
        records = {f"record {name}": values for name, (_, values) in result.records.items()}
        return result.states, {**result.ledger.table(), "times": result.times, **records}
    if isinstance(result, AdaptiveResult):
        levels = {name: np.array([getattr(level, name) for level in result.levels]) for name in ("n_dofs", "value", "error")}
        return [result.solution], {**levels, "error_bar": np.array([result.error_bar])}
    raise InputError(f"result: a {type(result).__name__} has no fields; give a Solution or the result of an analysis")
