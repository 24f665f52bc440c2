"""A System as a TOML file: out and in again, and every complaint in one line."""

from __future__ import annotations

import os
import re
import tomllib
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from kinds import kinds_of

import frictionloop as fl

number = st.floats(-1e9, 1e9)
positive = st.floats(1e-9, 1e9)
fraction = st.floats(0, 1)
# Whatever a path, a column or a unit may be: quotes, backslashes, line ends, control characters, any script.
text = st.text(max_size=20) | st.sampled_from(
    ['a"b', "C:\\new\\table", "tab\tline\nend\r", "'''", '"""', "µN/√Hz", "\x7f\x00", "#"]
)


@st.composite
def steps(draw):
    levels = draw(st.lists(number, min_size=1, max_size=5))
    gaps = draw(st.lists(st.floats(1e-3, 10), min_size=len(levels) - 1, max_size=len(levels) - 1))
    return fl.Steps(times_s=tuple(sum(gaps[:k]) for k in range(len(levels))), levels_n=tuple(levels))


@st.composite
def windows(draw):
    start = draw(st.floats(0, 1e3))
    stop = draw(st.none() | st.floats(1e-3, 1e3).map(lambda length: start + length))
    return fl.Recording(
        path=draw(text), column=draw(text), rate_hz=draw(st.none() | positive), scale=draw(number),
        offset_n=draw(number), unit=draw(text), start_s=start, stop_s=stop, remove_mean=draw(st.booleans()),
        rectify=draw(st.none() | st.booleans()),
    )  # fmt: skip


frequencies = st.tuples(positive, positive).filter(lambda pair: pair[0] != pair[1])
SOURCES = {
    "constant": st.builds(fl.Constant, offset_n=number),
    "sine": st.builds(fl.Sine, offset_n=number, amplitude_n=number, frequency_hz=positive),
    "log_sweep": st.builds(
        lambda ends, **rest: fl.LogSweep(start_hz=ends[0], stop_hz=ends[1], **rest),
        frequencies, offset_n=number, amplitude_n=number, sweep_s=positive,
    ),
    "steps": steps(),
    "noise": st.builds(
        lambda ends, **rest: fl.ColouredNoise(low_hz=min(ends), high_hz=max(ends), **rest),
        frequencies, offset_n=number, rms_n=positive | st.just(0.0), exponent=st.floats(0, 2),
    ),
    "recording": windows(),
    "samples": st.builds(fl.Samples, values_n=st.lists(number, min_size=2, max_size=9), rate_hz=positive),
}  # fmt: skip
model = st.builds(
    fl.Model, nominal_n=positive, susceptibility_per_um2=st.floats(0.01, 10), max_amplitude_um=st.floats(0.1, 5),
    table_size=st.just(0) | st.integers(2, 65536),
)  # fmt: skip
systems = st.builds(
    fl.System,
    setpoint=st.one_of(*SOURCES.values()),
    disturbance=st.one_of(*SOURCES.values()),
    friction=st.builds(fl.Friction, nominal_n=positive, susceptibility_per_um2=st.floats(1e-9, 1.0)),
    plate=st.builds(fl.LowpassPlate, cutoff_hz=positive, max_amplitude_um=st.floats(1e-9, 20.0)),
    sensor=st.builds(fl.LowpassSensor, cutoff_hz=positive, noise_rms_n=fraction),
    controller=st.builds(
        fl.PiController,
        kp=positive,
        ki=positive | st.just(0.0),
        rate_hz=st.floats(1e-3, 1e6),
        delay_s=fraction,
        model=model,
    ),
)


def test_every_kind_of_source_is_tried():
    assert {kind.model_fields["kind"].default for kind in kinds_of("setpoint")} - {"effect"} == set(SOURCES)


@pytest.mark.slow
@settings(max_examples=300, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(system=systems)
def test_out_and_in_again(system, tmp_path):
    path = tmp_path / "system.toml"
    fl.write_toml(system, path)
    assert fl.read_toml(path) == seen_from_anywhere(system)


def seen_from_anywhere(system):
    """Return the system with the paths of its recordings absolute."""
    recordings = [name for name in ("setpoint", "disturbance") if hasattr(getattr(system, name), "path")]
    return system.evolve({f"{name}.path": str(Path(getattr(system, name).path).absolute()) for name in recordings})


@pytest.mark.parametrize("inside", [True, False])
def test_a_recording_is_found_from_the_file_not_from_where_one_stands(tmp_path, monkeypatch, inside):
    lab, other = tmp_path / "lab", tmp_path / "other"
    folder = lab / "data" if inside else other
    folder.mkdir(parents=True)
    other.mkdir(exist_ok=True)
    (folder / "finger.csv").write_text("0.1\n0.2\n")
    lab.mkdir(exist_ok=True)
    monkeypatch.chdir(tmp_path)
    recording = fl.Recording(path=str((folder / "finger.csv").relative_to(tmp_path)), rate_hz=5000.0)
    fl.write_toml(fl.paper().evolve({"disturbance": recording}), lab / "bench.toml")
    monkeypatch.chdir(other)
    assert Path(fl.read_toml(lab / "bench.toml").disturbance.path).read_text() == "0.1\n0.2\n"
    assert ("data/finger.csv" in (lab / "bench.toml").read_text()) == inside
    if inside:
        moved = lab.rename(tmp_path / "moved")
        assert Path(fl.read_toml(moved / "bench.toml").disturbance.path).is_file()


@pytest.mark.parametrize("name", ["paper", "feasible"])
def test_preset_alone(tmp_path, name):
    path = tmp_path / "mine.toml"
    path.write_text(f'preset = "{name}"\n')
    assert fl.read_toml(path) == fl.preset(name) == getattr(fl, name)()


def test_a_preset_file_holds_what_differs(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(
        """
        schema = 1
        preset = "feasible"
        [controller]
        kp = 4          # a whole number is a number
        model.table_size = 64
        [disturbance]
        path = "finger.csv"   # before its kind
        kind = "recording"
        """
    )
    expected = fl.feasible().evolve(
        {
            "controller.kp": 4.0,
            "controller.model.table_size": 64,
            "disturbance": fl.Recording(path=str(tmp_path / "finger.csv")),
        }
    )
    assert fl.read_toml(path) == expected


def test_numbers_carry_their_units():
    text = fl.to_toml(fl.paper())
    assert "cutoff_hz = 100.0  # Hz" in text
    assert "susceptibility_per_um2 = 0.38  # um^-2" in text
    assert "ki = 2.0  # 1/s" in text
    assert text.startswith("schema = 1\n")
    assert tomllib.loads(text)["controller"]["model"]["table_size"] == 0


def test_writing_replaces_the_old_file_whole(tmp_path):
    path = tmp_path / "system.toml"
    fl.write_toml(fl.paper(), path)
    fl.write_toml(fl.feasible(), path)
    assert fl.read_toml(path) == fl.feasible()
    assert os.listdir(tmp_path) == ["system.toml"]


@pytest.mark.parametrize("kind", [each.model_fields["kind"].default for each in kinds_of("controller")])
def test_the_kind_of_a_controller_comes_first(kind):
    lines = fl.to_toml(fl.bench().evolve({"controller.kind": kind})).splitlines()
    assert lines[lines.index("[controller]") + 1] == f'kind = "{kind}"'


@pytest.mark.parametrize("kind", [each.model_fields["kind"].default for each in kinds_of("controller")])
@pytest.mark.parametrize("every", [True, False])
def test_a_file_without_what_is_rare_is_the_same_system(tmp_path, kind, every):
    system = fl.bench().evolve({"controller.kind": kind})
    fl.write_toml(system, tmp_path / "mine.toml", every)
    assert fl.read_toml(tmp_path / "mine.toml") == system


def test_each_key_says_what_it_means():
    lines = [line for line in fl.to_toml(fl.bench()).splitlines() if " = " in line]
    without = [line for line in lines if "  # " not in line and not line.startswith(("schema", "kind"))]
    assert without == []
    assert 'form = "float"  # The float64 law, or the fixed-point C' in fl.to_toml(fl.bench())


def test_what_is_rare_is_written_where_it_is_not_the_default():
    plain = fl.to_toml(fl.bench(), every=False)
    assert not any(name in plain for name in ("[board]", "[touch]", "jitter_s", "table_size", "\nperson"))
    changed = fl.bench().evolve({"controller.jitter_s": 1e-5, "touch.load.mean_s": 0.4})
    said = fl.to_toml(changed, every=False)
    assert "jitter_s = 1e-05" in said and "mean_s = 0.4" in said and "[board]" not in said
    assert len(plain.splitlines()) < 0.75 * len(fl.to_toml(fl.bench()).splitlines())


def test_a_source_stands_only_beside_the_value_it_belongs_to():
    def line(system, key):
        return next(each for each in fl.to_toml(system).splitlines() if each.startswith(f"{key} = "))

    assert "(paper, Sec. 2.3)" in line(fl.paper(), "kp")
    assert line(fl.paper().evolve({"controller.kp": 12.0}), "kp") == "kp = 12.0  # N/N: Proportional gain K_p"
    assert "paper" in line(fl.bench(), "max_amplitude_um")
    assert "paper" not in line(fl.bench().evolve({"plate.max_amplitude_um": 2.0}), "max_amplitude_um")


def test_a_number_of_the_preset_stands_only_beside_the_presets_value():
    own = fl.to_toml(fl.bench().evolve({"sensor.noise_density_n_rthz": 2.61e-5, "friction.reference_load_n": 0.4}))
    assert "noise_density_n_rthz = 2.61e-05  # N/rtHz: White noise before the low-pass\n" in own
    assert "reference_load_n = 0.4  # N: Load N0 at which the limit is nominal_n\n" in own
    assert "5e-5 N rms below 300 Hz" not in own
    assert "5e-5 N rms below 300 Hz" in fl.to_toml(fl.bench())


@pytest.mark.parametrize("order", [("noise_rms_n", "cutoff_hz"), ("cutoff_hz", "noise_rms_n")])
def test_an_rms_noise_of_a_suspended_sensor_is_told_as_the_density_it_stands_for(tmp_path, order):
    values = {"noise_rms_n": 0.8e-3, "cutoff_hz": 600.0}
    file = tmp_path / "bench.toml"
    file.write_text('preset = "bench"\n[sensor]\n' + "".join(f"{name} = {values[name]}\n" for name in order))
    with pytest.raises(fl.FrictionloopError) as refused:
        fl.read_toml(file)
    said = str(refused.value)
    assert said.endswith(
        "did you mean sensor.noise_density_n_rthz = 2.60588e-05 N/rtHz "
        "(a density: rms / sqrt(pi/2 cutoff_hz), cutoff_hz = 600)? "
        f"(line {3 + order.index('noise_rms_n')}: 'noise_rms_n = 0.0008')"
    )
    density = float(said.partition(" = ")[2].split()[0])
    system = fl.bench().evolve({"sensor.cutoff_hz": 600.0, "sensor.noise_density_n_rthz": density})
    assert system.sensor.noise_rms_n == pytest.approx(0.8e-3, rel=1e-3)


def test_a_byte_order_mark_is_no_part_of_a_file(tmp_path):
    path = tmp_path / "bench.toml"
    path.write_bytes(b'\xef\xbb\xbfpreset = "bench"\n[controller]\nkp = 3\n')
    assert fl.read_toml(path) == fl.bench().evolve({"controller.kp": 3.0})


def test_where_a_default_comes_from_is_not_said_of_a_value_that_was_given():
    """Though it is equal: it is then that of who gave it."""
    bench = fl.bench()
    source = re.search(r"^stroke_mm = .*$", fl.to_toml(bench), re.MULTILINE)[0]
    given = re.search(r"^stroke_mm = .*$", fl.to_toml(bench, given={"motion.stroke_mm"}), re.MULTILINE)[0]
    assert "(assumed)" in source and "(assumed)" not in given and given.startswith(source.split("(")[0].rstrip())
    nested = fl.to_toml(bench, given={"touch.load.mean_s"})
    pairs = zip(nested.splitlines(), fl.to_toml(bench).splitlines(), strict=True)
    assert [now.split()[0] for now, was in pairs if now != was] == ["mean_s"]
