"""What objects of the user's own remember survives a stop, goes back with the run, and is known by its names on disk."""

import numpy as np
import pytest
import restarts
from restarts import CLAMP, arrays, same

import skancf as sk
from skancf.dynamics import HasState
from skancf.dynamics.log import Log
from skancf.dynamics.named_state import flat, nested
from skancf.terms import Addition, Term

pytestmark = pytest.mark.filterwarnings("ignore::skancf.OutOfDepth")  # vibrations of long steps are not followed
T_END = 0.06


class Forgets:
    """A load that pushes harder with every step, as wear or a history of the material would; its memory is not said."""

    load = True

    def __init__(self, at):
        self.at, self.worn = at, np.zeros(2)

    def force(self, q, v, case):
        out = np.zeros_like(q)
        out[self.at] = -0.1 * self.worn[1] - 1.0
        return out

    def reached(self, q, v, case):
        self.worn += [0.0, 1.0]  # in place, as a careless object would


class Remembers(Forgets):
    def state(self):
        return {"wear": {"worn": self.worn}}

    def restore(self, state):
        self.worn = state["wear"]["worn"]


class On(Addition):
    def __init__(self, kind):
        self.kind = kind

    def on(self, shell, layout):
        return type("Load", (self.kind, Term), {})(layout.n_dofs - 10)


class Short:
    """Every third accepted step is short."""

    smallest = 1e-3

    def __init__(self, every=3):
        self.every, self.count = every, 0

    def __repr__(self):
        return f"Short({self.every})"

    def first(self, guess):
        return 2e-3

    def accepts(self, attempt):
        self.count += 1
        return True

    def next_step(self, attempt):
        return 1e-3 if self.count % self.every == 0 else 2e-3


class Counting(Short):
    more = None

    def state(self):
        return {"count": self.count, "name": "third", "last": self.more}

    def restore(self, state):
        assert state["name"] == "third" and isinstance(state["count"], int)
        self.count = state["count"]


def simulated(folder, term=None, steps=None, cut=None, tree=False, **options):
    """A run with objects of its own, to its end or until it is interrupted."""

    def stop(state):
        if cut is not None and state.time > cut:
            raise KeyboardInterrupt
        return 0.0

    surface = sk.Rectangle(1.0, 1.0)
    terms = [] if term is None else [On(term)]
    problem = sk.Problem(surface, 0.05, sk.Isotropic(1e6, 0.3, 1000.0), CLAMP, restarts.JUMP, terms=terms)
    mesh = sk.meshes.uniform(surface, 2, 2)
    system = problem.on(sk.meshes.quadtree(mesh, surface) if tree else mesh, "kirchhoff")
    control = {"dt": 2e-3} if steps is None else {"steps": steps()}
    checkpoint = None if folder is None else sk.Checkpoint(folder, every=4)
    return sk.simulate(system, T_END, outputs=5, record={"stop": stop}, balance=None, checkpoint=checkpoint,
                       resume=folder is not None, progress=False, **control, **options)  # fmt: skip


@pytest.mark.parametrize(("what", "survives"), [
    ({"term": Remembers}, True), ({"term": Forgets}, False), ({"steps": Counting}, True), ({"steps": Short}, False),
    ({"term": Remembers, "steps": Counting}, True),
])  # fmt: skip
def test_what_an_object_remembers_survives_a_stop(what, survives, tmp_path):
    whole, plain = simulated(tmp_path / "whole", **what), simulated(tmp_path / "plain")
    assert whole.ok and not np.allclose(whole.q[-1], plain.q[-1], rtol=1e-6), "what it remembers changes the motion"
    assert not simulated(tmp_path / "cut", cut=0.021, **what).ok
    again = simulated(tmp_path / "cut", **what)
    assert again.ok and (same(arrays(whole), arrays(again)) == []) == survives


@pytest.mark.parametrize(("steps", "goes_back"), [(Counting, True), (Short, False)])
def test_what_an_object_remembers_goes_back_with_the_run(steps, goes_back):
    made = []
    motion = simulated(None, steps=lambda: made.append(steps()) or made[0], tree=True, follow=restarts.Looks())
    assert next(event.again for event in motion.ledger.events)
    n = sum(step.accepted for step in motion.steps)
    assert (made[0].count == n) == goes_back and made[0].count <= len(motion.steps)


def test_a_second_run_with_longer_steps_begins_as_the_first():
    """The error is that of shorter steps, not of a load that has worn."""
    motion = simulated(None, term=Remembers, check=True)
    assert motion.error[-1] < 0.2 * np.abs(motion.q[-1] - motion.q[0]).max()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Remembers, "restore", lambda self, state: None)
        worn = simulated(None, term=Remembers, check=True)
    assert worn.error[-1] > 1.5 * motion.error[-1]


def test_terms_that_remember_do_not_follow_meshes():
    with pytest.raises(sk.InputError, match=r"follow: a term remembers '[0-9]+\.wear\.worn', which does not go from mesh"):
        simulated(None, term=Remembers, tree=True, follow=sk.Follow())


# --- on disk -------------------------------------------------------------------------------------------------------------


def test_files_hold_arrays_with_names(tmp_path):
    n = sum(step.accepted for step in simulated(tmp_path, term=Remembers, steps=Counting).steps)
    with np.load(tmp_path / "state.npz", allow_pickle=False) as data:
        names = {"run.now.q", "run.solver.energy", "run.ledger.sums.work", "run.impulses.missed", "run.steps.count",
                 "run.dt"}  # fmt: skip
        assert names < set(data.files) and data["run.steps.count"] == n
        assert [name for name in data.files if name.endswith("wear.worn")] and data["run.steps.last"].size == 0
    with np.load(tmp_path / "piece_000002.npz", allow_pickle=False) as data:
        assert data["steps.accepted"].dtype == bool and len(data["ledger.kinetic"]) == 4 == len(data["steps.dt"])


@pytest.mark.parametrize(("changes", "words"), [
    ({"run.solver.energy": None}, "'solver.energy' is missing"),
    ({"run.steps.count": None}, "'steps.count' is missing"),
    ({"run.steps.more": np.array(1.0)}, "'steps.more' is missing there, or here"),
    ({"run.dt": np.ones(3)}, r"'dt' has the shape \(3,\)"),
    ({"run.steps.count": np.array("many")}, "'steps.count' has the shape .* <U4"),
    ({"run.now.jerk": np.ones(5), "run.now.q": np.ones(5)}, "vectors of other sizes than 108"),
    ({"run.solver.effort": np.array(7)}, "7 is not a valid Effort"),
])  # fmt: skip
def test_other_names_and_shapes_are_refused(changes, words, tmp_path):
    simulated(tmp_path, steps=Counting, cut=0.021)
    with np.load(tmp_path / "state.npz") as data:
        known = {name: data[name] for name in data.files} | changes
    np.savez(tmp_path / "state.npz", **{name: array for name, array in known.items() if array is not None})
    with pytest.raises(sk.InputError, match=rf"state.npz': is no state of a run \({words}.*begin in another folder"):
        simulated(tmp_path, steps=Counting)


@pytest.mark.parametrize("value", [{1, 2}, [[1.0], [1.0, 2.0]], object()])
def test_what_cannot_be_written_is_told_at_once(value, tmp_path, monkeypatch):
    monkeypatch.setattr(Counting, "more", value)
    with pytest.raises(sk.SkancfError, match=r"run\.steps\.last gives what cannot be written, for example a (set|list|obj)"):
        simulated(tmp_path, steps=Counting)


def test_quantities_of_other_shapes_on_every_mesh(tmp_path):
    def once(folder, stop=np.inf):
        def elements(state):
            if state.time > stop:
                raise KeyboardInterrupt
            return np.full(state.system.geometry.n_elements, state.time, np.float32)

        system, options = restarts.RUNS["meshes"]()
        return sk.simulate(system, 0.1, progress=False, outputs=3, checkpoint=sk.Checkpoint(folder, 7), resume=True,
                           **options | {"dt": 4e-3, "record": {"elements": elements}})  # fmt: skip

    whole = once(tmp_path / "whole")
    once(tmp_path / "cut", 0.07)
    again = once(tmp_path / "cut")
    values = [motion.records["elements"][1] for motion in (whole, again)]
    assert len({value.shape for value in values[0]}) > 2 and values[1][-1].dtype == np.float32
    assert all(np.array_equal(one, two) for one, two in zip(*values, strict=True))


# --- states and logs -----------------------------------------------------------------------------------------------------


def test_states_there_and_back():
    state = {"a": np.arange(3), "b": {"c": 1.5, "d": {}, "e": "text"}, "f": None, "g": True, "h.i": -2}
    arrays_ = flat(state)
    assert set(arrays_) == {"a", "b.c", "b.e", "f", "g", "h.i"} and arrays_["a"] is not state["a"]
    back = nested(arrays_, state)
    assert np.array_equal(back.pop("a"), state["a"])
    assert back == {name: value for name, value in state.items() if name != "a"}
    assert back["g"] is True and isinstance(back["h.i"], int)


def test_a_value_may_come_and_go():
    fresh, later = {"before": None, "history": np.zeros(0)}, {"before": np.ones(2), "history": np.ones(4)}
    for one, two in ((fresh, later), (later, fresh)):
        back = nested(flat(one), two)
        assert np.array_equal(back["history"], one["history"])
        assert back["before"] is None if one is fresh else np.array_equal(back["before"], np.ones(2))


def test_logs_there_and_back():
    log = Log()
    log.extend({"t": 0.5 * k, "n": k, "q": np.full(2 + k % 2, k), "m": np.full((k, 2), k)} for k in range(5))
    first, again = Log(), Log()
    first.extend(log[:3])
    again.add(first.since(0))
    again.add(log.since(3))
    assert len(again) == 5
    assert all(type(row["n"]) is int and type(row["t"]) is float for row in again)
    assert all(np.array_equal(one[name], two[name]) for one, two in zip(log, again, strict=True) for name in one)
    assert log.since(5) == {}


def test_objects_without_both_methods_have_no_state():
    assert isinstance(Counting(), HasState)
    assert not isinstance(Short(), HasState) and not isinstance(sk.Follow(), HasState)
