r"""Compiled parts of theory `kirchhoff` for laws at points: the strains that a law sees, and what its stresses are on all.

The law sees the assumed membrane strains and the curvatures, :math:`\hat\varepsilon`, in the local frame of the undeformed
surface. What it answers there goes back to the covariant strains, with the weights of the points: with the matrix T from
those to local ones, :math:`T^T S` and :math:`T^T D\, T`. The rest of the membrane strains has the law of the undeformed
state, R, so that the energy is

.. math:: \sum_p w_p\, \psi(T \hat\varepsilon_p) + \tfrac12 (\varepsilon - \hat\varepsilon)_p \cdot R_p
    (\varepsilon - \hat\varepsilon)_p .
"""

from typing import NamedTuple

import numpy as np

from skancf.compiled import INNER, OPTIONS, compiled
from skancf.kernels.constants import AXES, FUNCTIONS, POINTS
from skancf.kernels.gather import gather
from skancf.kernels.panels import add_panel, set_panel
from skancf.showing import short
from skancf.theories.kirchhoff.kernels import (
    JETS,
    N_MEMBRANE,
    N_STRAINS,
    PROJECTION,
    PROJECTIONS,
    add_change,
    gauss_slopes,
    jets,
    sampled_strains,
    surface,
)
from skancf.theories.kirchhoff.kernels import strains as strains_of


class Places(NamedTuple):
    """What classes of equal undeformed elements share, besides :class:`~skancf.theories.kirchhoff.kernels.Elements`.

    ``turn`` (n_shapes, 3, 3, 16), from covariant membrane strains to local ones, ``side`` (n_shapes,), by which curvatures
    are multiplied more, ``areas`` (n_shapes, 16), ``rest`` (n_shapes, 3, 3, 16), the law of the rest with the weights.
    """

    turn: np.ndarray
    side: np.ndarray
    areas: np.ndarray
    rest: np.ndarray

    def __repr__(self) -> str:
        return short(self)


@compiled(**INNER)
def element_strains(e, q, change, tables, maps, elements, local, moved, x, y, n, duals, gamma, eps):
    """Strains (6 or 9, 16) of an element, extrapolated linearly along a ``change``, (0, 4, 3) for none."""
    c = elements.shape[e]
    kind, assumed, reference = elements.points[c], elements.assumed[c], elements.reference[c]
    gather(e, q, maps, local)
    jets(tables, kind, local, x)
    surface(x, n, duals, gamma)
    strains_of(x, n, reference, eps)
    if change.shape[0]:
        gather(e, change, maps, moved)
        jets(tables, kind, moved, y)
        add_change(x, y, n, gamma, eps)
    if kind > 0 and assumed > 0:
        y[:] = 0.0
        if change.shape[0]:
            gauss_slopes(tables, moved, y)
        gauss_slopes(tables, local, x)
        sampled_strains(x, y, reference, eps)
    else:
        eps[N_STRAINS:] = 0.0


@compiled(**INNER)
def assume(tables, kind, assumed, eps, hat):
    """The strains that the law is applied to, hat (6, 16): assumed membrane strains with the curvatures.

    Assumed ones of own points are made of those at the Gauss points, the last three of the strains (6 or 9, 16).
    """
    hat[3:] = eps[3:N_STRAINS]
    first = N_STRAINS * POINTS if kind > 0 and assumed > 0 else 0
    for c in range(N_MEMBRANE):
        at = PROJECTIONS * assumed + PROJECTION * c
        set_panel(1, POINTS, eps, first + POINTS * c, 1, 0, tables.projections, at, POINTS, hat, POINTS * c, POINTS)


@compiled(**INNER)
def spread(tables, kind, assumed, stress, extra, hat):
    """From stresses that do work on the strains of the law, and those on the rest of the membrane strains, ``extra``
    (3, 16), to those on all strains, in place; ``hat`` is scratch."""
    first = N_STRAINS * POINTS if kind > 0 and assumed > 0 else 0
    for c in range(N_MEMBRANE):
        at = PROJECTIONS * assumed + PROJECTION * c
        for p in range(POINTS):
            hat[c, p] = stress[c, p] - extra[c, p]
        stress[c] = extra[c]
        add_panel(1, POINTS, hat, POINTS * c, 1, 0, tables.transposed, at, POINTS, stress, first + POINTS * c, POINTS)


@compiled(**OPTIONS)
def strains(start, stop, order, q, change, tables, maps, elements, places, all_out, hat_out, law_out):
    """All strains, extrapolated linearly along ``change``, (n_elements, 6 or 9, 16), those that the law sees (n_elements,
    6, 16), and these in the local frame, (6, n_elements, 16), or nowhere if that is empty."""
    local, moved = np.empty((FUNCTIONS, AXES)), np.empty((FUNCTIONS, AXES))
    x, y = np.empty((AXES, JETS)), np.empty((AXES, JETS))
    n, duals, gamma = np.empty((AXES, POINTS)), np.empty((2, AXES, POINTS)), np.empty((3, 2, POINTS))
    eps, hat = np.zeros((all_out.shape[1], POINTS)), np.empty((N_STRAINS, POINTS))
    for index in range(start, stop):
        e = order[index]
        c = elements.shape[e]
        element_strains(e, q, change, tables, maps, elements, local, moved, x, y, n, duals, gamma, eps)
        assume(tables, elements.points[c], elements.assumed[c], eps, hat)
        all_out[e], hat_out[e] = eps, hat
        if law_out.shape[1]:
            to_local(places.turn[c], places.side[c], hat, law_out[:, e])


@compiled(**INNER)
def to_local(turn, side, hat, out):
    """Local strains (6, 16) of covariant ones (6, 16)."""
    for p in range(POINTS):
        for k in range(3):
            membrane = bent = 0.0
            for l in range(3):
                membrane += turn[k, l, p] * hat[l, p]
                bent += turn[k, l, p] * hat[3 + l, p]
            out[k, p], out[3 + k, p] = membrane, side * bent


@compiled(**OPTIONS)
def to_covariant(start, stop, order, forces, stiffness, pairs, elements, places, stress_out, law_out):
    """Stresses (n_elements, 6, 16) on the strains that the law sees, and entries of their law (n_elements, 21, 16), with the
    weights, from section forces (6, n_elements, 16) and entries of their stiffness (21, n_elements, 16), local ones."""
    local = np.empty((N_STRAINS, N_STRAINS))
    half, whole = np.empty((N_STRAINS, N_STRAINS)), np.empty((N_STRAINS, N_STRAINS))
    for index in range(start, stop):
        e = order[index]
        c = elements.shape[e]
        turn, side = places.turn[c], places.side[c]
        for p in range(POINTS):
            area = places.areas[c, p]
            for k in range(3):
                membrane = bent = 0.0
                for l in range(3):
                    membrane += turn[l, k, p] * forces[l, e, p]
                    bent += turn[l, k, p] * forces[3 + l, e, p]
                stress_out[e, k, p], stress_out[e, 3 + k, p] = area * membrane, area * side * bent
            for m in range(pairs.shape[0]):
                k, l = pairs[m]
                local[k, l] = local[l, k] = stiffness[m, e, p]
            for row in range(N_STRAINS):
                for k in range(3):
                    membrane = bent = 0.0
                    for l in range(3):
                        membrane += local[row, l] * turn[l, k, p]
                        bent += local[row, 3 + l] * turn[l, k, p]
                    half[row, k], half[row, 3 + k] = area * membrane, area * side * bent
            for column in range(N_STRAINS):
                for k in range(3):
                    membrane = bent = 0.0
                    for l in range(3):
                        membrane += turn[l, k, p] * half[l, column]
                        bent += turn[l, k, p] * half[3 + l, column]
                    whole[k, column], whole[3 + k, column] = membrane, side * bent
            for m in range(pairs.shape[0]):
                law_out[e, m, p] = whole[pairs[m, 0], pairs[m, 1]]


@compiled(**OPTIONS)
def stresses(start, stop, order, law_stress, everything, hat, tables, elements, places, out):
    """Stresses on all strains (n_elements, 6 or 9, 16): those on the strains that the law sees (n_elements, 6, 16), and that
    of the rest of the membrane strains, from all strains and those that the law sees."""
    extra, scratch = np.empty((N_MEMBRANE, POINTS)), np.empty((N_STRAINS, POINTS))
    for index in range(start, stop):
        e = order[index]
        c = elements.shape[e]
        stress = out[e]
        stress[:N_STRAINS], stress[N_STRAINS:] = law_stress[e], 0.0
        for k in range(N_MEMBRANE):
            for p in range(POINTS):
                total = 0.0
                for l in range(N_MEMBRANE):
                    total += places.rest[c, k, l, p] * (everything[e, l, p] - hat[e, l, p])
                extra[k, p] = total
        spread(tables, elements.points[c], elements.assumed[c], stress, extra, scratch)
