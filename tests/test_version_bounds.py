"""Lower bounds of dependencies: those that pyproject.toml states, and, where a run asks for it, those that are installed."""

import importlib.metadata
import importlib.util
import os
import re
from pathlib import Path

import pytest

PROGRAM = Path(__file__).resolve().parent.parent / ".ci" / "wheel.py"


@pytest.mark.skipif(not PROGRAM.exists(), reason="tests of an installed package, away from its checkout")
def test_oldest_versions_are_those_of_pyproject():
    specification = importlib.util.spec_from_file_location("wheel", PROGRAM)
    wheel = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(wheel)
    stated = wheel.project()
    assert re.fullmatch(r"3\.\d+", stated["python"])
    pins = wheel.oldest(stated["dependencies"])
    assert {"numpy", "scipy", "numba", "pyvista", "meshio", "matplotlib", "h5py", "scikit-fem"} <= {
        p.split("==")[0] for p in pins
    }
    made = wheel.oldest(["a>=1.2,<3", "llvmlite", "b-c>=2; python_version < '3.11'"])
    assert made == ["a==1.2", "b-c==2; python_version < '3.11'"]
    assert wheel.interpreter("1.5") is None


def test_a_run_with_pinned_versions_has_them():
    for pin in re.findall(r"([\w.-]+)==([\d.]+)(?!;)", os.environ.get("SKANCF_EXPECTED", "")):
        try:
            installed = importlib.metadata.version(pin[0])
        except importlib.metadata.PackageNotFoundError:
            continue  # of another Python or machine
        assert installed.startswith(pin[1]), pin
