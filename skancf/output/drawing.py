"""Frames on a plotter of pyvista."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple

import numpy as np

from skancf.output.colours import colour_map
from skancf.output.fields import readable_unit
from skancf.output.frames import Frame, Survey, sight
from skancf.output.rendering import check_rendering, quiet
from skancf.output.style import Style
from skancf.tolerances import ONE_PLACE

DARK, GREY = "#202020", "#9a9a9a"


def new_plotter(style: Style, off_screen: bool | None = None) -> Any:
    """A plotter on white, as large as the style says."""
    check_rendering()
    import pyvista

    with quiet():
        plotter = pyvista.Plotter(off_screen=off_screen, window_size=[int(pixels) for pixels in style.size])
        plotter.set_background("white")
        plotter.enable_anti_aliasing("ssaa")
        if off_screen:
            plotter.render_window.Render()
    return plotter


@contextmanager
def unseen_plotter(style: Style) -> Iterator[Any]:
    """A plotter without a window, closed at the end."""
    check_rendering()
    with quiet():
        plotter = new_plotter(style, off_screen=True)
        try:
            yield plotter
        finally:
            plotter.close()


def panel_size(plotter: Any) -> tuple[float, float]:
    """Width and height (pixels) of the active renderer of a plotter."""
    left, bottom, right, top = plotter.renderer.GetViewport()
    width, height = plotter.window_size
    return (right - left) * width, (top - bottom) * height


class Drawn(NamedTuple):
    """Actors of a frame, and the title of its colour bar."""

    actors: list[Any]
    bar: str


def draw(plotter: Any, frame: Frame, style: Style, limits: tuple[float, float]) -> Drawn:
    """Add surface, lines, colour bar and title of a frame to the active renderer; what is returned :func:`erase` removes."""
    import pyvista

    height = panel_size(plotter)[1]
    font, width = max(6, round(height / 72)), max(1.0, height / 550)
    factor, shown_unit = readable_unit(style.field, max(abs(limit) for limit in limits), style.units)
    low, high = factor * limits[0], factor * limits[1]
    cells = np.column_stack([np.full(len(frame.cells), 4), frame.cells])
    surface = pyvista.PolyData(frame.points, cells.ravel())
    surface.point_data["values"] = factor * frame.values
    bar = _bar(plotter, style, shown_unit, frame.where, font)
    drawn = [
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
            scalar_bar_args=bar,
        )
    ]
    if style.show_undeformed:
        drawn.append(plotter.add_mesh(lines(frame.outline), color=GREY, line_width=width, lighting=False))
    if style.show_mesh:
        # Lines lie in the surface; this draws them before it, by units of 2^-24 of the depth of the picture.
        edges = plotter.add_mesh(lines(frame.edges), color=DARK, line_width=width, lighting=False)
        edges.mapper.SetResolveCoincidentTopologyToPolygonOffset()
        edges.mapper.SetRelativeCoincidentTopologyLineOffsetParameters(0, -500)
        drawn.append(edges)
    if frame.title:
        place = {"position": (0.04, 0.93), "viewport": True}
        drawn.append(plotter.add_text(frame.title, font_size=font, color=DARK, **place))
    return Drawn(drawn, bar["title"])


def erase(plotter: Any, drawn: Drawn) -> None:
    """Remove a frame, and leave camera, lights and directions as they are."""
    plotter.remove_actor(drawn.actors, reset_camera=False, render=False)
    plotter.remove_scalar_bar(drawn.bar, render=False)


def add_directions(plotter: Any) -> None:
    """Arrows along x, y and z, in a corner."""
    plotter.add_axes(xlabel="x", ylabel="y", zlabel="z", color=DARK, viewport=(0.84, 0, 1, 0.18))


def lines(curves: np.ndarray) -> Any:
    """Curves (m, n, 3) as lines."""
    import pyvista

    m, n = curves.shape[:2]
    numbers = np.column_stack([np.full(m, n), np.arange(m * n).reshape(m, n)])
    return pyvista.PolyData(curves.reshape(-1, 3), lines=numbers.ravel())


def _bar(plotter: Any, style: Style, shown_unit: str, where: str, font: int) -> dict[str, Any]:
    short = {"displacement": "u", "velocity": "v"}.get(style.field, style.field)
    depth = where.split(" through")[0].split(" face")[0]
    title = short + (f" ({shown_unit})" if shown_unit else "") + (f"\n{depth}" if depth else "") + "\n"
    # A plotter knows its bars by their titles; spaces tell those of several panels apart.
    while title in plotter.scalar_bars:
        title += " "
    return {
        "title": title,
        "vertical": True,
        "position_x": 0.855,
        "position_y": 0.2,
        "width": 0.06,
        "height": 0.6,
        "n_labels": 7,
        "fmt": " %.3g",
        "color": DARK,
        "title_font_size": 2 * font,
        "label_font_size": 2 * font,
        "unconstrained_font_size": True,
    }


def look_at(plotter: Any, seen: Survey, style: Style) -> None:
    """Parallel projection that shows all points as large as they fit, left of the colour bar."""
    axes, size = sight(style.view), panel_size(plotter)
    span = max(seen.high.max() - seen.low.min(), 0.0)
    width, height, depth = np.maximum(seen.high - seen.low, ONE_PLACE * span)
    camera = plotter.camera
    camera.SetParallelProjection(True)
    # The picture is 2 * parallel scale high; 0.80 of its width and 0.78 of its height are for the plate.
    camera.SetParallelScale(0.5 * max(height / 0.78, width / (0.80 * size[0] / size[1])))
    middle = (seen.low + seen.high) / 2 @ axes
    camera.SetFocalPoint(*middle)
    camera.SetPosition(*(middle + axes[2] * (width + height + depth)))
    camera.SetViewUp(*axes[1])
    # Centre of the plate at 0.44 of the width and 0.47 of the height.
    camera.SetWindowCenter(0.12, 0.06)
    plotter.renderer.ResetCameraClippingRange()
    plotter.camera_set = True
