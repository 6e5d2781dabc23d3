"""Files to look at: results of this library, and what was written for ParaView."""

import warnings
from pathlib import Path
from typing import Any

from skancf.arguments import choice
from skancf.atomic import AnyPath, as_path, check_file
from skancf.errors import InputError, SkancfError


def look_at_file(path: AnyPath, field: str | None = None, out: AnyPath | None = None) -> None:
    """Open a window on a file, or write a picture or a page of it; without a screen a picture next to it.

    Parameters
    ----------
    path : str or Path
        ``*.h5``, ``*.vtu`` or ``*.pvd``.
    field : str, optional
        What the colours show. Default: the displacement.
    out : str or Path, optional
        Write this ``*.png`` or ``*.html`` instead.
    """
    from skancf.output.viewer import has_screen

    file = as_path("file", path)
    if not file.is_file():
        raise InputError(f"file '{file}': there is no such file")
    shows = {".h5": _show_result, ".vtu": _show_points, ".pvd": _show_points}
    if file.suffix.lower() not in shows:
        raise InputError(f"file '{file}': its name ends in '{file.suffix}'; give one of .h5, .vtu or .pvd")
    target = None if out is None else check_file(out, ".png", ".html")
    if target is None and not has_screen():
        target = check_file(file.with_name(f"{file.stem}_view.png"), ".png")
        page = f" A page to turn it on: skancf view {file} --out page.html" if file.suffix.lower() == ".h5" else ""
        print(f"There is no screen to open a window on; a picture is written.{page}")
    shows[file.suffix.lower()](file, field, target)
    if target is not None:
        print(f"-> {target}")


def _show_result(file: Path, field: str | None, target: Path | None) -> None:
    from skancf.output import picture, view, write_html
    from skancf.output.rendering import check_rendering
    from skancf.storage import load
    from skancf.storage.run_file import shown_state

    result = load(file)
    options: dict[str, Any] = {} if field is None else {"field": field}
    if target is None:
        view(result, backend="window", **options)
    elif target.suffix.lower() == ".html":
        write_html(result, target, **options)
    else:
        check_rendering()
        picture(shown_state(result), target, **options)


def _show_points(file: Path, field: str | None, target: Path | None) -> None:
    """What points of a file for ParaView carry, by its own readers; of a collection the last time."""
    import pyvista

    from skancf.output.files import read
    from skancf.output.rendering import check_rendering, quiet

    if target is not None and target.suffix.lower() == ".html":
        raise SkancfError(f"file '{file}': pages are made of .h5 files, which sk.save writes; write a .png, or open it in "
                          "ParaView")  # fmt: skip
    # That they are whole, told in words.
    found = read(file)
    times = [(time, part) for time, part in found] if isinstance(found, list) else [(None, file)]
    if isinstance(found, list):
        read(times[-1][1])
    check_rendering()
    with quiet():
        plotter = pyvista.Plotter(off_screen=target is not None, window_size=(1400, 1000))
        _add(plotter, times[-1], field)
        if target is None and len(times) > 1:
            plotter.add_slider_widget(lambda k: _add(plotter, times[round(k)], field), (0, len(times) - 1), len(times) - 1,
                                      title="state", fmt="%.0f")  # fmt: skip
        plotter.add_axes()
        plotter.view_isometric()
        plotter.camera.zoom(1.3)
        plotter.show(screenshot=False if target is None else str(target), title=f"skancf {file.name}")


def _add(plotter: Any, one: tuple[float | None, Path], field: str | None) -> None:
    """Draw a file of the times of a collection."""
    import pyvista

    time, file = one
    data = pyvista.read(file)
    names = list(data.point_data.keys())
    if not names:
        raise InputError(f"file '{file}': its points carry no values")
    name = field or ("displacement" if "displacement" in names else names[0])
    choice("field", name, names)
    with warnings.catch_warnings():
        # Of an argument that earlier versions do not have.
        warnings.simplefilter("ignore")
        # Curved cells are drawn as curves.
        surface = data.extract_surface(nonlinear_subdivision=4)
    title = name if time is None else f"{name}, {time:g}"
    plotter.add_mesh(
        surface,
        scalars=name,
        name="states",
        cmap="viridis",
        smooth_shading=True,
        ambient=0.35,
        scalar_bar_args={"title": name},
    )
    plotter.add_text(title, name="title", font_size=12)
