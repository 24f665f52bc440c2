"""What the paper prints of its sensor (Sec. 3.3), rebuilt: simulated rigs, analysed as recordings."""

from __future__ import annotations

import math

import numpy as np
import pytest
from floor_terms import floor_terms
from noise_corner import fit_corner

import frictionloop.identification as find
from frictionloop.identification import rigs
from frictionloop.parameters.calibration_bench import CalibrationBench

BENCH = CalibrationBench()
LOADS_N = np.arange(11) * 0.02 * 9.80665
UP_AND_DOWN_KG = (*np.arange(11) * 0.02, *np.arange(9, -1, -1) * 0.02)


def blocked(exponent):
    """A string that slides over a peg, of friction ``exponent``."""
    return {"pulley.bearing_friction": 1e9, "pulley.string_friction": rigs.string_friction_for(exponent)}


# Fig. 4a


@pytest.mark.parametrize("seed", range(3))
def test_a_sane_rig_gives_four_nines(seed):
    found = find.weights(rigs.weights_rig(seed=seed), tolerance=BENCH.weights.tolerance)
    assert found.r2 > 0.9999
    # The residual is the curvature: 1.01 * 0.0057 F^3/2.5^2 less its best line, 2.45^3 of that times sqrt(1/7 - 1/16 -
    # 12 (1/5 - 1/8)^2) for loads spread evenly; with eleven of them within a tenth.
    curved = 0.0057 * 2.4516625**3 / 2.5**2 * math.sqrt(1 / 7 - 1 / 16 - 12 * (1 / 5 - 1 / 8) ** 2)
    assert found.residual_rms_n == pytest.approx(curved, rel=0.15)
    assert found.residual_rms_n > 20 * 5e-5  # far above the noise floor all the same
    assert found.weights_error < 1e-4


def test_without_curvature_gain_and_offset_come_back():
    bench = BENCH.evolve({"errors.nonlinearity": 0.0})
    found = find.weights(rigs.weights_rig(bench=bench), tolerance=bench.weights.tolerance)
    # What the line does not know: the tolerance of the weights and the pulley, which up and down nearly cancels.
    unseen = 1.01 * math.hypot(3 * found.weights_error, rigs.friction_exponent(bench.pulley))
    assert found.sensitivity.value == pytest.approx(1.01, abs=3 * found.sensitivity.standard_error + unseen)
    assert found.offset.value == pytest.approx(0.005, abs=4 * found.offset.standard_error + bench.pulley.drag_n)
    assert 1 - found.r2 < 1e-6


def test_the_printed_r2_needs_a_pulley_that_hardly_turns():
    """R2 = 0.95 is b = 0.14: a bearing with a friction of 0.8, five hundred times a ball bearing's."""
    exponent = find.exponent_for_r2(0.95, LOADS_N)
    bench = BENCH.evolve(blocked(exponent) | {"errors.nonlinearity": 0.0, "weights.swing_deg": 0.0})
    found = find.weights(rigs.weights_rig(UP_AND_DOWN_KG, bench))
    assert found.r2 == pytest.approx(0.95, abs=1e-3)
    assert found.residual_rms_n / found.load_std_n == pytest.approx(find.residual_share(0.95), rel=0.1)
    assert rigs.bearing_friction_for(exponent, BENCH.pulley) > 500 * BENCH.pulley.bearing_friction
    assert (5e-5 / found.load_std_n) ** 2 < 1e-8  # what a residual of the floor would leave of 1 - R2
    friction = find.pulley_friction(found)
    low, high = friction.exponent.interval(0.999)
    assert low < exponent < high
    assert friction.sensitivity.value == pytest.approx(1.01, rel=1e-3)


def test_a_pulley_that_drags_one_way_hides_from_r2():
    bench = BENCH.evolve(blocked(0.12) | {"errors.nonlinearity": 0.0, "errors.gain_error": 0.0})
    found = find.weights(rigs.weights_rig(UP_AND_DOWN_KG[:11], bench))
    assert found.r2 > 0.9999
    assert found.sensitivity.value == pytest.approx(math.exp(-0.12), rel=1e-2)


# Fig. 4b, response


@pytest.mark.parametrize("rate_hz", [5000.0, 25000.0])
def test_resonance_and_q_are_found_within_their_intervals(rate_hz):
    found = find.fit_resonance(find.response(rigs.hammer_rig(rate_hz=rate_hz, seed=1)))
    # One draw, so at 99.9 %; how often 95 % holds is counted below.
    for estimate, exact in ((found.resonance, 145.0), (found.q, 20.0)):
        low, high = estimate.interval(0.999)
        assert low < exact < high
    assert found.resonance.standard_error < 0.05
    assert found.cutoff_hz == pytest.approx(1000.0, rel=0.02)


@pytest.mark.parametrize("seeds", [pytest.param(40, marks=pytest.mark.slow), pytest.param(200, marks=pytest.mark.soak)])
def test_intervals_hold_as_often_as_they_say(seeds):
    inside = np.zeros(2)
    for seed in range(seeds):
        found = find.fit_resonance(find.response(rigs.hammer_rig(seed=seed)))
        for k, (estimate, exact) in enumerate(((found.resonance, 145.0), (found.q, 20.0))):
            low, high = estimate.interval()
            inside[k] += low < exact < high
    # 95 % less three standard errors of a binomial.
    assert np.all(inside / seeds > 0.95 - 3 * math.sqrt(0.95 * 0.05 / seeds))


def test_other_suspensions():
    for hertz, q in ((250.0, 20.0), (145.0, 5.0)):
        bench = BENCH.evolve({"sensor.resonance_hz": hertz, "sensor.q": q})
        run = rigs.hammer_rig(bench, rate_hz=10000.0, pulse_s=2e-3)
        found = find.fit_resonance(find.response(run))
        assert found.resonance.value == pytest.approx(hertz, abs=4 * found.resonance.standard_error)
        assert found.q.value == pytest.approx(q, abs=4 * found.q.standard_error)


# Fig. 4b, noise

ISOLATED = BENCH.evolve({"base.vibration_ug": 0.0, "sensor.cutoff_hz": 300.0, "errors.gain_error": 0.0})


def test_the_floor_is_5e_5_n_and_94_db_on_an_isolated_bench():
    spectrum = find.noise_spectrum(rigs.floor_rig(ISOLATED, seed=2))
    rms = find.band_rms(spectrum, 2, 2500)
    terms = floor_terms(ISOLATED)
    assert rms.value == pytest.approx(terms.rms_n, abs=4 * rms.standard_error)
    assert terms.electronics_n == pytest.approx(5e-5, rel=2e-3)
    # 93.98 dB less what the converter adds; the paper prints 93.
    assert find.dynamic_range_db(2.5, math.hypot(terms.electronics_n, terms.converter_n)) < 93.98
    assert round(find.dynamic_range_db(2.5, rms.value)) == 93
    fit = fit_corner(spectrum, 3, 2500)
    low, high = fit.corner.interval(0.999)
    assert low < 300.0 < high
    low, high = fit.density.interval(0.999)
    assert low < 2.3e-6 < high


def test_a_bench_that_shakes_sets_the_floor():
    bench = BENCH.evolve({"errors.gain_error": 0.0})
    spectrum = find.noise_spectrum(rigs.floor_rig(bench, duration_s=60.0, seed=1), segment_s=4.0)
    terms, rms = floor_terms(bench), find.band_rms(spectrum, 1, 2500)
    assert rms.value == pytest.approx(terms.rms_n, abs=4 * rms.standard_error)
    assert terms.base_n > 4 * 5e-5
    peak = spectrum.frequency_hz[np.argmax(spectrum.power_density)]
    assert peak == pytest.approx(145.0, abs=145.0 / 20)


def test_what_converters_leave():
    """Sixteen bits add step/sqrt(12). With thirteen the step is wider than the noise, and the offset decides."""
    rms = {}
    for bits in (13, 16):
        step_n = 5.0 / 2**bits
        for share in (0.0, 0.5):
            bench = ISOLATED.evolve({"sensor.adc_bits": bits, "errors.offset_n": share * step_n})
            rms[bits, share] = float(rigs.floor_rig(bench).f_m.std())
    for share in (0.0, 0.5):
        assert rms[16, share] == pytest.approx(math.hypot(4.993e-5, 5.0 / 2**16 / math.sqrt(12)), rel=0.05)
    assert rms[13, 0.0] < 1e-6  # one and the same number for ten seconds: no noise, and nothing seen below the step
    assert rms[13, 0.5] == pytest.approx(5.0 / 2**14, rel=0.01)  # back and forth between two
