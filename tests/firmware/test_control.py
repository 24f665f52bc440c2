"""The tick as a whole: open loop inverts the friction law, closing has no bump, idle goes down by the ramp."""

from __future__ import annotations

import math

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.device.simulated_boards import Sample
from frictionloop.firmware.parameter_words import firmware_words
from frictionloop.quantities.protocol_schema import schema

MODEL = fl.bench().controller.model
RISE_TICKS = schema()["protocol"]["rise_ticks"]


def force(amplitude_um: float) -> float:
    """g of the controller's model."""
    return MODEL.nominal_n * math.exp(-MODEL.susceptibility_per_um2 * amplitude_um**2)


def amplitude(force_n: float) -> float:
    return math.sqrt(math.log(MODEL.nominal_n / force_n) / MODEL.susceptibility_per_um2)


def counts(force_n: float) -> int:
    return round(force_n * 2**16 / 5)


@pytest.mark.parametrize("level_n", [0.2, 0.45, 0.6, 0.9, 0.949])
def test_open_loop_commands_what_the_model_says(make_rig, level_n: float):
    rig = make_rig(setpoint__hold_n=level_n)
    rig.mode("open")
    assert force(rig.tick(RISE_TICKS).amplitude_um) == pytest.approx(level_n, abs=2e-4)


@pytest.mark.parametrize(("level_n", "at"), [(0.0, 2.5), (2.0, 0.0)])
def test_open_loop_stays_within_the_clamp(make_rig, level_n: float, at: float):
    rig = make_rig(setpoint__hold_n=level_n)
    rig.mode("open")
    assert rig.tick(RISE_TICKS).amplitude_um == pytest.approx(at, abs=1e-3)


def test_duty_gives_the_amplitude_through_the_sine_of_the_carrier(make_rig):
    worst = 0.0
    for level_n in np.linspace(0.09, 0.94, 60):
        rig = make_rig(setpoint__hold_n=level_n)
        rig.mode("open")
        drive = rig.tick()
        worst = max(worst, abs(2.5 * math.sin(math.pi * drive.duty / 2**17) - drive.amplitude_um))
    # In the last cell arcsin(1 - x) = pi/2 - sqrt(2 x), and linear interpolation gives 1 - 256 x^2 instead of 1 - x:
    # at most 1/1024 off. A step of the duty is 2.5 um pi 2^-17 = 6e-5 um.
    assert worst < 2.5 / 1024 + 1e-4


def slides(rig, force_n: float) -> Sample:
    return Sample(counts(force_n) + rig.ticks % 3, 0, 4 * rig.ticks, 3277)


def system(kind: str, **changed: object) -> fl.System:
    """Return the bench with a law's own default gains, but for some."""
    controller = {"kind": kind, "delay_s": 200e-6, "model": MODEL.model_dump(), **changed}
    return fl.System.model_validate(fl.bench().model_dump() | {"controller": controller})


LAWS = {
    "printed gains": fl.bench(),
    "retuned": fl.bench().evolve({"controller.kp": 0.062, "controller.ki": 134.0}),
    "no proportional part": fl.bench().evolve({"controller.kp": 0.0, "controller.ki": 500.0}),
    "lookup": system("lookup"),
    "notch": system("notch_pi"),
    "feed-forward": system("notch_pi", feedforward=True),
    "limit observer": system("limit_observer"),
}


@pytest.mark.parametrize("case", LAWS)
@pytest.mark.parametrize("before", ["idle", "open"])
@pytest.mark.parametrize("measured_n", [0.2, 0.6, 0.95])
def test_closing_begins_with_at_most_what_the_set_point_asks(make_rig, case: str, before: str, measured_n: float):
    """And in the first 0.1 s it is never beyond the straight line down from there."""
    rig = make_rig(overdrive__decay=0, overdrive__inverse=1)
    rig = type(rig)(firmware_words(LAWS[case]), overdrive__decay=0, overdrive__inverse=1, safety__force_jump_n=8.0)
    rig.run(300)
    rig.mode(before)
    for _ in range(200):
        rig.tick(1, slides(rig, measured_n))
    asked_um = amplitude(0.6)
    assert rig.reason("mode", state=2) == "done"
    path = [rig.tick(1, slides(rig, measured_n)).amplitude_um for _ in range(512)]
    assert path[0] <= asked_um + 1e-4
    line = 0.6 - (0.6 - MODEL.floor_n) * np.arange(512) / 512
    assert np.all(np.array([force(a) for a in path]) >= line - 2e-4)


def test_closing_from_open_goes_on_where_it_was_when_the_force_is_right(rig):
    rig.run(300)
    rig.mode("open")
    opened = rig.tick(1, slides(rig, 0.6)).amplitude_um
    rig.reason("mode", state=2)
    path = [rig.tick(1, slides(rig, 0.6)).amplitude_um for _ in range(50)]
    # A count is 76 uN, which the integral takes up: 134/s * 76 uN * 10 ms.
    assert path == pytest.approx([opened] * 50, abs=5e-4)
    rig.reason("mode", state=1)
    assert rig.tick(1, slides(rig, 0.6)).amplitude_um == opened


def test_closing_again_does_not_begin_the_law_anew(rig):
    rig.run(300)
    rig.mode("closed")
    rig.run(1000)
    before = rig.drive.amplitude_um
    assert rig.mode("closed") == "done"
    assert rig.drive.amplitude_um == pytest.approx(before, abs=1e-3)
    assert before != pytest.approx(amplitude(0.6), abs=0.05)


def test_to_idle_by_the_ramp(rig):
    rig.mode("open")
    start = rig.tick().amplitude_um
    rig.reason("mode", state=0)
    path = [rig.tick().amplitude_um for _ in range(40)]
    wanted = np.maximum(start - 2.5 / 50 * np.arange(1, 41), 0)
    np.testing.assert_allclose(path, wanted, rtol=0, atol=1e-12)


def test_two_axes_give_the_magnitude(make_rig):
    rig = make_rig(force__axes=2, force__n_per_count=[5 / 2**16] * 2, force__zero_counts=[100, -50])
    rig.stream()
    rng = np.random.default_rng(0)
    pairs = rng.integers(-20_000, 20_000, (16, 2))
    for x, y in pairs:
        rig.tick(1, Sample(int(x), int(y), 0, 0))
    wanted = np.hypot(pairs[:, 0] - 100, pairs[:, 1] + 50) * 5 / 2**16
    np.testing.assert_allclose(rig.telemetry()["f_m"], wanted, rtol=0, atol=0.51e-4)


def test_one_axis_keeps_its_sign(make_rig):
    rig = make_rig(force__zero_counts=[100, 0])
    rig.stream()
    rig.tick(16, Sample(-5000, 7000, 0, 0))
    assert rig.telemetry()["f_m"] == pytest.approx(-5100 * 5 / 2**16, abs=0.51e-4)
