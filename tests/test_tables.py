"""Loads and functions of time from tables: DataFrames, files, mappings and structured arrays."""

import pickle

import numpy as np
import pandas as pd
import pytest

import skancf as sk
from skancf.errors import InputError

SQUARE = sk.Rectangle(1.0, 1.0)
STEEL = sk.Isotropic(210e9, 0.3, 7800.0)
ROWS = {"x": [0.25, 0.5, 0.75], "y": [0.5, 0.5, 0.25], "fz": [-1.0, 0.0, 2.5], "mx": [0.0, 3.0, 4.0]}


class Own:
    """Any object with columns and brackets."""

    columns = tuple(ROWS)

    def __getitem__(self, name):
        return tuple(ROWS[name])


def structured():
    out = np.zeros(3, dtype=[(name, float) for name in ROWS])
    for name, column in ROWS.items():
        out[name] = column
    return out


def written(path, separator=","):
    pd.DataFrame(ROWS).to_csv(path, index=False, sep=separator)
    return path


TABLES = {
    "DataFrame": lambda folder: pd.DataFrame(ROWS, index=[7, 8, 9]),
    "mapping": lambda folder: ROWS,
    "structured array": lambda folder: structured(),
    "own": lambda folder: Own(),
    "csv": lambda folder: written(folder / "a.csv"),
    "semicolons": lambda folder: str(written(folder / "a.csv", ";")),
    "Tabular": lambda folder: sk.output.Columns(ROWS, {"x": "m", "y": "m", "fz": "N"}),
    "save_table": lambda folder: sk.output.save_table(folder / "b.csv", ROWS),
}


@pytest.mark.parametrize("kind", TABLES)
def test_point_forces_are_the_rows_of_a_table(tmp_path, kind):
    pulse = sk.Pulse(1.0)
    loads = sk.loads.point_forces(TABLES[kind](tmp_path), history=pulse)
    assert loads == [
        sk.PointForce((0.25, 0.5), (0.0, 0.0, -1.0), pulse), sk.PointMoment((0.5, 0.5), (3.0, 0.0, 0.0), pulse),
        sk.PointForce((0.75, 0.25), (0.0, 0.0, 2.5), pulse), sk.PointMoment((0.75, 0.25), (4.0, 0.0, 0.0), pulse),
    ]  # fmt: skip


def test_a_problem_takes_them():
    problem = sk.Problem(
        SQUARE, 0.02, STEEL, [sk.Clamp("left")], sk.loads.point_forces({"x": [0.5], "y": [0.5], "fz": [-8.0]})
    )
    solution = sk.solve_linear(problem.on(sk.meshes.uniform(SQUARE, 2, 2)))
    assert solution.reactions() == pytest.approx([0.0, 0.0, 8.0], abs=1e-6)


def test_titles_and_units():
    table = pd.DataFrame(
        {"Position X [mm]": [10.0], "y (mm)": [20.0], "Load (N)": [5.0], "my (N mm)": [2.0], "label": ["a"]}
    )
    loads = sk.loads.point_forces(table, titles={"x": "Position X", "fz": "Load (N)"})
    assert loads == [sk.PointForce((10.0, 20.0), (0.0, 0.0, 5.0)), sk.PointMoment((10.0, 20.0), (0.0, 2.0, 0.0))]
    for wrong in ({"x (m)": [1.0], "y (m)": [1.0], "fx (kN)": [1.0]}, {"x (mm)": [1], "y (m)": [1], "fx": [1]},
                  {"x (m)": [1.0], "y": [1.0], "mx [N mm]": [1.0]}, {"x": [1.0], "y (deg)": [1], "fx": [1.0]}):  # fmt: skip
        with pytest.raises(InputError, match=r"units of '.*' do not belong together; convert"):
            sk.loads.point_forces(wrong)
    with pytest.raises(InputError, match=r"units .*p \(Pa\)"):
        sk.loads.sampled({"x (mm)": [0, 1, 0], "y (mm)": [0, 0, 1], "p (Pa)": [1, 2, 3]}, "p")


WRONG = {
    "no x": ({"y": [1.0], "fx": [1.0]}, r"table: has no column 'x'; its columns are 'y', 'fx'"),
    "no force": ({"x": [1.0], "y": [1.0], "f_z": [1.0]}, r"none of the columns fx, fy, fz.*titles="),
    "text": (
        {"x": [1.0, 2.0], "y": [1.0, 1.0], "fx": [1.0, "abc"]},
        r"table: column 'fx', row 1: 'abc' is no finite number",
    ),
    "missing": ({"x": [1.0, 2.0], "y": [None, 1.0], "fx": [1.0, 2.0]}, r"column 'y', row 0: None"),
    "nan": (pd.DataFrame({"x": [1.0, np.nan], "y": [1.0, 1.0], "fx": [1.0, 2.0]}), r"column 'x', row 1: nan"),
    "truth": ({"x": [True], "y": [1.0], "fx": [1.0]}, r"column 'x', row 0: True"),
    "lengths": ({"x": [1.0], "y": [1.0, 2.0], "fx": [1.0, 2.0]}, r"lengths {'x': 1, 'y': 2, 'fx': 2}"),
    "twice": ({"x (m)": [1.0], "x": [1.0], "y": [1.0], "fx": [1.0]}, r"'x \(m\)', 'x' are all 'x'"),
    "square": ({"x": [[1.0]], "y": [1.0], "fx": [1.0]}, r"column 'x' has the shape \(1, 1\)"),
    "list": ([1.0, 2.0], "give a DataFrame"),
    "file": ("table.txt", r"ends in '.txt'"),
    "no file": ("nowhere.csv", "cannot be read"),
}


@pytest.mark.parametrize("kind", WRONG)
def test_what_is_wrong_with_a_table_is_named_by_column_and_row(kind):
    table, word = WRONG[kind]
    with pytest.raises(InputError, match=word):
        sk.loads.point_forces(table)


def test_what_is_wrong_with_a_file_is_named(tmp_path):
    file = tmp_path / "a.csv"
    for content, word in (
        ("", "is empty"),
        ("x,y,fx\n1,2\n", "row 0 has 2 entries"),
        ("x,y,fx\n1,2,3\n1,,3\n", "'y', row 1: ''"),
    ):
        file.write_text(content)
        with pytest.raises(InputError, match=word):
            sk.loads.point_forces(file)
    with pytest.raises(InputError, match=r"titles: 'fw' is not asked for"):
        sk.loads.point_forces(ROWS, titles={"fw": "x"})


# -------------------------------------------------------------------------------------------------- functions of time


def test_histories_from_tables(tmp_path):
    expected = sk.Table([0.0, 1.0, 2.0], [0.0, 1.0, 0.5])
    frame = pd.DataFrame({"time (s)": [0.0, 1.0, 2.0], "factor": [0.0, 1.0, 0.5]})
    frame.to_csv(tmp_path / "gust.csv", index=False)
    series = pd.Series([0.0, 1.0, 0.5], index=[0.0, 1.0, 2.0])
    for table in (frame, tmp_path / "gust.csv", series):
        assert sk.Table.of(table) == expected
    other = frame.rename(columns={"time (s)": "t", "factor": "gust"})
    assert sk.Table.of(other, "t", "gust", kind="smooth") == sk.Table(expected.times, expected.values, "smooth")
    with pytest.raises(InputError, match=r"no column 'time'; its columns are 't', 'gust'"):
        sk.Table.of(other)
    with pytest.raises(InputError, match="times must ascend"):
        sk.Table.of(series[::-1])
    with pytest.raises(InputError, match=r"column 'factor', row 2: nan"):
        sk.Table.of(series.where(series != 0.5))


# --------------------------------------------------------------------------------------------------- fields of samples


def test_samples_on_a_grid_are_interpolated_bilinearly(rng):
    x, y = np.meshgrid([0.0, 0.3, 1.0], [0.0, 0.6, 1.0])
    order = rng.permutation(9)
    table = pd.DataFrame({"x": x.ravel()[order], "y": y.ravel()[order]})
    table["p"] = 1 + table.x - 2 * table.y + 3 * table.x * table.y
    p = sk.loads.sampled(table, "p")
    at = rng.random((2, 4, 5))
    assert np.allclose(p(*at), 1 + at[0] - 2 * at[1] + 3 * at[0] * at[1])
    assert p(0.0, 1.0) == pytest.approx(-1.0) and p(1.0 + 1e-13, 0.5) == pytest.approx(2.5)


def test_scattered_samples_are_interpolated_linearly(rng):
    x, y = np.concatenate([rng.random((2, 40)), [[0, 1, 1, 0], [0, 0, 1, 1]]], axis=1)
    force = sk.loads.sampled({"x": x, "y": y, "px": x, "py": -y, "pz": 2 * x + y}, ("px", "py", "pz"))
    at = rng.random((2, 50))
    assert force(*at).shape == (3, 50) and np.allclose(force(*at), [at[0], -at[1], 2 * at[0] + at[1]])
    assert "values" not in repr(force) and len(repr(force)) < 200
    again = pickle.loads(pickle.dumps(force))
    assert again == force and np.array_equal(again(*at), force(*at))


def test_a_pressure_map_is_a_load():
    x, y = (each.ravel() for each in np.meshgrid([0.0, 1.0], [0.0, 1.0]))
    table = {"x": x, "y": y, "p": 100 * x, "fz": -50 * x}
    mesh = sk.meshes.uniform(SQUARE, 2, 2)

    def resultant(load):
        return sk.solve_linear(sk.Problem(SQUARE, 0.02, STEEL, [sk.Clamp("left")], [load]).on(mesh)).reactions()[2]

    assert resultant(sk.FollowerPressure(sk.loads.sampled(table, "p"))) == pytest.approx(-50.0)
    p = sk.loads.sampled(table, "fz")
    assert resultant(sk.SurfaceLoad(lambda x, y: (0.0, 0.0, p(x, y)))) == pytest.approx(25.0)
    small = sk.loads.sampled({"x": [0, 0.5, 0, 0.5], "y": [0, 0, 1, 1], "p": [1, 2, 3, 4]}, "p")
    with pytest.raises(InputError, match=r"samples: there are none around .*from x = 0 to 0\.5 and y = 0 to 1"):
        resultant(sk.FollowerPressure(small))


@pytest.mark.parametrize(
    ("x", "y", "p", "word"),
    [
        ([0, 1], [0, 1], [1, 1], "2 samples make no field"),
        ([0, 1, 2], [0, 1, 2], [1, 1, 1], "on one line"),
        ([0, 1, 0, 0], [0, 0, 1, 1], [1, 1, 2, 3], r"rows 2 and 3 are both at \(0, 1\)"),
    ],
)
def test_samples_that_are_no_field_are_refused(x, y, p, word):
    with pytest.raises(InputError, match=word):
        sk.loads.sampled({"x": x, "y": y, "p": p}, "p")
    with pytest.raises(InputError, match="no column 'q'"):
        sk.loads.sampled({"x": x, "y": y, "p": p}, "q")
    for wrong in ((), ("p", "p"), ("x", "p", "q"), 3, ("p", "p", "p")):
        with pytest.raises(InputError, match="values = "):
            sk.loads.sampled({"x": x, "y": y, "p": p}, wrong)
