"""Gains found on the few plants that limit them: those of a search that looks at all plants all the time."""

from __future__ import annotations

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.analysis.disturbance import touch_spectrum
from frictionloop.design.operating_grid import OperatingGrid
from frictionloop.design.pi_synthesis import WorstFew, best_gains
from frictionloop.design.plants import Plants, shifted
from frictionloop.design.robust_notch import NotchSearch

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
