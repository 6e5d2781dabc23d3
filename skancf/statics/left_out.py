"""What theory `kirchhoff` leaves out of frequencies and buckling loads."""

import numpy as np

from skancf.errors import warn
from skancf.solution import Solution
from skancf.statics.validity import THICK
from skancf.thinness import ShearForm, product_of, rotary_inertia, with_shear


def frequency_changes(state: Solution, eigenvalues: np.ndarray, shapes: np.ndarray) -> np.ndarray:
    """By which part of itself shear and rotary inertia change each frequency about a state, (n,).

    Eigenvalues (n,) and shapes (n, n_dofs) of unit modal mass; NaN where an eigenvalue is not positive.
    """
    system = state.system
    if not hasattr(system, "geometry") or system.geometry.theory.shear:
        return np.zeros(len(eigenvalues))
    start = system.undeformed
    at = state.about
    form, elastic = ShearForm(system), eigenvalues
    if not np.array_equal(state.q, start):
        plain = state.model.elastic(state.unknowns)
        elastic = np.array([2 * plain.energy(shape) for shape in shapes])
    out = np.full(len(eigenvalues), np.nan)
    for k in np.flatnonzero((eigenvalues > 0) & (elastic > 0)):
        value, shape = float(eigenvalues[k]), shapes[k]
        changed = with_shear(value, float(elastic[k]), product_of(form, at, shape), rotary_inertia(system, at, shape))
        out[k] = np.sqrt(max(changed, 0.0) / value) - 1
    return out


def buckling_changes(linear: Solution, shapes: np.ndarray) -> np.ndarray:
    r"""By which part of itself shear changes each buckling load, :math:`1 / (1 + F(\phi, \phi)) - 1` with
    :math:`\phi \cdot K_0 \phi = 1`, (n,)."""
    system = linear.system
    if not hasattr(system, "geometry") or system.geometry.theory.shear:
        return np.zeros(len(shapes))
    form = ShearForm(system)
    return np.array([with_shear(1.0, 1.0, product_of(form, system.undeformed, shape)) - 1 for shape in shapes])


def warn_of_changes(what: str, changes: np.ndarray) -> None:
    """A warning where theory `kirchhoff` leaves much out of a ``"frequency"`` or ``"buckling load"``, (n,) of them."""
    much = THICK / 2 if what == "frequency" else THICK  # a frequency is a root
    if not (np.abs(changes) > much).any():
        return
    worst = int(np.nanargmax(np.abs(changes)))
    left_out = "transverse shear" + " and rotary inertia" * (what == "frequency")
    warn(
        f"theory 'kirchhoff' leaves out {left_out}, which would lower the {what} number {worst} by about "
        f"{-100 * changes[worst]:.2g} % (over {100 * much:g} %): take theory 'full', or let theory='auto' choose"
    )
