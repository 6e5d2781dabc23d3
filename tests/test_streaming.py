"""Runs whose states do not fit into memory: they stay in their folder, and in the file that is made of it."""

import os
import pickle
import signal
import subprocess
import sys
import tracemalloc
import warnings
from dataclasses import replace

import numpy as np
import pytest
from kept import STEEL, linked

import skancf as sk
from skancf.equality import same
from skancf.rows import Rows
from skancf.storage import files, hdf5

EVERY, STEPS = 8, 64


@pytest.fixture(scope="module")
def system():
    asked = sk.Problem(
        sk.Rectangle(1.0, 1.0), 0.01, STEEL, [sk.Clamp("left")],
        [sk.PointForce((1.0, 0.5), (0.0, 0.0, -100.0)), sk.Impulse((1.0, 0.5), (0.0, 0.0, 0.1), time=5.2e-3)],
        sk.Damping(stiffness=1e-4),
    )  # fmt: skip
    return asked.on(sk.meshes.uniform(asked.surface, 8, 8), "kirchhoff")


def run(system, folder, steps=STEPS, in_memory=False, **more):
    checkpoint = sk.Checkpoint(folder, EVERY, in_memory)
    options = {"dt": 1e-4, "outputs": "steps", "progress": False, "checkpoint": checkpoint, "balance": None} | more
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return sk.simulate(system, steps * 1e-4, **options)


@pytest.fixture(scope="module")
def both(system, tmp_path_factory):
    """The same run in memory and in a folder, and a file of the latter."""
    folder = tmp_path_factory.mktemp("runs")
    streamed = run(system, folder / "run")
    return run(system, folder / "here", in_memory=True), streamed, sk.save(streamed, folder / "run.h5")


@pytest.fixture
def lazily(monkeypatch):
    monkeypatch.setattr(files, "LAZY", 1000)


def timeless(motion):
    return replace(motion, seconds=0.0)


def test_the_motion_is_the_same_to_the_last_bit(both, lazily):
    here, streamed, file = both
    loaded = sk.load(file)
    for motion in (streamed, loaded):
        assert isinstance(motion.segments[0].q, Rows) and timeless(motion) == timeless(here)
        assert len(motion.segments) == 2 and np.array_equal(motion.q, here.q) and np.array_equal(motion.v, here.v)
        for ask in (lambda m: m.displacement((1.0, 0.5)), lambda m: m.at(6.17e-3).q, lambda m: m.times,
                    lambda m: m.history(lambda s: s.strain_energy)):  # fmt: skip
            assert np.array_equal(ask(motion), ask(here))
        assert pickle.loads(pickle.dumps(motion)) == motion
    assert "Rows" in repr(loaded.segments[0].q)


@pytest.mark.parametrize(
    "key", [3, -1, slice(2, 9, 3), slice(None, None, -2), [1, 1, 0], np.array([True, False] * 10), (4, 2), (slice(3), 1)]
)
def test_rows_are_indexed_as_arrays_are(key):
    class Own(Rows):
        def read(self, numbers):
            return array[numbers]

    array = np.arange(60.0).reshape(20, 3)
    rows = Own(array.shape)
    assert np.array_equal(rows[key], array[key]) and np.array_equal(np.asarray(rows), array)
    assert len(rows) == 20 and rows.size == 60 and rows.nbytes == 480 and rows[np.zeros(20, bool)].shape == (0, 3)
    with pytest.raises(IndexError):
        _ = rows[20]


def peak(call):
    """Most memory (bytes) that a call took of what Python and numpy count."""
    tracemalloc.start()
    try:
        value = call()
        return value, tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def test_memory_does_not_grow_with_the_run(system, both, tmp_path, lazily, monkeypatch):
    one_state = 2 * 8 * system.n_dofs
    monkeypatch.setattr(hdf5, "CHUNK", 4 * one_state)
    _, at_first = peak(lambda: run(system, tmp_path / "short", STEPS // 4))
    long, in_the_end = peak(lambda: run(system, tmp_path / "long", STEPS))
    _, in_memory = peak(lambda: run(system, tmp_path / "here", STEPS, in_memory=True))
    more = (STEPS - STEPS // 4) * one_state
    assert in_the_end - at_first < 0.2 * more < more < 1.2 * (in_memory - at_first), "and the other way it does grow"
    file, saving = peak(lambda: sk.save(long, tmp_path / "run.h5"))
    loaded, loading = peak(lambda: sk.load(file))
    tips, asking = peak(lambda: [state.q[-1] for state in loaded.states])
    monkeypatch.setattr(files, "LAZY", 1e9)
    _, at_once = peak(lambda: sk.load(file))
    states = STEPS * one_state
    assert saving < 0.7 * states < at_once - loading and asking < 0.2 * states and len(tips) == STEPS + 1
    assert tips[-1] == both[0].q[-1, -1]


def test_conditions_and_meshes_that_follow(tmp_path):
    one, two = (run(linked(), tmp_path / str(kept), 20, kept, outputs=7) for kept in (True, False))
    assert timeless(two) == timeless(one) and two.at(1e-3).conditions == one.at(1e-3).conditions
    assert timeless(sk.load(sk.save(two, tmp_path / "linked.h5"))) == timeless(one)
    asked = linked().problem
    tree = replace(asked, conditions=[]).on(sk.meshes.quadtree(sk.meshes.uniform(asked.surface, 4, 2)), "kirchhoff")
    follow = {"follow": sk.Follow(rtol=0.05, every=4), "outputs": 8}
    one, two = (run(tree, tmp_path / f"follow {kept}", 24, kept, **follow) for kept in (True, False))
    assert len(two.segments) > 1 and timeless(two) == timeless(one)
    loaded = sk.load(sk.save(two, tmp_path / "follow.h5"))
    assert timeless(loaded) == timeless(one) and len({part.system.n_dofs for part in loaded.segments}) > 1


def test_a_run_that_was_cut_off_is_read_and_goes_on(system, both, tmp_path):
    def quantity(state):
        if state.time > 34.5e-4 and not going:
            raise KeyboardInterrupt
        return state.q[-1]

    going: list[bool] = []
    record = {"tip": quantity}
    stopped = run(system, tmp_path / "run", record=record)
    assert stopped.status.name == "INTERRUPTED"
    so_far = sk.read_motion(system, tmp_path / "run", in_memory=False)
    assert isinstance(so_far.segments[0].q, Rows) and len(so_far.times) >= 30
    assert np.array_equal(so_far.q, both[0].q[: len(so_far.times)])
    assert np.array_equal(sk.load(sk.save(so_far, tmp_path / "so_far.h5")).q, so_far.q)
    going.append(True)
    again = run(system, tmp_path / "run", record=record, resume=True)
    assert np.array_equal(again.q, run(system, tmp_path / "all", record=record).q) and again.ok


KILLED = """
import sys, skancf as sk
sys.path.insert(0, {tests!r})
from kept import system
def quantity(state):
    if state.time > 45e-4:
        print("there", flush=True)
    return state.q[-1]
sk.simulate(system(), 1.0, dt=1e-4, outputs="steps", progress=False, record=dict(tip=quantity), balance=None,
            checkpoint=sk.Checkpoint({folder!r}, every=5, in_memory=False))
"""


def test_nothing_that_was_written_is_lost_by_a_kill(tmp_path):
    import kept

    folder = tmp_path / "run"
    code = KILLED.format(tests=os.path.dirname(__file__), folder=str(folder))
    process = subprocess.Popen([sys.executable, "-W", "ignore", "-c", code], stdout=subprocess.PIPE)
    assert process.stdout is not None and process.stdout.readline() == b"there\n"
    process.send_signal(signal.SIGKILL)
    process.wait(timeout=30)
    process.stdout.close()
    so_far = sk.read_motion(kept.system(), folder, in_memory=False)
    assert so_far.times[-1] >= 44e-4 and so_far.status.name == "UNFINISHED"
    assert same(sk.load(sk.save(so_far, tmp_path / "run.h5")).q, so_far.q)


def test_a_file_that_is_gone_another_or_damaged_is_named(both, tmp_path, lazily):
    file = tmp_path / "run.h5"
    file.write_bytes(both[2].read_bytes())
    one, two, three = (sk.load(file) for _ in range(3))
    assert one.segments[0].q[0].size
    sk.save(replace(both[0], seconds=1.0), file)
    assert one.segments[0].q[1].size, "an open file stays the one that it was"
    with pytest.raises(sk.InputError, match="is another one than was loaded"):
        _ = two.segments[0].q[0]
    file.unlink()
    with pytest.raises(sk.InputError, match="cannot be read"):
        _ = three.segments[0].q[0]
    data = bytearray(both[2].read_bytes())
    data[data.index(both[0].segments[0].q[30, 300:320].tobytes())] ^= 1
    file.write_bytes(data)
    with pytest.raises(sk.InputError, match="cannot be read"):
        _ = sk.load(file).segments[0].q[:]


def test_a_folder_that_is_gone_is_named(system, tmp_path):
    motion = run(system, tmp_path / "run", 20)
    for piece in (tmp_path / "run").glob("piece*"):
        piece.unlink()
    with pytest.raises(sk.InputError, match="is missing"):
        _ = motion.segments[0].q[0]
