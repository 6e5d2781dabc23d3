"""The comparison with other programs: scenes, what counts as reached, results and their page. It needs no other program."""

import json
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks import analysis, compare, page, setup_peers
from benchmarks.ladder import ladder
from benchmarks.programs import ours
from benchmarks.scenes import SCENES, Quantity, Scene

ROOT = Path(__file__).resolve().parent.parent
# Sizes at which our thin elements have errors of this order: that scenes, references and models belong together.
EXPECTED = {
    "end_shear": ("uniform", 8, 1e-4), "roll_up": ("uniform", 12, 1e-3), "hemisphere": ("graded", 12, 2e-3),
    "hinged_roof": ("uniform", 4, 2e-2), "l_shape": ("adaptive", 1e-3, 2e-3), "corner_plate": ("uniform", 4, 1e-3),
    "paper_2n": ("uniform", 4, 4e-2), "paper_20n": ("uniform", 4, 4e-2), "free_ruler": ("uniform", 4, 3e-3),
}  # fmt: skip


def scene_with(reference: dict, uncertainty: dict, scale: float | None = None) -> Scene:
    quantity = Quantity("a number", "m", reference, uncertainty, "made up", scale)
    return Scene("made_up", "Made up", "Nothing.", {}, {"a": quantity})


@pytest.mark.parametrize("name", SCENES)
def test_our_thin_elements_reach_the_reference(name: str) -> None:
    scene = SCENES[name]
    variant, size, bound = EXPECTED[name]
    outcome = ours.run(scene, variant, size)
    error = scene.error(outcome.values, "thin")
    # Above the bound over 50, so that a reference that was copied from this very run would be noticed.
    assert bound / 50 < error < bound
    assert outcome.dofs > 0


def test_errors_are_relative_to_the_reference_of_the_theory_or_the_scale() -> None:
    scene = scene_with({"thin": 2.0, "thick": 4.0}, {"thin": 1e-6, "thick": 1e-6})
    assert scene.error({"a": 2.1}, "thin") == pytest.approx(0.05)
    assert scene.error({"a": 4.1}, "thick") == pytest.approx(0.025)
    assert scene_with({"thin": 0.0}, {"thin": 0.0}, 10.0).error({"a": 1.0}, "thick") == pytest.approx(0.1)
    series = scene_with({"thin": (3.0, 4.0)}, {"thin": 1e-3})
    assert series.error({"a": [3.0, 4.5]}, "thin") == pytest.approx(0.5 / 5.0)
    assert series.error({"a": [3.0, float("nan")]}, "thin") == float("inf")
    with pytest.raises(ValueError, match="1 values, the reference has 2"):
        series.error({"a": [3.0]}, "thin")
    with pytest.raises(ValueError, match="no value for"):
        series.error({}, "thin")


def curve(errors: tuple[float, ...], seconds: tuple[float, ...], program: str = "skancf") -> analysis.Curve:
    sizes = tuple(range(len(errors)))
    return analysis.Curve(program, program, f"{program}, a variant", "thin", sizes, sizes, errors, seconds)


def test_an_error_that_is_small_by_chance_is_not_reached() -> None:
    crossing = curve((1e-1, 1e-4, 1e-2, 1e-3), (1.0, 2.0, 3.0, 4.0))
    assert crossing.time_to(1e-4) is None
    assert crossing.time_to(5e-3) == 4.0
    assert crossing.time_to(0.5) == 1.0
    # Where a finer mesh happens to be faster, its time counts.
    assert curve((1e-3, 1e-3), (2.0, 1.0)).time_to(1e-2) == 1.0
    assert curve((), ()).time_to(1.0) is None


def test_a_size_that_failed_is_no_accurate_one_and_the_last_needs_another_that_confirms_it() -> None:
    failed = curve((1e-3, float("inf"), 1e-3), (1.0, float("inf"), 3.0))
    assert failed.time_to(1e-2) == 3.0 and not failed.confirmed(1e-2) and failed.done == [0, 2]
    assert curve((1e-3, 1e-3), (1.0, 2.0)).confirmed(1e-2)


def test_references_that_are_not_known_well_enough_are_marked() -> None:
    scene = scene_with({"thin": 1.0}, {"thin": 1e-4})
    thin = replace(curve((1e-5,), (1.0,)), uncertainty=scene.uncertainty("thin"))
    assert thin.known(1e-3) and not thin.known(1e-4)
    assert not scene.own("thick") and not replace(thin, uncertainty=scene.uncertainty("thick")).known(0.5)


@pytest.mark.parametrize("module", compare.PROGRAMS)
def test_each_program_runs_each_scene_or_says_why_not(module: str) -> None:
    program = compare.program(module)
    assert program.environment is None or (setup_peers.PEERS / program.environment).is_dir()
    for variant in program.variants.values():
        for name in SCENES:
            able = name in variant.sizes and variant.theory not in SCENES[name].limitless
            why = variant.cannot.get(name) or (variant.theory in SCENES[name].limitless and compare.NO_LIMIT)
            assert able != bool(why), (variant.label, name)


def test_a_scene_that_a_program_cannot_run_is_stored_with_the_reason() -> None:
    contender = next(c for c in compare.contenders(["ours"]) if c.variant == "adaptive")
    runs = compare.Runs(SCENES["end_shear"])
    found = compare.stored(runs, [contender], compare.QUICK, {})["cannot"]
    assert found == [{"module": "ours", "label": contender.label, "reason": "nothing is concentrated"}]


def test_runs_of_the_worker_are_stored_with_what_failed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    entered = [c for c in compare.contenders(["ours"]) if c.variant == "uniform"]
    scene = SCENES["paper_2n"]
    monkeypatch.setitem(entered[0].program.variants["uniform"].sizes, scene.name, (2, 5))  # steps for 5 are not set up
    runs = compare.compare(scene, entered, compare.Limits(60.0, 2, 10.0))
    good, bad = runs.rows[("ours", "uniform", 2.0)], runs.rows[("ours", "uniform", 5.0)]
    assert len(good["wall"]) == len(good["cpu"]) >= 2 and all(0 < t < 60 for t in good["cpu"])
    assert good["error"] == pytest.approx(scene.error(ours.run(scene, "uniform", 2).values, "thin"))
    assert not bad["wall"] and "Error" in bad["failed"]
    other = {"module": "exudyn", "label": "Exudyn", "program": "Exudyn"}
    old = {"rows": [{**other}], "versions": {"Exudyn": "1"}, "cannot": [{**other, "reason": "why"}]}
    kept = compare.stored(runs, entered, compare.QUICK, old)
    assert json.loads(json.dumps(kept)) == kept
    assert [row["module"] for row in kept["rows"]] == ["exudyn", "ours", "ours"] and kept["cannot"][0]["reason"] == "why"
    assert kept["apart"] == ["ours"] and not compare.stored(runs, entered, compare.QUICK, {})["apart"]


def test_a_ladder_ends_when_its_time_is_up() -> None:
    contender = next(c for c in compare.contenders(["ours"]) if c.variant == "uniform")
    began = time.perf_counter()
    lines = list(ladder(Path(sys.executable), [contender.module, contender.variant, "hemisphere"], [8, 200], 3.0))
    assert time.perf_counter() - began < 60
    assert "version" in lines[0] and "time was up after" in lines[-1]["end"]
    assert all(line["size"] == 8 for line in lines[1:-1])


def test_a_worker_that_breaks_is_told_with_its_last_words() -> None:
    lines = list(ladder(Path(sys.executable), ["no_such_program", "uniform", "hemisphere"], [8], 60.0))
    assert len(lines) == 1 and "ended with code 1 after its start: ModuleNotFoundError" in lines[0]["end"]


def test_a_program_without_its_environment_is_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(setup_peers, "PEERS", tmp_path)
    contender = next(c for c in compare.contenders(["exudyn"]) if "end_shear" in c.program.variants[c.variant].sizes)
    assert "make peers" in str(contender.reason(SCENES["end_shear"]))


def test_the_page_is_made_of_stored_results(tmp_path: Path) -> None:
    u, w = (SCENES["end_shear"].quantities[name].reference for name in ("u", "w"))

    def row(module: str, size: int, error: float, seconds: float) -> dict:
        program = {"ours": "skancf", "exudyn": "Exudyn"}[module]
        return {
            "program": program, "module": module, "variant": "a", "label": f"{program}, a", "theory": "thin", "size": size,
            "dofs": 10 * size, "error": 7.0, "wall": [seconds, 9.0, seconds / 2], "cpu": [seconds], "note": "",
            "values": {"u": u["thin"] + 10 * error, "w": w["thin"]},
        }  # fmt: skip

    stored = {
        "scene": "end_shear", "machine": compare.facts(), "threads": 1, "rounds": 1, "versions": {"Exudyn": "Exudyn 7"},
        "rows": [row("ours", 1, 2e-2, 0.25), row("ours", 2, 5e-4, 0.5), row("exudyn", 1, 5e-4, 4.0)],
        "apart": ["ours"],
        "cannot": [{"module": "kratos", "label": "Kratos, b", "reason": "no such *element\nat all"}],
    }  # fmt: skip
    (tmp_path / "scene_end_shear.json").write_text(json.dumps(stored))
    found = list(analysis.compared(tmp_path))
    assert [c.seconds for c in found[0].curves] == [(0.25, 0.5), (4.0,)]
    text = page.overview(found) + page.section(found[0], tmp_path)
    assert "not in turns with them: skancf, a." in text
    assert "Kratos, b: ``no such *element at all``" in text and "\n     - 8\n" in text
    assert (tmp_path / "end_shear.png").stat().st_size > 10_000


def test_the_module_that_peers_read_needs_only_the_standard_library() -> None:
    code = "import sys; sys.modules['numpy'] = sys.modules['skancf'] = None; import benchmarks.scenes"
    subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=True)
