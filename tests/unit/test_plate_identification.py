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
from frictionloop.identification.line_fits import straight_scale
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


def flat(**columns):
    data = {name: ("time", np.asarray(values, dtype=float), {"units": "V"}) for name, values in columns.items()}
    size = len(next(iter(columns.values())))
    return xr.Dataset(data, {"time": ("time", np.arange(size) / 1e5, {"units": "s"})})


NOISE = np.random.default_rng(0).normal(size=4000)
TWO = sum(1 / np.hypot(1 - (np.linspace(0.97, 1.03, 61) / c) ** 2, 0.005) for c in (0.99, 1.01))


@pytest.mark.parametrize(
    ("function", "arguments", "says"),
    [
        (plate_sweep, [table(frequency=[1.0, 2, 3, 4, 5], vibration=[0.0, 0, 5, 0, 0])], "above half power"),
        (plate_sweep, [table(frequency=np.arange(9.0), vibration=np.linspace(4, 5, 9))], "inside the sweep"),
        (plate_sweep, [table(frequency=46e3 * np.linspace(0.97, 1.03, 61), vibration=TWO)], "misfit of "),
        (plate_sweep, [table(frequency=np.arange(9.0))], "no column 'vibration'"),
        (plate_envelope, [flat(envelope=1 + 0.001 * NOISE)], "jumps of the vibration = 0"),
        (
            plate_decay,
            [flat(vibration=np.sin(np.arange(4000)) * (np.arange(4000) < 3990))],
            "jumps of the vibration = 0",
        ),
        (plate_decay, [flat(vibration=np.sin(2 * np.pi * 49e3 * np.arange(4000) / 1e5))], "rate = 100000 Hz"),
        (loop_delay, [flat(jump=np.arange(4000) > 2000, answer=NOISE), 5000.0], "jumps of 'jump' = 1"),
        (loop_delay, [flat(jump=np.arange(4000) // 1000 % 2, answer=NOISE), 5000.0], "misfit of delayed exponential"),
        (loop_delay, [flat(jump=NOISE, answer=NOISE), 1e5], "4 control_hz"),
        (carrier_drift, [table(minutes=[1, 2], frequency=[4.0, 5.0])], "values of frequency = 2"),
    ],
)
def test_what_is_refused(function, arguments, says):
    with pytest.raises(fl.FrictionloopError) as failure:
        function(*arguments)
    assert says in str(failure.value) and "\n" not in str(failure.value)
