"""Gains that hold with sensor, delay and gain at the ends of their intervals at once."""

from __future__ import annotations

import json

import pytest

import frictionloop as fl
from frictionloop.cli import main
from frictionloop.design.bench_file import read_designed
from frictionloop.design.corners import corners
from frictionloop.design.operating_grid import ITSELF, Lean, leaning
from frictionloop.design.requirements import Requirements
from frictionloop.design.synthesis import synthesised

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


def test_a_share_that_is_none_is_refused():
    with pytest.raises(fl.FrictionloopError, match=r"delay_error = 0.7: must be from 0 to 0.5"):
        Requirements(delay_error=0.7)


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
