"""Pictures and films of deformed plates, drawn without a screen."""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from skancf.errors import InputError, finite, number, positive, vector
from skancf.output.atomic import AnyPath, check_file, replacing
from skancf.output.fields import check_name, unit, values
from skancf.output.rendering import check_rendering, quiet
from skancf.output.sampling import grid, sample_surface
from skancf.solution import Solution

DARK, GREY = "#202020", "#9a9a9a"
FEW_CELLS = 20_000
"""Elements are cut into up to 12 x 12 cells, fewer where that would be more cells than this."""


@dataclass(frozen=True)
class Look:
    """How pictures look.

    Parameters
    ----------
    field : str
        ``"displacement"`` and ``"velocity"`` (lengths of the vectors), ``"u1"`` to ``"u3"``, ``"v1"`` to ``"v3"``,
        stresses ``"S11"``, ``"S22"``, ``"S33"``, ``"S23"``, ``"S13"``, ``"S12"`` in the local frame, ``"mises"``, and
        strains ``"E11"``, ... in the same order.
    z : float
        Depth of the surface that is drawn and of its field (m).
    scale : float
        Factor of the displacements that are drawn.
    limits : (2,) tuple, optional
        Smallest and largest value of the colours. Default: those of the field, made symmetric about zero where it has
        both signs.
    view : (3,) tuple
        Direction from the plate to the eye.
    show_mesh, show_undeformed : bool
        Draw the edges of elements, as the curves they are; draw the undeformed ones too, in grey.
    title : str, optional
        Default: field, depth, and time or load factor. ``""``: none.
    subdivisions : int, optional
        Cells along an element's edge. Default: by the number of elements.
    size : (2,) tuple of int
        Pixels.
    """

    field: str = "displacement"
    z: float = 0.0
    scale: float = 1.0
    limits: tuple[float, float] | None = None
    view: tuple[float, float, float] = (-0.55, -1.0, 0.62)
    show_mesh: bool = True
    show_undeformed: bool = True
    title: str | None = None
    subdivisions: int | None = None
    size: tuple[int, int] = (1400, 1000)

    def __post_init__(self) -> None:
        check_name(self.field)
        number("scale", self.scale)
        if np.hypot(*vector("view", self.view, 3)[:2]) == 0:
            raise InputError(f"view = {self.view}: look from the side a little, not exactly along z, as in (0, -0.01, 1)")
        if self.limits is not None and not np.diff(vector("limits", self.limits, 2))[0] > 0:
            raise InputError(f"limits = {self.limits}: give the smaller value first")
        if self.subdivisions is not None:
            grid(self.subdivisions)
        for pixels in finite("size", self.size):
            positive("size", pixels, "pixels")


@dataclass(frozen=True)
class Frame:
    """What is drawn of one state: points (n, 3), values (n,), rims of elements now and undeformed, and a title."""

    points: np.ndarray
    values: np.ndarray
    cells: np.ndarray
    rims: np.ndarray
    undeformed: np.ndarray
    title: str


def picture(solution: Solution, path: AnyPath, **look: Any) -> Path:
    """Draw a deformed plate, coloured by a field.

    Parameters
    ----------
    solution : Solution
    path : str or Path
        ``*.png``.
    **look
        ``field="S11"``, ``z``, ``scale``, ``limits``, ``view``, ``show_mesh``, ``show_undeformed``, ``title``,
        ``subdivisions``, ``size``: see :class:`~skancf.output.pictures.Look`.

    Returns
    -------
    Path

    Raises
    ------
    InputError
        For a field, depth or file that cannot be.
    SkancfError
        On a machine that cannot draw; the message says what to install.
    """
    file, style = check_file(path, ".png"), Look(**look)
    frame = _frame(solution, style)
    with replacing(file) as part, _plotter(style) as plotter:
        _draw(plotter, frame, style, _limits([frame], style))
        _look_at(plotter, _extent([frame], style), style)
        plotter.screenshot(str(part))
    return file


def animation(states: Iterable[Solution], path: AnyPath, *, seconds_per_frame: float = 0.05, **look: Any) -> Path:
    """Draw states one after the other as an animated GIF, with the same colours and camera.

    Parameters
    ----------
    states : iterable of Solution
    path : str or Path
        ``*.gif``.
    seconds_per_frame : float
        s.
    **look
        See :func:`picture`. The default size is 700 x 500 pixels.

    Returns
    -------
    Path
    """
    file, style = check_file(path, ".gif"), Look(**{"size": (700, 500), **look})
    positive("seconds_per_frame", seconds_per_frame, "s")
    frames = [_frame(state, style) for state in states]
    if not frames:
        raise InputError("states: there are none to draw; give at least one")
    limits, extent = _limits(frames, style), _extent(frames, style)
    images = []
    with _plotter(style) as plotter:
        for frame in frames:
            plotter.clear()
            _draw(plotter, frame, style, limits)
            _look_at(plotter, extent, style)
            images.append(plotter.screenshot(return_img=True))
    _save_gif(images, file, seconds_per_frame)
    return file


def _frame(solution: Solution, style: Look) -> Frame:
    few = int(np.clip(np.sqrt(FEW_CELLS / solution.system.geometry.n_elements), 2, 12))
    k = few if style.subdivisions is None else style.subdivisions
    colours = values(solution, style.field, k, style.z)
    surface = sample_surface(solution, k, style.z)
    undeformed = surface.points - surface.displacement
    return Frame(
        points=undeformed + style.scale * surface.displacement,
        values=colours,
        cells=surface.cells,
        rims=surface.rims,
        undeformed=undeformed,
        title=_title(solution, style) if style.title is None else style.title,
    )


def _title(solution: Solution, style: Look) -> str:
    parts = [_label(style.field)]
    if style.z or style.field[0] in "SEm":
        parts.append(f"z = {style.z:.4g} m")
    if solution.time is not None:
        parts.append(f"t = {solution.time:.4g} s")
    elif solution.load_factor != 1:
        parts.append(f"load factor {solution.load_factor:.4g}")
    if style.scale != 1:
        parts.append(f"displacements x {style.scale:.4g}")
    return ", ".join(parts)


def _label(field: str) -> str:
    if field == "mises":
        return "von Mises stress (Pa)"
    return f"{field} ({unit(field)})" if unit(field) else field


def _limits(frames: Sequence[Frame], style: Look) -> tuple[float, float]:
    if style.limits is not None:
        return style.limits
    low = min(float(frame.values.min()) for frame in frames)
    high = max(float(frame.values.max()) for frame in frames)
    if low < 0 < high and min(-low, high) > 0.05 * max(-low, high):
        low, high = -max(-low, high), max(-low, high)
    # A constant field still needs an interval to be coloured in.
    wide = max(high - low, 1e-6 * max(abs(low), abs(high)), 1e-300)
    return low, low + wide


def _extent(frames: Sequence[Frame], style: Look) -> np.ndarray:
    """Points (m, 3) that the picture has to show."""
    shown = [frame.points for frame in frames] + ([frames[0].undeformed] if style.show_undeformed else [])
    return np.concatenate(shown)


@contextmanager
def _plotter(style: Look) -> Iterator[Any]:
    check_rendering()
    import pyvista

    with quiet():
        plotter = pyvista.Plotter(off_screen=True, window_size=[int(pixels) for pixels in style.size])
        try:
            plotter.set_background("white")
            plotter.enable_anti_aliasing("ssaa")
            yield plotter
        finally:
            plotter.close()


def _draw(plotter: Any, frame: Frame, style: Look, limits: tuple[float, float]) -> None:
    import pyvista

    low, high = limits
    cells = np.column_stack([np.full(len(frame.cells), 4), frame.cells])
    surface = pyvista.PolyData(frame.points, cells.ravel())
    surface.point_data["values"] = frame.values
    plotter.add_mesh(
        surface,
        scalars="values",
        clim=limits,
        cmap="RdBu_r" if low < 0 < high else "viridis",
        n_colors=256,
        smooth_shading=True,
        ambient=0.45,
        diffuse=0.6,
        specular=0.0,
        scalar_bar_args=_bar(style),
    )
    if style.show_undeformed and not np.allclose(frame.points, frame.undeformed):
        plotter.add_mesh(_lines(_outline(frame)), color=GREY, line_width=_width(style), lighting=False)
    if style.show_mesh:
        # Lines lie in the surface; this draws them before it.
        edges = plotter.add_mesh(_lines(frame.points[frame.rims]), color=DARK, line_width=_width(style), lighting=False)
        edges.mapper.SetResolveCoincidentTopologyToPolygonOffset()
        edges.mapper.SetRelativeCoincidentTopologyLineOffsetParameters(0, -8)
    if frame.title:
        plotter.add_text(frame.title, position=(0.04, 0.93), viewport=True, font_size=_font(style), color=DARK)
    plotter.add_axes(xlabel="x", ylabel="y", zlabel="z", color=DARK, viewport=(0, 0, 0.16, 0.2))
