"""Stability and Ms from a response alone, against the poles and margins of the loops whose law is known."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictionloop.analysis.linear import linearise
from frictionloop.design.nyquist import poles_outside
from frictionloop.design.robustness import robustness, worst
from frictionloop.parameters import RETUNED, bench, paper
from frictionloop.quantities import FrictionloopError

BENCH = bench()
LOOP = linearise(BENCH)
GRID = np.append(LOOP.search_grid(1e-3), LOOP.nyquist_hz)
GRID = GRID[GRID >= 1e-3]
PLANT, PERIOD_S = LOOP.plant.response(GRID)[:, 1, 0], LOOP.plant.period_s


def pi(kp: float, ki: float):
    return lambda f: kp + ki * PERIOD_S / np.expm1(2j * np.pi * np.asarray(f) * PERIOD_S)


RETUNED_PI = pi(RETUNED["controller.kp"], RETUNED["controller.ki"])


@settings(max_examples=60)
@given(kp=st.floats(0.0, 20.0), ki=st.floats(1.0, 2000.0))
def test_poles_are_counted_as_eigenvalues_tell(kp: float, ki: float) -> None:
    size = np.abs(LOOP.with_gains(kp, ki).poles())
    if np.any(np.abs(size - 1) < 1e-4):
        return
    assert poles_outside(pi(kp, ki)(GRID) * PLANT, GRID, PERIOD_S) == np.sum(size > 1)


def test_table_is_what_the_margins_of_each_loop_say() -> None:
    table = robustness(BENCH, RETUNED_PI, resonance=(-0.1, 0.0, 0.1), gain=(0.65, 1.35), speed_mm_s=(20.0, 150.0))
    for contact in ("dahl", "slider"):
        for off in (-0.1, 0.1):
            for speed in (20.0, 150.0):
                changes = {
                    "finger.contact": contact,
                    "sensor.resonance_hz": 145.0 * (1 + off),
                    "motion.speed_mm_s": speed,
                }
                loop = linearise(BENCH.evolve(changes))
                for gain in (0.65, 1.35):
                    # A gain on the plant is one on both gains of the law.
                    margins = loop.with_gains(*(gain * RETUNED[f"controller.{k}"] for k in ("kp", "ki"))).margins()
                    here = table.sel(resonance=off, gain=gain, contact=contact, speed_mm_s=speed)
                    assert bool(here["stable"]) == margins.stable
                    assert float(here["sensitivity_peak"]) == pytest.approx(margins.sensitivity_peak, rel=5e-3)


def test_printed_gains_are_unstable_everywhere_and_infinite() -> None:
    table = robustness(BENCH, pi(10.0, 2.0), contact=("dahl",), speed_mm_s=(20.0,))
    assert not table["stable"].any()
    assert np.all(np.isinf(table["sensitivity_peak"]))


def test_worst_is_the_largest_and_looks_no_further_than_asked() -> None:
    table = robustness(BENCH, RETUNED_PI, gain=(1.0,), contact=("dahl",), speed_mm_s=(20.0,))
    assert worst(table)["sensitivity_peak"] == float(table["sensitivity_peak"].max())
    near = worst(table, resonance=0.05)
    assert abs(near["resonance"]) <= 0.05 < abs(worst(table)["resonance"])
    assert near["sensitivity_peak"] < worst(table)["sensitivity_peak"]


def test_a_loop_without_springs_or_skin() -> None:
    system = paper()
    table = robustness(system, pi(0.1, 50.0), resonance=(0.0,), gain=(1.0,), contact=("none",), speed_mm_s=(20.0,))
    wanted = linearise(system).with_gains(0.1, 50.0).margins().sensitivity_peak
    assert float(table["sensitivity_peak"].squeeze()) == pytest.approx(wanted, rel=1e-3)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"gain": (0.0,)}, "^gain = .*must be finite and above 0"),
        ({"resonance": ()}, "^resonance = .*at least one value"),
        ({"resonance": (-1.0,)}, "^resonance = -1: must be above -1"),
        ({"contact": ("jelly",)}, "contact"),
    ],
)
def test_what_is_refused(changes, words) -> None:
    with pytest.raises(FrictionloopError, match=words):
        robustness(BENCH, RETUNED_PI, **changes)


def test_springs_that_are_not_there_and_a_coarse_grid_are_refused() -> None:
    with pytest.raises(FrictionloopError, match=r"^resonance = -0.1: sensor.kind = 'lowpass' has none"):
        robustness(paper(), RETUNED_PI)
    with pytest.raises(FrictionloopError, match="too coarse or starts too high"):
        poles_outside(10 * PLANT[::400], GRID[::400], PERIOD_S)
