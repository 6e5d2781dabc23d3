"""Films of states: animated GIFs and MP4 files."""

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from skancf.atomic import AnyPath, check_file, replacing
from skancf.errors import InputError, positive, shown
from skancf.optional import needed
from skancf.output.drawing import add_directions, draw, erase, look_at, unseen_plotter
from skancf.output.frames import Survey, frame_of, survey
from skancf.output.reels import series_of
from skancf.output.style import Style
from skancf.progress import Bar, ShowProgress, check_progress
from skancf.solution import Solution


def animation(
    states: Any, path: AnyPath, *, seconds_per_frame: float = 0.05, progress: ShowProgress = True, **options: Any
) -> Path:
    """Draw states one after the other as a film, with the same colours and camera.

    Parameters
    ----------
    states : iterable of Solution, Motion or PathResult
        For example ``motion.states``, ``path.solutions``, or ``modes.swing(0)``.
    path : str or Path
        ``*.gif``, or ``*.mp4`` (H.264, which browsers, slides and phones play; a tenth of the size).
    seconds_per_frame : float
        Duration of each picture (s).
    progress : bool or callable
        A bar, nothing, or a function that is told of each picture; see :class:`~skancf.Progress`.
    **options
        See :func:`picture`. The default size is 700 x 500 pixels; of an MP4 file odd sizes are made even.

    Returns
    -------
    Path

    Raises
    ------
    InputError
        For no states, and for what :func:`picture` refuses.
    SkancfError
        Where the package that writes MP4 files is missing.

    Notes
    -----
    States are gone through twice, first for the range of colours and the camera, then to draw them, so that only one picture
    is in memory at a time. Of a generator the states are kept.

    Examples
    --------
    >>> strip = sk.Problem(sk.Rectangle(1.0, 0.3), 0.01, sk.Isotropic(2e9, 0.3, 1e3), [sk.Clamp("left")])
    >>> modes = sk.modes(strip.on(sk.meshes.uniform(strip.surface, 4, 1)), 2)
    >>> film = sk.output.animation(modes.swing(1, frames=4), "second_mode.gif", size=(200, 150))
    >>> film.name
    'second_mode.gif'
    """
    file, style = check_file(path, ".gif", ".mp4"), Style(**{"size": (700, 500), **options})
    positive("seconds_per_frame", seconds_per_frame, "s")
    check_progress(progress)
    states = series_of(states)
    if isinstance(states, Solution) or not isinstance(states, Iterable) or isinstance(states, str | bytes):
        raise InputError(f"states = {shown(states)}: give a sequence of Solutions, as motion.states")
    mp4 = file.suffix.lower() == ".mp4"
    if mp4:
        style = _even(style)
    kept = states if isinstance(states, Sequence) else tuple(states)
    seen = survey((frame_of(state, style) for state in kept), style)
    with replacing(file) as part, Bar("film", len(kept), progress) as bar:
        images = _images(kept, style, seen, bar)
        if mp4:
            _save_mp4(images, part, seconds_per_frame, style.size)
        else:
            _save_gif(images, part, seconds_per_frame)
    return file


def _even(style: Style) -> Style:
    """Colours of MP4 files are stored for squares of 2 x 2 pixels."""
    width, height = (2 * -(-int(pixels) // 2) for pixels in style.size)
    return Style(**{**vars(style), "size": (width, height)})


def _images(states: Sequence[Solution], style: Style, seen: Survey, bar: Bar) -> Iterator[np.ndarray]:
    """Pictures (height, width, 3), drawn when they are asked for."""
    with unseen_plotter(style) as plotter:
        add_directions(plotter)
        for state in states:
            drawn = draw(plotter, frame_of(state, style), style, seen.limits)
            look_at(plotter, seen, style)
            yield plotter.screenshot(return_img=True)
            bar.next("")
            erase(plotter, drawn)


def _save_gif(images: Iterator[np.ndarray], file: Path, seconds_per_frame: float) -> None:
    first = _few_colours(next(images))
    rest = (_few_colours(image) for image in images)
    first.save(file, save_all=True, append_images=rest, duration=round(1000 * seconds_per_frame), loop=0, format="GIF")


def _few_colours(image: np.ndarray) -> Any:
    from PIL import Image

    return Image.fromarray(image).convert("P", palette=Image.Palette.ADAPTIVE)


def _save_mp4(images: Iterator[np.ndarray], file: Path, seconds_per_frame: float, size: tuple[int, int]) -> None:
    ffmpeg = needed("imageio_ffmpeg", "an MP4 film", "view")
    # The index at the front lets browsers begin before the whole file is there.
    writer = ffmpeg.write_frames(str(file), size, fps=1 / seconds_per_frame, codec="libx264", pix_fmt_out="yuv420p",
                          quality=8, macro_block_size=2, output_params=["-movflags", "+faststart"])  # fmt: skip
    writer.send(None)
    try:
        for image in images:
            writer.send(np.ascontiguousarray(image))
    finally:
        writer.close()
