"""The lookup table: exact inverse and N entries, with their error bound; overdrive in closed form."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import frictionloop as fl
from frictionloop.control.lookup import (
    interpolate_step,
    inverse_step,
    lookup_table,
    overdrive_gains,
    overdrive_step,
    table_position,
)

MODEL = fl.Model()


def g(a, model=MODEL):
    return model.nominal_n * math.exp(-model.susceptibility_per_um2 * a * a)


def exact_inverse(u, model=MODEL):
    return inverse_step(u, math.log2(model.nominal_n), math.log(2.0) / model.susceptibility_per_um2)


def table_inverse(u, model):
    table, low = lookup_table(model), model.floor_n
    cells_per_n = (model.table_size - 1) / (model.nominal_n - low)
    cell, after, fraction = table_position(u, low, cells_per_n, float(model.table_size - 2))
    assert 0 <= cell <= model.table_size - 2
    return interpolate_step(fraction, table[cell], table[after])


models = st.builds(
    fl.Model,
    nominal_n=st.floats(0.1, 10),
    susceptibility_per_um2=st.floats(0.05, 1),
    max_amplitude_um=st.floats(0.5, 2.5),
    table_size=st.integers(2, 2000),
)


@given(models, st.floats(0, 1))
def test_the_exact_inverse_undoes_equation_1(model, share):
    u = min(model.floor_n + share * (model.nominal_n - model.floor_n), model.nominal_n)
    # tau a^2 = ln(f0/u) <= 6.25 comes from two logarithms of up to 13 binary digits, 3 ulp each: 6 * 2^-49 ln 2,
    # and the same error of the exponent is the relative error of g.
    assert g(exact_inverse(u, model), model) == pytest.approx(u, rel=1e-14)


def test_the_ends_of_the_clamp():
    assert exact_inverse(MODEL.nominal_n) == 0.0
    assert exact_inverse(MODEL.floor_n) == pytest.approx(MODEL.max_amplitude_um, rel=1e-14)
    for size in (2, 3, 64):
        model = MODEL.model_copy(update={"table_size": size})
        # a^2 between the last two entries is rounded at the size of the last but one, 6 um^2 at most: sqrt(6 * 2^-52).
        assert table_inverse(model.nominal_n, model) == pytest.approx(0.0, abs=4e-8)
        assert table_inverse(model.floor_n, model) == pytest.approx(2.5, rel=1e-14)


@given(models, st.floats(0, 1))
def test_the_error_of_the_table_stays_below_the_bound(model, share):
    low, high = model.floor_n, model.nominal_n
    u = min(low + share * (high - low), high)
    h = (high - low) / (model.table_size - 1)
    bottom = low + math.floor((u - low) / h) * h  # of the cell
    # a^2 = ln(f0/u)/tau is convex: the chord lies above it by at most h^2/8 times the largest second derivative
    # 1/(tau u^2), at the bottom of the cell; a^2 too large by x makes the force too small by u (1 - e^(-tau x)).
    bound = u * -math.expm1(-(h**2) / (8 * max(bottom - 1e-9 * h, low) ** 2))
    short = u - g(table_inverse(u, model), model)
    assert -1e-14 * high <= short <= bound + 1e-14 * high


@pytest.mark.parametrize("size", [16, 64, 256, 1024])
def test_the_bound_stated_in_the_module(size):
    model = MODEL.model_copy(update={"table_size": size})
    u = np.linspace(model.floor_n, model.nominal_n, 20 * size)
    error = u - np.array([g(table_inverse(v, model), model) for v in u])
    h = (model.nominal_n - model.floor_n) / (size - 1)
    # h^2/(8u) holds to first order in h/u: the cell's bottom is at most h below u, (u/(u-h))^2 <= 1 + 3 h/u here.
    stated = h**2 / (8 * u)
    assert np.all(error <= stated * (1 + 3 * h / u) ** 2 + 1e-15)
    # And it is no exaggeration: in the lowest cell, in the middle, the error is nearly that.
    assert error.max() > 0.6 * stated.max()


def test_entries_are_exact():
    model = MODEL.model_copy(update={"table_size": 11})
    u = np.linspace(model.floor_n, model.nominal_n, 11)
    np.testing.assert_allclose(lookup_table(model), np.log(0.8 / u) / 0.38, rtol=1e-14)
    np.testing.assert_allclose(lookup_table(model), fl.amplitude_for(u, fl.Friction()) ** 2, rtol=1e-14, atol=1e-15)


def test_a_large_table_is_the_exact_inverse():
    few, exact = (
        fl.simulate(fl.paper().evolve({"controller.model.table_size": size}), 0.2)["f_a"].values for size in (65536, 0)
    )
    # h = 1.1e-5 N: the table's force errs by up to h^2/(8 * 0.074) = 2e-10 N, the loop at kp = 10 by at most a few
    # times that, since it attenuates what stands inside it.
    assert np.abs(few - exact).max() < 1e-9


TS, PLATE_HZ, LARGEST_UM = 2e-4, 100.0, 2.5
LEFT = math.exp(-2.0 * math.pi * PLATE_HZ * TS)
"""Share of a difference that the plate's lag leaves after a period."""
GAINS = overdrive_gains(fl.LookupController(overdrive=True))


@given(st.floats(0.0, LARGEST_UM), st.floats(-10.0, 10.0))
def test_the_plate_goes_to_what_is_wanted_or_as_near_as_a_period_lets_it(amplitude_um, wanted_um):
    """Commands from 0 to a_max reach p a to p a + (1 - p) a_max; the belief is the lag's answer to what is given."""
    believed, command = overdrive_step(amplitude_um, wanted_um, GAINS)
    assert 0.0 <= command <= LARGEST_UM
    assert believed == pytest.approx(command + (amplitude_um - command) * LEFT, abs=1e-14)
    lowest, highest = LEFT * amplitude_um, LARGEST_UM - LEFT * (LARGEST_UM - amplitude_um)
    assert believed == pytest.approx(min(max(wanted_um, lowest), highest), abs=1e-13)


def test_a_leap_takes_the_least_time_that_the_drive_allows():
    """Full drive up, none down, until the level is reached, then the level: the plate's own amplitude, each period."""
    levels_n = (0.8, 0.1, 0.7, 0.8)
    steps = fl.Steps(times_s=(0.0, 0.01, 0.03, 0.04), levels_n=levels_n)
    system = fl.paper().evolve(
        {"controller": {"kind": "lookup", "overdrive": True}, "setpoint": steps, "disturbance": fl.Constant(offset_n=0)}
    )
    run = fl.simulate(system, 0.06)
    exact, wanted_um = [0.0], np.sqrt(np.log(0.8 / run["f_r"].values) / 0.38)
    for wanted in wanted_um[:-1]:
        before = exact[-1]
        full, none = LARGEST_UM + (before - LARGEST_UM) * LEFT, before * LEFT
        exact.append(min(wanted, full) if wanted > before else max(wanted, none))
    assert np.count_nonzero(np.abs(exact - np.roll(wanted_um, 1)) > 0.01) > 30  # most leaps take many periods
    np.testing.assert_allclose(run["a"].values, exact, rtol=0, atol=1e-9)
