"""What a loop leaves of a disturbance between frequencies that a person names."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.cli.advice import CLAMPED, by_itself
from frictionloop.cli.advice_text import lines
from frictionloop.cli.bands_asked import by_band, edges_of, notes, rows
from frictionloop.cli.ringing import of_system


def test_the_bands_are_named_counted_and_add_up_to_the_whole(tmp_path, frictionloop):
    at_s = np.arange(4000) / 1000.0
    slow_n, fast_n = 0.05 * np.sin(2 * np.pi * 3.0 * at_s), 0.02 * np.sin(2 * np.pi * 90.0 * at_s)
    table = np.column_stack([at_s, slow_n + fast_n])
    np.savetxt(tmp_path / "s.csv", table, delimiter=",", header="time_s,force_n", comments="")
    given = [
        "simulate", "--preset", "feasible", "--setpoint.kind", "constant", "--setpoint.offset_n", "0.5",
        "--disturbance.kind", "recording", "--disturbance.path", str(tmp_path / "s.csv"),
        "--disturbance.column", "force_n", "--duration-s", "4", "--split-hz", "8,300",
    ]  # fmt: skip
    said = frictionloop(*given).out
    assert "by frequency" in said
    assert "below 8 Hz" in said
    assert "8 to 300 Hz" in said
    assert "above 300 Hz, where next to nothing varies" in said
    bands = json.loads(frictionloop(*given, "--json").out)["bands"]
    assert [each["low_hz"] for each in bands] == [0.0, 8.0, 300.0]
    assert bands[0]["disturbance_n"] == pytest.approx(0.05 / math.sqrt(2), rel=0.01)
    assert bands[1]["disturbance_n"] == pytest.approx(0.02 / math.sqrt(2), rel=0.01)
    assert bands[1]["disturbance_left"] == pytest.approx(bands[1]["left_n"] / bands[1]["disturbance_n"])


@pytest.mark.parametrize("text", ["", "x", "8,4", "0", "-1", "8,8", "2500", "nan", "8;20"])
def test_frequencies_that_do_not_rise_within_the_loops_are_refused(text):
    with pytest.raises(fl.FrictionloopError, match="split_hz"):
        edges_of(text, 5000.0)
    assert edges_of(None, 5000.0) == []
    assert edges_of("8, 20", 5000.0) == [0.0, 8.0, 20.0, math.inf]


def told(edges, *tones_hz):
    at_s = np.arange(10_000) / 5000.0
    values_n = 0.02 * sum((np.sin(2 * np.pi * each * at_s) for each in tones_hz), start=0 * at_s)
    signals = {"setpoint": fl.Constant(offset_n=0.5), "disturbance": fl.Samples(values_n=values_n, rate_hz=5000.0)}
    run = fl.simulate(fl.feasible().evolve(signals), 2.0)
    mask = run.time.values >= 0.5
    return " ".join(notes(run, mask, by_band(run, mask, edges_of(edges, 5000.0))))


def test_a_tone_that_is_too_near_to_an_edge_is_said():
    assert "by less than 1.3 Hz, and so near to 8 Hz" in told("8", 7.5)
    assert told("8", 3.0, 90.0) == ""


def test_what_is_not_there_is_said():
    calm = fl.simulate(fl.feasible().evolve({"disturbance": fl.Constant()}), 1.0)
    everything = np.ones(calm.sizes["time"], bool)
    bands = by_band(calm, everything, edges_of("8", 5000.0))
    assert "nothing of a disturbance varies" in " ".join(notes(calm, everything, bands))
    assert [row[1] for row in rows(bands, np.ones(4, bool))] == ["-", "-"]
    assert by_band(calm, ~everything, edges_of("8", 5000.0)) == []


@pytest.mark.parametrize(
    ("gains", "rings"),
    [
        ((), True),
        (("--controller.kp", "0.0064", "--controller.ki", "13.8"), False),
    ],
)
def test_a_loop_that_rings_has_no_share_to_quote(gains, rings, tmp_path, frictionloop):
    """Its ringing is there without the disturbance too: what is left is the difference of two limit cycles."""
    force_n = 0.02 * np.sin(2 * np.pi * 3.0 * np.arange(1500) / 1000.0)
    np.savetxt(tmp_path / "s.csv", force_n, header="force_n", comments="")
    said = frictionloop(
        "simulate", "--preset", "bench", *gains, "--setpoint.kind", "constant", "--setpoint.offset_n", "0.6",
        "--motion.speed_mm_s", "40", "--disturbance.kind", "recording", "--disturbance.path", str(tmp_path / "s.csv"),
        "--disturbance.column", "force_n", "--disturbance.rate_hz", "1000", "--duration-s", "1.4", "--split-hz", "8",
    ).out  # fmt: skip
    assert ("disturbance_left" in said) and ("This loop rings" in said) is rings
    words = " ".join(said.split())
    assert ("no share to quote: the loop rings by itself" in words) is rings
    assert ("no shares to quote: the loop rings by itself" in words) is rings


@pytest.mark.parametrize(
    ("kp", "close", "alone"), [(0.02, False, False), (0.06, True, False), (0.1, True, False), (0.3, True, True)]
)
def test_a_loop_that_is_close_to_ringing_or_rings_when_moist_does_not_ring_by_itself(kp, close, alone):
    system = fl.bench().evolve({"controller.kp": kp, "controller.ki": 2.0, "disturbance": fl.Sine(amplitude_n=0.01)})
    found, run = of_system(system), fl.simulate(system, 0.5)
    assert (found is not None) is close and by_itself(run, run["scored"].values, found) is alone


def test_a_loop_that_its_clamp_keeps_swinging_rings_by_itself_though_it_is_stable():
    gains = {"controller.kp": 20.0, "setpoint": fl.Constant(offset_n=0.5), "disturbance": fl.Sine(amplitude_n=0.02)}
    system = fl.paper().evolve(gains)
    found, run = of_system(system), fl.simulate(system, 1.0)
    assert found is not None and found.stable
    assert by_itself(run, np.ones(run.sizes["time"], dtype=bool), found)
    told = {swings: " ".join(lines(found, fl.metrics(run), swings)) for swings in (True, False)}
    assert "This loop rings between the ends of its clamp, though a small change dies out, near" in told[True]
    assert "This loop is close to ringing, near" in told[False]


def test_a_run_says_one_thing_of_a_loop_that_its_clamp_keeps_swinging(frictionloop):
    said = frictionloop(
        "simulate", "--preset", "paper", "--controller.kp", "20", "--setpoint.kind", "constant",
        "--setpoint.offset_n", "0.5", "--duration-s", "1",
        "--disturbance.amplitude_n", "0.02", "--disturbance.offset_n", "0",
    ).out  # fmt: skip
    assert "the loop rings by itself" in said and "This loop rings between the ends of its clamp" in said
    assert "close to ringing" not in said and "nearly" not in said


def test_a_set_point_out_of_reach_clamps_a_loop_that_does_not_ring():
    asked = {"controller.kp": 0.045, "controller.ki": 2.0, "setpoint": fl.Sine(offset_n=0.9, amplitude_n=0.3)}
    system = fl.bench().evolve(asked | {"disturbance": fl.Sine(amplitude_n=0.01)})
    found, run = of_system(system), fl.simulate(system, 10.0)
    mask = run["scored"].values
    assert found is not None and found.stable and fl.saturation_index(run, mask) > CLAMPED
    assert not by_itself(run, mask, found)
