"""The compilation of kernels shows that it is on, and for how long; later runs and other functions show nothing."""

import io
import logging
import sys
import time

import numba
import pytest

from skancf import compiling, progress
from skancf.compiling import Announcer, announce


class Terminal(io.StringIO):
    def isatty(self):
        return True


class Kernel:
    """An event of numba's compiler."""

    def __init__(self, module="skancf.theories.full.kernels"):
        function = type("residual", (), {"__module__": module})
        self.data = {"dispatcher": type("Dispatcher", (), {"py_func": function})}


@pytest.fixture
def fresh(monkeypatch):
    """One that hears nothing of numba and ticks fast."""
    monkeypatch.setattr(compiling, "TICK", 0.01)
    monkeypatch.setattr(compiling, "OVER", 0.05)
    monkeypatch.setattr(progress, "_lines", [])
    one = Announcer()
    one.share()
    return one


def wait_for(text, stream):
    end = time.perf_counter() + 5
    while text not in stream.getvalue() and time.perf_counter() < end:
        time.sleep(0.01)
    return text in stream.getvalue()


def test_a_terminal_shows_count_and_seconds_and_their_sum(fresh, monkeypatch):
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    for _ in range(2):
        fresh.on_start(Kernel())
        fresh.on_start(Kernel())  # one that the first one calls
        time.sleep(0.03)
        fresh.on_end(Kernel())
        assert fresh.is_on
        fresh.on_end(Kernel())
        assert not fresh.is_on
        assert terminal.getvalue().endswith(" \r"), "the terminal is free for what the user prints"
    assert wait_for("compiled 2 kernels in 0 s; later runs load them\n", terminal)
    lines = terminal.getvalue().split("\r")
    assert sum(line.startswith("compiling kernels (once per machine, about 30 s): 0 done, 0 s") for line in lines) > 1
    assert sum(line.startswith("compiling kernels (once per machine, about 30 s): 1 done, 0 s") for line in lines) > 1
    assert terminal.getvalue().count("\n") == 1


def test_a_bar_waits_for_the_compiler(fresh, monkeypatch):
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setattr(progress, "DELAY", 0.0)
    monkeypatch.setattr(progress, "INTERVAL", 0.0)
    with progress.Bar("work", 2, True) as bar:
        fresh.on_start(Kernel())
        bar.at(1, "one")
        assert "work" not in terminal.getvalue()
        fresh.on_end(Kernel())
        bar.at(2, "two")
    shown = terminal.getvalue()
    assert shown.index("compiled 1 kernels") < shown.index("work: 100%")


def test_what_is_no_terminal_gets_nothing_but_the_log_does(fresh, capsys, caplog):
    with caplog.at_level(logging.INFO, "skancf"):
        for _ in range(2):
            fresh.on_start(Kernel())
            fresh.on_end(Kernel())
    fresh.finish()
    assert capsys.readouterr() == ("", "")
    first, *rest = [record.getMessage() for record in caplog.records]
    assert first == "compiling kernels (once per machine, about 30 s)"
    assert [line.split(" in ")[0] for line in rest] == ["compiled skancf.theories.full.kernels.residual"] * 2


def test_functions_of_users_are_none_of_ours(fresh, monkeypatch):
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    fresh.on_start(Kernel("users"))
    fresh.on_end(Kernel("users"))
    assert terminal.getvalue() == "" and fresh.kernels == 0


def test_the_compiler_of_numba_is_heard(caplog):
    def double(x):
        return 2 * x

    double.__module__ = "skancf.of_a_test"
    announcer = announce()
    before = announcer.kernels
    with caplog.at_level(logging.INFO, "skancf.compiling"):
        assert numba.njit(double)(2) == 4
    assert announcer.kernels == before + 1
    assert "compiled skancf.of_a_test.double" in caplog.records[-1].getMessage()
