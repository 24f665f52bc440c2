"""Shards on a local cluster of two workers: only what was running is lost, and the bits are those of one process."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import threading
import time

import pytest
import xarray as xr

import frictionloop as fl

posix = pytest.mark.skipif(os.name != "posix", reason="signals and mounts as POSIX has them")
pytestmark = [pytest.mark.slow, posix, pytest.mark.timeout(900)]
shard_cluster = pytest.importorskip("shard_cluster")


@pytest.fixture(scope="module")
def whole():
    return fl.sweep(shard_cluster.BENCH, shard_cluster.GRID, **shard_cluster.HOW)


def check(folder, whole):
    told = fl.sweep_status(folder)
    assert (len(told.done), told.runs_done) == (shard_cluster.SHARDS, whole["rms_error"].size)
    xr.testing.assert_identical(fl.open_sweep(folder).compute(), whole)


def test_workers_killed_at_ten_random_moments(tmp_path, whole):
    chance, killed, ended = random.Random(0), [], threading.Event()

    def kill(client):
        while len(killed) < shard_cluster.KILLS and not ended.wait(chance.uniform(0.1, 1.5)):
            if pids := [*client.run(os.getpid, on_error="ignore").values()]:
                os.kill(chance.choice(pids), signal.SIGKILL)
                killed.append(len(pids))

    with shard_cluster.cluster() as cluster, shard_cluster.Client(cluster) as client:
        killer = threading.Thread(target=kill, args=(client,))
        killer.start()
        try:
            for k in range(100):
                shard_cluster.written(client, tmp_path / str(k))
                if len(killed) == shard_cluster.KILLS:
                    break
        finally:
            ended.set()
            killer.join()
    assert len(killed) == shard_cluster.KILLS
    for folder in tmp_path.iterdir():
        check(folder, whole)


def test_the_scheduler_killed_and_started_anew(tmp_path, whole):
    run = [sys.executable, shard_cluster.__file__, tmp_path]
    first = subprocess.Popen(run, stderr=subprocess.DEVNULL)
    while not list(tmp_path.glob("shard-*.h5")) and first.poll() is None:
        time.sleep(0.05)
    first.kill()
    first.wait()
    assert fl.sweep_status(tmp_path).runs_done < whole["rms_error"].size
    subprocess.run(run, check=True, stderr=subprocess.DEVNULL)
    check(tmp_path, whole)


def test_a_full_disk_and_a_shard_that_was_cut(tmp_path, whole):
    place = tmp_path / "small"
    place.mkdir()
    tmpfs = ["mount", "-t", "tmpfs", "-o", "size=1m", "tmpfs", place]
    if subprocess.run(tmpfs, capture_output=True, check=False).returncode:
        pytest.skip("no file system can be mounted here")

    def all_shards():
        for part in range(1, shard_cluster.SHARDS + 1):
            shard = part, shard_cluster.SHARDS
            fl.sweep(shard_cluster.BENCH, shard_cluster.GRID, path=place, shard=shard, **shard_cluster.HOW)

    try:
        (place / "filling").write_bytes(bytes(1_000_000))
        with pytest.raises(fl.FrictionloopError, match="No space left on device"):
            all_shards()
        before = fl.sweep_status(place)
        assert before.done and before.missing and not before.damaged
        (place / "filling").unlink()
        cut = place / f"shard-1-of-{shard_cluster.SHARDS}.h5"
        cut.write_bytes(cut.read_bytes()[: cut.stat().st_size // 2])
        with pytest.warns(UserWarning, match="is damaged; it is made anew"):
            all_shards()
        check(place, whole)
    finally:
        subprocess.run(["umount", place], check=True)
