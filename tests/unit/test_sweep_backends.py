"""The same sweep in other processes, through joblib's back ends: the same call and the same bits."""

from __future__ import annotations

import os
import signal
import threading
import time

import joblib
import numpy as np
import pytest
import xarray as xr

import frictionloop as fl
from frictionloop.loop.parallel_runs import shared_out

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
    cluster = distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=":0")
    with cluster, distributed.Client(cluster) as client, joblib.parallel_config(backend="dask"):
        assert len(client.scheduler_info()["workers"]) == 2
        xr.testing.assert_identical(elsewhere(monkeypatch), in_threads)


@pytest.mark.slow
def test_a_dask_worker_that_is_killed_costs_nothing_but_time(in_threads, tmp_path):
    """With a file, which is saved while a client is open; another worker does again what the lost one had."""
    distributed = pytest.importorskip("dask.distributed")
    cluster = distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=":0")
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


@pytest.mark.parametrize("workers", [1, 2, 5])
def test_each_call_is_made_once(workers):
    made = sorted(shared_out(lambda a, b: (a, b), [(i, -i) for i in range(40)], workers))
    assert made == [(i, -i) for i in range(40)]


def test_the_caller_works_too():
    """Two calls that wait for each other are done by two workers only if the caller is one of them."""
    both = threading.Barrier(2)
    threads = set(shared_out(lambda _: (both.wait(60) and None) or threading.get_ident(), [(1,), (2,)], 2))
    assert len(threads) == 2
    assert threading.get_ident() in threads


@pytest.mark.parametrize("thread", ["the caller", "its helper"])
def test_an_error_comes_back_and_drops_what_has_not_begun(thread):
    caller, began = threading.get_ident(), []
    met = threading.Event()

    def fails(number):
        began.append(number)
        if (threading.get_ident() == caller) == (thread == "the caller"):
            met.set()
            raise IndexError("no such place")
        met.wait(60)
        time.sleep(1e-3)

    with pytest.raises(IndexError, match="no such place"):
        list(shared_out(fails, [(i,) for i in range(100_000)], 2))
    assert len(began) < 100_000


def test_closing_drops_what_has_not_begun():
    began, threads = [], threading.active_count()

    def begins(number):
        began.append(number)
        time.sleep(1e-3)

    calls = shared_out(begins, [(i,) for i in range(100_000)], 2)
    next(calls)
    calls.close()
    assert len(began) < 100_000
    assert threading.active_count() == threads
