"""A term that a user writes: an energy, or a residual and its tangent, integrated over the deformed surface."""

import inspect
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
import skfem
from skfem.assembly.form import Form

from skancf.arguments import flag, whole
from skancf.equality import by_value
from skancf.errors import InputError, shown
from skancf.functions import is_function
from skancf.history import Case, History, check_history
from skancf.layout.geometry import Geometry
from skancf.layout.layout import Layout
from skancf.showing import short
from skancf.terms.forms import integrand
from skancf.terms.forms.fields import VELOCITY
from skancf.terms.forms.integrand import Integrand
from skancf.terms.forms.points import Chunk, chunks_of
from skancf.terms.term import Addition, Term
from skancf.tolerances import ROUNDED_PRODUCT, SAME_VALUE

FORMS = {"energy": (skfem.Functional, "(w)"), "residual": (skfem.LinearForm, "(v, w)"),
         "tangent": (skfem.BilinearForm, "(u, v, w)")}  # fmt: skip


@by_value
@dataclass(frozen=True, eq=False)
class FormTerm(Addition):
    r"""An energy, a residual or both, of one's own, over the undeformed surface or along its edges.

    .. math::
        E = \int f(w) \, dA, \qquad \delta E = \int r(\delta r; w) \, dA, \qquad
        \Delta\delta E = \int t(\Delta r, \delta r; w) \, dA

    What is not given is made of what is: the residual of an energy by complex steps, exact to rounding; the tangent of a
    residual likewise, and of an energy alone by differences of such steps, to nine digits or so. In each case a form is
    differentiated with respect to the fields it reads, at points, so that one that reads few costs little.

    Parameters
    ----------
    energy : callable or skfem.Functional, optional
        f(w), energy per undeformed area (J/m2), or per length of an edge.
    residual : callable or skfem.LinearForm, optional
        r(v, w), with the variation v: what stands on the left side of the equations of motion, as the derivative of an
        energy does.
    tangent : callable or skfem.BilinearForm, optional
        t(u, v, w), the derivative of the residual along u. It need not be symmetric.
    where
        None for the whole surface; a name such as ``"left"``, or a list of names, for edges of the boundary; a function of
        (x, y) that is true on a part of the surface.
    load : bool
        Whether it acts from outside: it counts with the load factor and the history, and its work is booked as that of
        loads. Else it is part of the structure, and its energy a part of the strain energy.
    history : callable, optional
        Factor as a function of time, of a load.
    points : int
        Gauss points along each side of an element, or along an edge. Elements with points of their own have these.

    Raises
    ------
    InputError
        For none of the three, a tangent without a residual, what is no form or the wrong kind of one, and a history of what
        is no load; on a mesh, for names that w does not have, values of another shape or, undeformed, not finite, and
        functions that are not analytic where a derivative has to be taken.

    Notes
    -----
    Fields of ``w``, arrays with components first and elements and points last; m is a number of elements, n of points:

    ==================================  ===============  ==============================================================
    name                                shape            meaning
    ==================================  ===============  ==============================================================
    x                                   (2, m, n)        the parameters: ``x, y = w.x``
    X, X_x, X_y                         (3, m, n)        undeformed position and its derivatives
    X_xx, X_xy, X_yy                    (3, m, n)        second ones, in theory `kirchhoff`
    D, D_x, D_y                         (3, m, n)        undeformed director, in theory `full`
    N, dA                               (3, m, n), ()    undeformed unit normal, along X_x x X_y; area per dx dy
    A, B                                (2, 2, m, n)     undeformed metric, and curvature B_ab = X_ab . N (`kirchhoff`)
    r, r_x, r_y                         (3, m, n)        deformed position; also as ``w.r.grad``, (3, 2, m, n)
    r_xx, r_xy, r_yy                    (3, m, n)        `kirchhoff`; also as ``w.r.hess``, (3, 2, 2, m, n)
    d, d_x, d_y                         (3, m, n)        director, in theory `full`
    u, v                                (3, m, n)        displacement r - X; velocity, of residuals
    n, da, J                            (3, m, n), ()    deformed unit normal, area per dx dy, and da / dA
    a, b                                (2, 2, m, n)     deformed metric, and curvature b_ab = r_ab . n (`kirchhoff`)
    H, K                                (m, n)           mean and Gaussian curvature of the deformed surface (`kirchhoff`)
    s, nu, stretch                      (3, m, n), ()    of an edge: unit tangent with the surface on its left; unit vector
                                                         outwards, in the surface; deformed length per undeformed
    time, factor                        numbers          time (s), zero in statics; load factor
    ==================================  ===============  ==============================================================

    Test functions u and v are vectors (3, ...), variations of r, with ``grad``, ``hess`` (`kirchhoff`) and ``d``, the
    variation of the director, with ``d.grad`` (`full`).

    Integrals are over the undeformed area of the elements, or the length of their edges, those of the interpolated surface
    where it is curved; over the deformed area, multiply by ``w.J``. Forms are called with some elements at a time, and must
    be functions of what w holds.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> bed = sk.FormTerm(energy=lambda w: 0.5 * 1e6 * w.u[2] ** 2)  # a foundation of 1e6 N/m3
    >>> slab = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel, terms=[bed],
    ...     supports=[sk.Roller("left", (1, 0, 0)), sk.Roller("bottom", (0, 1, 0))],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> sunk = sk.solve(slab.on(sk.meshes.uniform(slab.surface, 2, 2), "kirchhoff")).unwrap()
    >>> print(f"{1000 * sunk.displacement((0.5, 0.5))[2]:.4f} mm")
    -1.0000 mm
    """

    energy: Any = None
    residual: Any = None
    tangent: Any = None
    where: Any = None
    load: bool = False
    history: History | None = None
    points: int = 4

    __repr__ = short

    def __post_init__(self) -> None:
        for name in FORMS:
            _check_form(name, getattr(self, name))
        if self.energy is None and self.residual is None:
            what = "a tangent alone" if self.tangent is not None else "none of energy, residual and tangent"
            raise InputError(f"FormTerm with {what}: give an energy(w), or a residual(v, w)")
        if self.tangent is not None and self.residual is None:
            raise InputError("FormTerm with a tangent and no residual: give the residual that it is the derivative of, or "
                             "the energy alone, of which both are made")  # fmt: skip
        object.__setattr__(self, "load", flag("load", self.load))
        object.__setattr__(self, "points", whole("points", self.points, most=64))
        check_history(self.history)
        if self.history is not None and not self.load:
            raise InputError("FormTerm with a history: only loads have one; give load=True, or read w.time in the form")

    def on(self, shell: Any, layout: Layout) -> "OnSurface":
        """The term on the shell's mesh."""
        forms = {
            name: Integrand(name, getattr(form, "form", form))
            for name in FORMS if (form := getattr(self, name)) is not None
        }  # fmt: skip
        return OnSurface(shell, forms, chunks_of(shell.geometry, self.where, self.points), self.load, self.history)


def _check_form(name: str, form: Any) -> None:
    if form is None:
        return
    kind, arguments = FORMS[name]
    if not isinstance(form, Form):
        if not is_function(form):
            raise InputError(f"{name} = {shown(form)}: give a function of {arguments}, or a skfem.{kind.__name__}")
    elif not isinstance(form, kind) or form.form is None:
        raise InputError(f"{name} is a skfem.{type(form).__name__}: give a skfem.{kind.__name__}, a function of {arguments}")
    function, wanted = getattr(form, "form", form), arguments.count(",") + 1
    try:
        inspect.signature(function).bind(*range(wanted))
    except TypeError as wrong:
        raise InputError(f"{name} = {shown(function)}: it is called as {name}{arguments}, which it does not take ({wrong})"
                         ) from wrong  # fmt: skip
    except ValueError:
        return  # a builtin has no signature


class _Watched(Case):
    """A case that notes whether a form reads its time."""

    def __getattribute__(self, name: str) -> Any:
        if name == "time":
            vars(self)["read"] = True
        return super().__getattribute__(name)


class OnSurface(Term):
    """Forms at the points of a mesh.

    Attributes
    ----------
    forms : dict
        Some of energy, residual and tangent.
    chunks : list of Chunk
    """

    def __init__(
        self, shell: Any, forms: dict[str, Integrand], chunks: list[Chunk], load: bool, history: History | None
    ) -> None:
        self.shell, self.forms, self.chunks, self.load, self.history = shell, forms, chunks, load, history
        self.geometry: Geometry = shell.geometry
        self._sizes, self._of_velocity = sizes_of(self.geometry), False
        self._check()

    def _check(self) -> None:
        """InputError for forms that are wrong at the undeformed state, or not analytic where that is needed."""
        case, rng = Case(time=0.0), np.random.default_rng(0)
        watched = _Watched(time=0.0)
        for chunk in self.chunks:
            for name, form in self.forms.items():
                tests = [integrand.every(chunk)] * list(FORMS).index(name)
                value, (*_, read) = form(chunk, chunk.undeformed.jet, case, *tests)
                form.check_finite(value, chunk)
                if VELOCITY in read and name == "energy":
                    raise InputError("energy: it reads the velocity w.v; an energy is one of positions, give what depends "
                                     "on the velocity as a residual")  # fmt: skip
                self._of_velocity |= VELOCITY in read and name == "residual"
        chunk = self.chunks[0]
        if "energy" in self.forms:
            vars(watched)["read"] = False
            self.forms["energy"](chunk, chunk.undeformed.jet, watched)
            self.timed = vars(watched)["read"]
        if "residual" in self.forms:
            self._check_linear(chunk, case, rng)
        for name, derivative in (("energy", "residual"), ("residual", "tangent")):
            if name in self.forms and (derivative not in self.forms or (self._of_velocity and name == "residual")):
                self.forms[name].check_analytic(chunk, self._sizes, case, rng)

    def _check_linear(self, chunk: Chunk, case: Case, rng: np.random.Generator) -> None:
        form, start = self.forms["residual"], chunk.undeformed.jet
        one, two, away = (integrand.random_jet(chunk, self._sizes, rng) for _ in range(3))
        both = {name: one[name] - 2.0 * two[name] for name in one}
        for far in (0.0, integrand.AWAY):
            jet = {name: start[name] + far * away[name] for name in start}
            a, b, found = (form(chunk, jet, case, test)[0] for test in (one, two, both))
            # What is not finite away from the undeformed state, solvers turn back from.
            if np.abs(found - a + 2.0 * b).max() > SAME_VALUE * max(np.abs(a).max(), np.abs(b).max()):
                raise InputError("residual: the form is not linear in v; it must be, as a virtual work is")

    def couples(self) -> np.ndarray:
        return np.asarray(self.shell.cells)

    def _amount(self, case: Case) -> float:
        return case.amplitude(self.history) if self.load else 1.0

    def _states(self, q: np.ndarray, v: np.ndarray | None = None) -> Iterable[tuple[Chunk, dict[str, np.ndarray]]]:
        nodal = self.shell.nodal(q)
        rates = None if v is None or not self._of_velocity else self.shell.nodal(v)
        for chunk in self.chunks:
            local = self.geometry.local(nodal, chunk.elements)
            yield chunk, chunk.jet(local, None if rates is None else self.geometry.local(rates, chunk.elements))

    def energy(self, q: np.ndarray, case: Case) -> float | None:
        """The integral of the energy; None without one, and of a load, whose work is booked."""
        if "energy" not in self.forms or self.load:
            return None
        form = self.forms["energy"]
        return sum(float((form(c, jet, case)[0] * c.weights).sum()) for c, jet in self._states(q))

    def force(self, q: np.ndarray, v: np.ndarray | None, case: Case) -> np.ndarray:
        return self._forces(((chunk, self._gradient(chunk, jet, case)) for chunk, jet in self._states(q, v)), case)

    def _forces(self, gradients: Iterable[tuple[Chunk, dict[str, np.ndarray]]], case: Case) -> np.ndarray:
        out, amount = np.zeros_like(self.geometry.undeformed), self._amount(case)
        for chunk, gradient in gradients:
            out += self.geometry.nodal(amount * chunk.forces(gradient), chunk.elements)
        return np.asarray(self.shell.flat(out))

    def between(self, q0: np.ndarray, q1: np.ndarray, case: Case) -> np.ndarray | None:
        """The force in the middle, and at each point the part along the change that is missing from the energy's; None with
        a velocity, of a load, and without an energy."""
        if "energy" not in self.forms or self._of_velocity or self.load:
            return None
        pairs = zip(self._states(q0), self._states(q1), strict=True)
        gradients = (
            (chunk, integrand.discrete_gradient(self.forms["energy"], chunk, start, end, case, self._sizes))
            for (chunk, start), (_, end) in pairs
        )
        return self._forces(gradients, case)

    def _gradient(self, chunk: Chunk, jet: dict[str, np.ndarray], case: Case) -> dict[str, np.ndarray]:
        if "residual" in self.forms:
            return integrand.gradient_of_residual(self.forms["residual"], chunk, jet, case)
        return integrand.gradient_of_energy(self.forms["energy"], chunk, jet, case, self._sizes)

    def add_tangent(self, q: np.ndarray, v: np.ndarray | None, case: Case, blocks: Any) -> None:
        if blocks.skew and "residual" not in self.forms:
            return
        self._add(((chunk, self._second(chunk, jet, case)) for chunk, jet in self._states(q, v)), case, blocks)

    def add_damping(self, q: np.ndarray, v: np.ndarray | None, case: Case, blocks: Any) -> None:
        if self._of_velocity:
            form = self.forms["residual"]
            self._add(((chunk, integrand.damping_of_residual(form, chunk, jet, case, self._sizes))
                       for chunk, jet in self._states(q, v)), case, blocks)  # fmt: skip

    def _add(self, parts: Iterable[tuple[Chunk, integrand.Second]], case: Case, blocks: Any) -> None:
        on_elements, amount = self.shell.on_elements(blocks), self._amount(case)
        for chunk, (second, rows, columns) in parts:
            wanted = second.size and not (blocks.skew and rows == columns and _is_symmetric(second))
            if wanted:
                on_elements.add(chunk.elements, chunk.matrices(amount * second, rows, columns))

    def _second(self, chunk: Chunk, jet: dict[str, np.ndarray], case: Case) -> integrand.Second:
        if "tangent" in self.forms:
            return integrand.second_by_form(self.forms["tangent"], chunk, jet, case)
        if "residual" in self.forms:
            return integrand.second_of_residual(self.forms["residual"], chunk, jet, case, self._sizes)
        return integrand.second_of_energy(self.forms["energy"], chunk, jet, case, self._sizes)


def _is_symmetric(second: np.ndarray) -> bool:
    """Whether second derivatives (k, 3, k, 3, m, n) are, but for rounding."""
    return bool(np.abs(second - second.transpose(2, 3, 0, 1, 4, 5)).max() <= ROUNDED_PRODUCT * np.abs(second).max())


def sizes_of(geometry: Geometry) -> dict[str, float]:
    """The size in which each vector of a jet counts."""
    extent = float(np.ptp(geometry.undeformed[:, 0], axis=0).max())
    one, two = np.sqrt((geometry.undeformed[:, 1:3] ** 2).sum(axis=2)).max(axis=0).tolist()
    return {"r": extent, "r_x": one, "r_y": two, "r_xx": one**2 / extent, "r_xy": one * two / extent,
            "r_yy": two**2 / extent, "d": 1.0, "d_x": one / extent, "d_y": two / extent, VELOCITY: extent}  # fmt: skip
