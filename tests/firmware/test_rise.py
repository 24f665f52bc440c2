"""Whatever a table and the readings ask for, the amplitude rises by a share of the plate's largest a tick."""

from __future__ import annotations

import zlib
from typing import Any

import numpy as np
import pytest

from frictionloop.device.simulated_boards import Sample
from frictionloop.quantities.protocol_schema import parameter_words, schema

TICKS = schema()["protocol"]["rise_ticks"]
NEAR = 1 / 512
"""Share of the largest amplitude by which the arcsine's table may be off, twice."""
WILD = {
    "law__gains": [2.0**31, *[0.0] * 63],
    "law__low_n": 2.0**-28,
    "overdrive__decay": 0.99,
    "overdrive__inverse": 2.0**30,
    "setpoint__hold_n": 0.25,
}
"""A PI without its integral, overdrive behind it, with gains so large that a reading drives the plate fully or not."""
BELOW, ABOVE = 3000, 3600
"""Readings on either side of the set-point, in counts."""


def shares(rig: Any, forces: list[int]) -> np.ndarray:
    """Return the share of its largest amplitude that the pin gives the plate at each tick."""
    samples = (Sample(force, 0, 4 * rig.ticks, 3277) for force in forces)
    return np.array([np.sin(np.pi * rig.tick(1, sample).duty / 2**17) for sample in samples])


@pytest.mark.parametrize("mode", ["open", "closed"])
@pytest.mark.parametrize("seed", range(5))
def test_it_rises_no_faster_whatever_the_gains_are(make_rig, seed: int, mode: str):
    rig = make_rig(**WILD)
    rig.tick(50)
    rig.reason("mode", state=schema()["states"][mode])
    found = shares(rig, np.random.default_rng(seed).choice([BELOW, ABOVE, 30000, 0], 800).tolist())
    assert found.max() > 0.2
    assert np.diff(found, prepend=0.0).max() <= 1 / TICKS + NEAR


def test_those_gains_ask_for_whole_steps_and_it_falls_at_once(make_rig):
    rig = make_rig(**WILD)
    rig.tick(50)
    rig.mode("closed")
    rig.tick(600)
    steps = np.diff(shares(rig, ([BELOW] * 8 + [ABOVE] * 8) * 3))
    assert steps.max() == pytest.approx(1 / TICKS, abs=NEAR)
    assert steps.min() < -0.9


@pytest.mark.parametrize("times", [0.25, 0.5, 1.5])
def test_a_plate_that_is_said_to_be_another_one_is_driven_no_further_at_once(make_rig, times: float):
    """What is committed is as large a share as before: the same duty, and the rise begins there."""
    rig = make_rig(setpoint__hold_n=0.45)
    rig.mode("open")
    rig.tick(20)
    before = np.sin(np.pi * rig.drive.duty / 2**17)
    word = parameter_words()
    for name in ("drive.largest_um", "drive.ceiling_um"):
        rig.words[word[name].first] = times * rig.words[word[name].first]
    for first in range(0, len(rig.words), 32):
        assert rig.reason("set", first=first, values=rig.words[first : first + 32]) == "done"
    assert rig.reason("commit", crc=zlib.crc32(rig.words.astype("<f8").tobytes())) == "done"
    found = shares(rig, [8000] * 10)
    assert np.diff(found, prepend=before).max() <= 1 / TICKS + NEAR
    assert abs(found[-1] - before) > 0.05
