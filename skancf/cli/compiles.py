"""All kernels compiled, so that no later run has to."""

import time
from collections.abc import Callable
from functools import partial
from typing import Any

from skancf.compiling import announce
from skancf.dynamics import simulate
from skancf.linear import available_backends
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
    "NeoHooke": partial(NeoHooke, shear=1e6, density=1e3, poisson=0.45),
    "MooneyRivlin": partial(MooneyRivlin, c10=1e6, c01=1e5, density=1e3, poisson=0.45),
    "Yeoh": partial(Yeoh, c10=1e6, c20=0.0, c30=0.0, density=1e3, poisson=0.45),
    "Gent": partial(Gent, shear=1e6, most=50.0, density=1e3, poisson=0.45),
    "Ogden": partial(Ogden, [(1e6, 2.0)], density=1e3, poisson=0.45),
}


def compile_all() -> None:
    """Run small problems that need the kernels, and say how many were compiled."""
    from skancf.about import kept_kernels

    begun, listener = time.perf_counter(), announce()
    before = listener.total
    with Bar("kernels", len(RUNS), True) as bar:
        for name, run in RUNS.items():
            run()
            bar.next(name)
    new = listener.total - before
    took = f"{new} kernel{'s' * (new != 1)} compiled in {time.perf_counter() - begun:.0f} s"
    print(took if new else "the kernels are compiled already")
    print(f"kept in {kept_kernels()[2]}")


def _strip(theory: str, material: Any, loads: Any, cells: tuple[int, int] = (2, 1)) -> System:
    """A system of a small strip that is clamped at one end."""
    surface = Rectangle(2.0, 1.0)
    return Problem(surface, 0.05, material, [Clamp("left")], list(loads)).on(uniform(surface, *cells), theory)


def _plain(theory: str) -> None:
    loads = [EdgeLoad("right", (0.0, 0.0, 1.0)), FollowerPressure(1.0)]
    system = _strip(theory, Isotropic(1e7, 0.3, 1e3), loads, cells=(16, 8))
    for backend in available_backends():
        solve_linear(system, backend=backend)
    simulate(system, 0.002, dt=0.001, outputs=2, progress=False)


def _rubber(theory: str, name: str) -> None:
    system = _strip(theory, RUBBERS[name](), [EdgeLoad("right", (0.0, 0.0, 1.0))])
    solve(system, progress=False)


RUNS: dict[str, Callable[[], None]] = {
    **{f"theory {theory}": partial(_plain, theory) for theory in THEORIES},
    **{f"{name}, theory kirchhoff": partial(_rubber, "kirchhoff", name) for name in RUBBERS},
    # Ogden's laws have no stress in solids.
    **{f"{name}, theory full": partial(_rubber, "full", name) for name in RUBBERS if name != "Ogden"},
}
