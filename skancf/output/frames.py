"""What is drawn of a state: points, colours, lines and words, before anything draws them."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from skancf.errors import InputError
from skancf.output.colours import colour_limits
from skancf.output.fields import place, values
from skancf.output.sampling import sample_surface
from skancf.output.style import Style, title_of
from skancf.solution import Solution
from skancf.states import StateLike, solution_of

FEW_CELLS = 20_000
"""Elements are cut into up to 12 x 12 cells, fewer where that would be more cells than this."""


@dataclass(frozen=True)
class Frame:
    """What is drawn of one state.

    Attributes
    ----------
    points, values, cells : (n, 3), (n,) and (m, 4) arrays
    edges : (n_elements, k, 3) array
        Curves around the elements.
    outline : (n_lines, k, 3) array
        Curves along the boundary of the undeformed surface.
    title : str
    where : str
        Depth, in words.
    """

    points: np.ndarray
    values: np.ndarray
    cells: np.ndarray
    edges: np.ndarray
    outline: np.ndarray
    title: str
    where: str = ""


def frame_of(solution: StateLike, style: Style) -> Frame:
    """What a picture of a state in a style shows."""
    solution = solution_of("solution", solution)
    few = int(np.clip(np.sqrt(FEW_CELLS / solution.system.geometry.n_elements), 2, 12))
    k = few if style.subdivisions is None else style.subdivisions
    colours = values(solution, style.field, k, style.z)
    depth, where = place(style.field, solution.system.problem.section, style.z)
    surface = sample_surface(solution, k, depth)
    undeformed = surface.points - surface.displacement
    points = undeformed + style.scale * surface.displacement
    return Frame(
        points=points,
        values=colours,
        cells=surface.cells,
        edges=points[surface.rims],
        outline=undeformed[boundary(solution, surface.rims)],
        title=title_of(solution, style, where) if style.title is None else style.title,
        where=where,
    )


def boundary(solution: Solution, rims: np.ndarray) -> np.ndarray:
    """The parts (n_lines, k + 1) of rims (n_elements, 4 k + 1) that are edges of one element only."""
    geometry, k = solution.system.geometry, rims.shape[1] // 4
    sides = np.stack([rims[:, side * k : (side + 1) * k + 1] for side in range(4)])
    return np.asarray(sides[np.isin(geometry.mesh.t2f, geometry.boundary)])


@dataclass(frozen=True)
class Survey:
    """What frames drawn with the same colours and camera have together.

    Attributes
    ----------
    limits : (2,) tuple
        Smallest and largest value of the colours.
    low, high : (3,) arrays
        Bounds of all points along :func:`sight`.
    """

    limits: tuple[float, float]
    low: np.ndarray
    high: np.ndarray


def survey(frames: Iterable[Frame], style: Style) -> Survey:
    """Go through frames once, keeping none."""
    axes = sight(style.view)
    least, most, lows, highs = np.inf, -np.inf, [], []
    for k, frame in enumerate(frames):
        least, most = min(least, float(frame.values.min())), max(most, float(frame.values.max()))
        drawn = [frame.points] + ([frame.outline.reshape(-1, 3)] if style.show_undeformed and not k else [])
        seen = np.concatenate(drawn) @ axes.T
        lows.append(seen.min(axis=0))
        highs.append(seen.max(axis=0))
    if not lows:
        raise InputError("states: the sequence is empty; give at least one")
    limits = colour_limits(least, most) if style.limits is None else style.limits
    return Survey(limits, np.min(lows, axis=0), np.max(highs, axis=0))


def sight(view: tuple[float, float, float]) -> np.ndarray:
    """Unit vectors to the right, upwards and towards the eye, (3, 3) rows, z (along z: y) upright in the picture."""
    back = np.array(view) / np.linalg.norm(view)
    right = np.cross([0.0, 0.0, 1.0], back)
    right = right / np.linalg.norm(right) if np.any(right) else np.array([1.0, 0.0, 0.0])
    return np.stack([right, np.cross(back, right), back])
