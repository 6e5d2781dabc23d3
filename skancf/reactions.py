"""Forces and moments of supports in a state of rest."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from skancf.errors import InputError, vector
from skancf.layout.constrain import shares_of_supports
from skancf.showing import short
from skancf.tabular import Column, Tabular
from skancf.terms.springs import Springs
from skancf.vectors import cross, sum_of_cross

MOVES = "reactions: this state moves, and its supports also carry inertia; reactions are for statics"


@dataclass(frozen=True, eq=False)
class SupportReactions(Tabular):
    """Forces and moments on the structure by support; a table, see :class:`~skancf.tabular.Tabular`.

    Attributes
    ----------
    names : tuple of str
        The kind of each support and its place, in the order of the problem; then conditions, and terms of the user's own.
    forces : (n, 3) array
        On the structure (N).
    moments : (n, 3) array
        About the points (N m).
    points : (n, 3) array
        Points in space that the moments are about (m).
    """

    names: tuple[str, ...]
    forces: np.ndarray
    moments: np.ndarray
    points: np.ndarray

    __repr__ = short

    @property
    def total_force(self) -> np.ndarray:
        """Sum of the forces (N), (3,); it is minus that of the loads."""
        return np.asarray(self.forces.sum(axis=0))

    @property
    def total_moment(self) -> np.ndarray:
        """Sum of the moments about the origin (N m), (3,); it is minus that of the loads."""
        return np.asarray(self.moments.sum(axis=0) + sum_of_cross(self.points, self.forces))

    def __getitem__(self, name: str) -> tuple[np.ndarray, np.ndarray]:
        """Force and moment of a support by its name."""
        if name not in self.names:
            raise InputError(f"name = {name!r}: no such support; there are {', '.join(map(repr, self.names))}")
        k = self.names.index(name)
        return self.forces[k], self.moments[k]

    def _table(self) -> dict[str, Column]:
        table: dict[str, Column] = {"support": (self.names, "")}
        for letter, unit, values in (("F", "N", self.forces), ("M", "N m", self.moments), ("", "m", self.points)):
            axes = "xyz" if letter else "XYZ"
            table |= {f"{letter}{axis}": (column, unit) for axis, column in zip(axes, values.T, strict=True)}
        return table


class Reactions:
    """What a state of rest says of its supports; a base of :class:`~skancf.Solution`."""

    system: Any
    velocity: Any
    model: Any
    unknowns: Any
    case: Any
    multipliers: Any
    about: Any

    def reactions(self, where: Any = None) -> np.ndarray:
        """Sum of the support forces (3,) (N) in a state of rest, at a place or everywhere, those of springs included.

        Raises
        ------
        InputError
            For a state that moves: its supports also carry inertia.
        """
        support, system = self._supporting(), self.system
        if where is None:
            return np.asarray(system.layout.positions(support).sum(axis=0))
        return np.asarray(system.shell.nodal(support)[system.geometry.nodes_on(where), 0].sum(axis=0))

    def reaction_moment(self, where: Any = None, about: Any = None) -> np.ndarray:
        """Moment of the support forces about a point of space (3,) (N m), at a place or everywhere.

        It is that of the forces at the nodes and of the moments that held slopes and directors take, in the deformed state;
        of a small-deflection answer in the undeformed one.

        Parameters
        ----------
        where
            Place, as for supports. Default: everywhere.
        about : (3,) numbers, optional
            Point of space (m). Default: the centre of the nodes at the place.

        Raises
        ------
        InputError
            For a state that moves.

        Examples
        --------
        >>> beam = sk.Problem(sk.Rectangle(2.0, 0.1), 0.01, sk.Isotropic(2e11, 0.0, 7800), [sk.Clamp("left")],
        ...                   [sk.EdgeLoad("right", (0, 0, 50.0))])
        >>> solution = sk.solve_linear(beam.on(sk.meshes.uniform(beam.surface, 4, 1)))
        >>> np.round(solution.reactions("left"), 6) + 0.0, np.round(solution.reaction_moment("left"), 6) + 0.0
        (array([ 0.,  0., -5.]), array([ 0., 10.,  0.]))
        """
        geometry, support = self.system.geometry, self.system.shell.nodal(self._supporting())
        nodes = np.arange(geometry.n_nodes) if where is None else geometry.nodes_on(where)
        places = self.system.shell.nodal(self.about)
        centre = places[nodes, 0].mean(axis=0) if about is None else vector("about", about, 3)
        return _moment(places[nodes], support[nodes], centre)

    def reactions_by_support(self, about: Any = None) -> SupportReactions:
        """Forces and moments of each support on the structure, those of springs and foundations too.

        Where two supports hold the same coordinate, each has an equal share. Conditions, as of hinges and links, have what
        they exert on the structure altogether: nothing where they tie two parts of it. The sums balance the loads.

        Parameters
        ----------
        about : (3,) numbers, optional
            Point of space that the moments are about (m). Default: of each support the centre of the nodes it holds.

        Raises
        ------
        InputError
            For a state that moves.

        Examples
        --------
        >>> beam = sk.Problem(sk.Rectangle(2.0, 0.1), 0.01, sk.Isotropic(2e11, 0.0, 7800), [sk.Clamp("left")],
        ...                   [sk.EdgeLoad("right", (0, 0, 50.0))])
        >>> table = sk.solve_linear(beam.on(sk.meshes.uniform(beam.surface, 4, 1))).reactions_by_support()
        >>> table.names
        ("Clamp 'left'",)
        >>> force, moment = table["Clamp 'left'"]
        >>> np.round(moment, 6) + 0.0
        array([ 0., 10.,  0.])
        """
        point = None if about is None else vector("about", about, 3)
        support, system, geometry = self._supporting(), self.system, self.system.geometry
        places, supports = system.shell.nodal(self.about), system.problem.supports
        parts: list[tuple[str, np.ndarray, np.ndarray]] = []
        left = system.shell.nodal(support).copy()
        # Supports that hold also carry what springs exert on held coordinates.
        springs = self.model.others_force(self.unknowns, None, self.case) if system.others else 0.0
        fixed = system.shell.nodal(system.constraints.fixed_part(support + springs))
        held = shares_of_supports(geometry, supports, fixed.reshape(-1, 12))
        for name, each, (nodes, force) in zip(_names(supports), supports, held, strict=True):
            whole, elastic = force.reshape(-1, 4, 3).copy(), each.springs(system.assembly)
            if elastic:
                term = Springs(elastic, system.shell)
                term.bind(system.blocks())
                whole -= system.shell.nodal(term.force(self.model.q(self.unknowns), None, self.case))
                nodes = np.union1d(nodes, np.concatenate([geometry.nodes[elements].ravel() for elements, _ in elastic]))
            left -= whole
            if nodes.size:
                parts.append((name, nodes, whole))
        everywhere = np.arange(geometry.n_nodes)
        if self.multipliers is not None and system.conditions:
            for name, force in system.conditions.forces_of(self.about, self.multipliers):
                parts.append((name, everywhere, -system.shell.nodal(force)))
        if system.problem.terms:
            parts.append(("terms", everywhere, left))
        centres = [places[nodes, 0].mean(axis=0) if point is None else point for _, nodes, _ in parts]
        forces = [force[:, 0].sum(axis=0) for _, _, force in parts]
        moments = [_moment(places, force, centre) for (_, _, force), centre in zip(parts, centres, strict=True)]
        rows = [np.array(values).reshape(-1, 3) for values in (forces, moments, centres)]
        return SupportReactions(tuple(name for name, _, _ in parts), *rows)

    def _supporting(self) -> np.ndarray:
        """What supports exert, (n_dofs,)."""
        if self.velocity is not None and np.any(self.velocity):
            raise InputError(MOVES)
        return np.asarray(self.model.support_force(self.unknowns, self.case, self.multipliers))


def _moment(places: np.ndarray, forces: np.ndarray, centre: np.ndarray) -> np.ndarray:
    """Of forces on nodal vectors (n, 4, 3) about a point."""
    return sum_of_cross(places, forces) - cross(centre, forces[:, 0].sum(axis=0))


def _names(supports: Any) -> list[str]:
    """The kind and place of each, with a number where several are equal."""
    names = []
    for support in supports:
        where, kind = getattr(support, "where", None), type(support).__name__
        names.append(f"{kind} {where!r}" if isinstance(where, str | tuple | list) else kind)
    return [name if names.count(name) == 1 else f"{name} {names[: k + 1].count(name)}" for k, name in enumerate(names)]
