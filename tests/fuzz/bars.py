"""Error bars hold: the estimate on a coarse mesh against the answer on a mesh four times as fine, with its own estimate."""

from typing import Any

from hypothesis import reject
from hypothesis import strategies as st

import skancf as sk
from fuzz import bodies, conditions
from fuzz.assessment import bounded, seen, stated
from fuzz.bodies import among, decades
from fuzz.case import Case, Mesh, place
from fuzz.shapes import open_sides

LEAST = 0.8
"""Of the error, on a first mesh."""
SURFACES = ("rectangle", "parallelogram", "cylinder", "annulus", "cone", "sphere", "saddle")
LOADS = ("surface", "edge", "pressure", "gravity")
INSIDE = among(0.5, 0.25, 0.75, 0.3)
SETTLED = 0.1
"""Of the coarse error: where the fine mesh is not that much better, nothing is known."""


@st.composite
def asked(draw: Any) -> tuple[Case, Any]:
    """A sheet of moderate thickness on edges, on four by four elements, and a number of it that has a limit."""
    surface = draw(st.one_of(*[bodies.SURFACES[name] for name in SURFACES]))
    section = draw(bodies.sections(among(5.0, 10.0, 20.0, 50.0)))
    sides = open_sides(surface)
    # One that holds it alone, and perhaps others.
    held = draw(among(*sides))
    supports: list[Any] = [draw(among(sk.Clamp(held), sk.Clamp([held, *sides[:2]]), sk.SimpleSupport("boundary", "hard")))]
    if draw(st.booleans()):
        supports.append(sk.SimpleSupport(draw(among(*sides))))
    load = draw(conditions.loads(surface, section, draw(decades(-3, 0)), LOADS))
    lines = tuple(k / 4 for k in range(5))
    problem = sk.Problem(surface, section.thickness, section.material, supports, [load])
    case = Case(problem, Mesh(lines, lines), draw(among("kirchhoff", sk.Kirchhoff(assumed=False))))
    at = place(surface, (draw(INSIDE), draw(INSIDE)))
    corners = place(surface, (0.25, 0.5)), place(surface, (0.75, 1.0))
    of_means = st.builds(sk.SectionForce, among("N11", "M11", "M22"), within=st.just(tuple(zip(*corners, strict=True))))
    of_points = st.builds(sk.Displacement, st.just(at), conditions.DIRECTIONS)
    quantity = draw(st.one_of(of_points, st.just(sk.StrainEnergy()), of_means))
    return case, quantity


def holds(given: tuple[Case, Any]) -> None:
    """The bar is not much smaller than the distance to the limit."""
    case, quantity = given
    with stated():
        mesh = sk.meshes.quadtree(case.mesh.on(case.problem.surface), case.problem.surface)
        coarse, fine = (
            sk.goal_estimate(sk.solve_linear(case.problem.on(m, case.theory)), quantity) for m in (mesh, mesh.refined(2))
        )
    limit = fine.value + fine.error
    error = abs(limit - coarse.value)
    if fine.bar > SETTLED * error:
        seen["not settled"] += 1
        reject()
    bounded("part of the error", LEAST * error, coarse.bar + fine.bar)
