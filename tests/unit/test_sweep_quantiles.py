"""Quantiles of a sweep in shards: those of the values themselves within what is promised, in whatever shards."""

from __future__ import annotations

import re

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

import frictionloop as fl
from frictionloop.loop.sweep_quantiles import LEAST, MOST, WITHIN, _added, _read, bucket, value_of

BENCH = fl.bench().evolve(fl.RETUNED)
GRID = {"finger": fl.fingers(4, 1), "controller.kp": [0.01, 0.03, 0.05]}
HOW = {"duration_s": 0.2, "seeds": 2, "metrics": ["rms_error", "saturation_index"], "progress": False}
SHARES = [0.0, 0.1, 0.5, 0.9, 1.0]
SIZES = st.floats(LEAST, MOST) | st.floats(-MOST, -LEAST) | st.just(0.0)


@given(values=st.lists(SIZES, min_size=1))
def test_what_stands_for_a_value_is_within_the_promise(values):
    values = np.array(values)
    found = value_of(bucket(values))
    assert (abs(found - values) <= WITHIN * (1 + 1e-9) * abs(values)).all()
    order = np.argsort(values)
    assert (np.diff(bucket(values)[order]) >= 0).all()


def test_what_is_too_small_is_zero_and_too_large_infinite():
    odd = np.array([0.0, 1e-16, -1e-16, 1e16, np.inf, -np.inf])
    np.testing.assert_array_equal(value_of(bucket(odd)), [0.0, 0.0, 0.0, np.inf, np.inf, -np.inf])


@given(
    parts=st.lists(st.lists(SIZES, min_size=1), min_size=1, max_size=4), shares=st.lists(st.floats(0, 1), min_size=1)
)
def test_counts_of_parts_give_the_quantiles_that_numpy_gives_of_all(parts, shares):
    counts = None
    for each in parts:
        counts = _added(counts, np.unique(bucket(np.array(each)) + OFFSET, return_counts=True))
    exact = np.quantile(np.concatenate(parts), shares, method="inverted_cdf")
    np.testing.assert_allclose(_read(counts, 1, np.array(shares))[:, 0], exact, rtol=WITHIN * (1 + 1e-9))


OFFSET = bucket(np.array([np.inf]))[0]


def test_a_group_without_values_has_no_quantile():
    own = 2 * OFFSET + 1
    counts = np.array([own + OFFSET + 5, own + OFFSET + 7]), np.array([3, 1])
    found = _read(counts, 3, np.array([0.5, 1.0]))
    assert np.isnan(found[:, [0, 2]]).all()
    np.testing.assert_array_equal(found[:, 1], value_of(np.array([5, 7])))


def test_of_a_sweep_by_its_gain_in_whatever_shards(tmp_path):
    whole = fl.sweep(BENCH, GRID, **HOW)
    found = []
    for parts in (1, 4, 5):
        for part in range(1, parts + 1):
            fl.sweep(BENCH, GRID, path=tmp_path / str(parts), shard=(part, parts), **HOW)
        found.append(fl.sweep_quantiles(tmp_path / str(parts), SHARES))
    for each in found[1:]:
        xr.testing.assert_identical(found[0], each)
    assert found[0]["rms_error"].dims == ("quantile", "controller.kp")
    assert found[0]["rms_error"].attrs == whole["rms_error"].attrs
    flat = whole["rms_error"].transpose("finger", "seed", "controller.kp").values.reshape(-1, 3)
    exact = np.quantile(flat, SHARES, axis=0, method="inverted_cdf")
    np.testing.assert_allclose(found[0]["rms_error"], exact, rtol=WITHIN * (1 + 1e-9))


def test_a_part_that_cannot_be_read_is_told_and_shares_are_checked(tmp_path):
    for part in (1, 2):
        fl.sweep(BENCH, GRID, path=tmp_path, shard=(part, 2), **HOW)
    with pytest.raises(fl.FrictionloopError, match=re.escape("quantiles = ")):
        fl.sweep_quantiles(tmp_path, [0.5, 1.5])
    alone = fl.open_sweep(tmp_path).isel(finger=slice(2)).compute()
    second = tmp_path / "shard-2-of-2.h5"
    second.write_bytes(second.read_bytes()[: second.stat().st_size // 2])
    with pytest.warns(UserWarning, match="cannot read shards 2"):
        found = fl.sweep_quantiles(tmp_path, [1.0])
    largest = alone["rms_error"].max(["finger", "seed"])
    np.testing.assert_allclose(found["rms_error"][0], largest, rtol=WITHIN * (1 + 1e-9))
