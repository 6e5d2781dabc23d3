"""Conditions that cannot be met together beyond a load factor: named, by every solver; limit points are none."""

import numpy as np
import pytest
import scipy.sparse as sp
from test_links_and_hinges import WIDTH, D, R, Slides, arch, hinged_ring

import skancf as sk
from skancf.linear import Constraints, least_squares
from skancf.solving import Status
from skancf.statics.contradictions import contradiction_ahead

STEEL = sk.Isotropic(young=7e10, poisson=0.3, density=2700.0)
RODS = [sk.RigidLink((x, 0.0), (x, np.pi / 2), name=f"rod at {x:g}") for x in (0.0, WIDTH)]
LIFT = 0.5 * R
"""Of a crown that rods from a foot let rise by (sqrt 2 - 1) R."""
STRIP = sk.Rectangle(2.0, 0.2)
LINE = [sk.RigidLink((0.0, 0.1), (1.0, 0.1), name="one"), sk.RigidLink((1.0, 0.1), (2.0, 0.1), name="two")]


def pressed(theory):
    crown = [(x, np.pi / 2) for x in (0.0, WIDTH)]
    return arch(*RODS, force=0.0, n=12, supports=[sk.Prescribed(crown, (None, None, LIFT))], theory=theory)


def lifted(theory):
    """By a condition that moves; nothing is prescribed."""
    lifts = [Slides((x, np.pi / 2), (0, 0, 1), LIFT, f"lift at {x:g}") for x in (0.0, WIDTH)]
    return arch(*RODS, *lifts, force=0.0, n=12, theory=theory)


def stretched(theory, right=(None, None, 2.6), hold=sk.Clamp):
    """A strip of 2 m between two rods in line, whose end goes 2.6 m up."""
    supports = [hold("left"), sk.Prescribed("right", right)]
    return sk.Problem(STRIP, 0.01, STEEL, supports, conditions=LINE).on(sk.meshes.uniform(STRIP, 8, 1), theory)


CASES = {
    "rods and a support": (pressed, "'rod at 0', 'rod at 0.05' and what supports prescribe", (np.sqrt(2) - 1) * R / LIFT),
    "rods and moving conditions": (lifted, "'rod at 0', 'rod at 0.05', 'lift at 0' and 'lift at 0.05'",
                                   (np.sqrt(2) - 1) * R / LIFT),
    "two rods": (stretched, "'one', 'two' and what supports prescribe", 2.0 / 2.6),
}  # fmt: skip
WAYS = {
    "solve": sk.solve, "load steps": lambda system: sk.solve(system, relax=False), "trace": sk.trace,
    "follow": lambda system: sk.solve(system, follow=True),
}  # fmt: skip


@pytest.mark.filterwarnings("ignore::skancf.OutOfDepth")
@pytest.mark.parametrize("theory", ["kirchhoff", "full"])
@pytest.mark.parametrize("case", CASES)
def test_who_contradicts_whom_and_from_where_on(case, theory):
    make, names, limit = CASES[case]
    system = make(theory)
    for way in WAYS if theory == "kirchhoff" else ("load steps", "trace"):
        found = WAYS[way](system)
        assert found.status is Status.CONTRADICTORY, way
        assert f"{names} cannot be met together beyond load factor {limit:.4g}," in found.message
        assert "limit point near" not in found.message and "mesh" not in found.message
        assert 0.97 * limit < found.solution.load_factor < limit
    assert sk.solve(system, load_factor=0.97 * limit, relax=False).status is Status.CONVERGED


def test_only_what_is_asked_about_contradicts():
    start, limit = sk.solve(pressed("kirchhoff"), load_factor=0.5).unwrap(), (np.sqrt(2) - 1) * R / LIFT
    system, q = start.system, start.q
    assert contradiction_ahead(system, q, 0.5, 0.999 * limit) is None
    assert contradiction_ahead(system, q, 0.5, -1.0) is None
    assert f"beyond load factor {limit:.4g}" in contradiction_ahead(system, q, 0.5, 1.001 * limit)
    assert contradiction_ahead(arch(force=1.0, n=12), q, 0.5, 2.0) is None


def test_rods_in_line_leave_it_but_get_no_longer():
    """To first order neither is possible."""
    system = stretched("kirchhoff", right=(-0.3, 0.0, 0.0), hold=sk.Pin)
    assert contradiction_ahead(system, system.undeformed, 0.0, 1.0) is None
    said = contradiction_ahead(system, system.undeformed, 0.0, -1.0)
    assert "'one', 'two' and what supports prescribe cannot be met together beyond load factor 0," in said


def test_a_limit_point_with_conditions_is_one():
    found = sk.solve(hinged_ring(-6.0 * D / R**2), relax=False)
    assert found.status in (Status.LIMIT_POINT, Status.BIFURCATION) and "contradict" not in found.message


def test_least_squares_of_equations_that_have_no_solution():
    """On a circle and a line that miss each other by c what is left is the same in both, and in a third nothing."""
    loose = Constraints(np.zeros((1, 3), bool))

    def solved(c, constraints=loose):
        return least_squares(
            lambda x: np.array([(x[:2] @ x[:2] - 1.0) / 2.0, x[1] - c, x[2] - 0.3]),
            lambda x: sp.csr_matrix([[x[0], x[1], 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
            np.array([0.8, 0.6, 0.0]), constraints, lambda g: bool(np.abs(g).max() < 1e-12),
        )  # fmt: skip

    for c in (0.9, 0.9999):
        x, rows = solved(c)
        assert rows.size == 0 and x == pytest.approx([np.sqrt(1 - c * c), c, 0.3], abs=1e-9)
    for c in (1.001, 1.5):
        x, rows = solved(c)
        assert sorted(rows) == [0, 1] and abs(x[0]) < 1e-3 and 1.0 < x[1] < c and x[2] == pytest.approx(0.3)
    x, rows = solved(0.9, Constraints(np.array([[False, False, True]])))
    assert rows.tolist() == [2] and x[2] == 0.0
