"""Electrodes: the plate capacitor, the force it makes, and the designs that cannot work."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictionloop.hardware.sensor.electrodes import capacitance_f, check_geometry, electrostatic_n_per_m
from frictionloop.parameters.sensor_design import SensorDesign
from frictionloop.quantities import FrictionloopError

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
