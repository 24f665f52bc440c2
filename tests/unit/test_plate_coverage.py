"""How often intervals of plate and delay hold what is true, and how wide they are."""

from __future__ import annotations

import numpy as np
import pytest

from frictionloop.identification import loop_delay, plate_decay, plate_envelope, plate_sweep, rigs
from frictionloop.parameters import ResonantPlate

PLATE = ResonantPlate(frequency_hz=41e3, q=180.0, max_amplitude_um=2.2)


def swept(seed):
    found = plate_sweep(rigs.plate_sweep_rig(PLATE, noise_um=0.02, seed=seed))
    return {"frequency": (found.resonance, found.method_hz, 41e3), "q": (found.q, found.method_q, 180.0)}


def switched(seed):
    found = plate_decay(rigs.plate_switch_rig(PLATE, switches=6, seed=seed))
    return {"frequency": (found.resonance, found.method_hz, 41e3), "q": (found.q, found.method_q, 180.0)}


def followed(seed):
    found = plate_envelope(rigs.plate_switch_rig(PLATE, switches=6, seed=seed))
    return {"corner": (found.corner, found.method_hz, 41e3 / 360)}


def jumped(seed):
    found = loop_delay(rigs.jumps_rig(230e-6, jumps=40, seed=seed), 5000.0)
    return {"delay": (found.delay, found.method_s, 230e-6)}


WIDEST = {
    swept: {"frequency": 5e-5, "q": 0.025},
    switched: {"frequency": 8e-6, "q": 0.003},
    followed: {"corner": 0.0015},
    jumped: {"delay": 0.12},
}
"""Median half width of intervals of 90 %, as a share of the value, that may not be exceeded."""


@pytest.mark.slow
@pytest.mark.parametrize("measure", WIDEST, ids=lambda measure: measure.__name__)
def test_coverage(measure):
    """Of 40 recordings, fewer than 34 intervals of 90 % hold the truth with a chance of 1 in 20 at most."""
    inside: dict[str, int] = {}
    widths: dict[str, list[float]] = {}
    for seed in range(40):
        for name, (estimate, method, true) in measure(seed).items():
            both = estimate._replace(standard_error=np.hypot(estimate.standard_error, method))
            low, high = both.interval(0.9)
            inside[name] = inside.get(name, 0) + (low < true < high)
            widths.setdefault(name, []).append((high - low) / 2 / true)
    assert all(count >= 34 for count in inside.values()), inside
    assert {name: np.median(each) for name, each in widths.items() if np.median(each) > WIDEST[measure][name]} == {}
