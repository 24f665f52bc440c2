"""What is told of a changed Fig. 5a besides its numbers."""

from __future__ import annotations

import pytest

from frictionloop.report import protocol
from frictionloop.report.changed_told import told
from frictionloop.report.device import OPEN, RETUNED_GAINS

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
