"""The noise of a sensor: its density before the pole, spurs, the quiet stretch, a file that was filtered."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from scipy.signal import butter, lfilter, sosfilt

from frictionloop.identification import noise, rigs
from frictionloop.parameters.calibration_bench import CalibrationBench

RATE = 5000.0


def recording(values, unit="N", rate=RATE):
    time = ("time", np.arange(values.size) / rate, {"units": "s"})
    return xr.Dataset({"f_m": ("time", values, {"units": unit})}, {"time": time})


def white(seed, samples=50000, density=2e-6):
    return density * np.sqrt(RATE / 2) * np.random.default_rng(seed).normal(size=samples)


def test_the_density_of_white_noise_and_its_coverage():
    inside = 0
    for seed in range(100):
        ends = noise(recording(white(seed))).density.interval(0.9)
        inside += ends.low < 2e-6 < ends.high
    assert 82 <= inside <= 97  # two and a half standard deviations of a share of 0.9


def test_a_sensitivity_turns_volts_into_newtons():
    found = noise(recording(0.25 * white(1), "V"), sensitivity=0.25)
    assert found.density.value == pytest.approx(noise(recording(white(1))).density.value, rel=1e-9)


@pytest.mark.parametrize("cutoff", [300.0, 1000.0])
def test_the_electronics_of_the_rig(cutoff):
    """Folded at half the rate, under the vibration of the base."""
    bench = CalibrationBench().evolve({"sensor.cutoff_hz": cutoff, "sensor.resonance_hz": 90.0})
    found = noise(rigs.floor_rig(bench, 20.0, seed=3), resonance_hz=90.0, cutoff_hz=cutoff)
    ends = found.density.interval(0.999)
    assert ends.low < 2.3e-6 < ends.high
    assert found.step_n == pytest.approx(5 / 2**16, rel=1e-6)


def test_a_pole_without_folding():
    """At 100 kHz nothing folds."""
    rate = 100e3
    draw = 2e-6 * np.sqrt(rate / 2) * np.random.default_rng(2).normal(size=1_000_000)
    pole = 1 - np.exp(-2 * np.pi * 1000 / rate)
    found = noise(recording(lfilter([pole], [1, pole - 1], draw), rate=rate), cutoff_hz=1000.0, resonance_hz=100.0)
    assert found.density.value == pytest.approx(2e-6, rel=0.03)


def test_spurs_are_listed_with_their_height_and_left_out():
    time = np.arange(50000) / RATE
    lines = 1e-4 * np.sin(2 * np.pi * 50 * time) + 5e-5 * np.sin(2 * np.pi * 612 * time)
    found = noise(recording(white(4) + lines))
    assert [round(each.frequency_hz) for each in found.spurs[:2]] == [50, 612]
    assert found.spurs[0].rms_n == pytest.approx(1e-4 / np.sqrt(2), rel=0.03)
    assert found.spurs[1].rms_n == pytest.approx(5e-5 / np.sqrt(2), rel=0.05)
    assert found.density.value == pytest.approx(2e-6, rel=0.03)


def test_the_quiet_stretch_is_found():
    values = white(5)
    values[:15000] += 0.01 * np.sin(np.arange(15000) / 200.0)
    values[40000:42000] += 0.05 * np.hanning(2000)
    found = noise(recording(values))
    assert found.interval_s[0] == pytest.approx(3.0, abs=0.11) and found.interval_s[1] == pytest.approx(8.0, abs=0.11)
    assert noise(recording(values), (3.5, 7.5)).interval_s == (3.5, 7.5)


def test_a_file_that_was_low_passed_is_suspected():
    low = sosfilt(butter(6, 800, fs=RATE, output="sos"), white(6))
    found = noise(recording(low))
    assert found.filtered and any(each.more["what"] == "a low-pass of the file" for each in found.findings)
    pole = 1 - np.exp(-2 * np.pi * 500 / RATE)
    assert not noise(recording(lfilter([pole], [1, pole - 1], white(6)))).filtered  # a sensor's own pole is none


def test_bands_add_up():
    found = noise(recording(white(7)))
    total = np.sqrt(sum(rms**2 for rms in found.rms_n.values()))
    assert total == pytest.approx(np.std(white(7)), rel=0.02)


def test_newtons_come_from_weights_of_the_same_unit_or_from_the_map():
    from frictionloop.identification.project_entry_result import Sensor, in_newtons

    def run(unit, **more):
        time = ("time", np.arange(8) / 1e3, {"units": "s"})
        return xr.Dataset({"f_m": ("time", np.full(8, 6.0), {"units": unit} | more)}, {"time": time})

    by_volts = Sensor(sensitivity=3.0, unit="V")
    for given, sensor, newtons, words in (
        (run("V"), by_volts, 2.0, ""),
        (run("N"), by_volts, 6.0, ""),
        (run("counts", newtons_per_unit=0.5), by_volts, 3.0, "counts by weights is not told: taken for 0.5 N"),
        (run("counts"), by_volts, 6.0, "taken for 1 N"),
        (run("V", newtons_per_unit=0.5), by_volts, 2.0, ""),
    ):
        (found,), told = in_newtons([given], sensor)
        assert float(found.f_m[0]) == newtons and found.f_m.attrs["units"] == "N"
        assert words in " ".join(map(str, told)) and bool(told) == bool(words)
