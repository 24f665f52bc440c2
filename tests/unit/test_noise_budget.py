"""The noise budget: closed forms of each term, equipartition, Lyapunov's integral, and what always holds."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import signal
from scipy.constants import Boltzmann
from scipy.linalg import solve_continuous_lyapunov

from frictionloop.hardware.sensor import front_end, springs
from frictionloop.hardware.sensor.noise_budget import noise_budget, side_density_pm_rthz
from frictionloop.parameters.sensor_design import SensorDesign

DESIGN = SensorDesign()
IDEAL = DESIGN.evolve(
    {
        "amplifier.gain_bandwidth_mhz": 1e6,
        "amplifier.feedback_mohm": 1e4,
        "amplifier.current_noise_fa_rthz": 0.0,
        "electrodes.imbalance": 0.0,
        "filters.bandpass_q": 0.5,
    },
)
"""The op-amp and the band-pass so wide that the usual formulas hold."""


def term(design, name, force=0.0):
    return next(each for each in noise_budget(design, force).terms if each.name == name)


def stiffness(design):
    return springs.stiffness(design.springs).x_n_per_m


def test_amplifier_noise_is_noise_gain_times_root_two_over_the_slope():
    capacitance = 8.8541878e-12 * 200e-6 / 100e-6
    noise_gain = 1 + (capacitance + 100e-12) / 22e-12
    slope_v_per_m = 10 * capacitance / 22e-12 / 100e-6  # of one side
    one_side_m = math.sqrt(2) * 4.5e-9 * noise_gain / slope_v_per_m
    expected = one_side_m / math.sqrt(2) * stiffness(IDEAL)  # two sides: noise sqrt(2), signal 2
    assert term(IDEAL, "amplifier voltage").density_n_rthz == pytest.approx(expected, rel=1e-3)
    assert one_side_m == pytest.approx(0.50e-12, rel=0.02)


def test_feedback_noise_is_its_current_into_the_capacitor():
    design = IDEAL.evolve({"amplifier.feedback_mohm": 100.0})
    current = math.sqrt(4 * Boltzmann * 295.0 / 100e6)
    volts = current / (2 * math.pi * 120e3 * 22e-12)
    slope_v_per_m = 10 * 8.8541878e-12 * 200e-6 / 100e-6**2 / 22e-12
    expected = volts / slope_v_per_m * stiffness(design)
    assert term(design, "Rf thermal").density_n_rthz == pytest.approx(expected, rel=1e-3)


def test_filter_noise_is_that_of_its_resistors_and_buffer():
    resistor = 0.5 * 2 * math.pi * 120e3 * 100e-6
    lowpass = 1 / (2 * math.pi * 1000 * 100e-9)
    at_carrier = 2 * (4 * Boltzmann * 295.0 * resistor + 4.5e-9**2)
    volts = math.sqrt(at_carrier + 4 * Boltzmann * 295.0 * lowpass)
    slope_v_per_m = 10 * 8.8541878e-12 * 200e-6 / 100e-6**2 / 22e-12
    expected = volts / slope_v_per_m / math.sqrt(2) * stiffness(IDEAL)
    assert term(IDEAL, "filters").density_n_rthz == pytest.approx(expected, rel=1e-3)


@given(st.floats(0, 0.3), st.floats(-2.5, 2.5))
def test_excitation_noise_is_the_unbalance_times_the_noise(imbalance, force):
    design = DESIGN.evolve({"electrodes.imbalance": imbalance})
    part = springs.travel_m(design, force) / 100e-6
    unequal = (imbalance + part) / (1 - part**2)
    expected = abs(unequal) * 1e-6 * 100e-6 * stiffness(design)
    assert term(design, "excitation amplitude", force).density_n_rthz == pytest.approx(expected, rel=1e-5, abs=1e-20)


@given(st.floats(0, 0.3), st.floats(-2.5, 2.5))
def test_the_ratio_has_no_excitation_noise(imbalance, force):
    design = DESIGN.evolve({"electrodes.imbalance": imbalance, "readout.form": "ratio"})
    assert term(design, "excitation amplitude", force).rms_n < 1e-18


def test_both_forms_are_the_same_at_rest_when_balanced():
    design = DESIGN.evolve({"electrodes.imbalance": 0.0})
    other = design.evolve({"readout.form": "ratio"})
    for one, two in zip(noise_budget(design).terms, noise_budget(other).terms, strict=True):
        assert one.rms_n == pytest.approx(two.rms_n, rel=1e-12, abs=1e-18)


@given(st.integers(6, 24))
def test_quantisation_is_a_step_over_root_twelve(bits):
    """Of a signal that wanders over many steps, measured."""
    design = DESIGN.evolve({"adc.bits": bits})
    step = 5.0 / 2**bits
    found = term(design, "ADC quantisation")
    error = np.random.default_rng(1).uniform(-step / 2, step / 2, 100_000)
    assert found.rms_n == pytest.approx(error.std(), rel=0.01)  # statistics: 0.1 %
    assert found.density_n_rthz * math.sqrt(2500) == pytest.approx(found.rms_n, rel=1e-12)


@pytest.mark.parametrize("q", [1.0, 20.0, 300.0])
def test_thermal_motion_has_the_energy_of_equipartition(q):
    """k <x^2> = kB T whatever Q is, seen through a low-pass that passes it all."""
    design = DESIGN.evolve({"moving.q": q, "filters.cutoff_hz": 1e6, "filters.bandpass_q": 0.5})
    expected = math.sqrt(Boltzmann * 295.0 * stiffness(design))
    # At Q = 1 the force noise passes above resonance; 1/f^4 leaves little beyond the grid.
    assert term(design, "thermomechanical").rms_n == pytest.approx(expected, rel=2e-4)


@pytest.mark.parametrize("q", [0.7, 20.0, 200.0])
@pytest.mark.parametrize("cutoff", [300.0, 1000.0])
def test_vibration_agrees_with_lyapunovs_integral(q, cutoff):
    design = DESIGN.evolve({"moving.q": q, "filters.cutoff_hz": cutoff, "filters.bandpass_q": 0.5})
    omega, turn = 2 * math.pi * springs.resonance_hz(design), 2 * math.pi * cutoff
    # In units of the resonance: suspension, then the pole.
    ratio = turn / omega
    a = np.array([[0, 1, 0], [-1, -1 / q, 0], [ratio, 0, -ratio]])
    covariance = solve_continuous_lyapunov(a, -np.outer([0, 1, 0], [0, 1, 0]))
    band_hz = covariance[2, 2] * omega / 2  # one-sided
    expected = 0.4 * 1e-6 * math.sqrt(band_hz)
    # The band-pass of Q = 0.5 is a pole at 120 kHz, which the closed form leaves out.
    assert term(design, "base vibration").rms_n == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize("q", [1.0, 5.0, 40.0])
def test_electronics_pass_two_poles(q):
    """Flat noise before the band-pass meets its envelope pole f/(2 Q) and the low-pass: pi/2 f1 f2/(f1 + f2)."""
    design = DESIGN.evolve({"filters.bandpass_q": q, "amplifier.gain_bandwidth_mhz": 1e6})
    found = term(design, "amplifier voltage")
    envelope = 120e3 / (2 * q)
    band = math.pi / 2 * envelope * 1000 / (envelope + 1000)
    # The envelope of a band-pass is a pole to the order of its relative width, which only matters far beyond 1 kHz.
    assert found.rms_n == pytest.approx(found.density_n_rthz * math.sqrt(band), rel=3e-3)


def test_tilt_is_weight():
    assert term(DESIGN, "tilt").rms_n == pytest.approx(0.4 * 9.80665 * 1e-6, rel=1e-9)
    assert math.isnan(term(DESIGN, "tilt").density_n_rthz)


def test_side_density():
    amplifier = term(IDEAL, "amplifier voltage").density_n_rthz
    others = [term(IDEAL, name).density_n_rthz for name in ("Rf thermal", "filters")]
    expected = math.hypot(amplifier, *others) * math.sqrt(2) / stiffness(IDEAL) * 1e12
    assert side_density_pm_rthz(IDEAL) == pytest.approx(expected, rel=1e-9)


def test_a_mode_of_welch_agrees_with_the_demodulated_density():
    """Noise through the discrete filter, times the reference: the density beside the closed form."""
    rate, carrier, q = 2.4e6, 120e3, 5.0
    omega = 2 * math.pi * carrier
    num, den = signal.bilinear([omega / q, 0], [1, omega / q, (2 * rate * math.tan(omega / 2 / rate)) ** 2], rate)
    noise = np.random.default_rng(3).standard_normal(2_400_000) * math.sqrt(rate / 2)
    time = np.arange(noise.size) / rate
    product = signal.lfilter(num, den, noise) * 2 * np.cos(omega * time)
    f, density = signal.welch(product, rate, nperseg=24_000)
    low = (f > 100) & (f < 3000)
    # 100 segments (200 overlapping), 29 lines: 2 % in power. Warped tuning leaves 1 %.
    tuned = DESIGN.evolve({"filters.bandpass_q": q})
    from frictionloop.hardware.sensor.front_end import bandpass

    model = front_end.demodulated_density(tuned, lambda x: np.abs(bandpass(tuned).response(x)), f[low])
    assert np.mean(density[low] / model**2) == pytest.approx(1.0, abs=0.06)


@settings(max_examples=30)
@given(
    st.floats(20, 400),
    st.floats(50, 1000),
    st.floats(0.5, 10),
    st.floats(0, 0.1),
    st.sampled_from(["subtraction", "ratio"]),
)
def test_any_budget_adds_up(gap, area, volts, imbalance, form):
    overrides = {
        "electrodes.gap_um": gap,
        "electrodes.area_mm2": area,
        "excitation.amplitude_v": volts,
        "electrodes.imbalance": imbalance,
        "readout.form": form,
    }
    budget = noise_budget(DESIGN.evolve(overrides))
    assert all(each.rms_n >= 0 and math.isfinite(each.rms_n) for each in budget.terms)
    assert budget.dominant.rms_n <= budget.rms_n <= math.sqrt(len(budget.terms)) * budget.dominant.rms_n
    assert budget.rms_n**2 == pytest.approx(sum(each.rms_n**2 for each in budget.terms), rel=1e-12)
    quieter = noise_budget(DESIGN.evolve(overrides | {"electrodes.gap_um": gap / 1.5}))
    assert quieter.white_density_n_rthz < budget.white_density_n_rthz
