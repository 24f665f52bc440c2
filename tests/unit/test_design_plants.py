"""Stability, Ms and gains of several loops from their responses alone, against poles and margins of each."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import frictionloop as fl
from frictionloop.analysis.disturbance_spectrum import touch_spectrum
from frictionloop.analysis.linear import linearise
from frictionloop.design.operating_grid import OperatingGrid
from frictionloop.design.pi_synthesis import WorstFew, best_gains
from frictionloop.design.plant_set import Plants, detuned, shifted
from frictionloop.design.robust_notch import NotchSearch
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


LIMITS = {0.0: 1.7, 0.05: 2.0, 0.1: 2.6}


@pytest.fixture(scope="module")
def cases():
    system = fl.bench().evolve({"controller.kind": "pi"})
    return shifted(OperatingGrid((11.5, 0.0), (20.0, 60.0), (0.4, 0.9)).loops(system), LIMITS)


@pytest.mark.parametrize("width", [0.3, 7.0])
@pytest.mark.parametrize("with_spectrum", [True, False])
def test_they_are_the_best_of_all(cases, width, with_spectrum):
    plants, peaks = Plants.of([loop for loop, _, _ in cases], fine=False), [limit for _, _, limit in cases]
    behind = NotchSearch(plants, peaks, 145.0, None).behind(np.log([0.95, width, 0.05]))
    density = touch_spectrum(cases[0][0].system, 0.3)(plants.frequency_hz) if with_spectrum else None
    looked = WorstFew()
    few, every = looked.gains(behind, peaks, density, refine=False), best_gains(behind, peaks, density)
    law = behind.pi(few.kp, few.ki)
    assert few.ki > 0.0 and behind.stable(law).all()
    assert (np.min(np.abs(behind.returned(law)), axis=1) * np.array(peaks)).min() >= 1.0 - 1e-8
    if with_spectrum:  # values of ki in steps of 15 %, from other ends
        assert behind.residual_n(law, density).max() == pytest.approx(few.cost + 1.0, rel=1e-8)
        assert few.cost + 1.0 == pytest.approx(every.cost + 1.0, rel=0.03)
    else:
        assert tuple(few) == pytest.approx(tuple(every), rel=1e-9)
    assert len(looked.few) < len(peaks) / 4
    assert looked.gains(behind, peaks, density, refine=False) == few


def test_where_no_gains_hold_there_are_none(cases):
    plants = Plants.of([loop for loop, _, _ in cases], fine=False)
    turned = plants.behind(np.full(plants.frequency_hz.size, -1.0 + 0j))
    looked = WorstFew()
    assert looked.gains(turned, [1.7] * len(cases), None, refine=False).ki == 0.0
