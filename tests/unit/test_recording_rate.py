"""The rate of a recording: times without a unit are asked about, attributes are read as `identify` reads them."""

from __future__ import annotations

import h5py
import numpy as np
import pytest
import recorded_files
from scipy.io import savemat

import frictionloop as fl
from frictionloop.parameters import Recording
from frictionloop.quantities import FrictionloopError
from frictionloop.recordings.file_opening import read_contents
from frictionloop.recordings.force_channel import read_recording
from frictionloop.recordings.force_channel import scaled as found
from frictionloop.recordings.sampling import sampling_of

FORCE = 0.3 + 0.1 * np.sin(np.arange(50.0))


def saved(path, step=None, units=None, **attributes):
    """Write a force and its times, in steps of the file's own unit, with attributes of the force."""
    with_times = {} if step is None else {"t": step * np.arange(FORCE.size)}
    if path.suffix == ".mat":
        savemat(path, {"ft": FORCE, **with_times, **attributes})
    else:
        with h5py.File(path, "w") as file:
            file.update({"ft": FORCE, **with_times})
            file["ft"].attrs.update(attributes)
            if units:
                file["t"].attrs["Units"] = units
    return Recording(path=str(path), column="ft")


@pytest.mark.parametrize("name", ["a.mat", "a.h5"])
@pytest.mark.parametrize(("step", "said"), [(0.04, "in s 25 Hz, in ms 25000 Hz"), (1e-7, "in s 1e+07 Hz;")])
def test_times_that_are_hardly_in_seconds_are_asked_about(tmp_path, name, step, said):
    recording = saved(tmp_path / name, step)
    with pytest.raises(FrictionloopError) as caught:
        found(recording)
    assert f"'t' without a unit: {said}" in str(caught.value)
    assert "--disturbance.rate_hz" in str(caught.value) and "\n" not in str(caught.value)
    for rate_hz in (25.0, 25000.0):  # either may be meant, and nothing in the file says it
        given = recording.model_copy(update={"rate_hz": rate_hz})
        assert read_recording(given, rate_hz) == pytest.approx(FORCE)
    assert sampling_of(name, read_contents(recording.path).signals()).rate_hz is None


@pytest.mark.parametrize("uneven", [0.0, 0.3])
def test_a_rate_beside_times_without_a_unit_is_held_against_them(tmp_path, uneven):
    """Slow times without a unit that are even, or not, are not overruled without a word."""
    at = 0.014 * (np.arange(50) + uneven * np.sin(np.arange(50)))
    (tmp_path / "a.csv").write_text("Time,ft\n" + "".join(f"{t:.9g},{0.1 * t:.4g}\n" for t in at))
    path, ft = str(tmp_path / "a.csv"), {"column": "ft"}
    with pytest.raises(FrictionloopError, match=r"rate_hz = 100 Hz: must be near 7.* \('Time' in s\)"):
        found(Recording(path=path, rate_hz=100.0, **ft))
    for rate_hz in (71400.0, 71.4):  # in ms, and in s
        assert found(Recording(path=path, rate_hz=rate_hz, **ft)).rate_hz == rate_hz


def test_times_with_a_unit_are_believed_at_any_rate(tmp_path):
    assert found(saved(tmp_path / "a.h5", 0.04, "s")).rate_hz == 25.0
    assert found(saved(tmp_path / "b.h5", 0.04, "ms")).rate_hz == 25000.0
    assert found(saved(tmp_path / "c.h5", 0.0004)).rate_hz == 2500.0


@pytest.mark.parametrize(("name", "value"), [("rate_hz", 25000.0), ("Fs", 25000), ("dt_ms", 0.04), ("rate_khz", 25.0)])
@pytest.mark.parametrize("ending", [".mat", ".h5"])
def test_a_rate_beside_a_force_is_that_of_identify(tmp_path, ending, name, value):
    recording = saved(tmp_path / f"a{ending}", **{name: value})
    assert found(recording).rate_hz == pytest.approx(25000.0)
    assert sampling_of("a", read_contents(recording.path).signals()).rate_hz == pytest.approx(25000.0)
    assert (found(recording).force.size, found(recording).part.by) == (50, repr(name))
    with pytest.raises(FrictionloopError, match="rate_hz = 1000 Hz: must be 25000, as in the file"):
        found(recording.model_copy(update={"rate_hz": 1000.0}))


def test_a_rate_settles_times_without_a_unit_and_contradicts_others(tmp_path):
    assert found(saved(tmp_path / "a.h5", 0.04, rate_hz=25000.0)).rate_hz == 25000.0
    with pytest.raises(FrictionloopError, match="1000 Hz by 't', 25000 Hz by 'rate_hz'"):
        found(saved(tmp_path / "b.h5", 0.001, rate_hz=25000.0))


def test_a_file_written_again_is_read_again(tmp_path):
    path = tmp_path / "a.csv"
    for force in ("0.1", "0.25"):
        path.write_text("time_s,F\n" + "".join(f"{k / 1000},{force}\n" for k in range(3)))
        assert found(Recording(path=str(path), column="F")).force.max() == float(force)


@pytest.mark.parametrize("name", ["file.lvm", "file.tdms", "file.uff"])
def test_recorders_bring_channels_by_name_with_their_rate(tmp_path, name):
    pytest.importorskip({"file.lvm": "lvm_read", "file.tdms": "nptdms", "file.uff": "pyuff"}[name])
    path = tmp_path / name
    rising = np.linspace(0.2, 0.9, FORCE.size)
    recorded_files.FORMATS[name](path, {"ft": FORCE, "fn": rising}, 500.0)
    force = Recording(path=str(path), column="ft", scale=1.0)
    np.testing.assert_allclose(read_recording(force, 500.0), FORCE, rtol=1e-6)
    assert found(force).rate_hz == pytest.approx(500.0, rel=1e-6)
    # In UFF no unit stands beside the values. A rate is told, so that a channel that rises evenly is no time.
    np.testing.assert_allclose(
        read_recording(Recording(path=str(path), column="1", scale=1.0), 500.0), rising, rtol=1e-6
    )
    with pytest.raises(FrictionloopError, match=r"may be any of 2 signals; accepted: '(daq/)?ft', '(daq/)?fn'"):
        read_recording(Recording(path=str(path), scale=1.0), 500.0)
    with pytest.raises(FrictionloopError, match=r"column: 'nix' is unknown; .*accepted: (daq/)?ft, (daq/)?fn"):
        read_recording(Recording(path=str(path), column="nix", scale=1.0), 500.0)


# A header with names for the first columns only: the others go by number, in a run as in `identify channels`.


RATE_HZ = 1000.0
VALUES = np.arange(50.0)[:, None] + np.arange(6.0) / 10


@pytest.fixture(params=[" ", "\t", ";", ","])
def path(tmp_path, request):
    """A table of six columns, of times and five of forces, three of which have names."""
    mark, columns = request.param, np.c_[np.arange(50) / RATE_HZ, VALUES[:, 1:]]
    written = tmp_path / "grip.txt"
    np.savetxt(written, columns, delimiter=mark, header=mark.join(("time_s", "Px", "Py")), comments="", fmt="%.6f")
    return str(written)


@pytest.mark.parametrize(("column", "k"), [("Py", 2), ("3", 3), (5, 5)])
def test_columns_without_a_name_are_read_by_number(path, column, k):
    recording = fl.Recording(path=path, column=column)
    assert read_recording(recording, RATE_HZ) == pytest.approx(VALUES[:, k])
    (fewer,) = found(recording).findings
    assert (fewer.code, fewer.value, fewer.limit) == ("NAMES-FEWER", 3, 6)


def test_one_that_is_not_there_is_refused_with_all_that_are(path):
    with pytest.raises(fl.FrictionloopError, match=r"column: '6' is unknown; accepted: time, Px, Py, 3, 4, 5"):
        read_recording(fl.Recording(path=path, column="6"), RATE_HZ)
