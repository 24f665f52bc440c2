"""A recording is read, or in doubt, so that nothing but what was meant enters a run."""

from __future__ import annotations

import h5py
import numpy as np
import pytest
from scipy.io import savemat, wavfile

import frictionloop as fl
from frictionloop.loop.input_findings import of_recorded
from frictionloop.quantities import FrictionloopError
from frictionloop.recordings.force_channel import read_recording
from frictionloop.recordings.force_channel import scaled as found
from frictionloop.recordings.plausibility import doubts_of

RATE_HZ = 1000.0


def values(samples=1000, mean_n=0.5):
    return mean_n + 0.05 * np.sin(2 * np.pi * 5 * np.arange(samples) / RATE_HZ)


def asked(system):
    return list(doubts_of(system))


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
    with pytest.raises(FrictionloopError, match=r"may be any of 2 signals; accepted: 'trial1/force"):
        found(fl.Recording(path=str(path)))
    assert found(fl.Recording(path=str(path), column="trial1/force")).channel.name == "trial1/force"


def test_the_only_signal_beside_times_and_a_rate_is_taken(tmp_path):
    with h5py.File(tmp_path / "one.h5", "w") as file:
        file["a_time"], file["fs"], file["trial/forces"] = 1.0, RATE_HZ, values()[:, None]
    read = found(fl.Recording(path=str(tmp_path / "one.h5")))
    assert (read.channel.name, read.rate_hz) == ("trial/forces", RATE_HZ)
    with h5py.File(tmp_path / "two.h5", "w") as file:
        file["trial/forces"] = np.c_[values(), values()]
    line = fl.Recording(path=str(tmp_path / "two.h5"), column="trial/forces[:, 1]", rate_hz=RATE_HZ)
    assert found(line).channel.name == "trial/forces[:, 1]"


@pytest.mark.parametrize(("tones_hz", "shares"), [((4000,), [100.0]), ((100,), [])])
def test_what_resampling_takes_out_is_found(tmp_path, tones_hz, shares):
    said = [each for each in of_recorded(under(wav(tmp_path / "d.wav", *tones_hz)), 0.9) if each.code == "TOO-FAST"]
    assert [each.value for each in said] == pytest.approx(shares, abs=0.5)


def test_no_share_is_left_of_what_did_not_enter(tmp_path):
    run = fl.simulate(under(wav(tmp_path / "d.wav", 4000)), 0.9)
    assert np.isnan(fl.metrics(run)["disturbance_left"])


@pytest.mark.parametrize("name",
    ["Normal force", "load", "Fz", "normal_force", "Normalkraft", "Andruckkraft", "Auflagekraft", "Force normale",
     "effort normal", "appui"],
)  # fmt: skip
def test_a_column_named_as_a_load_is_asked_about(tmp_path, name):
    (tmp_path / "d.csv").write_text(f"{name} [N],tangential [N],overload\n1,0.5,1\n1.1,0.6,2\n")
    load, friction, other = (
        fl.Recording(path=str(tmp_path / "d.csv"), column=each, rate_hz=RATE_HZ)
        for each in (name, "tangential", "overload")
    )
    (one,) = asked(under(load))
    assert one.code == "COLUMN-DOUBT" and one.value.startswith(name)
    assert asked(under(friction)) == asked(under(other)) == []


@pytest.mark.parametrize("name", ["Voltage", "voltage_lateral", "ADC", "raw counts", "Spannung"])
def test_a_column_named_as_what_a_sensor_puts_out_is_asked_about(tmp_path, name):
    (tmp_path / "d.csv").write_text(f"{name},evolution\n1,0.5\n1.1,0.6\n")
    voltage, other = (
        fl.Recording(path=str(tmp_path / "d.csv"), column=each, rate_hz=RATE_HZ) for each in (name, "evolution")
    )
    assert [each.remedy for each in asked(under(voltage))] == ["another disturbance.scale"]
    scaled = voltage.model_copy(update={"scale": 0.5})
    assert asked(under(scaled)) == asked(under(other)) == []


@pytest.mark.parametrize(
    "name", ["mu", "Mu", "COF", "friction coefficient", "Friction_Coefficient", "coeff of friction"]
)
def test_a_column_named_as_a_coefficient_is_asked_about_unless_its_unit_is_known(tmp_path, name):
    (tmp_path / "d.csv").write_text(f"{name},multi,mu_cal_n,friction\n1,0.5,1,1\n1.1,0.6,2,1.1\n")
    columns = {each: fl.Recording(path=str(tmp_path / "d.csv"), column=each, rate_hz=RATE_HZ) for each in
               (name, "multi", "mu_cal_n", "friction")}  # fmt: skip
    (one,) = asked(under(columns.pop(name)))
    assert (one.code, one.value, one.remedy) == ("COLUMN-DOUBT", name, "another disturbance.column")
    assert [asked(under(each)) for each in columns.values()] == [[], [], []]
    scaled = fl.Recording(path=str(tmp_path / "d.csv"), column=name, rate_hz=RATE_HZ, scale=0.5)
    assert asked(under(scaled)) == []


def test_a_column_that_never_changes_is_asked_about(tmp_path):
    (tmp_path / "d.csv").write_text("Fx [N],Fy [N]\n0,0.5\n0,0.6\n0,0.4\n")
    still, moving = (fl.Recording(path=str(tmp_path / "d.csv"), column=each, rate_hz=RATE_HZ) for each in ("Fx", "Fy"))
    assert [(each.code, each.value) for each in asked(under(still))] == [("COLUMN-DOUBT", "Fx")]
    assert asked(under(moving)) == []


def test_what_was_read_has_rms_and_mean(tmp_path):
    (tmp_path / "e.csv").write_text("force [N]\n0.4\n0.8\n0.7\n")
    read = found(fl.Recording(path=str(tmp_path / "e.csv"), rate_hz=RATE_HZ, remove_mean=True))
    read = read.summary()
    assert [read[f"raw_{each}_n"] for each in ("lowest", "highest", "mean")] == pytest.approx([0.4, 0.8, 1.9 / 3])
    assert (read["mean_n"], read["rms_n"]) == (0.0, pytest.approx(np.std([0.4, 0.8, 0.7])))


def test_an_index_over_a_stroke_that_does_not_vary_is_refused():
    from frictionloop.parameters.presets import STILL

    still = fl.bench().evolve({**STILL, "setpoint": fl.Constant(offset_n=0.5)})
    run = fl.simulate(still, 2.0)
    with pytest.raises(FrictionloopError, match="varies by nothing"):
        fl.relative_index(run)
    assert np.isnan(fl.metrics(run)["relative_index"])


def test_files_of_numpy_are_read(tmp_path):
    np.save(tmp_path / "one.npy", values())
    np.save(tmp_path / "two.npy", np.c_[values(), 2 * values()])
    np.savez(tmp_path / "more.npz", force=values(), load=values(), fs=RATE_HZ)
    one, two, more = (
        fl.Recording(path=str(tmp_path / name), **flags)
        for name, flags in (
            ("one.npy", {"rate_hz": RATE_HZ}),
            ("two.npy", {"column": "array[:, 1]", "rate_hz": RATE_HZ}),
            ("more.npz", {"column": "force"}),
        )
    )
    for recording, factor in ((one, 1), (two, 2), (more, 1)):
        np.testing.assert_array_equal(read_recording(recording, RATE_HZ), factor * values())
    for name, said in (
        ("two.npy", r"may be any of 2 signals; accepted: 'array\[:, 0\]'"),
        ("more.npz", "any of 2 signals"),
    ):
        with pytest.raises(FrictionloopError, match=said):
            found(fl.Recording(path=str(tmp_path / name), rate_hz=RATE_HZ))
    np.save(tmp_path / "any.npy", np.array([object()]), allow_pickle=True)
    with pytest.raises(FrictionloopError, match="damaged"):
        found(fl.Recording(path=str(tmp_path / "any.npy"), rate_hz=RATE_HZ))


def test_gaps_are_named_in_seconds_with_the_flags_that_cut_the_longest_part_out(tmp_path):
    holes = values()
    holes[100:103] = holes[400] = np.nan
    np.save(tmp_path / "holes.npy", holes)
    recording = fl.Recording(path=str(tmp_path / "holes.npy"), rate_hz=RATE_HZ)
    with pytest.raises(FrictionloopError) as refused:
        found(recording)
    said = str(refused.value)
    assert "no number at 0.1 to 0.102 s, 0.4 s; accepted: a finite number, or" in said
    assert "--disturbance.start_s 0.401 --disturbance.stop_s 0.999" in said
    cut = recording.model_copy(update={"start_s": 0.401, "stop_s": 0.999})
    np.testing.assert_array_equal(read_recording(cut, RATE_HZ), holes[401:])
