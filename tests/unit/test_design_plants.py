"""Stability and Ms of several loops from their responses alone, against poles and margins of each."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictionloop.analysis.linear import linearise
from frictionloop.design.plants import Plants, detuned
from frictionloop.parameters import RETUNED, bench, paper

BENCH = bench()
LOOPS = [
    detuned(linearise(BENCH.evolve({"finger.slip_length_um": length_um, "motion.speed_mm_s": speed})), 1.0 + off)
    for length_um in (11.5, 0.0)
    for speed in (20.0, 80.0)
    for off in (-0.1, 0.0, 0.1)
]
PLANTS = Plants.of(LOOPS)
GAINS = RETUNED["controller.kp"], RETUNED["controller.ki"]


@settings(max_examples=40, deadline=None)
@given(kp=st.floats(0.0, 20.0), ki=st.floats(1.0, 2000.0))
def test_what_is_stable_is_what_the_poles_tell(kp: float, ki: float) -> None:
    stable = PLANTS.stable(PLANTS.pi(kp, ki))
    for loop, found in zip(LOOPS, stable, strict=True):
        size = np.abs(loop.with_gains(kp, ki).poles())
        if not np.any(np.abs(size - 1) < 1e-4):
            assert found == bool(np.all(size < 1))


@pytest.mark.parametrize("gain", [0.65, 1.0, 1.35])
def test_peaks_are_what_the_margins_of_each_loop_say(gain: float) -> None:
    """Up to an Ms of 10, beyond which the grid is too wide to tell it to 0.5 %."""
    kp, ki = (gain * each for each in GAINS)
    for loop, peak in zip(LOOPS, PLANTS.peaks(PLANTS.pi(kp, ki)), strict=True):
        wanted = loop.with_gains(kp, ki).margins().sensitivity_peak
        assert peak == pytest.approx(wanted, rel=5e-3) if wanted <= 10.0 or np.isinf(wanted) else peak > 9.0


def test_an_integral_of_the_wrong_sign_is_unstable() -> None:
    assert not PLANTS.stable(PLANTS.pi(0.0, -20.0)).any()


def test_printed_gains_are_unstable_everywhere_and_infinite() -> None:
    assert np.all(np.isinf(PLANTS.peaks(PLANTS.pi(10.0, 2.0))))


def test_a_loop_without_springs_or_skin() -> None:
    loop = linearise(paper())
    plants = Plants.of([loop])
    wanted = loop.with_gains(0.1, 50.0).margins().sensitivity_peak
    assert plants.peaks(plants.pi(0.1, 50.0)) == pytest.approx([wanted], rel=1e-3)
