"""The tracker held to every corner: where it is looked at, and what it is told."""

from __future__ import annotations

import json
from typing import NamedTuple

import pytest

import frictionloop as fl
from frictionloop.cli import main
from frictionloop.design import tracker_synthesis
from frictionloop.design.corners import corners
from frictionloop.design.learnt import conditions
from frictionloop.design.tracker_synthesis import held_tracker
from frictionloop.design.wanted import Wanted
from frictionloop.parameters.tracking import SCHEDULE, TrackerController

TRACKER = {"controller.kind": "tracker"}


def test_a_tracker_is_looked_at_on_both_contacts_and_at_two_speeds_with_the_contact_learnt():
    found = conditions(fl.bench().evolve(TRACKER))
    told = [(s.finger.contact, s.motion.speed_mm_s, s.controller.compliance_um_per_n) for s in found]
    # Bristles of 20 N/mm give way by 50 um a newton, a slider by nothing.
    assert told == [("dahl", 20.0, 50.0), ("dahl", 80.0, 50.0), ("slider", 20.0, 0.0), ("slider", 80.0, 0.0)]
    assert conditions(fl.bench()) == [fl.bench()]


@pytest.mark.soak
def test_a_law_that_is_known_once_has_the_margins_of_each_resonance():
    system = fl.bench().evolve(TRACKER | {"finger.contact": "slider"})
    some = [each for each in corners(system, {0.0: 1.7, 0.05: 2.0}) if each.stroke == ", contact slider, 20 mm/s"]
    for each in some[::5]:
        alone = conditions(system)[0].evolve({"sensor.resonance_hz": 145.0 * (1 + each.off)})
        there = fl.linearise(alone, force_n=each.loop.elements.force_n, occluded=each.loop.elements.occluded)
        assert each.margins.sensitivity_peak == pytest.approx(there.margins().sensitivity_peak, rel=1e-6)
    assert {each.off for each in some} == {-0.05, 0.0, 0.05}


class Corner(NamedTuple):
    """A corner of which only Ms is looked at."""

    off: float
    sensitivity_peak: float
    where: str = "somewhere"

    @property
    def excess(self) -> float:
        return self.sensitivity_peak / 1.7


@pytest.fixture
def peaks(monkeypatch):
    """Replace the margins: Ms - 1 is a multiple of the share of the gain that is tried."""

    def looked_at(factor):
        def found(system, limits):
            share = system.controller.schedule[3][0] / SCHEDULE[3][0]
            return [Corner(0.0, 1.0 + factor * share)]

        monkeypatch.setattr(tracker_synthesis, "corners", found)
        monkeypatch.setattr(tracker_synthesis, "_learning", lambda _: ())

    return looked_at


@pytest.mark.parametrize(("factor", "share"), [(0.6, 1.0), (0.75, 0.9), (0.95, 0.7)])
def test_the_gain_on_the_limit_is_the_largest_share_that_holds(peaks, factor, share):
    peaks(factor)
    schedule = held_tracker(fl.bench(), Wanted()).overrides["controller.schedule"]
    for row, default in zip(schedule, SCHEDULE, strict=True):
        assert row == pytest.approx((share * default[0], *default[1:]), rel=5e-4)  # four digits


def test_limits_that_no_share_keeps_are_told_with_where(peaks):
    peaks(1.5)
    with pytest.raises(fl.FrictionloopError, match=r"^sensitivity_peak = 1.7: .* gets to 2.05 at somewhere"):
        held_tracker(fl.bench(), Wanted())


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_a_designed_tracker_holds_is_simulated_and_exported(tmp_path, capsys, monkeypatch):
    """A device unlike the preset: other springs, believed and true, and a shorter delay."""
    monkeypatch.chdir(tmp_path)
    other = ("--sensor.resonance_hz", "150", "--controller.delay_s", "150e-6")
    with pytest.raises(SystemExit) as left:
        main(["design", "controller", "--law", "tracker", *other, "--out", "t.toml", "--json"])
    assert left.value.code == 0
    found, system = json.loads(capsys.readouterr().out), fl.read_toml("t.toml")
    assert isinstance(system.controller, TrackerController)
    assert system.controller.model.resonance_hz == 150.0
    assert system.controller.schedule[0][1:] == SCHEDULE[0][1:]
    assert len(found["margins"]) == 4 * 5 * 6
    for row in found["margins"]:
        assert row["sensitivity_peak"] <= {0: 1.7, 5: 2.0, 10: 2.6}[round(100 * abs(row["resonance_off"]))] * 1.001
    assert "experimental" in found["notes"][0] and "notch_pi" in found["notes"][0]
    run = fl.simulate(system, 4.0).sel(time=slice(1.0, None))
    plain = fl.simulate(system.evolve({"controller.kind": "lookup"}), 4.0).sel(time=slice(1.0, None))
    assert fl.rms_error(run) < 0.5 * fl.rms_error(plain)
    with pytest.raises(SystemExit) as left:
        main(["firmware", "export", "t.toml", "--out", "table"])
    assert left.value.code == 0
