"""A finger on the plate: damping and the ripple along a stroke."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictionloop.hardware.plate.drive import amplitude_left, finger_effect, mode_factor
from frictionloop.parameters.plate_design import PlateDesign

HALF_MM = 140 / 11.5


def effect(plate, finger, contact):
    """What a finger changes on a plate of Q 230."""
    touched = {"finger.resistance_n_s_per_m": finger, "finger.contact_mm": contact, "drive.quality_factor": 230.0}
    return finger_effect(PlateDesign().evolve(touched), plate, HALF_MM)


@given(st.floats(-30, 30), st.floats(3, 30), st.floats(0.5, 25))
def test_the_mode_factor_is_the_mean_over_the_disc(position, half_mm, contact):
    """Chords of the disc, weighted by their length; Gauss-Chebyshev nodes of the second kind are exact for them."""
    n = np.arange(1, 201)
    angle = n * np.pi / 201
    x, weight = position + contact / 2 * np.cos(angle), np.sin(angle) ** 2
    direct = np.sum(weight * np.cos(np.pi / half_mm * x) ** 2) / np.sum(weight)
    assert mode_factor(position, half_mm, contact) == pytest.approx(direct, abs=1e-12)


@given(st.floats(-30, 30), st.floats(3, 30), st.floats(0.5, 25))
def test_the_ripple_has_the_period_of_half_a_wavelength(position, half_mm, contact):
    here = mode_factor(position, half_mm, contact)
    assert mode_factor(position + half_mm, half_mm, contact) == pytest.approx(here, abs=1e-12)
    assert mode_factor(position + half_mm / 2, half_mm, contact) == pytest.approx(1 - here, abs=1e-12)
    assert 0 <= here <= 1


def test_a_point_feels_the_mode_itself_and_a_large_contact_its_mean():
    x = np.linspace(0, 12, 7)
    np.testing.assert_allclose(mode_factor(x, HALF_MM, 1e-4), np.cos(np.pi * x / HALF_MM) ** 2, atol=1e-9)
    np.testing.assert_allclose(mode_factor(x, HALF_MM, 1e4), 0.5, atol=1e-4)


def test_figures_of_the_research_notes():
    """Notes C.5: at Q 230 a finger of 55 N s/m leaves 0.86 and Q 198, at Q 500 it leaves 0.74; ripple 10 to 20 %."""
    found = effect(168.0, 55.0, 10.0)
    assert found.amplitude_on_touch == pytest.approx(0.86, abs=5e-3)
    assert found.quality_on_touch == pytest.approx(198, abs=0.5)
    assert amplitude_left(0.5, 168.0 * 230 / 500, 55.0) == pytest.approx(0.74, abs=5e-3)
    assert 0.10 < found.felt_ripple < 0.20
    assert found.plate_ripple < found.felt_ripple


@given(st.floats(1, 1000), st.floats(0, 500), st.floats(0, 1))
def test_damping_adds_up(plate, finger, factor):
    """Amplitude goes as 1/damping at the same drive, and so does Q."""
    left = amplitude_left(factor, plate, finger)
    assert 0 < left <= 1
    assert left * (plate + factor * finger) == pytest.approx(plate, rel=1e-12)


@given(st.floats(1, 1000), st.floats(0, 500), st.floats(1, 20))
def test_the_ripple_of_the_plate_in_closed_form(plate, finger, contact):
    """Amplitudes 1/(R_p + R_f (1 +- s)/2) differ by R_f s/2 over their mean R_p + R_f/2."""
    spread = abs(float(mode_factor(0.0, HALF_MM, contact)) - 0.5)
    found = effect(plate, finger, contact)
    assert found.plate_ripple == pytest.approx(finger * spread / (plate + finger / 2), abs=1e-9)


def test_without_a_finger_only_the_mode_itself_is_felt():
    found = effect(168.0, 0.0, 10.0)
    assert found.amplitude_on_touch == 1.0
    assert found.plate_ripple == 0.0
    high, low = (math.sqrt(float(mode_factor(x, HALF_MM, 10.0))) for x in (0.0, HALF_MM / 2))
    assert found.felt_ripple == pytest.approx((high - low) / (high + low), rel=1e-9)
