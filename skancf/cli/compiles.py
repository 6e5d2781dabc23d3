"""All kernels compiled, so that no later run has to."""

import time
from collections.abc import Callable
from functools import partial
from typing import Any

from skancf.compiling import announce
from skancf.dynamics import simulate
from skancf.loads import EdgeLoad, FollowerPressure
from skancf.materials import Isotropic, MooneyRivlin, NeoHooke, Ogden
from skancf.materials.hyperelastic.gent import Gent
from skancf.materials.hyperelastic.yeoh import Yeoh
from skancf.meshes import uniform
from skancf.problem import Problem
from skancf.progress import Bar
from skancf.statics import solve, solve_linear
from skancf.supports import Clamp
from skancf.surfaces import Rectangle
from skancf.system.system import System

THEORIES = ("kirchhoff", "full")
RUBBERS: dict[str, Callable[[], Any]] = {
    "NeoHooke": partial(NeoHooke, shear=1e6, density=1e3),
    "MooneyRivlin": partial(MooneyRivlin, c10=1e6, c01=1e5, density=1e3),
    "Yeoh": partial(Yeoh, c10=1e6, c20=0.0, c30=0.0, density=1e3),
    "Gent": partial(Gent, shear=1e6, most=50.0, density=1e3),
    "Ogden": partial(Ogden, [(1e6, 2.0)], density=1e3),
}


def compile_all() -> None:
    """Run small problems that need the kernels, and say how many were compiled."""
    from skancf.about import kernels

    begun, listener = time.perf_counter(), announce()
    before = listener.total
    with Bar("kernels", len(RUNS), True) as bar:
        for name, run in RUNS.items():
            run()
            bar.next(name)
    new = listener.total - before
    print(f"{new} kernels compiled in {time.perf_counter() - begun:.0f} s" if new else "all kernels are compiled already")
    print(kernels())


def _strip(theory: str, material: Any, loads: Any = ()) -> System:
    """A system of a small strip that is clamped at one end."""
    surface = Rectangle(2.0, 1.0)
    return Problem(surface, 0.05, material, [Clamp("left")], list(loads)).on(uniform(surface, 2, 1), theory)


def _plain(theory: str) -> None:
    system = _strip(theory, Isotropic(1e7, 0.3, 1e3), [EdgeLoad("right", (0.0, 0.0, 1.0)), FollowerPressure(1.0)])
    solve_linear(system)
    simulate(system, 0.002, dt=0.001, outputs=2, progress=False)


def _rubber(theory: str, name: str) -> None:
    system = _strip(theory, RUBBERS[name](), [EdgeLoad("right", (0.0, 0.0, 1.0))])
    solve(system, progress=False)


RUNS: dict[str, Callable[[], None]] = {
    **{f"theory {theory}": partial(_plain, theory) for theory in THEORIES},
    **{f"{name}, theory {theory}": partial(_rubber, theory, name) for theory in THEORIES for name in RUBBERS},
}
