"""Envelopes of known motions, and utilisation against criteria worked out by hand."""

import numpy as np
import pytest

import skancf as sk

STRIP, B, H = sk.Rectangle(1.0, 0.25), 0.25, 0.01
PLAIN = sk.Isotropic(2e9, 0.0, 1e3)


@pytest.fixture(scope="module")
def system():
    problem = sk.Problem(STRIP, H, PLAIN, [sk.Clamp("left")], [sk.EdgeLoad("right", (0, 0, 1.0))])
    return problem.on(sk.meshes.uniform(STRIP, 4, 1))


def moved(system, size, time):
    """The strip lifted as a whole by size."""
    q = system.undeformed.copy().reshape(-1, 4, 3)
    q[:, 0, 2] += size
    return sk.Solution(system, q.ravel(), time=time)


def test_envelope_of_a_known_motion(system):
    times = np.linspace(0.0, 2 * np.pi, 41)
    made = []

    def states():
        for t in times:
            made.append(t)
            yield moved(system, 0.1 * np.sin(t) + 0.02, float(t))

    found = sk.envelope(states(), "u3", at=[(0.5, 0.1), (1.0, 0.0)])
    assert len(made) == 41 == found.n_states and found.over == "time" and found.unit == "m"
    assert np.allclose(found.highest, 0.12) and np.allclose(found.lowest, -0.08)
    assert np.allclose(found.highest_at, np.pi / 2) and np.allclose(found.lowest_at, 1.5 * np.pi)
    assert found.highest_state.tolist() == [10, 10] and np.allclose(found.largest, 0.12)
    governing = found.governing
    assert governing["value"] == pytest.approx(0.12) and governing["state"] == 10
    assert governing["place"] in ((0.5, 0.1), (1.0, 0.0)) and governing["index"] in ((0,), (1,))
    frame = found.to_dataframe()
    assert list(frame.columns) == ["x", "y", "lowest", "lowest_time", "highest", "highest_time"]
    down = sk.envelope([moved(system, -0.3, 0.0), moved(system, 0.1, 1.0)], lambda state: state.displacement((0.5, 0.1)))
    assert down.governing == {"value": pytest.approx(-0.3), "time": 0.0, "state": 0, "index": (2,)}


def test_envelopes_of_results(system):
    result = sk.solve(system)
    found = sk.envelope(result, "mises_top")
    assert found.over == "load_factor" and np.allclose(found.highest_at[found.highest > 1], 1.0)
    assert found.governing["value"] == pytest.approx(6 * 1.0 / H**2, rel=0.01) and found.governing["place"][0] == 0.0
    motion = sk.simulate(system, 0.02, dt=0.005, progress=False)
    tip = sk.envelope(motion, lambda state: state.displacement((1.0, 0.1))[2])
    history = motion.history(lambda state: state.displacement((1.0, 0.1))[2])
    assert tip.highest == history.max() and tip.highest_at == motion.times[history.argmax()]


def test_values_that_are_missing_and_mistakes(system):
    states = [moved(system, size, float(k)) for k, size in enumerate((0.1, 0.3, 0.2))]
    found = sk.envelope(states, lambda state: [np.nan if state.time == 0 else state.time, np.nan])
    assert found.lowest[0] == 1.0 and found.highest[0] == 2.0 and np.isnan(found.highest[1]) and found.highest_state[1] == -1
    with pytest.raises(sk.InputError, match="states: there are none"):
        sk.envelope([], "u3")
    with pytest.raises(sk.InputError, match="quantity = 'u4': is no column; there are x, y, X"):
        sk.envelope(states, "u4")
    with pytest.raises(sk.InputError, match=r"states\[0\] = 3: is no Solution"):
        sk.envelope([3], "u3")
    other = moved(system.problem.on(sk.meshes.uniform(STRIP, 2, 1)), 0.1, 3.0)
    with pytest.raises(sk.InputError, match=r"values of shape \(10,\) and \(6,\), as on meshes that differ; give places"):
        sk.envelope([*states, other], "u3")
    assert sk.envelope([*states, other], "u3", at=(0.3, 0.1)).highest == pytest.approx(0.3)


# --- strength ---------------------------------------------------------------------------------------------------------


def test_criteria_of_a_ply_by_hand():
    ply = sk.Strength((1500.0, 40.0), (1200.0, 246.0), 68.0)
    for stress, used in (((750.0, 0, 0), 0.5), ((-600.0, 0, 0), 0.5), ((0, 20.0, 0), 0.5), ((0, -123.0, 0), 0.5),
                         ((0, 0, -34.0), 0.5)):  # fmt: skip
        for criterion in ("max stress", "tsai-hill", "tsai-wu"):
            assert ply.used(np.array(stress), criterion) == pytest.approx(used, rel=1e-12), criterion
    both = np.array([750.0, 20.0, 34.0])
    assert ply.used(both, "max stress") == pytest.approx(0.5)
    assert ply.used(both, "tsai-hill") == pytest.approx(np.sqrt(0.25 - 750 * 20 / 1500**2 + 0.25 + 0.25))
    r = 1 / ply.used(both)
    F = [1 / 1500 - 1 / 1200, 1 / 40 - 1 / 246, 1 / (1500 * 1200), 1 / (40 * 246), 1 / 68**2]
    s = r * both
    tsai_wu = F[0] * s[0] + F[1] * s[1] + F[2] * s[0] ** 2 + F[3] * s[1] ** 2 + F[4] * s[2] ** 2
    assert tsai_wu - np.sqrt(F[2] * F[3]) * s[0] * s[1] == pytest.approx(1.0)
    assert ply.used(3 * both) == pytest.approx(3 * ply.used(both)) and ply.used(np.zeros(3)) == 0.0


def test_utilisation_of_a_cantilever(system):
    state = sk.solve_linear(system)
    found = sk.utilisation(state, 240e3)
    assert found.governing["value"] == pytest.approx(6 / H**2 / 240e3, rel=1e-3) and found.governing["place"][0] == 0.0
    assert abs(found.governing["z"]) == pytest.approx(H / 2) and found.governing["layer"] == 0
    half = sk.utilisation(state, 240e3, criterion="tresca", at=(0.5, 0.1))
    assert half.values == pytest.approx([3 / H**2 / 240e3], rel=1e-3)


def test_plies_have_their_strength_along_their_fibres():
    """A cross-ply under tension: each ply's stress in its own axes, and the one across the load governs."""
    carbon = sk.Orthotropic((100e9, 10e9, 10e9), (0.0, 0.0, 0.0), (5e9,) * 3, 1600.0)
    layers = [sk.Layer(carbon, 0.001, angle) for angle in (0.0, np.pi / 2, 0.0)]
    problem = sk.Problem(STRIP, None, sk.Laminate(layers), [sk.Clamp("left")], [sk.EdgeLoad("right", (210e3, 0, 0))])
    state = sk.solve_linear(problem.on(sk.meshes.uniform(STRIP, 4, 1)))
    strength = sk.Strength((1500e6, 40e6), (1200e6, 246e6), 68e6)
    found = sk.utilisation(state, strength, criterion="max stress", at=[(0.5, 0.1)])
    strain = 210e3 / (100e9 * 0.002 + 10e9 * 0.001)
    assert found.values == pytest.approx([10e9 * strain / 40e6], rel=1e-3)  # more than 100e9 * strain / 1500e6
    assert found.layer.tolist() == [1] and found.z[0] == pytest.approx(-0.0005, abs=1e-5)
    weak = sk.utilisation(state, [1e6, 1e9, 1e9], at=[(0.5, 0.1)])
    assert weak.layer.tolist() == [0] and weak.values == pytest.approx([100.0], rel=1e-3)
    with pytest.raises(sk.InputError, match="has 2 entries for 3 layers"):
        sk.utilisation(state, [strength, strength])
    with pytest.raises(sk.InputError, match="criterion = 'tresca': choose one of 'tsai-wu'"):
        sk.utilisation(state, strength, criterion="tresca")
