"""Units that tables and labels show, against conversions that are known."""

import numpy as np
import pytest

import skancf as sk
from skancf.output.fields import readable_unit


@pytest.mark.parametrize(
    ("unit", "factor", "name"),
    [("m", 1e3, "mm"), ("N", 1e-3, "kN"), ("Pa", 1e-6, "MPa"), ("N/m", 1e-6, "kN/mm"), ("N m", 1.0, "kN mm"),
     ("rad", 1.0, "rad"), ("s", 1.0, "s"), ("m/s", 1e3, "mm/s"), ("1/s2", 1.0, "1/s2"), ("", 1.0, ""), ("Hz", 1.0, "Hz"),
     ("J", 1.0, "J")],
)  # fmt: skip
def test_si_in_mm_and_kn(unit, factor, name):
    found = sk.Units(length="mm", force="kN", stress="MPa").of(unit)
    assert found == (pytest.approx(factor, rel=1e-14), name)


def test_a_problem_in_newtons_and_millimetres_keeps_its_numbers():
    units = sk.Units(stated=("mm", "N", "s"))
    assert [units.of(unit) for unit in ("m", "N", "Pa", "N/m", "J")] == [
        (1.0, "mm"), (1.0, "N"), (1.0, "MPa"), (1.0, "N/mm"), (1.0, "mJ")
    ]  # fmt: skip
    assert sk.Units(length="m", stress="GPa", stated=("mm", "N", "s")).of("Pa") == (pytest.approx(1e-3), "GPa")
    assert sk.Units(stated=("in", "lbf", "s")).of("Pa") == (1.0, "psi")
    assert sk.Units(stated=("m", "kN", "ms")).of("Hz") == (pytest.approx(1e3), "Hz")
    assert sk.Units(stated=("cm", "N", "s")).of("Pa") == (1.0, "N/cm2")


def test_the_same_strip_in_two_systems_of_units_shows_the_same_table():
    """Stated in m and N, and in mm and N (with densities in tonnes per mm3): shown alike."""

    def values(scale, young, force, stated):
        strip = sk.Rectangle(scale, 0.25 * scale)
        load = sk.EdgeLoad("right", (0, 0, force))
        problem = sk.Problem(strip, 0.01 * scale, sk.Isotropic(young, 0.3, 1.0), [sk.Clamp("left")], [load])
        state = sk.solve_linear(problem.on(sk.meshes.uniform(strip, 4, 1)))
        line = state.along((0.1 * scale, 0.1 * scale), (0.9 * scale, 0.1 * scale), n=4)
        return sk.Units(length="cm", force="kN", stress="kPa", stated=stated).table(line)

    one, two = values(1.0, 2e11, 40.0, ("m", "N", "s")), values(1e3, 2e5, 0.04, ("mm", "N", "s"))
    assert one.units == two.units and one.units["M11"] == "kN" and one.units["S11_top"] == "kPa"
    for name in one.columns:
        if name not in ("x", "y"):
            size = np.abs(one.columns[name]).max()
            assert np.allclose(one.columns[name], two.columns[name], rtol=1e-7, atol=1e-7 * size + 1e-12), name
    assert np.abs(one.columns["u3"]).max() > 0


def test_labels_and_mistakes():
    assert readable_unit("mises", 3e7) == (1e-6, "MPa") and readable_unit("u3", 1.0) == (1.0, "m")
    assert readable_unit("mises", 3e7, sk.Units(stress="kPa")) == (1e-3, "kPa")
    assert readable_unit("S11", 250.0, sk.Units(stated=("mm", "N", "s"))) == (pytest.approx(1.0), "MPa")
    assert readable_unit("u3", 1.0, sk.Units(length="mm")) == (1e3, "mm")
    with pytest.raises(sk.InputError, match="length = 'meter': is no unit of length that is known; there are m, mm"):
        sk.Units(length="meter")
    with pytest.raises(sk.InputError, match="stated = 'mm': give units of length, force and time"):
        sk.Units(stated="mm")
    with pytest.raises(sk.InputError, match="table = 3: give a result that is a table"):
        sk.Units().table(3)
