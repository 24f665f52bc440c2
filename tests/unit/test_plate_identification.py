"""Resonance, Q and envelope of the plate, delay of the loop, drift and scales: closed forms and simulated rigs."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import curve_fit
from scipy.signal import hilbert
from scipy.stats import linregress

import frictionloop as fl
from frictionloop.identification import carrier_drift, loop_delay, plate_decay, plate_envelope, plate_sweep, rigs
from frictionloop.identification.linear_calibration import straight_scale
from frictionloop.identification.plate_sweep import stepped
from frictionloop.parameters import ResonantPlate


def inside(estimate, truth, method=0.0):
    low, high = estimate._replace(standard_error=np.hypot(estimate.standard_error, method)).interval(0.999)
    return low < truth < high


def table(**columns):
    units = {"frequency": "Hz", "vibration": "um", "drive": "V", "minutes": "min", "temperature": "degC"}
    return xr.Dataset({name: ("row", np.asarray(values), {"units": units[name]}) for name, values in columns.items()})


@given(st.floats(2e4, 8e4), st.floats(30, 900), st.floats(0.01, 5))
@settings(max_examples=30)
def test_an_exact_sweep_is_fitted_exactly(hertz, q, gain):
    frequency = hertz * (1 + np.linspace(-1.2, 1.7, 21) / q)
    relative = frequency / hertz
    found = plate_sweep(table(frequency=frequency, vibration=gain / np.hypot(1 - relative**2, relative / q)))
    assert found.resonance.value == pytest.approx(hertz, rel=1e-8)
    assert found.q.value == pytest.approx(q, rel=1e-6)
    assert found.corner.value == pytest.approx(hertz / (2 * q), rel=1e-6)


def test_a_sweep_with_noise_agrees_with_curve_fit():
    run = rigs.plate_sweep_rig(noise_um=0.02, seed=4)
    found = plate_sweep(run)

    def lorentz(f, g, f0, q):
        return g / np.hypot(1 - (f / f0) ** 2, f / (f0 * q))

    best, spread = curve_fit(lorentz, run.frequency.values, run.vibration.values, [0.01, 46010, 200])
    assert found.resonance.value == pytest.approx(best[1], rel=1e-6) and found.q.value == pytest.approx(
        best[2], rel=1e-4
    )
    assert found.q.standard_error == pytest.approx(np.sqrt(spread[2, 2]), rel=0.5)
    assert inside(found.q, 230.0, found.method_q) and inside(found.resonance, 46e3, found.method_hz)


def test_a_drive_that_changes_is_divided_out():
    frequency = 46e3 + np.linspace(-300, 300, 21)
    relative, drive = frequency / 46e3, np.linspace(1, 3, 21)
    run = table(frequency=frequency, vibration=drive / np.hypot(1 - relative**2, relative / 230), drive=drive)
    assert plate_sweep(run).q.value == pytest.approx(230.0, rel=1e-6)


@pytest.mark.parametrize("detuning_hz", [0.0, 30.0, -120.0])
def test_decays_and_envelopes(detuning_hz):
    plate = ResonantPlate(frequency_hz=38e3, q=150.0)
    run = rigs.plate_switch_rig(plate, detuning_hz=detuning_hz, switches=6, seed=2)
    found, followed = plate_decay(run), plate_envelope(run)
    assert inside(found.resonance, 38e3, found.method_hz) and inside(found.q, 150.0, found.method_q)
    assert inside(followed.corner, 38e3 / 300, followed.method_hz) and followed.jumps == 3
    assert found.corner.value == pytest.approx(followed.corner.value, rel=0.01)


def test_a_decay_by_hilbert():
    """Another way: a line through the logarithm of the analytic signal and through its phase."""
    run = rigs.plate_switch_rig(switches=2, noise_um=1e-4)
    piece = hilbert(run.vibration.values[8010:9500])[50:-200]
    time = np.arange(piece.size) / 200e3
    rate = -np.polyfit(time, np.log(np.abs(piece)), 1)[0]
    hertz = np.polyfit(time, np.unwrap(np.angle(piece)), 1)[0] / (2 * np.pi)
    found = plate_decay(run)
    assert found.q.value == pytest.approx(np.pi * hertz / rate, rel=2e-3)
    assert found.resonance.value == pytest.approx(hertz, rel=1e-5)


def test_a_single_rise():
    plate = ResonantPlate(q=300.0)
    run = rigs.plate_switch_rig(plate, switches=1, seed=1)
    assert plate_decay(run).q.value == pytest.approx(300.0, rel=0.02)
    assert plate_envelope(run).corner.value == pytest.approx(46e3 / 600, rel=0.01)


@pytest.mark.parametrize("plate_hz", [100.0, None])
@pytest.mark.parametrize("waits", [True, False])
def test_the_delay(plate_hz, waits):
    found = loop_delay(rigs.jumps_rig(310e-6, 4000.0, plate_hz, waits=waits, jumps=12, seed=6), 4000.0, waits=waits)
    assert inside(found.delay, 310e-6, found.method_s)
    assert found.jumps == 12 and np.hypot(found.delay.standard_error, found.method_s) < 30e-6


def test_jumps_in_step_are_noticed():
    (doubt,) = loop_delay(rigs.jumps_rig(waits=False), 5000.0).findings
    assert (doubt.code, doubt.remedy) == ("DELAY-WAITS", "waits = false")
    (doubt,) = loop_delay(rigs.jumps_rig(), 5000.0, waits=False).findings
    assert doubt.remedy == "waits = true"


def test_a_drift():
    rng = np.random.default_rng(0)
    minutes = np.linspace(0, 40, 21)
    kelvin = 20 + 0.2 * minutes
    found = carrier_drift(
        table(minutes=minutes, frequency=46e3 - 14 * kelvin + rng.normal(size=21), temperature=kelvin)
    )
    assert inside(found.rate, -2.8, found.method_hz_per_min) and inside(found.per_kelvin, -14.0)
    # Half a width off: 1/sqrt(2) of the amplitude is left.
    assert found.share_left(found.span_hz * 2 * 200, 200) == pytest.approx(2**-0.5)


@given(st.integers(0, 1000), st.floats(-4, 4).filter(lambda k: abs(k) > 0.1))
@settings(max_examples=20)
def test_a_scale_is_the_line_of_linregress_and_its_jackknife(seed, slope):
    rng = np.random.default_rng(seed)
    x = rng.uniform(0, 3, 9)
    y = 0.3 + slope * x + 0.1 * rng.normal(size=9)
    found, line = straight_scale(x, y), linregress(x, y)
    left = np.array([np.polyfit(np.delete(x, k), np.delete(y, k), 1)[0] for k in range(9)])
    jackknife = np.sqrt(8 / 9 * np.sum((left - left.mean()) ** 2))
    assert found.slope.value == pytest.approx(line.slope)
    assert found.slope.standard_error == pytest.approx(max(jackknife, line.stderr))


PLATE = ResonantPlate(frequency_hz=41e3, q=180.0, max_amplitude_um=2.2)


def swept(seed):
    found = plate_sweep(rigs.plate_sweep_rig(PLATE, noise_um=0.02, seed=seed))
    return {"frequency": (found.resonance, found.method_hz, 41e3), "q": (found.q, found.method_q, 180.0)}


def switched(seed):
    found = plate_decay(rigs.plate_switch_rig(PLATE, switches=6, seed=seed))
    return {"frequency": (found.resonance, found.method_hz, 41e3), "q": (found.q, found.method_q, 180.0)}


def followed(seed):
    found = plate_envelope(rigs.plate_switch_rig(PLATE, switches=6, seed=seed))
    return {"corner": (found.corner, found.method_hz, 41e3 / 360)}


def jumped(seed):
    found = loop_delay(rigs.jumps_rig(230e-6, jumps=40, seed=seed), 5000.0)
    return {"delay": (found.delay, found.method_s, 230e-6)}


WIDEST = {
    swept: {"frequency": 5e-5, "q": 0.025},
    switched: {"frequency": 8e-6, "q": 0.003},
    followed: {"corner": 0.0015},
    jumped: {"delay": 0.12},
}
"""Median half width of intervals of 90 %, as a share of the value, that may not be exceeded."""


@pytest.mark.slow
@pytest.mark.parametrize("measure", WIDEST, ids=lambda measure: measure.__name__)
def test_coverage(measure):
    """Of 40 recordings, fewer than 34 intervals of 90 % hold the truth with a chance of 1 in 20 at most."""
    inside: dict[str, int] = {}
    widths: dict[str, list[float]] = {}
    for seed in range(40):
        for name, (estimate, method, true) in measure(seed).items():
            both = estimate._replace(standard_error=np.hypot(estimate.standard_error, method))
            low, high = both.interval(0.9)
            inside[name] = inside.get(name, 0) + (low < true < high)
            widths.setdefault(name, []).append((high - low) / 2 / true)
    assert all(count >= 34 for count in inside.values()), inside
    assert {name: np.median(each) for name, each in widths.items() if np.median(each) > WIDEST[measure][name]} == {}


RATE, HZ, Q = 200e3, 33.5e3, 150.0
STEPS = np.arange(33e3, 34e3, 50.0)


def gain(hertz):
    return 1 / (1 - (hertz / HZ) ** 2 + 1j * hertz / (HZ * Q))


def recorded(settle_s=1.5e-3, noise=0.005, seed=0):
    """The amplitude of each step is reached with the time constant of the plate, from that of the step before."""
    rows = int(0.03 * RATE)
    hertz = np.repeat(STEPS, rows)
    phase = 2 * np.pi * np.cumsum(hertz) / RATE
    size = 2 * np.abs(gain(STEPS)) / Q
    late = np.exp(-np.arange(rows) / RATE / settle_s)
    amplitude = np.concatenate([new + (old - new) * late for old, new in zip([0.0, *size], size, strict=False)])
    vibration = amplitude * np.sin(phase) + noise * np.random.default_rng(seed).normal(size=hertz.size)
    return xr.Dataset(
        {
            "frequency": ("time", hertz, {"units": "Hz"}),
            "vibration": ("time", vibration, {"units": "um"}),
            "envelope": ("time", amplitude, {"units": "um"}),
        },
        {"time": ("time", np.arange(hertz.size) / RATE, {"units": "s"})},
    )


def test_a_row_has_the_amplitude_of_its_step():
    found, true = stepped(recorded()), 2 * np.abs(gain(STEPS)) / Q
    assert found.frequency.values == pytest.approx(STEPS)
    # A sine of 3000 samples: its amplitude is known to noise sqrt(2/3000); five of these, and what has not settled.
    assert np.abs(found.vibration.values - true).max() < 5 * 0.005 * np.sqrt(2 / 3000) + 2 * np.exp(-10)
    assert np.abs(found.envelope.values - true).max() < 2 * np.exp(-10)


def test_a_project_takes_it(tmp_path):
    run = recorded()
    np.savez(tmp_path / "a.npz", f=run.frequency, v=run.vibration, fs=RATE)
    (tmp_path / "lab.toml").write_text(
        """
[[recording]]
kind = "plate"
files = ["a.npz"]
channels.frequency = { column = "f", unit = "Hz" }
channels.vibration = { column = "v", unit = "um" }
"""
    )
    found = fl.identify.bench(tmp_path / "lab.toml")
    for name, true in (("plate.frequency_hz", HZ), ("plate.q", Q)):
        ends = found.measured[name].interval(0.999)
        assert ends.low < true < ends.high and ends.high - ends.low < 0.02 * true


def test_what_is_no_stepped_sine_is_refused():
    run = recorded().isel(time=slice(0, 20000))
    swept = run.assign(frequency=("time", np.linspace(33e3, 34e3, run.sizes["time"]), {"units": "Hz"}))
    with pytest.raises(fl.FrictionloopError, match="steps of 16 samples or more"):
        stepped(swept)
    with pytest.raises(fl.FrictionloopError, match="samples of 'vibration' per period"):
        stepped(run.isel(time=slice(0, None, 4)))
