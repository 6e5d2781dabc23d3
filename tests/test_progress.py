"""Progress of long calls and what they log: seen by whoever asks, and nothing printed otherwise."""

import io
import logging
import sys

import numpy as np
import pytest

import skancf as sk
from skancf import InputError, Progress, output, progress
from skancf.progress import Bar


class Terminal(io.StringIO):
    def isatty(self):
        return True


def on_terminal(monkeypatch):
    """A terminal as stderr, on which bars appear at once; from the body of a test, as pytest sets stderr before it."""
    stream = Terminal()
    monkeypatch.setattr(sys, "stderr", stream)
    monkeypatch.setattr(progress, "DELAY", 0.0)
    monkeypatch.setattr(progress, "INTERVAL", 0.0)
    return stream


@pytest.fixture(scope="module")
def plate():
    return sk.Problem(sk.Rectangle(1.0, 1.0), 0.01, sk.Isotropic(70e9, 0.3, 2700.0), [sk.Clamp("left")],
                      [sk.EdgeLoad("right", (0.0, 0.0, 100.0))])  # fmt: skip


@pytest.fixture(scope="module")
def system(plate):
    return plate.on(sk.meshes.uniform(plate.surface, 3, 3))


@pytest.fixture(scope="module")
def pushed():
    column = sk.Problem(sk.Rectangle(1.0, 0.1), 0.01, sk.Isotropic(70e9, 0.3, 2700.0), [sk.Clamp("left")],
                        [sk.EdgeLoad("right", (-1.0, 0.0, 0.0))])  # fmt: skip
    return column.on(sk.meshes.uniform(column.surface, 6, 1))


TIP = sk.Displacement(at=(1.0, 0.5))


@pytest.fixture(scope="module")
def calls(plate, system, pushed, tmp_path_factory):
    """Long calls, each as a function of its option, with the name of the work."""
    state = sk.solve(
        plate.on(sk.meshes.quadtree(sk.meshes.uniform(plate.surface, 2, 2), plate.surface), "kirchhoff")
    ).solution
    file = tmp_path_factory.mktemp("written") / "states.pvd"
    return {
        "statics": lambda **option: sk.solve(system, **option),
        "path": lambda **option: sk.trace(system, steps=3, **option),
        "modes": lambda **option: sk.modes(system, 2, **option),
        "buckling": lambda **option: sk.buckling(pushed, 1, **option),
        "dynamics": lambda **option: sk.simulate(system, 0.03, dt=0.01, outputs=3, **option),
        "adapt": lambda **option: sk.adapt(plate, TIP, rtol=1e-2, **option),
        "estimate": lambda **option: sk.goal_estimate(state, TIP, **option),
        "error of the theory": lambda **option: sk.theory_error(state, TIP, **option),
        "write": lambda **option: output.write([state, state], file, subdivisions=1, depths={}, **option),
    }


NAMES = ["statics", "path", "modes", "buckling", "dynamics", "adapt", "estimate", "error of the theory", "write"]


@pytest.mark.parametrize("name", NAMES)
def test_a_function_is_told_of_every_step(calls, name, capsys):
    seen = []
    calls[name](progress=seen.append)
    assert seen and all(isinstance(event, Progress) and event.what == name for event in seen)
    done = [event.done for event in seen]
    assert done == sorted(done) and all(event.note for event in seen)
    if name in ("modes", "buckling"):
        assert seen[-1].total is None and seen[-1].share is None and done == list(range(1, len(done) + 1))
    elif name != "path":
        assert seen[-1].share == pytest.approx(1.0)
    assert capsys.readouterr() == ("", "")


@pytest.mark.parametrize("name", NAMES)
def test_a_bar_is_on_a_terminal_and_nowhere_else(calls, name, monkeypatch, capsys):
    terminal = on_terminal(monkeypatch)
    calls[name]()
    shown = terminal.getvalue()
    assert f"{name}: " in shown and shown.endswith("\n")
    assert shown.count("\n") == 1, "one bar for one call"
    calls[name](progress=False)
    assert terminal.getvalue() == shown
    assert capsys.readouterr().out == ""


def test_short_work_shows_no_bar(system, monkeypatch):
    terminal = on_terminal(monkeypatch)
    monkeypatch.setattr(progress, "DELAY", 60.0)
    sk.solve(system)
    assert terminal.getvalue() == ""


def test_bars_inside_of_others_are_one(monkeypatch):
    terminal = on_terminal(monkeypatch)
    with Bar("outer", 2, True) as outer:
        outer.at(1, "first")
        with Bar("inner", 1, True) as inner, Bar("innermost", 1, False) as innermost:
            inner.at(1, "within")
            innermost.at(1, "deep")
        outer.at(2, "second")
    shown = terminal.getvalue()
    assert shown.count("\n") == 1
    lines = [line for line in shown.split("\r") if line.strip()]
    assert all(line.startswith("outer: ") for line in lines)
    assert "first; inner: within" in shown and "first; innermost: deep" in shown and "100%" in lines[-1]


def test_a_function_inside_of_a_bar_is_told_too(monkeypatch):
    on_terminal(monkeypatch)
    seen = []
    with Bar("outer", 2, True) as outer, Bar("inner", None, seen.append) as inner:
        outer.at(1)
        inner.next("one more")
    assert seen == [Progress("inner", 1, None, "one more")]
    assert str(seen[0]) == "inner: 1, one more" and str(Progress("a", 1, 4)) == "a: 25%"


def test_an_error_in_the_function_loses_nothing_that_was_computed(system):
    def stop(event):
        if event.done >= 0.02:
            raise LookupError("enough")

    motion = sk.simulate(system, 0.05, dt=0.01, outputs="steps", progress=stop)
    assert motion.status.name == "FAILED" and "enough" in motion.message and motion.times[-1] == pytest.approx(0.02)
    with pytest.raises(LookupError, match="enough") as caught:
        sk.modes(system, 2, progress=stop)
    assert "progress" in caught.value.__notes__[0]


def test_an_interruption_in_the_function_is_one_from_the_keyboard(system):
    def stop(event):
        if event.done >= 2:
            raise KeyboardInterrupt

    path = sk.trace(system, steps=9, progress=stop)
    assert path.status.name == "INTERRUPTED" and len(path.solutions) == 3


@pytest.mark.parametrize("wrong", ["yes", 2, None, list, Progress])
def test_what_is_neither_a_truth_value_nor_a_function_is_named(system, wrong):
    with pytest.raises(InputError, match="give True, False, or a function that takes a Progress"):
        sk.solve(system, progress=wrong)


def test_a_notebook_is_known_by_its_kernel(monkeypatch):
    class Shell:
        config = dict.fromkeys(["IPKernelApp"])

    class IPython:
        get_ipython = staticmethod(lambda: Shell)

    assert not progress.in_notebook()
    monkeypatch.setitem(sys.modules, "IPython", IPython)
    assert progress.in_notebook() and progress.is_watched()
    Shell.config = {}
    assert not progress.in_notebook()


# Logging.


def messages(caplog, room, level):
    return [r.getMessage() for r in caplog.records if r.name.startswith(f"skancf.{room}") and r.levelno == level]


def test_statics_logs_iterations_and_load_steps(system, caplog):
    with caplog.at_level(logging.DEBUG, "skancf"):
        result = sk.solve(system)
    iterations = messages(caplog, "statics", logging.DEBUG)
    assert len(iterations) == result.iterations and iterations[0].startswith("iteration 1: ")
    assert f"load factor 1: {result.iterations} iterations, 0 negative pivots" in messages(caplog, "statics", logging.INFO)
    assert messages(caplog, "statics", logging.INFO)[-1] == "converged"


def test_paths_and_eigenvalues_are_logged(calls, caplog):
    with caplog.at_level(logging.INFO, "skancf"):
        path = calls["path"]()
        calls["modes"]()
        calls["buckling"]()
    said = messages(caplog, "statics", logging.INFO)
    assert [line for line in said if line.startswith("step 3: load factor")] and len(path.solutions) == 4
    assert any(line.startswith("2 modes, ") for line in said) and any(line.startswith("1 load factors; ") for line in said)


def test_motions_log_their_steps(system, caplog):
    with caplog.at_level(logging.INFO, "skancf.dynamics"):
        motion = sk.simulate(system, 0.03, dt=0.01, outputs=3)
    said = messages(caplog, "dynamics", logging.INFO)
    assert sum(line.startswith("t = ") for line in said) == sum(step.accepted for step in motion.steps) == 3
    assert said[-1] == "finished"


def test_adapt_logs_its_meshes_with_their_errors(plate, caplog):
    with caplog.at_level(logging.INFO, "skancf.adaptive"):
        result = sk.adapt(plate, TIP, rtol=1e-3)
    said = [line for line in messages(caplog, "adaptive", logging.INFO) if line.startswith("mesh ")]
    assert len(said) == len(result.levels)
    assert f"{result.value:.6g} +- {result.error_bar:.1g}" in said[-1]


def test_what_is_warned_is_logged_but_not_what_is_judged_later(caplog):
    thick = sk.Problem(sk.Rectangle(1.0, 1.0), 0.3, sk.Isotropic(70e9, 0.3, 2700.0), [sk.Clamp("boundary")],
                       [sk.SurfaceLoad((0.0, 0.0, -1e6))])  # fmt: skip
    with caplog.at_level(logging.WARNING, "skancf"), pytest.warns(sk.OutOfDepth) as warned:
        sk.adapt(thick, sk.Displacement(at=(0.5, 0.5)), rtol=1e-2)
    assert [record.getMessage() for record in caplog.records] == [str(one.message) for one in warned]


def test_what_ends_badly_is_logged_as_a_warning(system, caplog):
    with caplog.at_level(logging.WARNING, "skancf"):
        path = sk.trace(system, until=1e6, steps=1)
    assert not path.ok and any("these were all the steps" in line for line in messages(caplog, "statics", logging.WARNING))


def test_nothing_is_formatted_for_nobody(system, caplog):
    class Refused(logging.Handler):
        def emit(self, record):
            raise AssertionError(record)

    handler = Refused()
    logging.getLogger("skancf").addHandler(handler)
    try:
        with caplog.at_level(logging.ERROR, "skancf"):
            assert np.isfinite(sk.solve(system).solution.q).all()
    finally:
        logging.getLogger("skancf").removeHandler(handler)
    assert any(isinstance(one, logging.NullHandler) for one in logging.getLogger("skancf").handlers)
