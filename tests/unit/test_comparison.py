"""Laws compared: who competes, on whom, and what a file of results accepts."""

from __future__ import annotations

import signal
import subprocess
import sys

import numpy as np
import pytest
import xarray as xr

import frictionloop as fl
from frictionloop.control.instruction_cost import CORE_HZ, CYCLES_AT_MOST, WORST_TICK
from frictionloop.design import comparison as rooms
from frictionloop.design import controller_synthesis
from frictionloop.design.comparison import comparison_run, trial_protocol
from frictionloop.design.requirements import Designed, Requirements
from frictionloop.quantities import FrictionloopError

SHORT = {"duration_s": 1.0, "start_s": 0.4, "progress": False}
LAWS = ["lookup", "retuned_pi"]


def short(path=None, count=2, seed=5, laws=LAWS, speeds=(20.0,), system=None, **more):
    return rooms.run_laws(system or fl.bench(), laws, count, seed, speeds, path=path, **SHORT | more)


@pytest.fixture(autouse=True, scope="module")
def _swept_once():
    """The same few cells are asked for again and again: each is computed once in this file."""
    really, swept = comparison_run.sweep, {}

    def sweep(*given, **options):
        key = repr((given, options))
        if key not in swept:
            swept[key] = really(*given, **options)
        return swept[key].copy(deep=True)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(comparison_run, "sweep", sweep)
        yield


@pytest.fixture(scope="module")
def whole():
    return short()


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[pytest.mark.slow] * (name in trial_protocol.DESIGNED))
        for name in trial_protocol.ENTRANTS
        if name != "notch_pi"  # half a minute, which tests/unit/test_retune_notch.py has spent on it
    ],
)
def test_every_entrant_is_a_system(name):
    assert fl.bench().evolve(trial_protocol.ENTRANTS[name](fl.bench())).controller.kind


@pytest.mark.parametrize("law", sorted(trial_protocol.DESIGNED))
def test_an_entrant_that_is_designed_is_what_the_synthesis_of_its_law_finds(law, monkeypatch):
    asked = []

    def synthesised(*given):
        asked.append(given)
        return Designed({"controller.kind": "lookup"}), given[-1]

    monkeypatch.setattr(controller_synthesis, "synthesised", synthesised)
    assert trial_protocol.ENTRANTS[law](fl.bench()) == {"controller.kind": "lookup"}
    assert asked == [(fl.bench(), law, Requirements())]  # as `design controller` does


def test_the_printed_and_the_re_tuned_gains():
    printed = fl.bench().evolve(trial_protocol.ENTRANTS["printed_pi"](fl.bench())).controller
    assert (printed.kp, printed.ki) == (10.0, 2.0)  # paper, Sec. 2.3
    assert trial_protocol.retuned_pi(fl.bench()) == {"controller.kind": "pi", **fl.RETUNED}
    assert trial_protocol.retuned_pi(fl.bench().evolve({"controller.kp": 3.0})) == trial_protocol.retuned_pi(fl.bench())
    slower = fl.bench().evolve({"controller.delay_s": 400e-6})
    gains = trial_protocol.retuned_pi(slower)
    found = fl.retune(slower)
    assert (gains["controller.kp"], gains["controller.ki"]) == (found.kp, found.ki)


def test_fingers_are_those_of_the_seed_and_meet_three_resonances():
    people, plain = (
        trial_protocol.population(fl.bench(), 7, 5),
        trial_protocol.without_lengths(fl.fingers(7, 5)),
    )
    assert [{k: v for k, v in each.items() if k != "sensor.resonance_hz"} for each in people] == plain
    met = [each["sensor.resonance_hz"] / 145.0 for each in people]
    np.testing.assert_allclose(met, [1.0, 0.95, 1.05, 1.0, 0.95, 1.05, 1.0], rtol=1e-15)
    assert fl.bench().evolve(people[1]).controller.model.resonance_hz == 145.0


def test_no_two_tasks_or_populations_share_noise():
    seeds = {trial_protocol.noise_seed(seed, task) for seed in range(20) for task in trial_protocol.TASKS}
    assert len(seeds) == 20 * len(trial_protocol.TASKS)


def test_what_is_asked_is_the_paper_s_protocol():
    sine = trial_protocol.setpoint_of("sine 0.8")
    assert (sine.offset_n, sine.amplitude_n, sine.frequency_hz) == (0.8, 0.1, 1.0)
    assert trial_protocol.setpoint_of("hold 0.4") == fl.Constant(offset_n=0.4)
    steps = trial_protocol.setpoint_of("steps")
    assert steps.times_s[:3] == (0.0, 0.5, 1.0)
    assert steps.levels_n[:3] == (0.35, 0.75, 0.35)
    assert (steps.times_s[-1], len(steps.times_s)) == (10.5, 22)
    at = trial_protocol.Condition(80.0, 0.0, "landings")
    system = fl.bench().evolve(trial_protocol.overrides_of(at))
    assert (system.motion.speed_mm_s, system.finger.slip_length_um, system.motion.contact_s) == (80.0, 0.0, 1.0)
    assert fl.bench().evolve(trial_protocol.overrides_of(at._replace(task="steps"))).motion.contact_s == 0.0


def test_capable_fingers_are_those_of_capable(whole):
    speed = {"motion.speed_mm_s": 80.0}
    people = fl.fingers(40, 5)
    wanted = fl.capable([each | speed for each in people], 0.3, 0.9, contact_s=11.0)["capable"].values
    np.testing.assert_array_equal(trial_protocol.able(fl.bench(), people, 80.0), wanted)
    assert 0 < wanted.sum() < 40
    chosen = trial_protocol.median_finger(people, wanted)
    assert people.index(chosen) in np.flatnonzero(wanted)
    assert trial_protocol.median_finger(people, np.zeros(40, dtype=bool)) is None


def test_the_cells_are_those_of_a_sweep(whole):
    assert whole.cells["law"].values.tolist() == ["plain", *LAWS]
    law = {"controller.kind": "lookup"}
    at = trial_protocol.Condition(20.0, 0.0, "hold 0.6")
    system = fl.bench().evolve({**trial_protocol.overrides_of(at, 1.0), **law})
    people, seeds = trial_protocol.population(fl.bench(), 2, 5), [trial_protocol.noise_seed(5, "hold 0.6")]
    alone = fl.sweep(system, people, 1.0, seeds, ["rms_error"], score_from_s=0.4)
    cell = whole.cells["rms_error"].sel(law="lookup", speed_mm_s=20.0, slip_length_um=0.0, task="hold 0.6")
    np.testing.assert_array_equal(cell, alone["rms_error"].values[:, 0])


def test_what_was_interrupted_goes_on(whole, tmp_path, monkeypatch):
    path, calls, really = tmp_path / "r.h5", [], comparison_run._Trial.run

    def stopping(self, law, at):
        calls.append(at)
        if len(calls) == 6:
            raise KeyboardInterrupt
        return really(self, law, at)

    monkeypatch.setattr(comparison_run._Trial, "run", stopping)
    with pytest.raises(rooms.ComparisonInterrupted) as stop:
        short(path)
    total = 2 * (2 * len(trial_protocol.TASKS) + len(trial_protocol.SINES))
    assert (stop.value.done, stop.value.total) == (5, total)
    resumed = short(path, resume=True)
    assert len(calls) == 6 + total - 5
    xr.testing.assert_identical(resumed.cells, whole.cells)
    again = short(path, resume=True, laws=["lookup"])
    assert len(calls) == 6 + total - 5
    xr.testing.assert_identical(again.cells, whole.cells)


KILLED = """
import os, signal, sys
from frictionloop import bench
from frictionloop.design import comparison
from frictionloop.design.comparison import comparison_run as run

calls, really = [], run._Trial.run

def stopping(self, law, at):
    calls.append(at)
    if len(calls) == 6:
        os.kill(os.getpid(), signal.SIGKILL)
    return really(self, law, at)

run._Trial.run = stopping
comparison.run_laws(bench(), ["lookup", "retuned_pi"], 2, 5, [20.0], path=sys.argv[1], duration_s=1.0, start_s=0.4,
                   clock=lambda: 4.0 * len(calls))
"""
"""Its clock goes on by 4 s a cell, so that it saves every second one."""


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="no such signal on this system")
def test_a_comparison_that_is_killed_goes_on(whole, tmp_path, monkeypatch):
    path, calls, really = tmp_path / "r.h5", [], comparison_run._Trial.run
    done = subprocess.run([sys.executable, "-c", KILLED, str(path)], capture_output=True, text=True, check=False)
    assert done.returncode == -signal.SIGKILL, done.stderr
    monkeypatch.setattr(comparison_run._Trial, "run", lambda *given: (calls.append(given), really(*given))[1])
    xr.testing.assert_identical(short(path, resume=True).cells, whole.cells)
    total = 2 * (2 * len(trial_protocol.TASKS) + len(trial_protocol.SINES))
    assert len(calls) == total - 4
    assert [each.name for each in tmp_path.iterdir()] == ["r.h5"]


def test_an_interrupt_while_laws_are_designed_says_that_nothing_is_done():
    def interrupted(system):
        raise KeyboardInterrupt

    with pytest.raises(rooms.ComparisonInterrupted) as stop:
        short(laws={"mine": interrupted})
    assert (stop.value.done, stop.value.total) == (
        0,
        2 * (len(trial_protocol.TASKS) + len(trial_protocol.SINES)),
    )


def test_an_interrupt_while_more_laws_are_designed_counts_what_the_file_has(tmp_path):
    def interrupted(system):
        raise KeyboardInterrupt

    path = tmp_path / "r.h5"
    short(path, laws=["lookup"])
    both = {"lookup": trial_protocol.ENTRANTS["lookup"], "mine": interrupted}
    with pytest.raises(rooms.ComparisonInterrupted) as stop:
        short(path, resume=True, laws=both)
    assert stop.value.done == 2 * (len(trial_protocol.TASKS) + len(trial_protocol.SINES))


LATE = {"controller.delay_s": 1.9e-3}
"""More than one period: a limit observer cannot."""


def test_a_law_that_cannot_run_on_the_bench_is_left_out_with_the_reason(monkeypatch):
    cheap = {name: trial_protocol.ENTRANTS[name] for name in ("lookup", "limit_observer", "retuned_pi")}
    monkeypatch.setattr(trial_protocol, "ENTRANTS", cheap)
    ran = short(laws=None, system=fl.bench().evolve(LATE))
    assert list(ran.laws) == ["lookup", "retuned_pi"]
    assert list(ran.left_out) == ["limit_observer"] and "delay_s = 0.0019 s: " in ran.left_out["limit_observer"]


def test_a_law_that_is_named_and_cannot_run_is_refused_before_any_is_designed(monkeypatch):
    monkeypatch.setattr(controller_synthesis, "synthesised", lambda *given: pytest.fail("designed"))
    with pytest.raises(FrictionloopError, match="delay_s"):
        late = {"mine": lambda _: {"controller.kind": "limit_observer"}}
        short(laws=late | {"notch_pi": trial_protocol.ENTRANTS["notch_pi"]}, system=fl.bench().evolve(LATE))


@pytest.mark.slow
def test_more_laws_and_speeds_join_a_file(whole, tmp_path):
    path = tmp_path / "r.h5"
    short(path, laws=["retuned_pi"])
    both = short(path, resume=True)
    xr.testing.assert_identical(both.cells.sel(law=whole.cells["law"]), whole.cells)
    more = short(path, resume=True, laws=["lookup"], speeds=(40.0,))
    assert more.cells["speed_mm_s"].values.tolist() == [20.0, 40.0]
    assert np.isnan(more.cells["rms_error"].sel(law="retuned_pi", speed_mm_s=40.0)).all()
    assert rooms.scores(more)["speed_mm_s"].values.tolist() == [40.0]


def test_cells_of_other_code_are_refused(tmp_path, monkeypatch):
    path = tmp_path / "r.h5"
    short(path, laws=["lookup"])
    monkeypatch.setattr(comparison_run, "computing", lambda: "of a law that was changed meanwhile")
    with pytest.raises(fl.FrictionloopError, match=r"r\.h5: .*20 mm/s"):
        short(path, resume=True, laws=["lookup"])


@pytest.mark.slow
@pytest.mark.parametrize("laws", [["lookup"], ["printed_pi"]], ids=["fewer", "another"])
def test_a_file_keeps_the_cells_that_are_not_asked_for(laws, tmp_path):
    """Resumed with fewer laws and speeds than it holds, the file is written anew: every cell must come through."""
    path = tmp_path / "r.h5"
    short(path, speeds=(20.0, 40.0))
    before = fl.load(path)
    assert (before["digest"] != "").sum() == 2 * 2 * (2 * len(trial_protocol.TASKS) + len(trial_protocol.SINES))
    short(path, resume=True, laws=laws, speeds=(20.0,))
    after = fl.load(path)
    assert set(after["law"].values) == {"plain", *LAWS, *laws}
    xr.testing.assert_identical(after.sel(law=before["law"]), before)


@pytest.mark.slow
def test_a_file_refuses_what_it_does_not_keep(tmp_path, monkeypatch):
    path = tmp_path / "r.h5"
    short(path, laws=["lookup"])
    before = path.read_bytes()

    def refused(match, **more):
        with pytest.raises(fl.FrictionloopError, match=match) as error:
            short(path, **{"count": 2, "laws": ["lookup"], "resume": True} | more)
        assert "\n" not in str(error.value)

    refused("exists; --resume", resume=False)
    refused("of seed = 5, not 6", seed=6)
    refused("of fingers = 2, not 3", count=3)
    refused("of duration_s = 1.0, not 1.2", duration_s=1.2)
    refused("of another bench", system=fl.bench().evolve({"controller.delay_s": 1e-4}))
    monkeypatch.setitem(trial_protocol.ENTRANTS, "lookup", lambda system: {"controller.kind": "lookup", **MODEL})
    refused(r"lookup .*20 mm/s")
    assert path.read_bytes() == before
    fl.save(fl.simulate(fl.paper(), 0.01), tmp_path / "run.h5")
    with pytest.raises(fl.FrictionloopError, match=r"run\.h5: "):
        short(tmp_path / "run.h5", resume=True)
    with pytest.raises(fl.FrictionloopError, match="needs path"):
        short(resume=True)
    with pytest.raises(fl.FrictionloopError, match="cannot be written"):
        short(tmp_path / "nowhere" / "r.h5")


MODEL = {"controller.model.nominal_n": 0.9}


def test_entrants_of_ones_own_run_under_their_names():
    own = {"mine": lambda system: {"controller.kind": "lookup"}, "printed_pi": trial_protocol.ENTRANTS["printed_pi"]}
    found, named = short(laws=own), short(laws=["lookup", "printed_pi"])
    assert list(found.laws) == ["mine", "printed_pi"]
    for mine, theirs in (("mine", "lookup"), ("printed_pi", "printed_pi")):
        np.testing.assert_array_equal(found.cells["rms_error"].sel(law=mine), named.cells["rms_error"].sel(law=theirs))


def test_a_tick_is_the_worst_of_the_laws_image(whole):
    kinds = {name: fl.bench().evolve(overrides).controller.kind for name, overrides in whole.laws.items()}
    told = {row["law"]: row["tick_instructions"] for row in rooms.margin_rows(whole)}
    assert told == {law: WORST_TICK[kind] for law, kind in kinds.items()}
    assert max(WORST_TICK.values()) < CORE_HZ / 5000 / CYCLES_AT_MOST


@pytest.mark.slow
def test_a_design_is_kept_and_not_made_again(tmp_path, monkeypatch):
    made = []

    def design(system):
        made.append(system)
        return {"controller.kind": "notch_pi", "controller.kp": 2.0, "controller.ki": 60.0}

    monkeypatch.setitem(trial_protocol.DESIGNED, "notch_pi", design)
    monkeypatch.setitem(trial_protocol.ENTRANTS, "notch_pi", design)
    options = {"duration_s": 1.6, "progress": False, "path": tmp_path / "kept.h5"}
    first = rooms.run_laws(fl.bench(), ["notch_pi"], 2, 0, [20.0], **options)
    again = rooms.run_laws(fl.bench(), ["notch_pi"], 2, 0, [20.0], resume=True, **options)
    assert len(made) == 1
    assert again.laws == first.laws
    rooms.run_laws(fl.bench(), ["notch_pi"], 2, 0, [20.0], **{**options, "path": tmp_path / "other.h5"})
    assert len(made) == 2
