"""A sweep in shards on a local cluster of two workers; also a program, which writes them into its folder."""

from __future__ import annotations

import sys
import time
from functools import partial

import dask
from dask.distributed import Client, LocalCluster

import frictionloop as fl

BENCH = fl.bench().evolve(fl.RETUNED)
GRID = {"finger": fl.fingers(256, 1), "controller.kp": [0.01, 0.03]}
HOW = {"duration_s": 1.0, "metrics": ["rms_error", "saturation_index"], "progress": False, "n_jobs": 1}
SHARDS, KILLS = 8, 10


def written(client, folder):
    """Write all shards, each a task that any worker can run, and run again."""
    one = partial(fl.sweep, BENCH, GRID, path=folder, **HOW)
    calls = [partial(one, shard=(part, SHARDS)) for part in range(1, SHARDS + 1)]
    client.gather([client.submit(call, pure=False, retries=KILLS) for call in calls])


def cluster():
    """Return a cluster on which a task may lose its worker often; by itself it closes one away 15 s after it died."""
    dask.config.set({"distributed.scheduler.allowed-failures": 2 * KILLS})
    dask.config.set({"distributed.deploy.lost-worker-timeout": "1 h"})
    return LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0")


if __name__ == "__main__":
    with cluster() as mine, Client(mine) as opened:
        for _ in range(KILLS):
            try:
                written(opened, sys.argv[1])
                break
            except fl.FrictionloopError:  # a worker of a scheduler that was killed still writes
                time.sleep(1.0)
