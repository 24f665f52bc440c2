"""Names that no parameter has: all are refused at once, and those that people try lead to what is meant."""

from __future__ import annotations

import math

import pytest

import frictionloop as fl
from frictionloop.parameters.aliases import GUESSES
from frictionloop.quantities import check_each_once, check_known

BENCH = fl.bench()


def complaint(overrides, system=BENCH):
    with pytest.raises(fl.FrictionloopError) as caught:
        system.evolve(overrides)
    return str(caught.value)


def test_all_unknown_names_are_told_at_once_a_line_each():
    first, *lines = complaint({"sensor.damping": 0.02, "plate.zzz": 1.0, "controller.kp": 3.0}).splitlines()
    assert first == "2 unknown parameters:"
    assert [line.split(":")[0] for line in lines] == ["  'sensor.damping'", "  'plate.zzz'"]
    assert "sensor.q = 25 (Q = 1/(2 damping))" in lines[0]


def test_a_file_names_the_line_of_each(tmp_path):
    path = tmp_path / "bench.toml"
    path.write_text('preset = "bench"\n[sensor]\nzeta = 0.02\n[controller]\nKp = 3\nrate_hz = 4000\n')
    with pytest.raises(fl.FrictionloopError) as caught:
        fl.read_toml(path)
    first, *lines = str(caught.value).splitlines()
    assert first == f"{path}: 2 unknown parameters:"
    assert [line.rpartition("(line ")[2] for line in lines] == ["3: 'zeta = 0.02')", "5: 'Kp = 3')"]


def test_a_whole_file_and_a_constructor_tell_all_too(tmp_path):
    path = tmp_path / "bench.toml"
    path.write_text("\n".join(fl.to_toml(BENCH).splitlines()).replace("\nmoving_mass_kg", "\nmass"))
    path.write_text(path.read_text().replace("\nresonance_hz", "\nf0", 1))
    with pytest.raises(fl.FrictionloopError, match=r"2 unknown parameters:\n.*'sensor.mass'.*\n.*'sensor.f0'"):
        fl.read_toml(path)
    with pytest.raises(fl.FrictionloopError, match=r"SuspendedSensor: 2 unknown parameters:\n  'damping'.*\n  'mass'"):
        fl.SuspendedSensor(damping=0.02, mass=0.25)


def test_a_conversion_takes_what_other_unknown_names_say():
    told = complaint({"sensor.stiffness": 1e5, "sensor.mass": 0.25, "sensor.noise_mn": 5.0, "sensor.pole": 800.0})
    assert f"sensor.resonance_hz = {math.sqrt(1e5 / 0.25) / math.tau:.6g} Hz" in told
    assert "moving_mass_kg = 0.25" in told
    density = 5e-3 / math.sqrt(math.pi / 2 * 800)
    sensor = BENCH.evolve({"sensor.cutoff_hz": 800.0, "sensor.noise_density_n_rthz": density}).sensor
    assert sensor.noise_rms_n == pytest.approx(5e-3)
    assert f"sensor.noise_density_n_rthz = {density:.6g} N/rtHz" in told


@pytest.mark.slow
@pytest.mark.parametrize("given", [0.0, math.nan, math.inf, True, None, [1.0], "x"])
@pytest.mark.parametrize("word", [guess.words.split()[0] for guess in GUESSES])
@pytest.mark.parametrize("block", ["sensor", "plate", "controller"])
def test_no_value_makes_a_hint_fail(block, word, given):
    name = f"{block}.{word}_x"  # never a parameter
    assert repr(name) in complaint({name: given, f"{block}.{word}z": given})
    if word not in ("q", "kp", "filter", "range", "noise"):
        assert complaint({f"{block}.{word}": given}).startswith("unknown parameter")


# Names given out of those there are: what is refused, and how.


THERE = ("lookup", "retuned_pi", "observer")


def test_what_is_there_once_is_accepted():
    check_known("laws", ["observer", "lookup"], THERE)
    check_known("laws", [], THERE)
    check_each_once("laws", "law", ["observer", "lookup"])
