"""The guard of benchmarks tells what became slower, by name and exit code; times here are those of a clock that is told."""

import importlib.util
import json
import sys
from pathlib import Path

import pytest

GUARD = Path(__file__).parent.parent / "benchmarks" / "guard.py"


@pytest.fixture
def guard(monkeypatch):
    for name in ("SKANCF_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        monkeypatch.setenv(name, "1")  # the guard sets them; put back afterwards
    specification = importlib.util.spec_from_file_location("guard", GUARD)
    module = importlib.util.module_from_spec(specification)
    monkeypatch.setitem(sys.modules, "guard", module)
    specification.loader.exec_module(module)
    return module


class Clock:
    """A clock that work advances; the machine may be so many times slower, for a while."""

    def __init__(self):
        self.now, self.slowness = 0.0, [1.0]

    def __call__(self):
        return self.now

    def work(self, seconds):
        def run():
            self.slowness.append(self.slowness.pop(0))
            self.now += seconds * self.slowness[0]

        return run


def figures(guard, clock, seconds=2.0, n_calls=100):
    return {
        "kernel": guard.Ratio(clock.work(seconds), clock.work(1.0), clock),
        "other": guard.Ratio(clock.work(3.0), clock.work(1.0), clock),
        "calls": guard.Count(lambda: n_calls),
    }


@pytest.fixture
def stored(guard, tmp_path):
    file = tmp_path / "guard.json"
    assert guard.measure(figures(guard, Clock()), file, seconds=10.0) == 0
    assert json.loads(file.read_text())["figures"] == {"kernel": 2.0, "other": 3.0, "calls": 100.0}
    return file


def test_nothing_slower_is_well(guard, stored, capsys):
    assert guard.check(figures(guard, Clock(), seconds=2.3, n_calls=110), stored, seconds=10.0) == 0
    assert "SLOWER" not in capsys.readouterr().out


def test_a_slower_kernel_is_named(guard, stored, capsys):
    assert guard.check(figures(guard, Clock(), seconds=2.5), stored, seconds=10.0) == 1
    shown = capsys.readouterr().out
    assert [line.split()[0] for line in shown.splitlines() if "SLOWER" in line] == ["kernel"]
    assert shown.splitlines()[-1] == "slower by more than 20%: kernel"


def test_more_calls_are_named(guard, stored, capsys):
    assert guard.check(figures(guard, Clock(), n_calls=121), stored, seconds=10.0) == 1
    assert capsys.readouterr().out.splitlines()[-1] == "slower by more than 20%: calls"


def test_a_machine_in_a_bad_mood_is_not_a_slower_kernel(guard, stored):
    clock = Clock()
    clock.slowness = [3.0, 1.5, 1.0, 4.0, 2.0, 1.2, 3.5]  # of one piece of work after the other
    assert guard.check(figures(guard, clock), stored, seconds=60.0) == 0


def test_another_machine_is_told_and_compared(guard, stored, capsys):
    known = json.loads(stored.read_text())
    known["machine"]["processor"] = "abacus"
    stored.write_text(json.dumps(known))
    assert guard.check(figures(guard, Clock()), stored, seconds=10.0) == 0
    assert "another processor: abacus when stored" in capsys.readouterr().out


def test_what_is_not_stored_is_not_well(guard, stored, tmp_path, capsys):
    assert guard.check(figures(guard, Clock()), tmp_path / "none.json") == 1
    more = {**figures(guard, Clock()), "new": guard.Count(lambda: 1)}
    assert guard.check(more, stored, seconds=10.0) == 1
    assert "measure and store it" in capsys.readouterr().out
    with pytest.raises(Exception, match=r"\.json"):
        guard.measure(more, tmp_path / "guard.txt")


def test_calls_are_the_same_in_every_run(guard):
    work = guard.calls(lambda: sorted(str(k) for k in range(10)))
    assert work.value(0.0) == work.value(0.0) > 10


def test_the_figures_are_those_of_the_library(guard):
    found = guard.all_figures()
    assert {"residual, kirchhoff", "tangent, full", "factor", "solve", "set-up, 8 elements", "strip bent, full",
            "ten steps in time", "estimate", "import"} <= set(found)  # fmt: skip
    found["solve"].work()
    assert found["iterations, strip bent"].value(0.0) == 7
    assert found["calls, set-up, 8 elements"].value(0.0) == found["calls, set-up, 8 elements"].value(0.0)
