"""Leaf springs: closed forms of beam theory, a frame of straight beam elements, and what must hold for any leaf."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from frictionloop.hardware.sensor.springs import leaf_stiffness, peak_stress_pa, resonance_hz, stiffness, travel_m
from frictionloop.parameters.sensor_design import ArcSprings, SensorDesign, StraightSprings

THIN = 1e-3
"""Thickness in mm at which stretching no longer counts beside bending."""
arcs = st.builds(
    ArcSprings,
    radius_mm=st.floats(5, 50),
    angle_deg=st.floats(30, 300),
    width_mm=st.floats(2, 30),
    thickness_mm=st.floats(0.1, 1.2),
    arrangement=st.sampled_from(["around", "parallel"]),
)


def bending(leaves):
    """E I / R^3 of an arc."""
    inertia = leaves.width_mm * leaves.thickness_mm**3 / 12 * 1e-12
    return leaves.youngs_modulus_gpa * 1e9 * inertia / (leaves.radius_mm * 1e-3) ** 3


def frame(leaves, elements=400):
    """Solve the leaf as a chain of straight beams clamped at one end, the other end not rotating.

    Returns the 2 x 2 stiffness (chord, across) and, per direction, the largest stress for a unit displacement.
    """
    half = math.radians(leaves.angle_deg) / 2
    angles = np.linspace(-half, half, elements + 1)
    nodes = leaves.radius_mm * 1e-3 * np.column_stack([np.sin(angles), np.cos(angles)])
    modulus, width, thick = leaves.youngs_modulus_gpa * 1e9, leaves.width_mm * 1e-3, leaves.thickness_mm * 1e-3
    ei, ea = modulus * width * thick**3 / 12, modulus * width * thick
    size = 3 * (elements + 1)
    total, pieces = np.zeros((size, size)), []
    for i in range(elements):
        dx, dy = nodes[i + 1] - nodes[i]
        length = math.hypot(dx, dy)
        c, s = dx / length, dy / length
        a, b, d, e, f = ea / length, 12 * ei / length**3, 6 * ei / length**2, 4 * ei / length, 2 * ei / length
        local = np.array(
            [
                [a, 0, 0, -a, 0, 0],
                [0, b, d, 0, -b, d],
                [0, d, e, 0, -d, f],
                [-a, 0, 0, a, 0, 0],
                [0, -b, -d, 0, b, -d],
                [0, d, f, 0, -d, e],
            ]
        )
        turn = np.zeros((6, 6))
        for k in (0, 3):
            turn[k : k + 3, k : k + 3] = [[c, s, 0], [-s, c, 0], [0, 0, 1]]
        which = slice(3 * i, 3 * i + 6)
        total[which, which] += turn.T @ local @ turn
        pieces.append((which, local @ turn))
    free = np.arange(3, size - 3)
    stiff, stress = np.zeros((2, 2)), []
    for direction in range(2):
        u = np.zeros(size)
        u[size - 3 + direction] = 1.0
        u[free] = np.linalg.solve(total[np.ix_(free, free)], -total[np.ix_(free, [size - 3 + direction])][:, 0])
        stiff[:, direction] = (total @ u)[size - 3 : size - 1]
        ends = [force @ u[which] for which, force in pieces]
        stress.append(
            max(abs(q[j + 2]) * thick / 2 * modulus / ei + abs(q[j]) * modulus / ea for q in ends for j in (0, 3))
        )
    return stiff, stress


def test_a_semicircle_has_the_textbook_coefficients():
    leaves = ArcSprings(thickness_mm=THIN)
    one, unit = leaf_stiffness(leaves), bending(leaves)
    # integral of (sin - 2/pi)^2 over (0, pi) is pi/2 - 4/pi; of cos^2 it is pi/2
    assert one.along == pytest.approx(unit / (math.pi / 2 - 4 / math.pi), rel=1e-6)
    assert one.across == pytest.approx(unit / (math.pi / 2), rel=1e-6)


def test_a_quarter_circle_has_the_textbook_compliance():
    """Along the radii at its ends it is R^3/(E I) [[pi/4 - 2/pi, 2/pi - 1/2], [same, same]] in size."""
    leaves = ArcSprings(angle_deg=90, thickness_mm=THIN)
    one, unit = leaf_stiffness(leaves), bending(leaves)
    turn = np.array([[1, -1], [1, 1]]) / math.sqrt(2)
    compliance = turn @ np.diag([unit / one.along, unit / one.across]) @ turn.T
    own, cross = math.pi / 4 - 2 / math.pi, 2 / math.pi - 1 / 2
    np.testing.assert_allclose(np.abs(compliance), [[own, cross], [cross, own]], rtol=1e-5)


def test_a_straight_leaf_is_a_guided_beam():
    leaves = StraightSprings(length_mm=30, width_mm=20, thickness_mm=1.15)
    modulus, b, t, length = 73.1e9, 20e-3, 1.15e-3, 30e-3
    one = leaf_stiffness(leaves)
    assert one.across == pytest.approx(modulus * b * (t / length) ** 3, rel=1e-12)
    assert one.along == pytest.approx(modulus * b * t / length, rel=1e-12)
    assert stiffness(leaves).x_n_per_m == pytest.approx(4 * one.across, rel=1e-12)
    assert peak_stress_pa(leaves, 1e-6) == pytest.approx(3 * modulus * t * 1e-6 / length**2, rel=1e-12)


def test_a_flat_arc_is_a_straight_leaf_across():
    """Across its chord an arc of 10 degrees is a straight leaf of its length to the square of the angle."""
    arc = ArcSprings(angle_deg=10, radius_mm=30 / math.radians(10), thickness_mm=0.5)
    straight = StraightSprings(length_mm=30, thickness_mm=0.5)
    assert leaf_stiffness(arc).across == pytest.approx(leaf_stiffness(straight).across, rel=math.radians(10) ** 2)


@pytest.mark.parametrize(("angle", "thickness"), [(180, 0.7), (90, 1.0), (45, 0.5), (270, 2.0)])
def test_a_frame_of_beam_elements_agrees(angle, thickness):
    leaves = ArcSprings(angle_deg=angle, thickness_mm=thickness, arrangement="parallel")
    stiff, stress = frame(leaves)
    one = leaf_stiffness(leaves)
    # Chords in place of arcs: an error of (angle of an element)^2, at most (4.7/400)^2 / 6 of a length, cubed, with
    # a cancellation that multiplies it for flat arcs.
    np.testing.assert_allclose(np.diag(stiff), one, rtol=3e-4)
    assert abs(stiff[0, 1]) < 1e-6 * max(one)  # rounding of the solver is that of its largest entries
    assert peak_stress_pa(leaves, 1.0) == pytest.approx(stress[1], rel=1e-3)
    around = leaves.model_copy(update={"arrangement": "around"})
    assert peak_stress_pa(around, 1.0) == pytest.approx(max(stress), rel=1e-3)


@given(arcs)
def test_four_around_are_the_sum_of_turned_leaves(leaves):
    one = leaf_stiffness(leaves)
    around = stiffness(leaves.model_copy(update={"arrangement": "around"}))
    total = np.zeros((2, 2))
    for quarter in range(4):
        angle = quarter * math.pi / 2
        turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
        total += turn @ np.diag(one) @ turn.T
    np.testing.assert_allclose(total, np.diag(around), rtol=1e-12, atol=1e-12 * around.x_n_per_m)


@given(arcs, st.floats(1.01, 2))
def test_thicker_is_stiffer_by_at_most_the_cube(leaves, factor):
    thicker = leaves.model_copy(update={"thickness_mm": leaves.thickness_mm * factor})
    for before, after in zip(leaf_stiffness(leaves), leaf_stiffness(thicker), strict=True):
        assert factor * (1 - 1e-12) <= after / before <= factor**3 * (1 + 1e-12)


@given(arcs, st.floats(1e-7, 1e-4))
def test_stress_is_linear_in_travel_and_even(leaves, travel):
    assert peak_stress_pa(leaves, -travel) == peak_stress_pa(leaves, travel)
    assert peak_stress_pa(leaves, 2 * travel) == pytest.approx(2 * peak_stress_pa(leaves, travel), rel=1e-12)


def test_resonance_and_travel():
    """The mass let go at the end of its travel comes back after one period."""
    design = SensorDesign()
    k, start = stiffness(design.springs).x_n_per_m, travel_m(design)
    assert start == pytest.approx(2.5 / k, rel=1e-15)
    period = 1 / resonance_hz(design)
    path = solve_ivp(lambda _, y: [y[1], -k / 0.4 * y[0]], (0, period), [start, 0], rtol=1e-10, atol=1e-16)
    assert path.y[0, -1] == pytest.approx(start, rel=1e-7)
    assert resonance_hz(design) == pytest.approx(145, abs=0.05)  # the paper's, for which the default was chosen
