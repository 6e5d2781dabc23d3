"""What the thin theory leaves out, as it is estimated from a thin answer, against that of theory full."""

from typing import Any

from hypothesis import reject
from hypothesis import strategies as st

import skancf as sk
from fuzz import bodies
from fuzz.assessment import bounded, seen, stated
from fuzz.bodies import among
from fuzz.case import Case, Mesh, place
from fuzz.shapes import open_sides

LEFT, SMALL = 0.3, 0.2
"""Of the estimate, which is of first order, may be missing where it is less than SMALL of the number."""
SETTLED = 0.2
"""Of the estimate: where the meshes leave more, nothing is known."""
SURFACES = ("rectangle", "cylinder", "annulus")


@st.composite
def asked(draw: Any) -> tuple[Case, Any]:
    """A sheet held on all edges or on one, isotropic, and a number of it."""
    surface = draw(st.one_of(*[bodies.SURFACES[name] for name in SURFACES]))
    # In thick shells theory full differs by more than shear, by terms of h / R.
    curved = isinstance(surface, sk.CylinderSector)
    thickness = 1.0 / draw(among(25.0, 40.0) if curved else among(10.0, 15.0, 25.0))
    material = sk.Isotropic(1e9, draw(bodies.POISSON), 1000.0)
    supports = [draw(among(sk.Clamp("boundary"), sk.SimpleSupport("boundary", "hard"), sk.Clamp(open_sides(surface)[:2])))]
    lines = tuple(k / 6 for k in range(7))
    problem = sk.Problem(surface, thickness, material, supports, [sk.SurfaceLoad((0.0, 0.0, -1e9 * thickness**4))])
    case = Case(problem, Mesh(lines, lines), "kirchhoff")
    middle = sk.Displacement(place(surface, (0.5, 0.5)))
    return case, draw(among(middle, sk.StrainEnergy()))


def holds(given: tuple[Case, Any]) -> None:
    """The estimate is most of the difference of the two theories."""
    case, quantity = given
    surface = case.problem.surface
    with stated():
        mesh = sk.meshes.quadtree(case.mesh.on(surface), surface)
        thin_answer = sk.solve_linear(case.problem.on(mesh, "kirchhoff"))
        estimate = sk.theory_error(thin_answer, quantity)
        thin = sk.goal_estimate(thin_answer, quantity)
        thick = sk.goal_estimate(sk.solve_linear(case.problem.on(mesh.refined(), "full")), quantity)
    left = thin.bar / 4 + thick.bar / 4
    if not estimate.sound or abs(estimate.share) > SMALL or left > SETTLED * abs(estimate.value):
        seen["theory not settled"] += 1
        reject()
    difference = thick.value + thick.error - thin.value - thin.error
    bounded("what is missing", abs(difference - estimate.value), LEFT * abs(estimate.value) + left)
