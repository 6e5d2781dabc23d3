r"""A section on a curved surface: what layers off the reference surface, or of unlike stiffness, add to lamination theory.

Strain at a height, and the area there, are those of :mod:`skancf.materials.parallel`. The movement of the reference surface
is that of the layers there: by Poisson's ratio and by heat they grow thicker or thinner from there on, or from the face next
to it where they lie somewhere else. So a pressure on a face is right to first order where that is the reference surface.

The energy is taken about the neutral surface of the layers, at :math:`z_0`: that of lamination theory with the strains there
and the area :math:`\det \mu(z_0)`, and what is odd in the height above it to first order in the curvature. What is even,
a product of strain and curvature change in every section, is of the size that Love's first approximation leaves out, and is
left out as there: a section that is the same above and below has the law of lamination theory about its middle.

References
----------
W. T. Koiter, A consistent first approximation in the general theory of thin elastic shells, in *The Theory of Thin Elastic
Shells* (1960) 12-33.
"""

from collections.abc import Iterable
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from skancf.errors import InputError, warn
from skancf.materials.parallel import TRACE, area_at, curvature_at, principal_curvatures, strains_at, sums
from skancf.materials.section import IN_PLANE, Section
from skancf.showing import short
from skancf.tolerances import ROUNDED_PLACE

CURVED = 0.1
"""Thickness over radius from which it is said that the law is right to first order: at 0.1 a ring of fibres along it and
across is 0.4 % off in bending, and moves 6 % too little under a pressure that crushes the layer that is soft radially."""
MINUS = np.array([[-1.0, 0, 0], [0, -1.0, 0], [0, 0, -2.0]])
"""Strain 11, 22, 12 (doubled) that a unit of movement along the normal makes, per unit of curvature 11, 22, 12."""


class Rates(NamedTuple):
    """Derivatives by the curvatures 11, 22, 12 of what is integrated through the thickness.

    ``law`` (3, 6, 6), the odd part; ``stretch`` (3, 3, 3), strain per unit of curvature change that balances what of the law
    is left out; ``free`` (3, 6, 2), free strains per unit of temperature change and its gradient;
    ``left`` (3, 2, 2), twice the energy per area of layers that hold each other.
    """

    law: np.ndarray
    stretch: np.ndarray
    free: np.ndarray
    left: np.ndarray

    def __repr__(self) -> str:
        return short(self)


class CurvedSection:
    """A section at places with curvatures b, components 11, 22, 12 in the local frame, (..., 3) (1/m).

    One section for all of them, or, of a field, as many; heights z likewise are one number, or one for each place.
    """

    def __init__(self, section: Section):
        self.section, self.height = section, section.neutral
        self.own = section.about(self.height)

    @property
    def centred(self) -> bool:
        """Whether the law is that of lamination theory everywhere."""
        return not np.any(self.height) and (self.uniform or not self.rates.law.any())

    @property
    def uniform(self) -> bool:
        """Whether all layers have one stiffness, so that nothing is odd in the height."""
        stiffness = self.section.stiffness
        return bool((stiffness == np.take(stiffness, [0], axis=-3)).all())

    def law(self, b: np.ndarray) -> np.ndarray:
        """Stiffness for strain and curvature change of the reference surface, per its area: (..., 6, 6)."""
        abd = np.broadcast_to(self.section.abd(), (*b.shape[:-1], 6, 6))
        if not b.any() or self.centred:
            return abd
        own = self.own.abd() + _along(curvature_at(b, self.height), self.rates.law)
        turn = strains_at(b, self.height)
        law = turn.swapaxes(-1, -2) @ own @ turn * area_at(b, self.height)[..., None, None]
        flat = ~b.any(axis=-1)
        law[flat] = abd[flat]  # without the rounding of going there and back
        return np.asarray(law)

    def free_strains(self, b: np.ndarray, middle: np.ndarray, gradient: np.ndarray) -> np.ndarray:
        """Strain and curvature change that a temperature change T0 + z T1 makes without forces and moments: (..., 6).

        A size that grows changes the curvature too.
        """
        own = curvature_at(b, self.height)
        free = self._own_free(own, self._heat(middle, gradient))
        return np.asarray((strains_at(own, -self.height) @ free[..., None])[..., 0])

    def _own_free(self, own: np.ndarray, heat: np.ndarray) -> np.ndarray:
        """The same of the neutral surface and its curvatures, for :meth:`_heat`: (..., 6)."""
        free = np.asarray(times(self._flat[1], heat) + np.einsum("...i,...ikt,...t->...k", own, self.rates.free, heat))
        # What is between both surfaces grows by w, and the reference surface moves less by that along its normal, which
        # changes its curvature by w b b: of second order in b, but so is a change of shape by z0 / R of -alpha T b.
        by_strain, by_heat = self._levers_at(0.0 * self.height, np.clip(0.0, self.own.z[..., 0], self.own.z[..., -1]))
        grown = _product(free, by_strain) + _product(heat, by_heat)
        one, two, both = np.moveaxis(own, -1, 0)
        squared = np.stack([one**2 + both**2, two**2 + both**2, 2 * both * (one + two)], axis=-1)
        free[..., 3:] -= grown[..., None] * squared
        return free

    def energy_left(self, b: np.ndarray, middle: np.ndarray, gradient: np.ndarray) -> np.ndarray:
        """Energy per area of the reference surface of layers that hold each other at those strains, (...) (J/m2)."""
        heat, own = self._heat(middle, gradient), curvature_at(b, self.height)
        left = self._flat[2] + _along(own, self.rates.left)
        return np.asarray(0.5 * np.einsum("...s,...st,...t->...", heat, left, heat) * area_at(b, self.height))

    def masses(self, b: np.ndarray) -> np.ndarray:
        """Mass and its first moment per area of the reference surface, that at the centre of mass: (2, ...)."""
        section = self.section
        off = section.first_moment / section.mass
        mass = section.mass * area_at(b, off)
        return np.stack([mass, off * mass])

    def strain_at(self, b: np.ndarray, z: Any, strains: np.ndarray, heat: np.ndarray | None) -> np.ndarray:
        r"""Strain 11, 22, 12 at a height, of strains (..., 6) of the reference surface and T0, T1 (2, ...): (..., 3).

        With what the change of the thickness between that surface and the height adds, and with the stretch that balances
        bending: a bent ring carries no force where its middle is stretched by :math:`\kappa h^2 / 12 R`, of which the law
        knows nothing, and which is of first order in the stress at its faces.
        """
        own_b = curvature_at(b, self.height)
        own = (strains_at(b, self.height) @ strains[..., None])[..., 0]
        by_strain, by_heat = self._levers_at(z - self.height, z - self.height)
        moved, bent = _product(own, by_strain), own[..., 3:]
        if heat is not None:
            change = self._heat(*heat)
            moved, bent = moved + _product(change, by_heat), bent - self._own_free(own_b, change)[..., 3:]
        stretched = own[..., :3] + np.einsum("...i,...ijk,...k->...j", own_b, self.rates.stretch, bent)
        own = np.concatenate([stretched, own[..., 3:]], axis=-1)
        there = (strains_at(own_b, z - self.height)[..., :3, :] @ own[..., None])[..., 0]
        return np.asarray(there + moved[..., None] * (curvature_at(b, z) @ MINUS))

    def forces(self, b: np.ndarray, stresses: np.ndarray) -> np.ndarray:
        r"""Membrane forces and moments per length of the reference surface from what does work on its strains: (..., 6).

        Work on the strain has :math:`N + \tfrac12 (b M + M b)`, because bending a curved surface strains it at a height.
        """
        membrane = stresses[..., :3] - 0.5 * (sums(b).swapaxes(-1, -2) @ stresses[..., 3:, None])[..., 0]
        return np.concatenate([membrane, stresses[..., 3:]], axis=-1)

    def check(self, b: np.ndarray) -> None:
        """Whether curvatures are small enough against the layers' heights.

        Raises
        ------
        InputError
            Where layers, or the way to them, reach beyond a centre of curvature.
        """
        if not b.any() or self.centred:
            return
        section, principal = self.section, principal_curvatures(b)
        require_one_side(principal, [section.z[..., 0], section.z[..., -1], self.height])
        ratio = (section.thickness * np.abs(principal / (1 - self.height * principal))).max(initial=0.0)
        if ratio > CURVED:
            warn(
                "theory 'kirchhoff' has layers off the reference surface, or of unlike stiffness, right to first order in "
                f"thickness over radius, which is {ratio:.3g} here (over {CURVED:g}): stiffness is uncertain by about half "
                f"of its square, {50 * ratio**2:.2g} %, and more under pressure that crushes layers which are soft across; "
                "theory 'full' on a fine mesh integrates over the thickness"
            )

    def _heat(self, middle: np.ndarray, gradient: np.ndarray) -> np.ndarray:
        """Temperature change at the neutral surface and its gradient, (..., 2)."""
        return np.stack([middle + self.height * gradient, np.asarray(gradient, dtype=float)], axis=-1)

    @cached_property
    def _points(self) -> tuple[np.ndarray, ...]:
        """Heights above the neutral surface, weights, layers, Q and alpha at Gauss points that integrate exactly."""
        z, w, layer = self.own.points(3)
        Q, alpha = np.take(self.own.in_plane(), layer, axis=-3), np.take(self.own.expansion, layer, axis=-2)
        return z, w, np.broadcast_to(layer, z.shape), Q, alpha[..., IN_PLANE]

    def _levers_at(self, z: Any, within: Any) -> tuple[np.ndarray, np.ndarray]:
        """The same at one height for each place, in the layer at another one: (6,) and (2,)."""
        layer = self.own.layer_at(within)
        by_strain, by_heat = self._levers(np.asarray(z)[..., None], layer[..., None])
        return by_strain[..., 0, :], by_heat[..., 0, :]

    def _levers(self, z: np.ndarray, layer: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Movement along the normal, against the reference surface, by the change of thickness: at heights (n,) above the
        neutral surface.

        Per unit of strain and curvature change, (n, 6), and of temperature change and its gradient, (n, 2). What is between
        layers and a reference surface outside of them keeps its length.
        """
        own = self.own
        thermal = own.expansion[..., 2] - np.einsum("...li,...li->...l", own.thinning, own.expansion[..., IN_PLANE])
        of_layers = np.concatenate([own.thinning, thermal[..., None]], axis=-1)
        start = np.clip(-np.asarray(self.height), own.z[..., 0], own.z[..., -1])[..., None]
        parts = [_between(of_layers, own.z, start, z, layer, power) for power in (1, 2)]
        by_strain, by_heat = [part[..., :3] for part in parts], [part[..., 3] for part in parts]
        return np.concatenate(by_strain, axis=-1), np.stack(by_heat, axis=-1)

    @cached_property
    def _flat(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Resultants and free strains, each (6, 2), per unit of temperature change and gradient; twice the energy left."""
        z, w, _, Q, alpha = self._points
        strain, free = _of_section(z), alpha[..., None] * np.stack([np.ones_like(z), z], axis=-1)[..., None, :]
        resultants = _integral(w, strain, Q, free)
        strains = np.linalg.solve(self.own.abd(), resultants)
        held = free - strain @ strains[..., None, :, :]
        return resultants, strains, _integral(w, held, Q, held)

    @cached_property
    def rates(self) -> Rates:
        z, w, layer, Q, alpha = self._points
        flat, of_law, abd = _of_section(z), [], self.own.abd()
        by_strain, by_heat = self._levers(z, layer)
        free = alpha[..., None] * np.stack([np.ones_like(z), z], axis=-1)[..., None, :]
        _, strains, _ = self._flat
        held = free - flat @ strains[..., None, :, :]
        of_free, of_left, of_stretch = [], [], []
        for unit, minus, shrinks in zip(sums(np.eye(3)), MINUS, TRACE, strict=True):
            change = np.concatenate([np.multiply.outer(z, unit), np.multiply.outer(z * z / 2, unit)], axis=-1)
            change = change + minus[:, None] * by_strain[..., None, :]
            moved = -minus[:, None] * by_heat[..., None, :]
            one = _integral(w, flat, Q, change)
            law = one + one.swapaxes(-1, -2) - shrinks * _integral(w * z, flat, Q, flat)
            kept = _odd(law, abd, self.own.thickness)
            of_law.append(kept)
            of_stretch.append(np.linalg.solve(abd[..., :3, :3], (kept - law)[..., :3, 3:]))
            resultants = _integral(w, change, Q, free) + _integral(w, flat, Q, moved)
            resultants = resultants - shrinks * _integral(w * z, flat, Q, free)
            of_free.append(np.linalg.solve(abd, resultants - law @ strains))
            more = _integral(w, held, Q, moved - change @ strains[..., None, :, :])
            of_left.append(more + more.swapaxes(-1, -2) - shrinks * _integral(w * z, held, Q, held))
        return Rates(*(np.stack(each, axis=-3) for each in (of_law, of_stretch, of_free, of_left)))


def require_one_side(principal: np.ndarray, heights: Iterable[Any]) -> None:
    """InputError where heights, each a number or one for each place, are past a centre of curvature of a surface with these
    principal curvatures, (2, ...)."""
    for z in heights:
        shrunk = 1 - z * principal
        if shrunk.min(initial=1.0) <= 0:
            worst = np.unravel_index(np.argmin(shrunk), shrunk.shape)
            height = float(np.broadcast_to(z, shrunk.shape)[worst])
            raise InputError(
                f"material: layers at the height {height:.6g} m are past a centre of curvature of the surface, whose "
                f"radii go down to {1 / np.abs(principal).max():.6g} m: take the surface nearer to them (its offset)"
            )


def _along(b: np.ndarray, rates: np.ndarray) -> np.ndarray:
    """Sum of rates (3, n, n) times the components of curvatures (..., 3): (..., n, n)."""
    return np.tensordot(b, rates, 1) if rates.ndim == 3 else np.einsum("...i,...ijk->...jk", b, rates)


def times(matrix: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """One matrix, or one for each place, times vectors (..., n)."""
    return vectors @ matrix.T if matrix.ndim == 2 else (matrix @ vectors[..., None])[..., 0]


def _product(vectors: np.ndarray, row: np.ndarray) -> np.ndarray:
    """Vectors (..., n) times one row, or one for each place: (...)."""
    return np.asarray(vectors @ row if row.ndim == 1 else (vectors * row).sum(axis=-1))


def _of_section(z: np.ndarray) -> np.ndarray:
    """From strain and curvature change to the strain at heights (n,): (n, 3, 6)."""
    return np.concatenate([np.broadcast_to(np.eye(3), (*z.shape, 3, 3)), np.multiply.outer(z, np.eye(3))], axis=-1)


def _integral(w: np.ndarray, a: np.ndarray, Q: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.asarray((a.swapaxes(-1, -2) @ (w[..., None, None] * Q) @ b).sum(axis=-3))


def _between(
    of_layers: np.ndarray, faces: np.ndarray, start: np.ndarray, z: np.ndarray, layer: np.ndarray, power: int
) -> np.ndarray:
    """Integrals from a start (1,) to heights z in their layers of what is constant in layers (n, k), times z^(power - 1)."""
    powers, axis = faces**power / power, faces.ndim - 1
    whole = np.cumsum(np.diff(powers)[..., None] * of_layers, axis=axis)
    whole = np.concatenate([np.zeros_like(whole[..., :1, :]), whole], axis=axis)

    def up_to(z: np.ndarray, layer: np.ndarray) -> np.ndarray:
        layer = np.broadcast_to(layer, z.shape)
        whole_below, rate = (np.take_along_axis(each, layer[..., None], axis) for each in (whole, of_layers))
        return whole_below + (z**power / power - np.take_along_axis(powers, layer, axis))[..., None] * rate

    return np.asarray(up_to(z, layer) - up_to(start, (faces[..., 1:-1] < start).sum(axis=-1)[..., None]))


def _odd(law: np.ndarray, abd: np.ndarray, thickness: Any) -> np.ndarray:
    """A rate of the law without the product of the strain where bending strains nothing, and curvature change."""
    lever = np.linalg.solve(abd[..., :3, :3], abd[..., :3, 3:])
    A, B, D = law[..., :3, :3], law[..., :3, 3:], law[..., 3:, 3:]
    transposed = lever.swapaxes(-1, -2)
    mixed = B.swapaxes(-1, -2) @ lever
    bending = D - mixed - mixed.swapaxes(-1, -2) + 2 * transposed @ A @ lever
    out = np.block([[A, A @ lever], [transposed @ A, bending]])
    scale = np.sqrt(np.diagonal(abd, axis1=-2, axis2=-1))
    rounding = ROUNDED_PLACE * np.asarray(thickness)[..., None, None] * (scale[..., :, None] * scale[..., None, :])
    return np.where(np.abs(out) > rounding, out, 0.0)
