"""The tracker held to every corner: where it is looked at, and how often its rows are tuned."""

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
from frictionloop.design.tracker_tuning import TrackerTuning
from frictionloop.design.wanted import Wanted
from frictionloop.parameters.tracking import PLACES, SCHEDULE, TrackerController

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
        assert each.sensitivity_peak == pytest.approx(there.margins().sensitivity_peak, rel=1e-6)
    assert {each.off for each in some} == {-0.05, 0.0, 0.05}


class Corner(NamedTuple):
    """A corner of which only Ms is looked at."""

    off: float
    limit: float
    sensitivity_peak: float
    where: str = "somewhere"

    @property
    def excess(self) -> float:
        return self.sensitivity_peak / self.limit


@pytest.fixture
def rows(monkeypatch):
    """Replace the search: between its rows Ms - 1 is larger by a factor than what the rows were asked for."""
    asked = []

    def tuner(factor, least=0.0):
        def tune(system, limits, progress):
            asked.append(dict(limits))
            if limits[0.0] - 1.0 < least:
                raise fl.FrictionloopError(f"limits: {limits[0.0]:g} is not reached")
            for _ in PLACES:
                progress()
            peaks = ({sign * off: peak for off, peak in limits.items() for sign in (-1, 1)},) * len(PLACES)
            return TrackerTuning(SCHEDULE, system.controller.model, (0.01,) * len(PLACES), peaks, 0.91, 6.0)

        def looked_at(_system, limits):
            return [Corner(off, limits[off], 1.0 + factor * (peak - 1.0)) for off, peak in asked[-1].items()]

        monkeypatch.setattr(tracker_synthesis, "tune_tracker", tune)
        monkeypatch.setattr(tracker_synthesis, "corners", looked_at)
        monkeypatch.setattr(tracker_synthesis, "_learning", lambda _: ())
        return asked

    return tuner


def test_rows_that_hold_between_them_are_tuned_once(rows):
    asked = rows(1.1)
    found = held_tracker(fl.bench(), Wanted())
    assert len(asked) == 1
    assert max(each.sensitivity_peak for each in found.corners if each.off == 0.0) <= 1.7
    assert fl.bench().evolve(dict(found.overrides)).controller.schedule == SCHEDULE


@pytest.mark.parametrize("factor", [1.2, 1.9])
def test_rows_that_do_not_are_tuned_again_as_much_more_tightly(rows, factor):
    asked = rows(factor)
    found = held_tracker(fl.bench(), Wanted())
    assert len(asked) == 2
    for each in found.corners:
        limit = {0.0: 1.7, 0.05: 2.0, 0.1: 2.6}[each.off]
        assert 0.95 * (limit - 1) < each.sensitivity_peak - 1 <= limit - 1


def test_what_is_not_reached_even_so_is_told_as_it_was_asked_for(rows):
    asked = rows(1.9, least=0.5)
    with pytest.raises(fl.FrictionloopError, match=r"^sensitivity_peak = 1.7: law tracker cannot hold .* somewhere"):
        held_tracker(fl.bench(), Wanted())
    assert len(asked) == 2
    rows(1.0, least=5.0)
    with pytest.raises(fl.FrictionloopError, match=r"^sensitivity_peak = 1.7: law tracker: 1.63 is not reached$"):
        held_tracker(fl.bench(), Wanted())


@pytest.mark.soak
@pytest.mark.timeout(900)
def test_a_tuned_tracker_holds_is_simulated_and_exported(tmp_path, capsys, monkeypatch):
    """A bench unlike the preset: other springs, electronics and delay."""
    monkeypatch.chdir(tmp_path)
    other = ("--sensor.resonance_hz", "160", "--sensor.cutoff_hz", "800", "--controller.delay_s", "150e-6")
    with pytest.raises(SystemExit) as left:
        main(["design", "controller", "--law", "tracker", *other, "--out", "t.toml", "--json"])
    assert left.value.code == 0
    found, system = json.loads(capsys.readouterr().out), fl.read_toml("t.toml")
    assert isinstance(system.controller, TrackerController)
    assert system.controller.model.resonance_hz == 160.0
    assert len(found["margins"]) == 4 * 5 * 6
    for row in found["margins"]:
        assert row["sensitivity_peak"] <= {0: 1.7, 5: 2.0, 10: 2.6}[round(100 * abs(row["resonance_off"]))] * 1.001
    assert [row["place"] for row in found["schedule"]] == list(PLACES)
    assert "experimental" in found["notes"][0] and "notch_pi" in found["notes"][0]
    run = fl.simulate(system, 4.0).sel(time=slice(1.0, None))
    plain = fl.simulate(system.evolve({"controller.kind": "lookup"}), 4.0).sel(time=slice(1.0, None))
    assert fl.rms_error(run) < 0.5 * fl.rms_error(plain)
    with pytest.raises(SystemExit) as left:
        main(["firmware", "export", "t.toml", "--out", "table"])
    assert left.value.code == 0
