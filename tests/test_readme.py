"""The code of the README has no type errors, runs, and prints what is shown."""

import contextlib
import importlib.util
import io
import re
import subprocess
import sys
from pathlib import Path

import pytest

from skancf import SkancfError, output
from skancf.output.rendering import check_rendering

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```python\n(.*?)^```\n(?:\n```\n(.*?)^```\n)?", README, re.MULTILINE | re.DOTALL)
NUMBER = re.compile(r"-?\d[\d.]*(?:e-?\d+)?")
SHORTER = (("t_end=0.5", "t_end=0.02"), ("motion.at(0.5)", "motion.at(0.02)"), ("motion.at(0.1)", "motion.at(0.02)"))
"""The motion of the README takes ten seconds; here it takes less."""
CODE = "\n".join(code for code, _ in BLOCKS)


def test_the_first_example_is_a_shell_in_ten_lines_with_its_picture():
    code, shown = BLOCKS[0]
    assert "surface=sk.CylinderSector" in code and shown and len(code.strip().splitlines()) <= 15
    picture = re.search(r'<img src="([^"]+)"', README)
    assert README.index(code) < picture.start() < README.index("```python", README.index(code))
    assert (ROOT / picture[1]).stat().st_size > 10_000


@pytest.mark.skipif(importlib.util.find_spec("mypy") is None, reason="mypy is not installed")
def test_every_line_type_checks(tmp_path):
    file = tmp_path / "readme.py"
    file.write_text(CODE)
    strict = [sys.executable, "-m", "mypy", "--config-file", str(ROOT / "pyproject.toml"), "--strict-equality",
              "--check-untyped-defs", "--cache-dir", str(ROOT / ".mypy_cache"), str(file)]  # fmt: skip
    done = subprocess.run(strict, capture_output=True, text=True, timeout=300, cwd=ROOT)
    assert done.returncode == 0, done.stdout
    assert len(BLOCKS) >= 4


def test_it_runs_and_prints_what_is_shown(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    try:
        check_rendering()
    except SkancfError:
        monkeypatch.setattr(output, "picture", lambda *_, **__: None)
    names = {"__name__": "readme"}
    for code, shown in BLOCKS:
        for longer, shorter in SHORTER:
            code = code.replace(longer, shorter)
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            exec(compile(code, "README.md", "exec"), names)
        printed, shown = out.getvalue(), shown or out.getvalue()
        assert NUMBER.sub("#", printed).split() == NUMBER.sub("#", shown).split()
        # The first number; error bars depend on how results are rounded.
        first = float(NUMBER.search(printed)[0])
        assert first == pytest.approx(float(NUMBER.search(shown)[0]), rel=1e-5)
    events = [round(event.load_factor, 3) for event in names["path"].events]
    assert events == [0.742, 0.170]
