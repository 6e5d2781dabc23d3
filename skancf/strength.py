"""How much of its strength a material uses: yield, and failure of plies."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from skancf.arguments import STATE, choice, instance
from skancf.errors import InputError, finite, number, positive, shown, vector
from skancf.lines import ABOVE, checked_points
from skancf.materials import Laminate
from skancf.materials.heights import Interface
from skancf.point_values import PointValues
from skancf.showing import short
from skancf.solution import Solution
from skancf.tabular import Column, Tabular
from skancf.tensors import tresca, turned, von_mises

CRITERIA = ("tsai-wu", "tsai-hill", "max stress")
YIELD = ("von mises", "tresca")


@dataclass(frozen=True)
class Strength:
    """Strengths of a ply in its plane, along its fibres and across them.

    Parameters
    ----------
    tension, compression : (2,) tuple
        Along the fibres and across them, all positive (Pa).
    shear : float
        In the plane (Pa).
    interaction : float
        Of both directions in the criterion of Tsai and Wu, relative to the bound of its size, between -1 and 1.

    Raises
    ------
    InputError
        For strengths that are not positive, and an interaction out of range.

    Examples
    --------
    >>> carbon = sk.Strength((1500e6, 40e6), (1200e6, 246e6), 68e6)
    >>> used = carbon.used(np.array([750e6, 0.0, 0.0]), "max stress")
    >>> float(used)
    0.5
    """

    tension: tuple[float, float]
    compression: tuple[float, float]
    shear: float
    interaction: float = -0.5

    __repr__ = short

    def __post_init__(self) -> None:
        for name in ("tension", "compression"):
            for value in vector(name, getattr(self, name), 2):
                positive(name, value, "Pa")
        positive("shear", self.shear, "Pa")
        if not -1 < number("interaction", self.interaction) < 1:
            raise InputError(f"interaction = {self.interaction}: give a number between -1 and 1")

    def used(self, stress: np.ndarray, criterion: str = "tsai-wu") -> np.ndarray:
        r"""Which part of the strength stresses 11, 22, 12 in the axes of the ply use, (..., 3) to (...).

        It is the factor by which the strength would have to be divided for the stress to be on the limit, so that half of it
        is used under half of the load:

        - ``"max stress"``: the largest of :math:`\sigma_1 / X, \sigma_2 / Y, |\tau| / S`;
        - ``"tsai-hill"``: the root of :math:`(\sigma_1 / X)^2 - \sigma_1 \sigma_2 / X^2 + (\sigma_2 / Y)^2 + (\tau / S)^2`;
        - ``"tsai-wu"``: 1 / r with :math:`r^2 (F_{11} \sigma_1^2 + F_{22} \sigma_2^2 + 2 F_{12} \sigma_1 \sigma_2 + F_{66}
          \tau^2) + r (F_1 \sigma_1 + F_2 \sigma_2) = 1`, :math:`F_i = 1/X_t - 1/X_c`, :math:`F_{ii} = 1/(X_t X_c)`,
          :math:`F_{12} = f \sqrt{F_{11} F_{22}}` with the interaction f.

        Parameters
        ----------
        stress : (..., 3) array
        criterion : {"tsai-wu", "tsai-hill", "max stress"}

        Raises
        ------
        InputError
            For another name, and stresses of another shape.
        """
        choice("criterion", criterion, CRITERIA)
        stress = finite("stress", stress)
        if not stress.ndim or stress.shape[-1] != 3:
            raise InputError(f"stress of shape {stress.shape}: give components 11, 22, 12 in the axes of the ply, (..., 3)")
        return self.of(stress, criterion)

    def of(self, stress: np.ndarray, criterion: str) -> np.ndarray:
        """The same, unchecked; NaN where stress is."""
        s, (t, c) = np.moveaxis(stress, -1, 0), (np.array(self.tension), np.array(self.compression))
        if criterion != "tsai-wu":
            X, Y = (np.where(part > 0, t[k], c[k]) for k, part in enumerate(s[:2]))
            if criterion == "max stress":
                return np.asarray(np.max([np.abs(s[0]) / X, np.abs(s[1]) / Y, np.abs(s[2]) / self.shear], axis=0))
            square = (s[0] / X) ** 2 - s[0] * s[1] / X**2 + (s[1] / Y) ** 2 + (s[2] / self.shear) ** 2
            return np.asarray(np.sqrt(np.maximum(square, 0.0)))
        F1, F2 = 1 / t - 1 / c
        F11, F22 = 1 / (t * c)
        F12 = self.interaction * np.sqrt(F11 * F22)
        square = F11 * s[0] ** 2 + F22 * s[1] ** 2 + 2 * F12 * s[0] * s[1] + (s[2] / self.shear) ** 2
        linear = F1 * s[0] + F2 * s[1]
        return np.asarray(0.5 * (linear + np.sqrt(linear**2 + 4 * square)))


@dataclass(frozen=True, eq=False)
class Utilisation(Tabular):
    """Outcome of :func:`utilisation`; a table, see :class:`~skancf.tabular.Tabular`.

    Attributes
    ----------
    points : (n, 2) array
        Places of the parameter plane.
    values : (n,) array
        The largest part of the strength that is used through the thickness: one on the limit.
    z : (n,) array
        Height where that is (m).
    layer : (n,) int array
        Its layer, from the bottom on.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> system = plate.on(sk.meshes.uniform(plate.surface, 6, 6), "kirchhoff")
    >>> used = sk.utilisation(sk.solve_linear(system), 235e6)  # von Mises' stress against a yield stress
    >>> print(f"{100 * used.governing['value']:.1f} %")
    1.1 %
    """

    points: np.ndarray
    values: np.ndarray
    z: np.ndarray
    layer: np.ndarray

    __repr__ = short

    @property
    def governing(self) -> dict[str, Any]:
        """The largest value, with its place, height and layer."""
        k = int(np.nanargmax(self.values))
        return {"value": float(self.values[k]), "place": tuple(self.points[k].tolist()), "z": float(self.z[k]),
                "layer": int(self.layer[k])}  # fmt: skip

    def _table(self) -> dict[str, Column]:
        return {
            "x": (self.points[:, 0], ""), "y": (self.points[:, 1], ""), "utilisation": (self.values, ""),
            "z": (self.z, "m"), "layer": (self.layer, ""),
        }  # fmt: skip


def utilisation(state: Solution, strength: Any, *, criterion: str | None = None, at: Any = None) -> Utilisation:
    """Which part of its strength a plate or shell uses, the largest through the thickness.

    Of the Cauchy stresses at the faces of each layer; at nodes they are means over the elements that meet there. At
    re-entrant corners and point supports they grow without a limit as the mesh is refined.

    Parameters
    ----------
    state : Solution
    strength : float, Strength, or sequence of them
        A yield stress (Pa), or the :class:`Strength` of a ply; or one for each layer from the bottom on.
    criterion : str, optional
        Of yield stresses ``"von mises"`` (default) or ``"tresca"``; of plies ``"tsai-wu"`` (default), ``"tsai-hill"`` or
        ``"max stress"``.
    at : (2,) or (n, 2) numbers, optional
        Points of the parameter plane. Default: the nodes of the mesh.

    Returns
    -------
    Utilisation

    Raises
    ------
    InputError
        For strengths that are not as many as layers, a criterion of the other kind, and plies in zones or fields of their
        own, whose axes are not known.

    Examples
    --------
    >>> plate = sk.Problem(sk.Rectangle(1.0, 0.2), 0.01, sk.Isotropic(2e11, 0.0, 7800), [sk.Clamp("left")],
    ...                    [sk.EdgeLoad("right", (0, 0, 1000.0))])
    >>> solution = sk.solve_linear(plate.on(sk.meshes.uniform(plate.surface, 4, 1)))
    >>> found = sk.utilisation(solution, 240e6)
    >>> round(found.governing["value"], 4), found.governing["place"][0]
    (0.25, 0.0)
    """
    instance("state", state, Solution, STATE)
    points = state.system.mesh.p.T if at is None else checked_points(state.system, at, "at")
    values = PointValues(state, points)
    heights = values.heights
    n = len(heights) - 1
    limits, plies = _limits(strength, n)
    if criterion is None:
        criterion = "tsai-wu" if plies else "von mises"
    choice("criterion", criterion, CRITERIA if plies else YIELD)
    angles = _angles(state.system.problem, n) if plies else [0.0] * n
    found, where = [], []
    for k in range(n):
        for face, depth in ((k, Interface(k, ABOVE if k else 0.0)), (k + 1, Interface(k + 1))):
            stress = values.stress(depth).components
            found.append(_used(stress, limits[k], criterion, angles[k]))
            where.append((k, face))
    each = np.array(found)
    worst = np.argmax(np.where(np.isnan(each), -np.inf, each), axis=0)
    layer, face = np.array(where)[worst].T
    rows = np.arange(len(points))
    return Utilisation(points, each[worst, rows], heights[face, rows], layer)


def _used(stress: np.ndarray, limit: Any, criterion: str, angle: float) -> np.ndarray:
    if not isinstance(limit, Strength):
        return np.asarray((tresca if criterion == "tresca" else von_mises)(stress) / limit)
    c, s = np.cos(angle), np.sin(angle)
    to_ply = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    return limit.of(turned(stress, to_ply)[:, [0, 1, 5]], criterion)


def _limits(strength: Any, n: int) -> tuple[list[Any], bool]:
    """A strength for each of n layers, and whether they are those of plies."""
    given = list(strength) if isinstance(strength, Sequence) and not isinstance(strength, str) else [strength] * n
    if len(given) != n:
        raise InputError(f"strength = {shown(strength)}: has {len(given)} entries for {n} layers; give one for each, or one "
                         "for all")  # fmt: skip
    plies = [isinstance(each, Strength) for each in given]
    if any(plies) and not all(plies):
        raise InputError(f"strength = {shown(strength)}: give yield stresses for all layers, or a Strength for all")
    return (given if all(plies) else [positive("strength", each, "Pa") for each in given]), all(plies)


def _angles(problem: Any, n: int) -> list[float]:
    """Angles of the fibres of each layer to the first axis of the surface."""
    material = problem.material
    if problem.zones or callable(material):
        raise InputError("strength: plies of zones and of fields have axes of their own, which are not known here; take "
                         "stresses from solution.at(points).stress(z) and Strength.used for these")  # fmt: skip
    if isinstance(material, Laminate):
        return [float(getattr(layer.material, "angle", 0.0)) + float(layer.angle) for layer in material.layers]
    return [float(getattr(material, "angle", 0.0))] * n
