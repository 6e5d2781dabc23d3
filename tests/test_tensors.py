"""Principal stresses and equivalents of known tensors."""

import numpy as np
import pytest

import skancf as sk
from skancf.tensors import cauchy, components, tensors, turned
from skancf.vectors import rotation

out = sk.output
KNOWN = [
    ((3.0, 1.0, 2.0, 0.0, 0.0, 0.0), (3.0, 2.0, 1.0)),
    ((0.0, 0.0, 0.0, 0.0, 0.0, 5.0), (5.0, 0.0, -5.0)),
    ((7.0, 7.0, 7.0, 0.0, 0.0, 0.0), (7.0, 7.0, 7.0)),
    ((4.0, 4.0, 0.0, 0.0, 0.0, 0.0), (4.0, 4.0, 0.0)),
    ((-4.0, -4.0, 0.0, 0.0, 0.0, 0.0), (0.0, -4.0, -4.0)),
    ((0.0, 0.0, 0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0)),
    ((50.0, -10.0, 0.0, 0.0, 0.0, 40.0), (70.0, 0.0, -30.0)),
]  # fmt: skip
ROUNDING = 1e-13


@pytest.mark.parametrize(("stress", "principal"), KNOWN)
def test_principal_stresses_of_known_tensors(stress, principal):
    found = out.principal_stresses(np.array(stress))
    assert np.abs(found - principal).max() <= ROUNDING * max(1.0, np.abs(stress).max())
    rows = out.principal_directions(np.array(stress))
    assert np.abs(rows @ rows.T - np.eye(3)).max() < ROUNDING
    assert np.abs(rows.T @ np.diag(principal) @ rows - tensors(np.array(stress))).max() <= 10 * ROUNDING * 70


def test_values_do_not_depend_on_the_frame_and_follow_a_turn():
    rng = np.random.default_rng(3)
    stress = np.array([stress for stress, _ in KNOWN])[:, None] + np.zeros((1, 4, 1))
    R = np.array([rotation(v) for v in rng.normal(size=(4, 3))])
    moved = turned(stress, R)
    for value in (out.principal_stresses, out.von_mises, out.tresca):
        assert np.abs(value(moved) - value(stress)).max() < 1e-12 * 70
    assert np.abs(moved - stress).max() > 1.0
    assert np.array_equal(components(tensors(stress)), stress)
    one = np.array([50.0, -10.0, 0.0, 0.0, 0.0, 40.0])
    first = out.principal_directions(turned(one, R[0]))[0]
    assert abs(abs(first @ R[0] @ out.principal_directions(one)[0]) - 1) < ROUNDING


def test_plane_stress_is_exact():
    s = np.array([1e6, 1e6, 0.0, 0.0, 0.0, 1e-3])
    assert out.principal_stresses(s).tolist() == [1e6 + 1e-3, 1e6 - 1e-3, 0.0]
    assert out.principal_stresses(np.array([1e6, 0.3, 0.0, 0.0, 0.0, 1e3]))[2] < 0.0


def test_equivalents():
    pulled, sheared = np.array([9.0, 0, 0, 0, 0, 0]), np.array([0, 0, 0, 0, 0, 2.0])
    assert out.von_mises(pulled) == out.tresca(pulled) == out.signed_von_mises(pulled) == -out.signed_von_mises(-pulled) == 9
    assert out.von_mises(sheared) == pytest.approx(2 * np.sqrt(3)) and out.tresca(sheared) == 4.0
    missing = np.array([np.nan] * 6)
    assert np.isnan(out.principal_stresses(missing)).all() and np.isnan(out.principal_directions(missing)).all()
    with pytest.raises(sk.InputError, match=r"stress of shape \(3,\): give components"):
        out.von_mises(np.zeros(3))


def test_cauchy_of_a_stretch():
    stretch = np.array([1.5, 0.8, 0.9])
    strain = np.concatenate([(stretch**2 - 1) / 2, np.zeros(3)])
    stress = cauchy(np.array([2.0, 3.0, 0.0, 0.0, 0.0, 0.0]), strain)
    assert np.allclose(stress[:3], np.array([2.0, 3.0, 0.0]) * stretch**2 / stretch.prod(), rtol=1e-14)
