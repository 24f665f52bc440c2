"""A recording that ends in any way keeps what it has: killed, told to stop, twice, on a full disk."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from designed_notch import DESIGNED_NOTCH

import frictionloop as fl
from frictionloop.device.device_run import ending
from frictionloop.device.recording import counted
from frictionloop.loop import growing_file as module
from frictionloop.loop.growing_file import CHUNK_ROWS, Column, Spool, recovered, unfinished

COLUMNS = {
    "f_m": Column("f8", {"units": "N", "long_name": "measured force"}),
    "sliding": Column("bool", {"units": "1"}),
}
ATTRS = {"schema": 1, "source": "device"}
RECORD = """
import signal, sys, frictionloop as fl
signal.signal(signal.SIGINT, signal.default_int_handler)  # a background job ignores it
signal.signal(signal.SIGHUP, signal.SIG_DFL)
with fl.connect("sim:") as device:
    device.run(0.5, 3600.0, path="run.h5", progress=lambda rows: print(rows, flush=True))
"""


def values(rows: int, seed: int = 0) -> dict[str, np.ndarray]:
    draw = np.random.default_rng(seed)
    return {"f_m": draw.normal(size=rows), "sliding": draw.random(rows) < 0.5}


@pytest.fixture
def spool(tmp_path: Path) -> Spool:
    return Spool(tmp_path / "run.h5", COLUMNS, 2e-4, ATTRS, ("lost_samples",))


@pytest.fixture
def recording(tmp_path: Path) -> Any:
    """A process that records for an hour, and has some seconds in its file."""
    process = subprocess.Popen([sys.executable, "-c", RECORD], cwd=tmp_path, stdout=subprocess.PIPE, text=True,
                               stderr=subprocess.PIPE)  # fmt: skip
    assert process.stdout is not None
    for line in process.stdout:
        if int(line) > 12_000:
            break
    threading.Thread(target=process.stdout.read, daemon=True).start()  # a full pipe would stop it
    yield process
    process.kill()
    process.wait()
    process.stdout.close()
    process.stderr.close()


def test_a_finished_file_is_what_was_appended(spool: Spool) -> None:
    parts = [values(rows, rows) for rows in (1, 4999, 5000, 37)]
    for part in parts:
        spool.append(part, {"lost_samples": 3})
    run = fl.load(spool.finish({"reconnects": 2}))
    for name in COLUMNS:
        np.testing.assert_array_equal(run[name], np.concatenate([part[name] for part in parts]))
    np.testing.assert_allclose(run.time, np.arange(10_037) * 2e-4)
    assert (run.f_m.attrs, run.sliding.dtype) == (COLUMNS["f_m"].attrs, bool)
    assert (run.attrs["schema"], run.attrs["reconnects"]) == (1, 2)
    assert os.listdir(spool.path.parent) == ["run.h5"]


def test_a_growing_file_is_read_by_others(spool: Spool) -> None:
    spool.append(values(7000), {"lost_samples": 5})
    with pytest.warns(UserWarning, match="unfinished, 7000 samples"):
        run = fl.load(spool.partial)
    assert (run.sizes["time"], run.attrs["lost_samples"], run.attrs["unfinished"]) == (7000, 5, 1)
    spool.append(values(10))
    found = unfinished(spool.partial)
    assert found is not None and found.sizes["time"] == 7010
    found.close()
    spool.drop()


SIGNALS = [signal.SIGTERM, *(pytest.param(how, marks=pytest.mark.slow) for how in (signal.SIGHUP, signal.SIGINT))]


@pytest.mark.parametrize("how", SIGNALS, ids=lambda how: how.name)
def test_told_to_stop(recording: Any, tmp_path: Path, how: int) -> None:
    recording.send_signal(how)
    assert recording.wait(30) != 0
    run = fl.load(tmp_path / "run.h5")
    assert run.sizes["time"] > 12_000 and np.isfinite(run.f_m).all()
    assert [path.name for path in tmp_path.iterdir()] == ["run.h5"]


@pytest.mark.parametrize("how", [signal.SIGHUP, signal.SIGINT], ids=lambda how: how.name)
def test_what_nohup_or_a_background_job_ignores_stays_ignored(how: int) -> None:
    before = signal.signal(how, signal.SIG_IGN)
    try:
        with ending():
            os.kill(os.getpid(), how)
            time.sleep(0.01)
        assert signal.getsignal(how) == signal.SIG_IGN
    finally:
        signal.signal(how, before)


@pytest.mark.slow
def test_told_to_stop_again_and_again(recording: Any, tmp_path: Path) -> None:
    for number in (signal.SIGINT, signal.SIGINT, signal.SIGTERM, signal.SIGINT):
        recording.send_signal(number)
        time.sleep(0.02)
    assert recording.wait(30) != 0
    assert fl.load(tmp_path / "run.h5").sizes["time"] > 12_000


@pytest.mark.slow
def test_a_recording_that_goes_on_is_left_alone(recording: Any, tmp_path: Path) -> None:
    (partial,) = tmp_path.iterdir()
    with pytest.raises(fl.FrictionloopError, match=r"partial-\w+\.h5: in use"):
        recovered(partial, tmp_path / "run.h5")
    with pytest.warns(UserWarning, match="unfinished, "):
        assert fl.load(partial).sizes["time"] > 12_000 - 5000  # looking is free
    recording.kill()
    recording.wait()
    rows, _ = recovered(partial, tmp_path / "run.h5")
    assert rows > 12_000 - 5000


@pytest.mark.slow
def test_killed(recording: Any, tmp_path: Path) -> None:
    recording.kill()
    recording.wait()
    (partial,) = tmp_path.iterdir()
    with pytest.raises(fl.FrictionloopError, match=f"no such file; unfinished: .*{partial.name}"):
        fl.load(tmp_path / "run.h5")
    rows, damaged = recovered(partial, tmp_path / "run.h5")
    run = fl.load(tmp_path / "run.h5")
    assert (run.sizes["time"], damaged) == (rows, 0)
    assert rows > 12_000 - 5000  # at most the second that was under way is lost
    assert np.isfinite(run.f_m).all() and fl.system_of(run).sensor.kind == "suspended"
    assert (run.attrs["lost_samples"], run.attrs["recovered"]) == (0, 1)


def test_a_damaged_chunk_is_named_and_the_rest_kept(spool: Spool, tmp_path: Path) -> None:
    given = values(3 * CHUNK_ROWS)
    spool.append(given)
    with h5py.File(spool.partial, "r", swmr=True) as file:
        place = file["f_m"].id.get_chunk_info(1)
    spool._file.close()
    spool._let_go()
    content = bytearray(spool.partial.read_bytes())
    content[place.byte_offset + place.size // 2] ^= 0xFF
    spool.partial.write_bytes(content)
    with h5py.File(spool.partial, "r") as file, pytest.raises(OSError):
        file["f_m"][:]
    assert recovered(spool.partial, tmp_path / "mended.h5") == (3 * CHUNK_ROWS, CHUNK_ROWS)
    run = fl.load(tmp_path / "mended.h5")
    bad = np.isnan(run.f_m.values)
    np.testing.assert_array_equal(np.flatnonzero(bad), np.arange(CHUNK_ROWS, 2 * CHUNK_ROWS))
    np.testing.assert_array_equal(run.f_m.values[~bad], given["f_m"][~bad])


@pytest.fixture
def small_disk(tmp_path: Path) -> Any:
    """A disk of 3 MB."""
    place = tmp_path / "disk"
    place.mkdir()
    if os.name != "posix" or subprocess.run(["mount", "-t", "tmpfs", "-o", "size=3m", "tmpfs", place],
                                            capture_output=True, check=False).returncode:  # fmt: skip
        pytest.skip("a small disk needs root on Linux")
    yield place
    subprocess.run(["umount", "-l", place], check=True)


def test_a_full_disk_keeps_every_row(small_disk: Path) -> None:
    spool, kept = Spool(small_disk / "run.h5", COLUMNS, 2e-4, ATTRS), []
    with pytest.raises(module.DiskFull, match="the disk is full"):
        for seed in range(1000):
            kept.append(values(5000, seed))
            spool.append(kept[-1])
    run = fl.load(spool.finish({}))
    np.testing.assert_array_equal(run.f_m, np.concatenate([each["f_m"] for each in kept]))


@pytest.mark.slow
def test_a_full_disk_ends_a_run_safely(small_disk: Path) -> None:
    """In a process of its own, which has to end well: HDF5 is known to crash at exit after a full disk."""
    script = RECORD.replace("run.h5", str(small_disk / "run.h5")).replace("print(rows, flush=True)", "None")
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 1
    assert "Interrupted: " in done.stderr and "the disk is full" in done.stderr
    run = fl.load(small_disk / "run.h5")
    assert re.search(rf"{run.sizes['time']} samples .*run\.h5", done.stderr)
    assert run.sizes["time"] > 5000 and np.isfinite(run.f_m).all()


def test_memory_does_not_grow_with_the_run(tmp_path: Path) -> None:
    """What a day leaves behind: blocks come and go."""
    import tracemalloc

    spool = Spool(tmp_path / "run.h5", COLUMNS, 2e-4, ATTRS)
    part = values(5000)
    for _ in range(5):
        spool.append(part)
    tracemalloc.start()
    for _ in range(200):
        spool.append(part)
    grown, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    spool.drop()
    assert grown < 2e5  # 200 s of these columns are 9 MB


def test_part_of_a_run(spool: Spool, monkeypatch: pytest.MonkeyPatch) -> None:
    given = values(10_000)
    spool.append(given)
    path = spool.finish({})
    np.testing.assert_array_equal(fl.load(path, from_s=0.5, until_s=0.9998).f_m, given["f_m"][2500:5000])
    monkeypatch.setattr("frictionloop.loop.record.AT_ONCE_BYTES", 1000)
    lazy = fl.load(path)
    assert not lazy.f_m.variable._in_memory
    np.testing.assert_array_equal(lazy.f_m[9000:], given["f_m"][9000:])
    lazy.close()


# Which samples of a recording count: those that `simulate` would count.


BENCH = fl.bench().evolve(DESIGNED_NOTCH)


def test_a_recording_scores_as_the_simulation_does() -> None:
    with fl.connect("sim:", BENCH) as device:
        run = device.run(BENCH.setpoint, 4.0)
    simulated = fl.simulate(BENCH, 4.0)
    assert fl.rms_error(run) == pytest.approx(fl.rms_error(simulated), rel=0.05)
    # The position that is measured has 10 um of noise and the tremor, 30 um; the stroke that is meant has neither.
    late = run.attrs["start_tick"] - 1
    other = run.scored.values[: 20000 - late] != simulated.scored.values[late:]
    edge = abs(abs(simulated.position.values[late:]) - 28e-3)
    assert edge[other].max() < 6 * 40e-6


def test_what_counts_with_strokes_and_without() -> None:
    sliding = np.array([True, True, True, True, True, False, False])
    position = np.array([0.0, 27.9e-3, -28.1e-3, 0.0, 0.0, 0.0, np.nan])
    load = np.array([0.5, 0.5, 0.5, 0.26, 0.24, 0.5, np.nan])  # strokes of 60 mm, 2 mm unscored, under 0.5 N
    assert counted(sliding, position, load, BENCH).tolist() == [True, True, False, True, False, False, False]
    soft = BENCH.evolve({"finger.stiffness_n_m": 400.0})  # whose skin yields 5 mm
    assert not counted(sliding, position, load, soft)[1]
    assert counted(sliding, position, load, None).tolist() == sliding.tolist()
    assert counted(sliding, position, load, fl.paper()).tolist() == sliding.tolist()
