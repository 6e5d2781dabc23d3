"""The benchmark of error bars: its scenes, their right values, and the rule for them."""

import json
from dataclasses import replace
from math import pi, radians

import numpy as np
import pytest
from reference import two_membranes

import skancf as sk
from benchmarks.bars import assessment, references, run
from benchmarks.bars.formulas import FORMULAS
from benchmarks.bars.statement import FOLDER, kirsch, made, scenes
from benchmarks.bars.two_membranes import Plate

SCENES = {scene.name: scene for scene in scenes()}
RIGHT = json.loads((FOLDER / "references.json").read_text(encoding="utf-8"))


def stored(values: list[float], bars: list[float], right: float, uncertainty: float = 0.0, outcome: str = "REACHED") -> dict:
    levels = [{"value": v, "bar": b, "dofs": 10, "rejected": False} for v, b in zip(values, bars, strict=True)]
    head = {"scene": "made up", "asked": "a number", "kinds": [], "rtol": 1e-2, "right": right, "uncertainty": uncertainty}
    return {**head, "levels": levels, "outcome": outcome, "message": "", "seconds": 0.0}


def test_each_number_that_is_asked_for_has_a_right_value_that_is_known_well_enough():
    for scene in SCENES.values():
        for asked in scene.asked:
            right = RIGHT[scene.name][asked.name]
            least = min(asked.tolerances) * abs(right["value"])
            assert right["uncertainty"] <= least / 20, (scene.name, asked.name)
            assert right["source"]


def test_there_are_enough_runs_of_every_kind():
    runs = [(kind, rtol) for s in SCENES.values() for a in s.asked for rtol in a.tolerances for kind in s.kinds]
    assert sum(len(a.tolerances) for s in SCENES.values() for a in s.asked) >= 200
    words = "plate corner change pole hole shell membrane force foundation temperature buckling prescribed nonlinear thick"
    kinds = {*words.split(), "laminate", "frequency"}
    assert {kind for kind, _ in runs} == kinds


@pytest.mark.parametrize("name", SCENES)
def test_a_scene_is_a_problem_that_the_library_takes(name: str):
    scene = SCENES[name]
    around = any(getattr(scene.problem.surface, "closed", ()))
    system = scene.problem.on(scene.start() or scene.mesh(4, 8 if around else 4), scene.theory)
    assert system.n_dofs > 0


def test_two_membranes_are_those_of_navier_and_of_biquadratic_elements():
    square = Plate([0, 1], [0, 1], False, lambda x, y: np.array([x, y]), 3, 6)
    assert square.deflection(np.array([0.5, 0.5])) == pytest.approx(FORMULAS["navier"]("w")[0], rel=1e-8)
    assert square.energy == pytest.approx(FORMULAS["navier"]("energy")[0], rel=1e-8)
    assert square.eigenvalue() == pytest.approx(2 * pi**2, rel=1e-8)
    skew = sk.Parallelogram(1.0, 1.0, radians(70))
    found = Plate([0, 1], [0, 1], False, skew.position, 5, 5).deflection(
        skew.position(np.array([0.5]), np.array([0.5]))[:2, 0]
    )
    assert found == pytest.approx(two_membranes.rhombic_centre(radians(70), 64), rel=1e-5)  # what its 64 elements leave


def test_a_reentrant_corner_needs_the_singular_moment():
    """Without it the L-shape would be two thirds too soft; the energy is the published one, with all its digits."""

    def at(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return np.array([x, y])

    plate = Plate([-1, 0, 1], [-1, 0, 1], True, at, 9, 4)
    assert 2 * plate.energy == pytest.approx(0.0124005, rel=3e-5)
    without = Plate([-1, 0, 1], [-1, 0, 1], False, at, 3, 4)
    assert without.energy > plate.energy


def test_values_on_meshes_of_halved_size_are_extrapolated():
    h = 0.5 ** np.arange(5)
    values = (1 + 0.3 * h**4 - 0.2 * h**5 + h**6).tolist()
    limit, doubt = references.romberg(values, (4, 5, 6, 7))
    assert abs(limit - 1) < 1e-12 and abs(limit - 1) <= doubt + 1e-15
    assert references.aitken(1 + 0.1, 1 + 0.01, 1 + 0.001) == pytest.approx(1.0, abs=1e-13)


def test_the_sheet_with_a_hole_is_in_balance():
    angle = np.linspace(0, pi / 2, 200_001)
    x, y, _ = kirsch(1.0, 0.0)(3.0, angle)
    # The cut through the hole carries what the outer edge does.
    r = np.linspace(1.0, 3.0, 200_001)
    hoop = 0.5 * (1 + 1 / r**2) + 0.5 * (1 + 3 / r**4)
    assert np.trapezoid(x, angle) * 3 == pytest.approx(np.trapezoid(hoop, r), rel=1e-8)
    beside = 0.5 * (1 + 1 / r**2) - 0.5 * (1 + 3 / r**4)
    assert np.trapezoid(y, angle) * 3 == pytest.approx(np.trapezoid(beside, r), rel=1e-8)


def test_data_are_objects():
    assert made({"Clamp": ["left"]}) == sk.Clamp("left")
    assert made([{"degrees": 180}, {"AnnulusSector": {"inner": 0, "outer": 1}}]) == (pi, sk.AnnulusSector(0, 1))
    place = made({"line": ["y", 0, 0, 0.5]})
    assert place(0.25, 0.0) and not place(0.75, 0.0) and not place(0.25, 0.5)


def test_the_rule_sees_a_bar_that_is_too_small():
    good = stored([1.1, 1.01], [0.09, 0.0095], 1.0)
    assert assessment.summary([good]).holds and not list(assessment.broken(good))
    assert "on mesh 1 of 10 dofs" in next(assessment.broken(stored([1.1, 1.01], [0.079, 0.01], 1.0)))
    assert "on mesh 2 of 10 dofs" in next(assessment.broken(stored([1.1, 1.01], [0.1, 0.0089], 1.0)))
    rejected = stored([1.1, 1.05, 1.01], [0.1, 0.01, 0.01], 1.0)
    rejected["levels"][1]["rejected"] = True
    assert not list(assessment.broken(rejected))


def test_the_rule_sees_bars_that_are_too_large():
    good, large = stored([1.01], [0.01], 1.0), stored([1.01], [0.031], 1.0)
    assert assessment.summary([good] * 19 + [large]).holds
    assert not assessment.summary([good] * 18 + [large]).holds
    assert not assessment.summary([stored([1.01], [0.016], 1.0)] * 3).holds


def test_errors_below_the_uncertainty_count_apart():
    found = assessment.summary([stored([1.0004], [1e-6], 1.0, uncertainty=1e-4), stored([1.01], [0.01], 1.0)])
    assert (found.unknown, found.assessed) == (1, 1) and found.holds


def test_zeros_must_be_held_and_reached():
    assert not list(assessment.broken(stored([1e-18], [1e-17], 0.0)))
    assert "bar" in next(assessment.broken(stored([1e-18], [1e-19], 0.0)))
    assert "zero" in next(assessment.broken(stored([1e-18], [1e-17], 0.0, outcome="BUDGET")))
    assert "NO_LIMIT" in next(assessment.broken(stored([1.01], [0.01], 1.0, outcome="NO_LIMIT")))


def test_a_run_is_stored_with_the_bar_of_each_mesh():
    scene = SCENES["square, clamped"]
    asked = next(a for a in scene.asked if a.name == "energy")
    found = run.run(scene, asked, 1e-3, RIGHT[scene.name]["energy"], 20.0, 20_000)
    assert json.loads(json.dumps(found)) == found
    assert found["levels"][-1]["bar"] == found["bar"] and len(found["levels"]) > 1
    looser = run.stopped(found, 1e-2)
    assert looser["outcome"] == "REACHED" and len(looser["levels"]) < len(found["levels"])
    again = run.run(scene, asked, 1e-2, RIGHT[scene.name]["energy"], 20.0, 20_000)
    assert [again[key] for key in ("value", "bar", "outcome")] == [looser[key] for key in ("value", "bar", "outcome")]
    assert "| square, clamped | energy |" in assessment.markdown([found])
    failed = run.run(replace(scene, theory="none"), asked, 1e-3, RIGHT[scene.name]["energy"], 20.0, 20_000)
    assert "InputError" in failed["failed"] and not assessment.summary([failed]).holds
