"""The laws of "Beyond the paper": the notch's loop is stable, and what is stored is what is found."""

from __future__ import annotations

import math

import pytest

from frictionloop.design.comparison import EVALUATION_SEED, SMALL, law_margins, trial_protocol
from frictionloop.report.control_law_study import NOTCH, ORACLE, PRINTED, stored
from frictionloop.report.paper_protocol import the_bench
from studies import beyond
from studies.beyond import LAWS, SPEED_MM_S, race

GAINS = [f"controller.{name}" for name in ("kp", "ki", "notch_hz", "notch_depth", "notch_width")]


@pytest.fixture(scope="module")
def finger():
    """The median of the capable fingers of the section, with the resonance that the bench says."""
    people = trial_protocol.population(the_bench(), SMALL, EVALUATION_SEED)
    found = trial_protocol.median_finger(people, trial_protocol.able(the_bench(), people, SPEED_MM_S))
    return {path: value for path, value in found.items() if path != "sensor.resonance_hz"}


def peak(finger, length_um, level_n, changes):
    at = trial_protocol.Condition(SPEED_MM_S, length_um, trial_protocol.SINES[1])
    system = the_bench().evolve({**trial_protocol.overrides_of(at), **finger, **changes})
    found = law_margins.loop_at(system, level_n, 0.5 * (trial_protocol.START_S + trial_protocol.DURATION_S)).margins()
    assert found.stable == math.isfinite(found.sensitivity_peak)
    return found.sensitivity_peak


@pytest.fixture(scope="module")
def notch():
    return LAWS[NOTCH](the_bench())


@pytest.mark.parametrize("length_um", [30.0, 0.0])
@pytest.mark.parametrize("level_n", trial_protocol.LEVELS_N)
def test_the_notch_is_stable_around_its_levels(finger, notch, length_um, level_n):
    """Ms at most 2, its usual bound and that of the section's limit."""
    assert peak(finger, length_um, level_n, notch) <= 2.0


@pytest.mark.timeout(900)
@pytest.mark.parametrize(
    "laws", [[NOTCH, ORACLE], pytest.param([*LAWS], marks=pytest.mark.soak)], ids=["two laws", "all laws"]
)
def test_what_is_stored_is_what_is_found(laws, notch, monkeypatch):
    """But of the printed gains, whose loop is chaotic; the limit beside the laws with all of them alone."""
    monkeypatch.setattr(beyond, "LAWS", {law: LAWS[law] for law in laws} | {NOTCH: lambda bench: notch})
    if len(laws) < len(LAWS):
        monkeypatch.setattr(beyond, "_limits_n", lambda finger: stored().limit_n)
    found, _ = race()
    assert {float(z): limit for z, limit in found["limit_n"].items()} == pytest.approx(stored().limit_n, rel=0.01)
    for law, there in found["laws"].items():
        for length_um in (30.0, 0.0) if law != PRINTED else ():
            for score, values in there[f"{length_um:g}"]["scores"].items():
                kept = stored().cells[law, length_um]["scores"][score]
                assert [float(each) for each in values] == pytest.approx([float(each) for each in kept], rel=0.01)
