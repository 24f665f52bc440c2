"""Effects in the C core: the same forces as the player in Python, nothing run that cannot be, one after the other."""

from __future__ import annotations

import zlib

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import frictionloop as fl
from frictionloop.device.host_board import Sample
from frictionloop.firmware.compiled import host_library
from frictionloop.firmware.effect_pieces import TOLERANCE_N
from frictionloop.firmware.effect_tables import STEP, effect_tables
from frictionloop.quantities.schema import schema
from frictionloop.rendering.library import LIBRARY
from frictionloop.rendering.program import Do
from frictionloop.rendering.source import EffectSource
from tests.helpers.effect_trees import TREES

R = fl.rendering
PARITY_N = 2e-4
BAND_N = (0.1, 0.9)
STEEP = ("square", "chirp", "slider", "rough", "rubber")
"""Effects of the library that a device has too few values for."""


def strokes(ticks: int, seed: int = 0) -> np.ndarray:
    """Return places (2^-32 m), speeds and loads (2^-28) of a finger that strokes, turns, presses and lifts."""
    rng, t = np.random.default_rng(seed), np.arange(ticks) / 5000
    along = 40 * np.sin(2 * np.pi * rng.uniform(0.5, 3) * t + rng.uniform(0, 6)) + 3 * np.sin(2 * np.pi * 17 * t)
    load = 0.5 + 0.6 * np.sin(2 * np.pi * rng.uniform(1, 5) * t + rng.uniform(0, 6))
    speed = np.gradient(along, t)
    return np.rint(np.stack([along * 1e-3 * 2**32, speed * 1e-3 * 2**28, load * 2**28], 1)).astype(np.int32)


def in_c(words: np.ndarray, touches: np.ndarray) -> tuple[int, np.ndarray]:
    """Return the first word that is wrong, -1 for none, and the forces of the C core."""
    ffi, library = host_library()
    words, touches = np.ascontiguousarray(words, np.int16), np.ascontiguousarray(touches, np.int32)
    limits = np.rint(np.array([0.02, *BAND_N]) * 2**28).astype(np.int32)
    out = np.zeros(len(touches), np.int32)
    given = [ffi.from_buffer("int32_t[]", each) for each in (touches, limits, out)]
    wrong = library.fl_host_effect(ffi.from_buffer("int16_t[]", words), len(words), len(touches), *given)
    return wrong, out / 2**28


def in_python(program, touches: np.ndarray) -> np.ndarray:
    player = R.Player.of(program, BAND_N)
    return np.array([player.tick(x * 1e3 / 2**32, v * 1e3 / 2**28, w / 2**28, 2e-4) for x, v, w in touches.tolist()])


@pytest.mark.parametrize("name", LIBRARY)
def test_every_effect_of_the_library_is_the_same_in_c(name):
    """Also against the tables of the simulator, where the device has room for them."""
    made = effect_tables(EffectSource(effect=LIBRARY[name]), 255.0)
    touches = strokes(1500)
    wrong, found = in_c(made.words, touches)
    assert wrong == -1
    np.testing.assert_allclose(found, in_python(made.program, touches), rtol=0, atol=PARITY_N)
    assert bool(made.told) == (name in STEEP)
    if name not in STEEP:
        full = in_python(EffectSource(effect=LIBRARY[name]).program(255.0), touches)
        np.testing.assert_allclose(found, full, rtol=0, atol=PARITY_N)


def fits(effect) -> bool:
    try:
        effect_tables(EffectSource(effect=effect), 255.0)
    except fl.FrictionloopError:
        return False
    return True


@pytest.mark.slow
@settings(max_examples=15, deadline=None)
@given(TREES, st.integers(0, 1000))
def test_random_trees_are_the_same_in_c(effect, seed):
    """At a jump the places of C and Python, 0.1 nm apart, may lie on both sides: there one of the neighbours is met."""
    assume(fits(effect))
    made = effect_tables(EffectSource(effect=effect), 255.0)
    assume(not steps_of_force(made.program))
    touches = strokes(150, seed)
    wrong, found = in_c(made.words, touches)
    assert wrong == -1
    apart = np.abs(found - in_python(made.program, touches))
    assert np.max(apart) <= PARITY_N * max(1.0, largest(made.program))


def steps_of_force(program) -> bool:
    """Whether a table goes by more than 0.1 N from one value to the next, or takes the nearest."""
    for do, *numbers in program.code:
        if do > Do.WAVE:
            continue
        first, count = int(numbers[0]), int(numbers[1] + numbers[5 if do == Do.TABLE else 3])
        rise = np.max(np.abs(np.diff(program.values[first : first + count])))
        if (do == Do.TABLE and numbers[4]) or rise * (numbers[3] if do == Do.TABLE else 0.0) > 1e3:
            return True
    return False


def largest(program) -> float:
    """Return the product of all forces that may multiply each other."""
    return float(np.prod([max(1.0, np.max(np.abs(program.values)))] * len(program.code)))


def test_how_many_values_a_table_gets():
    few = effect_tables(EffectSource(effect=R.Grating()), 255.0)
    assert len(few.words) < 200
    assert few.error_n < 1.01 * TOLERANCE_N
    rough = R.Texture(longest_mm=2.0) + R.Wave(values_n=(0, 0.1, 0), rate_hz=9.0)
    many = effect_tables(EffectSource(effect=rough), 255.0)
    assert len(many.words) == 1024
    assert "values" in many.told[0]
    assert "mN" in many.told[0]


def test_a_map_of_two_dimensions_gives_the_row_under_the_track():
    map_ = R.Map(values_n=((0.2, 0.4, 0.2), (0.6, 0.2, 0.3)), pitch_mm=10.0, start_mm=-10.0)
    for y_mm, wanted in ((0.0, (0.2, 0.4, 0.2)), (10.0, (0.6, 0.2, 0.3)), (5.0, (0.4, 0.3, 0.25))):
        made = effect_tables(EffectSource(effect=map_, track=R.Track(y_mm=y_mm)), 255.0)
        touches = np.rint([[x * 1e-3 * 2**32, 2.7e6, 2**27] for x in (-10.0, 0.0, 10.0)])
        np.testing.assert_allclose(in_c(made.words, touches)[1], wanted, atol=PARITY_N)


WRONG = {
    "what": 10, "repeats": 2, "nearest": 2, "first": 0, "count": 0, "per": 1 << 30, "per_shift": 13, "scale_shift": 63,
}  # fmt: skip


@pytest.mark.parametrize("field", WRONG)
def test_a_step_that_cannot_be_run_is_found(field):
    words = effect_tables(EffectSource(effect=R.Grating()), 255.0).words
    steps = words[2 : 2 + STEP.itemsize // 2].copy().view(STEP)
    steps[field] = WRONG[field]
    spoilt = np.concatenate([words[:2], steps.view(np.int16), words[2 + STEP.itemsize // 2 :]])
    assert in_c(words, strokes(3))[0] == -1
    assert in_c(spoilt, strokes(3))[0] == 2


@pytest.mark.parametrize("effect", [R.Constant(level_n=9.0), R.Constant(level_n=5.0) * R.Viscous(per_speed_n_s_m=2.0)])
def test_a_force_that_fits_no_word_is_refused_in_a_line(effect):
    with pytest.raises(fl.FrictionloopError, match=r"^effect: asks for up to \d+ N; must be below 8 N to fit$"):
        effect_tables(EffectSource(effect=effect), 255.0)


def test_an_effect_of_too_many_steps_is_refused_in_a_line():
    parts = [R.Detents(spacing_mm=float(k)) for k in range(2, 8)]
    with pytest.raises(fl.FrictionloopError, match=r"^effect: is 23 steps for a device; at most 9"):
        effect_tables(EffectSource(effect=R.Sum(of=tuple(parts))), 255.0)


def play(rig, effect, position="measured", **changed) -> str:
    words = effect_tables(EffectSource(effect=effect, position=position), 255.0).words
    for first in range(0, len(words), 128):
        assert rig.reason("waveform", first=first, values=words[first : first + 128]) == "done"
    fields = {"source": schema()["sources"]["effect"], "loops": 0, "count": len(words), "step": 0, "start_um": 0}
    return rig.reason("play", **(fields | {"crc": zlib.crc32(words.astype("<i2").tobytes())} | changed))


def still(load: int = 3277) -> Sample:
    return Sample(8000, 0, 0, load)


def told(rig, ticks: int, sample=None) -> np.ndarray:
    """Run ticks with a host that is there, and return the set-points that they tell."""
    rig.told.clear()
    for _ in range(0, ticks, 10):
        rig.ask("heartbeat")
        rig.tick(10, sample)
    rig.listen()
    return rig.telemetry()["f_r"]


def test_one_effect_gives_way_to_another_by_small_steps(rig):
    rig.stream()
    assert play(rig, R.Constant(level_n=0.3)) == "done"
    assert rig.mode("closed") == "done"
    assert told(rig, 50)[-1] == pytest.approx(0.3, abs=1e-4)
    assert play(rig, R.Constant(level_n=0.6)) == "done"
    forces = told(rig, 500)
    model = fl.bench().controller.model
    step = (model.nominal_n - model.floor_n) / (fl.bench().board.ramp_s * 5000)
    assert 0.9 * step < np.max(np.diff(forces)) <= step + 1e-4
    assert forces[-1] == pytest.approx(0.6, abs=1e-4)


def test_a_broken_upload_changes_nothing(rig):
    rig.stream()
    assert play(rig, R.Constant(level_n=0.3)) == "done"
    rig.tick()
    assert play(rig, R.Constant(level_n=0.6), crc=1) == "wrong_crc"
    assert told(rig, 120)[-1] == pytest.approx(0.3, abs=1e-4)


def test_a_host_triggers(rig):
    rig.stream()
    assert rig.reason("trigger", number=255) == "not_now"
    wave = R.Wave(values_n=(0.2, 0.2), rate_hz=100.0)
    button = R.Trigger(on_load_n=0.8, off_load_n=0.2, then=R.Constant(level_n=0.3), otherwise=R.Constant(level_n=0.5))
    assert play(rig, wave + button) == "done"
    assert rig.reason("trigger", number=4) == "out_of_range"
    forces = told(rig, 100, still())
    assert forces[10] == pytest.approx(0.7, abs=1e-4)
    assert forces[-1] == pytest.approx(0.5, abs=1e-4)  # the wave took 10 ms
    assert rig.reason("trigger", number=0) == "done"
    assert told(rig, 120, still())[-1] == pytest.approx(0.3, abs=1e-4)
    assert rig.reason("trigger", number=255) == "done"
    forces = told(rig, 120, still())
    assert (forces.max(), forces[-1]) == (pytest.approx(0.5, abs=1e-4), pytest.approx(0.3, abs=1e-4))


def sliding(rig, position: str) -> float:
    """Return the set-point on a slope of 0.6 N/mm after 60 ms of sliding at 20 mm/s."""
    slope = R.Gradient(from_n=0.2, to_n=0.8, length_mm=1.0)
    assert play(rig, slope.at(-0.5), position) == "done"
    rig.stream()
    assert rig.mode("closed") == "done"
    rig.told.clear()
    for tick in range(300):
        if tick % 100 == 0:
            rig.ask("heartbeat")
        place_m = -0.5e-3 + 0.02 * tick / 5000 - 0.7e-3
        rig.tick(1, Sample(8000, 0, round(place_m / fl.bench().board.position_m_per_count), 3277))
    rig.listen()
    return float(rig.telemetry()["f_r"][-1])


def test_the_predicted_place_leads_by_the_delay(make_rig):
    """It is 6 um ahead of the tracked place at 20 mm/s: delay and half a period, times the speed."""
    apart = sliding(make_rig(), "predicted") - sliding(make_rig(), "measured")
    assert apart == pytest.approx(600 * 0.02 * (fl.bench().controller.delay_s + 1e-4), abs=PARITY_N)
