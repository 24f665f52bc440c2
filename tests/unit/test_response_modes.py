"""Modes of frequency responses: analytic ones, tables with and without a phase, several modes with a hammer channel."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from three_modes import TRUE

import frictionloop as fl
from frictionloop.cli import main
from frictionloop.identification.frequency_response import FrequencyResponse
from frictionloop.identification.recording_file import opened
from frictionloop.identification.response_modes import response_modes
from frictionloop.identification.sensor_resonance import response_table


def analytic(hertz, modes=TRUE, noise=0.0, seed=0):
    found = sum(size / (1 - (hertz / f) ** 2 + 1j * hertz / (f * q)) for f, q, size in modes)
    draw = np.random.default_rng(seed)
    return found + noise * np.abs(found).max() * (draw.normal(size=hertz.size) + 1j * draw.normal(size=hertz.size))


def given(hertz, values):
    one = np.ones_like(hertz)
    return FrequencyResponse(hertz, values, one, 0 * one, one, 1, 2 * hertz[-1], "V/N")


HERTZ = np.linspace(1000, 6000, 600)


@pytest.mark.parametrize("magnitude", [False, True])
def test_three_modes_of_an_analytic_response(magnitude):
    values = analytic(HERTZ, noise=2e-3)
    found = response_modes(given(HERTZ, np.abs(values) + 0j if magnitude else values), 3, magnitude=magnitude)
    assert len(found.modes) == 3
    for mode, (hertz, q, _) in zip(found.chosen_modes, TRUE, strict=True):
        assert mode.frequency.value == pytest.approx(hertz, rel=1e-3)
        assert mode.q.value == pytest.approx(q, rel=0.03)
    (strongest, *_) = response_modes(given(HERTZ, values), "strongest").chosen_modes
    assert strongest.frequency.value == pytest.approx(3100, rel=1e-3)


@pytest.mark.slow
def test_coverage_of_the_intervals():
    inside = 0
    for seed in range(20):
        mode = response_modes(given(HERTZ, analytic(HERTZ, noise=0.01, seed=seed))).chosen_modes[0]
        low, high = mode.frequency.interval(0.9)
        inside += low < 1600 < high
    assert 15 <= inside <= 20


def test_what_has_no_peak_or_does_not_fit_is_refused_with_its_picture():
    smooth = 1 / (1 + 1j * HERTZ / 500)
    with pytest.raises(fl.FrictionloopError, match="peaks = 0") as failure:
        response_modes(given(HERTZ, smooth))
    assert failure.value.curves["response"]["frequency_hz"]
    draw = np.random.default_rng(1)
    wild = draw.normal(size=HERTZ.size) + 1j * draw.normal(size=HERTZ.size)
    with pytest.raises(fl.FrictionloopError, match=r"misfit|mode = |peaks = 0"):
        response_modes(given(HERTZ, wild))


def lab(folder, header, columns, channels, extra=""):
    np.savetxt(folder / "steps.csv", np.column_stack(columns), delimiter=",", header=header, comments="")
    (folder / "lab.toml").write_text(
        f'[[recording]]\nkind = "response"\nfiles = ["steps.csv"]\n{extra}\n[recording.channels]\n{channels}\n'
    )
    return folder / "lab.toml"


def test_a_stepped_sine_gives_the_sensor(tmp_path):
    hertz = np.repeat(np.linspace(60, 400, 120), 2)[::-1]
    values = analytic(hertz, [(173.0, 26.0, 1.0)], noise=1e-3)
    columns = hertz, np.abs(values), np.degrees(np.angle(values))
    channels = 'frequency = { column = "f" }\nmagnitude = { column = "gain" }\nphase_deg = { column = "phase" }'
    path = lab(tmp_path, "f [Hz],gain,phase", columns, channels, "count = 1")
    found = fl.identify.bench(path)
    assert found.system.sensor.resonance_hz == pytest.approx(173.0, rel=1e-3)
    assert found.system.sensor.q == pytest.approx(26.0, rel=0.02)
    assert found.measured["mode 1"].value == pytest.approx(173.0, rel=1e-3)
    low, high = found.measured["sensor.resonance_hz"].interval(0.99)
    assert low < 173.0 < high


def test_a_refusal_names_its_picture(tmp_path, capsys):
    draw = np.random.default_rng(2)
    hertz = np.linspace(60, 400, 120)
    channels = 'frequency = { column = "f" }\nmagnitude = { column = "gain" }'
    path = lab(tmp_path, "f [Hz],gain", (hertz, 1 + 0.5 * draw.random(hertz.size)), channels)
    with pytest.raises(SystemExit) as left:
        main(["identify", "bench", str(path)])
    said = capsys.readouterr().err
    assert left.value.code == 2 and said.count("\n") == 1
    picture = tmp_path / "lab.refused.png"
    assert str(picture) in said and picture.stat().st_size > 5000


def hammered():
    rate, hits, length = 50e3, 6, 10000
    draw = np.random.default_rng(3)
    force, reading = 1e-4 * draw.normal(size=hits * length), 1e-3 * draw.normal(size=hits * length)
    for k in range(hits):
        onset = k * length + 2000
        pulse = np.zeros(hits * length)
        pulse[onset : onset + 5] = draw.uniform(0.8, 1.2) * np.sin(np.pi * np.arange(5) / 5)
        force += pulse
        time = np.arange(length) / rate
        kernel = sum(
            s * 2 * np.pi * f / rate * np.exp(-np.pi * f / q * time) * np.sin(2 * np.pi * f * time) for f, q, s in TRUE
        )
        reading += np.convolve(pulse, kernel)[: reading.size]
    return xr.Dataset(
        {"hammer": ("time", force, {"units": "N"}), "f_m": ("time", reading, {"units": "V"})},
        {"time": ("time", np.arange(reading.size) / rate, {"units": "s"})},
    )


def test_several_modes_with_a_hammer_channel():
    run = hammered()
    found = response_modes(fl.identify.response(run, 0.15), 3, (800, 7000))
    for mode, (hertz, q, _) in zip(found.chosen_modes, TRUE, strict=True):
        assert mode.frequency.value == pytest.approx(hertz, rel=2e-3)
        assert mode.q.value == pytest.approx(q, rel=0.05)


def test_a_table_reads_every_form(tmp_path):
    hertz = np.linspace(100, 200, 20)
    values = analytic(hertz, [(150.0, 20.0, 1.0)])
    np.savetxt(
        tmp_path / "a.csv", np.column_stack([hertz, values.real, values.imag]), delimiter=",", header="f,re,im",
        comments="",
    )  # fmt: skip
    map_ = {"frequency": "f", "real": "re", "imaginary": "im"}
    np.testing.assert_allclose(response_table(opened(tmp_path / "a.csv", map_, table=True)).response, values)
    np.savez(tmp_path / "b.npz", f=hertz, h=values)
    map_ = {"frequency": "f", "response": "h"}
    np.testing.assert_allclose(response_table(opened(tmp_path / "b.npz", map_, table=True)).response, values)


@pytest.mark.slow
def test_a_hammer_on_three_modes(tmp_path):
    """One resonance explains little of its response: the modes are those of the decays, without a pole."""
    run = hammered()
    np.savez(tmp_path / "a.npz", hammer=run.hammer, f_m=run.f_m, fs=50e3)
    path = tmp_path / "lab.toml"
    path.write_text(
        '[[recording]]\nkind = "hits"\nfiles = ["a.npz"]\nmode = "strongest"\ncount = 3\n'
        'channels.hammer = { column = "hammer", unit = "N" }\nchannels.f_m = { column = "f_m", unit = "V" }\n'
    )
    found = fl.identify.bench(path)
    assert found.measured["sensor.resonance_hz"].value == pytest.approx(3100, rel=2e-3)
    assert found.measured["mode 3"].value == pytest.approx(4800, rel=2e-3)
    assert "sensor.cutoff_hz" not in found.measured
    (untold,) = [each for each in found.findings if each.more.get("what") == "the pole behind the springs"]
    assert "one resonance leaves" in untold.more["reason"]


@pytest.mark.slow
@pytest.mark.parametrize("magnitude", [False, True])
@pytest.mark.parametrize("steps", [31, 76])
def test_noise_that_goes_with_the_response_is_no_mode(steps, magnitude):
    """A stepped sine that reads a percent off at each step: one mode, and within its interval."""
    hertz, inside = np.linspace(900.0, 2400.0, steps), 0
    for seed in range(8):
        draw = np.random.default_rng(seed)
        true = 1 / (1 - (hertz / 1612) ** 2 + 1j * hertz / 1612 / 38)
        seen = true * (1 + 0.01 * (draw.normal(size=steps) + 1j * draw.normal(size=steps)))
        found = response_modes(given(hertz, np.abs(seen) + 0j if magnitude else seen), magnitude=magnitude)
        assert len(found.modes) == 1, seed
        both = found.chosen_modes[0].frequency
        both = both._replace(standard_error=np.hypot(both.standard_error, found.method_hz[0]))
        ends = both.interval(0.9)
        inside += ends.low < 1612 < ends.high
    # Of intervals of 90 % at least five of eight hold the truth, but for a chance of 1 in 200.
    assert inside >= 5


def test_decibels_are_read_and_suspected(tmp_path):
    hertz = np.linspace(100, 200, 60)
    size = np.abs(analytic(hertz, [(150.0, 20.0, 0.01)]))
    table = np.column_stack([hertz, 20 * np.log10(size)])
    np.savetxt(tmp_path / "a.csv", table, delimiter=",", header="f,size", comments="")
    map_ = {"frequency": {"column": "f"}, "magnitude": {"column": "size", "unit": "dB"}}
    found = response_table(opened(tmp_path / "a.csv", map_, table=True))
    np.testing.assert_allclose(np.abs(found.response), size, rtol=1e-9)
    map_["magnitude"] = {"column": "size"}
    with pytest.raises(fl.FrictionloopError, match="magnitude = -"):
        response_table(opened(tmp_path / "a.csv", map_, table=True))
