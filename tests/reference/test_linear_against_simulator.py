"""The linear loop against the simulator: measured frequency responses and measured noise."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from linear_runs import noise_spectrum

import frictionloop as fl
from frictionloop.analysis import LinearLoop, linearise

# A response is measured about a point, with a signal that is small on purpose.
pytestmark = pytest.mark.filterwarnings("ignore:UNIT-DOUBT:frictionloop.SignalWarning")

RATE_HZ = 5000
SETTLE_S = 2.0  # the slowest pole, ki / (1 + kp) = 18 / s or faster, has decayed by exp(-36)
SCORE_S = 1.0
TONES_HZ = np.array([3, 17, 41, 107, 263, 457, 809, 1301, 2003])
"""Whole periods in SCORE_S; no sum or difference of two of them is a third, so products of second order fall beside."""
LOOPS = {
    "paper's kp": {"controller.kp": 10.0, "controller.ki": 200.0},
    "late": {"controller.kp": 3.0, "controller.ki": 200.0, "controller.delay_s": 2e-4},
    "late by a fraction": {"controller.kp": 4.0, "controller.ki": 200.0, "controller.delay_s": 1.3e-4},
    "wrong model": {
        "controller.kp": 5.0,
        "controller.ki": 200.0,
        "controller.model.susceptibility_per_um2": 0.25,
        "controller.model.nominal_n": 0.9,
    },
}
MEAN_FORCE_N, MEAN_DISTURBANCE_N = 0.6, 0.15


def bench(changes: dict[str, float]) -> fl.System:
    constants = {
        "setpoint": fl.Constant(offset_n=MEAN_FORCE_N),
        "disturbance": fl.Constant(offset_n=MEAN_DISTURBANCE_N),
        "sensor.noise_rms_n": 0.0,
    }
    return fl.paper().evolve(constants | changes)


def linear(system: fl.System) -> LinearLoop:
    return linearise(system, force_n=MEAN_FORCE_N - MEAN_DISTURBANCE_N)


def tones(amplitude_n: float) -> np.ndarray:
    t = np.arange(round((SETTLE_S + SCORE_S) * RATE_HZ) + 2) / RATE_HZ
    phases = np.random.default_rng(5).uniform(0, 2 * np.pi, TONES_HZ.size)
    return amplitude_n * np.cos(2 * np.pi * np.outer(t, TONES_HZ) + phases).sum(axis=1)


def measured_response(system: fl.System, where: str, output: str, amplitude_n: float, folder: Path) -> np.ndarray:
    """Return output / input at the tones, from the discrete Fourier transform of the scored second."""
    signal = tones(amplitude_n)
    path = folder / "tones.csv"
    np.savetxt(path, signal, fmt="%.17g", header="force", comments="")
    mean = MEAN_FORCE_N if where == "setpoint" else MEAN_DISTURBANCE_N
    recording = fl.Recording(path=str(path), column="force", rate_hz=RATE_HZ, offset_n=mean)
    run = fl.simulate(system.evolve({where: recording}), duration_s=SETTLE_S + SCORE_S, seed=0)
    scored = slice(round(SETTLE_S * RATE_HZ), round((SETTLE_S + SCORE_S) * RATE_HZ))
    assert not run.saturated[scored].any()
    lines = np.round(TONES_HZ * SCORE_S).astype(int)
    given = signal[:-2][scored]
    return np.asarray((np.fft.rfft(run[output].values[scored]) / np.fft.rfft(given))[lines])


@pytest.mark.parametrize("name", LOOPS)
@pytest.mark.parametrize("where", ["setpoint", "disturbance"])
def test_frequency_response(name: str, where: str, tmp_path: Path) -> None:
    """At the tones only products of third order disturb: halving the amplitude must quarter what is left."""
    system = bench(LOOPS[name])
    expected = linear(system).responses(TONES_HZ)["f_a_from_f_r" if where == "setpoint" else "f_a_from_d"]
    apart = {}
    for amplitude_n in (2e-4, 1e-4):
        measured = measured_response(system, where, "f_a", amplitude_n, tmp_path)
        apart[amplitude_n] = np.max(np.abs(measured - expected))
    # Nine tones through kp 10 swing u by about 9 * 10 * 0.2 mN = 18 mN of 450 mN: third order (0.04)^2 = 1.6e-3.
    assert apart[2e-4] < 1.6e-3
    assert apart[2e-4] / apart[1e-4] == pytest.approx(4, rel=0.2)


NOISE_S = 20.0


@pytest.mark.parametrize("name", LOOPS)
@pytest.mark.parametrize("output", ["f_a", "u"])
def test_noise(name: str, output: str) -> None:
    """The sample variance of T seconds errs by sqrt(integral of S^2 df / T) / integral of S df (one-sided S)."""
    system = bench(LOOPS[name]).evolve({"sensor.noise_rms_n": 1e-5})
    run = fl.simulate(system, duration_s=SETTLE_S + NOISE_S, seed=11)
    measured = np.var(run[output].values[round(SETTLE_S * RATE_HZ) :])
    loop = linear(system)
    predicted = 1e-5**2 * loop.state_space().variance("n")[output]
    spectrum = noise_spectrum(loop, (np.arange(25_000) + 0.5) * 0.1, output)
    error = np.sqrt(np.sum(spectrum**2) * 0.1 / NOISE_S) / (np.sum(spectrum) * 0.1)
    assert measured / predicted == pytest.approx(1, abs=4 * error)
