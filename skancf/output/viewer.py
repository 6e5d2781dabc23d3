"""States to look at, in a window or on a page."""

import html
import os
import sys
import tempfile
import webbrowser
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from skancf.arguments import choice
from skancf.errors import SkancfError
from skancf.output.drawing import DARK, Drawn, add_directions, draw, erase, look_at, new_plotter
from skancf.output.shows import FACES, Show
from skancf.output.web import page_of
from skancf.progress import in_notebook

NO_SCREEN = (
    "view: there is no screen to open a window on; take backend='page' for a page that any browser opens, write it with "
    "skancf.output.write_html, or draw a picture with skancf.output.picture"
)
FRAMES_PER_SECOND = 12


class Window:
    """A plotter of pyvista with the controls of a :class:`~skancf.output.shows.Show`: a thin layer over it.

    Attributes
    ----------
    look : Look
        What is chosen now.
    plotter : pyvista.Plotter
    """

    def __init__(self, show: Show, off_screen: bool | None = None) -> None:
        self.show, self.look, self.playing = show, show.first, False
        self.plotter = new_plotter(show.style, off_screen)
        add_directions(self.plotter)
        self._drawn: Drawn = self._draw()
        look_at(self.plotter, show.seen(), show.style)
        self.sliders: dict[str, Any] = {}
        self._add_sliders()
        self._add_switches()

    def change(self, **what: Any) -> None:
        """Choose otherwise, as in ``change(field="mises")``, and draw that."""
        look = replace(self.look, **what)
        if look != self.look:
            self.look = look
            erase(self.plotter, self._drawn)
            self._drawn = self._draw()
            self.plotter.render()

    def step(self, _: int = 0) -> None:
        """The next state, or the next phase of a mode, while it plays."""
        if not self.playing:
            return
        if self.show.reel.rest is not None:
            self.move("phase", (self.look.phase + 15) % 360)
        else:
            self.move("state", (self.look.state + 1) % len(self.show.reel.states))

    def move(self, name: str, value: float) -> None:
        """Move a slider, as a hand would."""
        self.sliders[name].GetRepresentation().SetValue(value)
        self.change(**{name: int(value) if name == "state" else value})

    def _draw(self) -> Drawn:
        show, look = self.show, self.look
        return draw(self.plotter, show.frame(look), show.styled(look), show.limits(look))

    def _add_sliders(self) -> None:
        reel, look, n = self.show.reel, self.look, len(self.show.reel.states)
        scale = max(1.0, 2 * look.scale)
        rows = [("scale", "deformation x", (0.0, scale), "%.3g")]
        if reel.rest is not None:
            rows.append(("phase", "phase (degrees)", (0.0, 360.0), "%.0f"))
        if n > 1:
            rows.append(("state", reel.label if reel.label == "mode" else "state", (0.0, n - 1.0), "%.0f"))
        for k, (name, title, (low, high), form) in enumerate(rows):
            left = 0.03 + 0.27 * k
            self.sliders[name] = self.plotter.add_slider_widget(
                self._changer(name), (low, high), value=getattr(look, name), title=title, fmt=form, color=DARK,
                style="modern", pointa=(left, 0.075), pointb=(left + 0.22, 0.075), interaction_event="always",
                title_height=0.018, slider_width=0.02, tube_width=0.004,
            )  # fmt: skip
        texts = [("field", self.show.fields, 0.22, 0.52), ("face", FACES, 0.58, 0.74)]
        for name, data, left, right in texts:
            self.sliders[name] = self.plotter.add_text_slider_widget(
                self._changer(name), list(data), value=data.index(getattr(look, name)), color=DARK, style="modern",
                pointa=(left, 0.885), pointb=(right, 0.885), interaction_event="always",
            )  # fmt: skip
            drawn = self.sliders[name].GetRepresentation()
            drawn.SetTitleHeight(0.018)
            drawn.SetSliderWidth(0.02)
            drawn.SetTubeWidth(0.004)

    def _changer(self, name: str) -> Any:
        if name == "state":
            return lambda value: self.change(state=round(value))
        return lambda value: self.change(**{name: value})

    def _add_switches(self) -> None:
        switches = [("show_mesh", "mesh"), ("show_undeformed", "undeformed")]
        self.buttons: dict[str, Any] = {}
        for k, (name, words) in enumerate(switches):
            self._add_switch(k, words, getattr(self.look, name), self._changer(name))
        if len(self.sliders) > 3:
            self._add_switch(len(switches), "play", False, lambda on: setattr(self, "playing", bool(on)))

    def _add_switch(self, k: int, words: str, on: bool, callback: Any) -> None:
        height = self.show.style.size[1]
        size, y = max(14, round(height / 45)), round(height * (0.86 - 0.045 * k))
        left = round(0.04 * self.show.style.size[0])
        self.buttons[words] = self.plotter.add_checkbox_button_widget(
            callback, value=on, position=(left, y), size=size, border_size=2, color_on="#0072B2", color_off="#d0d0d0"
        )
        self.plotter.add_text(words, position=(left + 1.5 * size, y), font_size=max(6, round(height / 90)), color=DARK)

    def open(self) -> None:
        """Show the window until it is closed."""
        self.plotter.add_timer_event(max_steps=10**9, duration=1000 // FRAMES_PER_SECOND, callback=self.step)
        self.plotter.show()


class Page:
    """A page of :func:`~skancf.output.write_html` that notebooks show; :meth:`open` shows it in a browser."""

    def __init__(self, text: str) -> None:
        self.text = text

    def __repr__(self) -> str:
        return f"Page({len(self.text) / 1e6:.1f} MB)"

    def _repr_html_(self) -> str:
        return (f'<iframe srcdoc="{html.escape(self.text)}" title="states of a shell" '
                'style="width: 100%; height: 620px; border: 0"></iframe>')  # fmt: skip

    def open(self) -> None:
        """Open the page in the browser of this machine."""
        with tempfile.NamedTemporaryFile("w", suffix=".html", prefix="skancf_", delete=False, encoding="utf-8") as file:
            file.write(self.text)
        webbrowser.open(Path(file.name).as_uri())


def view(states: Any, *, backend: str = "auto", fields: Sequence[str] | None = None, **options: Any) -> Page | None:
    """Look at states: turn and zoom them, and choose field, face, size of the displacements, mesh and undeformed outline.

    A motion or path has a slider for its states, modes have one for the phase of their swing.

    Parameters
    ----------
    states : Solution, sequence of Solution, result, Motion, PathResult, Modes or BucklingResult
    backend : {"auto", "window", "page"}
        A window of pyvista, which stays until it is closed; or the page of :func:`~skancf.output.write_html`, which needs no
        server: in a notebook it is shown there, elsewhere in a browser. ``"auto"``: a page in notebooks, else a window.
    fields : sequence of str, optional
        What a page lets choose: see :func:`~skancf.output.write_html`. A window has all fields.
    **options
        What is chosen at first: see :class:`~skancf.output.Style`.

    Returns
    -------
    Page or None
        What a notebook shows; None of a window.

    Raises
    ------
    InputError
        For what :func:`~skancf.output.write_html` refuses.
    SkancfError
        Where there is no screen for a window.

    Examples
    --------
    >>> strip = sk.Problem(sk.Rectangle(1.0, 0.3), 0.01, sk.Isotropic(2e9, 0.3, 1e3), [sk.Clamp("left")])
    >>> modes = sk.modes(strip.on(sk.meshes.uniform(strip.surface, 4, 1)), 2)
    >>> sk.output.view(modes, field="u3")  # doctest: +SKIP
    """
    choice("backend", backend, ("auto", "window", "page"))
    show = Show(states, **options)
    if backend == "window" or (backend == "auto" and not in_notebook()):
        if not has_screen():
            raise SkancfError(NO_SCREEN)
        Window(show).open()
        return None
    page = Page(page_of(show, fields))
    if not in_notebook():
        page.open()
    return page


def has_screen() -> bool:
    """Whether windows can be opened."""
    return not sys.platform.startswith("linux") or bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
