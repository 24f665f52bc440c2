"""Effects: closed forms, what mixing and placing mean, tables, triggers, and what is refused."""

from __future__ import annotations

import math

import numpy as np
import pytest
from effect_trees import TREES
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import frictionloop as fl
from frictionloop.quantities import FrictionloopError

R = fl.rendering
DT = 2e-4
BAND = (0.074, 0.8)


def played(effect, along, speed=20.0, load=0.5, band=BAND):
    player = R.Player(effect, band_n=band)
    along, speed, load = np.broadcast_arrays(along, speed, load)
    return np.array([player.tick(*map(float, each), DT) for each in zip(along, speed, load, strict=True)])


def asked(effect, x, **more):
    return effect.force_of(R.Touch(x_mm=np.asarray(x, float), **more))


def test_a_grating_at_constant_speed_is_a_sine_in_time_with_the_right_phase():
    speed, time = 80.0, np.arange(5000) * DT
    force = played(R.Grating(spacing_mm=2.0), speed * time - 40.0, speed)
    assert np.allclose(force, 0.45 + 0.15 * np.sin(2 * np.pi * (speed * time - 40.0) / 2.0), atol=5e-7, rtol=0)


def test_forth_and_back_agree_and_a_turn_makes_no_step():
    x = np.concatenate([np.linspace(-20, 20, 4001), np.linspace(20, -20, 4001)])
    for name in ("grating", "edge", "rough", "braille", "chirp", "gradient"):
        force = played(R.LIBRARY[name], x, np.repeat([20.0, -20.0], 4001))
        assert np.allclose(force[:4001], force[:4000:-1], atol=1e-12), name
        assert abs(force[4001] - force[4000]) < 1e-12


def test_the_direction_is_kept_at_rest():
    bump = R.LIBRARY["bump"]
    force = played(bump, -1.5, [20.0, 1.0, 0.0, -1.0, -3.0, -1.0, 0.0])
    assert len(set(force[:4])) == 1
    assert len(set(force[4:])) == 1
    assert force[0] - 0.45 == pytest.approx(0.45 - force[4])


def test_the_force_of_a_bump_integrates_to_its_height_times_the_load():
    bump = R.Ridge(height_mm=0.5, width_mm=6.0, load_n=0.5)
    x = np.linspace(-3.0, 0.0, 20001)
    assert np.trapezoid(asked(bump, x), x) == pytest.approx(0.5 * 0.5, rel=1e-7)
    assert np.trapezoid(asked(bump, -x, speed_mm_s=-1.0), x) == pytest.approx(0.5 * 0.5, rel=1e-7)
    assert np.all(asked(bump, [-4.0, 4.0]) == pytest.approx(0.0, abs=1e-15))


def test_a_map_turned_round_keeps_its_places_and_a_ridge_its_uphill():
    edge = R.Edge()
    assert asked(edge.rotate(180.0), 0.4) == pytest.approx(float(asked(edge, -0.4)))
    ridge = R.Ridge()
    assert asked(ridge.rotate(180.0), -1.0) == pytest.approx(float(asked(ridge, -1.0)))


def test_mixing_is_what_it_says():
    a, b, x = R.Grating(), R.Edge(), np.linspace(-3, 3, 101)
    assert np.allclose(asked(a + b, x), asked(a, x) + asked(b, x))
    assert np.allclose(asked(a * 0.5, x), 0.5 * asked(a, x))
    assert np.allclose(asked(a.max(b), x), np.maximum(asked(a, x), asked(b, x)))
    share = R.Edge(from_n=0.0, to_n=1.0)
    assert np.allclose(asked(a.mask(share, 0.2), x), asked(share, x) * asked(a, x) + (1 - asked(share, x)) * 0.2)
    assert np.allclose(asked(a.at(0.3), x), asked(a, x - 0.3))
    assert np.allclose(asked(a.scale(2.0, 3.0), x), 2 * asked(a, x / 3.0))
    assert np.allclose(asked(b.repeat(1.5), x), asked(b, np.mod(x, 1.5)))
    assert np.allclose(asked(b.repeat(1.5, 2), [-1.0, 2.9, 4.0]), asked(b, [-1.0, 1.4, 2.5]))
    assert (a + b + 0.1).of == (a, b, R.Constant(level_n=0.1))


def test_a_map_holds_or_repeats_beyond_its_edge():
    values = (0.1, 0.3, 0.2)
    hold = R.Map(values_n=values, pitch_mm=2.0, start_mm=1.0)
    assert np.allclose(asked(hold, [-9.0, 1.0, 2.0, 5.0, 90.0]), [0.1, 0.1, 0.2, 0.2, 0.2])
    again = R.Map(values_n=values, pitch_mm=2.0, start_mm=1.0, beyond="repeat")
    assert np.allclose(asked(again, [1.0, 6.0, 7.0, -5.0, 8.0]), [0.1, 0.15, 0.1, 0.1, 0.2])
    nearest = R.Map(values_n=values, pitch_mm=2.0, between="nearest")
    assert np.allclose(asked(nearest, [0.9, 1.1, 3.1]), [0.1, 0.3, 0.2])
    plane = R.Map(values_n=((0.0, 1.0), (2.0, 3.0)), pitch_mm=1.0)
    assert float(plane.force_of(R.Touch(x_mm=0.5, y_mm=0.25))) == pytest.approx(1.0)


def test_a_path_chooses_the_row_of_a_map():
    plane = R.Map(values_n=((0.2, 0.3), (0.4, 0.5)), pitch_mm=1.0)
    for y, wanted in ((0.0, 0.25), (0.5, 0.35), (1.0, 0.45)):
        player = R.Player(plane, R.Track(y_mm=y))
        assert player.tick(0.5, 20.0, 0.5, DT) == pytest.approx(wanted, abs=1e-4)
    across = R.Player(plane, R.Track(x_mm=0.5, heading_deg=90.0))
    assert across.tick(1.0, 20.0, 0.5, DT) == pytest.approx(0.45, abs=1e-4)


def test_what_is_asked_for_is_held_in_the_air_and_decided_at_landing():
    edge, x = R.Edge(), np.linspace(-5.0, 5.0, 101)
    force = played(edge, x, load=np.where((x > -2) & (x < 2), 0.0, 0.5))
    assert np.all(force[(x > -2) & (x < 2)] == force[0])
    assert force[-1] == pytest.approx(0.6)


def test_a_button_clicks_once_with_hysteresis_and_a_dead_time():
    load = np.concatenate([np.full(100, 0.4), np.full(200, 0.9), np.full(50, 0.6), np.full(200, 0.4)])
    force = played(R.LIBRARY["button"], 0.0, 0.0, load)
    assert force[50] == pytest.approx(0.55)
    assert force[100 + 25] == pytest.approx(0.3 - 0.15)  # 5 ms after the press: the click at its largest
    assert force[299] == force[320] == pytest.approx(0.3)
    assert force[350 + 25] == pytest.approx(0.55 + 0.08)
    assert force[-1] == pytest.approx(0.55)
    quick = R.Trigger(on_load_n=0.8, off_load_n=0.5, dead_s=0.01, then=R.Constant(level_n=0.3))
    force = played(quick, 0.0, 0.0, np.tile([0.4, 0.9], 200), band=(0.0, 1.0))
    changes = np.flatnonzero(np.diff(force))
    assert changes.size >= 7  # 400 periods hold 8 dead times of 50
    assert np.diff(changes).min() >= 49


def test_a_trigger_of_place_moves_with_what_it_is_part_of():
    effect = R.Trigger(on_x_mm=1.0, off_x_mm=0.0, then=R.Constant(level_n=0.6), otherwise=R.Constant(level_n=0.3))
    x = np.linspace(-10, 10, 2001)
    assert x[np.flatnonzero(np.diff(played(effect.at(5.0), x)))[0] + 1] == pytest.approx(6.0)
    with pytest.raises(FrictionloopError, match=r"trigger\.on_x_mm: must be crossed once"):
        R.Player(effect.repeat(4.0))


def test_a_wave_is_over_or_begins_anew():
    wave = R.Wave(values_n=(0.1, 0.3), rate_hz=10.0)
    assert np.allclose(wave.force_of(R.Touch(time_s=np.array([-0.1, 0.0, 0.05, 0.1, 0.2]))), [0, 0.1, 0.2, 0.3, 0])
    again = R.Wave(values_n=(0.1, 0.3), rate_hz=10.0, loops=True)
    assert np.allclose(again.force_of(R.Touch(time_s=np.array([0.15, 0.2, 0.25]))), [0.2, 0.1, 0.2])
    force = played(again, [0.0])  # from the first period on
    assert np.allclose(force[:1], 0.1)


def test_a_rough_texture_has_its_deviation_and_its_seed():
    texture, x = R.Texture(rms_n=0.05), np.linspace(0, 64, 4096, endpoint=False)
    assert np.std(asked(texture, x)) == pytest.approx(0.05, rel=1e-6)
    assert np.all(asked(texture, x) == asked(R.Texture(), x))
    assert np.any(asked(texture, x) != asked(R.Texture(seed=1), x))


def test_a_function_of_place_becomes_a_map_and_its_error_is_told():
    hidden = R.sampled(lambda x: 0.4 + 0.1 * np.sin(2 * np.pi * x / 0.1), 0.0, 20.0, 0.1)
    assert hidden.error_n > 0.06  # a period of one pitch is 0.4 N at each value and midway
    made = R.sampled(lambda x: 0.4 + 0.1 * np.sin(x), 0.0, 20.0, 0.1)
    assert made.error_n == pytest.approx(0.1 * 0.1**2 / 8, rel=0.01)
    x = np.linspace(0, 20, 1001)
    assert np.abs(asked(made.map, x) - (0.4 + 0.1 * np.sin(x))).max() <= made.error_n * 1.01


def test_a_patterns_place_does_not_depend_on_the_speed():
    for name in ("rough", "chirp", "detents"):
        forces = [
            played(R.LIBRARY[name], np.linspace(-20, 20, n), v)[:: (n - 1) // 100] for n, v in ((101, 150), (1001, 20))
        ]
        assert np.allclose(*forces, atol=1e-12), name


@settings(max_examples=150, deadline=None)
@given(TREES, st.integers(0, 2**31 - 1))
def test_any_effect_stays_in_the_band_and_is_a_number(effect, seed):
    rng = np.random.default_rng(seed)
    try:
        player = R.Player(effect, band_n=BAND)
    except FrictionloopError as error:
        assume("at most" in str(error))
        return
    for _ in range(60):
        force = player.tick(*rng.uniform([-150, -200, 0], [150, 200, 1.2]).tolist(), DT)
        assert BAND[0] <= force <= BAND[1]
        assert math.isfinite(player.clamped_n)


@settings(max_examples=100, deadline=None)
@given(TREES)
def test_any_effect_goes_through_a_file_unchanged(effect):
    import tomllib

    tree = tomllib.loads(R.to_toml(effect))
    tree.pop("schema")
    from frictionloop.rendering.effect_toml import effect_of

    assert effect_of(tree) == effect


@settings(max_examples=60, deadline=None)
@given(TREES.filter(lambda effect: effect.is_static), st.floats(-120, 120))
def test_the_table_of_a_still_effect_is_the_effect(effect, x):
    program = R.program_of(effect, R.Track(), 255.0)
    found = R.Player(effect, band_n=(-9.0, 9.0)).tick(x, 20.0, 0.5, DT)
    assert abs(found - float(asked(effect, x))) <= 4.0 * program.error_n + 2e-4
