"""What a viewer shows, decided without a window: which states, fields, depths, and what is drawn of a choice of them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from skancf.materials import Section
from skancf.materials.heights import DEPTHS
from skancf.output.colours import colour_limits
from skancf.output.fields import FORCES, SHEAR, STRAINS, STRESSES, through, values
from skancf.output.frames import Frame, Survey, frame_of, survey
from skancf.output.reels import Reel, reel_of
from skancf.output.style import Style
from skancf.solution import Solution

FACES = ("top", "middle", "bottom")
assert set(FACES) == set(DEPTHS)


@dataclass(frozen=True)
class Look:
    """What is chosen of what can be seen.

    Attributes
    ----------
    state : int
        Number of the state, from 0.
    phase : float
        Of the swing of a mode (degrees).
    face : str
        ``"top"``, ``"middle"`` or ``"bottom"``: where stresses and strains are drawn.
    field, scale, show_mesh, show_undeformed
        As in :class:`~skancf.output.Style`.
    """

    state: int = 0
    phase: float = 90.0
    field: str = "displacement"
    face: str = "top"
    scale: float = 1.0
    show_mesh: bool = True
    show_undeformed: bool = True


class Show:
    """States to look at in a style, with the choices that there are.

    Parameters
    ----------
    states : Solution, sequence of Solution, result, Motion, PathResult, Modes or BucklingResult
    **options
        Of :class:`~skancf.output.Style`: what is chosen at first.
    """

    def __init__(self, states: Any, **options: Any) -> None:
        self.style = Style(**options)
        self.reel: Reel = reel_of(states)
        self.fields = fields_of(self.reel.states, self.style.field)
        self._limits: dict[tuple[str, str, int], tuple[float, float]] = {}

    @property
    def first(self) -> Look:
        """The choice at the beginning: the only state, the first mode, the last state of a path or motion."""
        style, modes = self.style, self.reel.rest is not None
        face = style.z if style.z in FACES else "top"
        return Look(0 if modes else len(self.reel.states) - 1, 90.0, style.field, str(face), style.scale, style.show_mesh,
                    style.show_undeformed)  # fmt: skip

    def styled(self, look: Look) -> Style:
        """The style of a picture of a choice."""
        z = look.face if through(look.field) else None
        return replace(self.style, field=look.field, z=z, scale=look.scale, show_mesh=look.show_mesh,
                       show_undeformed=look.show_undeformed)  # fmt: skip

    def frame(self, look: Look) -> Frame:
        """Points, colours and lines of a choice; the title names the state."""
        frame = frame_of(self.reel.at(look.state, look.phase), self.styled(look))
        name = self.reel.names[look.state]
        return frame if name in frame.title or not frame.title else replace(frame, title=f"{frame.title}, {name}")

    def limits(self, look: Look) -> tuple[float, float]:
        """Limits of the colours: of all states, so that colours can be compared between them, but of each mode its own."""
        if self.style.limits is not None:
            return self.style.limits
        modes = self.reel.rest is not None
        key = look.field, look.face if through(look.field) else "", look.state if modes else 0
        if key not in self._limits:
            states = self.reel.states[look.state : look.state + 1] if modes else self.reel.states
            found = [values(state, look.field, 3, key[1] or None) for state in states]
            self._limits[key] = limits_of(found, look.field, modes)
        return self._limits[key]

    def seen(self) -> Survey:
        """What the camera has to show: all states."""
        first = self.styled(self.first)
        coarse = replace(first, field="displacement", z=None, subdivisions=3)
        return survey((frame_of(state, coarse) for state in self.reel.states), coarse)


def limits_of(found: Sequence[np.ndarray], field: str, swings: bool) -> tuple[float, float]:
    """Limits for values of some states; those of a mode are what they are in the whole swing."""
    low, high = min(float(part.min()) for part in found), max(float(part.max()) for part in found)
    if swings:
        low, high = (min(low, -high), max(high, -low)) if signed(field) else (min(low, 0.0), high)
    return colour_limits(low, high)


def signed(field: str) -> bool:
    """Whether a field turns its sign with that of a mode; lengths and von Mises' stress do not."""
    return field not in ("displacement", "velocity", "mises", "thickness")


def fields_of(states: tuple[Solution, ...], first: str) -> tuple[str, ...]:
    """The fields that all states have, with the one that is wanted first among them."""
    theory = states[0].system.geometry.theory
    names = ["displacement", "u1", "u2", "u3"]
    if all(state.velocity is not None for state in states):
        names += ["velocity", "v1", "v2", "v3"]
    shear = theory.shear
    names += ["mises"]
    names += [name for name in STRESSES if shear or name in ("S11", "S22", "S12")]
    names += [name for name in STRAINS if shear or name in ("E11", "E22", "E12")]
    names += [*FORCES] if shear else [*FORCES, *SHEAR]
    if any(not isinstance(state.system.problem.section, Section) for state in states):
        names.append("thickness")
    return tuple(names) if first in names else (first, *names)
