"""The two levels of the force sensor: voltages at MHz steps beside the baseband model and the noise budget."""

from __future__ import annotations

import math

import numpy as np
import pytest
from sensor_waveform import waveform

from frictionloop.hardware.sensor import front_end
from frictionloop.hardware.sensor.noise_budget import noise_budget
from frictionloop.parameters.sensor_design import SensorDesign
from frictionloop.quantities import FrictionloopError

CALM = SensorDesign().evolve({"moving.q": 2.0})
"""A resonance that dies out in the 0.1 s before the response is taken: e^(-23)."""
TONES_HZ = np.array([10.0, 50, 100, 140, 150, 200, 300, 400, 500])


def tones(amplitude_n):
    return lambda t: amplitude_n * np.sum(np.sin(2 * np.pi * TONES_HZ[:, None] * t), axis=0)


def response(design, amplitude_n=0.01):
    """Gain and phase at each tone over 0.1 s, whole periods of all of them."""
    found = waveform(design, tones(amplitude_n), 0.2)
    late = found.time_s >= 0.1
    turning = np.exp(-2j * np.pi * np.outer(TONES_HZ, found.time_s[late]))
    return 2j * (turning @ found.force_n[late]) / late.sum() / amplitude_n


@pytest.mark.parametrize(
    "overrides",
    [
        {},
        {"readout.form": "ratio", "electrodes.imbalance": 0.1},
        {"filters.bandpass_q": 40.0, "filters.cutoff_hz": 300.0},
        {"amplifier.gain_bandwidth_mhz": 5.0, "amplifier.feedback_mohm": 0.1},
    ],
    ids=["default", "ratio, unequal", "narrow filters", "slow amplifier, small Rf"],
)
def test_gain_and_phase(overrides):
    """0.1 % and 0.1 degree to 500 Hz."""
    design = CALM.evolve(overrides)
    ratio = response(design) / front_end.sensor_response(design, TONES_HZ)
    assert np.max(np.abs(np.abs(ratio) - 1)) < 1e-3
    assert np.max(np.abs(np.angle(ratio, deg=True))) < 0.1


def test_the_block_of_the_loop():
    """The same bounds for suspension, one pole and the delay of the band-pass."""
    ratio = response(CALM) / front_end.loop_response(CALM, TONES_HZ)
    assert (
        np.max(np.abs(np.abs(ratio) - 1)) < 1e-3 + 9e-4
    )  # the band-pass itself takes (500/12000)^2/2 = 0.09 % at 500 Hz
    assert np.max(np.abs(np.angle(ratio, deg=True))) < 0.1


@pytest.mark.parametrize("samples", [128, 256])
def test_the_samples_cost_what_they_must(samples):
    """Straight lines between N samples of a sine keep sinc^2(1/N) of it, twice: amplifier and band-pass.

    The images that they add instead, at N - 1 times the carrier, pass the amplifier at a part of order 1/N.
    """
    design = SensorDesign().evolve({"electrodes.imbalance": 0.0})
    found = waveform(design, lambda t: np.full_like(t, 0.01), 1e-3, samples).force_n[-1]
    assert 1 - found / 0.01 == pytest.approx(1 - np.sinc(1 / samples) ** 4, rel=10 / samples)


@pytest.mark.parametrize("form", ["subtraction", "ratio"])
@pytest.mark.parametrize("force", [-2.5, 0.7, 2.5])
def test_steady_forces_read_as_the_static_curve(form, force):
    design = SensorDesign().evolve({"readout.form": form})
    found = waveform(design, lambda t: np.full_like(t, force), 1e-3)
    expected = front_end.readings(design, *front_end.amplitudes_v(design, force)).force_n
    # 0.04 % from the samples, of the force and, in a subtraction, of the imbalance.
    assert found.force_n[-1] == pytest.approx(expected, rel=1e-3)
    assert found.clipped == 0


def test_a_clipped_amplifier_reads_too_little():
    """Clipped at b of its peak, a sine keeps 2/pi (asin b + b sqrt(1 - b^2)) of its fundamental."""
    design = SensorDesign().evolve({"electrodes.imbalance": 0.0, "readout.form": "ratio"})
    peak = front_end.peak_amplifier_v(design, 0.0)
    limited = design.evolve({"amplifier.swing_v": 0.8 * peak})
    found = waveform(limited, lambda t: np.full_like(t, 0.5), 1e-3)

    def fundamental(volts):
        b = min(1.0, 0.8 * peak / volts)
        return volts * 2 / math.pi * (math.asin(b) + b * math.sqrt(1 - b * b))

    volts = [front_end.peak_amplifier_v(design, 0.5), front_end.amplitudes_v(design, 0.5).minus]
    plus, minus = map(fundamental, volts)
    assert found.clipped == pytest.approx(1 - 2 / math.pi * math.asin(0.8), abs=0.02)
    # The difference of two clipped sines is small beside them: 0.1 % of each is 2 % of it.
    assert found.force_n[-1] == pytest.approx(float(front_end.readings(design, plus, minus).force_n), rel=0.02)
    assert found.force_n[-1] < 0.45


def test_same_seed_same_noise():
    quiet = SensorDesign().evolve({})
    one, two, other = (waveform(quiet, np.zeros_like, 1e-3, 16, seed=seed).force_n for seed in (3, 3, 4))
    np.testing.assert_array_equal(one, two)
    assert not np.array_equal(one, other)
    assert np.ptp(waveform(quiet, np.zeros_like, 1e-3, 16).force_n) < 1e-9


def white_rms_n(design, force_n=0.0):
    return math.sqrt(sum(term.rms_n**2 for term in noise_budget(design, force_n).terms if term.white))


NOISE = [
    ({"excitation.amplitude_noise_rthz": 0.0}, 0.0),
    ({"electrodes.imbalance": 0.1}, 0.0),
    ({"readout.form": "ratio", "electrodes.imbalance": 0.1}, 1.5),
    ({"filters.cutoff_hz": 300.0, "amplifier.feedback_mohm": 0.3}, 0.0),
]


def measured_noise(overrides, force_n, duration_s):
    design = SensorDesign().evolve(overrides)
    found = waveform(design, lambda t: np.full_like(t, force_n), duration_s, samples_per_period=32, seed=11)
    # Noise with the correlation e^(-wc |t|) has a variance that is known to sqrt(2/(wc T)), its root to half of that.
    error = math.sqrt(2 / (2 * math.pi * design.filters.cutoff_hz * duration_s)) / 2
    return found.force_n.std() / white_rms_n(design, force_n), error


def test_noise_in_a_short_record():
    """Statistical error 0.9 %: four of them, and the 0.6 % that 32 samples per period cost."""
    ratio, error = measured_noise({}, 0.0, 1.0)
    assert error < 0.0091
    assert ratio == pytest.approx(1.0, abs=4 * error + 0.006)


@pytest.mark.slow
@pytest.mark.parametrize(("overrides", "force_n"), NOISE)
def test_noise_within_three_percent(overrides, force_n):
    """3 %, with a statistical error of 0.45 % (0.7 % for the 300 Hz low-pass, in 6 s)."""
    ratio, error = measured_noise(overrides, force_n, 6.0 if "filters.cutoff_hz" in overrides else 4.0)
    assert error < 0.0068
    assert ratio == pytest.approx(1.0, abs=0.03)


@pytest.mark.slow
def test_each_source_alone_has_its_share():
    """Terms one by one, so that a wrong small one cannot hide behind the largest. 0.4 s: 1.4 % each."""
    silent = {
        "amplifier.noise_nv_rthz": 0.0,
        "amplifier.current_noise_fa_rthz": 0.0,
        "filters.buffer_noise_nv_rthz": 0.0,
        "excitation.amplitude_noise_rthz": 0.0,
        "amplifier.feedback_mohm": 1e4,
        "filters.bandpass_coil_uh": 1e-3,
        "filters.lowpass_nf": 1e6,
    }
    for loud in (
        {"amplifier.noise_nv_rthz": 20.0},
        {"amplifier.feedback_mohm": 0.1},
        {"amplifier.current_noise_fa_rthz": 1e3},
        {"filters.bandpass_coil_uh": 1000.0},
        {"filters.lowpass_nf": 1.0},
        {"excitation.amplitude_noise_rthz": 1e-5},
    ):
        ratio, error = measured_noise(silent | loud, 0.0, 0.4)
        assert ratio == pytest.approx(1.0, abs=4 * error + 0.006), loud


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        ((1e-7,), r"^duration_s = 1e-07 s: must be at least one period"),
        ((math.nan,), r"^duration_s = nan s"),
        ((1e-3, 7), r"^samples_per_period = 7: must be at least 8"),
    ],
)
def test_bad_input(arguments, line):
    with pytest.raises(FrictionloopError, match=line):
        waveform(SensorDesign(), np.zeros_like, *arguments)
