"""The laws of "Beyond the paper": the notch is the one that the synthesis finds, and its loop is stable."""

from __future__ import annotations

import math

import pytest

import frictionloop as fl
from frictionloop.design.synthesis import design_controller
from frictionloop.design.tournament import EVALUATION_SEED, SMALL, margins, protocol
from frictionloop.report.beyond import LAWS, NOTCH, SPEED_MM_S

GAINS = [f"controller.{name}" for name in ("kp", "ki", "notch_hz", "notch_depth", "notch_width")]


@pytest.fixture(scope="module")
def finger():
    """The median of the capable fingers of the section, with the resonance that the bench says."""
    people = protocol.population(fl.bench(), SMALL, EVALUATION_SEED)
    found = protocol.median_finger(people, protocol.able(fl.bench(), people, SPEED_MM_S))
    return {path: value for path, value in found.items() if path != "sensor.resonance_hz"}


def peak(finger, contact, level_n, changes):
    at = protocol.Condition(SPEED_MM_S, contact, protocol.SINES[1])
    system = fl.bench().evolve({**protocol.overrides_of(at), **finger, **changes})
    found = margins.loop_at(system, level_n, 0.5 * (protocol.START_S + protocol.DURATION_S)).margins()
    assert found.stable == math.isfinite(found.sensitivity_peak)
    return found.sensitivity_peak


@pytest.mark.parametrize("contact", protocol.CONTACTS)
@pytest.mark.parametrize("level_n", protocol.LEVELS_N)
def test_the_notch_is_stable_around_its_levels(finger, contact, level_n):
    """Ms at most 2, its usual bound and that of the section's limit: a kind with another's gains has far more."""
    assert peak(finger, contact, level_n, LAWS[NOTCH](fl.bench())) <= 2.0


def test_the_kind_alone_keeps_gains_that_are_not_stable(finger):
    """Why the gains are named: the test above fails without them."""
    kind = {path: value for path, value in LAWS[NOTCH](fl.bench()).items() if path not in GAINS}
    assert peak(finger, "dahl", 0.6, kind) == math.inf


@pytest.mark.slow
def test_the_notch_is_what_its_synthesis_finds():
    own, found = LAWS[NOTCH](fl.bench()), design_controller(fl.bench(), "notch_pi").overrides
    assert own.keys() == found.keys()
    for path, value in found.items():  # kept to three digits: half of the last one is at most 0.5 %
        assert own[path] == (value if isinstance(value, (str, bool)) else pytest.approx(value, rel=5e-3))
