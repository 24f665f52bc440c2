"""The linear optimum of fingers: between the waterbed's bound and loops that exist; the noise of a reading."""

from __future__ import annotations

import numpy as np
import pytest
from designed_notch import DESIGNED_NOTCH

import frictionloop as fl
from studies.causes import mean_occlusion
from studies.linear_reach import KEPT, linear_reach, linear_reach_table, reading_noise_psd
from studies.oracle import deciding

BENCH = fl.bench().evolve({"motion.stroke_mm": 240.0, "setpoint": fl.Constant(offset_n=0.6)})
SHORT = {"duration_s": 2.0, "levels_n": [0.6]}


@pytest.mark.parametrize("length_um", [11.5, 0.0])
def test_a_run_under_a_designed_law_leaves_more(length_um: str) -> None:
    own = BENCH.evolve({"finger.slip_length_um": length_um})
    found = linear_reach(own, [{}], seed=7, peaks=[2.0], levels_n=[0.6]).sel(measured="force and load").squeeze()
    run = fl.simulate(own.evolve(DESIGNED_NOTCH), 11.0, 7)
    left = fl.rms_error(run, run["scored"].values & (run["time"].values >= 1.0))
    assert found["waterbed_rms_n"] < found["bound_rms_n"] <= found["optimum_rms_n"] < left
    assert found["noise_rms_n"] < found["optimum_rms_n"] < found["open_rms_n"]


def test_the_waterbed_is_below_a_loop_of_the_same_peak_and_falls_with_the_peak() -> None:
    pi = BENCH.evolve(fl.RETUNED)
    loop = fl.linearise(pi, force_n=0.6, occluded=mean_occlusion(pi, 1.0, 11.0))
    run, peak = fl.simulate(pi, 11.0, 7), loop.margins().sensitivity_peak
    found = linear_reach(pi, [{}], seed=7, peaks=[peak, 1.2 * peak, 3.0], levels_n=[0.6]).isel(finger=0)
    least, open_ = (found[name].sel(measured="force").values for name in ("waterbed_rms_n", "open_rms_n"))
    assert least[0] < fl.rms_error(run, run["scored"].values & (run["time"].values >= 1.0))
    assert np.all(np.diff(least) < 0)
    assert np.all(least < open_)
    assert np.all(found["open_rms_n"].sel(measured="force and load").values < open_)


def test_without_lag_the_waterbed_is_in_proportion_to_the_force() -> None:
    slider = BENCH.evolve({"finger.slip_length_um": 0.0})
    found = [
        linear_reach(slider, [{}], 3.0, 7, peaks=[1.7], levels_n=levels)["waterbed_rms_n"].values
        for levels in ([0.4], [0.8], [0.4, 0.8])
    ]
    assert found[1] == pytest.approx(2.0 * found[0], rel=1e-3)
    assert found[2] == pytest.approx(np.sqrt((found[0] ** 2 + found[1] ** 2) / 2.0), rel=1e-9)


def test_a_quieter_sensor_and_a_larger_peak_reach_further() -> None:
    quiet = {"sensor.noise_density_n_rthz": 1e-8, "sensor.adc_bits": 24}
    found = linear_reach(BENCH, [{}, quiet, {"friction.nominal_n": 0.3}], seed=7, peaks=[1.7, 2.0], **SHORT)
    least = found["optimum_rms_n"].sel(measured="force and load").transpose("finger", "sensitivity_peak").values
    assert np.all(least[1] < least[0])
    assert np.all(least[:2, 1] < 0.97 * least[:2, 0])
    assert np.isnan(least[2]).all()
    assert (found["noise_rms_n"].isel(finger=1) < 0.5 * found["noise_rms_n"].isel(finger=0)).all()


def test_the_plates_lag_costs_no_linear_law_more_than_a_period() -> None:
    """A plate of 1 kHz in place of 100 Hz: its pole is divided out; what sampling leaves of it differs a little."""
    found = linear_reach(BENCH, [{}, {"plate.q": 23.0}], seed=7, peaks=[1.7], **SHORT)
    slow, quick = found["optimum_rms_n"].sel(measured="force").values.ravel()
    assert quick == pytest.approx(slow, rel=0.05)
    # With a drive that is seldom cut it costs more: the quick one has it for the asking.
    slow_driven, quick_driven = found["driven_rms_n"].sel(measured="force").values.ravel()
    assert slow <= slow_driven and quick <= quick_driven < slow_driven


def test_noise_of_readings_has_the_variance_of_the_simulated_sensor() -> None:
    frequency_hz = (np.arange(100_000) + 0.5) * 2500.0 / 100_000
    power = reading_noise_psd(BENCH, frequency_hz).sum() * 2500.0 / frequency_hz.size
    sensor = BENCH.sensor
    assert power == pytest.approx(sensor.noise_rms_n**2 + sensor.step_n**2 / 12.0, rel=1e-6)
    paper = fl.paper()
    density = reading_noise_psd(paper, np.array([1e-3]))
    assert density == pytest.approx(2.0 * paper.sensor.noise_rms_n**2 / paper.controller.rate_hz, rel=1e-6)


def test_the_table_has_both_speeds_and_contacts() -> None:
    options = SHORT | {"peaks": [1.7]}
    found = linear_reach_table(BENCH, [{}], **options)
    one = linear_reach(BENCH.evolve({"motion.speed_mm_s": 80.0, "finger.slip_length_um": 0.0}), [{}], **options)
    cell = found.sel(speed_mm_s=80.0, slip_length_um=0.0)
    assert all(np.array_equal(cell[name].transpose(*one[name].dims), one[name]) for name in KEPT)


def test_without_a_limit_on_the_peak_it_is_the_least_that_cannot_be_predicted() -> None:
    """On a slider: who knows the future leaves less, who does not more."""
    own = BENCH.evolve({"finger.slip_length_um": 0.0, "motion.speed_mm_s": 80.0})
    asked = {"seed": 7, "peaks": [2.0, np.inf], "levels_n": [0.6]}
    found = linear_reach(own, [{}], **asked).sel(measured="force and load").isel(finger=0)
    at_two, least = found["optimum_rms_n"].values
    assert least <= at_two
    assert found["bound_rms_n"].values[1] == pytest.approx(least, rel=2e-3)
    assert found["waterbed_rms_n"].values[1] == 0.0
    left = {}
    with deciding(preview=True) as clairvoyant:
        for name, law in {"notch": DESIGNED_NOTCH, "clairvoyant": clairvoyant}.items():
            run = fl.simulate(own.evolve(law), 11.0, 7)
            left[name] = fl.rms_error(run, run["scored"].values & (run["time"].values >= 1.0))
    assert left["clairvoyant"] < 0.1 * least < least < left["notch"]
