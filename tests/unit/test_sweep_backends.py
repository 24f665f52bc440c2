"""The same sweep in other processes, through joblib's back ends: the same call and the same bits."""

from __future__ import annotations

import os
import signal
import threading

import joblib
import numpy as np
import pytest
import xarray as xr

import frictionloop as fl

POINTS = {"controller.kp": np.linspace(0.5, 20.0, 70), "controller.delay_s": [0.0, 130e-6]}
OPTIONS = {
    "duration_s": 0.02,
    "seeds": [3, 2**40],
    "metrics": [m for m in fl.METRICS if not m.startswith(("rise", "fall"))],
}


@pytest.fixture(scope="module")
def in_threads():
    return fl.sweep(fl.paper(), POINTS, **OPTIONS)


def elsewhere(monkeypatch):
    """Run the sweep such that work in this process would fail: only other processes can have done it."""
    monkeypatch.setattr("frictionloop.loop.sweep.run_tile", lambda *_: pytest.fail("not in another process"))
    return fl.sweep(fl.paper(), POINTS, **OPTIONS)


@pytest.mark.slow
def test_on_a_dask_cluster_of_two_workers(monkeypatch, in_threads):
    distributed = pytest.importorskip("dask.distributed")
    cluster = distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None)
    with cluster, distributed.Client(cluster) as client, joblib.parallel_config(backend="dask"):
        assert len(client.scheduler_info()["workers"]) == 2
        xr.testing.assert_identical(elsewhere(monkeypatch), in_threads)


@pytest.mark.slow
def test_a_dask_worker_that_is_killed_costs_nothing_but_time(in_threads, tmp_path):
    """With a file, which is saved while a client is open; another worker does again what the lost one had."""
    distributed = pytest.importorskip("dask.distributed")
    cluster = distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None)
    with cluster, distributed.Client(cluster) as client, joblib.parallel_config(backend="dask"):
        pids = client.run(os.getpid)
        killer = threading.Timer(0.5, lambda: os.kill(next(iter(pids.values())), signal.SIGKILL))
        killer.start()
        found = fl.sweep(fl.paper(), POINTS, path=tmp_path / "far.h5", **OPTIONS)
        killer.join()
        fl.save(found, tmp_path / "again.h5")
    xr.testing.assert_identical(found, in_threads)
    for name in ("far.h5", "again.h5"):
        xr.testing.assert_equal(fl.load(tmp_path / name), in_threads)


@pytest.mark.slow
def test_in_processes_of_this_machine(monkeypatch, in_threads):
    with joblib.parallel_config(backend="loky", n_jobs=2):
        xr.testing.assert_identical(elsewhere(monkeypatch), in_threads)


def test_one_thread(in_threads):
    xr.testing.assert_identical(fl.sweep(fl.paper(), POINTS, n_jobs=1, **OPTIONS), in_threads)
