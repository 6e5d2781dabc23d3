"""One process at a time writes into the folder of a run."""

import json
import os
import signal
import socket
import subprocess
import sys
import time

import pytest

import skancf as sk
from skancf.dynamics import run_lock
from skancf.dynamics.run_lock import LOCK, RunLock
from skancf.errors import InputError
from skancf.solving import Status

SLOW = """
import time
from test_run_lock import run
def slowly(state):
    time.sleep(0.02)
    return 0.0
run({folder!r}, {resume}, slowly)
"""
TAKE = """
import sys, time
from pathlib import Path
from skancf.dynamics.run_lock import RunLock
while time.time() < float(sys.argv[2]): pass
lock = RunLock(Path(sys.argv[1]))
lock.take()
print("taken", flush=True)
sys.stdin.read()
lock.release()
"""


def system():
    problem = sk.Problem(sk.Rectangle(1.0, 1.0), 0.05, sk.Isotropic(1e6, 0.3, 1000.0), [sk.Clamp("left")],
                         [sk.EdgeLoad("right", (0, 0, 20.0))])  # fmt: skip
    return problem.on(sk.meshes.uniform(problem.surface, 2, 2), "kirchhoff")


def run(folder, resume=False, record=lambda state: 0.0, checkpoint=None):
    return sk.simulate(system(), 0.5, dt=2e-3, checkpoint=checkpoint or sk.Checkpoint(folder, every=5), resume=resume,
                       record={"nothing": record}, progress=False)  # fmt: skip


def process(code, *arguments, **more):
    path = os.pathsep.join([os.path.dirname(__file__), os.getcwd(), *sys.path])
    return subprocess.Popen([sys.executable, "-c", code, *map(str, arguments)], env={**os.environ, "PYTHONPATH": path},
                            text=True, **more)  # fmt: skip


def waited(condition, child):
    while not condition():
        assert child.poll() is None
        time.sleep(0.005)


def test_a_second_process_is_refused_until_the_first_is_gone(tmp_path):
    folder = tmp_path / "run"
    first = process(SLOW.format(folder=str(folder), resume=False))
    try:
        waited((folder / "piece_000002.npz").exists, first)
        for resume in (True, False):
            with pytest.raises(InputError, match=f"process {first.pid} on '{socket.gethostname()}' is writing its run"):
                run(folder, resume)
        # Others look at it meanwhile.
        motion = sk.read_motion(system(), folder)
        assert motion.status is Status.UNFINISHED and motion.times[-1] > 0
        assert first.poll() is None and json.loads((folder / LOCK).read_text())["pid"] == first.pid
    finally:
        first.send_signal(signal.SIGKILL if os.name == "posix" else signal.SIGTERM)
        first.wait()
    assert (folder / LOCK).exists(), "it had no time to take it away"
    done = run(folder, True)
    assert done.status is Status.FINISHED and done.times[-1] == pytest.approx(0.5)
    assert not (folder / LOCK).exists()
    assert run(folder, True).status is Status.FINISHED


def test_of_processes_that_begin_at_once_one_goes_on(tmp_path):
    at = time.time() + 2.5
    (tmp_path / LOCK).write_text(json.dumps({"pid": 2**22 + 1, "host": socket.gethostname()}))  # of one that was killed
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    children = [process(TAKE, tmp_path, at, **pipes) for _ in range(3)]
    deadline = time.time() + 60
    while sum(child.poll() is None for child in children) > 1 and time.time() < deadline:
        time.sleep(0.02)
    out = [child.communicate() for child in children]
    assert sum("taken" in said for said, _ in out) == 1
    assert sum("is writing its run into it" in wrong for _, wrong in out) == 2
    assert not (tmp_path / LOCK).exists()


def test_a_process_is_refused_what_it_writes_itself(tmp_path):
    tried = []

    def again(state):
        if state.time > 0.01 and not tried:
            with pytest.raises(InputError) as refused:
                run(tmp_path, True)
            tried.append(refused)
        return 0.0

    assert run(tmp_path, record=again).status is Status.FINISHED
    assert tried[0].match("this process is writing its run") and not (tmp_path / LOCK).exists()
    with pytest.raises(InputError, match="holds a run already"):
        run(tmp_path)
    assert not (tmp_path / LOCK).exists(), "given back where the folder is refused"


def test_locks_of_other_hosts_are_not_broken(tmp_path):
    (tmp_path / LOCK).write_text(json.dumps({"pid": 1, "host": "elsewhere"}))
    with pytest.raises(InputError, match=r"process 1 on 'elsewhere' may still be writing .* remove '.*lock'"):
        RunLock(tmp_path).take()
    (tmp_path / LOCK).unlink()
    RunLock(tmp_path).take()


@pytest.mark.skipif(os.name != "posix", reason="processes are asked for by signal 0")
def test_where_the_system_has_no_locks_the_number_of_the_process_tells(tmp_path, monkeypatch):
    monkeypatch.setattr(run_lock, "_lock", lambda file: None)
    lock = RunLock(tmp_path)
    lock.take()
    with pytest.raises(InputError, match="this process may still be writing"):
        RunLock(tmp_path).take()
    (tmp_path / LOCK).write_text(json.dumps({"pid": 2**22 + 1, "host": socket.gethostname()}))
    other = RunLock(tmp_path)
    other.take()
    assert json.loads((tmp_path / LOCK).read_text())["pid"] == os.getpid()
    other.release()
    assert not (tmp_path / LOCK).exists()


@pytest.mark.parametrize("content", ["", "{", "[1]", "null"])
def test_a_file_that_was_cut_off_is_in_nobodys_way(content, tmp_path):
    (tmp_path / LOCK).write_text(content)
    lock = RunLock(tmp_path)
    lock.take()
    lock.release()
    assert not (tmp_path / LOCK).exists()
