"""Hits, weights and their statistics as laboratories have them: of each trouble the smallest file."""

from __future__ import annotations

import re

import numpy as np
import pytest
from hammer_files import HammerFile, hammer_file

import frictionloop as fl
from frictionloop.identification import modes, pick_hits, response, rigs
from frictionloop.quantities import FrictionloopError

RING_S = np.arange(4000) / 5000.0
HEAD = '[[recording]]\nkind = "{}"\nfiles = {}\n'


def rung(parts, hits, seed=0):
    """Hits 1 s apart at 5 kHz of damped sines: Hz, Q, share."""
    draw, y = np.random.default_rng(seed), np.zeros(5000 * (hits + 1))
    for k in range(hits):
        for hertz, q, share in parts:
            decay = np.exp(-np.pi * hertz / q * RING_S) * np.sin(2 * np.pi * hertz * RING_S)
            y[2500 + 5000 * k :][:4000] += share * draw.uniform(0.9, 1.1) * decay
    return y + 1e-4 * draw.normal(size=y.size)


@pytest.fixture
def bench(tmp_path):
    def made(text, **files):
        for name, values in files.items():
            np.savez(tmp_path / f"{name}.npz", **{"fs": 5000.0, **values})
        (tmp_path / "lab.toml").write_text(text)
        return fl.identify.bench(tmp_path / "lab.toml")

    return made


def codes(found):
    return [each.code for each in found.findings]


@pytest.mark.parametrize("weak", [0.005, 0.02, 0.04])
def test_weak_long_modes_that_beat_are_no_hits(weak):
    reading = rung([(400.0, 10.0, 1.0), (383.0, 60.0, -weak), (407.0, 60.0, weak)], 8)
    run = HammerFile(reading, None, 5000.0, 8, 400.0, 10.0).recording()
    assert len(pick_hits(run).table) == 8
    (found,) = modes(run, "strongest").chosen_modes
    true_hz = 400 * np.sqrt(1 + 1 / 400)  # undamped
    assert found.frequency.value == pytest.approx(true_hz, rel=2e-3) and found.q.value == pytest.approx(10, rel=0.05)


@pytest.mark.parametrize("seed", [5, 20, 28])
def test_files_of_another_generator(seed):
    file = hammer_file(seed)
    assert len(pick_hits(file.recording()).table) == file.hits
    (found,) = modes(file.recording(), "strongest").chosen_modes
    assert found.frequency.value == pytest.approx(file.hertz, rel=2e-3)
    assert found.q.value == pytest.approx(file.q, rel=0.05)


@pytest.mark.parametrize("lines", [False, True])
def test_statistics_are_those_of_files(bench, lines):
    """Mounted three times: neither a file with one hit nor hits in lines of an array shrink the interval."""
    runs = [rung([(hertz, 17.0, 0.5)], 5, k) for k, hertz in enumerate((190, 193, 196))]
    cut = np.lib.stride_tricks.sliding_window_view
    files = {f"m{k}": {"f_m": cut(run, 5000)[2000::5000] if lines else run} for k, run in enumerate(runs)}
    files |= {} if lines else {"poor": {"f_m": rung([(193.0, 17.0, 0.5)], 1)}}
    column = 'channels.f_m = {{ column = "f_m{}", unit = "N" }}\n'.format("[*, :]" if lines else "")
    found = bench(HEAD.format("hits", [f"{name}.npz" for name in files]) + column, **files)
    low, high = found.measured["sensor.resonance_hz"].interval()
    assert high - low == pytest.approx(15, rel=0.1)  # 3/sqrt(3) Hz by Student of two degrees, both sides
    named = [each.where.recording for each in found.findings if each.code == "LEFT-OUT"]
    assert named == ([] if lines else ["poor.npz"])


def test_an_inverted_recording_is_turned_and_not_averaged():
    """With a second mode, too, of which no fit of one resonance tells the sign."""
    runs = []
    for seed in (3, 4, 5):
        run = rigs.hammer_rig(seed=seed)
        second = np.convolve(run.hammer.values, 0.05 * np.exp(-RING_S / 0.02) * np.sin(2 * np.pi * 320 * RING_S))
        runs.append(
            run.assign(f_m=run.f_m + second[: run.sizes["time"]]).assign(f_m=lambda r: r.f_m.assign_attrs(units="N"))
        )
    turned = runs[2].assign(f_m=(-runs[2].f_m).assign_attrs(units="N"))
    found = response([*runs[:2], turned])
    assert [each.where.recording for each in found.findings] == ["recording 3"]
    assert codes(response(turned)) == ["SIGN-DOUBT"] and not response(runs).findings
    np.testing.assert_allclose(found.response, response(runs).response)


def test_modes_beyond_those_there_are_not_asked_for(bench):
    run = rung([(150.0, 20.0, 1.0), (420.0, 30.0, 0.8)], 5)
    found = bench(
        HEAD.format("hits", '["a.npz"]') + 'count = 8\nchannels.f_m = { column = "f_m", unit = "V" }\n', a={"f_m": run}
    )
    assert "mode 2" in found.measured and "mode 3" not in found.measured
    assert "MODE-LEFT-OUT" in codes(found)


def test_a_refusal_lists_frequency_and_q_of_what_it_found():
    draw = np.random.default_rng(0)
    reading = rung([(150.0, 20.0, 1.0), (420.0, 30.0, 0.8)], 6)
    reading += 0.3 * np.abs(reading) * draw.normal(size=reading.size)
    with pytest.raises(FrictionloopError) as refused:
        modes(HammerFile(reading, None, 5000.0, 6, 150.0, 20.0).recording())
    found = np.array(re.findall(r"([\d.]+) Hz \(Q ([\d.]+)\)", str(refused.value)), float)
    assert np.all(np.abs(found / [[150, 20], [420, 30]] - 1) < [0.005, 0.15])


def test_a_mislabelled_weight_is_named_and_left_out_of_the_line(bench):
    marks = np.array([0, 25, 50, 200, 150, 200, 250, 200, 150, 100, 50, 25, 0.0])
    hung = np.where(np.arange(13) == 3, 100.0, marks)
    draw = np.random.default_rng(1)
    files = {"w": {"f_m": 3e-3 * 9.80665 * hung + 2e-3 * draw.normal(size=13), "mass": marks}}
    files["q"] = {"f_m": 3e-4 * draw.normal(size=50000)}
    channels = 'channels.f_m = { column = "f_m", unit = "V" }\n'
    text = HEAD.format("weights", '["w.npz"]') + channels + 'channels.mass = { column = "mass", unit = "g" }\n'
    found = bench(text + HEAD.format("quiet", '["q.npz"]') + channels, **files)
    (label,) = [each for each in found.findings if each.code == "WEIGHT-LABEL"]
    assert label.more["row"] == 4 and label.value == 200 and label.more["other"] == pytest.approx(100, rel=0.01)
    assert "LINE-OFF" not in codes(found)
    slope, density = found.measured["sensitivity"], found.measured["sensor.noise_density_n_rthz"]
    assert slope.value == pytest.approx(3.0, rel=0.005) and density.error / density.value >= slope.error / slope.value
    kept = {name: np.delete(each, 3) for name, each in files["w"].items()}
    mended = bench(text, w=kept).measured["sensitivity"]
    assert (slope.value, slope.error) == pytest.approx((mended.value, mended.error), rel=1e-9)


@pytest.mark.parametrize("masses", [[0, 50, 100, 50, 0], [0, 50, 100, 50]])
def test_a_log_of_plateaus_needs_no_mass(bench, masses):
    log = np.repeat(np.array([0, 50, 100, 50, 0]) * 3e-3 * 9.80665, [30000, 25000, 32000, 28000, 30000])
    log += 1e-3 * np.random.default_rng(0).normal(size=log.size)
    text = HEAD.format("weights", '["w.npz"]') + f"masses_g = {masses}\ngravity_m_s2 = 9.80665\n"
    text += 'channels.f_m = { column = "f_m", unit = "V" }\n'
    if len(masses) < 5:
        with pytest.raises(fl.FrictionloopError, match="masses_g = 4: must be as many as plateaus: 5"):
            bench(text, w={"f_m": log})
    else:
        assert bench(text, w={"f_m": log}).measured["sensitivity"].value == pytest.approx(3.0, rel=1e-3)
