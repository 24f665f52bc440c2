"""Gains that hold over speeds and loads, with sensor, delay and gain at the ends of their intervals."""

from __future__ import annotations

import json
import re

import pytest

import frictionloop as fl
from frictionloop.cli import main
from frictionloop.design.bench_file import read_designed
from frictionloop.design.controller_synthesis import held_between, synthesised
from frictionloop.design.grid_corners import corners
from frictionloop.design.operating_grid import ITSELF, Lean, OperatingGrid, leaning
from frictionloop.design.requirements import Designed, Requirements
from frictionloop.quantities import FrictionloopError

BENCH = fl.bench()
LEAN = Lean(sensor_error=0.2, delay_error=0.2, gain_error=0.1)


def test_a_leaning_loop_is_that_of_the_other_bench():
    points = ITSELF.loops(BENCH.evolve({"controller.kind": "pi"}))
    slow = leaning(points, LEAN)[len(points)]
    changed = {"sensor.cutoff_hz": 0.8 * BENCH.sensor.cutoff_hz, "controller.delay_s": 1.2 * BENCH.controller.delay_s}
    other = ITSELF.loops(BENCH.evolve({"controller.kind": "pi"} | changed))[0]
    for hertz in (5.0, 100.0, 700.0):
        mine, theirs = (loop.plant.response(hertz)[0, 1, 0] for loop in (slow, other))
        assert mine == pytest.approx(1.1 * theirs, rel=1e-9)
    assert leaning(points, Lean()) == points


def test_more_lag_may_excuse_more_gain_so_each_end_of_one_is_looked_at_with_each_of_the_other():
    """On the bench an integral is limited below the resonance, which more lag turns away from -1."""
    points = ITSELF.loops(BENCH.evolve({"controller.kind": "pi", "controller.kp": 0.0, "controller.ki": 100.0}))[:1]
    found = leaning(points, LEAN)
    assert len(found) == 5
    _, *leant = (loop.sensitivity_peak() for loop in found)
    peaks = dict(zip(LEAN.sides, leant, strict=True))
    assert peaks[-1.0, 1.0] == max(leant) > peaks[1.0, 1.0]
    assert Lean(gain_error=0.1).sides == [(0.0, 1.0), (0.0, -1.0)]
    assert Lean(delay_error=0.1).sides == [(1.0, 0.0), (-1.0, 0.0)]


@pytest.mark.slow
def test_gains_hold_at_the_ends():
    plain, careful = (
        synthesised(BENCH, "pi", Requirements(resonance_error=0.01, **lean._asdict(), slip_lengths_um=()))[0]
        for lean in (Lean(), LEAN)
    )
    limits = Requirements(resonance_error=0.01).limits
    worst = [
        max(each.excess for each in corners(BENCH.evolve(found.overrides), ITSELF._replace(limits=limits, lean=LEAN)))
        for found in (plain, careful)
    ]
    assert worst[0] > 1.01 and worst[1] <= 1.0011
    assert careful.overrides["controller.ki"] < plain.overrides["controller.ki"]


def test_a_loop_at_an_end_is_that_of_the_other_bench():
    points = ITSELF.loops(BENCH.evolve({"controller.kind": "pi"}))
    found = leaning(points, Lean(ends=(("plate.q", 300.0),)))
    other = ITSELF.loops(BENCH.evolve({"controller.kind": "pi", "plate.q": 300.0}))
    assert len(found) == 2 * len(points)
    for mine, theirs in zip(found[len(points) :], other, strict=True):
        assert mine.plant.response(70.0) == pytest.approx(theirs.plant.response(70.0))


def certificate(tmp_path, *corners):
    """What identify bench --json prints, as far as a design reads it."""
    listed = [{"path": path, "value": value, "side": "low"} for path, value in corners]
    (tmp_path / "bench.json").write_text(json.dumps({"measured": [], "corners": listed}))
    return str(tmp_path / "bench.json")


@pytest.mark.slow
def test_a_design_holds_the_corners_of_a_certificate(tmp_path):
    ends = (("plate.q", 460.0), ("friction.susceptibility_per_um2", 0.9))
    words = ["design", "controller", "--law", "pi", "--slip-lengths-um", "11.5", "--resonance-error", "0.01"]
    limits, off = Requirements(resonance_error=0.01).limits, Lean(ends=ends)
    worst = []
    for more in ([], ["--corners", certificate(tmp_path, *ends, ("sensor.resonance_hz", 100.0))]):
        out = tmp_path / f"{len(more)}.toml"
        with pytest.raises(SystemExit) as left:
            main([*words, *more, "--out", str(out)])
        assert left.value.code == 0
        worst.append(max(each.excess for each in corners(fl.read_toml(out), ITSELF._replace(limits=limits, lean=off))))
    assert worst[0] > 1.01 and worst[1] <= 1.0011
    assert read_designed(out).requirements.ends == ends, "a share covers the resonance"


@pytest.mark.parametrize(
    ("text", "says"), [("no", "no measured values"), ("{}", "no corners"), (None, "cannot be read")]
)
def test_a_certificate_that_is_none_is_one_line(tmp_path, capsys, text, says):
    if text is not None:
        (tmp_path / "a.html").write_text(text)
    with pytest.raises(SystemExit) as left:
        main(["design", "controller", "--corners", str(tmp_path / "a.html")])
    said = capsys.readouterr().err
    assert left.value.code == 2 and says in said and said.strip().count("\n") == 0


def test_a_q_that_may_be_off_is_looked_at_on_both_sides_one_at_a_time():
    points, q = ITSELF.loops(BENCH.evolve({"controller.kind": "pi"})), BENCH.sensor.q
    lean = Lean(q_error=0.3)
    found = leaning(points, lean)
    assert len(found) == 3 * len(points)
    assert {loop.system.sensor.q for loop in found[len(points) :]} == {0.7 * q, 1.3 * q}
    assert {loop.system.controller.delay_s for loop in found} == {BENCH.controller.delay_s}
    with pytest.raises(fl.FrictionloopError, match=r"q_error = 0.9: must be from 0 to 0.5"):
        Requirements(q_error=0.9)
    with pytest.raises(fl.FrictionloopError, match=r"q_error = 0.3: needs sensor.kind"):
        leaning([fl.linearise(fl.feasible())], lean)


def at(systems):
    return [(each.finger.slip_length_um, each.motion.speed_mm_s, each.motion.load_n) for each in systems]


def test_every_combination_the_longest_first():
    assert ITSELF.systems(BENCH) == [BENCH]
    found = OperatingGrid((0.0, 11.5), (20.0, 60.0), (0.4,)).systems(BENCH)
    assert at(found) == [(length_um, v, 0.4) for length_um in (11.5, 0.0) for v in (20.0, 60.0)]
    longer, none = (BENCH.evolve({"finger.slip_length_um": z}) for z in (30.0, 0.0))
    assert OperatingGrid(None).lengths_of(longer) == (30.0, 0.0) and OperatingGrid(None).lengths_of(none) == (11.5, 0.0)
    assert OperatingGrid().lengths_of(longer) == (30.0,) and OperatingGrid((5.0, 5.0)).lengths_of(longer) == (5.0,)
    rigid = BENCH.evolve({"finger": {"kind": "rigid"}})
    assert OperatingGrid((0.0, 11.5)).systems(rigid) == [rigid]


@pytest.mark.slow
def test_a_design_for_loads_and_contacts_holds_its_limits_between_them():
    wanted = Requirements(loads_n=(0.4, 0.8))
    limited = ITSELF._replace(limits=wanted.limits)
    made = BENCH.evolve(dict(synthesised(BENCH, "pi", wanted)[0].overrides))
    own = BENCH.evolve(dict(synthesised(BENCH, "pi", Requirements())[0].overrides))
    for length_um in (11.5, 0.0):
        for load in (0.4, 0.5, 0.65, 0.8):
            there = corners(made.evolve({"finger.slip_length_um": length_um, "motion.load_n": load}), limited)
            assert max(each.excess for each in there) <= 1.002
        assert max(each.excess for each in corners(own.evolve({"finger.slip_length_um": length_um}), limited)) <= 1.002
    heavy = corners(own.evolve({"finger.slip_length_um": 0.0, "motion.load_n": 0.8}), limited)
    assert max(each.excess for each in heavy) > 1.05  # which a design for 0.5 N does not hold


WANTED = Requirements(resonance_error=0.0, slip_lengths_um=(11.5,))
PI = {"controller.kind": "pi", "controller.kp": 0.03, "controller.ki": 40.0}


def limit_on_ki() -> float:
    """The factor on `PI` up to which Ms stays within 1.7 wherever it is looked at, by each loop alone."""
    at = corners(BENCH.evolve(PI), WANTED.grid(1, 1))
    return min(each.loop.gain_factor(each.limit) for each in at)


def times(factor):
    gains = {path: factor * PI[path] for path in ("controller.kp", "controller.ki")}
    return lambda system, wanted: Designed({**PI, **gains})


def test_gains_that_are_a_little_too_large_are_lowered_to_those_that_hold():
    most = limit_on_ki()
    found, at = held_between(BENCH, "pi", times(1.03 * most), WANTED)
    assert found.overrides["controller.ki"] == pytest.approx(most * PI["controller.ki"], rel=1e-3)
    assert found.overrides["controller.kp"] == pytest.approx(most * PI["controller.kp"], rel=1e-3)
    assert max(each.sensitivity_peak for each in at) == pytest.approx(1.7, rel=1e-3)


def test_gains_that_are_much_too_large_are_refused_with_the_nearest_limit_that_would_do():
    most = limit_on_ki()
    said = r"law pi: Ms \S+, 1\.7 asked, .*; --sensitivity-peak \S+ may hold$"
    with pytest.raises(FrictionloopError, match=said) as caught:
        held_between(BENCH, "pi", times(1.2 * most), WANTED)
    assert caught.value.code == "NO-CONTROLLER"
    peak = float(re.search(r"--sensitivity-peak (\S+) may", str(caught.value))[1])
    assert held_between(BENCH, "pi", times(1.2 * most), Requirements(peak, 0.0, slip_lengths_um=(11.5,)))
    with pytest.raises(FrictionloopError, match=r"; --sensitivity-peak \S+ may hold, or --law pi$"):
        held_between(BENCH, "notch_pi", times(1.2 * most), WANTED)
