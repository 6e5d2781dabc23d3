"""The error of a quantity of interest by its dual weight, and indicators of where the residual is large."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from skancf.adaptive.energies import energies, of_state, small
from skancf.adaptive.enriched import Enriched
from skancf.adaptive.quantities import Quantity
from skancf.adaptive.rings import NOTHING_KNOWN, Halvings
from skancf.arguments import having, instance
from skancf.equality import by_value
from skancf.errors import InputError, number, vector
from skancf.functions import called
from skancf.linear import check_backend
from skancf.meshes import MeshQuadTree
from skancf.progress import Bar, ShowProgress, check_progress
from skancf.showing import short
from skancf.solution import Solution
from skancf.states import StateLike, solution_of
from skancf.tabular import Column, Tabular


@by_value
@dataclass(frozen=True)
class Estimate(Tabular):
    r"""How far a value is from its limit, and where that comes from; as a table the indicators of the elements.

    Attributes
    ----------
    value : float
        On the mesh.
    error : float
        Limit minus value, estimated.
    indicators : (n_elements,) array
        Sizes of the contributions of the elements to it; contributions of both signs may cancel in it.
    better : Solution
        The state one refinement further, where the estimate comes from; that of the mesh where it comes from coarser ones.
    left : float
        Part of the error that the refinement does not see.
    unsure : float
        What the parts of single contributions that it does not see add up to with random signs.
    rounding : float
        What the unresolved residual of that state may do to the value: rounding of the linear solve, and Newton's rest.
    scale : float
        Sum of the sizes of what contributes to the value: one that is much smaller is zero, as its contributions cancel.
        They are those of the work of the answer's stresses on the strains of z in the elements, or a size that the quantity
        knows. 0 of frequencies and buckling loads.
    halvings : Halvings
        What one halving of the elements at singular points leaves of their part in the error.
    nested : bool
        The error is from values on this and two coarser meshes.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> mesh = sk.meshes.quadtree(sk.meshes.uniform(plate.surface, 6, 6), plate.surface)
    >>> system = plate.on(mesh, "kirchhoff")
    >>> estimate = sk.goal_estimate(sk.solve_linear(system), sk.StrainEnergy())
    >>> print(estimate.indicators.shape, abs(estimate.error) < 0.01 * estimate.value)
    (36,) True
    """

    value: float
    error: float
    indicators: np.ndarray
    better: Solution
    left: float
    unsure: float = 0.0
    rounding: float = 0.0
    scale: float = 0.0
    halvings: Halvings = NOTHING_KNOWN
    nested: bool = False

    __repr__ = __str__ = short

    def _table(self) -> dict[str, Column]:
        return {"element": (np.arange(len(self.indicators)), ""), "indicator": (self.indicators, "")}

    @property
    def bar(self) -> float:
        """Size of the error, with what it is unsure by, and with rounding."""
        return abs(self.error) + self.unsure + self.rounding

    @classmethod
    def seen(
        cls, value: float, refined: float, indicators: np.ndarray, better: Solution, left: np.ndarray, **more: Any
    ) -> "Estimate":
        r"""From the value on the refined mesh, and the parts :math:`\ell_K` (n_elements,) of the contributions that are left
        there: with :math:`1 - \ell = \sum_K \eta_K / \sum_K \eta_K (1 - \ell_K)^{-1}`

        .. math:: \frac{J(\text{refined}) - J}{1 - \ell}, \qquad \text{unsure by} \qquad
            \Bigl( \sum_K (\ell_K \eta_K)^2 \Bigr)^{1/2} .
        """
        total = float(indicators.sum())
        part = 1 - total / float(indicators @ (1 / (1 - left))) if total else 0.0
        unsure = float(np.sqrt(((left * indicators) ** 2).sum()))
        return cls(value, (refined - value) / (1 - part), indicators, better, part, unsure, **more)


def check_quantity(quantity: Any, methods: Sequence[str] = ("value", "gradient")) -> None:
    """InputError for what is no quantity of interest with these methods."""
    having("quantity", quantity, ("unit", *methods),
           "a quantity such as Displacement(at=(0.5, 0.5)), or an object with unit, value and gradient")  # fmt: skip


def check_state(name: str, value: Any, backend: str = "auto") -> Solution:
    """A state on a quadtree, whose elements can be quartered; InputError for another one, and for an unknown solver."""
    state = solution_of(name, value)
    check_backend(backend)
    if not isinstance(state.system.mesh, MeshQuadTree):
        raise InputError(f"{name}: its mesh must be a quadtree; make it by sk.meshes.quadtree(mesh)")
    return state


def goal_estimate(
    state: StateLike,
    quantity: Quantity,
    *,
    backend: str = "auto",
    halvings: Halvings = NOTHING_KNOWN,
    progress: ShowProgress = True,
) -> Estimate:
    r"""Dual-weighted residual estimate of the error of a quantity.

    Every element is quartered, a few times more at singular points. With the residual R of the refined system, its tangent K
    and the dual weight :math:`z = K^{-1} \partial J / \partial q`,

    .. math:: J(u) - J(u_h) \approx \frac{J(u_h - K^{-1} R) - J(u_h)}{1 - \ell}, \qquad
        \eta_K = \sum_{i \in K} |R_i \cdot (z - I z)_i|

    over the new nodes i of an element K, with the interpolant I of the mesh, and the part :math:`\ell` of the error that is
    left there: a sixteenth in theory `kirchhoff` and a quarter in `full`, more in elements at singular points where energies
    in rings about them say so. The difference of the two values contains all of the step that the linear
    weight :math:`-z \cdot R` has, and the terms of second order, which are all there is where the quantity is the energy.
    Conditions, of hinges and links, are met by the refined answer and by z; R is with their forces.

    Parameters
    ----------
    state : Solution
    quantity : Quantity
    backend : str
        Of the linear solver.
    halvings : Halvings
        Those of an estimate on a coarser mesh, which count where elements at singular points cannot be quartered often
        enough to have rings.
    progress : bool or callable
        A bar, nothing, or a function that is told of each part; see :class:`~skancf.Progress`.

    Raises
    ------
    InputError
        For what is no state or no quantity, and a mesh that is no quadtree.

    References
    ----------
    Becker and Rannacher (2001), Acta Numerica 10, 1-102.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> mesh = sk.meshes.quadtree(sk.meshes.uniform(plate.surface, 6, 6), plate.surface)
    >>> system = plate.on(mesh, "kirchhoff")
    >>> estimate = sk.goal_estimate(sk.solve_linear(system), sk.Displacement(at=(0.5, 0.5)))
    >>> print(f"{1000 * estimate.value:.5f} mm, missing {1000 * estimate.error:.5f} mm")
    -0.06578 mm, missing -0.00001 mm
    """
    state = check_state("state", state, backend)
    check_quantity(quantity)
    check_progress(progress)
    instance("halvings", halvings, Halvings, "what an estimate on a coarser mesh found, its halvings")
    value = value_of(quantity, state)
    with Bar("estimate", 3, progress) as bar, Enriched(state, quantity=quantity, backend=backend) as enriched:
        bar.next(f"refined to {enriched.system.mesh.nelements} elements")
        better = enriched.corrected
        bar.next("answer on the refined mesh")
        gradient = gradient_of(quantity, better)
        lift = quantity.lift(better) if hasattr(quantity, "lift") else None
        weight, pulls = enriched.solve_both(gradient, given_way(quantity, better, lift, enriched.rows))
        bar.next("dual weight")
        smooth = weight if lift is None else weight - lift
        indicators = enriched.shares(enriched.residual * enriched.surplus(smooth))
        if pulls.size:
            indicators = indicators + enriched.shares(enriched.pulled(pulls))
        answer, dual = of_state(better), small(enriched.system, smooth, better.about)
        halved = enriched.halvings((energies(answer), energies(dual)), before=halvings)
        scale = enriched.scale(smooth, dual, answer)
        if hasattr(quantity, "scale"):
            scale = max(scale, quantity.scale(better))
        return Estimate.seen(
            value, value_of(quantity, better), indicators, better, enriched.left(halved),
            rounding=enriched.rounding(weight, gradient, pulls), scale=scale, halvings=halved,
        )  # fmt: skip


def residual_indicator(state: Solution, *, backend: str = "auto") -> np.ndarray:
    r"""Energy that the residual has on the bubbles of elements and edges, (n_elements,) (J).

    .. math:: \eta_K^2 = \tfrac12 \sum_{i \in K} R_i \cdot K_{ii}^{-1} R_i

    over the nodes i that quartering puts in the middle of the element and of its edges: the element and edge terms of a
    residual estimate, weighted by the functions themselves, for any load, law and deformation. Both terms are those that the
    classical formulas bound by powers of the element size.

    References
    ----------
    Antolin, Buffa and Coradello (2020), Computer Methods in Applied Mechanics and Engineering 363, 112919.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> mesh = sk.meshes.quadtree(sk.meshes.uniform(plate.surface, 6, 6), plate.surface)
    >>> system = plate.on(mesh, "kirchhoff")
    >>> print(sk.residual_indicator(sk.solve_linear(system)).shape)
    (36,)
    """
    state = check_state("state", state, backend)
    with Enriched(state, state.system.mesh.refined(), backend=backend) as enriched:
        blocks = enriched.free_diagonal()
        r = enriched.system.layout.blocks(enriched.system.constraints.free_part(enriched.residual))
        steps = np.linalg.solve(blocks, r[:, :, None])[:, :, 0]
        return enriched.shares(0.5 * (r * steps * enriched.is_new()[:, None]).ravel())


def value_of(quantity: Quantity, state: Solution) -> float:
    """The number that a quantity is in a state, also one of the user's own."""
    return number("quantity.value", called("quantity.value", quantity.value, state))


def given_way(
    quantity: Any, state: Solution, lift: np.ndarray | None, rows: Callable[[np.ndarray], np.ndarray]
) -> np.ndarray:
    r"""By how much the dual weight changes the conditions, (n,): as the motion ``lift`` of supports does, by ``rows``, and
    by :math:`\partial J / \partial \lambda` of a quantity that depends on their multipliers."""
    out = np.zeros(state.system.conditions.n)
    if lift is not None and out.size:
        out = out + rows(lift)
    if hasattr(quantity, "by_multipliers"):
        name = "quantity.by_multipliers"
        out = out + vector(name, called(name, quantity.by_multipliers, state), out.size)
    return out


def gradient_of(quantity: Quantity, state: Solution) -> np.ndarray:
    return vector("quantity.gradient", called("quantity.gradient", quantity.gradient, state), state.system.n_dofs)
