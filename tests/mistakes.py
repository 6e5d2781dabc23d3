"""Ordinary mistakes: a valid call of each public function, and what each of its arguments may be mistaken for.

``python -m tests.mistakes [seconds]`` looks further: at pairs of mistakes in one call, at random.
"""

import inspect
import math
import os
import re
import signal
import sys
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, fields, is_dataclass
from decimal import Decimal
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from mistaken_exchange import add_exchange
from mistaken_problems import add_problems

import skancf as sk
from skancf.adaptive.rings import Halvings

SECONDS = 60.0
"""Longest that any of the calls may take; the slowest valid one takes a fifth of a second."""


class OwnFault(Exception):
    """Raised by a function of the user."""


def fails(*_: Any) -> Any:
    raise OwnFault("mine")


def stops(*_: Any) -> Any:
    return next(iter(()))


class Scene:
    """Small objects of every kind."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.surface = sk.Rectangle(1.0, 1.0)
        self.material = sk.Isotropic(1e7, 0.3, 1e3)
        self.problem = sk.Problem(
            self.surface, 0.01, self.material, [sk.Clamp("left")], [sk.EdgeLoad("right", (0.0, 0.0, 0.01))]
        )
        self.pushed = sk.Problem(
            self.surface, 0.01, self.material, [sk.Clamp("left")], [sk.EdgeLoad("right", (-0.01, 0.0, 0.0))]
        )
        self.mesh = sk.meshes.quadtree(sk.meshes.uniform(self.surface, 2, 2))
        self.plain = sk.meshes.uniform(self.surface, 2, 2)
        self.region = sk.meshes.Region((0.5, 0.5), (0.25, 0.25))

    @cached_property
    def system(self) -> Any:
        return self.problem.on(self.mesh, "kirchhoff")

    @cached_property
    def pushed_system(self) -> Any:
        return self.pushed.on(self.mesh, "kirchhoff")

    @cached_property
    def finer(self) -> Any:
        return self.problem.on(self.mesh.refined([0]), "kirchhoff")

    @cached_property
    def result(self) -> Any:
        return sk.solve(self.system)

    @cached_property
    def solution(self) -> Any:
        return self.result.solution

    @cached_property
    def motion(self) -> Any:
        return sk.simulate(self.system, 0.02, dt=0.01, outputs=3, progress=False)

    @cached_property
    def path(self) -> Any:
        return sk.trace(self.system, until=0.5)

    @cached_property
    def modes(self) -> Any:
        return sk.modes(self.system, 2)

    @cached_property
    def buckled(self) -> Any:
        return sk.buckling(self.pushed_system, 1)

    @cached_property
    def spectrum(self) -> Any:
        t = np.linspace(0.0, 1.0, 33)
        return sk.spectrum(t, np.sin(40 * t))

    @cached_property
    def axes(self) -> Any:
        from matplotlib.figure import Figure

        return Figure().add_subplot(projection="3d")

    def flat_axes(self) -> Any:
        from matplotlib.figure import Figure

        return Figure().add_subplot()

    @cached_property
    def plotter(self) -> Any:
        import pyvista

        return pyvista.Plotter(off_screen=True, window_size=(100, 80))

    @cached_property
    def vtu(self) -> Path:
        return sk.output.write(self.solution, self.folder / "kept.vtu", subdivisions=1)

    @cached_property
    def run(self) -> Path:
        sk.simulate(self.system, 0.02, dt=0.01, outputs=3, progress=False, checkpoint=self.folder / "run")
        return self.folder / "run"

    @cached_property
    def tree(self) -> Path:
        return sk.meshes.save(self.mesh, self.folder / "tree.npz")


def mistakes(scene: Scene) -> dict[str, Any]:
    """What an argument may be mistaken for."""
    return {
        "problem": scene.problem, "system": scene.system, "mesh": scene.plain, "result": scene.result,
        "solution": scene.solution, "surface": scene.surface, "load": sk.Gravity(), "class": sk.Problem, "type": int,
        "none": None, "true": True, "text": "0.01", "word": "nonsense", "empty text": "", "bytes": b"0.01",
        "complex": 1 + 2j, "nan": float("nan"), "inf": float("inf"), "huge": 1e300, "tiny": 1e-300, "minus": -1,
        "zero": 0, "half": 0.5, "endless": 10**400, "many": 10**12, "list": [1.0, "2"], "empty": [], "dict": {},
        "set": {1.0}, "ragged": [[1.0], [1.0, 2.0]], "objects": np.array([None, object()]), "texts": np.array(["1", "2"]),
        "complexes": np.array([1j, 2.0, 3.0]), "nans": np.array([np.nan, 0.0, 0.0]), "cube": np.ones((2, 2, 2)),
        "row": np.ones(7), "nothing": np.empty((0, 3)), "nonsense object": object(), "generator": (v for v in (1.0, 2.0)),
        "sin": math.sin, "raises": fails, "returns nan": lambda *_: float("nan"), "returns text": lambda *_: "1",
        "returns none": lambda *_: None, "returns pair": lambda *_: (0.0, 0.0), "returns inf": lambda *_: float("inf"),
        "nan point": (float("nan"), 0.5), "names": ["left", "nonsense"], "name and none": ["left", [None]],
        "wrong shape": lambda *_: np.ones((5, 5)),
        "masked": np.ma.array([1.0, 2.0], mask=[1, 0]), "decimal": Decimal("0.5"), "short float": np.float16(0.5),
        "no object": np.array(None), "bytearray": bytearray(b"12"), "three bytes": b"abc", "truth and number": (True, 0.5),
        "stops": stops, "unwritable": "\ud800", "long name": 300 * "x",
    }  # fmt: skip


@dataclass(frozen=True)
class Call:
    """A valid call, by names.

    ``takes`` names what else an argument may be, beside what its kind allows: ``(argument, mistake)``. ``aliases`` are other
    words by which a message may name an argument, for example that of a whole of which it is a part.
    """

    function: Callable[..., Any]
    arguments: dict[str, Any]
    takes: frozenset[tuple[str, str]] = frozenset()
    kinds: dict[str, str] = field(default_factory=dict)
    aliases: dict[str, str] = field(default_factory=dict)


HALVES = {"half", "decimal", "short float"}
NUMBERS = {"huge", "tiny", "minus", "zero", "many", "endless", *HALVES}
"""Numbers of another size than usual: they may be refused or do, as long as the result is finite."""
FUNCTIONS = {"sin", "raises", "returns nan", "returns text", "returns none", "returns pair", "returns inf", "wrong shape",
             "stops"}  # fmt: skip

MAY_BE: dict[str, set[str]] = {
    "number": NUMBERS,
    "optional": NUMBERS | {"none"},
    "whole": {"many", "zero", "minus"},
    "numbers": {"row", "nothing", "empty", "cube"} | NUMBERS,
    "flag": {"true", "zero", "none"},
    "progress": {"true", "zero", *FUNCTIONS},
    "text": {"text", "word", "empty text", "long name", "none"},
    "items": {"empty", "none", "nothing"},
    "mapping": {"dict", "none"},
    "file": {"text", "word", "empty text", "long name"},
    "state": {"solution", "result", "none"},
    "mesh": {"mesh"},
    "problem": {"problem"},
    "system": {"system"},
    "surface": {"surface", "none"},
    "function": {*FUNCTIONS, "none"},
    "field": NUMBERS,
    "place": {"cube"},
    "any": set(),
}
"""What an argument of a kind may be without a fault."""


def kind_of(call: Call, name: str) -> str:
    """The kind of an argument, from what is valid for it."""
    if name in call.kinds:
        return call.kinds[name]
    if name in ("where", "mesh", "system", "surface", "progress"):
        return "place" if name == "where" else name
    value = call.arguments[name]
    for kind, types in (("flag", bool), ("whole", int), ("number", float), ("text", str), ("file", Path),
                        ("state", sk.Solution), ("problem", sk.Problem), ("mapping", dict)):  # fmt: skip
        if isinstance(value, types):
            return kind
    return "numbers" if isinstance(value, list | tuple | np.ndarray) else "any"


@dataclass(frozen=True)
class Fault:
    """What is wrong with the answer to a mistake."""

    call: str
    argument: str
    mistake: str
    what: str

    def __str__(self) -> str:
        return f"{self.call}({self.argument} = {self.mistake}): {self.what}"


CALLERS = {"adapt", "history", "simulate"}
"""Functions that call one of the user's, and let through what it raises."""


class TooLong(BaseException):
    """A call that took more than :data:`SECONDS`."""


@contextmanager
def bounded() -> Iterator[None]:
    def stop(*_: Any) -> None:
        raise TooLong

    before = signal.signal(signal.SIGALRM, stop)
    signal.setitimer(signal.ITIMER_REAL, SECONDS)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def answer(call: Call, **wrong: Any) -> tuple[Any, BaseException | None]:
    """Result or exception of a call with some arguments replaced."""
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        try:
            with bounded():
                return call.function(**{**call.arguments, **wrong}), None
        except (Exception, TooLong) as error:
            return None, error


def fault(name: str, call: Call, argument: str, mistake: str, value: Any) -> Fault | None:
    """What is wrong with the answer to one mistake; None where nothing is."""
    result, error = answer(call, **{argument: value})
    if any(re.search(rf"\b{argument}\b", note) for note in getattr(error, "__notes__", ())):
        return None  # raised by the user's own function
    if isinstance(error, OwnFault) and call.function.__name__ in CALLERS:
        return None
    if error is not None:
        if isinstance(error, TooLong):
            return Fault(name, argument, mistake, f"took more than {SECONDS} s")
        if mistake == "sin" and type(error) is TypeError and call.function.__name__ in CALLERS:
            return None  # what the user's own function raises for a state
        if not isinstance(error, sk.SkancfError):
            return Fault(name, argument, mistake, f"raw {type(error).__name__}: {error}")
        alias = call.aliases.get(argument)
        if not (re.search(rf"\b{re.escape(argument)}\b", str(error)) or (alias and alias in str(error))):
            return Fault(name, argument, mistake, f"does not name it: {error}")
        return None
    if not may_be(call, argument, mistake):
        return Fault(name, argument, mistake, "was taken")
    if mistake not in ("returns nan", "returns inf") and not is_finite(result):
        return Fault(name, argument, mistake, "result is not finite")
    return None


def may_be(call: Call, argument: str, mistake: str) -> bool:
    """Whether an argument may be that."""
    same = "half" if mistake in HALVES else mistake
    return mistake in MAY_BE[kind_of(call, argument)] or (argument, same) in call.takes


def is_finite(result: Any, depth: int = 3) -> bool:
    """Whether all numbers of a result are, as far as it is looked into."""
    if isinstance(result, float | np.ndarray | np.floating):
        array = np.asarray(result)
        return array.dtype.kind != "f" or bool(np.isfinite(array).all())
    if depth and is_dataclass(result) and not isinstance(result, type):
        return all(is_finite(getattr(result, part.name), depth - 1) for part in fields(result)
                   if part.name not in ("largest",))  # fmt: skip
    if depth and isinstance(result, tuple | list):
        return all(is_finite(part, depth - 1) for part in result)
    return True


def calls(scene: Scene) -> dict[str, Call]:
    """A valid call of every public function that has arguments to check."""
    s, out = scene, {}

    def add(name: str, function: Callable[..., Any], /, takes: str = "", kinds: dict[str, str] | None = None,
            aliases: dict[str, str] | None = None, **arguments: Any) -> None:  # fmt: skip
        pairs = frozenset(tuple(pair.split(":", 1)) for pair in takes.split(",") if pair)
        out[name] = Call(function, arguments, pairs, kinds or {}, aliases or {})  # type: ignore[arg-type]

    add_materials(add, s)
    add_histories(add)
    add_meshes(add, s)
    add_solvers(add, s)
    add_states(add, s)
    add_storage(add, s)
    add_adaptive(add, s)
    add_output(add, s)
    add_problems(add, s)
    add_exchange(add, s)
    return out


def add_materials(add: Any, s: Scene) -> None:
    add("Isotropic", sk.Isotropic, young=1e7, poisson=0.3, density=1e3, kind="3d", shear_correction=0.8, expansion=1e-5)
    add("Orthotropic", sk.Orthotropic, young=(1e7, 1e7, 1e7), poisson=(0.1, 0.1, 0.1), shear=(4e6, 4e6, 4e6), density=1e3,
        angle=0.1, kind="3d", shear_correction=0.8, expansion=(0.0, 0.0, 0.0))  # fmt: skip
    add("Anisotropic", sk.Anisotropic, matrix=1e7 * np.eye(6), density=1e3, angle=0.1, kind="3d", shear_correction=0.8,
        expansion=(0.0,) * 6)  # fmt: skip
    add_rubbers(add)
    add("Layer", sk.Layer, material=s.material, thickness=0.1, angle=0.1)
    add("Laminate", sk.Laminate, layers=[sk.Layer(s.material, 0.1)], offset=0.1, kinds={"layers": "items"})
    add("Damping", sk.Damping, mass=0.1, stiffness=0.1)
    add("Problem.on", s.problem.on, mesh=s.plain, theory="full", tolerance=0.01)
    add("through_thickness", sk.through_thickness, mesh=s.plain, thickness=0.1, n=2, n_z=2)
    add("Full", sk.Full, assumed=True, n_thickness=3)
    add("Kirchhoff", sk.Kirchhoff, assumed=True)


def energy(I1: Any, I2: Any, J: Any, parameters: Any) -> Any:
    return parameters[0] * (I1 - 3.0 - 2.0 * np.log(J)) + 1e6 * (J - 1.0) ** 2


def add_rubbers(add: Any) -> None:
    laws = {
        "NeoHooke": (sk.NeoHooke, {"shear": 1e6}),
        "MooneyRivlin": (sk.MooneyRivlin, {"c10": 4e5, "c01": 1e5}),
        "Ogden": (sk.Ogden, {"terms": [(1e6, 1.5), (-1e4, -2.0)]}),
        "Yeoh": (sk.materials.Yeoh, {"c10": 4e5, "c20": 1e4, "c30": 1e3}),
        "Gent": (sk.materials.Gent, {"shear": 1e6, "most": 30.0}),
    }
    for name, (law, own) in laws.items():
        add(name, law, **own, density=1e3, poisson=0.4, expansion=1e-4, takes="poisson:none")
        add(f"{name}, bulk", law, **own, density=1e3, bulk=1e7, expansion=1e-4, takes="bulk:none")
    add("Hyperelastic", sk.Hyperelastic, energy=energy, parameters=[1e6], density=1e3, incompressible=False, expansion=1e-4,
        transverse_shear=1e5, takes="transverse_shear:none", kinds={"energy": "function"})  # fmt: skip


def add_histories(add: Any) -> None:
    add("Table", sk.Table, times=[0.0, 1.0, 2.0], values=[0.0, 1.0, 0.0], kind="smooth")
    add("Path", sk.Path, times=[0.0, 1.0, 2.0], points=[(0.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
    add("Ramp", sk.Ramp, duration=1.0, start=0.5)
    add("Pulse", sk.Pulse, duration=1.0, start=0.5, shape="triangle")
    add("Ramp()", sk.Ramp(1.0), time=0.5)
    add("Pulse()", sk.Pulse(1.0), time=0.5)
    add("Table()", sk.Table([0.0, 1.0], [0.0, 1.0]), time=0.5, aliases={"time": "t ="})
    add("Path()", sk.Path([0.0, 1.0], [(0.0, 0.0), (1.0, 1.0)]), time=0.5, aliases={"time": "t ="})


def add_meshes(add: Any, s: Scene) -> None:
    m = sk.meshes
    opening = [((0.0, 0.5), (0.0, 0.5))]
    zone = sk.Zone("a", ((0.0, 0.3), (0.0, 1.0)), thickness=0.02)
    add("with_lines", m.with_lines, surface=s.surface, nx=2, ny=2, zones=[zone], beside=0.01, x=[0.5], y=[0.5],
        openings=opening, aliases={"nx": "elements", "ny": "elements"}, kinds={"zones": "items"},
        takes="openings:empty,openings:nothing,y:half,beside:none")  # fmt: skip
    add("uniform", m.uniform, surface=s.surface, nx=2, ny=2, openings=opening, aliases={"nx": "elements", "ny": "elements"},
        takes="openings:empty,openings:nothing")  # fmt: skip
    row = [0.0, 0.5, 1.0]
    add("tensor", m.tensor, surface=s.surface, x=row, y=row, openings=opening)
    add("graded", m.graded, surface=s.surface, regions=[s.region], nodes=49, finest=0.3, growth=1.5, transition=0.1,
        openings=opening[:0], kinds={"regions": "items", "transition": "optional", "finest": "number"},
        aliases={"nodes": "elements"})  # fmt: skip
    add("graded shape", m.graded, surface=s.surface, regions=[s.region], shape=(6, 6), kinds={"regions": "items"},
        aliases={"shape": "n"}, takes="shape:generator")  # fmt: skip
    add("graded coarse", m.graded, surface=s.surface, regions=[s.region], coarse=0.3, kinds={"regions": "items"})
    add("refined_in", m.refined_in, mesh=s.mesh, regions=[s.region], finest=0.3, coarse=0.5,
        kinds={"regions": "items", "coarse": "optional"})  # fmt: skip
    add("refined_in levels", m.refined_in, mesh=s.mesh, regions=[s.region], levels=1, kinds={"regions": "items"},
        takes="levels:none", aliases={"levels": "level"})  # fmt: skip
    add("quadtree", m.quadtree, mesh=s.plain, surface=s.surface)
    add("quadtree.refined", s.mesh.refined, times_or_ix=[0, 1], aliases={"times_or_ix": "refined"},
        takes="times_or_ix:returns pair")  # fmt: skip
    add(
        "quadtree.coarsened",
        s.mesh.refined().coarsened,
        elements=[0, 1],
        aliases={"elements": "coarsened"},
        takes="elements:true,elements:wrong shape,elements:returns pair",
    )
    add("quadtree.adapted", s.mesh.adapted, refine=[0], coarsen=[1], aliases={"refine": "refined", "coarsen": "coarsened"},
        takes="refine:true,coarsen:true,refine:returns pair,coarsen:returns pair")  # fmt: skip
    add("progression", m.progression, l_0=1.0, l_n=0.1, length=5.0)
    add("Region", m.Region, centre=(0.5, 0.5), half_size=(0.1, 0.1), ratio=4.0, value=1.0, kinds={"value": "optional"})
    add("Regions", m.Regions, regions=[s.region], cell=(0.1, 0.1), kinds={"regions": "items"})
    add("check_mesh", m.check_mesh, mesh=s.plain)
    add("save", m.save, mesh=s.mesh, path=s.folder / "saved.npz", aliases={"path": "file"})
    add("load", m.load, path=s.tree, aliases={"path": "file"})


def add_solvers(add: Any, s: Scene) -> None:
    add("solve", sk.solve, system=s.system, load_factor=0.5, control=sk.HalveAndGrow(), start=None, rtol=1e-6,
        max_iterations=20, mixed=True, follow=False, relax=True, backend="auto", progress=False,
        kinds={"control": "any", "start": "state"}, takes="control:none")  # fmt: skip
    add("solve_linear", sk.solve_linear, system=s.system, backend="auto")
    add("trace", sk.trace, system=s.system, control=sk.ArcLength(), until=0.1, steps=3, start=None, rtol=1e-6,
        max_iterations=10, mixed=True, backend="auto", progress=False,
        kinds={"control": "any", "start": "state", "until": "optional"}, takes="control:none")  # fmt: skip
    add("modes", sk.modes, system=s.system, n=2, state=s.solution, tolerance=1e-8, backend="auto", progress=False)
    add("buckling", sk.buckling, system=s.pushed_system, n=1, signs="positive", tolerance=1e-8, backend="auto",
        progress=False, takes="system:system")  # fmt: skip
    add("simulate", sk.simulate, system=s.system, t_end=0.01, dt=0.01, outputs=3, record={"a": lambda state: 1.0},
        velocity=sk.RigidVelocity(), start=None, balance=0.1, resume=False, newton_rtol=1e-4, backend="auto", check=False,
        progress=False,
        kinds={"start": "state", "velocity": "function", "balance": "optional", "newton_rtol": "optional", "dt": "optional"},
        takes="outputs:row")  # fmt: skip
    add("simulate steps", sk.simulate, system=s.system, t_end=0.01, rtol=1e-1, steps=sk.FixedStep(0.01), outputs=[0.0, 0.01],
        rule=sk.GeneralizedAlpha(), follow=sk.Follow(), checkpoint=None, progress=False, takes="steps:none,rule:none,"
        "follow:none,checkpoint:none", kinds={"checkpoint": "file"}, aliases={"checkpoint": "folder"})  # fmt: skip
    add("read_motion", sk.read_motion, system=s.system, folder=s.run, in_memory=False)
    add("Case", sk.Case, factor=1.0, time=0.5, takes="time:none")
    add("Checkpoint", sk.Checkpoint, folder=s.folder / "other", every=10, in_memory=True)
    t = np.linspace(0.0, 1.0, 33)
    add("spectrum", sk.spectrum, times=t, values=np.sin(20 * t), window="hann", detrend="linear", begin=0.0, end=1.0,
        padding=4, kinds={"begin": "optional", "end": "optional"}, aliases={"begin": "times", "end": "times"})  # fmt: skip
    add("HalveAndGrow", sk.HalveAndGrow, first=1.0, smallest=1e-3, cut=2.0, growth=2.0, easy=5)
    add("StepLength", sk.StepLength, smallest=1e-3, largest=10.0, easy=5, growth=1.5, cut=2.0)
    add("ArcLength", sk.ArcLength, first=0.1, steps=sk.StepLength())
    add("DisplacementControl", sk.DisplacementControl, at=(0.5, 0.5), direction=(0.0, 0.0, 1.0), to=0.1, first=0.1,
        steps=sk.StepLength())  # fmt: skip
    add("DisplacementReached", sk.DisplacementReached, at=(0.5, 0.5), direction=(0.0, 0.0, 1.0), value=0.1)
    add("FixedStep", sk.FixedStep, dt=0.1, smallest=1e-3)
    add("LocalError", sk.LocalError, rtol=1e-3, largest=0.1, smallest=1e-3, atol=1e-9, takes="largest:inf")
    add("EnergyBalance", sk.EnergyBalance, rtol=1e-3, largest=0.1, smallest=1e-3, takes="largest:inf")
    add("NewtonCount", sk.NewtonCount, dt=0.1, iterations=5, largest=0.1, smallest=1e-3, takes="largest:inf")
    add("GeneralizedAlpha", sk.GeneralizedAlpha, rho_inf=0.5)
    add("RigidVelocity", sk.RigidVelocity, velocity=(0.0, 0.0, 0.0), spin=(0.0, 0.0, 0.0), about=(0.0, 0.0, 0.0))


def add_storage(add: Any, s: Scene) -> None:
    add("sk.save", sk.save, thing=s.solution, path=s.folder / "solution.h5", what="all", aliases={"path": "file"},
        takes="thing:problem,thing:system,thing:mesh,thing:result,thing:surface,thing:load")  # fmt: skip
    kept = sk.save(s.solution, s.folder / "kept.h5")
    add("sk.load", sk.load, path=kept, aliases={"path": "file"})
    text = s.folder / "problem.toml"
    text.write_text(PROBLEM)
    add("read_problem", sk.read_problem, path=text, aliases={"path": "file"})
    add("run_file", sk.run_file, path=text, folder=s.folder / "results", progress=False, takes="folder:none",
        aliases={"path": "file"})  # fmt: skip
    x = np.linspace(0.0, 1.0, 7)
    add("Splined", sk.storage.Splined, x=x, y=x, values=np.ones((7, 7)), error=0.1)


PROBLEM = """
thickness = 0.01
surface = {type = "Rectangle", length_x = 1.0, length_y = 1.0}
material = {type = "Isotropic", young = 1e7, poisson = 0.3, density = 1e3}
supports = [{type = "Clamp", where = "left"}]
mesh = {type = "uniform", nx = 2, ny = 2}
theory = "kirchhoff"
analysis = {type = "modes", n = 1}
"""


def add_states(add: Any, s: Scene) -> None:
    state, place = s.solution, (0.5, 0.5)
    add("Solution", sk.Solution, system=s.system, q=state.q, velocity=0 * state.q, time=0.1, load_factor=1.0, linear=False,
        small=state.q - s.system.undeformed, note="a mode", multipliers=np.zeros(0), kinds={"time": "optional"},
        takes="velocity:none,small:none,note:unwritable,multipliers:none")  # fmt: skip
    points = np.array([[0.2, 0.4], [0.3, 0.9]])
    for name in ("displacement", "position"):
        add(f"Solution.{name}", getattr(state, name), at=place, z=0.001, kinds={"at": "numbers"})
    add("Solution.rotation", state.rotation, at=place)
    for name in ("section_forces", "recovered_section_forces", "shear_forces"):
        add(f"Solution.{name}", getattr(state, name), points=points, elements=[0, 1], takes="points:none,elements:none")
    for name in ("strains", "stresses", "recovered_strains", "recovered_stresses", "cauchy_stresses", "thickness_stretch"):
        add(f"Solution.{name}", getattr(state, name), points=points, z=0.001, elements=[0, 1], takes="elements:none")
    add_places(add, state, place)
    add("Solution.nodal_stresses", state.nodal_stresses, z=0.001)
    add("Solution.shear_share_of", state.shear_share_of, elements=np.ones(4, bool), takes="elements:none")
    add("Motion.at", s.motion.at, time=0.01)
    add("Motion.displacement", s.motion.displacement, at=place, z=0.001)
    add(
        "Motion.history",
        s.motion.history,
        quantity=lambda state: 1.0,
        kinds={"quantity": "function"},
        takes="quantity:returns nan",
    )
    add("Ledger.at", s.motion.ledger.at, times=[0.0, 0.01])
    add("PathResult.displacement", s.path.displacement, at=place)
    add("Modes.shape", s.modes.shape, i=0, size=0.1, kinds={"size": "optional"})
    add("BucklingResult.shape", s.buckled.shape, i=0, size=0.1, kinds={"size": "optional"})
    add("Spectrum.peaks", s.spectrum.peaks, count=1, prominence=0.1, takes="count:none")
    add("Spectrum.compare", s.spectrum.compare, natural=[6.0, 7.0], count=1, prominence=0.1, takes="count:none")


def add_places(add: Any, state: Any, place: Any) -> None:
    def along(start: Any, end: Any, n: Any, side: Any) -> Any:
        return state.along(start, end, n=n, side=side).columns

    def at(points: Any, side: Any) -> Any:
        return state.at(points, side=side).columns

    def draw_along(name: Any, axes: Any, units: Any) -> Any:
        return state.along((0.0, 0.5), (1.0, 0.5), n=3).plot(name, axes=axes, units=units)

    values = state.at(place)
    add("at columns", at, points=[place, (0.1, 0.2)], side=(1.0, 0.0), takes="side:none", kinds={"points": "numbers"})
    add("Solution.at", state.at, points=[place, (0.1, 0.2)], side=(1.0, 0.0), takes="side:none", kinds={"points": "numbers"})
    add("along", along, start=(0.0, 0.5), end=(1.0, 0.5), n=3, side=(0.0, 1.0), aliases={"start": "points", "end": "points"},
        takes="side:none,n:half")  # fmt: skip
    add("Solution.through_thickness", state.through_thickness, at=place, n=2, side=(1.0, 0.0), takes="side:none")
    add("PointValues.stress", values.stress, z=0.001, frame="global", measure="cauchy")
    add("PointValues.strain", values.strain, z=0.001)
    add("PointValues.unit", values.unit, name="M11")
    add("draw along", draw_along, name="M11", axes=Figure().subplots(), units=sk.Units(), takes="units:none,axes:none")
    add("Arc", sk.Arc, centre=(0.5, 0.5), radius=0.1, start=0.0, end=1.0)
    add("Solution.reactions", state.reactions, where="left", takes="where:none")
    add(
        "Solution.reaction_moment", state.reaction_moment, where="left", about=(0.0, 0.0, 0.0), takes="where:none,about:none"
    )
    add("Solution.reactions_by_support", state.reactions_by_support, about=(0.0, 0.0, 0.0), takes="about:none")
    add("envelope", sk.envelope, states=[state], quantity="u3", at=[place], takes="at:none,states:result",
        kinds={"states": "state", "at": "numbers"})  # fmt: skip
    add("envelope of a function", sk.envelope, states=[state], quantity=lambda state: state.load_factor,
        takes="states:result", kinds={"states": "state", "quantity": "function"})  # fmt: skip
    add("Strength", sk.Strength, tension=(3.0, 1.0), compression=(2.0, 1.0), shear=1.0, interaction=-0.4)
    add("Strength.used", sk.Strength((3.0, 1.0), (2.0, 1.0), 1.0).used, stress=np.ones(3), criterion="tsai-hill")
    add("utilisation", sk.utilisation, state=state, strength=1e6, criterion="tresca", at=[place],
        takes="criterion:none,at:none", kinds={"at": "numbers"})  # fmt: skip
    add("Units", sk.Units, length="mm", force="kN", time="ms", stress="MPa", energy="J", stated=("mm", "N", "s"),
        takes="length:none,force:none,time:none,stress:none,energy:none")  # fmt: skip
    add("Units.of", sk.Units().of, unit="N/m")
    add("Units.table", sk.Units().table, table=values, takes="table:result")
    for function in (sk.output.von_mises, sk.output.tresca, sk.output.principal_stresses, sk.output.principal_directions,
                     sk.output.signed_von_mises):  # fmt: skip
        add(function.__name__, function, stress=np.arange(12.0).reshape(2, 6))


def add_adaptive(add: Any, s: Scene) -> None:
    at, up = (0.5, 0.5), (0.0, 0.0, 1.0)
    add("adapt", sk.adapt, problem=s.problem, quantity=sk.Displacement(at), rtol=0.5, atol=0.0, mesh=s.plain,
        theory="kirchhoff", linear=True, load_factor=1.0, indicator="goal", marking=sk.Doerfler(), coarsening=sk.Below(),
        max_dofs=300, max_seconds=1.0, max_levels=1, backend="auto", progress=False,
        kinds={"max_seconds": "optional", "marking": "optional"}, aliases={"indicator": "indicators"},
        takes="mesh:none")  # fmt: skip
    add("adapt by", sk.adapt, problem=s.problem, quantity=sk.Displacement(at), rtol=0.1, mesh=s.plain, linear=True,
        indicator=sk.recovery_indicator, max_levels=1, kinds={"indicator": "any"},
        takes="mesh:none", aliases={"indicator": "indicators"})  # fmt: skip
    add("transfer", sk.transfer, state=s.solution, system=s.finer)
    add("remap", sk.remap, state=s.solution, system=s.finer, acceleration=0 * s.solution.q, settle=True, backend="auto",
        takes="acceleration:none")  # fmt: skip
    add("goal_estimate", sk.goal_estimate, state=s.solution, quantity=sk.Displacement(at), backend="auto", progress=False,
        halvings=Halvings(np.empty((2, 0)), np.empty(0)))  # fmt: skip
    add("theory_error", sk.theory_error, solution=s.solution, quantity=sk.Displacement(at), backend="auto", progress=False,
        takes="quantity:none")  # fmt: skip
    add("residual_indicator", sk.residual_indicator, state=s.solution, backend="auto")
    add("recovery_indicator", sk.recovery_indicator, solution=s.solution)
    for name in ("stress_indicator", "nodal_measure"):
        add(name, getattr(sk, name), solution=s.solution, components="in_plane", z=0.001, kinds={"z": "optional"})
    add("stress_regions", sk.stress_regions, solution=s.solution, components=["S11"], z=0.001, radius=2.0, size=1.0, cap=2.0,
        kinds={"z": "optional"})  # fmt: skip
    grid = np.stack(np.meshgrid(np.linspace(0, 1, 4), np.linspace(0, 1, 4)), axis=-1).reshape(-1, 2).T
    add("find_regions", sk.find_regions, points=grid, sigma=np.arange(16.0), spacing=0.3, positions=None, cell=0.3,
        radius=2.0, size=1.0, cap=2.0, takes="positions:none", kinds={"cell": "optional"})  # fmt: skip
    markings = {"share": [sk.Doerfler], "factor": [sk.Maximum, sk.Below],
                "fraction": [sk.FixedFraction]}  # fmt: skip
    add("Even", sk.Even, even=0.5, share=0.5)
    add("Even.marked", sk.Even().marked, indicators=np.arange(5.0))
    for marking, part in ((marking, part) for part, kinds in markings.items() for marking in kinds):
        add(marking.__name__, marking, **{part: 0.5})
        add(f"{marking.__name__}.marked", marking().marked, indicators=np.arange(5.0))
    add("AllElements.marked", sk.AllElements().marked, indicators=np.arange(5.0))
    add("Never.marked", sk.Never().marked, indicators=np.arange(5.0))
    add("Displacement", sk.Displacement, at=at, direction=up)
    add("Displacement.value", sk.Displacement(at).value, state=s.solution)
    add("Displacement.gradient", sk.Displacement(at).gradient, state=s.solution)
    add("Rotation", sk.Rotation, at=at, towards=up)
    add("Rotation.value", sk.Rotation(at, (1.0, 0.0, 0.0)).value, state=s.solution)
    add("ConditionForce", sk.ConditionForce, name="slit", direction=up, takes="direction:none")
    add("Reaction", sk.Reaction, direction=up)
    add("Reaction.value", sk.Reaction("left").value, state=s.solution)
    add("StrainEnergy.value", sk.StrainEnergy().value, state=s.solution)
    add("SectionForce", sk.SectionForce, component="M11", at=at, takes="at:none")
    add("SectionForce within", sk.SectionForce, component="M11", within=((0.0, 1.0), (0.0, 1.0)), takes="within:none")
    add("SectionForce.value", sk.SectionForce("M11").value, state=s.solution)
    add("Eigenfrequency", sk.Eigenfrequency, number=0, loaded=True)
    add("BucklingLoad", sk.BucklingLoad, number=0)
    add("Follow", sk.Follow, rtol=0.2, every=10, indicator=sk.recovery_indicator, max_dofs=1000, smallest=0.1, coarsest=0,
        energy=1.0, kinds={"indicator": "function", "energy": "optional"}, takes="max_dofs:half")  # fmt: skip


def add_output(add: Any, s: Scene) -> None:
    o, file = sk.output, {"path": "file"}
    times, png = np.linspace(0.0, 1.0, 5), s.folder / "chart.png"
    values = np.arange(9.0)
    add("sample", o.sample, solution=s.solution, subdivisions=1, z=0.001)
    add("write", o.write, states=s.solution, path=s.folder / "state.vtu", subdivisions=1, depths={"mid": 0.0},
        progress=False, cells="flat", aliases={**file, "states": ".pvd"},
        takes="depths:none,subdivisions:none", kinds={"depths": "mapping"})  # fmt: skip
    add("write many", o.write, states=[s.solution], path=s.folder / "states.pvd", subdivisions=1, depths={}, progress=False,
        cells="flat", takes="subdivisions:none",
        aliases={**file, "states": "state"},
        kinds={"states": "any"})  # fmt: skip
    add("read", o.read, path=s.vtu, aliases=file)
    add("save_table", o.save_table, path=s.folder / "table.csv", columns={"a": [1.0, 2.0]}, aliases=file)
    add("Columns", o.Columns, columns={"a": [1.0, 2.0]}, units={"a": "m"}, takes="units:none", kinds={"units": "mapping"})
    add("check_folder", o.check_folder, path=s.folder / "new", aliases={"path": "folder"}, takes="path:half")
    add("mesh_chart", o.mesh_chart, mesh=s.plain, path=png, surface=s.surface, regions=[s.region], points={"a": (0.5, 0.5)},
        title="a", aliases=file, takes="path:none", kinds={"regions": "items"})  # fmt: skip
    add("field_chart", o.field_chart, mesh=s.plain, values=values, path=png, label="a", surface=s.surface, title="a",
        limits=(0.0, 9.0), levels=5, show_mesh=True, aliases=file, takes="path:none,limits:none")  # fmt: skip
    histories, curve = {"a": times**2}, {"a": ([10.0, 100.0], [0.1, 0.01])}
    add("histories_chart", o.histories_chart, times=times, histories=histories, path=png, ylabel="a", title="a",
        xlabel="a", takes="path:none", aliases={"path": "file", "times": "'a'"})  # fmt: skip
    add("convergence", o.convergence, curves=curve, path=png, xlabel="a", ylabel="a", slopes=[1.0], title="a", aliases=file,
        takes="path:none,slopes:none")  # fmt: skip
    add("effectivity", o.effectivity, curves=curve, path=png, band=(0.9, 1.1), xlabel="a", title="a", takes="path:none",
        aliases=file)  # fmt: skip
    add("mesh_levels", o.mesh_levels, meshes=[s.plain], path=png, surface=s.surface, titles=["a"], values=[np.ones(4)],
        label="a", aliases=file, takes="path:none,titles:none,values:none", kinds={"meshes": "any"})  # fmt: skip
    add("spectrum_chart", o.spectrum_chart, spectra=s.spectrum, path=png, modes=[6.0], limit=20.0, title="a", ylabel="a",
        aliases={"path": "file", "modes": "natural"}, takes="path:none,modes:none,limit:none")  # fmt: skip
    on_axes = {
        o.mesh_chart: {"mesh": s.plain},
        o.field_chart: {"mesh": s.plain, "values": values},
        o.histories_chart: {"times": times, "histories": histories, "ylabel": "a"},
        o.convergence: {"curves": curve},
        o.effectivity: {"curves": curve},
        o.spectrum_chart: {"spectra": s.spectrum},
        o.mesh_levels: {"meshes": [s.plain]},
    }
    for chart, needed in on_axes.items():
        add(f"{chart.__name__} on axes", chart, **needed, ax=s.flat_axes(), takes="ax:none", aliases={"times": "'a'"},
            kinds={"meshes": "any"})  # fmt: skip
    add("draw_cells", o.draw_cells, axes=s.axes, cells=np.array([[[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]]),
        colours=np.ones((1, 4)), light=(0.5, -0.4, 0.8), stretch=(1.0, 1.0, 1.0))  # fmt: skip
    add("plot", o.plot, solution=s.solution, plotter=s.plotter, off_screen=True, takes="plotter:none,off_screen:none")
    add("write_html", o.write_html, states=s.solution, path=s.folder / "page.html", fields=["u3"], seconds_per_frame=0.1,
        aliases={**file, "fields": "field"}, takes="fields:none,states:result,states:solution",
        kinds={"states": "any"})  # fmt: skip
    from skancf.output.style import Style

    add("Style", Style, field="S11", z=0.0, scale=1.0, limits=(0.0, 1.0), view=(1.0, 1.0, 1.0), show_mesh=True,
        show_undeformed=False, title="a", subdivisions=2, size=(300, 200), units=sk.Units(),
        takes="limits:none,subdivisions:none,z:none,units:none")  # fmt: skip


SLOW = {
    "mesh_chart",
    "field_chart",
    "histories_chart",
    "convergence",
    "effectivity",
    "mesh_levels",
    "spectrum_chart",
    "plot",
    "write_html",
}
"""Calls of which a valid one takes a tenth of a second: of each argument's mistakes that may do, none is tried.

Nor is one in nonlinear statics ("solved"), which takes long under huge loads.
"""


def trials(scene: Scene, found: dict[str, Call]) -> Iterator[tuple[str, Call, str, str, Any]]:
    """Every argument of every call, with every mistake."""
    for name, call in found.items():
        for argument in call.arguments:
            for mistake, value in mistakes(scene).items():
                if not ((name in SLOW or " solved " in name) and may_be(call, argument, mistake)):
                    yield name, call, argument, mistake, value


def faults(scene: Scene, only: str = "") -> tuple[int, list[Fault]]:
    """How many mistakes were tried, and those with a wrong answer."""
    n, out = 0, []
    for name, call, argument, mistake, value in trials(scene, calls(scene)):
        if name.startswith(only):
            n += 1
            if found := fault(name, call, argument, mistake, value):
                out.append(found)
    return n, out


def search(scene: Scene, seconds: float, seed: int = 0) -> list[Fault]:
    """Pairs of mistakes at random: the call must still answer by an error of the library, or finite numbers."""
    rng, out, end = np.random.default_rng(seed), [], time.monotonic() + seconds
    found = [(name, call) for name, call in calls(scene).items() if len(call.arguments) > 1]
    while time.monotonic() < end:
        name, call = found[rng.integers(len(found))]
        names = rng.choice(list(call.arguments), 2, replace=False)
        wrong = mistakes(scene)
        picked = rng.choice(list(wrong), 2)
        result, error = answer(call, **{str(n): wrong[str(m)] for n, m in zip(names, picked, strict=True)})
        if (error is None and is_finite(result)) or isinstance(error, sk.SkancfError | OwnFault):
            continue
        what = "result is not finite" if error is None else f"raw {type(error).__name__}: {error}"
        out.append(Fault(name, " and ".join(names), " and ".join(picked), what))
    return out


def parameters(function: Callable[..., Any]) -> set[str]:
    """Names of the parameters that can be given by name."""
    return {p.name for p in inspect.signature(function).parameters.values() if p.kind is not p.VAR_KEYWORD}


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)  # names of files by mistake are written there
        made = Scene(Path(folder))
        if len(sys.argv) > 1 and sys.argv[1].replace(".", "").isdigit():
            print(*search(made, float(sys.argv[1])), sep="\n")
        else:
            begun = time.process_time()
            number, wrong = faults(made, *sys.argv[1:])
            print(*wrong, sep="\n")
            print(f"{len(wrong)} faults in {number} mistakes, {time.process_time() - begun:.1f} s")
