"""Frequencies of histories: sines that are known, a plate that is let go, and what is refused."""

import numpy as np
import pytest
from PIL import Image

import skancf as sk
from skancf import output
from skancf.dynamics.spectrum import LOBES, Match
from skancf.output.spectrum_chart import _outline

LENGTH = 10.0
TIMES = np.arange(1000) * LENGTH / 1000
FREQUENCIES, AMPLITUDES = np.array([1.234, 5.678, 17.77]), np.array([3.0, 0.5, 0.08])
UNEVEN = np.cumsum(np.random.default_rng(4).uniform(0.2, 1.0, 2000)) / 120


def sines(t, frequencies=FREQUENCIES, amplitudes=AMPLITUDES):
    phases = np.arange(len(frequencies))
    return (amplitudes * np.sin(2 * np.pi * np.outer(t, frequencies) + phases)).sum(axis=1)


@pytest.mark.parametrize(
    # Errors in units of 1 / length, and of amplitudes: those of Hann's window fall with the cube of the distance between
    # peaks, those of no window with the distance; a top that is flat has no clear maximum.
    ("window", "bins", "relative"),
    [("hann", 1e-3, 1e-3), ("blackman", 1e-3, 1e-3), ("blackmanharris", 1e-3, 1e-4), ("flattop", 0.5, 1e-3),
     ("hamming", 0.1, 0.05), ("boxcar", 0.2, 0.2)],
)  # fmt: skip
def test_sines_are_found_with_their_amplitudes(window, bins, relative):
    spectrum = sk.spectrum(TIMES, sines(TIMES), window=window)
    found, amplitudes = spectrum.peaks(3)
    assert found == pytest.approx(FREQUENCIES, abs=bins / LENGTH)
    assert amplitudes == pytest.approx(AMPLITUDES, rel=relative)
    assert spectrum.resolution == pytest.approx(LOBES[window] / LENGTH) and spectrum.nyquist == pytest.approx(50)
    if window not in ("boxcar", "hamming"):
        assert len(spectrum.peaks()[0]) == 3, "no side lobe is taken for a peak"


@pytest.mark.parametrize("frequency", np.random.default_rng(1).uniform(1.0, 40.0, 10))
def test_one_sine_is_found_to_a_ten_thousandth_of_a_bin(frequency):
    (found,), (amplitude,) = sk.spectrum(TIMES, sines(TIMES, [frequency], [2.0])).peaks()
    assert found == pytest.approx(frequency, abs=1e-4 / LENGTH) and amplitude == pytest.approx(2.0, rel=1e-4)


def test_uneven_times():
    """The longest interval is 1/120 s: six samples per period of 20 Hz at least, where a cubic spline loses 2e-3."""
    spectrum = sk.spectrum(UNEVEN, sines(UNEVEN))
    found, amplitudes = spectrum.peaks()
    length = np.ptp(UNEVEN)
    assert found == pytest.approx(FREQUENCIES, abs=1e-3 / length) and amplitudes == pytest.approx(AMPLITUDES, rel=5e-3)
    assert spectrum.nyquist == pytest.approx(60, rel=1e-2) and spectrum.frequencies[-1] <= spectrum.nyquist
    # A tiny first step does not make a million samples.
    early = np.insert(UNEVEN, 1, UNEVEN[0] + 1e-9)
    assert sk.spectrum(early, sines(early)).peaks(3)[0] == pytest.approx(FREQUENCIES, abs=1e-3 / length)


def test_no_frequency_above_that_of_the_samples():
    """45 Hz at 50 samples per second look like 5 Hz; the content of a stretch with short steps above it is left out."""
    spectrum = sk.spectrum(TIMES[::2], sines(TIMES[::2], [45.0], [1.0]))
    assert spectrum.peaks()[0] == pytest.approx([5.0], abs=1e-3) and spectrum.nyquist == pytest.approx(25.0)
    mixed = np.concatenate([TIMES[:500], TIMES[500::10]])
    spectrum = sk.spectrum(mixed, sines(mixed, [2.0, 20.0], [1.0, 1.0]))
    assert spectrum.nyquist == pytest.approx(5.0) and spectrum.peaks(1)[0] == pytest.approx([2.0], abs=1e-3)
    assert (spectrum.peaks()[0] < 5.0).all()


def test_a_drift_is_removed():
    """Of five periods, which a plain straight line would tilt by a third of their amplitude."""
    five = sines(TIMES, [0.5], [1.0])
    plain, drifting = (sk.spectrum(TIMES, x, detrend="linear") for x in (five, five + 100 * TIMES - 7))
    assert np.allclose(drifting.amplitudes, plain.amplitudes, rtol=0, atol=1e-10)
    assert drifting.peaks()[0] == pytest.approx([0.5], abs=1e-3 / LENGTH)
    assert sk.spectrum(TIMES, five + 100 * TIMES).peaks(1)[0] < 0.2, "the drift hides it"
    mean = sk.spectrum(TIMES, five + 7.0, detrend=None, window="boxcar")
    assert mean.amplitudes[0] == pytest.approx(7.0, rel=1e-6)


def test_several_columns_and_a_part():
    turning = np.stack([np.cos(2 * np.pi * 3 * TIMES), 2 * np.sin(2 * np.pi * 3 * TIMES), 0 * TIMES], axis=1)
    spectrum = sk.spectrum(TIMES, turning, begin=2.0, end=7.0)
    assert spectrum.amplitudes.shape == (len(spectrum.frequencies), 3) and not spectrum.amplitudes[:, 2].any()
    assert spectrum.peaks()[1] == pytest.approx([np.sqrt(5)], rel=1e-3)
    assert spectrum.resolution == pytest.approx(2 / 5, rel=5e-3)


def test_peaks_by_number_and_prominence():
    spectrum = sk.spectrum(TIMES, sines(TIMES))
    assert spectrum.peaks(2.0)[0] == pytest.approx(FREQUENCIES[:2], abs=1e-3)
    assert len(spectrum.peaks(prominence=0.1)[0]) == 2 and len(spectrum.peaks(prominence=0.02)[0]) == 3
    assert len(sk.spectrum(TIMES, 0 * TIMES + 3.0).peaks()[0]) == 0, "rest has no peaks of rounding"


def test_what_is_compared():
    spectrum = sk.spectrum(TIMES, sines(TIMES))
    first, second, third = spectrum.compare([-3.0, 0.0, 1.25, 5.6, 5.7, 20.0])
    assert (first.nearest, first.modes, first.resolved) == (2, (2,), True)
    assert first.difference == pytest.approx(1.234 / 1.25 - 1, abs=1e-4) and str(first).endswith("-1.28%")
    assert (second.nearest, second.modes, second.found, second.resolved) == (4, (3, 4), True, False)
    assert "modes (3, 4) not resolved" in str(second)
    assert (third.nearest, third.modes, third.found) == (5, (), False) and "not within the resolution" in str(third)
    assert spectrum.compare([1.25], count=1) == (Match(first.frequency, first.amplitude, 0, 1.25, (0,), 1.25),)
    # What the number of modes that were asked for decides is said, and nothing else is.
    assert [match.highest for match in (first, second, third)] == [None, None, None]
    near, above = spectrum.compare([1.25, 5.6])[1:]
    assert near.resolved and near.highest == above.highest == 5.6 and not above.found
    assert all(str(match).endswith("none above 5.6 Hz is given: ask for more modes") for match in (near, above))


# A plate


YOUNG, POISSON, DENSITY, THICKNESS = 1e6, 0.3, 1000.0, 0.002
NAVIER = np.pi / 2 * np.array([2, 5, 8]) * np.sqrt(YOUNG * THICKNESS**2 / (12 * (1 - POISSON**2) * DENSITY))
CORNER = (1 / 3, 1 / 6)
PERIODS, STEPS = 20, 60


def plate(thickness=THICKNESS, loads=()):
    problem = sk.Problem(sk.Rectangle(1.0, 1.0), thickness, sk.Isotropic(YOUNG, POISSON, DENSITY),
                         [sk.SimpleSupport("boundary", "hard")], loads)  # fmt: skip
    return problem.on(sk.meshes.uniform(problem.surface, 6, 6), "kirchhoff")


@pytest.fixture(scope="module")
def let_go():
    """History of a plate that a force off its middle bent by a hundredth of its thickness."""
    loaded, free = plate(loads=[sk.PointForce(CORNER, (0, 0, 1e-9))]), plate()
    bent = sk.solve_linear(loaded)
    size = 0.01 * THICKNESS / bent.displacement(CORNER)[2]
    start = sk.Solution(free, free.undeformed + size * (bent.q - loaded.undeformed))
    motion = sk.simulate(
        free, PERIODS / NAVIER[0], dt=1 / (STEPS * NAVIER[0]), rho_inf=1.0, start=start, outputs=2, newton_rtol=1e-8,
        record={"w": lambda state: state.displacement(CORNER)[2]}, progress=False,
    )  # fmt: skip
    return motion.unwrap().records["w"]


def test_a_plate_sounds_its_natural_frequencies(let_go):
    spectrum = sk.spectrum(*let_go)
    found, amplitudes = spectrum.peaks(3)
    # The rule lowers omega by (omega dt)^2 / 12, by 1.5 % in the third, and by (omega dt)^4 / 80 less: 4e-4. The mesh of six
    # elements raises it by up to 5.3e-4, and the peak is good to a hundredth of 1 / length.
    period_error = (2 * np.pi * NAVIER / (STEPS * NAVIER[0])) ** 2 / 12
    tolerance = 1e-3 + 0.01 * NAVIER[0] / (PERIODS * NAVIER)
    assert (np.abs(found / NAVIER - 1 + period_error) < tolerance).all()
    assert period_error[2] > 10 * tolerance[2], "the period error is seen"
    assert (np.diff(amplitudes) < 0).all() and amplitudes.sum() < 0.01 * THICKNESS


def test_a_plate_and_its_modes(let_go, tmp_path):
    spectrum, modes = sk.spectrum(*let_go), sk.modes(plate(), 6)
    first, second, third = spectrum.compare(modes, count=3)
    assert first.resolved and third.resolved and (first.nearest, third.nearest) == (0, 3)
    assert second.modes == (1, 2), "the equal pair is not told apart"
    assert max(abs(match.difference) for match in (first, second, third)) < 0.02
    # The same plate 1.2 times as thick is another plate.
    other = spectrum.compare(sk.modes(plate(1.2 * THICKNESS), 6), count=3)
    assert not any(match.found for match in other) and all(match.difference < -0.1 for match in other)
    chart = output.spectrum_chart(spectrum, tmp_path / "plate.png", modes, ylabel="amplitude of u3 (m)")
    assert np.asarray(Image.open(chart).convert("L")).std() > 5


# Charts


def test_charts_are_drawn(tmp_path):
    spectra = {"all": sk.spectrum(TIMES, sines(TIMES)), "half": sk.spectrum(TIMES, sines(TIMES), end=5.0)}
    made = [
        output.spectrum_chart(spectra, tmp_path / "two.png", [1.2, 1.3, 5.6, 70.0], title="sines"),
        output.spectrum_chart(spectra["all"], tmp_path / "part.pdf", [70.0], limit=3.0),
        output.spectrum_chart({"noise": sk.spectrum(TIMES[:9], TIMES[:9] ** 2)}, tmp_path / "few.svg"),
    ]
    assert all(path.stat().st_size > 2000 for path in made)


def test_the_line_shows_peaks_and_no_side_lobes():
    spectrum = sk.spectrum(TIMES, sines(TIMES, [5.05], [1.0]))
    frequencies, amplitudes = _outline(spectrum, spectrum.peaks()[0])
    turns = 1 + np.flatnonzero((np.diff(np.sign(np.diff(amplitudes))) < 0) & (amplitudes[1:-1] > 1e-4))
    assert frequencies[turns] == pytest.approx([5.05], abs=0.02) and amplitudes.max() == pytest.approx(1.0, rel=1e-2)
    assert np.sort(spectrum.total[np.abs(spectrum.frequencies - 5.05) > 0.2])[-1] > 0.02, "there are side lobes to leave out"


# What is refused


def test_bad_input_is_refused(tmp_path):
    x, spectrum, path = sines(TIMES), sk.spectrum(TIMES, sines(TIMES)), tmp_path / "a.png"
    backwards, twice, hole = TIMES.copy(), TIMES.copy(), x.copy()
    backwards[5], twice[7], hole[3] = 0.0, TIMES[6], np.nan
    calls = {
        r"times\[5\] = 0.0 s after 0.04 s: times must ascend": lambda: sk.spectrum(backwards, x),
        r"times\[7\] = 0.06 s after 0.06 s": lambda: sk.spectrum(twice, x),
        r"values\[3\].*not finite": lambda: sk.spectrum(TIMES, hole),
        r"times\[0\].*not finite": lambda: sk.spectrum(TIMES - np.inf, x),
        "7 samples to use; a spectrum needs 8": lambda: sk.spectrum(TIMES[:7], x[:7]),
        "3 samples to use": lambda: sk.spectrum(TIMES, x, begin=0.1, end=0.125),
        "begin = 0.3 s, end = 0.1 s: give the earlier": lambda: sk.spectrum(TIMES, x, begin=0.3, end=0.1),
        r"shape \(999,\) at times of shape \(1000,\)": lambda: sk.spectrum(TIMES, x[1:]),
        r"shape \(1000, 1, 1\)": lambda: sk.spectrum(TIMES, x[:, None, None]),
        r"shape \(1000, 0\)": lambda: sk.spectrum(TIMES, np.zeros((1000, 0))),
        r"shape \(\)": lambda: sk.spectrum(TIMES, 1.0),
        r"begin = -1 s: the history is known from 0.0 to 9.99 s": lambda: sk.spectrum(TIMES, x, begin=-1),
        r"end = 11 s: the history": lambda: sk.spectrum(TIMES, x, end=11),
        "begin = nan": lambda: sk.spectrum(TIMES, x, begin=np.nan),
        "window = 'hanning': give one of boxcar, hann": lambda: sk.spectrum(TIMES, x, window="hanning"),
        "detrend = 'cubic'": lambda: sk.spectrum(TIMES, x, detrend="cubic"),
        "padding = 1.5": lambda: sk.spectrum(TIMES, x, padding=1.5),
        "padding = 0": lambda: sk.spectrum(TIMES, x, padding=0),
        "count = 0": lambda: spectrum.peaks(0),
        "count = 1.5": lambda: spectrum.peaks(1.5),
        r"prominence = 1\.0:": lambda: spectrum.peaks(prominence=1),
        "natural frequencies = .*above zero": lambda: spectrum.compare([0.0, -1.0]),
        r"natural frequencies = \[\]": lambda: spectrum.compare([]),
        "natural frequencies.*not finite": lambda: spectrum.compare([np.nan]),
        "spectra: the sequence is empty": lambda: output.spectrum_chart({}, path),
        "all amplitudes are zero": lambda: output.spectrum_chart(sk.spectrum(TIMES, 0 * x), path),
        "limit = -1": lambda: output.spectrum_chart(spectrum, path, limit=-1),
        "end it in .png": lambda: output.spectrum_chart(spectrum, path.with_suffix(".jpg")),
    }
    for message, call in calls.items():
        with pytest.raises(sk.InputError, match=f"(?s){message}"):
            call()
    assert not list(tmp_path.iterdir())
