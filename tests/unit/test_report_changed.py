"""What is told of a changed Fig. 5a besides its numbers."""

from __future__ import annotations

import pytest

from frictionloop.report import protocol
from frictionloop.report.changed_told import told
from frictionloop.report.device import IDEAL, OPEN, PRINTED, RETUNED_GAINS

ROWS = (OPEN, RETUNED_GAINS)


@pytest.fixture(scope="module")
def base():
    return protocol.finger_system(protocol.population()[0])


@pytest.mark.parametrize(("slope", "does"), [(-0.12, "falls"), (0.05, "rises")])
def test_a_changed_speed_tells_how_friction_goes_with_speed(base, slope, does):
    sloped = base.evolve({"friction.speed_slope": slope})
    (line,) = told({"motion.speed_mm_s": 40.0}, sloped, ROWS)
    assert line == (
        f"this finger's friction {does} with speed, friction.speed_slope = {slope}: the open loop changes with it"
    )
    (line,) = told({"motion.speed_mm_s": 40.0}, sloped, ("printed gains",))
    assert "open loop" not in line


def test_friction_that_does_not_depend_on_speed_and_a_speed_that_stays_tell_nothing(base):
    assert told({"motion.speed_mm_s": 40.0}, base.evolve({"friction.speed_slope": 0.0}), ROWS) == []
    assert told({"motion.speed_mm_s": base.motion.speed_mm_s}, base, ROWS) == []
    assert told({"plate.q": 100.0}, base, ROWS) == []


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"controller.delay_s": 1e-3}, "controller.delay_s = 0.001, with half a period of hold: 1.1 ms in all"),
        ({"controller.rate_hz": 2e3}, "controller.delay_s = 0.0002, with half a period of hold: 0.45 ms in all"),
    ],
)
def test_a_changed_delay_or_rate_tells_the_delay_with_the_hold(base, changes, said):
    assert told(changes, base, ROWS) == [said]
    same = {"controller.delay_s": base.controller.delay_s, "controller.rate_hz": base.controller.rate_hz}
    assert told(same, base, ROWS) == []


def test_a_change_that_the_ideal_sensor_takes_away_again_is_named(base):
    changes = {"sensor.resonance_hz": 200.0, "plate.q": 100.0, "controller.delay_s": 9e-4}
    assert told(changes, base, (PRINTED, IDEAL))[1:] == [
        'sensor.resonance_hz and controller.delay_s do not reach "ideal sensor, no delay"'
    ]
    assert told({"controller.delay_s": 9e-4}, base, (PRINTED, IDEAL))[1].startswith("controller.delay_s does not reach")
    assert told({"plate.q": 100.0}, base, (PRINTED, IDEAL)) == told({"sensor.q": 5.0}, base, ROWS) == []
    other_kind = {"sensor.kind": "lowpass", "sensor.noise_rms_n": 1e-4}
    assert told(other_kind, base, (PRINTED, IDEAL)) == ['sensor.kind does not reach "ideal sensor, no delay"']


def test_what_the_finger_had_in_place_of_a_change_is_told(base):
    own = base.evolve({"motion.load_n": 0.67})
    assert told({"motion.load_n": 0.8}, own, ROWS) == [
        "this finger's own, which the change replaces: motion.load_n = 0.67 N"
    ]
