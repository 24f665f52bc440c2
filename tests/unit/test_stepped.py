"""A stepped sine recorded over time is the table of its steps."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import frictionloop as fl
from frictionloop.identification.plate_sweep import stepped

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
