"""Results as tables: names, units, lengths, pandas and files."""

import csv
import sys

import numpy as np
import pytest

import skancf as sk
from skancf.output import Columns
from skancf.tabular import Tabular


@pytest.fixture(scope="module")
def strip() -> sk.Problem:
    return sk.Problem(
        sk.Rectangle(1.0, 0.2), 0.01, sk.Isotropic(1e7, 0.3, 1e3), [sk.Clamp("left")],
        [sk.EdgeLoad("right", (0.0, 0.0, 0.05))],
    )  # fmt: skip


@pytest.fixture(scope="module")
def results(strip: sk.Problem) -> dict[str, Tabular]:
    system = strip.on(sk.meshes.uniform(strip.surface, 4, 1))
    pushed = sk.Problem(strip.surface, 0.01, strip.material, strip.supports, [sk.EdgeLoad("right", (-0.01, 0.0, 0.0))])
    motion = sk.simulate(system, t_end=0.02, record={"tip": lambda state: state.displacement((1.0, 0.1)), "T": energy})
    return {
        "static": sk.solve(system),
        "path": sk.trace(system, until=1.0),
        "modes": sk.modes(system, 3),
        "buckling": sk.buckling(pushed.on(system.mesh), 2),
        "motion": motion,
        "ledger": motion.ledger,
        "spectrum": sk.spectrum(np.linspace(0, 1, 64), np.sin(np.linspace(0, 60, 64))),
        "adaptive": sk.adapt(strip, sk.Displacement((1.0, 0.1), (0, 0, 1)), rtol=0.3),
        "estimate": sk.goal_estimate(
            sk.solve(strip.on(sk.meshes.quadtree(sk.meshes.uniform(strip.surface, 2, 1)))).solution,
            sk.Displacement((1.0, 0.1), (0, 0, 1)),
        ),
    }


def energy(state: sk.Solution) -> float:
    return state.kinetic_energy


NAMES = ["static", "path", "modes", "buckling", "motion", "ledger", "spectrum", "adaptive", "estimate"]


@pytest.mark.parametrize("name", NAMES)
def test_a_table_is_the_same_in_pandas_in_a_file_and_in_rows(results, name, tmp_path):
    import pandas as pd

    result = results[name]
    frame = result.to_dataframe()
    assert list(frame.columns) == list(result.columns) and len(frame) == len(next(iter(result.columns.values()))) > 0
    assert frame.attrs["units"] == result.units and set(result.units) == set(result.columns)
    rows = list(result.rows())
    read = pd.read_csv(result.to_csv(tmp_path / f"{name}.csv"), keep_default_na=False)
    titles = [f"{column} [{unit}]" if unit else column for column, unit in result.units.items()]
    assert list(read.columns) == titles
    for column, title in zip(frame.columns, titles, strict=True):
        values = frame[column].to_numpy()
        assert [row[column] for row in rows] == values.tolist() or frame[column].isna().any()
        if values.dtype == float:
            assert np.array_equal(pd.to_numeric(read[title], errors="coerce").to_numpy(), values, equal_nan=True)


def test_values_are_those_of_the_results(results):
    static, path, motion = results["static"], results["path"], results["motion"]
    tip = np.linalg.norm(static.solution.displacements, axis=0).max()
    assert static.columns["largest_displacement"][-1] == tip > 0.01
    assert np.array_equal(path.columns["load_factor"], path.load_factors)
    assert np.array_equal(results["modes"].columns["frequency"], results["modes"].frequencies)
    assert np.array_equal(results["adaptive"].columns["value"], [level.value for level in results["adaptive"].levels])
    assert np.array_equal(motion.columns["kinetic"], motion.output_ledger().kinetic)
    records = motion.record_table.columns
    assert list(records) == ["time", "tip_x", "tip_y", "tip_z", "T"]
    assert np.array_equal(records["tip_z"], motion.records["tip"][1][:, 2])
    assert np.array_equal(motion.step_table.columns["accepted"], [step.accepted for step in motion.steps])
    attempts = static.attempt_table
    assert attempts.columns["iterations"].sum() == static.iterations and attempts.columns["status"][-1] == "converged"
    assert len(path.attempt_table.columns["residual"]) == len(path.attempts)
    assert results["ledger"].table().keys() == results["ledger"].columns.keys()


def test_events_of_a_path_are_a_table_even_when_there_are_none(results):
    assert results["path"].event_table.columns["kind"].size == len(results["path"].events) == 0
    assert list(results["path"].event_table.to_dataframe().columns) == ["kind", "load_factor", "refined"]


def test_a_motion_without_records_says_so(strip):
    motion = sk.simulate(strip.on(sk.meshes.uniform(strip.surface, 1, 1)), t_end=1e-4)
    with pytest.raises(sk.InputError, match="record_table: this motion has no records; ask simulate"):
        _ = motion.record_table


def test_columns_are_checked_and_numbers_are_whole(tmp_path):
    table = Columns({"s": [0.1, 1 / 3], "name": ["a", "b,c"]}, {"s": "m"})
    with open(table.to_csv(tmp_path / "table.csv"), newline="") as stream:
        head, *rows = csv.reader(stream)
    assert head == ["s [m]", "name"] and [float(row[0]) for row in rows] == [0.1, 1 / 3] and rows[1][1] == "b,c"
    assert repr(table) == "Columns(2 rows: s [m], name)"
    with pytest.raises(sk.InputError, match=r"units\['u'\] = 'm': give texts for columns among \['s'\]"):
        Columns({"s": [1.0]}, {"u": "m"})
    with pytest.raises(sk.InputError, match="each a list of the same length"):
        Columns({"s": [1.0], "t": [1.0, 2.0]})
    with pytest.raises(sk.InputError, match="columns = 3: give names and values"):
        Columns(3)


def test_without_pandas_the_message_says_how_to_install_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(sk.SkancfError, match=r"to_dataframe needs pandas: pip install 'skancf\[tables\]'"):
        Columns({"s": [1.0]}).to_dataframe()


def test_a_table_prints_its_first_rows_with_units():
    long = Columns({"n": np.arange(14), "w": np.linspace(0.0, 1.0, 14)}, {"w": "m"})
    lines = str(long).splitlines()
    assert lines[0].split() == ["n", "w", "(m)"] and lines[2].split() == ["1", "0.076923"]
    assert len(lines) == 12 and lines[-1] == "... and 4 more rows"
    assert str(Columns({"n": [3]}, {})).splitlines() == ["n", "3"]
