r"""Is the thin theory enough? What it leaves out, measured by what it knows.

A thin plate has no transverse shear strain, but its moments need transverse shear forces for equilibrium,
:math:`Q^a = M^{ab}{}_{|b}`. The energy they would have in a plate that yields to them, over the strain energy, is the
relative error of leaving shear out, known before any thick calculation.
"""

import warnings
from dataclasses import dataclass

import numpy as np

from skancf.assembly.geometry import Geometry
from skancf.assembly.system import System
from skancf.elements.nodal import nodal_jacobian
from skancf.elements.quad_ancf import square_quadrature
from skancf.errors import InputError, OutOfDepth, SingularMatrix, warn
from skancf.materials import Section
from skancf.theories.kirchhoff import legendre, local_frame
from skancf.theories.kirchhoff_point import dual
from skancf.vectors import cross

BILINEAR = square_quadrature(2)
"""Points where the moments are taken, and their weights."""


def shear_forces(
    system: System, q: np.ndarray, moments: np.ndarray, points: np.ndarray, factor: float = 1.0, time: float | None = None
) -> np.ndarray:
    r"""Transverse shear forces per length that balance the moments of a thin state: (n_elements, 2, n) (N/m).

    .. math::
        Q_1 = M_{11,1} + M_{12,2} + \omega_2 (M_{11} - M_{22}) - 2 \omega_1 M_{12} + s \cdot r_{,1}, \qquad
        Q_2 = M_{12,1} + M_{22,2} + \omega_1 (M_{11} - M_{22}) + 2 \omega_2 M_{12} + s \cdot r_{,2}

    in the local frame of the undeformed surface, which turns by :math:`\omega_a` per length along direction a; s is the
    force per area times its height, of weight whose centre is not in the reference surface. In each element the moments are
    bilinear through the 2 x 2 Gauss points, where those of the bicubic element are most accurate; the shear force is of
    second order in the middle of an element and of first order elsewhere.

    Parameters
    ----------
    q : (n_dofs,) array
    moments : (n_elements, 3, 4) array
        :math:`M_{11}, M_{22}, M_{12}` at the points :data:`BILINEAR`.
    points : (2, n) array
        Of the reference square.
    factor, time : float
        Of the loads: a temperature change and eccentric weight have moments of their own.
    """
    geometry, theory = system.geometry, system.geometry.theory
    places, weights = BILINEAR
    fit = moments @ (weights[:, None] * legendre(places, (2, 2)))
    values = legendre(points, (2, 2))
    slopes = [legendre(points + d, (2, 2)) - values for d in (np.array([[1.0], [0.0]]), np.array([[0.0], [1.0]]))]
    m11, m22, m12 = (fit @ values.T).swapaxes(0, 1)
    by_parameter = np.stack([(fit @ slope.T).swapaxes(0, 1) for slope in slopes])  # bilinear: differences are exact
    jets = theory.jets(geometry.undeformed_local, points)
    e1, e2, _ = local_frame(jets, geometry.tangents(points), geometry.side)
    along = np.einsum("fiep,giep->fgep", np.stack([e1, e2]), dual(jets))
    d1, d2 = np.einsum("fgep,gkep->fkep", along, by_parameter)
    w1, w2 = np.einsum("fgep,gep->fep", along, _frame_turn(geometry, points, e2))
    turned = m11 - m22
    Q = np.stack([d1[0] + d2[2] + w2 * turned - 2 * w1 * m12, d1[2] + d2[1] + w1 * turned + 2 * w2 * m12], axis=1)
    couple = system.couple(time)
    if couple is None:
        return Q
    now = theory.jets(geometry.local(q.reshape(-1, 4, 3)), points)[:2]
    return np.asarray(Q + factor * np.einsum("fgep,gkep,k->efp", along, now, couple))


def _frame_turn(geometry: Geometry, points: np.ndarray, e2: np.ndarray) -> np.ndarray:
    """e2 . e1,g for both directions of the reference square, (2, n_elements, n); e1 is along X_x."""
    x, y = geometry.parameters(points)
    first = geometry.surface.derivatives(x, y)[0]
    xx, xy, _ = geometry.surface.second_derivatives(x, y)
    jacobian = nodal_jacobian(geometry.mesh)[:, :, 0, :, None]
    change = xx * jacobian[0][:, None] + xy * jacobian[1][:, None]
    return np.asarray((change * e2).sum(axis=1) / np.sqrt((first * first).sum(axis=0)))


def shear_energy(system: System, Q: np.ndarray, weights: np.ndarray, points: np.ndarray) -> float:
    r"""Energy of shear forces (n_elements, 2, n) at points with weights (J).

    .. math:: \int \tfrac12 Q \cdot (k G t)^{-1} Q \, dA
    """
    geometry = system.geometry
    jets = geometry.theory.jets(geometry.undeformed_local, points)
    areas = np.linalg.norm(cross(jets[0], jets[1]), axis=0) * weights
    compliance = np.linalg.inv(system.problem.section.shear_stiffness())
    return float(0.5 * np.einsum("eip,ij,ejp,ep->", Q, compliance, Q, areas))


def shear_share(system: System, Q: np.ndarray, weights: np.ndarray, points: np.ndarray, energy: float, heat: float) -> float:
    """Energy of shear forces (n_elements, 2, n) over the strain energy; zero where a temperature change of the energy
    ``heat`` strains a body freely, so that both are rounding."""
    return 0.0 if energy <= FREE * heat else shear_energy(system, Q, weights, points) / energy


FREE = 1e-9
"""Of the energy of a temperature change that is held back: less than this is none."""


def warn_if_mass_is_off(system: System) -> None:
    """A warning where theory `kirchhoff` has mass in the reference surface that is more than a hundredth of the thickness
    off it."""
    if not (hasattr(system, "geometry") and system.geometry.theory.twist):
        return
    section = system.problem.section
    off = section.first_moment / section.mass if section.mass else 0.0
    if abs(off) > section.thickness / 100:
        warnings.warn(
            f"theory 'kirchhoff' has its mass in the reference surface, and the centre of mass is {off:.3g} m off, with a "
            f"thickness of {section.thickness:.3g} m: take the surface through it (offset of a laminate), or theory 'full' "
            "on a fine mesh",
            OutOfDepth,
            stacklevel=3,
        )


OFF = 0.25
"""Offset over thickness from which theory `full` needs more elements: a strip of 16 bends 1 % less at an offset of one
thickness, 12 % less at five."""


def warn_if_full_is_off(section: Section) -> None:
    r"""A warning where the stiffness of layers is so far off the surface that theory `full` locks on coarse meshes: by
    :math:`B_{ii} / A_{ii}`, which is the offset of layers of one material, over the thickness that bends."""
    abd, thickness = section.abd(), section.bending_thickness
    ratios = abd[:3, 3:].diagonal()[:2] / abd[:3, :3].diagonal()[:2]
    off = float(ratios[np.argmax(np.abs(ratios))])
    if abs(off) > OFF * thickness:
        warn(
            f"theory 'full' with the stiffness of its layers {off:.3g} m off the reference surface, and a thickness of "
            f"{thickness:.3g} m as far as bending goes, is too stiff on coarse meshes: refine until the answer stays, take "
            "the surface through their neutral surface (offset of a laminate), or theory 'kirchhoff', which is not, where "
            "the plate is thin"
        )


@dataclass(frozen=True)
class Choice:
    """Which theory was taken, and why.

    Attributes
    ----------
    theory : str
    share : float
        Energy of the shear forces over the strain energy of the small-deflection thin answer; NaN where there is none.
    reason : str
    """

    theory: str
    share: float
    reason: str


def choose(system: System, tolerance: float) -> Choice:
    """The cheapest theory whose modelling error is below a tolerance, from the small-deflection answer of the thin one.

    Raises
    ------
    InputError
        Where there is no such answer: a motion is free, or nothing strains the surface.
    """
    way_out = "name the theory, 'kirchhoff' or 'full'"
    try:
        change = system.linear_change()
    except SingularMatrix as free:
        raise InputError(f"theory = 'auto' judges by a static answer, and there is none ({free}); {way_out}") from free
    energy, heat = system.linear_energy(change), system.thermal_energy()
    if not (energy > 0 or heat > 0):
        raise InputError(f"theory = 'auto': nothing strains the surface, so that there is nothing to judge by; {way_out}")
    points, weights = BILINEAR
    moments = system.linearised(lambda q: system.section_forces(q, points)[:, 3:], change)
    Q = shear_forces(system, system.undeformed + change, moments, system.geometry.inside(points))
    share = shear_share(system, Q, weights, points, energy, heat)
    name, than = ("kirchhoff", "no more than") if share <= tolerance else ("full", "more than")
    reason = (f"theory '{name}': leaving transverse shear out changes the strain energy by {100 * share:.3g} %, "
              f"{than} the {100 * tolerance:.3g} % asked")  # fmt: skip
    return Choice(name, share, reason)
