"""Effects in the C core: the same forces as the player in Python, nothing run that cannot be, one after the other."""

from __future__ import annotations

import zlib

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import frictionloop as fl
from frictionloop.control.lookup import LOOKUP_LAW
from frictionloop.device.simulated_boards import Sample
from frictionloop.firmware.compiled_core import host_library
from frictionloop.firmware.effect_tables import HEAD, STEP, TOLERANCE_N, effect_tables
from frictionloop.quantities.protocol_schema import schema
from frictionloop.rendering.effect_setpoint import EffectSource
from frictionloop.rendering.library import LIBRARY
from tests.helpers.effect_trees import TREES

R = fl.rendering
PARITY_N = 2e-4
"""From the simulator's tables, which have more values and no steps of 16 bits."""
SAME_N = 1e-9
BAND_N = (0.1, 0.9)
STEEP = ("square", "chirp", "slider", "rough", "rubber")
"""Effects of the library that a device has too few values for."""


def strokes(ticks: int, seed: int = 0) -> np.ndarray:
    """Return places (mm), speeds (m/s) and loads (N) of a finger that strokes, turns, presses and lifts."""
    rng, t = np.random.default_rng(seed), np.arange(ticks) / 5000
    along = 40 * np.sin(2 * np.pi * rng.uniform(0.5, 3) * t + rng.uniform(0, 6)) + 3 * np.sin(2 * np.pi * 17 * t)
    load = 0.5 + 0.6 * np.sin(2 * np.pi * rng.uniform(1, 5) * t + rng.uniform(0, 6))
    speed = np.gradient(along, t)
    return np.stack([along, speed * 1e-3, load], 1)


def in_c(words: np.ndarray, touches: np.ndarray) -> tuple[int, np.ndarray]:
    """Return the first word that is wrong, -1 for none, and the forces of the C core."""
    ffi, library = host_library(LOOKUP_LAW, 5000)
    words, touches = np.ascontiguousarray(words, np.int16), np.ascontiguousarray(touches, float)
    limits, out = np.array([0.02, *BAND_N]), np.zeros(len(touches))
    given = [ffi.from_buffer("double[]", each) for each in (touches, limits, out)]
    wrong = library.fl_host_effect(ffi.from_buffer("int16_t[]", words), len(words), len(touches), *given)
    return wrong, out


def in_python(program, touches: np.ndarray, off_mm: float = 0.0) -> np.ndarray:
    player, steps = R.Player.of(program, BAND_N), touches.tolist()
    return np.array([player.tick(x + off_mm, 1e3 * v, w, 2e-4) for x, v, w in steps])


@pytest.mark.parametrize("name", LIBRARY)
def test_every_effect_of_the_library_is_the_same_in_c(name):
    """Also against the tables of the simulator, where the device has room for them."""
    made = effect_tables(EffectSource(effect=LIBRARY[name]), 255.0)
    touches = strokes(1500)
    wrong, found = in_c(made.words, touches)
    assert wrong == -1
    np.testing.assert_allclose(found, in_python(made.program, touches), rtol=0, atol=SAME_N)
    assert bool(made.findings) == (name in STEEP)
    if name not in STEEP:
        full = in_python(EffectSource(effect=LIBRARY[name]).program(255.0), touches)
        np.testing.assert_allclose(found, full, rtol=0, atol=PARITY_N)


def fits(effect) -> bool:
    try:
        effect_tables(EffectSource(effect=effect), 255.0)
    except fl.FrictionloopError:
        return False
    return True


NEAR_MM = 1e-9
"""By how much rounding moves a place."""


def apart(made, touches: np.ndarray) -> np.ndarray:
    """Return how far C is from Python, N, wherever between two places 2 pm apart it is: a jump has both its ends."""
    wrong, found = in_c(made.words, touches)
    assert wrong == -1
    near = np.array([in_python(made.program, touches, off) for off in (-NEAR_MM, 0.0, NEAR_MM)])
    return np.maximum(np.maximum(found - near.max(0), near.min(0) - found), 0.0)


def matches(effect, seed: int, ticks: int) -> None:
    """Hold C to Python on the values that the words hold."""
    made = effect_tables(EffectSource(effect=effect), 255.0)
    assert np.max(apart(made, strokes(ticks, seed))) <= SAME_N


@pytest.mark.slow
@settings(max_examples=40, deadline=None)
@given(TREES, st.integers(0, 1000))
def test_random_trees_are_the_same_in_c(effect, seed):
    """Jumps, nearest tables and products too."""
    assume(fits(effect))
    matches(effect, seed, 150)


def test_jumps_nearest_tables_and_products_are_the_same_in_c():
    steps = R.Map(values_n=(0.2, 0.9, 0.4), pitch_mm=0.7, between="nearest", beyond="repeat")
    square = R.Grating(shape="square", spacing_mm=0.5, amplitude_n=0.5, offset_n=0.6)
    for number, effect in enumerate((steps, square, square * R.Detents(), steps.mask(square, square.at(0.1)))):
        matches(effect, number, 400)


def test_how_many_values_a_table_gets():
    few = effect_tables(EffectSource(effect=R.Grating()), 255.0)
    assert len(few.words) < 200
    assert few.error_n < 1.5 * TOLERANCE_N
    rough = R.Texture(longest_mm=2.0) + R.Wave(values_n=(0, 0.1, 0), rate_hz=9.0)
    many = effect_tables(EffectSource(effect=rough), 255.0)
    assert len(many.words) == 1024
    (coarser, *_) = many.findings
    assert coarser.code == "EFFECT-COARSER" and coarser.value < coarser.limit


def test_a_map_of_two_dimensions_gives_the_row_under_the_track():
    map_ = R.Map(values_n=((0.2, 0.4, 0.2), (0.6, 0.2, 0.3)), pitch_mm=10.0, start_mm=-10.0)
    for y_mm, wanted in ((0.0, (0.2, 0.4, 0.2)), (10.0, (0.6, 0.2, 0.3)), (5.0, (0.4, 0.3, 0.25))):
        made = effect_tables(EffectSource(effect=map_, track=R.Track(y_mm=y_mm)), 255.0)
        touches = np.array([[x, 0.01, 0.5] for x in (-10.0, 0.0, 10.0)])
        np.testing.assert_allclose(in_c(made.words, touches)[1], wanted, atol=PARITY_N)
        assert [(each.code, each.value) for each in made.findings] == [("EFFECT-ROW", 2)]


WRONG = {
    "what": 10, "repeats": 2, "nearest": 2, "first": 0, "count": 0, "per": -1.0, "start": np.nan, "scale": np.inf,
}  # fmt: skip


@pytest.mark.parametrize("field", WRONG)
def test_a_step_that_cannot_be_run_is_found(field):
    words = effect_tables(EffectSource(effect=R.Grating()), 255.0).words
    steps = words[HEAD : HEAD + STEP.itemsize // 2].copy().view(STEP)
    steps[field] = WRONG[field]
    spoilt = np.concatenate([words[:HEAD], steps.view(np.int16), words[HEAD + STEP.itemsize // 2 :]])
    assert in_c(words, strokes(3))[0] == -1
    assert in_c(spoilt, strokes(3))[0] == HEAD


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


def pin(rig, ticks: int) -> np.ndarray:
    """Return the share of the largest amplitude that the pin gives a plate under a finger that slides, each tick."""
    found = []
    for tick in range(ticks):
        if tick % 10 == 0:
            rig.ask("heartbeat")
        found.append(np.sin(np.pi * rig.tick(1).duty / 2**17))
    return np.array(found)


@pytest.mark.parametrize("mode", ["open", "closed"])
def test_another_effect_while_the_finger_slides_is_no_jump_at_the_pin(rig, mode: str):
    """No tick drives the plate up by half of its largest. Open loop, one step of the set-point is all that a tick adds:
    a^2 goes by at most ln(f/(f - step))/tau."""
    model, ticks = fl.bench().controller.model, schema()["protocol"]["rise_ticks"]
    near = 1 / 512  # of the arcsine's table, as in test_rise
    step = (model.nominal_n - model.floor_n) / (fl.bench().board.ramp_s * 5000)
    assert play(rig, R.Constant(level_n=0.9)) == "done"
    rig.mode(mode)
    before = pin(rig, 60)
    assert play(rig, R.Constant(level_n=0.2)) == "done"
    share = np.concatenate([before[-1:], pin(rig, 500)])
    assert np.max(np.diff(share)) <= 1 / ticks + near
    assert share[-1] > 0.7
    if mode == "open":
        force = model.nominal_n * np.exp(-model.susceptibility_per_um2 * (share[:-1] * model.max_amplitude_um) ** 2)
        most = np.log(force / (force - step)) / model.susceptibility_per_um2 / model.max_amplitude_um**2
        assert np.all(np.diff(share**2) <= 1.05 * most + 2 * near * share[1:])


def test_an_edge_of_an_effect_itself_rises_by_half_of_the_largest_at_most(rig):
    """It is not eased: what the effect contains is asked for at once, and only the pin's own limit holds it back."""
    ticks = schema()["protocol"]["rise_ticks"]
    edges = R.Map(values_n=(0.9, 0.1), pitch_mm=1.0, between="nearest", beyond="repeat")
    assert play(rig, edges) == "done"
    rig.mode("open")
    rises = np.diff(pin(rig, 1000))
    assert 0.9 / ticks < np.max(rises) <= 1 / ticks + 1 / 512


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
