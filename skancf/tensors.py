r"""Symmetric tensors of stress and strain: principal values, equivalent stresses, turns.

Components are in the order 11, 22, 33, 23, 13, 12 on the last axis.
"""

from typing import Any

import numpy as np

from skancf.errors import InputError, finite

ROWS, COLUMNS = [0, 1, 2, 1, 0, 0], [0, 1, 2, 2, 2, 1]
"""Of the components."""


def tensors(voigt: np.ndarray, doubled: float = 1.0) -> np.ndarray:
    """Symmetric tensors (..., 3, 3) of components (..., 6), whose shear entries are ``doubled`` times too large."""
    out = np.empty((*voigt.shape[:-1], 3, 3))
    out[..., ROWS, COLUMNS] = out[..., COLUMNS, ROWS] = voigt / ([1.0] * 3 + [doubled] * 3)
    return out


def components(tensor: np.ndarray) -> np.ndarray:
    """Components (..., 6) of symmetric tensors (..., 3, 3)."""
    return np.asarray(tensor[..., ROWS, COLUMNS])


def cauchy(stress: np.ndarray, strain: np.ndarray) -> np.ndarray:
    r"""Cauchy stress :math:`U S U / \det U` with :math:`U^2 = 1 + 2 E`, of second Piola-Kirchhoff stress and Green-Lagrange
    strain with doubled shear entries, (..., 6) each, in a frame that turns with the material."""
    squares, axes = np.linalg.eigh(np.eye(3) + 2 * tensors(strain, 2.0))
    stretches = np.sqrt(np.where(squares > 0, squares, np.nan))
    U = np.einsum("...ik,...k,...jk->...ij", axes, stretches, axes)
    return components(U @ tensors(stress) @ U / stretches.prod(axis=-1)[..., None, None])


def turned(stress: np.ndarray, R: np.ndarray) -> np.ndarray:
    r"""Components of :math:`R \sigma R^T`, (..., 6), with matrices (..., 3, 3)."""
    return components(R @ tensors(stress) @ np.swapaxes(R, -1, -2))


def checked(stress: Any) -> np.ndarray:
    """Stresses (..., 6), checked."""
    # Where a law has no stress it is NaN.
    array = stress if isinstance(stress, np.ndarray) and stress.dtype == float else finite("stress", stress)
    if not array.ndim or array.shape[-1] != 6:
        raise InputError(f"stress of shape {array.shape}: give components 11, 22, 33, 23, 13, 12 on the last axis, (..., 6)")
    return array


def von_mises(stress: np.ndarray) -> np.ndarray:
    r"""Von Mises' equivalent of stresses in the order 11, 22, 33, 23, 13, 12: (..., 6) to (...), same unit.

    .. math:: \sigma_v^2 = \tfrac12 [(S_{11} - S_{22})^2 + (S_{22} - S_{33})^2 + (S_{33} - S_{11})^2]
                           + 3 (S_{23}^2 + S_{13}^2 + S_{12}^2)

    Of the second Piola-Kirchhoff stress it is the usual one where strains are small, however large rotations are.

    Parameters
    ----------
    stress : (..., 6) array

    Raises
    ------
    InputError
        For an array of another shape.

    Examples
    --------
    >>> float(sk.output.von_mises(np.array([100.0, 0.0, 0.0, 0.0, 0.0, 0.0])))
    100.0
    """
    s11, s22, s33, s23, s13, s12 = np.moveaxis(checked(stress), -1, 0)
    return np.sqrt(0.5 * ((s11 - s22) ** 2 + (s22 - s33) ** 2 + (s33 - s11) ** 2) + 3 * (s23**2 + s13**2 + s12**2))


def principal_stresses(stress: np.ndarray) -> np.ndarray:
    r"""Principal stresses :math:`\sigma_1 \ge \sigma_2 \ge \sigma_3` of stresses (..., 6): (..., 3), same unit.

    Of plane stress, :math:`S_{33} = S_{23} = S_{13} = 0`, one of them is exactly zero, and the others are

    .. math:: \tfrac12 (S_{11} + S_{22}) \pm \sqrt{\tfrac14 (S_{11} - S_{22})^2 + S_{12}^2} .

    Parameters
    ----------
    stress : (..., 6) array
        In the order 11, 22, 33, 23, 13, 12.

    Raises
    ------
    InputError
        For an array of another shape.

    Examples
    --------
    >>> sk.output.principal_stresses(np.array([0.0, 0.0, 0.0, 0.0, 0.0, 5.0]))  # pure shear
    array([ 5.,  0., -5.])
    """
    stress = checked(stress)
    s11, s22, s33, s23, s13, s12 = np.moveaxis(stress, -1, 0)
    middle, radius = 0.5 * (s11 + s22), np.hypot(0.5 * (s11 - s22), s12)
    plane = np.sort(np.stack([middle + radius, np.zeros_like(middle), middle - radius], axis=-1), axis=-1)[..., ::-1]
    known = np.isfinite(stress).all(axis=-1)
    out = np.where(known[..., None], plane, np.nan)
    general = ((s33 != 0) | (s23 != 0) | (s13 != 0)) & known
    if general.any():
        out[general] = np.linalg.eigvalsh(tensors(stress[general]))[..., ::-1]
    return out


def principal_directions(stress: np.ndarray) -> np.ndarray:
    """Unit vectors (..., 3, 3) along which the principal stresses act, a row for each, in the frame of the components.

    Their signs mean nothing. Of equal principal stresses any two at right angles in their plane are as good.

    Parameters
    ----------
    stress : (..., 6) array
        In the order 11, 22, 33, 23, 13, 12.

    Raises
    ------
    InputError
        For an array of another shape.

    Examples
    --------
    >>> rows = sk.output.principal_directions(np.array([1.0, 3.0, 2.0, 0.0, 0.0, 0.0]))
    >>> np.abs(rows)
    array([[0., 1., 0.],
           [0., 0., 1.],
           [1., 0., 0.]])
    """
    stress = checked(stress)
    known = np.isfinite(stress).all(axis=-1)
    axes = np.linalg.eigh(tensors(np.where(known[..., None], stress, 0.0)))[1]
    rows = np.swapaxes(axes, -1, -2)[..., ::-1, :]
    return np.asarray(np.where(known[..., None, None], rows, np.nan))


def tresca(stress: np.ndarray) -> np.ndarray:
    r"""Tresca's equivalent :math:`\sigma_1 - \sigma_3`, twice the largest shear stress, of stresses (..., 6): (...).

    Parameters
    ----------
    stress : (..., 6) array
        In the order 11, 22, 33, 23, 13, 12.

    Raises
    ------
    InputError
        For an array of another shape.

    Examples
    --------
    >>> float(sk.output.tresca(np.array([100.0, -50.0, 0.0, 0.0, 0.0, 0.0])))
    150.0
    """
    values = principal_stresses(stress)
    return np.asarray(values[..., 0] - values[..., 2])


def signed_von_mises(stress: np.ndarray) -> np.ndarray:
    """Von Mises' equivalent with the sign of the principal stress of the largest size: (..., 6) to (...).

    Negative where the material is mostly compressed.

    Parameters
    ----------
    stress : (..., 6) array
        In the order 11, 22, 33, 23, 13, 12.

    Raises
    ------
    InputError
        For an array of another shape.

    Examples
    --------
    >>> float(sk.output.signed_von_mises(np.array([-100.0, 0.0, 0.0, 0.0, 0.0, 0.0])))
    -100.0
    """
    values = principal_stresses(stress)
    return np.asarray(np.where(values[..., 0] + values[..., 2] < 0, -1.0, 1.0) * von_mises(stress))
