"""The guard of benchmarks tells what became slower, by name and exit code; times here are those of a clock that is told."""

import importlib.util
import json
import subprocess
import sys
from contextlib import nullcontext
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent


def loaded(name, monkeypatch):
    specification = importlib.util.spec_from_file_location(name, ROOT / "benchmarks" / f"{name}.py")
    module = importlib.util.module_from_spec(specification)
    monkeypatch.setitem(sys.modules, name, module)
    specification.loader.exec_module(module)
    return module


@pytest.fixture
def guard(monkeypatch):
    for name in ("SKANCF_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        monkeypatch.setenv(name, "1")  # the guard sets them; put back afterwards
    return loaded("guard", monkeypatch)


@pytest.fixture
def commits(guard, monkeypatch):
    return loaded("guard_commits", monkeypatch)


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
            "four steps in time", "estimate", "import"} <= set(found)  # fmt: skip
    found["solve"].work()
    assert found["iterations, strip bent"].value(0.0) == 7
    assert found["calls, set-up, 8 elements"].value(0.0) == found["calls, set-up, 8 elements"].value(0.0)


# A commit and the working tree in turns.


def passes(values, n_calls=100, **failed):
    """One pass for each value of a kernel, as a process tells it."""
    return [
        {"ratios": {"kernel": value, "other": 3.0}, "counts": {"calls": n_calls}, "failed": dict(failed)} for value in values
    ]


BASE = [2.0, 2.06, 2.02, 2.1, 2.04]


@pytest.mark.parametrize(
    ("here", "slower"),
    [
        ([1.06 * value for value in BASE], True),
        ([1.01 * value for value in BASE], False),
        ([0.8 * value for value in BASE], False),
        ([2.0, 2.06, 9.0, 2.1, 2.04], False),  # noise in one round
        ([2.2, 2.07, 2.6, 2.5, 2.4], False),  # much noise, and one quiet round that shows the kernel is the same
        ([2.11, 2.11, 2.11, 2.11, 2.11], False),  # BASE was lucky once: the median of rounds says 3 %
    ],
)
def test_five_percent_in_most_rounds_and_in_the_smallest_are_told(commits, capsys, here, slower):
    assert commits.compare(passes(BASE), passes(here)) == int(slower)
    expected = "kernel" if slower else "nothing"
    assert capsys.readouterr().out.splitlines()[-1] == f"slower by more than 5% (counts: 20%): {expected}"


def test_noise_in_the_rounds_of_base_does_not_hide_a_slower_kernel(commits):
    assert commits.compare(passes([2.0, 6.0, 2.02, 8.0, 2.0]), passes([2.2] * 5)) == 1


def test_counts_differ_without_being_slower_up_to_a_fifth(commits, capsys):
    assert commits.compare(passes(BASE), passes(BASE, n_calls=117)) == 0
    assert "+17" in next(line for line in capsys.readouterr().out.splitlines() if line.startswith("calls")).split()
    assert commits.compare(passes(BASE), passes(BASE, n_calls=121)) == 1
    assert capsys.readouterr().out.splitlines()[-1].endswith(": calls")


def test_a_figure_that_base_cannot_make_is_noted_and_the_others_go_on(commits, capsys):
    old, new = passes(BASE, kernel="AttributeError: no kernel"), passes([1.1 * value for value in BASE], n_calls=130)
    for one in old:
        del one["ratios"]["kernel"]
    assert commits.compare(old, new) == 1
    shown = capsys.readouterr().out.splitlines()
    assert "kernel: raises in BASE, AttributeError: no kernel" in shown
    assert shown[-1].endswith(": calls")


def test_a_figure_that_raises_in_some_rounds_is_compared_in_the_others(commits):
    old, new = passes(BASE), passes([1.1 * value for value in BASE])
    del old[0]["ratios"]["kernel"]
    (pair,) = (pair for pair in commits.pairs(old, new) if pair.name == "kernel")
    assert pair.old == BASE[1:]
    assert pair.rounds == pytest.approx([1.1] * 4)


def test_a_figure_that_raises_here_alone_is_not_well(commits, capsys):
    assert commits.compare(passes(BASE), passes(BASE, broken="ValueError: no")) == 1
    assert capsys.readouterr().out.splitlines()[-1].endswith(": broken")
    assert commits.compare(passes(BASE, broken="ValueError: no"), passes(BASE, broken="ValueError: no")) == 0


def test_a_process_goes_on_after_a_figure_that_raises(guard):
    def missing():
        raise AttributeError("no such hook")

    made = {
        "made of nothing": missing, "fails when run": lambda: guard.Count(missing), "calls": lambda: guard.Count(lambda: 7),
        "kernel": lambda: figures(guard, Clock())["kernel"],
    }  # fmt: skip
    assert guard.one_pass(made, 1.0) == {
        "ratios": {"kernel": 2.0}, "counts": {"calls": 7.0},
        "failed": {"made of nothing": "AttributeError: no such hook", "fails when run": "AttributeError: no such hook"},
    }  # fmt: skip


def test_another_package_than_that_of_the_tree_is_refused(guard, tmp_path, capsys):
    assert guard.figures(tmp_path, 0.0) == 1
    assert "which is not below" in capsys.readouterr().err


def test_trees_are_measured_in_turns_after_one_run_that_compiles(commits):
    seen = []

    def measure(tree, seconds):
        seen.append((tree.name, seconds))
        return passes(BASE)[0]

    assert commits.in_turns(Path("old"), Path("new"), 2, 0.5, measure) == 0
    assert seen == [("old", 0.0), ("new", 0.0), ("old", 0.5), ("new", 0.5), ("old", 0.5), ("new", 0.5)]


@pytest.fixture
def repository(tmp_path):
    def git(*arguments):
        return subprocess.run(
            ["git", "-C", str(tmp_path), "-c", "user.name=a", "-c", "user.email=a@b.c", *arguments],
            check=True, capture_output=True, text=True,
        ).stdout  # fmt: skip

    git("init", "--quiet")
    (tmp_path / "text").write_text("before")
    git("add", "text")
    git("commit", "--quiet", "-m", "one")
    (tmp_path / "text").write_text("after")
    return tmp_path, lambda: git("worktree", "list", "--porcelain").count("worktree ")


@pytest.mark.parametrize("ending", [None, RuntimeError, KeyboardInterrupt, SystemExit])
def test_the_commit_is_checked_out_and_gone_afterwards(commits, repository, ending):
    root, n_trees = repository
    trees = []
    with pytest.raises(ending) if ending else nullcontext(), commits.checked_out("HEAD", root) as tree:
        trees.append(tree)
        assert (tree / "text").read_text() == "before"
        assert n_trees() == 2
        (tree / "kernel.nbi").write_text("compiled")
        if ending:
            raise ending
    assert not trees[0].parent.exists()
    assert n_trees() == 1
    assert (root / "text").read_text() == "after"


def test_a_commit_that_is_not_known_is_named(commits, repository):
    root, n_trees = repository
    with pytest.raises(SystemExit, match="nowhere"), commits.checked_out("nowhere", root):
        pass
    assert n_trees() == 1
