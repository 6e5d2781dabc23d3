"""Errors from meshes that are quartered everywhere: against fine meshes, and when they are not trusted."""

from functools import cache
from math import pi

import numpy as np
import pytest

import skancf as sk
from skancf.adaptive.nested import Nested, extrapolated
from skancf.adaptive.refined import Refined
from skancf.errors import InputError

SQUARE = sk.Rectangle(1.0, 1.0)
MATERIAL = sk.Isotropic(1e7, 0.3, 1.0)
DOWN = sk.SurfaceLoad((0, 0, -1.0))
UP = (0, 0, -1)
CENTRAL = sk.Displacement((0.5, 0.5), UP)
L_SHAPE = sk.Rectangle(2.0, 2.0, origin=(-1.0, -1.0))
ROOF = sk.CylinderSector(1.0, 1.0, 0.8, start=pi / 2 - 0.4)


def plate(slenderness, *supports, surface=SQUARE, material=MATERIAL):
    return sk.Problem(surface, 1 / slenderness, material, list(supports or [sk.Clamp("boundary")]), [DOWN])


def hard(slenderness):
    return plate(slenderness, sk.SimpleSupport("boundary", "hard"))


def on_l():
    return sk.meshes.uniform(L_SHAPE, 4, 4, openings=[((0.0, 1.0), (-1.0, 0.0))])


# --- the rule --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("order", [4.0, 16.0])
def test_extrapolation(order):
    smooth = [7 + 2 * order**-k for k in range(3)]
    assert extrapolated(*smooth, order) == pytest.approx(7 - smooth[-1], rel=1e-9)
    # Some of what falls by two only: all of it is found where that is the case, and none of what falls more slowly lost.
    mixed = [7 + 2 * order**-k + 0.05 * 2.0**-k / order for k in range(3)]
    assert extrapolated(*mixed, order) == pytest.approx(7 - mixed[-1], rel=1e-9)
    # Faster than the order: no less than the order says.
    fast = [7 + 2 * (1.2 * order) ** -k for k in range(3)]
    assert abs(extrapolated(*fast, order)) > abs(7 - fast[-1])


@pytest.mark.parametrize("values", [(1.0, 1.5, 1.75), (1.0, 2.0, 1.8), (1.0, 1.0, 1.0), (1.0, 1.1, 1.1), (1.0, 1.9, 2.0)])
def test_values_that_do_not_fall_at_the_order_are_not_trusted(values):
    assert extrapolated(*values, 4.0) is None


def test_meshes_must_be_quartered_everywhere():
    problem = plate(10)
    tree = sk.meshes.quadtree(sk.meshes.uniform(SQUARE, 2, 2), SQUARE)
    whole, part = tree.refined(), tree.refined([0])
    nested = Nested(CENTRAL)

    def estimate(value):
        return sk.adaptive.estimate.Estimate(value, -value / 3, np.ones(1), sk.Solution(problem.on(tree, "full"),
                                             problem.on(tree, "full").undeformed), 0.25)  # fmt: skip

    nested.add(tree, estimate(1.0))
    nested.add(whole, estimate(0.5))
    assert nested.values == [1.0, 0.5]
    nested.add(whole.refined(), estimate(0.4))
    assert nested.values == [0.5, 0.4]
    nested.add(part, estimate(0.3))
    assert nested.values == [0.3]
    nested.add(part.refined(np.flatnonzero(part.levels < part.levels.max())), estimate(0.2))
    assert nested.values == [0.2]


# --- bars ------------------------------------------------------------------------------------------------------------


@cache
def everywhere(name):
    cases = {
        "clamped 7": (plate(7), CENTRAL, None), "hard 7": (hard(7), CENTRAL, None), "clamped 25": (plate(25), CENTRAL, None),
        "hard 25": (hard(25), sk.StrainEnergy(), None),
        "L": (plate(10, surface=L_SHAPE), sk.Displacement((-0.5, 0.5), UP), on_l()),
        "L energy": (plate(10, surface=L_SHAPE), sk.StrainEnergy(), on_l()),
        "roof": (plate(20, surface=ROOF), sk.Displacement((0.5, pi / 2), UP), None),
        "soft": (plate(20, sk.SimpleSupport("boundary", "soft")), CENTRAL, None),
    }  # fmt: skip
    problem, quantity, mesh = cases[name]
    return sk.adapt(problem, quantity, 1e-9, theory="full", linear=True, mesh=mesh, max_levels=4, marking=sk.AllElements())


LIMITS = {"L": 3.9526e-6, "L energy": 2.3626e-6}
"""Of adaptive runs to 3e-4; those of others are extrapolated from their own values."""


@pytest.mark.parametrize("name", ["clamped 7", "hard 7", "clamped 25", "hard 25", "L", "L energy", "roof", "soft"])
def test_bars_hold(name):
    result = everywhere(name)
    values = [level.value for level in result.levels]
    limit = LIMITS.get(name, values[-1] + (values[-1] - values[-2]) / 3)
    errors = np.abs(limit - np.array(values))
    taken = [k for k, level in enumerate(result.levels) if level.nested]
    assert (name == "soft") == (not taken), "the soft support's boundary layer is not resolved"
    for k in taken:
        if k < 3 or name in LIMITS:
            assert 1.1 * abs(result.levels[k].error) > 0.9 * errors[k]
            assert abs(result.levels[k].error) < 1.5 * errors[k]
    if taken and taken[-1] == 3:
        assert result.error_bar >= 1.1 * abs(result.levels[-1].error)


def test_indicators_add_up():
    result = everywhere("hard 7")
    for before, level in zip(result.levels[1:], result.levels[2:], strict=False):
        if level.nested:
            assert level.indicators.shape == (level.n_elements,) and (level.indicators >= 0).all()
            assert 0.2 * before.indicators.sum() < level.indicators.sum() < 0.5 * before.indicators.sum()


def test_theory_kirchhoff_too():
    problem = sk.Problem(SQUARE, 0.01, MATERIAL, [sk.SimpleSupport("boundary", "hard")], [DOWN])
    result = sk.adapt(problem, CENTRAL, 1e-12, linear=True, max_levels=4, marking=sk.AllElements())
    exact = 0.00406235266 / (1e7 * 0.01**3 / 12 / 0.91)
    taken = [level for level in result.levels if level.nested]
    assert taken
    for level in taken:
        assert 0.9 * abs(exact - level.value) < 1.1 * abs(level.error) < 4 * abs(exact - level.value)


def test_large_deflections_and_frequencies():
    load = sk.SurfaceLoad((0, 0, -2e3))
    problem = sk.Problem(SQUARE, 0.1, MATERIAL, [sk.Clamp("boundary")], [load])
    for quantity, options in ((CENTRAL, {}), (sk.Eigenfrequency(0), {"linear": True})):
        result = sk.adapt(problem, quantity, 1e-9, theory="full", max_levels=3, marking=sk.AllElements(), **options)
        last = result.levels[-1]
        finer = sk.adapt(problem, quantity, 1e-9, theory="full", mesh=last.mesh.refined(), max_levels=1, **options)
        error = abs(finer.corrected - last.value)
        assert last.nested and 0.9 * error < 1.1 * abs(last.error) < 1.5 * error


# --- what it costs ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("problem, rtol", [(hard(7), 1e-3), (plate(7), 1e-3), (plate(25), 1e-3), (hard(25), 2e-3)])
def test_no_dearer_than_five_uniform_meshes(problem, rtol, monkeypatch):
    """Counted in nodal coordinates of all systems that are solved, against the first uniform mesh that is as good."""
    solved, begin = [], Refined.__init__

    def counted(self, *arguments, **options):
        begin(self, *arguments, **options)
        solved.append(self.system.n_dofs)

    monkeypatch.setattr(Refined, "__init__", counted)
    result = sk.adapt(problem, CENTRAL, rtol, theory="full", linear=True)
    assert result.ok and any(level.nested for level in result.levels)
    spent = sum(solved) + sum(level.n_dofs for level in result.levels)
    limit = result.levels[-1].value + (result.levels[-1].value - result.levels[-2].value) / 3
    uniform = next(level for level in result.levels if abs(level.value - limit) <= rtol * abs(limit))
    assert spent <= 5 * uniform.n_dofs
    assert abs(result.value - limit) <= 1.1 * result.error_bar


def test_default_grows_locally_at_a_corner():
    result = sk.adapt(plate(10, surface=L_SHAPE), sk.StrainEnergy(), 2e-2, theory="full", linear=True, mesh=on_l())
    assert result.ok
    assert any(level.n_hanging for level in result.levels), "quartered where the corner has most of the error"
    assert abs(result.value / LIMITS["L energy"] - 1) < 2e-2


def test_fewer_where_all_are_too_many():
    problem = hard(10)
    options = {"theory": "full", "linear": True, "max_dofs": 3300}
    result = sk.adapt(problem, CENTRAL, 1e-6, **options)
    even = sk.adapt(problem, CENTRAL, 1e-6, marking=sk.AllElements(), **options)
    assert even.levels[-1].n_dofs < result.levels[-1].n_dofs <= 3300


# --- marking ---------------------------------------------------------------------------------------------------------


def test_even_marks_all_or_the_fewest():
    assert sk.Even(0.6).marked([1.0, 1.2, 0.9, 1.1]).tolist() == [0, 1, 2, 3]
    rough = [100.0, 1.0, 1.0, 1.0, 1.0]
    # (10 + 4)^2 / (5 * 104) = 0.377
    assert sk.Even(0.37).marked(rough).tolist() == [0, 1, 2, 3, 4]
    assert sk.Even(0.38).marked(rough).tolist() == sk.Doerfler(0.9).marked(rough).tolist() == [0]
    assert sk.Even().marked(np.zeros(3)).tolist() == [] and sk.Even().marked(np.empty(0)).tolist() == []
    assert sk.Even().marked(1e-300 * np.ones(3)).tolist() == [0, 1, 2]
    for wrong in ({"even": 0.0}, {"even": 1.5}, {"share": 0.0}):
        with pytest.raises(InputError, match="greater than 0 and at most 1"):
            sk.Even(**wrong)
