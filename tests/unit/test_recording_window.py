"""`start_s` and `stop_s` are times of the file where it has any, and count from its first sample where it has none."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.io import savemat

import frictionloop as fl
from frictionloop.recordings.force_channel import lasting_s, read_held, read_recording
from frictionloop.recordings.force_channel import scaled as found

RATE_HZ = 1000.0
ROWS = np.arange(2000)
SHAKEN_S = 0.3e-3 * np.random.default_rng(0).uniform(-1, 1, ROWS.size)


def written(folder, times, name="time_s"):
    """Return a recording whose force is the number of its row, beside times."""
    path = folder / "f.csv"
    lines = [f"{time},{row}" for time, row in zip(times, ROWS, strict=True)]
    path.write_text("\n".join([f"{name},force", *lines]))
    return fl.Recording(path=str(path), column="force")


def part(recording, **more):
    return read_recording(recording.model_copy(update=more), RATE_HZ)[[0, -1]].tolist()


@pytest.mark.parametrize(
    ("name", "times", "given"),
    [
        ("time_s", 3.0 + ROWS / RATE_HZ, {}),
        ("t_ms", 3000.0 + ROWS, {}),
        ("t", 3.0 + ROWS / RATE_HZ, {"rate_hz": RATE_HZ}),
        ("time_s", 3.0 + ROWS / RATE_HZ + SHAKEN_S, {"rate_hz": RATE_HZ}),
    ],
)
def test_a_part_is_that_of_the_times_in_the_file(tmp_path, name, times, given):
    recording = written(tmp_path, times, name)
    assert part(recording, start_s=3.5, stop_s=4.25, **given) == pytest.approx([500, 1250], abs=1)
    assert part(recording, **given) == part(recording, start_s=0.0, **given) == [0, 1999]
    assert found(recording.model_copy(update={"start_s": 3.5, **given})).part.at_s[0] == pytest.approx(3.5, abs=1e-3)


def test_times_before_a_trigger_are_below_0(tmp_path):
    recording = written(tmp_path, -0.5 + ROWS / RATE_HZ)
    assert part(recording, start_s=0.0) == [500, 1999]
    assert part(recording, start_s=-0.2, stop_s=-0.1) == [300, 400]
    one = found(recording.model_copy(update={"start_s": -0.2}))
    assert (one.part.at_s[0], one.part.at_s[-1]) == pytest.approx((-0.2, 1.499))


@pytest.mark.parametrize("begins", ["date", "since 1970", "0"])
def test_dates_count_from_the_first(tmp_path, begins):
    times = {
        "date": np.datetime64("2024-03-05T10:11:12", "us") + 1000 * ROWS,
        "since 1970": [f"{1.7e9 + row / RATE_HZ:.3f}" for row in ROWS],
        "0": ROWS / RATE_HZ,
    }[begins]
    recording = written(tmp_path, times)
    assert part(recording, start_s=0.5, stop_s=1.25) == [500, 1250]
    one = found(recording.model_copy(update={"start_s": 0.5, "stop_s": 1.25}))
    assert (one.part.at_s[0], one.part.at_s[-1]) == pytest.approx((0.5, 1.25), abs=1e-3)


def test_without_times_a_part_counts_from_the_first_sample(tmp_path):
    savemat(tmp_path / "f.mat", {"force": ROWS.astype(float)})
    recording = fl.Recording(path=str(tmp_path / "f.mat"), column="force", rate_hz=RATE_HZ)
    assert part(recording, start_s=0.5, stop_s=1.25) == [500, 1250]
    one = found(recording.model_copy(update={"start_s": 0.5, "stop_s": 1.25}))
    assert (one.part.at_s[0], one.part.at_s[-1]) == (0.5, 1.25)
    with pytest.raises(fl.FrictionloopError, match=r"start_s = -1 s: must be from 0 to 1\.999"):
        part(recording, start_s=-1.0)


def test_a_part_lasts_from_its_start_or_from_the_first_time(tmp_path):
    recording = written(tmp_path, 3.0 + ROWS / RATE_HZ)
    for start_s in (None, 0.0, 3.0):
        cut = recording.model_copy(update={"start_s": start_s, "stop_s": 4.0})
        assert lasting_s(cut) == pytest.approx(1.0) and read_held(cut, RATE_HZ).size == 1001
    assert lasting_s(recording) == pytest.approx(2.0)


def test_a_run_and_a_sweep_take_the_same_part(tmp_path):
    recording = written(tmp_path, 3.0 + ROWS / RATE_HZ).model_copy(update={"scale": 1e-4, "start_s": 3.5})
    system = fl.feasible().evolve({"disturbance": recording, "setpoint": fl.Constant(offset_n=0.5)})
    run = fl.simulate(system, 0.2)
    assert float(run.d[0]) == pytest.approx(0.05)
    grid = fl.sweep(system, [{}], 0.2, metrics=["rms_error"], progress=False)
    assert grid.rms_error.item() == pytest.approx(fl.rms_error(run), rel=1e-9)
