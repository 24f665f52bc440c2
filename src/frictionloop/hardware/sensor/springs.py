"""Leaf springs of the suspension: stiffness, stress, and the resonance of the mass on them.

A leaf is a thin beam whose ends do not rotate. By Castigliano's theorem its compliance along a direction u is

    C_u = 1/(E I) integral (lever of u about the centroid of the leaf)^2 ds + 1/(E A) integral (tangent . u)^2 ds,

with I = b t^3/12 and A = b t. The first term is bending, the second stretching, which leaves a straight leaf finitely
stiff along itself. In the axes of its chord a circular arc has no cross-compliance. Not counted: shear, the stiffening
of leaves much wider than thick (up to 1/(1 - nu^2), 12 % for aluminium), and play in the clamps.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from frictionloop.parameters.sensor_design import ArcSprings, SensorDesign, StraightSprings

Leaves = ArcSprings | StraightSprings


class Pair(NamedTuple):
    """A quantity of one leaf along its chord and across it."""

    along: float
    across: float


class Stiffness(NamedTuple):
    """Stiffness of the whole suspension along the two axes of the plate, N/m."""

    x_n_per_m: float
    y_n_per_m: float


def _section(leaves: Leaves) -> tuple[float, float, float]:
    """Return E I (N m^2), E A (N) and the thickness (m)."""
    modulus, width, thickness = leaves.youngs_modulus_gpa * 1e9, leaves.width_mm * 1e-3, leaves.thickness_mm * 1e-3
    return modulus * width * thickness**3 / 12, modulus * width * thickness, thickness


def leaf_stiffness(leaves: Leaves) -> Pair:
    """Return the stiffness of one leaf in N/m, along and across its chord, with ends that do not rotate.

    A semicircle has 3.36 E I/R^3 along and 0.637 E I/R^3 across, a straight leaf E A/L and 12 E I/L^3.
    """
    bending, stretching, _ = _section(leaves)
    if isinstance(leaves, StraightSprings):
        length = leaves.length_mm * 1e-3
        return Pair(stretching / length, 12 * bending / length**3)
    radius, half = leaves.radius_mm * 1e-3, math.radians(leaves.angle_deg) / 2
    # x = R sin(p), y = R cos(p), |p| <= half: integrals of (y - mean y)^2, x^2 and of the squared tangent.
    height = half + math.sin(half) * math.cos(half) - 2 * math.sin(half) ** 2 / half
    length = half - math.sin(half) * math.cos(half)
    along = radius**3 * height / bending + radius * (half + math.sin(half) * math.cos(half)) / stretching
    across = radius**3 * length / bending + radius * length / stretching
    return Pair(1 / along, 1 / across)


def stiffness(leaves: Leaves) -> Stiffness:
    """Return k_x and k_y of all leaves together in N/m.

    "around" turns half of the leaves by 90 degrees, k_x = k_y = n/2 (k_along + k_across); "parallel" has
    k_x = n k_across, k_y = n k_along.
    """
    one = leaf_stiffness(leaves)
    if leaves.arrangement == "parallel":
        return Stiffness(leaves.count * one.across, leaves.count * one.along)
    both = leaves.count / 2 * (one.along + one.across)
    return Stiffness(both, both)


def peak_stress_pa(leaves: Leaves, travel_m: float) -> float:
    """Return the largest stress |M| t/(2 I) + |N|/A in the leaves when the frame moves by ``travel_m`` along x, in Pa.

    A straight leaf moved across itself has 3 E t x/L^2.
    """
    one, (bending, stretching, thickness) = leaf_stiffness(leaves), _section(leaves)
    modulus = leaves.youngs_modulus_gpa * 1e9
    per_moment, per_force = thickness / 2 * modulus / bending, modulus / stretching
    if isinstance(leaves, StraightSprings):
        lever = np.array([leaves.length_mm * 1e-3 / 2])
        stresses = {"across": one.across * lever * per_moment, "along": np.array([one.along * per_force])}
    else:
        radius, half = leaves.radius_mm * 1e-3, math.radians(leaves.angle_deg) / 2
        p = np.linspace(0.0, half, 1001)
        mean = math.sin(half) / half
        along = radius * np.abs(np.cos(p) - mean) * per_moment + np.abs(np.cos(p)) * per_force
        across = radius * np.sin(p) * per_moment + np.abs(np.sin(p)) * per_force
        stresses = {"along": one.along * np.abs(along), "across": one.across * np.abs(across)}
    moved = ("across",) if leaves.arrangement == "parallel" else ("along", "across")
    return max(float(stresses[direction].max()) for direction in moved) * abs(travel_m)


def resonance_hz(design: SensorDesign) -> float:
    """Return the first resonance along x, sqrt(k_x/m)/(2 pi), in Hz (paper, Sec. 3.1)."""
    return math.sqrt(stiffness(design.springs).x_n_per_m / design.moving.mass_kg) / (2 * math.pi)


def travel_m(design: SensorDesign, force_n: float | None = None) -> float:
    """Return the displacement F/k_x in m, at the end of the range if no force is given."""
    return (design.load.range_n if force_n is None else force_n) / stiffness(design.springs).x_n_per_m
