"""Ctrl-C keeps what is done, and only the same sweep goes on from it."""

from __future__ import annotations

import gc
import multiprocessing
import signal
import threading
import time
from itertools import count

import numpy as np
import pytest
import xarray as xr

import frictionloop as fl
from frictionloop.loop import sweep as sweep_module
from frictionloop.quantities.whole_files import only_writer

BASE = fl.paper().evolve({"sensor.noise_rms_n": 1e-3})
KPS = {"controller.kp": np.linspace(0.5, 20.0, 100)}  # three full tiles and one of four lanes
OPTIONS = {"duration_s": 0.02, "seeds": [3]}


def interrupted(monkeypatch, after, **options):
    """Run the sweep with Ctrl-C after some tiles; return what the exception carries."""
    done, lock, run_tile = [], threading.Lock(), sweep_module.run_tile

    def until_ctrl_c(tile, periods):
        with lock:
            if len(done) >= after:
                raise KeyboardInterrupt
            done.append(tile)
        run_tile(tile, periods)

    monkeypatch.setattr(sweep_module, "run_tile", until_ctrl_c)
    with pytest.raises(fl.SweepInterrupted) as stopped:
        fl.sweep(BASE, KPS, n_jobs=1, **OPTIONS, **options)
    monkeypatch.setattr(sweep_module, "run_tile", run_tile)
    return stopped.value.partial


@pytest.fixture(scope="module")
def whole():
    return fl.sweep(BASE, KPS, **OPTIONS)


def test_ctrl_c_carries_what_is_done(monkeypatch, whole):
    partial = interrupted(monkeypatch, after=2)
    done = partial["rms_error"].notnull()
    assert int(done.sum()) == 64  # two tiles of 32 lanes
    for name in whole.data_vars:
        np.testing.assert_array_equal(partial[name].values[done], whole[name].values[done])
        assert partial[name].where(~done).isnull().all()


def test_sweep_interrupted_is_a_keyboard_interrupt():
    assert issubclass(fl.SweepInterrupted, KeyboardInterrupt)


@pytest.mark.parametrize("after", [0, 1, 3])
def test_resuming_equals_never_having_stopped(monkeypatch, tmp_path, whole, after):
    path = tmp_path / "sweep.h5"
    partial = interrupted(monkeypatch, after, path=path)
    xr.testing.assert_identical(fl.load(path), partial)
    run_tile, tiles = sweep_module.run_tile, []

    def counted(tile, periods):
        tiles.append(tile)
        run_tile(tile, periods)

    monkeypatch.setattr(sweep_module, "run_tile", counted)
    resumed = fl.sweep(BASE, KPS, path=path, resume=True, **OPTIONS)
    assert len(tiles) == 4 - after  # what was done is not done again
    xr.testing.assert_identical(resumed, whole)
    xr.testing.assert_identical(fl.load(path), whole)


def test_resuming_what_is_finished_runs_nothing(monkeypatch, tmp_path, whole):
    path = tmp_path / "sweep.h5"
    fl.sweep(BASE, KPS, path=path, **OPTIONS)
    monkeypatch.setattr(sweep_module, "run_tile", lambda *_: pytest.fail("something has run"))
    xr.testing.assert_identical(fl.sweep(BASE, KPS, path=path, resume=True, **OPTIONS), whole)


def test_resuming_without_a_file_starts(tmp_path, whole):
    xr.testing.assert_identical(fl.sweep(BASE, KPS, path=tmp_path / "new.h5", resume=True, **OPTIONS), whole)


def test_a_file_is_started_over_by_the_same_sweep_or_by_force(tmp_path, whole):
    path = tmp_path / "sweep.h5"
    for strange in (b"thesis", b""):
        path.write_bytes(strange)
        if strange:
            with pytest.raises(fl.FrictionloopError, match="holds something else; --force"):
                fl.sweep(BASE, KPS, path=path, **OPTIONS)
            with pytest.raises(fl.FrictionloopError, match="was not written by frictionloop"):
                fl.save(whole, path)
            assert path.read_bytes() == strange
    fl.sweep(BASE, {"controller.kp": [1.0]}, path=path, **OPTIONS)
    with pytest.raises(fl.FrictionloopError, match="holds something else; --force"):
        fl.sweep(BASE, KPS, path=path, **OPTIONS)
    for force in (True, False):
        fl.sweep(BASE, KPS, path=path, force=force, **OPTIONS)
        xr.testing.assert_identical(fl.load(path), whole)
    assert [each.name for each in tmp_path.iterdir()] == ["sweep.h5"]


def test_a_file_has_one_writer(tmp_path):
    """A second writer is refused while the first one works, in any thread, and the lock goes with the first."""
    path, begun, end = tmp_path / "sweep.h5", threading.Event(), threading.Event()

    def write():
        with only_writer(path):
            begun.set()
            end.wait(60)

    first = threading.Thread(target=write)
    first.start()
    begun.wait(60)
    try:
        with pytest.raises(fl.FrictionloopError, match="is written by another process"):
            fl.sweep(BASE, KPS, path=path, **OPTIONS)
        with pytest.raises(fl.FrictionloopError, match="is written by another process"):
            fl.compare(fl.bench(), ["lookup"], 2, path=path)
    finally:
        end.set()
        first.join()
    with only_writer(path):
        pass
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("system", "points", "options"),
    [
        (BASE.evolve({"friction.nominal_n": 0.9}), KPS, {}),
        (BASE, {"controller.kp": np.linspace(0.5, 21.0, 100)}, {}),
        (BASE, {"controller.ki": np.linspace(0.5, 20.0, 100)}, {}),
        (BASE, KPS, {"duration_s": 0.03}),
        (BASE, KPS, {"seeds": [4]}),
        (BASE, KPS, {"score_from_s": 0.01}),
        (BASE, KPS, {"metrics": ["rms_error"]}),
    ],
    ids=["system", "values", "path", "duration", "seeds", "scoring", "metrics"],
)
def test_only_the_same_sweep_is_resumed(tmp_path, whole, system, points, options):
    path = tmp_path / "sweep.h5"
    fl.save(whole, path)
    with pytest.raises(fl.FrictionloopError, match=r"\.h5: .*another sweep"):
        fl.sweep(system, points, path=path, resume=True, **(OPTIONS | options))
    xr.testing.assert_identical(fl.load(path), whole)


def test_points_of_other_code_are_refused(monkeypatch, tmp_path):
    path = tmp_path / "sweep.h5"
    interrupted(monkeypatch, 2, path=path)
    before = path.read_bytes()
    monkeypatch.setattr(sweep_module, "computing", lambda: "of a law that was changed meanwhile")
    with pytest.raises(fl.FrictionloopError, match=r"sweep\.h5: .*other code"):
        fl.sweep(BASE, KPS, path=path, resume=True, **OPTIONS)
    assert path.read_bytes() == before


def test_a_real_signal_while_threads_work(monkeypatch, tmp_path):
    """Not an exception of our own: SIGINT reaches the main thread while workers run in others."""
    run_tile, calls = sweep_module.run_tile, []

    def once_interrupted(tile, periods):
        calls.append(tile)
        if len(calls) == 3:
            signal.raise_signal(signal.SIGINT)
        run_tile(tile, periods)

    monkeypatch.setattr(sweep_module, "run_tile", once_interrupted)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    gc.disable()  # an exception in a callback of the collector, and hypothesis has one, is lost
    try:
        with pytest.raises(fl.SweepInterrupted) as stopped:
            fl.sweep(BASE, {"controller.kp": np.linspace(0, 20, 3200)}, n_jobs=2, path=tmp_path / "sweep.h5", **OPTIONS)
    finally:
        gc.enable()
        signal.signal(signal.SIGINT, before)
    partial = stopped.value.partial
    assert partial["rms_error"].isnull().any()
    xr.testing.assert_identical(fl.load(tmp_path / "sweep.h5"), partial)


RATES = {"controller.rate_hz": [50_000.0 / k for k in (1, 2, 4, 5, 8, 10, 16, 20, 25, 40)]}
"""A tile each."""


def _save_each_tile(path):
    seconds = count(step=10)
    return fl.sweep(BASE, RATES, 0.48, n_jobs=1, path=path, resume=True, clock=lambda: next(seconds))


@pytest.mark.soak
@pytest.mark.timeout(1800)
def test_a_sweep_killed_at_30_random_moments_is_as_if_it_had_not_been(tmp_path, record_property):
    path, expected = tmp_path / "sweep.h5", _save_each_tile(tmp_path / "whole.h5")
    made = multiprocessing.get_context("forkserver")  # a process that imported all it needs is copied for each
    made.set_forkserver_preload(["frictionloop.loop.sweep"])
    rng, killed_at, before = np.random.default_rng(1), [], 0
    while len(killed_at) < 30:
        process = made.Process(target=_save_each_tile, args=(path,))
        process.start()
        while not path.exists() and process.is_alive():
            time.sleep(0.01)
        process.join(float(rng.uniform(0.0, 6.0)))
        process.kill()
        process.join()
        done = int(fl.load(path)["rms_error"].notnull().sum())
        assert done >= before
        before = done
        if process.exitcode == -signal.SIGKILL:
            killed_at.append(done)
        else:
            path.unlink()
            before = 0
    record_property("points there when it was killed", killed_at)
    assert max(killed_at) > 0
    xr.testing.assert_identical(_save_each_tile(path), expected)
