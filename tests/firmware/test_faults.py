"""Each fault: when exactly it is raised, what it tells, that it brings the amplitude down and stays."""

from __future__ import annotations

import math
import zlib

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.device.simulated_boards import Sample
from frictionloop.firmware.parameter_words import firmware_words
from frictionloop.parameters.presets import RETUNED
from frictionloop.quantities.protocol_schema import parameter_words, schema

N_PER_COUNT = 5.0 / 2**16
LARGEST = 8.0
PATIENT = {
    "safety__stuck_ticks": 500_000,
    "safety__position_jump_m": LARGEST,
    "safety__load_jump_n": LARGEST,
}
"""Words of a board that takes no reading for stuck or for a jump."""


def faults(rig) -> list[tuple[str, int, float]]:
    """Return what the board told by itself: name, tick, value."""
    rig.listen()
    names = {number: name for name, number in schema()["faults"].items()}
    return [(names[m["fault"]], m["tick"], m["value"]) for m in rig.told if m.name == "fault"]


def closed(rig):
    rig.run(300)
    rig.mode("closed")
    return rig


def feed(rig, count: int, force: int, across: int = 0, jitter: int = 1) -> None:
    for _ in range(count):
        rig.tick(1, Sample(force + jitter * (rig.ticks % 3), across, 4 * rig.ticks, 3277))


@pytest.mark.parametrize("sign", [1, -1])
def test_force_out_of_range_for_the_ticks_of_its_word(make_rig, sign: int):
    rig = closed(make_rig(safety__force_ticks=7))
    outside = sign * 31458  # 0.96 * 32768 = 31457.28
    feed(rig, 6, outside, jitter=sign)
    feed(rig, 1, sign * 31455)  # within: the count begins anew
    feed(rig, 6, outside, jitter=sign)
    assert faults(rig) == []
    feed(rig, 1, outside, jitter=0)
    assert faults(rig) == [("force_range", rig.ticks, pytest.approx(outside * N_PER_COUNT))]


def test_a_converter_at_its_end_is_saturated_not_out_of_range(make_rig):
    for end in (32767, -32768):
        rig = closed(make_rig(safety__force_ticks=7))
        feed(rig, 6, end, jitter=0)
        assert faults(rig) == []
        feed(rig, 1, end, jitter=0)
        assert faults(rig) == [("sensor_saturated", rig.ticks, end)]


FULL_N = 32766 * N_PER_COUNT
"""A limit of the force that next to no reading is beyond."""


@pytest.mark.parametrize(
    ("reading", "limit", "fault"),
    [
        (32752, FULL_N, "sensor_saturated"),
        (-32753, FULL_N, "sensor_saturated"),
        (32751, FULL_N, "sensor_stuck"),
        (-32752, FULL_N, "sensor_stuck"),
        (31458, None, "force_range"),
        (31455, None, "sensor_stuck"),
    ],
)
def test_a_reading_that_is_too_large_is_not_stuck_however_soon_the_board_takes_one_for_it(
    make_rig, reading: int, limit: int | None, fault: str
):
    """A sensor of 12 bits, whose last code is 32752: four readings alike are looked for, and seven too large."""
    words = {} if limit is None else {"safety__force_limit_n": limit}
    rig = closed(make_rig(safety__force_ticks=7, safety__stuck_ticks=4, **words))
    feed(rig, 3 if fault == "sensor_stuck" else 6, reading, jitter=0)
    assert faults(rig) == []
    feed(rig, 1, reading, jitter=0)
    [(name, at, _)] = faults(rig)
    assert (name, at) == (fault, rig.ticks)


@pytest.mark.parametrize(
    ("limit", "sample"),
    [
        (None, lambda k: Sample(31457 + k % 2, 0, 4 * k, 3277)),  # its last bit goes across the limit
        (FULL_N, lambda k: Sample(32751 + (k % 4 == 0), 0, 4 * k, 3277)),  # across the end of 12 bits
        (None, lambda k: Sample(8000, 0, 4 * k, 32766 + (k % 4 == 0))),  # the load comes to its end now and then
    ],
)
def test_a_force_that_is_stuck_is_told_though_something_is_too_large_now_and_then(make_rig, limit, sample):
    words = {} if limit is None else {"safety__force_limit_n": limit}
    rig = closed(make_rig(**words))
    for _ in range(150):
        rig.tick(1, sample(rig.ticks))
    assert [name for name, *_ in faults(rig)] == ["sensor_stuck"]


def test_the_second_channel_counts_where_there_is_one(make_rig):
    rig = closed(make_rig(force__axes=2, force__n_per_count=[N_PER_COUNT] * 2, safety__force_ticks=7, **PATIENT))
    feed(rig, 7, 0, across=32752)  # the last code of 12 bits
    assert faults(rig) == [("sensor_saturated", rig.ticks, 32752)]
    rig = closed(make_rig(force__axes=2, force__n_per_count=[N_PER_COUNT, 0], safety__force_ticks=7))
    feed(rig, 7, 0, across=32767)
    assert faults(rig) == []


@pytest.mark.parametrize("end", [32767, -32768])
@pytest.mark.parametrize("channel", ["position", "load"])
def test_position_and_load_are_watched_as_well(make_rig, channel: str, end: int):
    def at(value: int) -> Sample:
        return Sample(8000 + rig.ticks % 3, 0, 4 * rig.ticks, 3277)._replace(**{channel: value})

    rig = closed(make_rig(safety__force_ticks=7, **PATIENT))
    rig.tick(6, at(end))
    rig.tick(12, at(end - (1 if end > 0 else -1)))  # short of it: twice as long, and nothing is left of the count
    rig.tick(6, at(end))
    assert faults(rig) == []
    rig.tick(1, at(end))
    assert faults(rig) == [("sensor_saturated", rig.ticks, end)]
    assert rig.reason("clear") == "still_at_fault"
    rig.tick()
    assert rig.reason("clear") == "done"


def test_a_converter_that_is_at_its_end_half_of_the_time_is_saturated_too(make_rig):
    rig = closed(make_rig(safety__force_ticks=7, **PATIENT))
    for _ in range(2):  # each tick at an end weighs two of 14, each other one takes one back
        feed(rig, 4, 32767, jitter=0)
        feed(rig, 4, 8000)
    feed(rig, 2, 32767, jitter=0)
    assert faults(rig) == []
    feed(rig, 1, 32767, jitter=0)
    assert faults(rig) == [("sensor_saturated", rig.ticks, 32767)]


@pytest.mark.parametrize(("channel", "gain"), [("position", "touch__m_per_count"), ("load", "touch__n_per_count")])
def test_a_channel_that_is_not_there_may_read_anything(make_rig, channel: str, gain: str):
    rig = closed(make_rig(safety__force_ticks=7, **{gain: 0}))
    for _ in range(20):
        rig.tick(1, rig.slides()._replace(**{channel: 32767}))
    assert faults(rig) == []
    assert rig.state == "closed"


def test_a_lifted_finger_is_no_fault_and_the_plate_goes_on(rig):
    closed(rig)
    before = rig.run(500).amplitude_um
    assert before > 0.5
    for _ in range(10):  # 1 s without load
        rig.run(500, Sample(rig.ticks % 3, 0, 4 * rig.ticks, 0))
    assert faults(rig) == []
    assert (rig.state, rig.drive.amplitude_um > 0.5) == ("closed", True)


def test_a_plate_that_nobody_touches_is_off_after_a_minute(rig):
    closed(rig)
    for _ in range(599):
        rig.run(500, Sample(rig.ticks % 3, 0, 0, 0))
    rig.run(300)  # a finger slides once more: the minute begins anew
    for _ in range(599):
        rig.run(500, Sample(rig.ticks % 3, 0, 0, 0))
    assert (rig.state, faults(rig)) == ("closed", [])
    rig.run(500, Sample(0, 0, 0, 0))
    assert [(name, value) for name, _, value in faults(rig)] == [("no_finger", 60.0)]
    rig.run(60)
    assert rig.drive.duty == 0
    assert rig.reason("clear") == "done"
    assert rig.mode("closed") == "done"
    assert rig.state == "closed"


def test_stuck_while_the_finger_slides(make_rig):
    rig = closed(make_rig(safety__stuck_ticks=50))
    for k in range(49):
        feed(rig, 1, 7000 + k % 2, jitter=0)
    assert faults(rig) == []
    feed(rig, 1, 7000, jitter=0)
    assert faults(rig) == [("sensor_stuck", rig.ticks, 7000)]


def test_a_finger_at_rest_leaves_the_reading_as_it_is(make_rig):
    rig = closed(make_rig(safety__stuck_ticks=50))
    for _ in range(10):  # 1 s; the tracked speed takes 0.05 s to be below that of sliding
        rig.run(500, Sample(rig.ticks % 3, 0, 4 * rig.ticks, 0))
    assert faults(rig) == []


def test_silence_of_more_than_200_ms(rig):
    closed(rig)
    rig.ask("heartbeat")
    rig.tick(1000)
    assert faults(rig) == []
    rig.tick(1)
    assert faults(rig) == [("host_silent", rig.ticks, pytest.approx(200.2))]


def test_silence_is_told_across_the_end_of_the_clock(rig):
    rig.now_us = 2**32 - 100_000 - 300 * 200
    closed(rig)
    rig.ask("heartbeat")
    rig.tick(1000)
    assert rig.now_us > 2**32
    assert faults(rig) == []
    rig.tick(1)
    assert [name for name, *_ in faults(rig)] == ["host_silent"]


def test_broken_frames_are_no_sign_of_life(rig):
    closed(rig)
    rig.ask("heartbeat")
    for _ in range(11):
        rig.tick(100)
        rig.board.receive(b"\x05\x0c\x01\x02\x03\x00", rig.now_us)
    assert [name for name, *_ in faults(rig)] == ["host_silent"]


def test_late_ticks_within_a_second(make_rig):
    rig = closed(make_rig(safety__overrun_ticks=3))
    rig.run(5000 - rig.ticks)  # the second ends
    for _ in range(2):
        rig.tick(1, late=True)
    rig.run(5000)
    for _ in range(2):
        rig.tick(1, late=True)
    assert faults(rig) == []
    rig.tick(1, late=True)
    assert faults(rig) == [("tick_overrun", rig.ticks, 3)]
    assert rig.reason("clear") == "still_at_fault"
    rig.run(5000)
    assert rig.reason("clear") == "done"
    assert rig.ask("statistics")["overruns"] == 5


def test_the_amplitude_goes_down_by_the_ramp_and_stays_down(rig):
    closed(rig)
    before = rig.run(500).amplitude_um
    assert before > 0.5
    ramp_um = 2.5 / 50  # 10 ms from the largest amplitude
    feed(rig, 24, 32767, jitter=0)
    at = rig.drive.amplitude_um
    steps = []
    while at > 0 and len(steps) < 100:
        feed(rig, 1, 32767, jitter=0)
        steps.append(at - rig.drive.amplitude_um)
        at = rig.drive.amplitude_um
    assert steps[:-1] == pytest.approx([ramp_um] * (len(steps) - 1), abs=1e-9)
    assert 0 < steps[-1] <= ramp_um + 1e-9
    assert rig.drive.duty == 0
    rig.run(1000)
    assert (rig.state, rig.drive.amplitude_um) == ("fault", 0.0)
    assert len(faults(rig)) == 1


def test_the_slowest_ramp_that_a_table_may_have_is_down_0_1_s_after_the_host_has_died(make_rig):
    slow = firmware_words(fl.bench().evolve({**RETUNED, "board.ramp_s": 0.1}))
    rig = closed(make_rig(drive__ramp_um=slow[parameter_words()["drive.ramp_um"].first]))
    rig.run(500)
    rig.ask("heartbeat")
    rig.tick(1000 + 250)
    assert (rig.state, rig.drive.duty > 0) == ("fault", True)
    rig.tick(251)
    assert rig.drive.duty == 0


def test_a_fault_is_told_once_with_the_tick_it_was_raised_and_the_first_one_stays(rig):
    closed(rig)
    feed(rig, 25, 32767, jitter=0)
    raised = rig.ticks
    rig.tick(1100)  # silence too
    assert faults(rig) == [("sensor_saturated", raised, 32767)]
    assert rig.fault == "sensor_saturated"


def test_clear_is_refused_while_the_sensor_is_at_its_end(rig):
    closed(rig)
    feed(rig, 25, 32767, jitter=0)
    assert rig.reason("clear") == "still_at_fault"
    assert rig.mode("closed") == "not_now"
    rig.tick()
    assert rig.reason("clear") == "done"
    rig.tick()
    assert (rig.state, rig.fault) == ("idle", "none")


def test_what_is_wrong_before_the_loop_is_on_stops_it_at_its_first_tick(rig):
    rig.run(300)
    feed(rig, 100, 32767, jitter=0)
    assert (rig.state, faults(rig)) == ("idle", [])
    assert rig.reason("mode", state=2) == "done"
    feed(rig, 1, 32767, jitter=0)
    assert rig.state == "fault"
    assert rig.drive.amplitude_um == 0.0


def test_three_jumps_not_two_of_which_one_is_forgotten_every_20_ms(make_rig):
    rig = closed(make_rig(safety__force_jump_n=0.45))
    feed(rig, 1, 8000)
    for _ in range(2):  # a spark: there and back
        feed(rig, 1, 16000)
        feed(rig, 200, 8000)
    assert faults(rig) == []
    for force in (16000, 8000, 16000, 8000):
        feed(rig, 1, force)
    assert [(name, value) for name, _, value in faults(rig)] == [("sensor_jumps", 1)]


@pytest.mark.parametrize("resonance_hz", [90.0, 145.0, 300.0])
def test_a_force_that_steps_and_stays_faster_than_the_springs_turn(rig, resonance_hz):
    """The limit is 2.1 (2 sin(w T/2))^2 of the range, at least a sixteenth."""
    words = firmware_words(fl.bench().evolve({**RETUNED, "sensor.resonance_hz": resonance_hz}))
    jump_n = words[parameter_words()["safety.force_jump_n"].first]
    limit = 32768 * max(2.1 * (2 * math.sin(math.pi * resonance_hz / 5000)) ** 2, 1 / 16)
    for step, told in ((0.95 * limit, []), (1.05 * limit, ["sensor_jumps"])):
        rig = closed(type(rig)(words, safety__force_jump_n=jump_n))
        feed(rig, 40, 8000 + round(step))
        assert [name for name, *_ in faults(rig)] == told


@pytest.mark.parametrize(
    ("force", "told"), [(30, True), (1100, True), (1500, False)]
)  # 0.2 of 0.5 N are 0.1 N, or 1311 counts
def test_no_friction_under_load_once_the_skin_has_turned(make_rig, force, told):
    rig = closed(make_rig(law__low_n=0.0, setpoint__hold_n=0.95))
    rig.run(2500)
    for k in range(2500):
        if k % 500 == 0:
            rig.ask("heartbeat")
        feed(rig, 1, force)
    assert [name for name, *_ in faults(rig)] == ["sensor_contrary"] * told


def test_a_force_without_load_for_15_ms(rig):
    closed(rig)
    lifted = Sample(8000, 0, 4 * rig.ticks, 0)
    rig.tick(74, lifted)
    feed(rig, 1, 8000)  # touched: the count begins anew
    rig.tick(75, lifted)
    assert faults(rig) == []
    rig.tick(1, lifted)
    assert faults(rig) == [("sensor_contrary", rig.ticks, 8000 * N_PER_COUNT)]


@pytest.mark.parametrize(("way_mm", "told"), [(9.0, False), (10.5, True)])
def test_a_force_along_the_motion_only_once_the_skin_has_turned(rig, way_mm: float, told: bool):
    closed(rig)
    rig.run(3000)
    top = 4 * rig.ticks
    for k in range(round(way_mm * 250)):  # back at 20 mm/s
        if k % 500 == 0:
            rig.ask("heartbeat")
        rig.tick(1, Sample(-4000 + rig.ticks % 3, 0, top - 4 * k, 3277))
    assert [name for name, *_ in faults(rig)] == ["sensor_contrary"] * told


def test_a_hum_is_no_fault_while_the_set_point_has_a_texture(make_rig):
    rig = closed(make_rig(setpoint__hold_n=0.5))
    rig.run(3000)
    points = np.rint(5000 + 2000 * np.sin(np.arange(100) * np.pi / 50)).astype("<i2")
    rig.ask("waveform", first=0, values=points)
    played = {"source": 1, "loops": 1, "count": 100, "step": 2**24, "start_um": 0}
    assert rig.reason("play", **played, crc=zlib.crc32(points.tobytes())) == "done"
    for k in range(600):
        if k % 500 == 0:
            rig.ask("heartbeat")
        rig.tick(1, Sample(round(8000 + 4000 * math.sin(k * math.pi / 50)), 0, 4 * rig.ticks, 3277))
    assert faults(rig) == []


@pytest.mark.parametrize("hz", [50.0, 60.0])
@pytest.mark.parametrize("share", [0.06, 0.12, 0.2])
def test_the_hum_that_a_bench_tolerates_is_its_share_of_the_range(make_rig, share: float, hz: float):
    """From peak to peak; told over whole periods of the springs, near half a period of the mains, it looks smaller."""
    words = firmware_words(fl.bench().evolve({**RETUNED, "board.hum_share": share}))
    limit = words[parameter_words()["safety.hum_n"].first]
    assert limit == pytest.approx(share * 2.5, rel=1e-6)
    seen = math.sin(math.pi * hz * 34 / 5000)
    for times, told in ((0.95 / seen, []), (1.05 / seen, ["sensor_hums"])):
        rig = closed(make_rig(safety__hum_n=limit))
        rig.run(3000)
        half = 0.5 * times * share * 2.5 / N_PER_COUNT
        for k in range(800):
            if k % 400 == 0:
                rig.ask("heartbeat")
            rig.tick(1, Sample(round(3000 + half * math.sin(2 * math.pi * hz * k / 5000)), 0, 4 * rig.ticks, 3277))
        assert [name for name, *_ in faults(rig)] == told
