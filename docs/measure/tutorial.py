"""Run the code of the tutorials and how-to pages, compare what it prints with what they show, and renew their pictures.

From the folder of the repository, in two minutes:

    .venv/bin/python docs/measure/tutorial.py

Names of pages run these only, for example ``laminates`` or ``plate_with_hole``. The pictures go to docs/pictures.
tests/test_docs.py runs the same code without touching them.
"""

import contextlib
import io
import os
import re
import shlex
import shutil
import sys
import tempfile
import textwrap
from pathlib import Path
from typing import NamedTuple

from PIL import Image, ImageSequence

DOCS = Path(__file__).resolve().parent.parent
PAGES = {page.stem: page for page in [DOCS / "getting_started.rst", *sorted((DOCS / "tutorials").glob("*.rst"))]}
FRONT = DOCS / "index.rst"
HOWTO = {page.stem: page for page in sorted((DOCS / "howto").glob("*.rst")) if page.stem != "index"}
PICTURE = re.compile(r"(?:image|figure):: (?:\.\./)?pictures/((?:howto/)?\w+\.(?:png|gif))")
LIVE = re.compile(r'src="\.\./_static/(\w+\.html)"')
BLOCK = re.compile(r"^\.\. code-block:: (\w+)\n\n((?:(?:   .*)?\n)+)", re.MULTILINE)
DOWNLOAD = re.compile(r":download:`[^`<]*<(files/[\w.]+)>`")
NUMBER = re.compile(r"-?\d+\.\d+|-?\d+")


class Example(NamedTuple):
    """A piece of code, what the page says that it prints, and its line on the page."""

    code: str
    shown: str
    line: int


def pictures(page: Path) -> list[str]:
    """Files that the code of a page makes and the page shows, by their places in docs/pictures."""
    return PICTURE.findall(page.read_text(encoding="utf-8"))


def live(page: Path) -> list[str]:
    """Pages of their own that the code of a page makes and the page embeds, in docs/_static."""
    return LIVE.findall(page.read_text(encoding="utf-8"))


def examples(page: Path) -> list[Example]:
    """The Python blocks of a page; a block of plain text is what the one before it prints.

    A block of a terminal that begins with the command ``skancf`` runs it, and shows below what that prints.
    """
    text, found = page.read_text(encoding="utf-8"), []
    for match in BLOCK.finditer(text):
        language, body = match[1], textwrap.dedent(match[2]).strip("\n") + "\n"
        if language == "python":
            found.append(Example(body, "", text[: match.start(2)].count("\n") + 1))
        elif language == "console" and body.startswith("$ skancf "):
            command, _, shown = body.partition("\n")
            code = (
                "import contextlib\nimport sys\n\nfrom skancf.cli import main\n\n"
                f"with contextlib.redirect_stderr(sys.stdout):\n    main({shlex.split(command)[2:]})\n"
            )
            found.append(Example(code, shown, text[: match.start(2)].count("\n") + 1))
        elif language == "none":
            found[-1] = found[-1]._replace(shown=body)
    return found


def lay_out(page: Path, folder: Path) -> None:
    """Copy the files that a page offers for download, and that its code reads, to a folder."""
    for name in DOWNLOAD.findall(page.read_text(encoding="utf-8")):
        shutil.copy(page.parent / name, folder)


def run(found: list[Example]) -> list[str]:
    """Run them one after the other, in the present folder; what each prints."""
    names: dict[str, object] = {"__name__": "__main__"}
    printed = []
    for example in found:
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            exec(compile("\n" * (example.line - 1) + example.code, "<tutorial>", "exec"), names)
        printed.append(out.getvalue())
    return printed


def same(shown: str, printed: str) -> bool:
    """Equal words, and numbers equal up to one in the last digit shown: steps in time depend on rounding."""
    if NUMBER.sub("#", shown).split() != NUMBER.sub("#", printed).split():
        return False
    pairs = zip(NUMBER.findall(shown), NUMBER.findall(printed), strict=True)
    return all(abs(float(a) - float(b)) <= (1.01 * 10.0 ** -len(a.partition(".")[2]) if "." in a else 0) for a, b in pairs)


def keep_film(film: Image.Image, path: Path) -> None:
    """Store a film in a few colours, the same in all of its pictures."""
    frames = [frame.convert("RGB") for frame in ImageSequence.Iterator(film)]
    strip = Image.new("RGB", (film.width, film.height * len(frames)))
    for k, frame in enumerate(frames):
        strip.paste(frame, (0, k * film.height))
    colours = strip.quantize(64, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
    few = [frame.quantize(palette=colours, dither=Image.Dither.NONE) for frame in frames]
    few[0].save(path, save_all=True, append_images=few[1:], duration=film.info["duration"], loop=0, optimize=True)


def renew(page: Path) -> bool:
    """Run a page, store its pictures, and report; whether it prints what it shows."""
    found = examples(page)
    start = os.getcwd()
    with tempfile.TemporaryDirectory() as folder:
        lay_out(page, Path(folder))
        os.chdir(folder)
        try:
            printed = run(found)
        finally:
            os.chdir(start)
        for name in live(page):
            shutil.copyfile(Path(folder) / name, DOCS / "_static" / name)
        for name in pictures(page):
            kept = DOCS / "pictures" / name
            with Image.open(Path(folder) / Path(name).name) as picture:
                if kept.suffix == ".gif":
                    keep_film(picture, kept)
                    continue
                flat = picture.convert("RGB")
                flat.thumbnail((900, 900))
                flat = flat.quantize(256, dither=Image.Dither.NONE)  # a third of the bytes
                flat.save(kept, optimize=True)
    wrong = [(e, p) for e, p in zip(found, printed, strict=True) if not same(e.shown, p)]
    for example, given in wrong:
        print(f"{page.name}, line {example.line} shows\n{example.shown}but prints\n{given}")
    return not wrong


def main() -> None:
    pages = {"index": FRONT, **PAGES, **HOWTO}
    results = [renew(pages[name]) for name in sys.argv[1:] or pages]
    sys.exit(not all(results))


if __name__ == "__main__":
    main()
