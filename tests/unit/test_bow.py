"""A slow bow beneath hits: it is taken off and told, and a recording without one stays as it is."""

from __future__ import annotations

import numpy as np
import pytest
import three_modes
import xarray as xr

from frictionloop.identification import modes, pick_hits, rigs
from frictionloop.identification.onsets import without_bow

RUN = three_modes.plate(seed=1, hits=3, noise=5e-3)
X = np.linspace(-1, 1, 10000)
BOWS = {"parabola": X**2, "half sine": np.cos(np.pi * X / 2), "discharge": np.exp(-1.5 * (X + 1))}


def hits(bow):
    """One triggered record for each hit, all with the same bow."""
    time = ("time", np.arange(X.size) / three_modes.RATE, {"units": "s"})
    return [
        xr.Dataset({"f_m": ("time", hit + bow, {"units": "V"})}, {"time": time})
        for hit in RUN.f_m.values.reshape(3, -1)
    ]


@pytest.fixture(scope="module")
def plain():
    return modes(hits(0.0), 3)


@pytest.mark.parametrize(("form", "size"), [("parabola", 3.0), ("half sine", 3.0), ("discharge", 0.3)])
def test_modes_are_those_without_the_bow(plain, form, size):
    """The hits are of 0.5 to 1 V."""
    bowed = modes(hits(size * BOWS[form]), 3)
    assert bowed.hits == 3 and bowed.bow > 0 and plain.bow == 0
    for one, other, (hertz, q, _) in zip(plain.modes, bowed.modes, three_modes.TRUE, strict=True):
        assert other.frequency.value == pytest.approx(hertz, rel=1e-3) and other.q.value == pytest.approx(q, rel=5e-3)
        apart = abs(other.frequency.value - one.frequency.value)
        assert apart < max(one.frequency.standard_error, other.frequency.standard_error)


def test_a_polynomial_is_what_is_taken_off():
    noise = 1e-3 * np.random.default_rng(0).normal(size=X.size)
    left, span = without_bow(noise + 0.4 * X**3 - 0.2 * X + 5.0)
    assert span == pytest.approx(np.ptp(0.4 * X**3 - 0.2 * X), rel=0.01)
    # The median of 416 samples is known to 6e-5, and six numbers go through 24 of them.
    assert np.std(left - noise) < 2e-4


@pytest.mark.parametrize("run", [RUN, rigs.hammer_rig(seed=3)], ids=["taps", "hammer"])
def test_what_has_no_bow_is_left_alone(run):
    reading = run.f_m.values
    left, span = without_bow(reading)
    assert span == 0 and np.array_equal(left, reading - np.median(reading)) and pick_hits(run).bow == 0
