"""What a state is at places of the parameter plane and along lines of it: displacements, section forces, stresses."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np

from skancf.arguments import choice
from skancf.errors import InputError, shown
from skancf.layout.around import Around, at_pairs, elements_around
from skancf.materials.heights import Depth, depth_of
from skancf.showing import short
from skancf.system.frames import frames, turns
from skancf.tabular import Column, Tabular
from skancf.tensors import (
    cauchy,
    principal_directions,
    principal_stresses,
    signed_von_mises,
    tensors,
    tresca,
    turned,
    von_mises,
)

COMPONENTS = ("11", "22", "33", "23", "13", "12")
GLOBAL = ("xx", "yy", "zz", "yz", "xz", "xy")
FACES = ("top", "bottom")
IN_PLANE = (0, 1, 5)
EQUIVALENTS = {
    "max_principal": "max_principal", "min_principal": "min_principal", "mises": "von_mises", "tresca": "tresca",
}  # fmt: skip
"""Columns of equivalent stresses, and what :class:`Stresses` calls them."""


@dataclass(frozen=True)
class Stresses(Tabular):
    """Stresses at places, as :meth:`PointValues.stress` gives them; a table, see :class:`~skancf.tabular.Tabular`.

    Attributes
    ----------
    components : (n, 6) array
        In the order 11, 22, 33, 23, 13, 12 of the frame (Pa); of the global one xx, yy, zz, yz, xz, xy.
    frame : {"local", "global"}

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> system = plate.on(sk.meshes.uniform(plate.surface, 6, 6), "kirchhoff")
    >>> stresses = sk.solve_linear(system).at([(0.5, 0.5)]).stress("bottom")
    >>> print(f"{stresses.von_mises[0] / 1e6:.2f} MPa")
    1.42 MPa
    """

    components: np.ndarray
    frame: str

    __repr__ = short

    @property
    def tensors(self) -> np.ndarray:
        """Symmetric matrices (n, 3, 3) (Pa)."""
        return tensors(self.components)

    @property
    def von_mises(self) -> np.ndarray:
        """Von Mises' equivalent stress, (n,) (Pa)."""
        return von_mises(self.components)

    @property
    def signed_von_mises(self) -> np.ndarray:
        """Von Mises' equivalent with the sign of the principal stress of the largest size, (n,) (Pa)."""
        return signed_von_mises(self.components)

    @property
    def tresca(self) -> np.ndarray:
        """Tresca's equivalent stress, the largest principal stress less the smallest, (n,) (Pa)."""
        return tresca(self.components)

    @property
    def principal(self) -> np.ndarray:
        """Principal stresses, the largest first, (n, 3) (Pa)."""
        return principal_stresses(self.components)

    @property
    def directions(self) -> np.ndarray:
        """Unit vectors of the principal stresses in the frame of the components, a row for each: (n, 3, 3)."""
        return principal_directions(self.components)

    @property
    def max_principal(self) -> np.ndarray:
        """The largest principal stress, (n,) (Pa): the largest tension."""
        return np.asarray(self.principal[:, 0])

    @property
    def min_principal(self) -> np.ndarray:
        """The smallest principal stress, (n,) (Pa): the largest pressure, negative."""
        return np.asarray(self.principal[:, 2])

    def _table(self) -> dict[str, Column]:
        names = COMPONENTS if self.frame == "local" else GLOBAL
        table: dict[str, Column] = {f"S{k}": (part, "Pa") for k, part in zip(names, self.components.T, strict=True)}
        table |= {f"principal_{k}": (part, "Pa") for k, part in zip((1, 2, 3), self.principal.T, strict=True)}
        return table | {"mises": (self.von_mises, "Pa"), "tresca": (self.tresca, "Pa")}


@dataclass(frozen=True, eq=False)
class PointValues(Tabular):
    """A state at places of the parameter plane, as :meth:`~skancf.Solution.at` gives it.

    As a table it has a row for each place: its parameters, position, displacement, rotation, section forces, and at both
    faces the Cauchy stress in the local frame, the largest and the smallest principal stress and von Mises' equivalent.

    Attributes
    ----------
    state : Solution
    points : (n, 2) array
        Parameters x and y.
    side : (2,) array or None
        On an edge of the mesh, where fields other than the displacement may jump, values are means over all elements that
        meet there, or of those on this side of it.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> system = plate.on(sk.meshes.uniform(plate.surface, 6, 6), "kirchhoff")
    >>> values = sk.solve_linear(system).at([(0.5, 0.5), (0.0, 0.5)])
    >>> print(values.M.shape, f"{values.M[0, 0]:.1f} N")
    (2, 3) -23.7 N
    """

    state: Any
    points: np.ndarray
    side: np.ndarray | None = None

    def __len__(self) -> int:
        return len(self.points)

    def __bool__(self) -> bool:
        return True

    def __repr__(self) -> str:
        note = f"; {self.state.note}" if self.state.note else ""
        return f"{type(self).__name__}({len(self)} points{note})"

    __str__ = __repr__

    @cached_property
    def around(self) -> Around:
        """The elements at the places."""
        return elements_around(self.state.system.geometry, self.points.T, self.side)

    @property
    def x(self) -> np.ndarray:
        """Parameter x, (n,)."""
        return np.asarray(self.points[:, 0])

    @property
    def y(self) -> np.ndarray:
        """Parameter y, (n,)."""
        return np.asarray(self.points[:, 1])

    @cached_property
    def positions(self) -> np.ndarray:
        """Deformed positions in space, (n, 3) (m)."""
        return np.asarray(self.state.position(self.points))

    @cached_property
    def displacements(self) -> np.ndarray:
        """(n, 3) (m)."""
        return np.asarray(self.state.displacement(self.points))

    @cached_property
    def rotations(self) -> np.ndarray:
        """Angles between normals (directors) and undeformed ones, (n,) (rad)."""
        return np.asarray(self.state.rotation(self.points))

    @cached_property
    def section_forces(self) -> np.ndarray:
        """N11, N22, N12 (N/m) and M11, M22, M12 (N) as :meth:`~skancf.Solution.recovered_section_forces`, (n, 6)."""
        return self._means(lambda at, some: self.state.recovered_section_forces(at, some).swapaxes(1, 2))

    @property
    def N(self) -> np.ndarray:
        """Membrane forces per length N11, N22, N12 in the local frame, (n, 3) (N/m)."""
        return np.asarray(self.section_forces[:, :3])

    @property
    def M(self) -> np.ndarray:
        """Moments per length M11, M22, M12 in the local frame, (n, 3) (N)."""
        return np.asarray(self.section_forces[:, 3:])

    @cached_property
    def Q(self) -> np.ndarray:
        """Transverse shear forces per length Q1, Q2, (n, 2) (N/m), see :meth:`~skancf.Solution.shear_forces`."""
        return self._means(lambda at, some: self.state.shear_forces(at, some).swapaxes(1, 2))

    @cached_property
    def frames(self) -> np.ndarray:
        """Unit vectors of the local frames of the undeformed surface in space, a row for each: (n, 3, 3).

        The first is along the parameter x, the third the normal.
        """
        whole = self._means(lambda at, some: frames(self.state.system, at, some)).swapaxes(1, 2)
        return np.asarray(whole / np.linalg.norm(whole, axis=2, keepdims=True))

    def stress(self, z: Depth = "top", *, frame: str = "local", measure: str = "cauchy") -> Stresses:
        r"""Stresses at a height of the places.

        In theory `full` of recovered strains, as pictures have them: see :meth:`~skancf.Solution.recovered_section_forces`.

        Parameters
        ----------
        z : float or {"top", "middle", "bottom"}
            Height above the reference surface of the undeformed plate (m). At an interface of layers the law is that of the
            lower one.
        frame : {"local", "global"}
            Directions of the components. ``"local"``: 1 along the parameter x of the surface, 2 at right angles to it in the
            surface, 3 across, turned with the material. ``"global"``: x, y, z of space.
        measure : {"cauchy", "second piola"}
            Cauchy stress, force per deformed area; in the global frame it acts in the deformed body, and is
            :math:`R \sigma R^T` with the rotation R of the material at z. Or the second Piola-Kirchhoff stress S, which
            works on Green-Lagrange strain; in the global frame its directions are those of the undeformed body. Where
            strains are small both have nearly the same components in the local frame. A small-deflection answer has one
            stress, in the undeformed directions.

        Raises
        ------
        InputError
            For a height outside the plate, and other names.
        """
        choice("frame", frame, ("local", "global"))
        choice("measure", measure, ("cauchy", "second piola"))
        state, true = self.state, measure == "cauchy"

        def stress(at: np.ndarray, some: np.ndarray) -> np.ndarray:
            found = state.recovered_stresses(at, z, some)
            if true and not state.linear:
                found = cauchy(found, state.recovered_strains(at, z, some))
            if frame == "local":
                return np.asarray(found)
            R = frames(state.system, state.system.geometry.inside(at), some)
            if true and not state.linear:
                depth = depth_of(state.system.assembly.section.at(at, some), z)
                R = turns(state.system, state.q, state.system.geometry.inside(at), some, depth) @ R
            return turned(found, R)

        return Stresses(self._means(stress), frame)

    def strain(self, z: Depth = "top") -> np.ndarray:
        """Green-Lagrange strains 11, 22, 33, 23, 13, 12 in the local frame at a height, shear strains doubled: (n, 6)."""
        return self._means(lambda at, some: self.state.recovered_strains(at, z, some))

    @property
    def heights(self) -> np.ndarray:
        """Undeformed heights of the faces and interfaces of layers above the reference surface, (n_layers + 1, n) (m)."""
        return self._means(self._heights).T

    def _heights(self, at: np.ndarray, some: np.ndarray) -> np.ndarray:
        z = self.state.system.assembly.section.at(at, some).z
        return np.broadcast_to(z, (len(some), at.shape[1], z.shape[-1]))

    def _means(self, value: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> np.ndarray:
        """Means over the elements at each place of values (m, k, ...) at points (2, k) of elements (m,)."""
        _, elements, local = self.around
        return self.around.means(at_pairs(elements, local, value), len(self.points))

    def __getitem__(self, name: str) -> np.ndarray:
        """A column of the table by its name, (n,)."""
        return np.asarray(self._makers()[self._known(name)][0]())

    def unit(self, name: str) -> str:
        """The unit of a column."""
        return self._makers()[self._known(name)][1]

    def _known(self, name: Any, called: str = "name") -> str:
        if not isinstance(name, str) or name not in self._makers():
            raise InputError(f"{called} = {shown(name)}: is no column; there are {', '.join(self._makers())}")
        return name

    @property
    def units(self) -> dict[str, str]:
        """Units by name of the column; empty for numbers without one."""
        return {name: unit for name, (_, unit) in self._makers().items()}

    def _table(self) -> dict[str, Column]:
        return {name: (make(), unit) for name, (make, unit) in self._makers().items()}

    def _makers(self) -> dict[str, tuple[Callable[[], np.ndarray], str]]:
        """Functions that give the columns, and their units."""
        out: dict[str, tuple[Callable[[], np.ndarray], str]] = {"x": (lambda: self.x, ""), "y": (lambda: self.y, "")}
        for names, unit, values in (
            (("X", "Y", "Z"), "m", lambda: self.positions),
            (("u1", "u2", "u3"), "m", lambda: self.displacements),
            (("rotation",), "rad", lambda: self.rotations[:, None]),
            (("N11", "N22", "N12"), "N/m", lambda: self.N),
            (("M11", "M22", "M12"), "N", lambda: self.M),
            (("Q1", "Q2"), "N/m", lambda: self.Q),
        ):
            out |= {name: (partial(_column, values, k), unit) for k, name in enumerate(names)}
        for face in FACES:
            for k in IN_PLANE:
                out[f"S{COMPONENTS[k]}_{face}"] = (partial(_column, partial(self._face, face), k), "Pa")
            for name, attribute in EQUIVALENTS.items():
                out[f"{name}_{face}"] = (partial(self._equivalent, face, attribute), "Pa")
        return out

    @cached_property
    def _faces(self) -> dict[str, Stresses]:
        """Stresses that columns have asked for."""
        return {}

    def _stresses(self, face: str) -> Stresses:
        if face not in self._faces:
            self._faces[face] = self.stress(face)
        return self._faces[face]

    def _face(self, face: str) -> np.ndarray:
        return self._stresses(face).components

    def _equivalent(self, face: str, name: str) -> np.ndarray:
        return np.asarray(getattr(self._stresses(face), name))


def _column(values: Callable[[], np.ndarray], k: int) -> np.ndarray:
    return np.asarray(values()[:, k])
