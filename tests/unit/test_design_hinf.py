"""The designs on the bench: what they promise, found again from poles and responses of the loop they are put into."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from scipy.signal import tf2ss

import frictionloop as fl
from frictionloop.analysis.linear import linearise
from frictionloop.control.filtered_pi import filtered_pi_gains
from frictionloop.design.friction_noise import NoiseModel
from frictionloop.design.hinf import MOST_STATES, Weights, design_hinf, weighted_plant
from frictionloop.design.pi_synthesis import retune
from frictionloop.design.slicot import Quadruple, synthesise
from frictionloop.parameters import bench
from frictionloop.quantities import FrictionloopError

BENCH = bench()
TREMOR = Quadruple(*tf2ss([0.3e-3, 5.0e-3], [1 / (2 * np.pi * 10) ** 2, 4 / (2 * np.pi * 100), 1.0]))
NOISE = NoiseModel(xr.DataArray([0.0]), TREMOR)
"""A peak at 10 Hz, 4 Hz wide, on a flat ground: 5 mN/rtHz below it."""


@pytest.fixture(scope="module")
def design():
    return design_hinf(BENCH, NOISE)


def series(blocks: list[Quadruple]) -> Quadruple:
    """One after the other, the first one driven first."""
    A, B, C, D = blocks[0]
    for a, b, c, d in blocks[1:]:
        A, B = np.block([[A, np.zeros((len(A), len(a)))], [b @ C, a]]), np.vstack([B, b @ D])
        C, D = np.hstack([d @ C, c]), d @ D
    return Quadruple(A, B, C, D)


def state_space(design) -> Quadruple:
    """The sections in transposed direct form and the PI, as the law runs them, and overdrive of a plate of 100 Hz."""
    blocks, cascade, p = [], design.cascade, np.exp(-2 * np.pi * 100 / 5000)
    for b0, b1, b2, a1, a2 in cascade.sections:
        B = np.array([[b1 - a1 * b0], [b2 - a2 * b0]])
        blocks.append(Quadruple(np.array([[-a1, 1.0], [-a2, 0.0]]), B, np.array([[1.0, 0.0]]), np.array([[b0]])))
    one = np.ones((1, 1))
    blocks.append(Quadruple(one, one * cascade.ki * cascade.period_s, one, one * cascade.kp))
    blocks.append(Quadruple(0 * one, one, -one * p / (1 - p), one / (1 - p)))
    return series(blocks)


def residual_rms_n(sensitivity: np.ndarray, f: np.ndarray) -> float:
    """What |S| leaves of the disturbance from 1 to 500 Hz, N."""
    band = (f >= 1.0) & (f <= 500.0)
    return float(np.sqrt(np.trapezoid(NOISE.density(f[band]) * sensitivity[band] ** 2, f[band])))


def closed_poles(plant, K: Quadruple) -> np.ndarray:
    B, C = plant.B[:, :1], plant.C[1:]
    return np.linalg.eigvals(np.block([[plant.A - B @ K.D @ C, B @ K.C], [-K.B @ C, K.A]]))


def test_it_holds_what_is_wanted_by_eigenvalues_and_a_plain_grid(design) -> None:
    K, f = state_space(design), np.append(np.geomspace(0.1, 2499, 6000), 2500.0)
    for off, most in ((0.0, 1.7), (-0.05, 2.0), (0.05, 2.0), (-0.1, 2.6), (0.1, 2.6)):
        for length_um in (11.5, 0.0):
            loop = linearise(BENCH.evolve({"sensor.resonance_hz": 145 * (1 + off), "finger.slip_length_um": length_um}))
            for gain in (0.65, 1.0, 2.0):
                scaled = K._replace(C=gain * K.C, D=gain * K.D)
                assert np.abs(closed_poles(loop.plant.state_space(), scaled)).max() < 1
            G = K.at(np.exp(2j * np.pi * f * 2e-4))[:, 0, 0] * loop.plant.response(f)[:, 1, 0]
            assert np.abs(1 / (1 + G)).max() <= most + 1e-3


def test_it_leaves_less_than_a_pi_held_to_the_same(design) -> None:
    f = np.geomspace(1.0, 500.0, 4000)
    S = [linearise(BENCH.evolve(each.overrides)).responses(f)["S"] for each in (design, retune(BENCH, 1.7))]
    assert residual_rms_n(np.abs(S[0]), f) < residual_rms_n(np.abs(S[1]), f)


def test_it_fits_the_law(design) -> None:
    assert len(design.cascade.sections) <= 6
    assert np.abs(design.cascade.sections).max() <= 2.0
    names = ("kind", "kp", "ki", "sections", "feedforward", "overdrive")
    assert set(design.overrides) == {f"controller.{name}" for name in names}
    assert design.overrides["controller.feedforward"] and design.overrides["controller.overdrive"]
    # Slow sections behind the first two, which the law can hold to the command.
    assert filtered_pi_gains(BENCH.evolve(design.overrides).controller).hold != 0.0
    nearest = [np.abs(1 - np.roots([1.0, *section[3:]])).min() for section in design.cascade.sections]
    assert min(nearest[:2]) >= max(nearest[2:])
    # Overdrive takes the plate's lag, one state more, which cancels in part of the designs.
    assert design.order <= min(design.full_order + 1, 13)


def test_the_norm_of_the_weighted_bench_is_what_the_synthesis_says() -> None:
    P = weighted_plant(linearise(BENCH).plant, NOISE.shaping, Weights())
    controller, gamma = synthesise(P)
    z = np.exp(1j * np.append(np.geomspace(1e-5, np.pi, 4000), 0))
    M, k = P.at(z[z != 1]), controller.at(z[z != 1])
    closed = M[:, :3, :4] + M[:, :3, 4:] @ k @ np.linalg.solve(1 - M[:, 3:, 4:] @ k, M[:, 3:, :4])
    norm = np.linalg.norm(closed, 2, axis=(1, 2)).max()
    assert norm == pytest.approx(gamma, rel=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("length_um", [11.5, 0.0])
def test_it_leaves_less_than_the_pi_on_capable_fingers(length_um) -> None:
    design = design_hinf(BENCH)  # for the bench's own friction noise
    people = fl.fingers(40, seed=3)
    able = [person for person, able in zip(people, fl.capable(people).capable.values, strict=True) if able]
    sine = {"kind": "sine", "offset_n": 0.6, "amplitude_n": 0.1, "frequency_hz": 1.0}
    # One stroke: how soon a law is back after a reversal is another matter.
    system = BENCH.evolve({"finger.slip_length_um": length_um, "setpoint": sine, "motion.stroke_mm": 240.0})

    def residual(overrides) -> float:
        run = fl.sweep(system.evolve(overrides), able, duration_s=7.0, score_from_s=1.0, metrics=["rms_error"])
        return float(run["rms_error"].median())

    assert residual(design.overrides) < 0.85 * residual(fl.RETUNED)


def test_fewer_states_are_checked_again(monkeypatch) -> None:
    monkeypatch.setattr("frictionloop.design.hinf.ORDER", 8)
    small = design_hinf(BENCH, NOISE)
    assert (small.order, len(small.cascade.sections)) == (9, 4)
    for off in (-0.05, 0.0, 0.05):
        off_bench = BENCH.evolve({**small.overrides, "sensor.resonance_hz": 145 * (1 + off)})
        assert linearise(off_bench).margins().sensitivity_peak <= 2.0


def test_a_delay_of_two_periods_at_5_khz_gets_a_controller_whose_pi_keeps_its_sign(monkeypatch) -> None:
    """The first section turns the sign of the least controller, which the search begins with."""
    late = BENCH.evolve({"sensor.resonance_hz": 240.0, "sensor.q": 25.0, "controller.delay_s": 400e-6})
    late = late.evolve({"finger.slip_length_um": 30.0})
    late = late.evolve({"plate.frequency_hz": 28.4e3, "plate.q": 260.0, "plate.max_amplitude_um": 2.2})
    late = late.evolve({"motion.speed_mm_s": 60.0, "motion.load_n": 0.8, "setpoint.offset_n": 0.475})
    late = late.evolve({"controller.model.nominal_n": 1.45, "controller.model.plate_hz": 54.6})
    num = (5.035e-11, 5.3918e-08, 5.4167e-06, 3.8876e-04, 9.9553e-03)
    shaping = Quadruple(*tf2ss(num, (1.788e-14, 8.5588e-08, 1.9705e-05, 1.0067e-03, 7.8072e-02, 1.0)))
    monkeypatch.setattr("frictionloop.design.hinf.SEARCHES", 0)
    found = design_hinf(late, replace(NOISE, shaping=shaping))
    assert found.cascade.sections[0][0] < 0 < min(found.cascade.kp, found.cascade.ki)
    for length_um in (11.5, 0.0):
        loop = linearise(late.evolve({**found.overrides, "finger.slip_length_um": length_um}))
        assert loop.margins().sensitivity_peak <= 1.7


def test_a_synthesis_without_a_controller_says_what_limits_and_what_to_try(monkeypatch) -> None:
    def fails(*_):
        raise FrictionloopError("the controller is not stable by itself")

    monkeypatch.setattr("frictionloop.design.hinf.synthesise", fails)
    with pytest.raises(FrictionloopError, match=r"^law hinf: .*delay 1 periods: .* not stable"):
        design_hinf(BENCH, NOISE)


@pytest.mark.parametrize("periods", [MOST_STATES - 8, MOST_STATES - 8.5, MOST_STATES - 7.5, 250, 3000])
def test_a_delay_of_too_many_states_is_refused_before_any_synthesis(periods, monkeypatch):
    """Of the generalised plant 8 states are no delay: 5 of the plant, 1 integrator, 2 of `TREMOR`."""
    reached = FrictionloopError("the synthesis was reached")

    def stop(plant):
        assert len(plant.A) <= MOST_STATES
        raise reached

    monkeypatch.setattr("frictionloop.design.hinf.synthesise", stop)
    slow = BENCH.evolve({"controller.delay_s": periods / 5000.0})
    match = "was reached" if periods <= MOST_STATES - 8 else "controller.delay_s = .* 0.0224 s"
    with pytest.raises(FrictionloopError, match=match):
        design_hinf(slow, NOISE)


def test_a_sensor_too_noisy_is_told_with_the_noise_that_would_do() -> None:
    noisy = BENCH.evolve({"sensor.noise_density_n_rthz": 2.34e-4, "sensor.adc_bits": 24})
    with pytest.raises(fl.FrictionloopError, match=r"^law hinf: .* N, .* N$") as no:
        design_hinf(noisy, NOISE)
    found_n, most_n = map(float, re.findall(r"(\S+) N\b", str(no.value)))
    assert most_n == 0.03 < found_n
    design_hinf(noisy.evolve({"sensor.noise_density_n_rthz": 0.97 * most_n / found_n * 2.34e-4}), NOISE)
