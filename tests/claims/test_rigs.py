"""The rigs of Fig. 4 as the report uses them, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from frictionloop.identification import r2_with_friction
from frictionloop.report.rig_characterisation import FLOORS, PRINTED_R2, SHAKING, STILL, loads_n, rubbing_bench


def test_the_rubbing_string_gives_the_printed_r2(results):
    exponent = rubbing_bench().pulley.string_friction * np.pi / 2
    assert r2_with_friction(loads_n().tolist(), exponent) == pytest.approx(PRINTED_R2, abs=1e-9)
    # The rig swings, its weights and its converter err, and the sensor is not quite straight.
    assert results.rigs.rubbing.r2 == pytest.approx(PRINTED_R2, abs=0.002)


def test_the_hammer_finds_what_is_built_in(results):
    found = results.rigs.resonance
    for estimate, true in ((found.resonance, 145.0), (found.q, 20.0)):
        low, high = estimate.interval(0.999)
        assert low <= true <= high


def test_a_still_base_leaves_electronics_and_converter(results):
    white = 2.3e-6 * np.sqrt(np.pi / 2 * 300.0)
    converter = 5.0 / 2**16 / np.sqrt(12)
    assert results.rigs.rms_n(STILL) == pytest.approx(np.hypot(white, converter), rel=0.02)
    # Below the pole the converter's noise lies under that of the electronics, spread to half the rate.
    floor = np.hypot(2.3e-6, converter / np.sqrt(2500.0))
    assert results.rigs.density_n_rthz(STILL) == pytest.approx(floor, rel=0.05)


def test_a_shaking_base_is_louder_and_peaks_at_the_resonance(results):
    spectrum = results.rigs.spectrum(SHAKING)
    assert spectrum.frequency_hz[np.argmax(spectrum.density)] == pytest.approx(145, abs=2)
    assert results.rigs.rms_n(SHAKING) > 3 * results.rigs.rms_n(STILL)
    assert set(results.rigs.floors) == set(FLOORS)
