"""The set-point table against numpy.interp, over time and over position."""

from __future__ import annotations

import zlib
from typing import Any

import numpy as np
import pytest

from frictionloop.device.simulated_boards import Sample
from frictionloop.quantities.protocol_schema import schema

SOURCES = schema()["sources"]
STEP = 2.0**24
ROUNDED = 0.5e-4 + 1e-8
"""Half a unit of the telemetry, and the firmware's own rounding."""


def upload(rig, points: np.ndarray) -> int:
    """Write a table into the copy that waits and return its CRC."""
    for first in range(0, len(points), 128):
        assert rig.reason("waveform", first=first, values=points[first : first + 128]) == "done"
    return zlib.crc32(points.astype("<i2").tobytes())


def play(rig, points: np.ndarray, **changed: Any) -> str:
    fields = {"source": SOURCES["time"], "loops": 0, "count": len(points), "step": 1 << 24, "start_um": 0}
    return rig.reason("play", **(fields | {"crc": upload(rig, points)} | changed))


def told(rig, ticks: int, samples: Any = None) -> np.ndarray:
    """Run ticks and return the set-point that they tell."""
    rig.told.clear()
    for k in range(ticks):
        rig.tick(1, samples(k) if samples else None)
        if k % 16 == 15:
            rig.listen()
    rig.ask("stream", decimation=0, mask=0)
    return rig.telemetry()["f_r"]


@pytest.fixture
def points() -> np.ndarray:
    return np.random.default_rng(0).integers(-32768, 32768, 300)


@pytest.mark.parametrize("step", [1 << 24, 3_456_789, 70_000_000, 123])
def test_over_time_it_stays_at_the_last_point(rig, points, step: int):
    rig.stream()
    assert play(rig, points, step=step) == "done"
    found = told(rig, 400)
    wanted = np.interp(np.arange(400) * (step / STEP), np.arange(len(points)), points * 1e-4)
    np.testing.assert_allclose(found, wanted, rtol=0, atol=ROUNDED)


@pytest.mark.parametrize("step", [1 << 24, 3_456_789, 70_000_000])
def test_over_time_it_loops(rig, points, step: int):
    rig.stream()
    assert play(rig, points, step=step, loops=1) == "done"
    found = told(rig, 700)
    wanted = np.interp(np.arange(700) * (step / STEP), np.arange(len(points)), points * 1e-4, period=len(points))
    np.testing.assert_allclose(found, wanted, rtol=0, atol=ROUNDED)


@pytest.mark.parametrize("loops", [0, 1])
def test_over_position(rig, points, loops: int):
    rig.stream()
    per_um, start_um = 0.013, -5000
    step = round(per_um * STEP)
    assert play(rig, points, source=SOURCES["position"], step=step, start_um=start_um, loops=loops) == "done"
    places_um = np.random.default_rng(1).integers(-100_000, 100_000, 500)
    found = told(rig, 500, lambda k: Sample(8000, 0, int(places_um[k]), 3277))
    along = (places_um - start_um) * (step / STEP)
    period = len(points) if loops else None
    wanted = np.interp(along, np.arange(len(points)), points * 1e-4, period=period)
    np.testing.assert_allclose(found, wanted, rtol=0, atol=ROUNDED)


def test_all_points_fit(rig):
    points = np.arange(1024) * 7 - 7000
    rig.stream()
    assert play(rig, points) == "done"
    np.testing.assert_allclose(told(rig, 1076), 1e-4 * np.append(points, [points[-1]] * 52), rtol=0, atol=ROUNDED)


def test_held_until_a_table_plays_and_again_after_it(make_rig, points):
    rig = make_rig(setpoint__hold_n=0.7)
    rig.stream()
    assert told(rig, 32) == pytest.approx(0.7, abs=ROUNDED)
    assert play(rig, points) == "done"
    rig.stream()
    assert told(rig, 1) == pytest.approx(points[0] * 1e-4, abs=ROUNDED)
    assert rig.reason("play", source=0, loops=0, count=0, step=0, start_um=0, crc=0) == "done"
    rig.stream()
    assert told(rig, 1) == pytest.approx(0.7, abs=ROUNDED)


def test_a_table_that_waits_changes_nothing_and_can_be_changed_in_part(rig, points):
    rig.stream()
    assert play(rig, points) == "done"
    rig.tick()
    changed = points.copy()
    changed[40:50] = 123
    assert rig.reason("waveform", first=40, values=changed[40:50]) == "done"
    found = told(rig, 60)
    np.testing.assert_allclose(found, points[:61] * 1e-4, rtol=0, atol=ROUNDED)
    assert rig.reason("play", source=1, loops=0, count=300, step=1 << 24, start_um=0,
                      crc=zlib.crc32(changed.astype("<i2").tobytes())) == "done"  # fmt: skip
    rig.stream()
    np.testing.assert_allclose(told(rig, 60), changed[:60] * 1e-4, rtol=0, atol=ROUNDED)


@pytest.mark.parametrize(
    ("wrong", "reason"),
    [
        ({"crc": 1}, "wrong_crc"),
        ({"count": 299}, "wrong_crc"),
        ({"count": 0}, "out_of_range"),
        ({"count": 2049}, "out_of_range"),
        ({"source": 3}, "out_of_range"),
        ({"loops": 2}, "out_of_range"),
        ({"start_um": 2_000_000_001}, "out_of_range"),
        ({"loops": 1, "count": 100, "step": (100 << 24) + 1}, "out_of_range"),
    ],
)
def test_what_is_refused_does_not_play(rig, points, wrong: dict[str, int], reason: str):
    rig.stream()
    assert play(rig, points, **wrong) == reason
    assert told(rig, 1) == pytest.approx(0.6, abs=ROUNDED)


def test_points_beyond_the_table_are_refused_by_index(rig):
    answer = rig.ask("waveform", first=1016, values=np.zeros(9, int))
    assert (answer.name, answer["reason"], answer["index"]) == ("refused", 5, 1024)


def test_a_loop_that_goes_on_begins_its_table_and_one_that_closes_goes_on(rig, points):
    """From idle to open the first point; from open to closed the next."""
    states = schema()["states"]
    rig.stream()
    assert play(rig, points) == "done"
    rig.tick(100)
    assert rig.reason("mode", state=states["open"]) == "done"
    np.testing.assert_allclose(told(rig, 50)[-50:], points[:50] * 1e-4, rtol=0, atol=ROUNDED)
    rig.stream()
    assert rig.reason("mode", state=states["closed"]) == "done"
    np.testing.assert_allclose(told(rig, 50)[-50:], points[50:100] * 1e-4, rtol=0, atol=ROUNDED)
