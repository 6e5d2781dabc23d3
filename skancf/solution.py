"""Fields, stresses, energies and reactions of one state of a system."""

from dataclasses import dataclass, field
from math import isfinite
from typing import Any

import numpy as np

from skancf.arguments import flag, plain, system_like, text
from skancf.equality import by_value
from skancf.errors import InputError, number, shown, vector
from skancf.history import Case
from skancf.layout.layout import vectors
from skancf.lines import AtPlaces
from skancf.local_fields import LocalFields
from skancf.materials.heights import Depth, depth_of
from skancf.reactions import Reactions
from skancf.showing import in_a_notebook, in_brackets, looked_at, state_in_words
from skancf.system.linearised import Exact, Linearised, Model, Rate, Value
from skancf.system.probe import normal_rates, normals, probe
from skancf.system.system import System
from skancf.thinness import Fields, ShearForm, share_of
from skancf.tolerances import SAME_VALUE

STRESSES = ("S11", "S22", "S33", "S23", "S13", "S12")


@by_value
@dataclass(frozen=True)
class Solution(LocalFields, AtPlaces, Reactions):
    """One state: nodal coordinates with their system.

    Attributes
    ----------
    system : System
    q : (n_dofs,) array
        Nodal coordinates.
    velocity : (n_dofs,) array or None
        Their rates, in dynamics.
    time : float or None
    load_factor : float
        Factor of all loads, in statics.
    linear : bool
        A small-deflection answer, in equilibrium with the tangent of the undeformed state.
    small : (n_dofs,) array or None
        Its change from the undeformed coordinates: their sum keeps only the digits that positions have.
    note : str
        What is to be known of it, such as that a mode has no size of its own; titles of pictures say it.
    multipliers : (n,) array or None
        Of the conditions, in the order of their rows; :attr:`conditions` has them by name.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> system = plate.on(sk.meshes.uniform(plate.surface, 6, 6), "kirchhoff")
    >>> solution = sk.solve_linear(system)
    >>> print(f"{1000 * solution.displacement((0.5, 0.5))[2]:.4f} mm, {solution.reactions()[2]:.1f} N")
    -0.0658 mm, 1000.0 N
    """

    system: System
    q: np.ndarray
    velocity: np.ndarray | None = None
    time: float | None = None
    load_factor: float = 1.0
    linear: bool = False
    small: np.ndarray | None = field(default=None, repr=False, kw_only=True)
    note: str = field(default="", kw_only=True)
    multipliers: np.ndarray | None = field(default=None, repr=False, kw_only=True)

    __repr__, __str__, _repr_html_, view = in_brackets, state_in_words, in_a_notebook, looked_at

    def __post_init__(self) -> None:
        plain(self)
        if not isinstance(self.system, System):
            system_like(self.system)
        n = self.system.undeformed.size
        for name in ("q", "velocity"):
            value = getattr(self, name)
            if value is None and name == "velocity":
                continue
            if not (isinstance(value, np.ndarray) and value.dtype == float and value.shape == (n,)):
                object.__setattr__(self, name, vector(name, value, n))
        if self.time is not None and not (type(self.time) is float and isfinite(self.time)):
            number("time", self.time)
        if not (type(self.load_factor) is float and isfinite(self.load_factor)):
            number("load_factor", self.load_factor)
        if type(self.linear) is not bool:
            flag("linear", self.linear)
        if type(self.note) is not str:
            text("note", self.note)
        if self.multipliers is not None:
            object.__setattr__(self, "multipliers", vector("multipliers", self.multipliers, self.system.conditions.n))
        if self.small is not None:
            small = vector("small", self.small, n)
            # That of another state, which this one is a copy of, is dropped.
            object.__setattr__(self, "small", small if np.array_equal(self.system.undeformed + small, self.q) else None)

    @property
    def case(self) -> Case:
        """The load factor and the time."""
        return Case(self.load_factor, self.time)

    @classmethod
    def of(cls, model: Model, x: np.ndarray, load_factor: float = 1.0, multipliers: np.ndarray | None = None) -> "Solution":
        """A state of rest of a model at its unknowns x."""
        small = x if model.linear else None
        return cls(model.system, model.q(x), None, None, load_factor, model.linear, small=small, multipliers=multipliers)

    @property
    def model(self) -> Model:
        """The system, to first order for a small-deflection answer: what forces, energies and fields are asked of, at
        :attr:`unknowns`."""
        return Linearised(self.system) if self.linear else Exact(self.system)

    @property
    def unknowns(self) -> np.ndarray:
        """What its model is asked at, (n_dofs,): q, or of a small-deflection answer the change."""
        return self.change if self.linear else self.q

    @property
    def about(self) -> np.ndarray:
        """Unknowns about which further changes are small, (n_dofs,): q, or of a small-deflection answer the undeformed."""
        return self.model.about(self.q)

    @property
    def change(self) -> np.ndarray:
        """Nodal coordinates less the undeformed ones, (n_dofs,): of a small-deflection answer with all digits it has."""
        return self.q - self.system.undeformed if self.small is None else self.small

    @property
    def displacements(self) -> np.ndarray:
        """Displacements of the nodes of the mesh, (3, n_mesh_nodes) (m)."""
        change = self.system.shell.nodal(self.change)
        return np.asarray(self.system.geometry.at_mesh_nodes(change)[:, 0].T)

    def displacement(self, at: Any, z: Depth = 0.0) -> np.ndarray:
        """Displacement at points of the parameter plane, (2,) or (n, 2), at depth z: (3,) or (n, 3)."""
        out = probe(self.system, at) @ vectors(self.change)
        if np.any(depth := self._depths(at, z)):
            out = out + depth * self._tilts(at)
        return np.asarray(out[0] if np.ndim(at) == 1 else out)

    def position(self, at: Any, z: Depth = 0.0) -> np.ndarray:
        """Position in space of points of the parameter plane, (2,) or (n, 2), at depth z: (3,) or (n, 3)."""
        out = probe(self.system, at) @ vectors(self.q)
        if np.any(depth := self._depths(at, z)):
            out = out + depth * (normals(self.system, at, self.system.undeformed) + self._tilts(at))
        return np.asarray(out[0] if np.ndim(at) == 1 else out)

    def rotation(self, at: Any) -> np.ndarray:
        """Angle between the normal (director) and the undeformed one at points (2,) or (n, 2): () or (n,) (rad)."""
        value, rate = self._normals(at)
        angle = self.model.turn(value, self.unknowns, rate)
        return angle[0] if np.ndim(at) == 1 else angle

    def _tilts(self, at: Any) -> np.ndarray:
        """Changes of directors or unit normals (n, 3), of a small-deflection answer to first order."""
        value, rate = self._normals(at)
        return np.asarray(self.model.rise(value, self.unknowns, rate))

    def _normals(self, at: Any) -> tuple[Value, Rate]:
        """Directors or unit normals, and their derivatives."""
        return lambda q: normals(self.system, at, q), lambda q, change: normal_rates(self.system, at, q, change)

    @property
    def shear_share(self) -> float:
        """By which part transverse shear, which theory `kirchhoff` leaves out, would change the strain energy, edge layers
        included: see :mod:`skancf.thinness.form`. Zero in `full`."""
        return self.shear_share_of(None)

    def shear_share_of(self, elements: np.ndarray | None) -> float:
        """What some elements, a mask (n_elements,), have in that; None: all."""
        if self.system.geometry.theory.shear:
            return 0.0
        form, fields = self.shear_fields()
        shares = form.shares(fields, fields)
        if elements is not None:
            if not isinstance(elements, np.ndarray) or elements.shape != shares.shape or elements.dtype.kind not in "biuf":
                raise InputError(f"elements = {shown(elements)}: give a mask of the {len(shares)} elements")
            shares = shares * elements
        heat = self.system.shell.thermal_energy(self.case)
        return share_of(float(shares.sum()), self.strain_energy, heat)

    def shear_fields(self) -> tuple[ShearForm, Fields]:
        """The form that says what leaving shear out changes, and this state's fields in it; for theory `kirchhoff`."""
        form = ShearForm(self.system, self.case)
        return form, form.of_state(self.model, self.unknowns)

    @property
    def rest_share(self) -> float:
        """How much of the strain energy is in membrane strains that the assumed ones of theory `kirchhoff` leave out.

        Where it is large, motions of single elements that hardly cost energy rule the answer. Zero in theory `full`.
        """
        system = self.system
        if not system.assembly.assumes_membrane:
            return 0.0
        heat = system.shell.thermal_energy(self.case)
        thin: Any = system.assembly
        rest = self._of_state(lambda q: thin.membrane_rest(system.shell.nodal(q)))
        energy = self.strain_energy
        return 0.0 if energy <= SAME_VALUE * heat else float(thin.rest_energy(rest) / energy)

    @property
    def strain_energy(self) -> float:
        """Strain energy (J), that of the stress: free expansion has none."""
        return self.model.strain_energy(self.unknowns, self.case)

    @property
    def work(self) -> float:
        """Work of the loads on the displacements (J), as if they were as large all the way; half of it when linear.

        A temperature change is no load from outside, and does none.
        """
        return self.model.work(self.unknowns, self.case)

    @property
    def kinetic_energy(self) -> float:
        """Kinetic energy (J); zero in statics."""
        if self.velocity is None:
            return 0.0
        return self.system.kinetic_energy(self.velocity)

    @property
    def momenta(self) -> np.ndarray:
        """Linear momentum (N s) and angular momentum about the origin (N m s), (2, 3); zero in statics."""
        return np.zeros((2, 3)) if self.velocity is None else self.system.momenta(self.q, self.velocity)

    @property
    def conditions(self) -> dict[str, Any]:
        """The forces that keep the conditions, by their names, see :meth:`~skancf.conditions.Condition.forces`: that in a
        link (N), the :class:`~skancf.conditions.hinge.HingeForce`, multipliers. InputError for a state without them."""
        conditions = self.system.conditions
        if self.multipliers is None and conditions:
            raise InputError(
                "conditions: this state has no multipliers; those of solve, solve_linear, trace and simulate have them"
            )
        return {} if self.multipliers is None else conditions.named(self.multipliers)

    def _depths(self, at: Any, z: Depth) -> Any:
        """Depths at points (2,) or (n, 2) of the parameter plane, one for all or (n, 1)."""
        if not isinstance(z, str) and not number("z", z):
            return 0.0
        depth = depth_of(self.system.assembly.section.at_places(np.atleast_2d(at).T), z)
        return depth[:, None] if np.ndim(depth) else depth
