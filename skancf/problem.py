"""A problem: what the user asks, without a mesh."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import skfem

from skancf.arguments import MESH, instance, plain
from skancf.conditions import Joint
from skancf.equality import by_value
from skancf.errors import InputError, positive, shown, warn
from skancf.layout.geometry import Geometry
from skancf.loads import Load
from skancf.materials import Damping, Laminate, Law, Section, SectionField, Zone, sections_of
from skancf.materials.zones import check_zones
from skancf.memory import require_mesh
from skancf.meshes.sides import misnamed, unjoined
from skancf.meshes.snap import onto_bounds, onto_lines
from skancf.showing import in_a_notebook, short
from skancf.supports import Support
from skancf.surfaces import Surface
from skancf.surfaces.checks import require_surface, require_vectors
from skancf.system.build import build
from skancf.system.system import System
from skancf.terms import Addition
from skancf.theories import Theory, theory_named

CHOICES: dict[str, Callable[[Callable[[Theory], System], float], System]] = {}
"""How theories are chosen, by name: from what a theory makes of a problem on a mesh, and a tolerance. Whoever can judge a
theory, by solving, puts its name here."""


@by_value
@dataclass(frozen=True)
class Problem:
    """Surface, thickness, material, supports and loads; knows no mesh.

    Parameters
    ----------
    surface : Surface
        Undeformed mid-surface, for example :class:`~skancf.Rectangle`.
    thickness : float or callable
        In metres, or any consistent unit of length; left out with a laminate, whose layers have their own. A function of the
        parameters (x, y) is asked where the elements integrate, on each mesh anew; where it jumps, there should be a zone.
    material : Law, Laminate or callable
        For example :class:`~skancf.Isotropic` or :class:`~skancf.Laminate`; or a function of (x, y) that returns one, such
        as fibres that turn. It is called point by point.
    supports, loads : sequences
    damping : Damping, optional
        Of the material and of the mass, in dynamics; motion is undamped without it.
    terms : sequence of Addition, optional
        Energies, forces and bodies of your own, see :class:`~skancf.terms.Addition`.
    offset : float or callable
        Height of the mid-plane above the surface (m), a number or a function of (x, y), such as half the thickness of a
        plate with a flat bottom in the surface; it adds to that of a laminate, which has the notes on what an offset means.
    zones : sequence of Zone, optional
        Parts of the parameter plane with sections of their own, such as a doubler or another layup. With zones that cover
        everything thickness and material may be left out.
    conditions : sequence of Joint, optional
        What holds together: links, hinges and conditions of your own, see :class:`~skancf.conditions.Joint`.

    Raises
    ------
    InputError
        For a thickness that is not positive, is missing, or is given with a laminate, and for a surface, material,
        support, load or damping that is not one; for zones that overlap.

    Examples
    --------
    >>> plate = sk.Problem(
    ...     surface=sk.Rectangle(1.0, 1.0), thickness=0.05,
    ...     material=sk.Isotropic(young=0.2e6, poisson=0.0, density=2000.0),
    ...     supports=[sk.Pin("corners")],
    ...     loads=[sk.PointForce(at=(0.5, 0.5), force=(0.0, 0.0, -20.0))],
    ... )
    >>> system = plate.on(sk.meshes.uniform(plate.surface, 12, 12), theory="full")
    """

    surface: Surface
    thickness: float | Callable[..., Any] | None = None
    material: Law | Laminate | Callable[..., Any] | None = None
    supports: Sequence[Support] = field(default_factory=tuple)
    loads: Sequence[Load] = field(default_factory=tuple)
    damping: Damping | None = None
    terms: Sequence[Addition] = field(default_factory=tuple)
    offset: float | Callable[..., Any] = 0.0
    zones: Sequence[Zone] = field(default_factory=tuple)
    conditions: Sequence[Joint] = field(default_factory=tuple)

    __repr__ = short

    _repr_html_ = in_a_notebook

    def __post_init__(self) -> None:
        plain(self)
        require_surface(self.surface)
        object.__setattr__(self, "zones", check_zones(self.zones))
        _ = self.section  # what is wrong with it is told here, not where it is first used
        for name, method in (("supports", "rows"), ("loads", "on"), ("terms", "part"), ("conditions", "gap")):
            items = getattr(self, name)
            if not isinstance(items, Sequence) or isinstance(items, str | bytes):
                raise InputError(f"{name}: give a list, as in {name}=[...], not {shown(items)}")
            object.__setattr__(self, name, tuple(items))
            for item in items:
                if isinstance(item, type) or not hasattr(item, method):
                    raise InputError(f"{name}: {shown(item)} is not a {name[:-1]}; see skancf.{name} for the choices")
                if name == "loads" and isinstance(item, Addition):
                    raise InputError(f"loads: {shown(item)} is a term; give it in terms=[...], a FormTerm with load=True")
        if self.damping is not None:
            instance("damping", self.damping, Damping, "a Damping, as in damping=Damping(stiffness=1e-4)")

    @cached_property
    def section(self) -> Section | SectionField:
        """The layers through the thickness, one for a plate of one material; a field where they vary."""
        return sections_of(self.material, self.thickness, self.offset, self.zones)

    def on(self, mesh: skfem.MeshQuad, theory: str | Theory = "full", *, tolerance: float = 0.01) -> System:
        """The problem on a mesh of the parameter plane, with a theory.

        Parameters
        ----------
        mesh
        theory
            A name, ``"full"`` or ``"kirchhoff"``; an object such as ``Full()``; or ``"auto"``: the cheapest theory whose
            modelling error is below ``tolerance``. What was taken and why is the system's ``choice``.
        tolerance : float
            For ``"auto"``: the largest part of the strain energy that leaving out transverse shear may change, or, without
            loads, of the square of the first frequency.

        Raises
        ------
        InputError
            For a mesh or theory that is not one, or does not fit the surface; for supports and loads without a place there;
            for zones whose sides are no mesh lines, and a thickness that is not positive somewhere.
        OutOfDepth
            Warned: for a boundary of the mesh with the name of one side of the surface that lies on another one, and for two
            sides that lie on each other and are not joined, where no support or load names one of them.
        NotEnoughMemory
            For a mesh whose system would not fit into memory, before any is taken.
        """
        instance("mesh", mesh, skfem.MeshQuad, MESH)
        tolerance = positive("tolerance", tolerance)
        if hasattr(self.surface, "bounds"):
            mesh = onto_bounds(mesh, self.surface.bounds)
            self._tell_of_sides(mesh)
        if isinstance(theory, str) and theory in CHOICES:
            return CHOICES[theory](lambda chosen: self._on(mesh, chosen), tolerance)
        return self._on(mesh, theory_named(theory))

    def _tell_of_sides(self, mesh: skfem.MeshQuad) -> None:
        if hasattr(self.surface, "sides"):
            wheres = [("where", getattr(item, "where", None)) for item in (*self.supports, *self.loads)]
            wheres += [where for joint in self.conditions for where in joint.wheres.items()]
            for hint in (misnamed(mesh, self.surface), unjoined(mesh, self.surface, wheres)):
                if hint:
                    warn(hint)

    def _on(self, mesh: skfem.MeshQuad, theory: Theory) -> System:
        require_mesh(mesh.nelements, theory.bytes_per_element)
        if theory.continuity:
            mesh = onto_lines(mesh)
        require_vectors(self.surface, mesh.p[:, mesh.t].mean(axis=1))
        geometry = Geometry(mesh, self.surface, theory)
        _check_extent(geometry)
        system = build(self, geometry)
        for section in system.assembly.section.samples():
            theory.warn_of(section, float(np.ptp(geometry.undeformed[:, 0], axis=0).max()))
        return system


SMALLEST_EXTENT, LARGEST_EXTENT = 1e-25, 1e12
"""Of a surface, in any unit of length: products of smaller and larger ones are no floating-point numbers, or zero."""


def _check_extent(geometry: Geometry) -> None:
    extent = float(np.ptp(geometry.undeformed[:, 0], axis=0).max())
    if not SMALLEST_EXTENT <= extent <= LARGEST_EXTENT:
        raise InputError(f"surface: it extends over {extent:.3g} in space; give lengths in another unit, so that it extends "
                         f"over {SMALLEST_EXTENT:g} to {LARGEST_EXTENT:g}")  # fmt: skip
