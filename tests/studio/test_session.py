"""A live session under a clock of the test: interpolation, stalls, the finger that is gone."""

from __future__ import annotations

import numpy as np
import pytest
from live_engines import GRATING, Echo

from frictionloop.live.live_engines import CHANNELS, TwinEngine
from frictionloop.live.live_session import CATCH_UP_S, GONE_S, KEPT_S, SPARSE, Session
from frictionloop.live.pointer_motion import FASTEST_MM_S, LATE_S
from frictionloop.studio.live_numbers import TURNED_MM, numbers_of, slides

X, LOAD = 0, 1


def session(**engine):
    made = Session(Echo(**engine))
    made.ghost_on = False
    made.step(0.0)
    return made


def rows(blocks):
    return np.concatenate([block.rows for block in blocks], axis=1)


def drag(live, speed_mm_s, duration_s, hz=60.0):
    """Slide with a 60 Hz pointer whose page began its clock elsewhere; return the blocks."""
    blocks = []
    for k in range(round(duration_s * 200)):
        now_s = 0.005 * (k + 1)
        if round(now_s * 200) % round(200 / hz) == 0 or k == 0:
            live.touch(now_s, np.array([[1e3 * (now_s + 77.0), speed_mm_s * now_s, 0.0, np.nan]]))
        blocks += live.step(now_s)
    return blocks


def test_time_that_has_not_passed_gives_no_block_and_what_has_gives_all_of_it():
    live = session()
    assert live.step(0.0049) == []
    assert [block.first_tick for block in live.step(0.0151)] == [0, 25, 50]


def test_a_block_ends_where_the_finger_reaches_what_the_pointer_told():
    """The loop knows of an event a row of a frame after it could; without one, blocks end on their grid."""
    live, told = session(), []
    sent_s = 0.0072 + np.arange(30) / 60.0
    for k in range(600):
        now_s = 0.001 * (k + 1)
        for each in sent_s[(now_s - 0.001 < sent_s) & (sent_s <= now_s)]:
            live.touch(each, np.array([[1e3 * each, 0.0, 0.0, np.nan]]))
        told += [(block, now_s) for block in live.step(now_s)]
    ends = np.array([block.first_tick + block.rows.shape[1] for block, _ in told])
    assert [block.first_tick for block, _ in told[1:]] == list(ends[:-1])
    assert not (ends % SPARSE).any()
    assert set(np.arange(25, 3000, 25)) <= set(ends)
    for each in sent_s:
        first = next(end for (block, _), end in zip(told, ends, strict=True) if block.reached_ms >= 1e3 * each)
        assert -1e-9 <= first / 5000.0 - each - LATE_S <= SPARSE / 5000.0
    assert len(told) <= 120 + 30


def test_a_pointer_of_a_thousand_samples_a_second_ends_one_block_of_two():
    live, blocks = session(), []
    for k in range(300):
        live.touch(0.001 * k, np.array([[float(k), 0.0, 0.0, np.nan]]))
        blocks += live.step(0.001 * (k + 1))
    assert 60 < len(blocks) <= 2 * 60


def test_the_finger_moves_evenly_between_pointer_samples_and_one_of_them_late():
    told = rows(drag(session(), 40.0, 1.0))
    steps = np.diff(told[X].astype(float))[1500:]
    np.testing.assert_allclose(steps, 40.0 / 5000.0, rtol=0.05)
    late_s = 1.0 - told[X, -1] / 40.0
    assert late_s == pytest.approx(LATE_S, abs=0.003)


def test_the_load_of_a_pointer_without_pressure_is_the_sliders():
    live = session()
    live.load_n = 0.8
    assert rows(drag(live, 40.0, 0.3))[LOAD, -1] == pytest.approx(0.8)


def test_a_flick_is_followed_no_faster_than_the_position_sensor_can():
    live = session()
    told = rows(drag(live, 3000.0, 0.4))
    speed = np.diff(told[X].astype(float)[25:]) * 5000.0
    assert np.abs(speed).max() <= 1.01 * FASTEST_MM_S


def test_a_finger_whose_page_is_silent_leaves_the_plate():
    live = session()
    drag(live, 20.0, 0.5)
    still = rows(live.step(0.5 + 0.9 * GONE_S))
    gone = rows([*live.step(0.5 + 1.1 * GONE_S), *live.step(0.5 + 1.1 * GONE_S + 0.1)])
    assert still[LOAD, -1] == pytest.approx(0.5)
    assert gone[LOAD, -1] == 0.0


@pytest.mark.parametrize("every_s", [0.01, 0.2])
def test_a_page_that_was_stopped_moves_nothing_by_what_it_said_before(every_s):
    """What waited in a renderer that stood still comes late; the finger rests 0.3 s after it was heard."""
    live, page_ms = session(), np.arange(0.0, 2000.0, 1000.0 / 60.0)
    events = [np.array([[each, 1e-3 * each * 20.0, 0.0, 0.5]]) for each in page_ms]
    fresh, late = events[:30], events[30:]
    for event in fresh:
        live.touch(1e-3 * event[0, 0], event)
        live.step(1e-3 * event[0, 0])
    rest_s = 1e-3 * fresh[-1][0, 0] + 0.3
    live.step(rest_s)
    moved = []
    for number, event in enumerate(late):  # from 0.4 s on, one by one
        now_s = rest_s + 0.2 + number * every_s
        assert not live.touch(now_s, event) or now_s - 1e-3 * event[0, 0] <= GONE_S
        if now_s - 1e-3 * event[0, 0] > GONE_S:
            moved += live.step(now_s)
    assert moved and all(block.rows[LOAD].max() == 0.0 for block in moved)


def test_stop_lifts_the_finger_and_holds_the_ghost_until_go():
    live = session()
    live.ghost_on = True
    assert rows(live.step(0.3))[LOAD, -1] == pytest.approx(0.5)
    live.stop()
    assert rows(live.step(0.5))[LOAD, -1] == 0.0
    live.go()
    assert rows(live.step(0.7))[LOAD, -1] == pytest.approx(0.5)


def test_a_stall_is_made_good_for_half_a_second_and_the_rest_is_counted():
    live = session()
    told = rows(live.step(3.0))
    assert told.shape[1] == CATCH_UP_S * 5000
    assert live.dropped_s == pytest.approx(2.5)
    assert len(live.step(3.005)) == 1


def test_the_last_seconds_are_kept_in_order_and_no_more_than_thirty():
    live = session()
    for k in range(80):
        live.step(0.5 * (k + 1))
    kept = live.last()
    assert kept.shape == (len(CHANNELS), KEPT_S * 5000)
    assert live.last(0.01).shape == (len(CHANNELS), 50)


def test_the_ghost_goes_back_and_forth_at_its_speed():
    live = session()
    live.ghost_on = True
    told = np.concatenate([rows(live.step(0.25 * (k + 1))) for k in range(40)], axis=1)
    speed = np.abs(np.diff(told[X].astype(float))) * 5000.0
    assert np.median(speed) == pytest.approx(40.0, rel=0.01)
    assert told[X].min() < -30.0
    assert told[X].max() > 30.0
    assert np.abs(told[X]).max() < 45.0


@pytest.mark.slow
def test_on_a_grating_the_closed_loop_follows_and_the_open_one_does_not():
    """On the preset's finger, which the model does not know."""
    live = Session(TwinEngine(GRATING.evolve({"friction.nominal_n": 1.3})))
    for k in range(60):
        live.step(0.1 * (k + 1))
    told = numbers_of(live.last(4.0), 5000.0, 0.02)
    assert told["closed_error_n"] < 0.5 * told["open_error_n"]
    assert told["closed_r2"] > told["open_r2"]


def test_numbers_of_what_was_asked_for_are_perfect_and_of_a_resting_finger_none():
    rows = np.zeros((len(CHANNELS), 5000))
    rows[X] = np.linspace(0, 40, 5000)
    rows[LOAD] = 0.5
    names = list(CHANNELS)
    rows[names.index("floor_n")], rows[names.index("limit_n")] = 0.1, 0.55
    asked = 0.5 + 0.1 * np.sin(rows[X])
    for name in ("asked_n", "closed_n"):
        rows[names.index(name)] = asked
    rows[names.index("open_n")] = asked + 0.1
    told = numbers_of(rows, 5000.0, 0.02)
    assert told["closed_error_n"] == pytest.approx(0.0)
    assert told["closed_r2"] == pytest.approx(1.0)
    assert told["open_error_n"] == pytest.approx(0.1)
    assert told["open_contrast"] == pytest.approx(1.0)
    assert told["beyond"] == pytest.approx(1 / 3, abs=0.02)  # 0.1 sin x is above 0.05 for a third of its period
    rows[X] = 3.0
    assert numbers_of(rows, 5000.0, 0.02) == {}


def test_what_is_around_a_turn_or_a_landing_does_not_count_and_a_rest_is_no_turn():
    forth, back = np.linspace(0, 10, 2501)[1:], np.linspace(10, 0, 2501)[1:]
    rest = np.full(500, 5.0)
    x_mm = np.concatenate([forth[:1250], rest, forth[1250:], back])
    counts = slides(x_mm, np.full(x_mm.size, 0.5), 5000.0, 0.02)
    assert not counts[: int(250 * TURNED_MM) - 2].any()
    assert counts[int(250 * TURNED_MM) + 2 : 1245].all()
    assert not counts[1260:1740].any()
    near = int(250 * TURNED_MM)
    assert counts[1760 : 3000 - near - 2].all()
    assert not counts[3000 - near + 2 : 3000 + near - 2].any()
    assert counts[3000 + near + 2 : -2].all()
    lifted = slides(x_mm, np.where(np.arange(x_mm.size) < 400, 0.0, 0.5), 5000.0, 0.02)
    assert not lifted[: 400 + near - 2].any()
    assert lifted[400 + near + 2 : 1245].all()
    lifts = slides(x_mm, np.where(np.arange(x_mm.size) < 1200, 0.5, 0.0), 5000.0, 0.02)
    assert lifts[near + 2 : 1200 - near - 2].all()
    assert not lifts[1200 - near + 2 :].any()


def test_ringing_is_at_both_limits_and_a_plate_that_does_all_it_can_at_one():
    rows, names = np.zeros((len(CHANNELS), 10_000)), list(CHANNELS)
    rows[X], rows[LOAD] = np.linspace(0, 80, 10_000), 0.5
    rows[names.index("saturated")] = 1.0
    rows[names.index("closed_um")] = 2.5
    assert numbers_of(rows, 5000.0, 0.02)["swings"] == 0.0
    rows[names.index("closed_um"), ::2] = 0.1
    assert numbers_of(rows, 5000.0, 0.02)["swings"] == pytest.approx(0.5, abs=0.01)
    rows[names.index("saturated")] = 0.0
    assert numbers_of(rows, 5000.0, 0.02)["swings"] == 0.0


@pytest.mark.parametrize("late_s", [0.0, 0.004, 0.012])
def test_the_contrast_is_the_share_at_the_patterns_own_period_whatever_else_is_in_the_force(late_s):
    rows, names, k = np.zeros((len(CHANNELS), 10_000)), list(CHANNELS), np.arange(10_000)
    rows[X], rows[LOAD] = 80.0 * k / 10_000, 0.5
    turns = 2.0 * np.pi * rows[X] / 2.0  # 20 Hz
    rows[names.index("asked_n")] = 0.5 + 0.1 * np.sin(turns)
    other = 0.05 * np.random.default_rng(0).standard_normal(k.size) + 0.03 * np.sin(2 * np.pi * 7.0 * k / 5000)
    rows[names.index("closed_n")] = force = 0.6 + 0.07 * np.sin(turns - 40.0 * np.pi * late_s) + other
    told = numbers_of(rows.astype(np.float32), 5000.0, 0.02)
    count = slides(rows[X], rows[LOAD], 5000.0, 0.02)
    wave = np.exp(1j * turns[count])
    share = abs(np.mean((force[count] - force[count].mean()) * wave)) / abs(np.mean(0.1 * np.sin(turns[count]) * wave))
    assert told["closed_contrast"] == pytest.approx(share, rel=0.02)
    assert told["closed_contrast"] == pytest.approx(0.7, rel=0.03)


@pytest.mark.parametrize("other_s", [-50.0, 50.0])
def test_the_next_driving_page_has_a_clock_of_its_own(other_s):
    live = session()
    drag(live, 40.0, 0.5)
    live.leave()
    live.present(0.5)
    for k in range(100, 200):
        now_s = 0.005 * (k + 1)
        if k % 3 == 0:
            live.touch(now_s, np.array([[1e3 * (now_s + 77.0 + other_s), 40.0 * now_s, 0.0, np.nan]]))
        told = live.step(now_s)
    assert told[-1].rows[X, -1] / 40.0 == pytest.approx(now_s - LATE_S, abs=0.003)


def test_the_event_that_is_reached_is_told_by_the_very_time_that_its_page_gave():
    live, sent, told = session(), set(), set()
    rng = np.random.default_rng(0)
    for k in range(200):
        now_s = 0.005 * (k + 1)
        if k % 4 == 0:  # the way from the page takes now this long, now that
            sent.add(page_ms := 1e3 * (now_s - rng.uniform(0.0, 0.003)))
            live.touch(now_s, np.array([[page_ms, 0.0, 0.0, np.nan]]))
        told |= {block.reached_ms for block in live.step(now_s)}
    told = {each for each in told if not np.isnan(each)}
    assert told <= sent
    assert len(told) > 40


def test_a_block_is_due_when_the_step_that_makes_it_gives_it():
    live = session()
    for now_s in (0.0, 0.0031, 0.0049):
        assert now_s + live.due_s(now_s) == pytest.approx(0.005)
        assert live.step(now_s) == []
    assert len(live.step(0.005)) == 1
    assert live.due_s(0.005) == pytest.approx(0.005)
    assert live.due_s(0.2) == 0.0
