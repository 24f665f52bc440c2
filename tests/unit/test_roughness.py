"""Spatial noise: exact standard deviation, 1/kappa spectrum, fixed in space, the same bits in lanes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import njit
from scipy.integrate import quad
from scipy.stats import chi2, kstest

from frictionloop.physics.roughness import (
    CELLS,
    WAVES,
    cells_per_m,
    roughness_between,
    roughness_cells,
    roughness_table,
)

PER_M = cells_per_m(100.0)


@njit
def roughness_step(position_m, per_m, table):
    cell, after, fraction = roughness_cells(position_m, per_m)
    return roughness_between(fraction, table[cell], table[after])


@njit
def rough_lanes(x, per_m, tables):
    out = np.empty(x.size)
    for i in range(x.size):
        cell, after, fraction = roughness_cells(x[i], per_m)
        out[i] = roughness_between(fraction, tables[cell, i], tables[after, i])
    return out


@given(st.integers(0, 2**64 - 1), st.floats(0.001, 0.3))
@settings(max_examples=20, deadline=None)
def test_rms_over_a_period_is_as_asked(seed, rms):
    table = roughness_table(rms, seed)
    assert np.mean(table) == pytest.approx(0, abs=1e-15)
    # Gauss-Legendre of two points is exact for the square of a line.
    fraction = 0.5 + np.array([-0.5, 0.5]) / np.sqrt(3)
    points = table[:, None] + fraction * (np.roll(table, -1) - table)[:, None]
    assert np.sqrt(np.mean(points**2)) == pytest.approx(rms, rel=1e-12)
    # Lines lose little of what the table holds.
    assert 1 < np.std(table) / rms < 1.01


def test_the_spectrum_is_one_over_kappa():
    k = np.arange(1, WAVES + 1)
    power = np.zeros((400, WAVES))
    for seed in range(400):
        power[seed] = np.abs(np.fft.rfft(roughness_table(1.0, seed))[1 : WAVES + 1]) ** 2
    slope = np.polyfit(np.log(k), np.log(power.mean(axis=0)), 1)[0]
    # The logarithm of each mean deviates by 1/20; over 1024 values with a standard deviation of ln k of 1.0.
    assert slope == pytest.approx(-1.0, abs=5 * 0.05 / np.sqrt(WAVES))
    # Each line is exponential about its mean, as for Gaussian noise (the scale to an exact rms hardly narrows it).
    high = (power * k)[:, 100:] / np.mean((power * k)[:, 100:])
    assert kstest(high[:, ::50].ravel() * 2, chi2(2).cdf).pvalue > 1e-3


def test_nothing_above_the_shortest_wave():
    spectrum = np.abs(np.fft.rfft(roughness_table(1.0, 0)))
    assert np.max(spectrum[WAVES + 1 :]) < 1e-12 * np.max(spectrum)


@given(st.floats(-1, 1), st.integers(0, 5))
def test_lookup_is_periodic_linear_interpolation(x, seed):
    table = TABLES[seed]
    grid = np.arange(CELLS) / PER_M
    exact = np.interp(x, grid, table, period=0.1)
    steepest = np.max(np.abs(np.diff(table, append=table[0])))
    assert roughness_step(x, PER_M, table) == pytest.approx(exact, abs=1e-10 * steepest)


TABLES = [roughness_table(0.05, seed) for seed in range(6)]


def test_it_is_fixed_in_space_whatever_the_way_there():
    x = np.array([0.0123, -0.0301, 0.0999])
    for there in x:
        cell, after, fraction = roughness_cells(there, PER_M)
        assert after == (cell + 1) % CELLS
        assert 0 <= fraction <= 1
        assert (cell + fraction) / PER_M == pytest.approx(there % 0.1, abs=1e-15)
        assert roughness_step(there, PER_M, TABLES[0]) == roughness_step(there, PER_M, TABLES[0].copy())


def test_mean_over_a_period_of_the_joined_function_vanishes():
    pieces = [quad(lambda x: roughness_step(x, PER_M, TABLES[1]), i / PER_M, (i + 1) / PER_M)[0] for i in range(64)]
    trapezium = (TABLES[1][:64] + TABLES[1][1:65]) / 2 / PER_M
    np.testing.assert_allclose(pieces, trapezium, rtol=0, atol=1e-15)


@given(st.lists(st.floats(-0.2, 0.2), min_size=6, max_size=6))
def test_lanes_have_the_bits_of_a_single_step(x):
    together = rough_lanes(np.array(x), PER_M, np.array(TABLES).T.copy())
    assert list(together) == [roughness_step(x[i], PER_M, TABLES[i]) for i in range(6)]


def test_a_seed_gives_its_table_and_seeds_differ():
    np.testing.assert_array_equal(roughness_table(0.05, 3), TABLES[3])
    assert not np.any(TABLES[3] == TABLES[4])
    assert np.all(roughness_table(0.0, 1) == 0.0)
