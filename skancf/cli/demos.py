"""Examples with published numbers, small enough for every machine."""

from collections.abc import Callable
from dataclasses import dataclass
from math import pi, radians

import numpy as np

from skancf.arguments import choice
from skancf.atomic import AnyPath, check_folder
from skancf.errors import SkancfError
from skancf.loads import PointForce
from skancf.materials import Isotropic
from skancf.meshes import uniform
from skancf.problem import Problem
from skancf.solution import Solution
from skancf.statics import solve, trace
from skancf.supports import Pin, Prescribed, Symmetry
from skancf.surfaces import CylinderSector, SphereSector


@dataclass(frozen=True)
class Outcome:
    """What an example has to show: a table with titles, states, and how to draw the last one."""

    titles: tuple[str, ...]
    rows: np.ndarray
    states: tuple[Solution, ...]
    look: dict[str, object]


@dataclass(frozen=True)
class Demo:
    """An example: what it is in a sentence, where its published numbers are from, and how it is computed."""

    says: str
    source: str
    run: Callable[[], Outcome]


def hemisphere() -> Outcome:
    """Outward and inward displacements at a quarter, a half, three quarters and the whole of the load, (4, 5)."""
    rim, quarter, force = pi / 2, pi / 2, 400.0
    surface = SphereSector(10.0, polar=(radians(18), rim), angle=2 * pi, closed=True)
    pulled, pinched = [(rim, 0.0), (rim, 2 * quarter)], [(rim, quarter), (rim, 3 * quarter)]
    between = [(rim, (k + 0.5) * quarter) for k in range(3)]
    shell = Problem(
        surface=surface,
        thickness=0.04,
        material=Isotropic(6.825e7, 0.3, density=1.0),
        # By symmetry none of these carries a force.
        supports=[
            Prescribed(pulled, (None, 0.0, None)), Prescribed(pinched, (0.0, None, None)),
            Prescribed(between, (None, None, 0.0)),
        ],
        loads=[
            PointForce(pulled[0], (force, 0.0, 0.0)), PointForce(pulled[1], (-force, 0.0, 0.0)),
            PointForce(pinched[0], (0.0, -force, 0.0)), PointForce(pinched[1], (0.0, force, 0.0)),
        ],
    )  # fmt: skip
    system = shell.on(uniform(surface, 12, 48), "kirchhoff")
    states: list[Solution] = []
    rows = []
    for factor, outwards, inwards in ((0.25, 2.596, 3.833), (0.5, 3.406, 5.902), (0.75, 3.816, 7.234), (1.0, 4.067, 8.178)):
        start = states[-1] if states else None
        states.append(solve(system, load_factor=factor, start=start).unwrap())
        found = states[-1].displacement(pulled[0])[0], -states[-1].displacement(pinched[0])[1]
        rows.append((factor * force, found[0], outwards, found[1], inwards))
    titles = ("force", "outwards", "published", "inwards", "published")
    look = {"field": "displacement", "view": (-0.4, -1.0, 0.75), "show_undeformed": False}
    return Outcome(titles, np.array(rows), tuple(states), look)


def roof() -> Outcome:
    """Load factors at the limit points of the snap, (2, 2)."""
    quarter = CylinderSector(radius=2.54, length=0.254, angle=0.1, start=pi / 2 - 0.1)
    crown = (0.254, pi / 2)
    shell = Problem(
        surface=quarter,
        thickness=0.0127,
        material=Isotropic(3102.75e6, 0.3, density=1200.0),
        supports=[Pin("start"), Symmetry("end"), Symmetry("right")],
        loads=[PointForce(crown, (0.0, 0.0, -750.0))],
    )
    path = trace(shell.on(uniform(quarter, 8, 8), "kirchhoff"), until=1.0).unwrap()
    limits = [event.load_factor for event in path.events if event.kind == "limit point"]
    rows = np.column_stack([np.multiply(3000.0, limits), np.multiply(3000.0, [0.7421, 0.1729])])
    return Outcome(("limit load (N)", "published"), rows, path.solutions, {"field": "displacement"})


SZE = "Sze, Liu and Lo (2004), Finite Elements in Analysis and Design 40, 1551-1569"
DEMOS = {
    "hemisphere": Demo(
        "A hemisphere, 0.4 % as thick as its radius, is pulled at two points of its rim and pinched at the two between.",
        SZE, hemisphere,
    ),
    "roof": Demo(
        "A shallow roof snaps through under a force at its crown; its path goes beyond both limit points.", SZE, roof
    ),
}  # fmt: skip


def show_demo(name: str, folder: AnyPath, *, listed: bool = False) -> None:
    """Solve an example, print its table, and write its picture and its states for ParaView to a folder."""
    if listed:
        for known, demo in DEMOS.items():
            print(f"{known:<12}{demo.says}")
        return
    choice("demo", name, DEMOS)
    place, demo = check_folder(folder), DEMOS[name]
    print(f"{demo.says}\n")
    found = demo.run()
    print("  ".join(f"{title:>14}" for title in found.titles))
    for row in found.rows:
        print("  ".join(f"{value:14.5g}" for value in row))
    print(f"\nPublished: {demo.source}.\n")
    _draw_and_write(name, found, place)


def _draw_and_write(name: str, found: Outcome, place: object) -> None:
    from skancf.output import picture, write
    from skancf.output.rendering import check_rendering

    try:
        check_rendering()
        print(f"picture         {picture(found.states[-1], f'{place}/{name}.png', **found.look)}")
    except SkancfError as none:
        print(f"picture         none: {none}")
    file = write(found.states, f"{place}/{name}.pvd")
    print(f"for ParaView    {file}")
