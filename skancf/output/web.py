"""States as one page for a browser, which needs no network and no server."""

import base64
import html
import json
import zlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from skancf.arguments import sequence, text
from skancf.atomic import AnyPath, check_file, replacing
from skancf.errors import positive
from skancf.output.colours import colour_map
from skancf.output.fields import check_name, readable_unit, through, values, words
from skancf.output.frames import sight
from skancf.output.reels import Reel
from skancf.output.sampling import sample_surface
from skancf.output.shows import FACES, Show, limits_of, signed
from skancf.solution import Solution

CUBIC = 3
"""Cells along an edge of an element, of which the corners are 4 x 4 points: what a polynomial of degree three needs."""
OF_DISPLACEMENT = ("displacement", "u1", "u2", "u3")
MANY_NUMBERS = 1_500_000
"""More stress components are only in pages with fewer values than this, some 3 MB."""
PARTS = Path(__file__).parent / "web"


def write_html(
    states: Any, path: AnyPath, *, fields: Sequence[str] | None = None, seconds_per_frame: float = 0.1, **options: Any
) -> Path:
    """Write states as one page for a browser, which works without a network: to turn, zoom, play and read values from.

    It has sliders for the time, the load factor or the mode with its phase and for the size of the displacements, and
    choices of the field, of the face, of the mesh and of the undeformed outline. A value is shown under the pointer.

    Parameters
    ----------
    states : Solution, sequence of Solution, result, Motion, PathResult, Modes or BucklingResult
    path : str or Path
        ``*.html``.
    fields : sequence of str, optional
        What can be chosen, by the names of :class:`~skancf.output.Style`. Default: displacements and von Mises' stress, and
        of few states the stresses S11, S22 and S12.
    seconds_per_frame : float
        While it plays (s).
    **options
        What is chosen at first: ``field``, ``z`` (a face), ``scale``, ``view``, ``limits``, ``show_mesh``,
        ``show_undeformed``, ``title``; see :class:`~skancf.output.Style`.

    Returns
    -------
    Path

    Raises
    ------
    InputError
        For a field that cannot be, no states, and a file that cannot be written.

    Notes
    -----
    The page draws the curved elements themselves, from 4 x 4 points of each. Stresses are those of the faces, drawn on the
    reference surface; they are stored to 1/65535 of their range. Stresses of a mode are taken as proportional to its swing.
    A page is 0.6 MB and, for each state, some 200 bytes for an element and 32 for each field at each face, before
    compression. It is drawn by `three.js <https://threejs.org>`_, which is part of the page.

    Examples
    --------
    >>> strip = sk.Problem(sk.Rectangle(1.0, 0.3), 0.01, sk.Isotropic(2e9, 0.3, 1e3), [sk.Clamp("left")])
    >>> modes = sk.modes(strip.on(sk.meshes.uniform(strip.surface, 4, 1)), 2)
    >>> page = sk.output.write_html(modes, "modes.html", title="Modes of a strip")
    >>> page.stat().st_size < 700_000
    True
    """
    file = check_file(path, ".html", ".htm")
    made = page_of(Show(states, **options), fields, seconds_per_frame)
    with replacing(file) as part:
        part.write_text(made, encoding="utf-8")
    return file


def page_of(show: Show, fields: Sequence[str] | None = None, seconds_per_frame: float = 0.1) -> str:
    """The page as text."""
    seconds = positive("seconds_per_frame", seconds_per_frame, "s")
    chosen = _fields(show, fields)
    blob = _Blob()
    described = _Described(show, chosen, blob).header()
    described["seconds"] = seconds
    style, first = show.style, show.first
    described["look"] = {"state": first.state, "field": first.field, "face": first.face, "scale": first.scale,
                         "mesh": bool(first.show_mesh), "undeformed": bool(first.show_undeformed)}  # fmt: skip
    title = style.title or ""
    parts = {
        "@TITLE@": html.escape(text("title", title) or words(style.field)),
        "@STYLE@": (PARTS / "page.css").read_text(encoding="utf-8"),
        "@THREE@": (PARTS / "three.min.js").read_text(encoding="utf-8"),
        "@SHOW@": json.dumps({**described, "title": title}, allow_nan=False).replace("<", "\\u003c"),
        "@NUMBERS@": blob.text(),
        "@SCRIPT@": (PARTS / "page.js").read_text(encoding="utf-8"),
    }
    page = (PARTS / "page.html").read_text(encoding="utf-8")
    for mark, part in parts.items():
        page = page.replace(mark, part)
    return page


def _fields(show: Show, fields: Sequence[str] | None) -> tuple[str, ...]:
    """Names of fields that can be chosen, the first one among them."""
    if fields is not None:
        given = sequence("fields", fields, str, "names of fields, as in ['displacement', 'mises']")
        for name in given:
            check_name(name)
    else:
        elements = sum(state.system.geometry.n_elements for state in show.reel.states)
        few = elements * (CUBIC + 1) ** 2 * 15 < MANY_NUMBERS
        given = (*OF_DISPLACEMENT, "mises", *(("S11", "S22", "S12") if few else ()))
    first = show.style.field
    return given if first in given else (first, *given)


class _Blob:
    """Arrays one behind the other."""

    def __init__(self) -> None:
        self.parts: list[bytes] = []
        self.size = 0

    def add(self, array: np.ndarray) -> int:
        """Where the array begins."""
        data = np.ascontiguousarray(array).tobytes()
        data += b"\0" * (-len(data) % 4)
        start, self.size = self.size, self.size + len(data)
        self.parts.append(data)
        return start

    def text(self) -> str:
        return base64.b64encode(zlib.compress(b"".join(self.parts), 9)).decode("ascii")


class _Described:
    """What the page has to know about the arrays of a show."""

    def __init__(self, show: Show, fields: Sequence[str], blob: _Blob) -> None:
        self.show, self.fields, self.blob = show, fields, blob
        self.meshes: dict[int, int] = {}
        self.mesh_rows: list[dict[str, int]] = []
        reel: Reel = show.reel
        rest = reel.rest if reel.rest is not None and np.any(reel.rest.change) else None
        self.n = len(reel.states)
        self.states: tuple[Solution, ...] = reel.states if rest is None else (*reel.states, rest)
        self.rest = None if rest is None else self.n
        self.surfaces = [sample_surface(state, CUBIC) for state in self.states]

    def header(self) -> dict[str, Any]:
        show, style = self.show, self.show.style
        axes, seen = sight(style.view), show.seen()
        rows = [self._state(k) for k in range(len(self.states))]
        return {
            "names": show.reel.names,
            "notes": [_note(state) for state in show.reel.states],
            "faces": FACES,
            "swings": show.reel.rest is not None,
            "rest": self.rest,
            "axes": axes.tolist(),
            "low": seen.low.tolist(),
            "high": seen.high.tolist(),
            "fields": [self._field(name, rows) for name in self.fields],
            "states": rows,
            "meshes": self.mesh_rows,
            "maps": {"one": _hex(colour_map(0.0, 1.0)), "two": _hex(colour_map(-1.0, 1.0))},
        }

    def _state(self, k: int) -> dict[str, Any]:
        geometry, surface = self.states[k].system.geometry, self.surfaces[k]
        if id(geometry) not in self.meshes:
            self.meshes[id(geometry)] = len(self.mesh_rows)
            sides = np.argwhere(np.isin(geometry.mesh.t2f, geometry.boundary).T) @ [4, 1]
            undeformed = (surface.points - surface.displacement).astype("<f4")
            self.mesh_rows.append({"elements": geometry.n_elements, "at": self.blob.add(undeformed), "sides": len(sides),
                                   "rim": self.blob.add(sides.astype("<i4"))})  # fmt: skip
        moved = self.blob.add(surface.displacement.astype("<f4"))
        return {"mesh": self.meshes[id(geometry)], "displacement": moved, "values": {}}

    def _field(self, name: str, rows: list[dict[str, Any]]) -> dict[str, Any]:
        limits: dict[str, list[tuple[float, float]]] = {}
        stored: dict[str, tuple[float, float]] = {}
        for face in FACES if through(name) else ("",):
            found = [self._values(k, name, face) for k in range(len(self.states))]
            swings = self.show.reel.rest is not None
            if self.show.style.limits is not None and name == self.show.style.field:
                limits[face] = [self.show.style.limits] * (self.n if swings else 1)
            elif swings:
                limits[face] = [limits_of([part], name, True) for part in found[: self.n]]
            else:
                limits[face] = [limits_of(found, name, False)]
            if name in OF_DISPLACEMENT:
                continue
            low, high = min(float(part.min()) for part in found), max(float(part.max()) for part in found)
            stored[face] = low, high
            for row, part in zip(rows, found, strict=True):
                whole = np.rint((part - low) * (65535 / (high - low) if high > low else 0.0))
                row["values"][f"{name} {face}"] = self.blob.add(whole.astype("<u2"))
        largest = max(abs(limit) for pairs in limits.values() for pair in pairs for limit in pair)
        factor, unit = readable_unit(name, largest, self.show.style.units)
        short = {"displacement": "u", "velocity": "v"}.get(name, name)
        return {"name": name, "words": words(name), "short": short, "unit": unit, "factor": factor, "faces": through(name),
                "signed": signed(name), "limits": limits, "stored": stored}  # fmt: skip

    def _values(self, k: int, name: str, face: str) -> np.ndarray:
        moved = self.surfaces[k].displacement
        if name in OF_DISPLACEMENT:
            return np.linalg.norm(moved, axis=1) if name == "displacement" else moved[:, int(name[1]) - 1]
        return values(self.states[k], name, CUBIC, face or None)


def _note(state: Solution) -> str:
    return ", ".join(part for part in (state.note, "small deflections" if state.linear else "") if part)


def _hex(colours: Any) -> str:
    """256 colours of a map of matplotlib, six digits each."""
    return "".join(f"{r:02x}{g:02x}{b:02x}" for r, g, b in colours(np.arange(256), bytes=True)[:, :3].tolist())
