"""The package as users get it: built, looked into, and run in environments of its own, away from the checkout.

    python .ci/wheel.py build              sdist and wheel into dist/, and what they hold
    python .ci/wheel.py try                the wheel in a clean environment of this Python: skancf info, and a small solve
    python .ci/wheel.py versions           tests with the oldest supported dependencies on the oldest Python, and with the
                                           newest on the newest, where these are to be had

Lower bounds of dependencies and of Python are read from pyproject.toml.
"""

import os
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
import time
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
DIST = ROOT / "dist"
NEWEST = "3.13"
TESTS = ["test_elements.py", "test_surfaces.py", "test_output.py", "test_statics.py", "test_version_bounds.py"]
"""Of elements, surfaces, files and pictures, and solves: what touches the dependencies, and takes a minute."""
SECONDS = 900
SOLVE = """
import pathlib, sys
import skancf as sk
assert not pathlib.Path(sk.__file__).is_relative_to(sys.argv[1]), f"the checkout was imported: {sk.__file__}"
assert (pathlib.Path(sk.__file__).parent / "py.typed").is_file()
strip = sk.Problem(sk.Rectangle(1.0, 0.1), 0.01, sk.Isotropic(210e9, 0.0, 7850.0), [sk.Clamp("left")],
                   [sk.EdgeLoad("right", (0.0, 0.0, 100.0))])
result = sk.solve_linear(strip.on(sk.meshes.uniform(strip.surface, 4, 1), "kirchhoff"))
w, beam = result.displacement((1.0, 0.05))[2], 10.0 / (3 * 210e9 * 0.1 * 0.01**3 / 12)
assert abs(w / beam - 1) < 1e-3, (w, beam)
print(f"sk {sk.__version__}: a cantilever bends by {w:.6g} m, beam theory says {beam:.6g} m")
"""


def project() -> dict:
    """The table ``project`` of pyproject.toml, of which this needs lists of texts only."""
    text = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    bounds = re.search(r"^dependencies = \[$(.*?)^\]$", text, re.MULTILINE | re.DOTALL)
    python = re.search(r'^requires-python = ">=([\d.]+)"$', text, re.MULTILINE)
    assert bounds and python, "pyproject.toml has no dependencies or no requires-python"
    return {"python": python[1], "dependencies": re.findall(r'^ +"(.+)",$', bounds[1], re.MULTILINE)}


def oldest(dependencies: list[str]) -> list[str]:
    """Each dependency that has a lower bound, pinned to it."""
    pins = []
    for each in dependencies:
        requirement, _, marker = each.partition(";")
        found = re.match(r"([\w.-]+)>=([\d.]+)", requirement)
        if found:
            pins.append(f"{found[1]}=={found[2]}" + (f";{marker}" if marker else ""))
    return pins


def run(*command: object, **options: object) -> None:
    subprocess.run([str(part) for part in command], check=True, timeout=SECONDS, **options)  # type: ignore[call-overload]


def interpreter(version: str) -> str | None:
    """A Python of a version that really starts, on the path or of pyenv."""
    folder = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv")) / "versions"
    for path in [shutil.which(f"python{version}"), *sorted(folder.glob(f"{version}.*/bin/python"), reverse=True)]:
        try:
            said = subprocess.run([str(path), "-c", "import sys, venv; print('%d.%d' % sys.version_info[:2])"],
                                  capture_output=True, text=True, timeout=60, check=False)  # fmt: skip
        except OSError:
            continue
        if path and said.stdout.strip() == version:
            return str(path)
    return None


def build() -> None:
    """sdist and wheel, with what belongs there and nothing else."""
    for old in DIST.glob("skancf-*"):
        old.unlink()
    run(sys.executable, "-m", "build", "--outdir", DIST, ROOT, stdout=subprocess.DEVNULL)
    wheel, sdist = wheel_file(), next(DIST.glob("skancf-*.tar.gz"))
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
    wrong = [
        name for name in names if not re.match(r"skancf(-[\w.]+\.dist-info)?/", name) or re.search(r"\.nb[ic]$|\.pyc$", name)
    ]
    assert not wrong, f"{wheel.name} holds what is not the package: {wrong[:5]}"
    sources = {path.relative_to(ROOT).as_posix() for path in (ROOT / "skancf").rglob("*.py")}
    assert not (missing := (sources | {"skancf/py.typed"}) - set(names)), f"{wheel.name} misses {sorted(missing)[:5]}"
    with tarfile.open(sdist) as archive:
        names = [name.partition("/")[2] for name in archive.getnames()]
    assert not (missing := (sources | {"pyproject.toml", "README.md", "LICENSE"}) - set(names)), f"sdist misses {missing}"
    print(f"{wheel.name}: {wheel.stat().st_size / 1e6:.1f} MB, {sdist.name}: {sdist.stat().st_size / 1e6:.1f} MB")


def wheel_file() -> Path:
    return next(DIST.glob("skancf-*.whl"))


def environment(folder: Path, python: str, *packages: str) -> Path:
    """The Python of a new environment with the wheel."""
    run(python, "-m", "venv", folder)
    inside = folder / ("Scripts" if os.name == "nt" else "bin") / "python"
    run(inside, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", wheel_file(), *packages)
    return inside


def attempt() -> None:
    """What a user does first, with the wheel."""
    with tempfile.TemporaryDirectory() as folder:
        python = environment(Path(folder) / "env", sys.executable)
        run(python.with_name("skancf"), "info", cwd=folder)
        run(python, "-W", "error::SyntaxWarning", "-c", SOLVE, ROOT, cwd=folder)


def versions() -> None:
    """The chosen tests, against the wheel, with the oldest and the newest of everything."""
    stated = project()
    for version, pins in ((stated["python"], oldest(stated["dependencies"])), (NEWEST, [])):
        what, began, python = "oldest" if pins else "newest", time.perf_counter(), interpreter(version)
        if python is None:
            print(f"Python {version} with the {what} dependencies: SKIPPED, there is no python{version} here that starts")
            continue
        print(f"Python {version} with the {what} dependencies", *pins, flush=True)
        with tempfile.TemporaryDirectory() as folder:
            inside = environment(Path(folder) / "env", python, *pins, "pytest>=8", "hypothesis>=6.100", "pytest-xdist>=3.5")
            tests = Path(folder) / "tests"
            shutil.copytree(ROOT / "tests", tests, ignore=shutil.ignore_patterns("__pycache__"))
            run(inside, "-m", "pytest", "-q", "-n", "auto", "--dist", "worksteal", "-p", "no:cacheprovider",
                "-W", "ignore::DeprecationWarning", *TESTS, cwd=tests,
                env={**os.environ, "PYTHONPATH": "", "SKANCF_EXPECTED": " ".join(pins)})  # fmt: skip
        print(f"{time.perf_counter() - began:.0f} s", flush=True)


if __name__ == "__main__":
    {"build": build, "try": attempt, "versions": versions}[sys.argv[1]]()
