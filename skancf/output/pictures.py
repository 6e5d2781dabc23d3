"""Pictures of deformed plates, as files and on plotters."""

from pathlib import Path
from typing import Any

from skancf.arguments import flag, having
from skancf.atomic import AnyPath, check_file, replacing
from skancf.output.drawing import add_directions, draw, look_at, new_plotter, unseen_plotter
from skancf.output.frames import frame_of, survey
from skancf.output.style import Style
from skancf.solution import Solution


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

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> system = plate.on(sk.meshes.uniform(plate.surface, 6, 6), "kirchhoff")
    >>> file = sk.output.picture(sk.solve_linear(system), "plate.png", field="mises", scale=1e3, size=(350, 250))
    >>> print(file.name)
    plate.png
    """
    file, style = check_file(path, ".png"), Style(**options)
    frame = frame_of(solution, style)
    seen = survey([frame], style)
    with replacing(file) as part, unseen_plotter(style) as plotter:
        draw(plotter, frame, style, seen.limits)
        add_directions(plotter)
        look_at(plotter, seen, style)
        plotter.screenshot(str(part))
    return file


def plot(solution: Solution, plotter: Any = None, *, off_screen: bool | None = None, **options: Any) -> Any:
    """Draw a deformed plate on a plotter of pyvista, which you then add to, show or save.

    Parameters
    ----------
    solution : Solution
    plotter : pyvista.Plotter, optional
        Its active panel is drawn on; sizes of text and lines follow from the size of the panel. Where the panel is empty,
        the camera is set, else it stays. Default: a new one.
    off_screen : bool, optional
        For a new plotter: whether it opens no window. Default: what pyvista does.
    **options
        ``field="S11"``, ``z``, ``scale``, ``limits``, ...: see :class:`~skancf.output.Style`. The ``size`` is that of a
        new plotter.

    Returns
    -------
    pyvista.Plotter
        ``plotter.show()`` opens the window, and in a notebook shows the picture.

    Raises
    ------
    InputError
        For a field or depth that cannot be, and for what is no plotter.
    SkancfError
        On a machine that cannot draw; the message says what to install.

    Examples
    --------
    >>> strip = sk.Problem(sk.Rectangle(1.0, 0.3), 0.01, sk.Isotropic(2e9, 0.3, 1e3), [sk.Clamp("left")],
    ...                    [sk.EdgeLoad("right", (0.0, 0.0, -1.0))])
    >>> solution = sk.solve_linear(strip.on(sk.meshes.uniform(strip.surface, 6, 2)))
    >>> plotter = sk.output.plot(solution, off_screen=True, field="u3", size=(400, 300))
    >>> tip = plotter.add_points(solution.position((1.0, 0.15)), color="red", point_size=12)
    >>> image = plotter.screenshot(return_img=True)
    >>> image.shape
    (300, 400, 3)
    >>> plotter.close()
    """
    style = Style(**options)
    frame = frame_of(solution, style)
    if off_screen is not None:
        flag("off_screen", off_screen)
    if plotter is None:
        plotter = new_plotter(style, off_screen)
    else:
        having("plotter", plotter, ("add_mesh", "renderer", "window_size"), "a pyvista.Plotter, or leave it out")
    seen, empty = survey([frame], style), not plotter.renderer.actors
    draw(plotter, frame, style, seen.limits)
    if empty:
        add_directions(plotter)
        look_at(plotter, seen, style)
    return plotter
