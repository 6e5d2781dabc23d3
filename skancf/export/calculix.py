"""A static problem as an input deck of CalculiX, for an independent check."""

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from skancf.arguments import choice, flag, system_like, whole
from skancf.atomic import AnyPath, check_file, replacing
from skancf.errors import InputError, number
from skancf.export.bricks import Bricks
from skancf.export.forces import Forces
from skancf.export.holds import Equation, equations
from skancf.export.results import CalculixDeck
from skancf.export.sections import Group, cards, groups
from skancf.version import __version__

ELEMENTS = ("C3D20R", "C3D20")
PATIENCE = ["*CONTROLS,PARAMETERS=TIME INCREMENTATION", "30,60,9,100,10,4,,30,,"]
"""Iterations before an increment is given up; CalculiX's own (4, 8, 9, 16, 10, 4, -, 5) cut steps that would converge."""
MOST_HALVINGS = 6


def calculix(
    system: Any, path: AnyPath, *, nonlinear: bool = True, refine: int = 0, element: str = "C3D20R", increment: float = 0.1
) -> CalculixDeck:
    r"""Write a static problem as an input deck of CalculiX (and of Abaqus): quadratic bricks, one for each layer.

    Each element becomes a brick with 20 nodes through the thickness, on the true surface, with the thickness, offset and
    layers that the problem has there. CalculiX makes the same bricks of its own shell elements, but ties a rotation at a
    node to a rigid cross-section, which bricks do not need. A support holds what it does here: positions of the reference
    surface (averages over the thickness), tilts of the line through the thickness at clamped and symmetric edges; the
    thickness stays free. Dead loads act on the reference surface too, and half of a pressure acts on each face.

    The loads are those of :func:`skancf.solve`: full amplitude, histories are left out.

    Parameters
    ----------
    system : System
        A problem on a mesh of any theory, without hanging nodes. What is exported: :class:`~skancf.Isotropic`,
        :class:`~skancf.Orthotropic` and laminates of them, zones whose faces meet, thickness and offset as functions of
        place; clamps, pins, simple supports, rollers, symmetry and prescribed displacements along edges, and at points those
        that hold positions only; hinges between edges with matching elements; dead loads, weight, pressure and temperature;
        moments with ``nonlinear=False``.
    path : str or Path
        Of the deck, ending in ``.inp``.
    nonlinear : bool
        With large deflections and rotations, ``*STEP, NLGEOM``, as :func:`skancf.solve` has them; or linear, as
        :func:`skancf.solve_linear`.
    refine : int
        How many times each element is halved in both directions.
    element : {"C3D20R", "C3D20"}
        With reduced integration, which thin plates need, or with the full one, for a check of hourglass motions.
    increment : float
        First share of the load in a nonlinear step; CalculiX changes it as it converges.

    Returns
    -------
    CalculixDeck
        Which runs CalculiX and reads its answer.

    Raises
    ------
    InputError
        By its name for whatever is not exported.

    Notes
    -----
    Bricks have three-dimensional elasticity with the material's own constants: their answer differs from that of a theory of
    plates under point loads, at clamped corners and where a shell is thick. Reduced integration leaves hourglass motions of
    a single row of elements, with which a nonlinear step of a strip does not converge: give ``refine=1``.

    Examples
    --------
    >>> plate = sk.Problem(sk.Rectangle(1.0, 1.0), 0.02, sk.Isotropic(70e9, 0.3, 2700.0), [sk.Clamp("left")], [sk.Gravity()])
    >>> system = plate.on(sk.meshes.uniform(plate.surface, 4, 4))
    >>> deck = sk.export.calculix(system, "plate.inp", nonlinear=False)
    >>> deck.n_elements
    16
    >>> answer = deck.run()                                    # doctest: +SKIP
    >>> answer.difference(sk.solve_linear(system))    # doctest: +SKIP
    0.004
    """
    system_like(system)
    nonlinear, times = flag("nonlinear", nonlinear), whole("refine", refine, least=0, most=MOST_HALVINGS)
    choice("element", element, ELEMENTS)
    share = number("increment", increment)
    if not 0 < share <= 1:
        raise InputError(f"increment = {increment}: the first share of the load is above 0 and at most 1")
    file = check_file(path, ".inp")
    if times:
        system = system.problem.on(system.mesh.refined(times), system.geometry.theory)
    _refuse(system)
    bricks = Bricks.of(system)
    deck = Deck(
        bricks, groups(bricks), Forces.of(bricks, nonlinear), *equations(bricks).reduced(), nonlinear, element, share
    )
    with replacing(file) as part:
        part.write_text("\n".join(deck.lines()) + "\n", encoding="ascii")
    return CalculixDeck(file, bricks, nonlinear)


def _refuse(system: Any) -> None:
    problem = system.problem
    if problem.terms:
        raise InputError(f"terms: {type(problem.terms[0]).__name__} is of your own, which another program does not know; "
                         "export the problem without it")  # fmt: skip
    if system.geometry.integration.kinds.any():
        raise InputError("system: it has integration points of its own, which bricks do not have")


@dataclass(frozen=True)
class Deck:
    """What a deck says."""

    bricks: Bricks
    groups: list[Group]
    forces: Forces
    held: list[Equation]
    tied: list[Equation]
    nonlinear: bool
    element: str
    increment: float

    def lines(self) -> Iterator[str]:
        yield from self._header()
        yield from self._mesh()
        yield from self._sections()
        yield from self._conditions()
        yield from self._step()

    def _header(self) -> Iterator[str]:
        problem, mesh = self.bricks.system.problem, self.bricks.system.mesh
        yield f"** skancf {__version__}: a static problem, {'large' if self.nonlinear else 'small'} deflections"
        yield f"** {mesh.nelements} elements, {self.bricks.n_layers} layer(s) of {self.element} through the thickness"
        yield f"** surface: {type(problem.surface).__name__}"
        for name in ("supports", "conditions", "loads"):
            kinds = [type(each).__name__ for each in getattr(problem, name)]
            yield f"** {name}: {', '.join(kinds) or 'none'}"
        yield "** units: those of the problem, such as m, N, Pa, kg, s"
        yield "** left out: histories of loads (full amplitude), damping, shear correction factors (bricks need none)"
        if self.forces.pressure is not None:
            yield "** pressure: half on each face, constant in each element"

    def _mesh(self) -> Iterator[str]:
        yield "*NODE,NSET=NALL"
        for k, (x, y, z) in enumerate(self.bricks.points.tolist(), 1):
            yield f"{k},{x:.12g},{y:.12g},{z:.12g}"
        for k, value in enumerate(self._dummies(), self.bricks.n_nodes + 1):
            yield f"*NODE,NSET=GIVEN\n{k},0,0,0\n** moved by {value:.6g}"
        first = 1
        for layer in range(self.bricks.n_layers):
            yield f"*ELEMENT,TYPE={self.element},ELSET=LAYER{layer + 1}"
            for k, nodes in enumerate((self.bricks.elements(layer) + 1).tolist(), first):
                yield ",".join(map(str, [k, *nodes[:15]])) + ","
                yield ",".join(map(str, nodes[15:]))
            first += self.bricks.system.geometry.n_elements
        yield "*ELSET,ELSET=EALL\n" + ",".join(f"LAYER{k + 1}" for k in range(self.bricks.n_layers))
        for name, facets in sorted((self.bricks.system.mesh.boundaries or {}).items()):
            yield f"*NSET,NSET={_name('N', name)}"
            yield from _rows(self._nodes_of(np.asarray(facets)) + 1)

    def _nodes_of(self, facets: np.ndarray) -> np.ndarray:
        """All nodes above and below facets."""
        geometry = self.bricks.system.geometry
        lines = np.union1d(geometry.ends(facets), self.bricks.lines_of_facets(facets))
        return np.flatnonzero(np.isin(self.bricks.line_of, lines))

    def _sections(self) -> Iterator[str]:
        heated, weighs = self.forces.temperature is not None, self.forces.acceleration is not None
        materials: dict[int, str] = {}
        for k, group in enumerate(self.groups, 1):
            own = id(group.material)  # a law that was given lists has no hash
            if own not in materials:
                materials[own] = f"M{len(materials) + 1}"
                yield from cards(group.material, materials[own], weighs, heated)
            yield f"*ELSET,ELSET=G{k}"
            yield from _rows(group.elements + group.layer * self.bricks.system.geometry.n_elements + 1)
            option = ""
            if group.axes is not None:
                yield f"*ORIENTATION,NAME=O{k},SYSTEM=RECTANGULAR"
                yield ",".join(f"{v:.9g}" for v in group.axes.ravel())
                option = f",ORIENTATION=O{k}"
            yield f"*SOLID SECTION,ELSET=G{k},MATERIAL={materials[own]}{option}"

    def _dummies(self) -> list[float]:
        """Values of equations that are not zero: each is the displacement of a node of its own."""
        return [each.value for each in self.tied if each.value]

    def _conditions(self) -> Iterator[str]:
        rest = [each for each in self.held if not each.value]
        if rest:
            yield "*BOUNDARY"
            yield from (_displacement(each) for each in rest)
        dummy = self.bricks.n_nodes
        for each in self.tied:
            terms = list(zip(each.unknowns, each.coefficients, strict=True))
            if each.value:
                terms.append((3 * dummy, -1.0))
                dummy += 1
            parts = [f"{u // 3 + 1},{u % 3 + 1},{c:.12g}" for u, c in terms]
            yield f"*EQUATION\n{len(parts)}"
            yield from (",".join(parts[k : k + 4]) for k in range(0, len(parts), 4))
        if self.forces.temperature is not None:
            yield "*INITIAL CONDITIONS,TYPE=TEMPERATURE\nNALL,0."

    def _step(self) -> Iterator[str]:
        forces, n = self.forces, self.bricks.system.geometry.n_elements
        yield from ["*STEP,NLGEOM,INC=10000", *PATIENCE] if self.nonlinear else ["*STEP"]
        yield "*STATIC"
        if self.nonlinear:
            yield f"{self.increment:.6g},1.,1e-5,1."
        moved = [each for each in self.held if each.value]
        given = [f"{k},1,1,{v:.12g}" for k, v in enumerate(self._dummies(), self.bricks.n_nodes + 1)]
        if moved or given:
            yield "*BOUNDARY"
            yield from (*(_displacement(each) for each in moved), *given)
        pushed = np.argwhere(forces.nodal)
        if len(pushed):
            yield "*CLOAD"
            yield from (f"{node + 1},{axis + 1},{forces.nodal[node, axis]:.12g}" for node, axis in pushed.tolist())
        if forces.pressure is not None or forces.acceleration is not None:
            yield "*DLOAD"
        if forces.acceleration is not None:
            size = float(np.linalg.norm(forces.acceleration))
            yield f"EALL,GRAV,{size:.12g}," + ",".join(f"{v:.12g}" for v in forces.acceleration / (size or 1.0))
        if forces.pressure is not None:
            top = (self.bricks.n_layers - 1) * n
            for k, p in enumerate(np.broadcast_to(forces.pressure, n).tolist(), 1):
                yield f"{k},P1,{p / 2:.12g}\n{k + top},P2,{-p / 2:.12g}"
        if forces.temperature is not None:
            yield "*TEMPERATURE"
            yield from (f"{k},{v:.12g}" for k, v in enumerate(forces.temperature.tolist(), 1))
        yield "*NODE PRINT,NSET=NALL,FREQUENCY=10000\nU"
        yield "*NODE FILE,FREQUENCY=10000\nU\n*EL FILE,FREQUENCY=10000\nS\n*END STEP"


def _displacement(each: Equation) -> str:
    """Of an equation with one unknown."""
    node, axis = each.unknowns[0] // 3 + 1, each.unknowns[0] % 3 + 1
    return f"{node},{axis},{axis}" + (f",{each.value:.12g}" if each.value else "")


def _rows(numbers: Iterable[int]) -> Iterator[str]:
    """Sixteen to a line, as a deck may have."""
    items = [str(int(k)) for k in numbers]
    return (",".join(items[k : k + 16]) + "," for k in range(0, len(items), 16))


def _name(prefix: str, name: str) -> str:
    """A name of a set: capital letters, digits and underscores."""
    return f"{prefix}_{re.sub('[^A-Z0-9]', '_', name.upper())}"[:70]
