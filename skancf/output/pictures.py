"""Pictures and films of deformed plates, drawn without a screen."""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from skancf.arguments import STATE, choice, flag, instance, texts, whole
from skancf.atomic import AnyPath, check_file, replacing
from skancf.errors import InputError, number, positive, shown, vector
from skancf.materials.heights import DEPTHS, Depth
from skancf.output.colours import colour_limits, colour_map
from skancf.output.fields import check_name, place, readable_unit, values, words
from skancf.output.rendering import check_rendering, quiet
from skancf.output.sampling import grid, sample_surface
from skancf.solution import Solution
from skancf.tolerances import ONE_PLACE
from skancf.units import Units

DARK, GREY = "#202020", "#9a9a9a"
MOST_PIXELS = 16_384
"""In one direction; graphics drivers draw no larger pictures."""
FEW_CELLS = 20_000
"""Elements are cut into up to 12 x 12 cells, fewer where that would be more cells than this."""


@dataclass(frozen=True)
class Style:
    """How pictures look.

    Parameters
    ----------
    field : str
        ``"displacement"`` and ``"velocity"`` (lengths of the vectors), ``"u1"`` to ``"u3"``, ``"v1"`` to ``"v3"``,
        stresses ``"S11"``, ``"S22"``, ``"S33"``, ``"S23"``, ``"S13"``, ``"S12"`` in the local frame, ``"mises"``,
        strains ``"E11"``, ... in the same order, section forces ``"N11"``, ``"N22"``, ``"N12"``, ``"M11"``, ``"M22"``,
        ``"M12"``, in theory `kirchhoff` ``"Q1"``, ``"Q2"``, and ``"thickness"``.
    z : float or {"top", "middle", "bottom"}, optional
        Depth of the surface that is drawn and of its field (m). Default: stresses and strains are those of the top face,
        and von Mises' stress is the largest through the thickness, drawn on the reference surface as all other fields. The
        title and the colour bar say which.
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
        Default: field, depth, and time or load factor; that an answer is one of small deflections, or a mode, which has no
        size of its own. ``""``: none.
    subdivisions : int, optional
        Cells along an element's edge. Default: by the number of elements.
    size : (2,) tuple of int
        Pixels.
    units : Units, optional
        Of the colour bar. Default: those of SI, stresses with a prefix.
    """

    field: str = "displacement"
    z: Depth | None = None
    scale: float = 1.0
    limits: tuple[float, float] | None = None
    view: tuple[float, float, float] = (-0.55, -1.0, 0.62)
    show_mesh: bool = True
    show_undeformed: bool = True
    title: str | None = None
    subdivisions: int | None = None
    size: tuple[int, int] = (1400, 1000)
    units: Units | None = None

    def __post_init__(self) -> None:
        check_name(self.field)
        if isinstance(self.z, str):
            choice("z", self.z, DEPTHS)
        elif self.z is not None:
            number("z", self.z)
        number("scale", self.scale)
        if np.hypot(*vector("view", self.view, 3)[:2]) == 0:
            raise InputError(f"view = {self.view}: look a little from the side, not along z: (0, -0.01, 1)")
        if self.limits is not None and not np.diff(vector("limits", self.limits, 2))[0] > 0:
            raise InputError(f"limits = {self.limits}: give the smaller value first")
        if self.subdivisions is not None:
            grid(self.subdivisions)
        for name in ("show_mesh", "show_undeformed"):
            flag(name, getattr(self, name))
        texts(title=self.title)
        if self.units is not None:
            instance("units", self.units, Units, "names of units, as in sk.Units(length='mm', stress='MPa')")
        for pixels in vector("size", self.size, 2):
            whole("size", pixels, most=MOST_PIXELS, floats=True)


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


def picture(solution: Solution, path: AnyPath, **options: Any) -> Path:
    """Draw a deformed plate, coloured by a field.

    Parameters
    ----------
    solution : Solution
    path : str or Path
        ``*.png``.
    **options
        ``field="S11"``, ``z``, ``scale``, ``limits``, ``view``, ``show_mesh``, ``show_undeformed``, ``title``,
        ``subdivisions``, ``size``: see :class:`~skancf.output.Style`.

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
    file, style = check_file(path, ".png"), Style(**options)
    frame = _frame(solution, style)
    with replacing(file) as part, _plotter(style) as plotter:
        _draw(plotter, frame, style, _limits([frame], style))
        _look_at(plotter, _extent([frame], style), style)
        plotter.screenshot(str(part))
    return file


def animation(states: Iterable[Solution], path: AnyPath, *, seconds_per_frame: float = 0.05, **options: Any) -> Path:
    """Draw states one after the other as an animated GIF, with the same colours and camera.

    Parameters
    ----------
    states : iterable of Solution
    path : str or Path
        ``*.gif``.
    seconds_per_frame : float
        Duration of each picture (s).
    **options
        See :func:`picture`. The default size is 700 x 500 pixels.

    Returns
    -------
    Path
    """
    file, style = check_file(path, ".gif"), Style(**{"size": (700, 500), **options})
    positive("seconds_per_frame", seconds_per_frame, "s")
    if isinstance(states, Solution) or not isinstance(states, Iterable) or isinstance(states, str | bytes):
        raise InputError(f"states = {shown(states)}: give a sequence of Solutions, as motion.states")
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


def _frame(solution: Solution, style: Style) -> Frame:
    instance("solution", solution, Solution, STATE)
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
        outline=undeformed[_boundary(solution, surface.rims)],
        title=_title(solution, style, where) if style.title is None else style.title,
        where=where,
    )


def _boundary(solution: Solution, rims: np.ndarray) -> np.ndarray:
    """The parts (n_lines, k + 1) of rims (n_elements, 4 k + 1) that are edges of one element only."""
    geometry, k = solution.system.geometry, rims.shape[1] // 4
    sides = np.stack([rims[:, side * k : (side + 1) * k + 1] for side in range(4)])
    return np.asarray(sides[np.isin(geometry.mesh.t2f, geometry.boundary)])


def _title(solution: Solution, style: Style, where: str) -> str:
    parts = [f"{words(style.field)}, {where}" if where else words(style.field)]
    if solution.note:
        parts.append(solution.note)
    if solution.linear:
        parts.append("small deflections")
    if solution.time is not None:
        parts.append(f"t = {solution.time:.4g} s")
    elif solution.load_factor != 1 and not (solution.note and solution.load_factor == 0):
        parts.append(f"load factor {solution.load_factor:.4g}")
    if style.scale != 1:
        parts.append(f"displacements x {style.scale:.4g}")
    return ", ".join(parts)


def _limits(frames: Sequence[Frame], style: Style) -> tuple[float, float]:
    if style.limits is not None:
        return style.limits
    low = min(float(frame.values.min()) for frame in frames)
    high = max(float(frame.values.max()) for frame in frames)
    return colour_limits(low, high)


def _extent(frames: Sequence[Frame], style: Style) -> np.ndarray:
    """Points (m, 3) that the picture has to show."""
    shown = [frame.points for frame in frames] + ([frames[0].outline.reshape(-1, 3)] if style.show_undeformed else [])
    return np.concatenate(shown)


@contextmanager
def _plotter(style: Style) -> Iterator[Any]:
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


def _draw(plotter: Any, frame: Frame, style: Style, limits: tuple[float, float]) -> None:
    import pyvista

    factor, shown_unit = readable_unit(style.field, max(abs(limit) for limit in limits), style.units)
    low, high = factor * limits[0], factor * limits[1]
    cells = np.column_stack([np.full(len(frame.cells), 4), frame.cells])
    surface = pyvista.PolyData(frame.points, cells.ravel())
    surface.point_data["values"] = factor * frame.values
    plotter.add_mesh(
        surface,
        scalars="values",
        clim=(low, high),
        cmap=colour_map(low, high),
        n_colors=256,
        smooth_shading=True,
        ambient=0.55,
        diffuse=0.5,
        specular=0.0,
        scalar_bar_args=_bar(style, shown_unit, frame.where),
    )
    if style.show_undeformed:
        plotter.add_mesh(_lines(frame.outline), color=GREY, line_width=_width(style), lighting=False)
    if style.show_mesh:
        # Lines lie in the surface; this draws them before it, by units of 2^-24 of the depth of the picture.
        edges = plotter.add_mesh(_lines(frame.edges), color=DARK, line_width=_width(style), lighting=False)
        edges.mapper.SetResolveCoincidentTopologyToPolygonOffset()
        edges.mapper.SetRelativeCoincidentTopologyLineOffsetParameters(0, -500)
    if frame.title:
        plotter.add_text(frame.title, position=(0.04, 0.93), viewport=True, font_size=_font(style), color=DARK)
    plotter.add_axes(xlabel="x", ylabel="y", zlabel="z", color=DARK, viewport=(0.84, 0, 1, 0.18))


def _lines(curves: np.ndarray) -> Any:
    """Curves (m, n, 3) as lines."""
    import pyvista

    m, n = curves.shape[:2]
    numbers = np.column_stack([np.full(m, n), np.arange(m * n).reshape(m, n)])
    return pyvista.PolyData(curves.reshape(-1, 3), lines=numbers.ravel())


def _bar(style: Style, shown_unit: str, where: str) -> dict[str, Any]:
    short = {"displacement": "u", "velocity": "v"}.get(style.field, style.field)
    depth = where.split(" through")[0].split(" face")[0]
    return {
        "title": short + (f" ({shown_unit})" if shown_unit else "") + (f"\n{depth}" if depth else "") + "\n",
        "vertical": True,
        "position_x": 0.855,
        "position_y": 0.2,
        "width": 0.06,
        "height": 0.6,
        "n_labels": 7,
        "fmt": " %.3g",
        "color": DARK,
        "title_font_size": 2 * _font(style),
        "label_font_size": 2 * _font(style),
        "unconstrained_font_size": True,
    }


def _font(style: Style) -> int:
    return max(6, round(style.size[1] / 72))


def _width(style: Style) -> float:
    return max(1.0, style.size[1] / 550)


def _look_at(plotter: Any, points: np.ndarray, style: Style) -> None:
    """Parallel projection that shows all points as large as they fit, left of the colour bar."""
    back = np.array(style.view) / np.linalg.norm(style.view)
    right = np.cross([0.0, 0.0, 1.0], back)
    right = right / np.linalg.norm(right)
    axes = np.stack([right, np.cross(back, right), back])
    seen = points @ axes.T
    low, high = seen.min(axis=0), seen.max(axis=0)
    width, height, depth = np.maximum(high - low, ONE_PLACE * np.ptp(seen))
    camera = plotter.camera
    camera.SetParallelProjection(True)
    # The picture is 2 * parallel scale high; 0.80 of its width and 0.78 of its height are for the plate.
    aspect = style.size[0] / style.size[1]
    camera.SetParallelScale(0.5 * max(height / 0.78, width / (0.80 * aspect)))
    middle = (low + high) / 2 @ axes
    camera.SetFocalPoint(*middle)
    camera.SetPosition(*(middle + back * (width + height + depth)))
    camera.SetViewUp(*axes[1])
    # Centre of the plate at 0.44 of the width and 0.47 of the height.
    camera.SetWindowCenter(0.12, 0.06)
    plotter.renderer.ResetCameraClippingRange()


def _save_gif(images: Sequence[np.ndarray], file: Path, seconds_per_frame: float) -> None:
    from PIL import Image

    first, *rest = (Image.fromarray(image).convert("P", palette=Image.Palette.ADAPTIVE) for image in images)
    with replacing(file) as part:
        first.save(part, save_all=True, append_images=rest, duration=round(1000 * seconds_per_frame), loop=0)
