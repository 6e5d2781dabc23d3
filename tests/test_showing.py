"""What objects show of themselves: short at a prompt, a table with a picture in a notebook, and nothing raises."""

import copy
import dataclasses
import inspect
from types import ModuleType

import numpy as np
import pytest
from mistakes import Scene, calls

import skancf as sk
from skancf import showing
from skancf.errors import SkancfError
from skancf.output.rendering import check_rendering

MOST = 1000
"""Characters."""
TIP = (1.0, 0.5)


def small_runs() -> dict[str, object]:
    """A result of every kind."""
    surface = sk.Rectangle(1.0, 1.0)
    plate = sk.Problem(
        surface, 0.02, sk.Isotropic(1e7, 0.3, 1e3), [sk.Clamp("left")], [sk.EdgeLoad("right", (-5.0, 0, 0.1))]
    )
    mesh = sk.meshes.quadtree(sk.meshes.uniform(surface, 8, 8))
    system = plate.on(mesh, theory="kirchhoff")
    static = sk.solve(system)
    motion = sk.simulate(system, t_end=0.02, dt=2e-3)
    adaptive = sk.adapt(plate, sk.Displacement(TIP), rtol=0.05)
    finer = plate.on(mesh.refined([0]), theory="kirchhoff")
    state = motion.at(0.02)
    return {
        "problem": plate, "mesh": mesh, "system": system, "static": static, "state": static.solution, "motion": motion,
        "segment": motion.segments[0], "step": motion.steps[0], "ledger": motion.ledger, "newton": static.attempts[0][1],
        "linear": sk.solve_linear(system), "modes": sk.modes(system, 3), "buckling": sk.buckling(system, 2),
        "path": sk.trace(system, until=1.0), "adaptive": adaptive, "level": adaptive.levels[0],
        "spectrum": sk.spectrum(np.linspace(0, 1, 64), np.sin(20 * np.linspace(0, 1, 64))), "check": static.checks[0],
        "estimate": sk.goal_estimate(static.solution, sk.Displacement(TIP)), "samples": sk.output.sample(static.solution),
        "theory error": sk.theory_error(static.solution, sk.Displacement(TIP)), "style": sk.output.Style(),
        "regions": sk.stress_regions(sk.solve(plate.on(sk.meshes.uniform(surface, 8, 8))).solution),
        "remapped": sk.remap(state, finer),
    }  # fmt: skip


@pytest.fixture(scope="module")
def runs() -> dict[str, object]:
    return small_runs()


def parts(value: object, depth: int = 4) -> list[object]:
    """An object of the library and those that it holds, down to some depth."""
    if isinstance(value, list | tuple):
        return [part for item in value[:3] for part in parts(item, depth)] + (
            [value] if type(value) not in (list, tuple) else []
        )
    if not type(value).__module__.startswith("skancf") or not depth:
        return []
    return [value, *(part for held in list(vars(value).values()) if held is not value for part in parts(held, depth - 1))]


def test_every_result_is_short_with_all_that_it_holds(runs):
    seen = {type(part): part for run in runs.values() for part in parts(run)}
    assert {sk.Solution, sk.Modes, type(runs["system"]), type(runs["newton"]), type(runs["segment"])} <= set(seen)
    for part in seen.values():
        for text in (repr(part), str(part)):
            assert 0 < len(text) < MOST, (type(part), len(text))
            assert text.count("\n") < 10


def test_every_input_is_short(tmp_path):
    """Made by the valid calls of the test of mistakes."""
    made = []
    for call in calls(Scene(tmp_path)).values():
        kind = inspect.unwrap(call.function)
        if isinstance(kind, type) and set(call.arguments) >= required(kind):
            made.append(kind(**call.arguments))
            assert len(repr(made[-1])) < MOST and len(str(made[-1])) < MOST
    assert {"Rectangle", "Isotropic", "Laminate", "Problem", "Solution", "EdgeLoad", "Pin"} <= {
        type(one).__name__ for one in made
    }


def required(kind: type) -> set[str]:
    given = inspect.signature(kind).parameters.values()
    return {
        one.name for one in given if one.default is one.empty and one.kind in (one.POSITIONAL_OR_KEYWORD, one.KEYWORD_ONLY)
    }


PUBLIC = {
    name: each for room in (sk, sk.meshes, sk.output, sk.dynamics, sk.statics, sk.adaptive, sk.materials, sk.terms)
    for name, each in vars(room).items() if inspect.isclass(each) and each.__module__.startswith("skancf")
}  # fmt: skip


@pytest.mark.parametrize("name", sorted(PUBLIC))
def test_half_made_objects_show_what_they_have(name):
    """As a debugger does in a constructor, and a traceback with values."""
    kind = PUBLIC[name]
    if issubclass(kind, BaseException | tuple) or isinstance(kind, type(sk.Status)) or inspect.isabstract(kind):
        return
    try:
        half = object.__new__(kind)
    except TypeError:  # made by its base class
        half = kind.__new__(kind)
    if isinstance(half, sk.meshes.MeshQuadTree):
        return  # shown by scikit-fem
    for text in (repr(half), str(half)):
        assert len(text) < MOST
    first = next(iter(dataclasses.fields(kind)), None) if dataclasses.is_dataclass(kind) else None
    if first is not None:
        object.__setattr__(half, first.name, np.zeros((1000, 1000)))
        assert len(repr(half)) < MOST or kind.__repr__ is not showing.short
    if hasattr(half, "_repr_html_"):
        assert half._repr_html_() is None or "<div" in half._repr_html_()


@pytest.mark.parametrize(("name", "words"), [
    ("static", ["StaticResult: converged", "theory kirchhoff", "64 elements, 81 nodes, 972 unknowns", "largest displacement",
                "iterations", "checks: 4 passed"]),
    ("linear", ["Solution: ", "small deflections", "largest displacement"]),
    ("modes", ["Modes: 3 modes", "frequencies", "Hz"]), ("buckling", ["BucklingResult: load factors"]),
    ("path", ["PathResult: converged", "load factors 0 to 1"]), ("motion", ["Motion: finished, 0 to 0.02 s", "10 steps"]),
    ("ledger", ["Ledger: 11 rows", "kinetic", "without a source"]), ("spectrum", ["Spectrum: up to 31.5 Hz, 1 column"]),
])  # fmt: skip
def test_results_say_what_a_person_wants_to_know(name, words, runs):
    text = str(runs[name])
    assert all(word in text for word in words), text
    assert repr(runs[name]) == f"<{text}>"


def test_a_state_names_its_largest_displacement(runs):
    state = runs["state"]
    moved = np.linalg.norm(state.displacements, axis=0)
    x, y = state.system.mesh.p[:, moved.argmax()]
    assert f"largest displacement {moved.max():.4g} at ({x:.4g}, {y:.4g})" in str(state)
    assert str(dataclasses.replace(state, load_factor=0.5)).count("load factor 0.5") == 1


def test_failed_checks_are_named(runs):
    bad = dataclasses.replace(runs["static"], checks=(*runs["static"].checks, sk.Check("balance of forces", 1.0, 1e-6)))
    assert str(bad).endswith("checks: 4 of 5 passed, FAILED: balance of forces")


@pytest.mark.parametrize("value", [
    sk.Rectangle(1.0, 2.0), sk.Isotropic(7e10, 0.3, 2700.0), sk.Isotropic(7e10, 0.3, 2700.0, kind="3d"),
    sk.Pin("corners"), sk.Pin([(0.0, 0.0), "left"]), sk.PointForce((0.5, 0.5), (0.0, 0.0, -1.0)), sk.Full(assumed=False),
    sk.Laminate([sk.Layer(sk.Isotropic(7e10, 0.3, 2700.0), 0.01)]), sk.Table([0.0, 1.0], [0.0, 2.0]),
    sk.Problem(sk.Rectangle(1.0, 1.0), 0.05, sk.Isotropic(2e5, 0.0, 2e3), [sk.Pin("corners")],
               [sk.PointForce((0.5, 0.5), (0.0, 0.0, -20.0))]),
], ids=lambda value: type(value).__name__)  # fmt: skip
def test_inputs_of_numbers_are_shown_as_the_call_that_makes_them(value):
    again = eval(repr(value), dict(vars(sk)))
    assert showing.in_full(again) == showing.in_full(value) and type(again) is type(value)
    assert showing.in_full(eval(showing.in_full(value), dict(vars(sk)))) == showing.in_full(value)


def test_what_is_long_is_told_in_few_words():
    path = sk.Path(np.linspace(0, 1, 1000), np.zeros((1000, 2)))
    assert repr(path).endswith("... 994 more))") or "more)" in repr(path)
    assert "<function <lambda>>" in repr(sk.Pin(lambda x, y: x > 0))
    assert (
        showing.brief(np.zeros((3, 81))) == "<array of shape (3, 81)>"
        and showing.brief(np.array([1.0, 2.0])) == "[1.0, 2.0]"
    )
    assert showing.brief([1] * 9) == "[1, 1, 1, 1, 1, 1, ... 3 more]" and showing.brief((1,)) == "(1,)"
    assert len(showing.brief("x" * 5000)) <= showing.LONG
    assert showing.in_full(path).count(",") > 1000


def test_an_own_class_whose_repr_fails_does_no_harm():
    class Own(sk.Rectangle):
        def __repr__(self):
            raise RuntimeError("mine")

    assert "<Own>" in repr(sk.Problem(Own(1.0, 1.0), 0.01, sk.Isotropic(1e7, 0.3, 1e3)))


# --- notebooks -----------------------------------------------------------------------------------------------------------

DRAWN = {"problem": 1, "static": 1, "state": 1, "modes": 3, "buckling": 2, "path": 2, "motion": 2, "ledger": 1,
         "spectrum": 1, "adaptive": 2}  # fmt: skip


@pytest.mark.parametrize("name", DRAWN)
def test_a_notebook_shows_a_table_and_pictures(name, runs):
    from skancf.output import notebook

    rows, drawings = notebook.contents(runs[name])
    assert len(drawings) == DRAWN[name] and rows
    page = runs[name]._repr_html_()
    assert page.startswith(f"<div><strong>{type(runs[name]).__name__}</strong><table>") and page.endswith("</div>")
    try:
        check_rendering()
    except SkancfError:
        return
    assert page.count('src="data:image/png;base64,iVBOR') == DRAWN[name]


def test_a_machine_that_cannot_draw_shows_the_table(runs, monkeypatch):
    def refuse(*_, **__):
        raise SkancfError("no pictures on this machine")

    monkeypatch.setattr("skancf.output.notebook.picture", refuse)
    page = runs["static"]._repr_html_()
    assert "<img" not in page and "largest displacement" in page and "converged" in page


def test_a_page_that_cannot_be_made_leaves_the_line(runs, monkeypatch):
    monkeypatch.setattr("skancf.showing.NOTEBOOK", "skancf.output.no_such_file")
    assert runs["static"]._repr_html_() is None


def test_small_displacements_are_enlarged_in_pictures(runs, monkeypatch):
    asked = []
    monkeypatch.setattr("skancf.output.notebook.picture", lambda state, file, **style: asked.append(style))
    state = runs["state"]
    for size in (1e-6, 1.0):
        change = size / np.linalg.norm(state.displacements, axis=0).max() * state.change
        sk.Solution(state.system, state.system.undeformed + change)._repr_html_()
    assert asked[0]["scale"] == pytest.approx(1e5) and asked[1]["scale"] == 1.0


def test_words_of_users_are_escaped():
    def draft(x, y):
        return 0 * x + 0.01

    draft.__name__ = "<script>"
    page = sk.Problem(sk.Plane(), draft, sk.Isotropic(1e7, 0.3, 1e3))._repr_html_()
    assert "<script>" not in page and "&lt;script&gt;" in page and "<img" not in page  # a plane has no bounds to draw


def test_copies_show_the_same(runs):
    assert repr(copy.copy(runs["static"])) == repr(runs["static"]) and isinstance(showing, ModuleType)
