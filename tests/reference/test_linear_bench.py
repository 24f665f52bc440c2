"""The linear bench against the simulator and against python-control: responses, onset of ringing, noise."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from linear_runs import noise_spectrum
from steady_finger import SILENT
from steady_finger import SLIDING as STEADY

import frictionloop as fl
from frictionloop.analysis import kp_limit, linearise

# A response is measured about a point, with a signal that is small on purpose.
pytestmark = pytest.mark.filterwarnings("ignore:UNIT-DOUBT:frictionloop.SignalWarning")

RATE_HZ, TS = 5000, 1 / 5000
SETTLE_S, SCORE_S = 2.0, 1.0
TONES_HZ = np.array([3, 17, 41, 89, 137, 149, 211, 307, 499])
"""Whole periods in SCORE_S, on both sides of the resonance."""
LOOPS = {
    "re-tuned": fl.RETUNED,
    "longer": fl.RETUNED | {"finger.slip_length_um": 30.0},
    "slider": {"controller.kp": 0.01, "controller.ki": 40.0, "finger.slip_length_um": 0.0},
    "fast, late by a fraction": {
        "controller.kp": 0.02,
        "controller.ki": 50.0,
        "controller.delay_s": 1.3e-4,
        "motion.speed_mm_s": 80.0,
    },
    "wrong model": {
        "controller.kp": 0.03,
        "controller.ki": 60.0,
        "controller.model.susceptibility_per_um2": 0.3,
        "controller.model.nominal_n": 0.8,
    },
    "no skin, soft springs": {
        "controller.kp": 0.05,
        "controller.ki": 60.0,
        "finger.kind": "rigid",
        "sensor.q": 5.0,
        "sensor.cutoff_hz": 300.0,
        "plate.q": 400.0,
    },
}
MEAN_N, MEAN_D_N = 0.6, 0.05


def steady(changes: dict[str, object], **signals: object) -> fl.System:
    constants = {"setpoint": fl.Constant(offset_n=MEAN_N), "disturbance": fl.Constant(offset_n=MEAN_D_N)}
    # Without skin the motion stays, and friction depends on nothing.
    return fl.bench().evolve(STEADY | constants | SILENT | changes | signals)


def tones(amplitude_n: float) -> np.ndarray:
    t = np.arange(round((SETTLE_S + SCORE_S) * RATE_HZ) + 2) / RATE_HZ
    phases = np.random.default_rng(5).uniform(0, 2 * np.pi, TONES_HZ.size)
    return amplitude_n * np.cos(2 * np.pi * np.outer(t, TONES_HZ) + phases).sum(axis=1)


def lines(values: np.ndarray) -> np.ndarray:
    return np.asarray(np.fft.rfft(values)[np.round(TONES_HZ * SCORE_S).astype(int)])


def driven(changes: dict[str, object], where: str, folder: Path, amplitude_n: float = 1e-4) -> dict[str, np.ndarray]:
    """Return every force over the input at the tones, from the discrete Fourier transform of the scored second."""
    signal = tones(amplitude_n)
    np.savetxt(folder / "tones.csv", signal, fmt="%.17g", header="force", comments="")
    mean = MEAN_N if where == "setpoint" else MEAN_D_N
    recording = fl.Recording(path=str(folder / "tones.csv"), column="force", rate_hz=RATE_HZ, offset_n=mean)
    run = fl.simulate(steady(changes, **{where: recording}), duration_s=SETTLE_S + SCORE_S, seed=0)
    scored = slice(round(SETTLE_S * RATE_HZ), round((SETTLE_S + SCORE_S) * RATE_HZ))
    assert not run.saturated[scored].any()
    given = lines(signal[:-2][scored])
    return {name: lines(run[name].values[scored]) / given for name in ("f_r", "f_m", "f_a")}


@pytest.mark.parametrize("name", LOOPS)
def test_response_to_the_setpoint(name: str, tmp_path: Path) -> None:
    """T is f_m over f_r and S what is left, both at the samples; asked for: 5 %."""
    expected = linearise(steady(LOOPS[name])).responses(TONES_HZ)
    measured = driven(LOOPS[name], "setpoint", tmp_path)
    np.testing.assert_allclose(np.abs(1 - measured["f_m"]), np.abs(expected["S"]), rtol=0.01)
    np.testing.assert_allclose(np.abs(measured["f_m"]), np.abs(expected["T"]), rtol=0.01)
    np.testing.assert_allclose(measured["f_a"], expected["f_a_from_f_r"], rtol=0.02)


@pytest.mark.parametrize("name", LOOPS)
def test_response_to_the_disturbance(name: str, tmp_path: Path) -> None:
    expected = linearise(steady(LOOPS[name])).responses(TONES_HZ)
    measured = driven(LOOPS[name], "disturbance", tmp_path)
    np.testing.assert_allclose(np.abs(measured["f_a"]), np.abs(expected["f_a_from_d"]), rtol=0.01)


KICK_S, RING_S = 4.0, 0.9


def softly(changes: dict[str, object]) -> fl.System:
    """A clamp 10 mN below the set-point: the springs come to rest on it before the integral lets the loop go."""
    law, floor_n = fl.bench().friction, MEAN_N - 0.01
    lowest_um = np.sqrt(np.log(law.nominal_n / floor_n) / law.susceptibility_per_um2)
    kick = fl.Steps(times_s=(0.0, KICK_S), levels_n=(MEAN_N, MEAN_N + 1e-4))
    changes = {"controller.ki": 30.0, "controller.model.max_amplitude_um": lowest_um, **changes}
    return steady(changes, setpoint=kick, disturbance=fl.Constant())


def growth_per_s(system: fl.System) -> float:
    """Return the rate at which the oscillation after the kick grows in the simulated force, 1/s."""
    run = fl.simulate(system, duration_s=KICK_S + 0.2 + RING_S, seed=0)
    assert not run.saturated[round(KICK_S * RATE_HZ) :].any()
    ring = run.f_m.values[-round(RING_S * RATE_HZ) :]
    parts = np.diff(ring, 2, prepend=ring[:2]).reshape(9, -1)[:, 2:]  # differences leave the slow poles out
    return float(np.polyfit(0.1 * np.arange(9), np.log(np.std(parts, axis=1)), 1)[0])


@pytest.mark.parametrize("length_um", [11.5, 30.0, 0.0])
def test_ringing_sets_in_at_the_limit(length_um: str) -> None:
    """The growth rate goes through 0 at the limit: found between 3 % below and 3 % above it."""
    loop = {"finger.slip_length_um": length_um}
    limit = kp_limit(softly(loop))
    systems = [softly(loop | {"controller.kp": limit * factor}) for factor in (0.97, 1.03)]
    rates = [growth_per_s(system) for system in systems]
    assert rates[0] < 0 < rates[1]
    onset = limit * (0.97 - 0.06 * rates[0] / (rates[1] - rates[0]))
    assert onset == pytest.approx(limit, rel=0.005)
    for system, rate in zip(systems, rates, strict=True):
        poles = linearise(system, force_n=MEAN_N).poles()
        ringing = np.max(np.abs(poles[np.abs(poles.imag) > 0.05]))
        assert rate == pytest.approx(np.log(ringing) / TS, rel=0.1)


def test_the_printed_gains_ring_in_the_simulation_too() -> None:
    """Predicted unstable; simulated, the command swings from clamp to clamp most of the time."""
    printed = {"controller.kp": 10.0, "controller.ki": 2.0}
    assert not linearise(steady(printed)).is_stable()
    run = fl.simulate(steady(printed), duration_s=2.0, seed=0)
    assert run.saturated[RATE_HZ:].mean() > 0.5


NOISE_S, COARSE = 20.0, 11
"""Bits that round by 0.7 mN, against 1.6 mN of noise: enough to spread what is rounded."""


@pytest.mark.parametrize("output", ["f_a", "u"])
@pytest.mark.parametrize(("density", "bits", "runs"), [(2.3e-6, 16, 1), (4e-5, 16, 1), (4e-5, COARSE, 20)])
def test_noise(output: str, density: float, bits: int, runs: int) -> None:
    """The sample variance of T seconds errs by sqrt(integral of S^2 df / T) / integral of S df (one-sided S)."""
    system = steady({**fl.RETUNED, "sensor.noise_density_n_rthz": density, "sensor.adc_bits": bits})
    measured = np.empty(runs)
    for seed in range(runs):
        run = fl.simulate(system, duration_s=SETTLE_S + NOISE_S, seed=seed)
        measured[seed] = np.var(run[output].values[round(SETTLE_S * RATE_HZ) :])
    loop = linearise(system)
    predicted = {"f_a": fl.output_noise_rms_n, "u": fl.command_noise_rms_n}[output](loop)
    spectrum = noise_spectrum(loop, (np.arange(25_000) + 0.5) * 0.1, output)
    error = np.sqrt(np.sum(spectrum**2) * 0.1 / (NOISE_S * runs)) / (np.sum(spectrum) * 0.1)
    assert np.mean(measured) / predicted**2 == pytest.approx(1, abs=4 * error)


control = pytest.importorskip("control")
ANALYTIC = {name: LOOPS[name] for name in ("re-tuned", "longer", "slider", "no skin, soft springs")}


def loop_z(system: fl.System) -> Any:
    """C(z) P S(z) from the numbers in the System, with a zero-order hold and one period of delay."""
    s, speed = control.tf("s"), 1e-3 * system.motion.speed_mm_s
    p, m, c = system.plate, system.sensor, system.controller
    envelope = 1 / (1 + s * 2 * p.q / (2 * np.pi * p.frequency_hz))
    w = 2 * np.pi * m.resonance_hz
    sensor = 1 / (1 + s / (m.q * w) + s**2 / w**2) / (1 + s / (2 * np.pi * m.cutoff_hz))
    contact = control.tf([1], [1])
    if system.finger.kind == "skin":
        contact = 1 / (1 + s * 1e-6 * system.finger.slip_length_um / speed)
    held = control.sample_system(control.ss(envelope * contact * sensor), TS, "zoh")
    return control.ss(control.tf([c.kp, c.ki * TS - c.kp], [1, -1], TS)) * held * control.ss(0, 1, 1, 0, TS)


@pytest.mark.parametrize("name", ANALYTIC)
def test_python_control_has_the_same_responses_and_margins(name: str) -> None:
    system = steady(ANALYTIC[name])
    series = loop_z(system)
    frequency = np.geomspace(0.5, 2499, 300)
    G = series(np.exp(2j * np.pi * frequency * TS))
    loop = linearise(system)
    ours = loop.responses(frequency)
    np.testing.assert_allclose(ours["G"], G, rtol=1e-7)
    np.testing.assert_allclose(ours["S"], 1 / (1 + G), rtol=1e-7)
    np.testing.assert_allclose(ours["T"], G / (1 + G), rtol=1e-7, atol=1e-12)
    # python-control's own margins are roots of a polynomial of order 14, which this resonance leaves few digits; so
    # they are read off its response, on a grid of 0.1 Hz.
    fine = np.arange(0.5, 2499, 0.1)
    G = series(np.exp(2j * np.pi * fine * TS))
    margins = loop.margins()
    assert margins.sensitivity_peak == pytest.approx(np.max(1 / np.abs(1 + G)), rel=1e-4)
    at_unit_gain = between(np.log(np.abs(G)), np.angle(-G))
    assert margins.phase_margin_deg == pytest.approx(np.degrees(min(at_unit_gain, key=abs)), rel=1e-3)
    negative = [real for real in between(G.imag, G.real) if real < 0]
    nearest = min(negative, key=lambda real: abs(np.log(-real)))
    assert margins.gain_margin == pytest.approx(-1 / nearest, rel=1e-3)


def between(value: np.ndarray, other: np.ndarray) -> list[float]:
    """Return the other where the value changes sign, linear between grid points."""
    k = np.flatnonzero(value[1:] * value[:-1] < 0)
    share = value[k] / (value[k] - value[k + 1])
    return list(other[k] + share * (other[k + 1] - other[k]))
