"""Whether this machine can draw, asked where a crash does no harm."""

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache

from skancf.errors import SkancfError

PROBE = """
import vtkmodules.vtkRenderingOpenGL2
from vtkmodules.vtkRenderingCore import vtkRenderer, vtkRenderWindow
window = vtkRenderWindow()
window.SetOffScreenRendering(1)
window.SetSize(8, 8)
window.AddRenderer(vtkRenderer())
window.Render()
raise SystemExit(0 if window.SupportsOpenGL() else 1)
"""


@lru_cache(maxsize=1)
def check_rendering() -> None:
    """Make sure that pictures can be drawn without a screen.

    VTK ends the whole process with a segmentation fault where there is no OpenGL, so another process tries first;
    once, in about a second.

    Raises
    ------
    SkancfError
        If they cannot.
    """
    try:
        done = subprocess.run([sys.executable, "-c", PROBE], capture_output=True, timeout=60, check=False)
        reason = f"a trial ended with code {done.returncode}"
        works = done.returncode == 0
    except (OSError, subprocess.TimeoutExpired) as error:
        works, reason = False, f"a trial could not be run: {error}"
    if not works:
        raise SkancfError(
            f"no pictures on this machine: VTK finds no OpenGL ({reason}). Install a software driver (on Debian and "
            "Ubuntu: apt-get install libegl1 libgl1-mesa-dri), or run under xvfb-run, or write the state with "
            "skancf.output.write and open it in ParaView elsewhere"
        )


@contextmanager
def quiet() -> Iterator[None]:
    """Keep VTK's remarks on a missing screen from the terminal; errors still show."""
    from vtkmodules.vtkCommonCore import vtkLogger

    before = vtkLogger.GetCurrentVerbosityCutoff()
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_ERROR)
    try:
        yield
    finally:
        vtkLogger.SetStderrVerbosity(before)
