"""Several modes from decays, without a hammer channel: closed forms, agreement, a bow beneath them, refusals."""

from __future__ import annotations

import numpy as np
import pytest
import three_modes
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st
from three_modes import RATE, TRUE, plate

import frictionloop as fl
from frictionloop.identification import modes, pick_hits, rigs
from frictionloop.identification.hit_onsets import without_bow


@pytest.mark.parametrize("seed", range(2))
def test_three_modes_are_found(seed):
    found = modes(plate(seed), 3)
    assert found.hits == 6 and len(found.chosen_modes) == 3
    for mode, (hertz, q, _) in zip(found.chosen_modes, TRUE, strict=True):
        assert mode.frequency.value == pytest.approx(hertz, abs=1.0)
        assert mode.q.value == pytest.approx(q, rel=0.02)
        assert mode.agreement > 0.99


def test_first_and_strongest_are_asked_for_by_name():
    run = plate()
    assert modes(run, "first").chosen_modes[0].frequency.value == pytest.approx(1600, abs=1)
    assert modes(run, "strongest").chosen_modes[0].frequency.value == pytest.approx(3100, abs=1)
    with pytest.raises(fl.FrictionloopError, match=r"1 to 3: 1\d+.* Hz"):
        modes(run, 4)
    with pytest.raises(fl.FrictionloopError, match="'first', 'strongest'"):
        modes(run, "second")


def test_the_sensor_of_the_rig():
    run = rigs.hammer_rig(seed=1)
    found = modes(run, "first")
    assert found.chosen_modes[0].frequency.value == pytest.approx(145.0, abs=0.05)
    assert found.chosen_modes[0].q.value == pytest.approx(20.0, rel=0.01)
    alone = modes(run.drop_vars("hammer"), "first")
    assert alone.chosen_modes[0].frequency.value == pytest.approx(145.0, abs=0.1)


@settings(max_examples=10, deadline=None)
@given(st.floats(60.0, 400.0), st.floats(8.0, 40.0), st.integers(0, 1000))
def test_a_closed_form_is_found_again(resonance_hz, q, seed):
    """Taps of x'' + w/Q x' + w^2 x = w^2 p(t), in counts: at Q 8 the undamped resonance is 0.2 % above what is seen."""
    rng, time = np.random.default_rng(seed), np.arange(20000) / 5000.0
    omega, seen = 2 * np.pi * resonance_hz, 2 * np.pi * resonance_hz * np.sqrt(1 - 1 / (4 * q * q))
    force = np.full(time.size, 0.1)
    for k in range(4):
        t = np.maximum(time - k - 0.2 - 0.1 * rng.random(), 0.0)
        force += rng.uniform(0.5, 1.0) * np.exp(-omega * t / (2 * q)) * np.sin(seen * t)
    counts = ("time", np.round(13107 * force), {"units": "counts"})
    (found,) = modes(xr.Dataset({"f_m": counts}, {"time": ("time", time, {"units": "s"})})).chosen_modes
    assert found.frequency.value == pytest.approx(resonance_hz, rel=1e-4)
    assert found.q.value == pytest.approx(q, rel=5e-3)


def test_a_band_leaves_the_others_out():
    assert modes(plate(), "first", band_hz=(2500, 4000)).chosen_modes[0].frequency.value == pytest.approx(3100, abs=2)


def test_what_does_not_ring_is_refused():
    draw = np.random.default_rng(1)
    y = 1e-3 * draw.normal(size=50000)
    for k in range(5):
        y[10000 * k + 2000 : 10000 * k + 4000] += draw.normal(size=2000) * np.exp(-np.arange(2000) / 500)
    time = ("time", np.arange(y.size) / RATE, {"units": "s"})
    with pytest.raises(fl.FrictionloopError, match=r"misfit|modes = 0|good hits"):
        modes(xr.Dataset({"f_m": ("time", y, {"units": "V"})}, {"time": time}), "first", segment_s=0.08)
    with pytest.raises(fl.FrictionloopError, match="good hits = 1"):
        modes(plate(hits=1), "first")


def alone(run, k, **more):
    """One hit in a recording of its own, as a triggered recorder saves them."""
    rows = int(0.1 * RATE)
    values = run.f_m.values[k * rows : (k + 1) * rows]
    for change in more.values():
        values = change(values)
    return xr.Dataset(
        {"f_m": ("time", values, {"units": "V"})}, {"time": ("time", np.arange(values.size) / RATE, {"units": "s"})}
    )


HUM = 0.05 * np.sin(2 * np.pi * 50 * np.arange(int(0.1 * RATE)) / RATE + 1.0)
RECORDED = {
    "hum": lambda y: y + HUM,
    "offset": lambda y: y + 0.3,
    "coarse converter": lambda y: np.round(y / 0.01) * 0.01,
    "little before the hit": lambda y: y[int(np.argmax(np.abs(y) > 0.1)) - 20 :],
    "cut off": lambda y: y[int(np.argmax(np.abs(y) > 0.1)) - 100 :][:1500],
}


@pytest.mark.parametrize("how", RECORDED)
def test_a_hit_in_each_recording(how):
    run = plate(seed=3, hits=5)
    found = modes([alone(run, k, change=RECORDED[how]) for k in range(5)], 3)
    assert found.hits == 5
    for mode, (hertz, q, _) in zip(found.chosen_modes, TRUE, strict=True):
        assert mode.frequency.value == pytest.approx(hertz, rel=2e-3)
        assert mode.q.value == pytest.approx(q, rel=0.05)


def test_a_mode_that_hits_do_not_share_is_none():
    """Frequencies that scatter by 1 % look like two poles; one of them rings for ever in some hits."""
    found = modes(plate(seed=2, hits=8, spread=0.01), 3)
    assert [round(mode.frequency.value, -2) for mode in found.modes] == [1600, 3100, 4800]
    assert all(mode.q.value < 100 for mode in found.modes)


def test_a_spike_of_the_hammers_noise_is_no_force():
    """A sample 5.5 standard deviations off is more than a fiftieth of a weak pulse: the decay begins before it."""
    run = rigs.hammer_rig(seed=3, peak_n=0.2)
    hammer = run.hammer.values.copy()
    onset = round(fl.identify.pick_hits(run).table[2].time_s * 5000)
    spike = 5.5 * float(np.std(hammer[:500]))
    assert spike > 0.02 * np.abs(hammer[onset : onset + 100]).max()
    hammer[onset + 1500] = spike
    found = modes(run.assign(hammer=("time", hammer, run.hammer.attrs)))
    assert found.chosen_modes[0].frequency.value == pytest.approx(145, rel=1e-3) and found.misfit < 0.02


RUN = three_modes.plate(seed=1, hits=3, noise=5e-3)
X = np.linspace(-1, 1, 10000)
BOWS = {"parabola": X**2, "half sine": np.cos(np.pi * X / 2), "discharge": np.exp(-1.5 * (X + 1))}


def hits(bow):
    """One triggered record for each hit, all with the same bow."""
    time = ("time", np.arange(X.size) / three_modes.RATE, {"units": "s"})
    return [
        xr.Dataset({"f_m": ("time", hit + bow, {"units": "V"})}, {"time": time})
        for hit in RUN.f_m.values.reshape(3, -1)
    ]


@pytest.fixture(scope="module")
def plain():
    return modes(hits(0.0), 3)


@pytest.mark.parametrize(("form", "size"), [("parabola", 3.0), ("half sine", 3.0), ("discharge", 0.3)])
def test_modes_are_those_without_the_bow(plain, form, size):
    """The hits are of 0.5 to 1 V."""
    bowed = modes(hits(size * BOWS[form]), 3)
    assert bowed.hits == 3 and bowed.bow > 0 and plain.bow == 0
    for one, other, (hertz, q, _) in zip(plain.modes, bowed.modes, three_modes.TRUE, strict=True):
        assert other.frequency.value == pytest.approx(hertz, rel=1e-3) and other.q.value == pytest.approx(q, rel=5e-3)
        apart = abs(other.frequency.value - one.frequency.value)
        assert apart < max(one.frequency.standard_error, other.frequency.standard_error)


def test_a_polynomial_is_what_is_taken_off():
    noise = 1e-3 * np.random.default_rng(0).normal(size=X.size)
    left, span = without_bow(noise + 0.4 * X**3 - 0.2 * X + 5.0)
    assert span == pytest.approx(np.ptp(0.4 * X**3 - 0.2 * X), rel=0.01)
    # The median of 416 samples is known to 6e-5, and six numbers go through 24 of them.
    assert np.std(left - noise) < 2e-4


@pytest.mark.parametrize("run", [RUN, rigs.hammer_rig(seed=3)], ids=["taps", "hammer"])
def test_what_has_no_bow_is_left_alone(run):
    reading = run.f_m.values
    left, span = without_bow(reading)
    assert span == 0 and np.array_equal(left, reading - np.median(reading)) and pick_hits(run).bow == 0
