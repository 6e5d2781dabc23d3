"""Valid calls of surfaces, supports, loads and functions of time, each made and used on a mesh: see ``tests.mistakes``."""

import functools
from collections.abc import Callable
from typing import Any

import skancf as sk

DT = 0.01
THEORIES = ("full", "kirchhoff")
FIELDS = {"pressure": "field", "change": "field", "gradient": "field", "static": "optional"}
"""Kinds of arguments of loads and supports that are numbers or functions of place."""


def used(kind: Callable[..., Any], use: Callable[[Any], Any], fixed: dict[str, Any] | None = None) -> Callable[..., Any]:
    """A class whose call makes an object of it and gives what its use gives."""

    @functools.wraps(kind, updated=())
    def made(**arguments: Any) -> Any:
        return use(kind(**{**(fixed or {}), **arguments}))

    return made


class Uses:
    """What is done with a surface, a support or a load: on a mesh, in statics and over a step of time."""

    def __init__(self, s: Any, theory: str) -> None:
        self.s, self.theory = s, theory

    def _solved(self, supports: list[Any], loads: list[Any], moves: bool) -> Any:
        s = self.s
        system = sk.Problem(s.surface, 0.01, s.material, supports, loads).on(s.plain, self.theory)
        if moves:
            return sk.simulate(system, DT, dt=DT, progress=False).at(DT).q
        solution = sk.solve_linear(system)
        return solution.q, solution.reactions()

    def load(self, load: Any) -> Any:
        return self._solved([sk.Clamp("left")], [load], False)

    def solved_load(self, load: Any) -> Any:
        problem = sk.Problem(self.s.surface, 0.01, self.s.material, [sk.Clamp("left")], [load])
        return sk.solve(problem.on(self.s.plain, self.theory)).solution.q

    def moving_load(self, load: Any) -> Any:
        return self._solved([sk.Clamp("left")], [load], True)

    def support(self, support: Any) -> Any:
        return self._solved([sk.Clamp("left"), support], [sk.Gravity()], False)

    def moving_support(self, support: Any) -> Any:
        return self._solved([support], [], True)

    def surface(self, surface: Any) -> Any:
        mesh = sk.meshes.uniform(surface, 2, 2)
        system = sk.Problem(surface, 0.001, self.s.material, [sk.Clamp("boundary")], [sk.Gravity()]).on(mesh, self.theory)
        return system.undeformed, system.stiffness().values


def add_problems(add: Any, s: Any) -> None:
    add_sections(add, s)
    add_surfaces(add, s)
    add_loads(add, s)
    add_supports(add, s)
    add_joints(add, s)
    add_places(add, s)


def add_sections(add: Any, s: Any) -> None:
    """Problems and zones, made into systems: their functions of place are called then."""
    where = ((0.0, 0.5), (0.0, 1.0))
    kinds = {"thickness": "field", "offset": "field", "where": "any"}
    for theory in THEORIES:

        def on(problem: Any, theory: str = theory) -> Any:
            system = problem.on(s.plain, theory)
            return system.undeformed, system.stiffness().values

        def zone(zone: Any, theory: str = theory) -> Any:
            return on(sk.Problem(s.surface, 0.01, s.material, [sk.Clamp("left")], zones=[zone]), theory)

        add(f"Problem {theory}", used(sk.Problem, on), surface=s.surface, thickness=0.01, material=s.material,
            supports=[sk.Clamp("left")], loads=[sk.Gravity()], damping=sk.Damping(), terms=[], offset=0.001,
            zones=[sk.Zone("a", where, thickness=0.02)], conditions=[sk.RigidLink((0.2, 0.3), (0.8, 0.7))],
            takes="damping:none",
            kinds={"supports": "items", "loads": "items", "zones": "items", "conditions": "items", **kinds})  # fmt: skip
        add(f"Zone {theory}", used(sk.Zone, zone), name="a", where=where, thickness=0.02, material=s.material, offset=0.001,
            takes="thickness:none,material:none,offset:none", kinds=kinds)  # fmt: skip


def add_surfaces(add: Any, s: Any) -> None:
    use = Uses(s, "full").surface

    def surface(kind: Any, /, takes: str = "", **arguments: Any) -> None:
        add(kind.__name__, used(kind, use), takes, aliases=dict.fromkeys(arguments, "surface"), **arguments)

    surface(sk.Rectangle, length_x=1.0, length_y=1.0, origin=(0.0, 0.0))
    surface(sk.Parallelogram, length_x=1.0, length_y=1.0, angle=1.0)
    surface(sk.AnnulusSector, inner=0.5, outer=1.0, angle=1.0, start=0.1, closed=False)
    surface(sk.CylinderSector, radius=1.0, length=1.0, angle=1.0, start=0.1, closed=False)
    surface(sk.Cone, radius_low=1.0, radius_high=2.0, height=1.0, angle=1.0, start=0.1, closed=False)
    surface(sk.SphereSector, radius=1.0, polar=(0.5, 1.5), angle=1.0, start=0.1, closed=False)
    surface(sk.HyperbolicParaboloid, length_x=1.0, length_y=1.0, rise=0.1)
    surface(sk.MappedSurface, function=lambda x, y: (x, y, 0.1 * x * y), bounds=((0.0, 1.0), (0.0, 1.0)),
            sides=("a", "b", "c", "d"), closed=(False, False),
            exact_derivatives=lambda x, y: ((1, 0, 0.1 * y), (0, 1, 0.1 * x)), step=0.01,
            takes="exact_derivatives:none")  # fmt: skip


def add_loads(add: Any, s: Any) -> None:
    def load(
        kind: Any, /, takes: str = "", name: str = "", moves: bool = False, fixed: Any = None, **arguments: Any
    ) -> None:
        aliases = {k: v for k, v in {"at": "point", "radius": "disk"}.items() if k in arguments}
        for theory in THEORIES:
            use = Uses(s, theory)
            kinds = {k: FIELDS[k] for k in FIELDS if k in arguments}
            add(f"{kind.__name__} {name} {theory}", used(kind, use.moving_load if moves else use.load, fixed), takes,
                kinds=kinds, aliases=aliases, **arguments)  # fmt: skip
            if not moves and theory == "kirchhoff":
                add(f"{kind.__name__} {name} solved {theory}", used(kind, use.solved_load, fixed), takes,
                    kinds=kinds, aliases=aliases, **arguments)  # fmt: skip

    at, up = (0.5, 0.5), (0.0, 0.0, 0.1)
    times: dict[str, Any] = {"moves": True, "takes": "history:none,history:sin", "history": lambda t: t}
    load(sk.PointForce, at=at, force=up)
    load(sk.PointForce, name="in time", fixed={"at": at, "force": up}, **times)
    load(sk.PointMoment, at=at, moment=(0.0, 0.1, 0.0))
    load(sk.PointMoment, name="in time", fixed={"at": at, "moment": (0.0, 0.1, 0.0)}, **times)
    load(sk.DiskForce, at=at, radius=0.1, force=up)
    load(sk.DiskForce, name="in time", fixed={"at": at, "radius": 0.1, "force": up}, **times)
    for kind, given in ((sk.EdgeLoad, "force"), (sk.EdgeMoment, "moment")):
        load(kind, where="right", **{given: lambda x, y: (x, y, 0.0)})
        load(kind, name="in time", fixed={"where": "right", given: up}, **times)
    load(sk.LineLoad, start=(0.1, 0.1), end=(0.9, 0.2), force=lambda x, y: (x, y, 0.0))
    load(sk.LineLoad, name="in time", fixed={"start": (0.1, 0.1), "end": (0.9, 0.2), "force": up}, **times)
    load(sk.SurfaceLoad, force=lambda x, y: (x, y, 0.0))
    load(sk.SurfaceLoad, name="in time", fixed={"force": up}, **times)
    load(sk.FollowerPressure, pressure=lambda x, y: x)
    load(sk.FollowerPressure, name="constant", pressure=1.0)
    load(sk.FollowerPressure, name="in time", fixed={"pressure": 1.0}, **times)
    load(sk.Gravity, acceleration=up)
    load(sk.Gravity, name="in time", **times)
    load(sk.Temperature, change=lambda x, y: x, gradient=lambda x, y: y)
    load(sk.Temperature, name="constant", change=1.0, gradient=0.1)
    load(sk.Temperature, name="in time", fixed={"change": 1.0}, **times)
    load(sk.MovingForce, path=lambda t: (t, 0.5), force=up, **{**times, "takes": times["takes"] + ",path:returns pair"})
    load(sk.MovingLine, start=lambda t: (t, 0.2), end=(0.5, 0.9), force=lambda x, y: (x, y, 0.0),
         **{**times, "takes": times["takes"] + ",start:returns pair,end:returns pair"})  # fmt: skip
    load(sk.Impulse, at=at, impulse=up, time=0.005, moves=True)
    load(sk.EdgeImpulse, where="right", impulse=lambda x, y: (x, y, 0.0), time=0.005, moves=True)


def add_supports(add: Any, s: Any) -> None:
    def support(
        kind: Any, /, takes: str = "", name: str = "", moves: bool = False, fixed: Any = None, **arguments: Any
    ) -> None:
        for theory in THEORIES:
            use = Uses(s, theory)
            add(
                f"{kind.__name__} {name} {theory}",
                used(kind, use.moving_support if moves else use.support, fixed),
                takes,
                kinds={k: FIELDS[k] for k in FIELDS if k in arguments},
                aliases={"where": "Symmetry"},
                **arguments,
            )

    for kind in (sk.Pin, sk.Clamp, sk.NoRotation, sk.Symmetry):
        support(kind, where="right")
    support(sk.SimpleSupport, where="right", kind="hard")
    support(sk.Roller, where="right", direction=(0.0, 0.0, 1.0), kind="soft")
    support(sk.Spring, where="right", stiffness=lambda x, y: (1.0, 1.0, y))
    support(sk.Spring, name="constant", where="right", stiffness=(0.0, 0.0, 1.0))
    support(sk.Dashpot, where="right", damping=lambda x, y: (1.0, 1.0, y))
    support(sk.Foundation, stiffness=lambda x, y: 1.0 + x, direction=(0.0, 0.0, 1.0),
            takes="direction:none,stiffness:half,stiffness:many")  # fmt: skip
    support(sk.Foundation, name="constant", stiffness=1.0)
    support(sk.Prescribed, where="right", displacement=lambda x, y: (None, 0.0, 0.001 * y),
            rotation=lambda x, y: (0.0, 0.0, 0.0), takes="displacement:none,rotation:none")  # fmt: skip
    support(sk.Prescribed, name="constant", where="right", displacement=(None, 0.0, 0.001))
    support(sk.Prescribed, name="in time", history=lambda t: t, moves=True, takes="history:none,history:sin",
            fixed={"where": "left", "displacement": (0.0, 0.0, 0.001)})  # fmt: skip
    support(sk.DrivenClamp, where="right", axis=(0.0, 0.0, 1.0), through=(0.0, 0.0, 0.0), static=0.0,
            angle=lambda t: t, displacement=lambda t: (t, 0.0, 0.0),
            takes="angle:sin,angle:none,displacement:none")  # fmt: skip
    support(sk.DrivenClamp, name="in time", moves=True, angle=lambda t: t**2, displacement=lambda t: (t**2, 0.0, 0.0),
            fixed={"where": "left"}, takes="angle:sin,angle:none,displacement:none")  # fmt: skip


def add_joints(add: Any, s: Any) -> None:
    tube = sk.CylinderSector(radius=1.0, length=1.0, angle=6.283185307179586)
    for theory in THEORIES:

        def solved(joint: Any, surface: Any = s.surface, theory: str = theory) -> Any:
            clamped = sk.Clamp(lambda x, y: abs(y - y.max() / 2) < 1e-6) if surface is tube else sk.Clamp("left")
            problem = sk.Problem(surface, 0.01, s.material, [clamped], [sk.Gravity()], conditions=[joint])
            solution = sk.solve_linear(problem.on(sk.meshes.uniform(surface, 2, 4), theory))
            return solution.q, solution.multipliers

        add(f"RigidLink {theory}", used(sk.RigidLink, solved), a=(0.2, 0.3), b=(0.8, 0.7), name="rod")
        add(f"Hinge {theory}", used(sk.Hinge, functools.partial(solved, surface=tube)), first="start", second="end",
            name="slit", aliases={"first": "where", "second": "where"})  # fmt: skip


def add_places(add: Any, s: Any) -> None:
    """Places of what is asked of a solution, and starts of runs."""
    add("Solution.reactions", s.solution.reactions, where="left", takes="where:none")
    add("Reaction where", used(sk.Reaction, lambda asked: (asked.value(s.solution), asked.gradient(s.solution))),
        where="left", direction=(0.0, 0.0, 1.0), takes="where:none")  # fmt: skip
    add("simulate velocity", sk.simulate, system=s.system, t_end=DT, dt=DT, velocity=lambda x, y: (x, y, 0.0),
        progress=False, kinds={"dt": "optional"}, takes="velocity:none")  # fmt: skip
