"""The same sweep in other processes, through joblib's back ends: the same call and the same bits."""

from __future__ import annotations

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


def test_in_processes_of_this_machine(monkeypatch, in_threads):
    with joblib.parallel_config(backend="loky", n_jobs=2):
        xr.testing.assert_identical(elsewhere(monkeypatch), in_threads)


def test_one_thread(in_threads):
    xr.testing.assert_identical(fl.sweep(fl.paper(), POINTS, n_jobs=1, **OPTIONS), in_threads)
