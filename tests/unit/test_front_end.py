"""Electrodes and electronics of one side: plate capacitor, nodal analysis, ideal limits, both ways of reading out."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictionloop.hardware.sensor import front_end, springs
from frictionloop.hardware.sensor.front_end import capacitance_f, check_geometry, electrostatic_n_per_m
from frictionloop.parameters.sensor_design import SensorDesign
from frictionloop.quantities import FrictionloopError

DESIGN = SensorDesign()
FREQUENCIES = np.geomspace(10, 1e7, 61)
designs = st.builds(
    lambda cf, rf, cpar, gbw, q: DESIGN.evolve(
        {
            "amplifier.feedback_pf": cf,
            "amplifier.feedback_mohm": rf,
            "amplifier.parasitic_pf": cpar,
            "amplifier.gain_bandwidth_mhz": gbw,
            "filters.bandpass_q": q,
        }
    ),
    st.floats(1, 200),
    st.floats(0.01, 1000),
    st.floats(0, 1000),
    st.floats(1, 1000),
    st.floats(0.5, 100),
)


def nodal(design, electrode_f, frequency_hz, excite=0.0, offset=0.0, current=0.0):
    """Solve the nodes (virtual ground, output) of the op-amp stage: excitation, noise voltage at +, noise current."""
    a = design.amplifier
    s = 2j * math.pi * frequency_hz
    yf = s * a.feedback_pf * 1e-12 + 1e-6 / a.feedback_mohm
    y_in = s * (electrode_f + a.parasitic_pf * 1e-12)
    turn = 2 * math.pi * a.gain_bandwidth_mhz * 1e6
    gain = turn / (s + turn / a.open_loop_gain)
    matrix = np.array([[y_in + yf, -yf], [gain, 1.0]])
    return np.linalg.solve(matrix, [s * electrode_f * excite + current, gain * offset])[1]


@given(designs, st.floats(1e-13, 1e-9))
def test_the_op_amp_stage_is_its_circuit(design, electrode_f):
    blocks = front_end.charge_amplifier(design, electrode_f)
    for f in FREQUENCIES[::6]:
        at = np.array(f)
        assert -electrode_f * blocks.charge.response(at) == pytest.approx(nodal(design, electrode_f, f, excite=1.0))
        assert blocks.voltage_noise.response(at) == pytest.approx(nodal(design, electrode_f, f, offset=1.0))
        assert -blocks.current_noise.response(at) == pytest.approx(nodal(design, electrode_f, f, current=1.0))


def test_with_a_fast_op_amp_it_is_the_charge_over_the_capacitor():
    fast = DESIGN.evolve({"amplifier.gain_bandwidth_mhz": 1e6, "amplifier.feedback_mohm": 1e6})
    blocks, carrier = front_end.charge_amplifier(fast, 17.7e-12), np.array(120e3)
    assert blocks.charge.response(carrier) == pytest.approx(1 / 22e-12, rel=1e-5)
    assert blocks.voltage_noise.response(carrier) == pytest.approx(1 + (17.7 + 100) / 22, rel=1e-5)  # 6.35


@given(designs)
def test_the_band_pass_is_its_parts(design):
    parts = front_end.bandpass_parts(design)
    s = 2j * math.pi * FREQUENCIES
    tank = 1 / (1 / (s * parts.coil_h) + s * parts.capacitor_f)
    np.testing.assert_allclose(
        front_end.bandpass(design).response(FREQUENCIES), tank / (tank + parts.resistor_ohm), rtol=1e-7
    )
    assert front_end.bandpass(design).response(np.array(120e3)) == pytest.approx(1.0, abs=1e-9)


def test_the_low_pass_is_its_parts():
    resistor, capacitor = front_end.lowpass_resistor_ohm(DESIGN), 100e-9
    s = 2j * math.pi * FREQUENCIES
    np.testing.assert_allclose(
        front_end.lowpass(DESIGN).response(FREQUENCIES), 1 / (1 + s * resistor * capacitor), rtol=1e-12
    )


def test_thermal_noise_of_a_kilohm():
    # 4.07 nV/rtHz at 300 K, from any table
    warm = DESIGN.evolve({"environment.temperature_k": 300.0})
    assert front_end.thermal_v_rthz(warm, 1000.0) == pytest.approx(4.07e-9, rel=1e-3)


@given(st.floats(-2.5, 2.5), st.floats(0, 0.3))
def test_the_ratio_reads_the_force_exactly(force, imbalance):
    design = DESIGN.evolve({"readout.form": "ratio", "electrodes.imbalance": imbalance})
    read = front_end.readings(design, *front_end.amplitudes_v(design, force)).force_n
    # r = (d + p)/(1 + d p) with p = x/e, read through its slope at rest: p/(1 + d p).
    part = springs.travel_m(design, force) / 100e-6
    assert read == pytest.approx(force / (1 + imbalance * part), abs=1e-12)


@given(st.floats(-2.5, 2.5))
def test_the_subtraction_errs_by_the_square(force):
    design = DESIGN.evolve({"electrodes.imbalance": 0.0})
    part = springs.travel_m(design, force) / 100e-6
    read = front_end.readings(design, *front_end.amplitudes_v(design, force)).force_n
    assert read == pytest.approx(force / (1 - part**2), abs=1e-12)


@pytest.mark.parametrize("form", ["subtraction", "ratio"])
@pytest.mark.parametrize("force", [-2.5, 0.0, 1.0])
def test_slopes_are_those_of_the_reading(form, force):
    design = DESIGN.evolve({"readout.form": form})
    volts = front_end.amplitudes_v(design, force)
    found, h = front_end.readings(design, *volts), 1e-5
    for side, slope in ((0, found.per_plus_n_per_v), (1, found.per_minus_n_per_v)):
        moved = [list(volts), list(volts)]
        moved[0][side] -= h
        moved[1][side] += h
        low, high = (front_end.readings(design, *v).force_n for v in moved)
        assert slope == pytest.approx((high - low) / (2 * h), rel=1e-6)


@given(st.floats(-2.5, 2.5))
def test_amplitudes_are_charge_over_feedback(force):
    """Within 3 %: Rf and the op-amp's speed are the difference."""
    volts = front_end.amplitudes_v(DESIGN, force)
    sides = capacitance_f(DESIGN, springs.travel_m(DESIGN, force))
    np.testing.assert_allclose(volts, np.array(sides) / 22e-12 * 10, rtol=0.03)


BALANCED = SensorDesign().evolve({"electrodes.imbalance": 0.0})


def test_a_plate_capacitor():
    # 8.854 pF/m * 200 mm^2 / 100 um
    assert capacitance_f(BALANCED).plus == pytest.approx(8.8541878e-12 * 200e-6 / 100e-6, rel=1e-7)
    slope = (capacitance_f(BALANCED, 1e-12).plus - capacitance_f(BALANCED, -1e-12).plus) / 2e-12
    assert slope == pytest.approx(capacitance_f(BALANCED).plus / 100e-6, rel=1e-4)


@given(st.floats(-0.9, 0.9), st.floats(0, 0.4))
def test_the_ratio_of_charges_is_the_displacement(part, imbalance):
    design = SensorDesign().evolve({"electrodes.imbalance": imbalance})
    plus, minus = capacitance_f(design, part * 100e-6)
    expected = (imbalance + part) / (1 + imbalance * part)
    assert (plus - minus) / (plus + minus) == pytest.approx(expected, abs=1e-12)


def test_the_electrostatic_force_grows_as_the_energy_says():
    """k = -d^2 U/dx^2 at constant voltage has the sign of a negative spring: the curvature of the energy C V^2/2."""
    h, mean_square = 1e-7, 50.0  # 10 V zero-to-peak
    energy = [sum(capacitance_f(BALANCED, x)) * mean_square / 2 for x in (-h, 0.0, h)]
    assert electrostatic_n_per_m(BALANCED) == pytest.approx((energy[0] - 2 * energy[1] + energy[2]) / h**2, rel=1e-4)


@given(st.floats(1, 50))
def test_the_gap_is_judged_against_the_travel(gap_um):
    design = SensorDesign().evolve({"electrodes.gap_um": gap_um})
    travel_um = 2.5 / 0.332036  # N over N/um, from test_springs
    if gap_um > travel_um * 1.001:
        check_geometry(design)
    elif gap_um < travel_um * 0.999:
        with pytest.raises(FrictionloopError, match=r"^electrodes\.gap_um"):
            check_geometry(design)
