"""A recording is read, or asked about, so that nothing but what was meant enters a run."""

from __future__ import annotations

import h5py
import numpy as np
import pytest
from scipy.io import savemat, wavfile

import frictionloop as fl
from frictionloop.cli.recorded_units import misnamed, resampled
from frictionloop.quantities import FrictionloopError
from frictionloop.recordings.told import found, told

RATE_HZ = 1000.0


def values(samples=1000, mean_n=0.5):
    return mean_n + 0.05 * np.sin(2 * np.pi * 5 * np.arange(samples) / RATE_HZ)


def wav(path, *tones_hz, rate_hz=20_000):
    time = np.arange(rate_hz) / rate_hz
    samples = np.stack([0.02 * np.sin(2 * np.pi * each * time) for each in tones_hz], axis=1)
    wavfile.write(path, rate_hz, samples.astype(np.float32))
    return fl.Recording(path=str(path))


def under(recording):
    return fl.feasible().evolve({"setpoint": fl.Constant(offset_n=0.5), "disturbance": recording})


@pytest.mark.parametrize("write", ["h5", "mat"])
def test_one_of_several_signals_is_not_taken_in_silence(tmp_path, write):
    arrays = {"force": values(), "load": values(), "time": np.arange(1000) / RATE_HZ}
    path = tmp_path / f"trial.{write}"
    if write == "h5":
        with h5py.File(path, "w") as file:
            for name, each in arrays.items():
                file[f"trial1/{name}"] = each
    else:
        savemat(path, {"trial1": arrays})
    with pytest.raises(FrictionloopError, match=r"\(the default\) may be any of 2 signals; accepted: 'trial1/force"):
        found(fl.Recording(path=str(path)))
    assert found(fl.Recording(path=str(path), column="trial1/force")).column == "trial1/force"


def test_the_only_signal_beside_times_and_a_rate_is_taken(tmp_path):
    with h5py.File(tmp_path / "one.h5", "w") as file:
        file["a_time"], file["fs"], file["trial/forces"] = 1.0, RATE_HZ, values()[:, None]
    read = found(fl.Recording(path=str(tmp_path / "one.h5")))
    assert (read.column, read.rate_hz) == ("trial/forces", RATE_HZ)
    with h5py.File(tmp_path / "two.h5", "w") as file:
        file["trial/forces"] = np.c_[values(), values()]
    line = fl.Recording(path=str(tmp_path / "two.h5"), column="trial/forces[:, 1]", rate_hz=RATE_HZ)
    assert found(line).column == "trial/forces[:, 1]"


def test_a_channel_of_several_is_told_with_the_others(tmp_path):
    assert "(channel 0 of 2; others by column: '1')" in told(wav(tmp_path / "two.wav", 50, 60))
    assert "channel" not in told(wav(tmp_path / "one.wav", 50))


@pytest.mark.parametrize(("tones_hz", "share"), [((4000,), "100%"), ((100,), None)])
def test_what_resampling_takes_out_is_told(tmp_path, tones_hz, share):
    said = " ".join(resampled(under(wav(tmp_path / "d.wav", *tones_hz))))
    assert said.startswith(f"{share} (rms) of what varies in the recorded disturbance") if share else said == ""


def test_no_share_is_left_of_what_did_not_enter(tmp_path):
    run = fl.simulate(under(wav(tmp_path / "d.wav", 4000)), 0.9)
    assert np.isnan(fl.metrics(run)["disturbance_left"])


@pytest.mark.parametrize("name", ["Normal force", "load", "Fz", "normal_force"])
def test_a_column_named_as_a_load_is_asked_about(tmp_path, name):
    (tmp_path / "d.csv").write_text(f"{name} [N],tangential [N],overload\n1,0.5,1\n1.1,0.6,2\n")
    load, friction, other = (
        fl.Recording(path=str(tmp_path / "d.csv"), column=each, rate_hz=RATE_HZ)
        for each in (name, "tangential", "overload")
    )
    assert f"column '{name}" in " ".join(misnamed(under(load)))
    assert misnamed(under(friction)) == misnamed(under(other)) == []


def test_the_read_back_gives_rms_and_mean(tmp_path):
    (tmp_path / "d.csv").write_text("force [N]\n0.4\n0.8\n")
    assert told(fl.Recording(path=str(tmp_path / "d.csv"), rate_hz=RATE_HZ)).endswith(
        "0.4 to 0.8 N, 200 mN rms about 0.6 N"
    )


def test_an_index_over_a_stroke_that_does_not_vary_is_refused(frictionloop):
    from frictionloop.cli.recorded import STILL

    still = fl.bench().evolve({**STILL, "setpoint": fl.Constant(offset_n=0.5)})
    run = fl.simulate(still, 2.0)
    with pytest.raises(FrictionloopError, match="varies by nothing"):
        fl.relative_index(run)
    assert np.isnan(fl.metrics(run)["relative_index"])
    flags = [word for name, value in STILL.items() for word in (f"--{name}", f"{value:g}")]
    steady = ("--setpoint.kind", "constant", "--setpoint.offset_n", "0.5", "--duration-s", "2")
    answer = frictionloop("simulate", "--preset", "bench", *flags, *steady)
    assert "no relative_index" in answer.out, answer.noted
