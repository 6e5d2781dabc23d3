"""Runs on disk: killed, cut off between files, refused, and read without running."""

import errno
import io
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from contextlib import contextmanager, suppress
from pathlib import Path

import numpy as np
import pytest
import restarts
from restarts import CLAMP, RUNS, arrays, run, same

import skancf as sk
from skancf.dynamics import run_files
from skancf.linear import available_backends
from skancf.linear.mkl import n_threads
from skancf.solving import Status

SCRIPT = restarts.__file__
posix = pytest.mark.skipif(not hasattr(os, "fork"), reason="processes are killed by SIGKILL")
SEED = 11
ATTEMPTS = 12
"""Runs that are to be killed, until two processes were: where a machine has much else to do, they end before the signal."""


def files_of(folder):
    """Bytes of all files but the states, which hold the wall time."""
    return {file.name: file.read_bytes() for file in Path(folder).iterdir() if file.name != "state.npz"}


def loaded(file):
    with np.load(file) as data:
        return {name: data[name] for name in data.files if name != "seconds"}


# --- killed --------------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def server():
    """A process that forks for every run."""
    with subprocess.Popen([sys.executable, SCRIPT], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        yield process
        process.stdin.close()


def ordered(server, name, folder, result, piece=None, after=0.0):
    """One run in a process of its own, killed some time after it has written a piece; its exit status."""
    server.stdin.write(f"{name} {folder} {result}\n")
    server.stdin.flush()
    pid = int(server.stdout.readline())
    if piece is not None:
        with suppress(ProcessLookupError):  # it has ended
            while not (folder / f"piece_{piece:06d}.npz").exists():
                os.kill(pid, 0)
                time.sleep(1e-4)
            time.sleep(after)
            os.kill(pid, signal.SIGKILL)
    return int(server.stdout.readline())


@posix
@pytest.mark.parametrize("name", ["rough", "momentum", "moving", "meshes"])
def test_killed_runs_end_with_the_same_bytes(name, server, tmp_path):
    assert ordered(server, name, tmp_path / "whole", tmp_path / "whole.npz") == 0
    whole, moments = loaded(tmp_path / "whole.npz"), random.Random(SEED)
    with np.load(tmp_path / "whole.npz") as data:
        seconds = float(data["seconds"])
    n = len(list((tmp_path / "whole").glob("piece*")))
    killed = 0
    for attempt in range(ATTEMPTS):
        folder, result = tmp_path / f"cut{attempt}", tmp_path / f"cut{attempt}.npz"
        for piece in sorted(moments.sample(range(1, n - 1), 4)):
            status = ordered(server, name, folder, result, piece, moments.uniform(0, 2) * seconds / n)
            assert status in (0, signal.SIGKILL)
            killed += status != 0
        assert ordered(server, name, folder, result) == 0
        assert same(whole, loaded(result)) == []
        assert files_of(tmp_path / "whole") == files_of(folder)
        if killed > 1:
            break
    assert killed > 1, "hardly any process was killed while it computed"


THREADS = dict.fromkeys(("SKANCF_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "2")


@posix
@pytest.mark.parametrize("name", ["large", "large_superlu"])
def test_large_runs_have_the_same_bytes_in_every_process(name, tmp_path):
    """Where the factors and the assembly take several threads: places in memory and waiting threads change nothing."""
    if name == "large" and "mkl" not in available_backends():
        pytest.skip("needs MKL")

    def process(k):
        return subprocess.Popen([sys.executable, SCRIPT, name, tmp_path / f"run {k}", tmp_path / f"{k}.npz"],
                                env={**os.environ, **THREADS, "PADDING": "x" * 1000 * k})  # fmt: skip

    both = [process(k) for k in range(2)]  # at the same time, so that they disturb each other
    while not (tmp_path / "run 1" / "piece_000002.npz").exists():
        assert both[1].poll() is None
        time.sleep(0.02)
    both[1].kill()
    assert both[0].wait() == 0 and both[1].wait() == -signal.SIGKILL
    assert process(1).wait() == 0
    assert same(*(loaded(tmp_path / f"{k}.npz") for k in range(2))) == []
    assert files_of(tmp_path / "run 0") == files_of(tmp_path / "run 1")


def test_fresh_machine_code_gives_the_same_bytes(tmp_path):
    """A run goes on in a process that loads what the first one compiled."""

    def printed():
        return subprocess.run([sys.executable, SCRIPT, "forces"], env={**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)},
                              stdout=subprocess.PIPE, check=True).stdout  # fmt: skip

    compiled = printed()
    assert list(tmp_path.rglob("*residual*.nbc"))
    assert printed() == compiled


# --- cut off between files -----------------------------------------------------------------------------------------------


class Cut(BaseException):
    """No exception that a run would catch."""


@contextmanager
def cut_at(monkeypatch, n, before):
    """The n-th file is not moved to its place, or the process ends when it is there."""
    replace, calls = os.replace, iter(range(n))

    def cut(*args):
        last = next(calls, None) is None
        if last and before:
            raise Cut
        replace(*args)
        if last:
            raise Cut

    with monkeypatch.context() as patch:
        patch.setattr(os, "replace", cut)
        yield


@pytest.mark.parametrize("before", [True, False])
def test_cut_off_between_any_two_files(before, monkeypatch, tmp_path):
    system = restarts.system_on("kirchhoff", 2, CLAMP, [sk.Gravity((0, 0, -1.0)), restarts.STRUCK[0]], tree=True)
    options = {"outputs": 5, "progress": False, "resume": True, "dt": 4e-3, "balance": None, "follow": restarts.Looks()}

    def go(folder):
        return sk.simulate(system, 0.08, checkpoint=sk.Checkpoint(tmp_path / folder, 5), **options)

    whole = go("whole")
    assert [event.again for event in whole.ledger.events] == [True, False]
    n = len(list((tmp_path / "whole").iterdir()))
    names = {file.name.split("_")[0] for file in (tmp_path / "whole").iterdir()}
    assert names == {"run.npz", "piece", "mesh", "state.npz"}
    n_cuts = n + len(list((tmp_path / "whole").glob("piece*"))) - 1  # the state is written with every piece
    for k in range(n_cuts):
        with cut_at(monkeypatch, k, before), pytest.raises(Cut):
            go(f"{k}")
        assert same(arrays(whole), arrays(go(f"{k}"))) == [], f"cut at file {k}"
        assert files_of(tmp_path / "whole") == files_of(tmp_path / f"{k}")


# --- refused -------------------------------------------------------------------------------------------------------------


def small(thickness=0.05, young=1e6, n=2, supports=None, history=None, theory="kirchhoff", loads=(), tree=False, **options):
    """A short run, and what it is asked for."""
    surface = sk.Rectangle(1.0, 1.0)
    loads = [sk.EdgeLoad("right", (0, 0, 5.0), history=history), *loads]
    problem = sk.Problem(surface, thickness, sk.Isotropic(young, 0.3, 1000.0), supports or CLAMP, loads)
    mesh = sk.meshes.uniform(surface, n, n)
    system = problem.on(sk.meshes.quadtree(mesh, surface) if tree else mesh, theory)
    return system, {"dt": 5e-3, "outputs": 3, "progress": False, "record": {"tip": restarts.tip}, **options}


def start(folder, every=4, t_end=0.05, resume=True, **what):
    system, options = small(**what)
    return sk.simulate(system, t_end, checkpoint=sk.Checkpoint(folder, every), resume=resume, **options)


@pytest.fixture
def folder(tmp_path):
    """Of a run that was cut off."""

    def stop(state):
        if state.time > 0.033:
            raise Cut
        return restarts.tip(state)

    with pytest.raises(Cut):
        start(tmp_path / "run", record={"tip": stop})
    names = {file.name for file in (tmp_path / "run").iterdir()}
    assert names == {"run.npz", "state.npz", "piece_000001.npz", "piece_000002.npz"}
    return tmp_path / "run"


@pytest.mark.parametrize(("what", "words"), [
    ({"n": 3}, "another mesh"),
    ({"thickness": 0.06}, "thickness = 0.05, this one 0.06"),
    ({"young": 2e6}, r"material = Isotropic\(young=1000000.0.*this one Isotropic\(young=2000000.0"),
    ({"supports": [sk.Pin("left")]}, "another supports"),
    ({"supports": [*CLAMP, sk.Spring((1.0, 1.0), (0, 0, 1.0))]}, "another stiffness"),
    ({"loads": [sk.PointForce((1.0, 1.0), (0, 0, 1e-3))]}, "another loads"),
    ({"loads": [sk.Impulse((1.0, 1.0), (0, 0, 1e-3), 0.02)]}, "another impulses"),
    ({"theory": "full"}, "theory = Kirchhoff.*this one Full"),
    ({"rule": sk.GeneralizedAlpha()}, "rule = EnergyMomentum.*this one GeneralizedAlpha"),
    ({"rho_inf": 0.7}, "rule = .*0.7"),
    ({"dt": 4e-3}, r"control = FixedStep\(dt=0.005"),
    ({"newton_rtol": 1e-6}, "newton rtol = None, this one 1e-06"),
    ({"balance": None}, "balance = 0.001, this one None"),
    ({"outputs": 4}, "outputs = "),
    ({"record": {"top": restarts.tip}}, r"record = \['tip'\], this one \['top'\]"),
    ({"every": 5}, "every = 4, this one 5"),
    ({"t_end": 0.06}, "end = 0.05, this one 0.06"),
    ({"tree": True, "follow": restarts.Looks()}, r"follow = None, this one Looks\(every=3\)"),
    ({"velocity": sk.RigidVelocity((0, 0, 1e-3))}, "another start velocity"),
    ({"backend": "superlu"}, "backend = mkl, .* threads, this one superlu"),
])  # fmt: skip
def test_a_run_of_something_else_is_refused(what, words, folder):
    if "backend" in what and "mkl" not in available_backends():
        pytest.skip("there is one solver only")
    known = files_of(folder)
    with pytest.raises(sk.InputError, match=words) as refusal:
        start(folder, **what)
    assert "state.npz" in str(refusal.value) and "begin in another folder" in str(refusal.value)
    assert files_of(folder) == known


def test_another_history_is_refused(tmp_path):
    start(tmp_path / "run", history=lambda t: 1.0)
    with pytest.raises(sk.InputError, match="another function of time 1"):
        start(tmp_path / "run", history=lambda t: 1.0 + (abs(t - 0.0301) < 2e-4))


def test_another_start_is_refused(folder):
    system, options = small()
    q = system.undeformed + system.constraints.free_part(1e-3 * np.ones(system.n_dofs))
    with pytest.raises(sk.InputError, match="another start, by"):
        sk.simulate(system, 0.05, checkpoint=sk.Checkpoint(folder, 4), resume=True, start=sk.Solution(system, q), **options)


def test_another_version_is_refused_but_read(folder, monkeypatch):
    monkeypatch.setattr("skancf.dynamics.fingerprint.__version__", "99.0")
    with pytest.raises(sk.InputError, match=r"version = .*, this one 99.0"):
        start(folder)
    assert sk.read_motion(small()[0], folder).status is Status.UNFINISHED


def rewritten(file, **changes):
    """A file of the same arrays with others among them; None takes one away."""
    with np.load(file) as data:
        arrays = {name: data[name] for name in data.files} | changes
    np.savez(file, **{name: array for name, array in arrays.items() if array is not None})


class Trap:
    """Ends a test that unpickles it."""

    def __reduce__(self):
        return os._exit, (3,)


def trapped(file):
    stream = io.BytesIO()
    np.savez(stream, format=np.array([Trap()], dtype=object))
    file.write_bytes(stream.getvalue())


def truncated(file):
    file.write_bytes(file.read_bytes()[:-200])


def flipped(file):
    """Bits in the middle; one alone may be a time of an archive's member, which nothing depends on."""
    data = bytearray(file.read_bytes())
    for k in range(len(data) // 2, len(data) // 2 + 300, 100):
        data[k] ^= 1
    file.write_bytes(data)


@pytest.mark.parametrize(("name", "damage", "words"), [
    ("state.npz", truncated, "is damaged"),
    ("state.npz", flipped, "is damaged"),
    ("state.npz", trapped, "is damaged"),
    ("state.npz", lambda file: file.write_bytes(b""), "is damaged"),
    ("state.npz", lambda file: np.savez(file, a=np.zeros(3)), "is no part of a run"),
    ("state.npz", lambda file: rewritten(file, format="skancf run 99"), "is skancf run 99; this version reads"),
    ("state.npz", lambda file: rewritten(file, **{"run.counts.knots": 3}), "does not fit its pieces"),
    ("state.npz", lambda file: rewritten(file, **{"run.now.q": np.zeros(3)}), "is no state of a run"),
    ("state.npz", Path.unlink, "'state.npz' is missing"),
    ("piece_000001.npz", Path.unlink, "is missing"),
    ("piece_000002.npz", truncated, "is damaged"),
    ("piece_000002.npz", trapped, "is damaged"),
    ("piece_000002.npz", lambda file: shutil.copy(file.with_name("piece_000001.npz"), file), "belongs to another run"),
    ("run.npz", flipped, "is damaged"),
    ("run.npz", Path.unlink, "is missing"),
])  # fmt: skip
def test_damage_is_named(name, damage, words, folder):
    damage(folder / name)
    with pytest.raises(sk.InputError) as refusal:
        start(folder)
    assert words in str(refusal.value) and str(folder) in str(refusal.value)
    with pytest.raises(sk.InputError):
        sk.read_motion(small()[0], folder)


def test_a_state_from_elsewhere_is_refused(folder, tmp_path):
    start(tmp_path / "other", history=lambda t: 2.0)
    shutil.copy(tmp_path / "other" / "state.npz", folder / "state.npz")
    with pytest.raises(sk.InputError, match=r"run.npz': is damaged, or belongs to another run"):
        start(folder)


def test_a_mesh_that_is_missing_or_another_is_named(tmp_path):
    run("meshes", tmp_path / "run")
    meshes = sorted((tmp_path / "run").glob("mesh*"))
    shutil.copy(meshes[0], meshes[1])
    with pytest.raises(sk.InputError, match=rf"{meshes[1].name}': is damaged"):
        run("meshes", tmp_path / "run", resume=True)
    meshes[0].unlink()
    with pytest.raises(sk.InputError, match=rf"{meshes[0].name}': is missing"):
        run("meshes", tmp_path / "run", resume=True)


def test_a_folder_that_holds_a_run_is_not_begun_anew(folder):
    with pytest.raises(sk.InputError, match="holds a run already; go on with it by resume=True"):
        start(folder, resume=False)


def test_without_a_folder():
    system, options = small()
    with pytest.raises(sk.InputError, match="from which folder"):
        sk.simulate(system, 0.05, resume=True, **options)


@pytest.mark.parametrize("resume", [False, True])
def test_a_folder_that_cannot_be_written(resume, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(sk.InputError, match=r"file' ?.*cannot be written"):
        start(tmp_path / "file", resume=resume)


@pytest.mark.parametrize("every", [0, -1, 2.5, "often"])
def test_every_is_a_number_of_steps(every):
    with pytest.raises(sk.InputError, match="every = "):
        sk.Checkpoint("run", every)


def test_a_finished_run_is_not_computed_again(tmp_path, monkeypatch):
    known = start(tmp_path / "run", every=np.int64(3))
    with monkeypatch.context() as patch:
        patch.setattr("skancf.dynamics.step_solver.StepSolver.step", None)
        again = start(tmp_path / "run", every=3)
    assert again.ok and same(arrays(known), arrays(again)) == []
    assert again.seconds > 0


# --- the disk ------------------------------------------------------------------------------------------------------------


class Full(io.BytesIO):
    """A disk that takes the first half of what it is given."""

    def __init__(self, file):
        super().__init__()
        self.file = file

    def write(self, data):
        with open(self.file, "wb") as stream:
            stream.write(data[: len(data) // 2])
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


@pytest.mark.parametrize("n", range(4))
def test_a_full_disk_ends_the_run_and_keeps_what_there_is(n, tmp_path, monkeypatch):
    """Of the pieces and states that follow the first ones, the n-th cannot be written, and none after it."""
    opened, calls = Path.open, iter(range(3 + n))

    def full(self, mode="r", *args, **kwargs):
        if ".part" in self.name and "w" in mode and next(calls, None) is None:
            return Full(self)
        return opened(self, mode, *args, **kwargs)

    with monkeypatch.context() as patch:
        patch.setattr(Path, "open", full)
        cut = start(tmp_path / "run")
    assert cut.status is Status.FAILED
    for words in (str(tmp_path / "run"), "No space left on device", "what was computed is kept", "Make room", "resume=True"):
        assert words in cut.message
    assert "Error" not in cut.message and "[Errno" not in cut.message
    assert cut.segments[-1].times[-1] == pytest.approx([0.02, 0.02, 0.04, 0.04][n])
    assert not list((tmp_path / "run").glob(".*"))
    read = sk.read_motion(small()[0], tmp_path / "run")
    assert read.segments[-1].times[-1] == pytest.approx([0.0, 0.0, 0.02, 0.02][n])
    assert same(arrays(start(tmp_path / "whole")), arrays(start(tmp_path / "run"))) == []
    assert files_of(tmp_path / "whole") == files_of(tmp_path / "run")


def test_a_last_write_that_fails_does_not_lose_the_run(tmp_path, monkeypatch):
    known = run_files.RunFiles.write_state

    def fail(self, name, state):
        if state["status"] == "FINISHED":
            raise OSError(errno.EIO, os.strerror(errno.EIO))
        known(self, name, state)

    with monkeypatch.context() as patch:
        patch.setattr(run_files.RunFiles, "write_state", fail)
        cut = start(tmp_path / "run")
    assert cut.status is Status.FAILED and "Input/output error" in cut.message
    assert cut.times[-1] == pytest.approx(0.05)
    assert start(tmp_path / "run").ok


@pytest.mark.parametrize("again", [False, True])
def test_a_folder_that_is_removed_on_the_way(again, tmp_path):
    """Nor is a folder that came back empty filled with half a run."""

    def remove(state):
        if state.time == pytest.approx(0.025):
            shutil.rmtree(tmp_path / "run")
            if again:
                (tmp_path / "run").mkdir()
        return restarts.tip(state)

    cut = start(tmp_path / "run", record={"tip": remove})
    assert cut.status is Status.FAILED and cut.segments[-1].times[-1] == pytest.approx(0.04)
    assert f"folder '{tmp_path / 'run'}' cannot be written any more (it is gone" in cut.message
    assert "until t = 0.02 s" in cut.message
    assert not again or not list((tmp_path / "run").iterdir())


def test_a_record_that_cannot_be_written_is_told_at_once(tmp_path):
    with pytest.raises(sk.SkancfError, match=r"record\['tip'\] gives what cannot be written, for example a dict"):
        start(tmp_path / "run", record={"tip": lambda state: {}})


def test_a_load_without_a_value_is_found_when_the_run_gets_there(tmp_path):
    cut = start(tmp_path / "run", history=lambda t: 1.0 if t < 0.03 else np.nan)
    assert cut.status is Status.FAILED and "history at t" in cut.message
    again = start(tmp_path / "run", history=lambda t: 1.0 if t < 0.03 else np.nan)
    assert same(arrays(cut), arrays(again)) == []


# --- read ----------------------------------------------------------------------------------------------------------------


def test_read_without_running(folder, monkeypatch):
    whole = start(folder.with_name("whole"))
    monkeypatch.setattr("skancf.dynamics.run.Run.__init__", None)
    with np.load(folder / "state.npz") as state:
        written = state["run.now.q"]
    cut = sk.read_motion(small()[0], folder)
    assert cut.status is Status.UNFINISHED and not cut.ok
    assert "until t = 0.02 s of 0.05 s" in cut.message
    assert [step.time for step in cut.steps] == pytest.approx([0.005, 0.01, 0.015, 0.02])
    assert len(cut.records["tip"][0]) == len(cut.ledger.times) == 5
    assert np.array_equal(cut.at(0.02).q, written) and cut.times.tolist() == [0.0]
    assert same(arrays(whole), arrays(sk.read_motion(small()[0], folder.with_name("whole")))) == []


def test_what_a_stopped_run_computed_is_read_to_its_end(tmp_path):
    """And a run that goes on leaves no trace of it."""

    def stop(state):
        if state.time > 0.033:
            raise KeyboardInterrupt
        return restarts.tip(state)

    cut = start(tmp_path / "run", record={"tip": stop})
    read = sk.read_motion(small()[0], tmp_path / "run")
    assert read.status is Status.INTERRUPTED and read.message == cut.message
    assert same(arrays(cut), arrays(read)) == [] and read.segments[-1].times[-1] == pytest.approx(0.035)
    assert start(tmp_path / "run").ok
    start(tmp_path / "whole")
    assert files_of(tmp_path / "run") == files_of(tmp_path / "whole")


def test_read_on_several_meshes(tmp_path):
    motion = run("meshes", tmp_path / "run")
    read = sk.read_motion(RUNS["meshes"]()[0], tmp_path / "run")
    assert same(arrays(motion), arrays(read)) == [] and len(read.segments) > 3
    assert read.at(0.09).strain_energy == motion.at(0.09).strain_energy


def test_an_event_where_the_run_was_just_written(tmp_path):
    """The output at that time is the state after it; the piece that was written before has the one before it."""
    what = {"loads": [sk.Impulse((1.0, 1.0), (0, 0, 0.1), 0.02)], "outputs": [0.0, 0.02, 0.05]}
    motion = start(tmp_path / "run", **what)
    assert motion.times.tolist() == [0.0, 0.02, 0.05] and len(motion.segments) == 2
    assert same(arrays(motion), arrays(sk.read_motion(small(**what)[0], tmp_path / "run"))) == []
    assert same(arrays(motion), arrays(start(tmp_path / "run", **what))) == []


@pytest.mark.parametrize(("what", "words"), [
    ({"n": 3}, "another mesh"), ({"young": 2e6}, "material ="), ({"theory": "full"}, "theory ="),
])  # fmt: skip
def test_another_problem_is_not_read(what, words, folder):
    with pytest.raises(sk.InputError, match=rf"{words}.*give read_motion the system of the run"):
        sk.read_motion(small(**what)[0], folder)


def test_a_folder_without_a_run_is_not_read(tmp_path):
    with pytest.raises(sk.InputError, match="holds no run"):
        sk.read_motion(small()[0], tmp_path)


@pytest.mark.skipif("mkl" not in available_backends(), reason="needs MKL")
def test_a_run_knows_its_threads(folder, monkeypatch):
    assert n_threads() >= 1
    monkeypatch.setattr("skancf.linear.mkl.n_threads", lambda: 64)
    with pytest.raises(sk.InputError, match=r"backend = mkl, .* threads, this one mkl, 64 threads"):
        start(folder)
