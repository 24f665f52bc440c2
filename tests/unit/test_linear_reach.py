"""The linear optimum of fingers: between the waterbed's bound and loops that exist; the noise of a reading."""

from __future__ import annotations

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.design.linear_reach import KEPT, linear_reach, linear_reach_table, reading_noise_psd
from frictionloop.design.reachable import least_residual

BENCH = fl.bench().evolve({"motion.stroke_mm": 240.0, "setpoint": fl.Constant(offset_n=0.6)})
SHORT = {"duration_s": 2.0, "levels_n": [0.6]}


@pytest.mark.parametrize("contact", ["dahl", "slider"])
def test_a_run_under_the_tracker_leaves_more(contact: str) -> None:
    own = BENCH.evolve({"finger.contact": contact})
    found = linear_reach(own, [{}], seed=7, peaks=[2.0], levels_n=[0.6]).sel(measured="force and load").squeeze()
    run = fl.simulate(own.evolve({"controller.kind": "tracker"}), 11.0, 7)
    left = fl.rms_error(run, run["scored"].values & (run["time"].values >= 1.0))
    assert found["waterbed_rms_n"] < found["bound_rms_n"] <= found["optimum_rms_n"] < left
    assert found["noise_rms_n"] < found["optimum_rms_n"] < found["open_rms_n"]


def test_the_waterbed_beside_it_is_that_of_least_residual() -> None:
    found, alone = (each(BENCH, [{}], seed=7, peaks=[1.7], **SHORT) for each in (linear_reach, least_residual))
    assert np.array_equal(found["waterbed_rms_n"], alone["residual_rms_n"])
    assert np.array_equal(found["open_rms_n"].sel(sensitivity_peak=1.7), alone["open_rms_n"])


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
    one = linear_reach(BENCH.evolve({"motion.speed_mm_s": 80.0, "finger.contact": "slider"}), [{}], **options)
    cell = found.sel(speed_mm_s=80.0, contact="slider")
    assert all(np.array_equal(cell[name].transpose(*one[name].dims), one[name]) for name in KEPT)
    with pytest.raises(fl.FrictionloopError, match=r'friction\.kind = "gaussian": must be "finger"'):
        linear_reach(fl.paper(), [{}])
