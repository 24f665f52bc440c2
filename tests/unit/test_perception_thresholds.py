"""Thresholds of vibration and of force: the table, straight lines in log-log, the impedance of the fingertip."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import interp1d
from scipy.optimize import minimize_scalar

from frictionloop.parameters import Skin
from frictionloop.perception import displacement_threshold_um, force_threshold_n
from frictionloop.perception.thresholds import THRESHOLD_UM
from frictionloop.quantities import Lti

frequency = st.floats(1, 500)
finger = st.builds(
    Skin, stiffness_n_m=st.floats(100, 1e4), damping_n_s_m=st.floats(0.1, 10), mass_kg=st.floats(1e-6, 1e-3)
)

# Forces worked out by hand, in mN to two digits.
PRINTED_MN = {
    **{1: 25, 5: 16, 10: 10, 20: 6.0, 40: 2.6, 60: 1.3, 80: 0.77, 100: 0.46, 150: 0.24},
    **{200: 0.18, 250: 0.17, 300: 0.22, 400: 0.46, 500: 0.94},
}


def test_the_table_of_g2():
    frequencies = [1, 3, 5, 10, 20, 30, 40, 60, 80, 100, 150, 200, 250, 300, 400, 500]
    printed = [25, 20, 16, 10, 6, 4, 2.5, 1.2, 0.7, 0.4, 0.18, 0.12, 0.10, 0.11, 0.18, 0.30]
    np.testing.assert_allclose(displacement_threshold_um(frequencies), printed, rtol=1e-14)


@given(frequency)
def test_straight_lines_in_log_log(f):
    line = interp1d(np.log10(list(THRESHOLD_UM)), np.log10(list(THRESHOLD_UM.values())))
    assert displacement_threshold_um(f) == pytest.approx(10 ** line(math.log10(f)), rel=1e-12)


def test_halfway_between_two_points_is_their_geometric_mean():
    assert displacement_threshold_um(math.sqrt(10 * 20)) == pytest.approx(math.sqrt(10 * 6), rel=1e-13)


@given(frequency, finger)
def test_the_force_is_that_of_the_skin_moved_by_the_threshold(f, tip):
    skin = Lti((tip.mass_kg, tip.damping_n_s_m, tip.stiffness_n_m), (1.0,))
    assert force_threshold_n(f, tip) == pytest.approx(
        1e-6 * displacement_threshold_um(f) * abs(skin.response(f)), rel=1e-12
    )


@pytest.mark.parametrize(("frequency_hz", "printed_mn"), PRINTED_MN.items())
def test_printed_forces(frequency_hz, printed_mn):
    got = 1e3 * float(force_threshold_n(frequency_hz))
    assert float(f"{got:.2g}") == printed_mn


def test_the_least_force_is_within_a_factor_of_three_of_the_papers():
    least = minimize_scalar(lambda f: float(force_threshold_n(f)), bounds=(150, 400), method="bounded")
    assert 200 < least.x < 300
    assert 5e-4 / 3 < least.fun < 5e-4 * 3


@given(frequency, finger)
def test_a_stiff_finger_needs_more_force_below_its_resonance(f, tip):
    stiffer = tip.model_copy(update={"stiffness_n_m": 2 * tip.stiffness_n_m})
    if (2 * math.pi * f) ** 2 * tip.mass_kg < tip.stiffness_n_m:
        assert force_threshold_n(f, stiffer) > force_threshold_n(f, tip)
