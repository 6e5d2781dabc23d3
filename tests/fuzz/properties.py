"""What must hold, each with the cases for which it must."""

from collections.abc import Callable
from typing import Any, NamedTuple

from hypothesis import strategies as st

import skancf as sk
from fuzz import bars, conditions, invariance, linear, motion, moving, nonlinear, theory, vibration, wrong
from fuzz.bodies import AFFINE, among
from fuzz.cases import EVERYTHING, NONLINEAR, UNITS, Frame, Range, cases, framed, free_bodies, parted


class Property(NamedTuple):
    """A strategy, a function that raises AssertionError, and how many examples the bounded run takes."""

    given: st.SearchStrategy[Any]
    holds: Callable[[Any], None]
    examples: int


SEEDS = st.integers(0, 1000)
SOFT = Range((0, 2), (-2, 0))
"""Loads that bend a plate by its thickness at most: one equilibrium, which a restart must find too."""


def _with_another_load() -> st.SearchStrategy[Any]:
    """Supports that stand still, and a second load."""
    return cases(moved=False, kinds=conditions.DEAD, units=False).flatmap(
        lambda case: st.tuples(st.just(case), conditions.loads(case.problem.surface, _section(case), 1.0, conditions.DEAD))
    )


def _section(case: Any) -> Any:
    from fuzz.bodies import Section

    problem = case.problem
    z = problem.section.z
    return Section(problem.material, problem.thickness, float(z[-1] - z[0]), float(problem.section.stiffness[0, 0, 0]))


_restated = st.tuples(framed(False), UNITS, SEEDS).map(lambda g: (g[0][0], g[0][1], g[1], g[2]))
PROPERTIES = {
    "balance": Property(cases(), linear.balance, 60),
    "moments": Property(cases(), linear.moments, 60),
    "clapeyron": Property(cases(), linear.clapeyron, 50),
    "reciprocity": Property(_with_another_load(), linear.reciprocity, 40),
    "superposition": Property(cases(), linear.superposition, 30),
    "nested": Property(
        cases(surfaces=AFFINE, kinds=conditions.DEAD, theories=st.just(sk.Kirchhoff(assumed=False)), moved=False,
              plain=True),
        linear.nested, 30,
    ),
    "units": Property(st.tuples(cases(units=False), UNITS), invariance.units, 40),
    "frame": Property(framed(False), invariance.frame, 50),
    "mirror": Property(framed(True), invariance.frame, 50),
    "numbering": Property(st.tuples(cases(), SEEDS), invariance.numbering, 40),
    "symmetry": Property(parted(within=EVERYTHING), invariance.symmetry, 40),
    "honest": Property(cases(within=NONLINEAR, most=3), nonlinear.honest, 60),
    "restart": Property(cases(within=SOFT, most=3), nonlinear.restart, 20),
    "small loads": Property(cases(within=SOFT, most=3), nonlinear.small_loads, 20),
    "vibration": Property(_restated, vibration.restated, 25),
    "free bodies": Property(free_bodies(), vibration.rigid, 30),
    "energy of motions": Property(
        st.one_of(moving.motions(moving.KEEPING), moving.motions(moving.KEEPING, free=True, loads=False)), motion.energy, 40,
    ),
    "small motions": Property(moving.motions(spin=False).map(moving.at_rest), motion.scaling, 20),
    "motions in a frame": Property(moving.restated("frame"), motion.restated, 25),
    "motions in units": Property(moving.restated("units"), motion.restated, 20),
    "restarted motions": Property(moving.motions(steps=among(10)), motion.restart, 8),
    "asked error": Property(moving.motions(among(sk.EnergyMomentum()), spin=False), motion.asked, 12),
    "bars": Property(bars.asked(), bars.holds, 12),
    "theory": Property(theory.asked(), theory.holds, 5),
    "refusals": Property(wrong.statements(), wrong.refused, 100),
}  # fmt: skip

__all__ = ["PROPERTIES", "Frame", "Property", "among"]
