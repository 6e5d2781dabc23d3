r"""Transverse shear forces of a thin state, from the equilibrium of its moments, :math:`Q^a = M^{ab}{}_{|b}`."""

import numpy as np

from skancf.elements.nodal import nodal_jacobian
from skancf.elements.quad_ancf import square_quadrature
from skancf.history import FULL, Case
from skancf.layout.geometry import Geometry
from skancf.layout.layout import nodal
from skancf.system.system import System
from skancf.terms.load import LoadTerm
from skancf.terms.shell import total
from skancf.theories.kirchhoff.point import dual
from skancf.theories.kirchhoff.theory import legendre, local_frame

BILINEAR = square_quadrature(2)
"""Points where the moments are taken, and their weights."""


def shear_forces(
    system: System,
    q: np.ndarray,
    moments: np.ndarray,
    points: np.ndarray,
    case: Case = FULL,
    elements: np.ndarray | None = None,
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
    case : Case
        Of the loads: a temperature change and eccentric weight have moments of their own.
    elements : (m,) int array, optional
        Those of the moments; default all.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> system = plate.on(sk.meshes.uniform(plate.surface, 6, 6), "kirchhoff")
    >>> Q = sk.solve_linear(system).shear_forces()
    >>> print(Q.shape)
    (36, 2, 1)
    """
    Q = balancing(system.geometry, moments, points, elements)
    more = coupled(system, q, points, case, elements)
    return Q if more is None else Q + more


def balancing(geometry: Geometry, moments: np.ndarray, points: np.ndarray, elements: np.ndarray | None = None) -> np.ndarray:
    """Shear forces (m, 2, n) at points (2, n) that balance moments (m, 3, 4), of some elements (m,) or of all."""
    elements = np.arange(geometry.n_elements) if elements is None else elements
    places, weights = BILINEAR
    fit = moments @ (weights[:, None] * legendre(places, (2, 2)))
    values = legendre(points, (2, 2))
    slopes = [legendre(points + d, (2, 2)) - values for d in (np.array([[1.0], [0.0]]), np.array([[0.0], [1.0]]))]
    m11, m22, m12 = (fit @ values.T).swapaxes(0, 1)
    by_parameter = np.stack([(fit @ slope.T).swapaxes(0, 1) for slope in slopes])  # bilinear: differences are exact
    e, along = _frame(geometry, points, elements)
    d1, d2 = np.einsum("fgep,gkep->fkep", along, by_parameter)
    w1, w2 = np.einsum("fgep,gep->fep", along, _frame_turn(geometry, points, e[1], elements))
    turned = m11 - m22
    return np.stack([d1[0] + d2[2] + w2 * turned - 2 * w1 * m12, d1[2] + d2[1] + w1 * turned + 2 * w2 * m12], axis=1)


def coupled(
    system: System, q: np.ndarray, points: np.ndarray, case: Case, elements: np.ndarray | None = None
) -> np.ndarray | None:
    """Shear forces (m, 2, n) that balance dead forces per area times their height above the surface (N/m); None where they
    act on it."""
    geometry = system.geometry
    elements = np.arange(geometry.n_elements) if elements is None else elements
    loads = [load.acting for load in system.loads if isinstance(load, LoadTerm)]
    couple = total(load.couple(case, points, elements) for load in loads)
    if couple is None:
        return None
    along = _frame(geometry, points, elements)[1]
    now = geometry.theory.jets(geometry.local(nodal(q)[: geometry.n_nodes], elements), points)[:2]
    return np.asarray(np.einsum(f"fgep,gkep,k{'ep' * (couple.ndim > 1)}->efp", along, now, couple))


def _frame(geometry: Geometry, points: np.ndarray, elements: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """e1 and e2, (2, 3, m, n), and their components along the reference square, (2, 2, m, n)."""
    jets = geometry.theory.jets(geometry.undeformed_local[elements], points)
    e = local_frame(jets, geometry.tangents(points, elements), geometry.side[elements])[:2]
    return e, np.einsum("fiep,giep->fgep", e, dual(jets))


def _frame_turn(geometry: Geometry, points: np.ndarray, e2: np.ndarray, elements: np.ndarray) -> np.ndarray:
    """e2 . e1,g for both directions of the reference square, (2, m, n); e1 is along X_x."""
    x, y = geometry.parameters(points, elements)
    first = geometry.surface.derivatives(x, y)[0]
    xx, xy, _ = geometry.surface.second_derivatives(x, y)
    jacobian = nodal_jacobian(geometry.mesh)[:, :, 0, elements, None]
    change = xx * jacobian[0][:, None] + xy * jacobian[1][:, None]
    return np.asarray((change * e2).sum(axis=1) / np.sqrt((first * first).sum(axis=0)))
