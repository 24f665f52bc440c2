"""A sweep in parts: the bits of the whole, whichever parts there are, in whatever order, after whatever happened."""

from __future__ import annotations

import math
import pickle
import re
import shutil

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

import frictionloop as fl
from frictionloop.loop import sweep_shards
from frictionloop.loop.sweep_points import points_of
from frictionloop.loop.sweep_shards import points_of_shard
from frictionloop.quantities.whole_files import only_writer

BENCH = fl.bench().evolve(fl.RETUNED)
KPS = [0.01, 0.03, 0.05]
GRID = {"finger": fl.fingers(4, 1), "controller.kp": KPS}
HOW = {"duration_s": 0.2, "seeds": 2, "metrics": ["rms_error", "saturation_index"], "progress": False}


def run(folder, part, parts, points=GRID, **more):
    return fl.sweep(BENCH, points, path=folder, shard=(part, parts), **(HOW | more))


def refused(said):
    return pytest.raises(fl.FrictionloopError, match=re.escape(said))


@pytest.fixture(scope="module")
def whole():
    return fl.sweep(BENCH, GRID, **HOW)


@given(shape=st.lists(st.integers(1, 9), min_size=1, max_size=3), data=st.data())
def test_parts_are_disjoint_in_order_and_together_the_whole(shape, data):
    parts = data.draw(st.integers(1, math.prod(shape)))
    ranges = [points_of_shard((part, parts), tuple(shape)) for part in range(1, parts + 1)]
    assert [k for each in ranges for k in each] == list(range(math.prod(shape)))
    assert all(ranges)


@given(
    axes=st.dictionaries(st.sampled_from("abc"), st.lists(st.floats(0, 1), min_size=1, max_size=4), min_size=1),
    seeds=st.integers(1, 3),
)
def test_lanes_are_numbered_as_the_flattened_result(axes, seeds):
    points = points_of(axes, seeds)
    lanes = points.runs(range(math.prod(points.shape)))
    for lane, (override, seed) in enumerate(lanes):
        *places, at = np.unravel_index(lane, points.shape)
        assert seed == points.seeds[at]
        assert override == {path: values[k] for k, (path, values) in zip(places, axes.items(), strict=True)}


@pytest.mark.parametrize("parts", [1, 3, 4, 5, 12])
def test_shards_have_the_bits_of_the_whole(tmp_path, whole, parts):
    for part in np.random.default_rng(parts).permutation(parts) + 1:
        run(tmp_path, int(part), parts)
    opened = fl.open_sweep(tmp_path)
    xr.testing.assert_identical(opened.compute(), whole)
    assert fl.sweep_status(tmp_path).rows() == [("done", f"{parts} of {parts} shards, 24 of 24 runs")]


def test_without_dask_they_are_read_at_once(tmp_path, whole, monkeypatch):
    for part in (1, 2):
        run(tmp_path, part, 2)
    monkeypatch.setitem(__import__("sys").modules, "dask.array", None)
    xr.testing.assert_identical(fl.open_sweep(tmp_path), whole)


def test_a_list_of_fingers_keeps_their_values(tmp_path):
    people = fl.fingers(7, 2)
    assert pickle.loads(pickle.dumps(people)) == people
    for part in (1, 3):
        run(tmp_path, part, 3, people)
    assert np.isnan(fl.open_sweep(tmp_path)["motion.person"].values).tolist() == [False] * 2 + [True] * 2 + [False] * 3
    run(tmp_path, 2, 3, people)
    xr.testing.assert_identical(fl.open_sweep(tmp_path).compute(), fl.sweep(BENCH, people, **HOW))


def test_what_is_missing_stopped_damaged_or_running_is_told_and_run_again(tmp_path, whole, monkeypatch):
    for part in (2, 3, 4):
        run(tmp_path, part, 4)
    second, third = (tmp_path / f"shard-{part}-of-4.h5" for part in (2, 3))
    second.write_bytes(second.read_bytes()[: second.stat().st_size // 2])

    def stopped(*_):
        raise KeyboardInterrupt

    third.unlink()
    monkeypatch.setattr("frictionloop.loop.sweep._run", stopped)
    with pytest.raises(fl.SweepInterrupted):
        run(tmp_path, 3, 4, n_jobs=1)
    monkeypatch.undo()
    with only_writer(tmp_path / "shard-4-of-4.h5"):
        told = fl.sweep_status(tmp_path)
        with refused("is written by another process"):
            run(tmp_path, 4, 4)
    assert (told.missing, told.unfinished, told.damaged, told.running) == ((1,), (3,), (2,), (4,))
    with pytest.warns(UserWarning, match="cannot read shards 2"):
        assert np.isnan(fl.open_sweep(tmp_path)["rms_error"].values[:3]).all()
    before = (tmp_path / "shard-4-of-4.h5").read_bytes()
    with pytest.warns(UserWarning, match=r"shard-2-of-4\.h5: is damaged; it is made anew"):
        run(tmp_path, 2, 4)
    for part in (1, 3, 4):
        run(tmp_path, part, 4)
    assert (tmp_path / "shard-4-of-4.h5").read_bytes() == before
    xr.testing.assert_identical(fl.open_sweep(tmp_path).compute(), whole)


def test_what_does_not_belong_together_is_refused(tmp_path, monkeypatch):
    run(tmp_path, 1, 3)
    with refused("shard-1-of-3.h5: is one of 3 shards, not of 4"):
        run(tmp_path, 1, 4)
    with refused("shard-1-of-3.h5: is of another sweep"):
        run(tmp_path, 2, 3, {"controller.kp": KPS})
    monkeypatch.setattr("frictionloop.loop.sweep.computing", lambda: "later")
    with refused("shard-1-of-3.h5: is of other code"):
        run(tmp_path, 2, 3)
    other = tmp_path / "other"
    run(other, 2, 3)
    shutil.copy(other / "shard-2-of-3.h5", tmp_path)
    for read in (fl.open_sweep, fl.sweep_status):
        with refused("shard-2-of-3.h5: is of other code"):
            read(tmp_path)
    for shard in ((0, 3), (4, 3), (1, 13), (1.0, 3)):
        with refused("shard = "):
            run(tmp_path / "new", *shard)
    with refused("has no shards"):
        fl.open_sweep(tmp_path / "new")
    with refused("path is missing"):
        run(None, 1, 3)


def test_a_folder_without_locks_is_written_all_the_same(tmp_path, whole, monkeypatch):
    import fcntl

    def none(*_):
        raise OSError(37, "No locks available")

    monkeypatch.setattr(fcntl, "flock", none)
    run(tmp_path, 1, 1)
    xr.testing.assert_identical(fl.open_sweep(tmp_path).compute(), whole)


def test_fingers_are_drawn_where_they_are_asked_for():
    many, few = fl.fingers(5_000_000, 3), fl.fingers(2000, 3)
    assert many[:3] == few[:3] and many[1999] == few[-1] and len(many[4_999_999]) == len(few[0])
    assert [each["motion.person"] for each in few] == list(range(2000))
    assert sweep_shards._spans([1, 3, 4, 5, 9]) == "1,3-5,9"
