"""Which seconds of a recorded disturbance a run does not score, and the stroke that scores them."""

from __future__ import annotations

import re

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.cli.recorded_turns import lines, without_turn_mm

VALUES_N = 0.02 * np.sin(2 * np.pi * 3 * np.arange(4000) / 1000)


def slid(**changes):
    recorded = {"disturbance": fl.Samples(values_n=VALUES_N, rate_hz=1000.0), "setpoint": fl.Constant(offset_n=0.5)}
    return fl.bench().evolve(recorded | fl.RETUNED | {"motion.stroke_mm": 20.0} | changes)


def unscored_s(run):
    off = np.r_[False, ~run.scored.values, False]
    edges = np.flatnonzero(np.diff(off.astype(int))).reshape(-1, 2)
    return [(run.time.values[a], run.time.values[b - 1]) for a, b in edges]


def test_the_seconds_are_those_of_the_run_and_the_stroke_has_no_turn():
    system = slid()
    run = fl.simulate(system, 3.0)
    said = " ".join(lines(run, system, 3.0))
    named = [tuple(map(float, each)) for each in re.findall(r"([\d.]+) to ([\d.]+) s", said)]
    assert np.ravel(named) == pytest.approx(np.ravel(unscored_s(run)[:3]), rel=5e-3)
    assert "below and above a frequency has a straight line there" in said
    stroke_mm = float(re.search(r"--motion\.stroke_mm (\S+) (?:--\S+ \S+ )*has no turn in this run", said)[1])
    longer = fl.simulate(slid(**{"motion.stroke_mm": stroke_mm}), 3.0)
    assert [start for start, _ in unscored_s(longer)] == [0.0]
    shorter = fl.simulate(slid(**{"motion.stroke_mm": stroke_mm - 10.0}), 3.0)
    assert len(unscored_s(shorter)) == 2


@pytest.mark.parametrize("changes", [{"motion.start": 0.25}, {"motion.contact_s": 1.0}, {"motion.stroke_mm": 500.0}])
def test_no_stroke_is_named_where_none_is_known_or_needed(changes):
    assert without_turn_mm(slid(**changes), 3.0) is None


def test_nothing_is_said_of_a_formula():
    system = slid(disturbance=fl.Sine(amplitude_n=0.02))
    assert lines(fl.simulate(system, 3.0), system, 3.0) == []


@pytest.mark.slow
def test_a_stroke_longer_than_the_plate_brings_the_plate(frictionloop):
    """What is proposed runs as it is written."""
    np.savetxt("s.csv", 0.02 * np.sin(np.arange(800) / 3), header="Ft [N]", comments="")
    flags = ("kind", "recording", "path", "s.csv", "column", "Ft", "rate_hz", "100")
    given = [f"--disturbance.{each}" if k % 2 == 0 else each for k, each in enumerate(flags)]
    given = ["simulate", "--preset", "bench", "--duration-s", "8", "--motion.speed_mm_s", "40", *given]
    first = " ".join(frictionloop(*given, "--split-hz", "2").out.split())
    assert "these shares are rough: across turns" in first
    found = re.search(r"(--motion\.stroke_mm \S+(?: --\S+ \S+)*) has no turn in this run", first)
    again = frictionloop(*given, "--split-hz", "2", *found[1].split())
    assert again.code == 0 and "has no turn" not in again.out and "are rough" not in again.out
