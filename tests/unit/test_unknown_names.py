"""Names that no parameter has: all are refused at once, and those that people try lead to what is meant."""

import math

import pytest

import frictionloop as fl
from frictionloop.parameters.aliases import GUESSES

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


@pytest.mark.parametrize(
    ("path", "given", "meant"),
    [
        ("sensor.damping", 0.02, "sensor.q = 25 (Q = 1/(2 damping))"),
        ("sensor.damping_ratio", "small", "sensor.q (Q = 1/(2 damping))"),
        ("sensor.log_decrement", 0.12, "sensor.q = 26.1799 (Q = pi/decrement)"),
        ("plate.logarithmic_decrement", 0.01, "plate.q = 314.159 (Q = pi/decrement)"),
        ("plate.zeta", 0.02, "plate.q = 25 (Q = 1/(2 damping))"),
        ("finger.damping", 1.0, "finger.damping_n_s_m (N s/m)"),  # it has one
        ("sensor.natural_frequency", 210.0, "sensor.resonance_hz (Hz)"),
        ("sensor.f0", 210.0, "sensor.resonance_hz (Hz)"),
        ("plate.f0", 32400.0, "plate.frequency_hz (Hz)"),
        ("friction.f0", 0.9, "friction.nominal_n (N)"),
        ("sensor.bandwidth", 800.0, "sensor.cutoff_hz (Hz)"),
        ("sensor.time_constant", 2e-4, "sensor.cutoff_hz = 795.775 Hz (1/(2 pi tau))"),
        ("sensor.noise_density", 1e-6, "sensor.noise_density_n_rthz (N/rtHz)"),
        ("controller.gain", 0.1, "controller.kp (N/N)"),
        ("controller.Kp", 0.1, "controller.kp (N/N)"),
        ("controller.Ti", 0.5, "controller.ki = 20 1/s (Kp/Ti, kp = 10)"),
        ("controller.Ts", 2.5e-4, "controller.rate_hz = 4000 Hz (1/Ts)"),
        ("controller.ts_ms", 0.25, "controller.rate_hz = 4000 Hz (1/Ts)"),
        ("controller.sample_rate", 4000.0, "controller.rate_hz (Hz)"),
        ("controller.latency_ms", 0.3, "controller.delay_s = 0.0003 s"),
        ("controller.delay_samples", 1.3, "controller.delay_s = 0.00026 s (periods/rate_hz, rate_hz = 5000)"),
        ("sensor.mass", 0.25, "sensor.moving_mass_kg (kg)"),
        ("sensor.mass_g", 250, "sensor.moving_mass_kg = 0.25 kg"),
        ("plate.amplitude_pp_um", 3.0, "plate.max_amplitude_um = 1.5 um (zero-to-peak, half of peak-to-peak)"),
        ("motion.force", 0.7, "motion.load_n (N)"),
        ("friction.mu", 0.9, "friction.nominal_n = 0.9 N (a force: mu times the load)"),
    ],
)
def test_what_people_call_a_thing_leads_to_its_name(path, given, meant):
    assert complaint({path: given}) == f"unknown parameter {path!r}; did you mean {meant}?"


def test_a_conversion_takes_what_other_unknown_names_say():
    told = complaint({"sensor.stiffness": 1e5, "sensor.mass": 0.25, "sensor.noise_mn": 5.0, "sensor.pole": 800.0})
    assert f"sensor.resonance_hz = {math.sqrt(1e5 / 0.25) / math.tau:.6g} Hz" in told
    assert "moving_mass_kg = 0.25" in told
    density = 5e-3 / math.sqrt(math.pi / 2 * 800)
    sensor = BENCH.evolve({"sensor.cutoff_hz": 800.0, "sensor.noise_density_n_rthz": density}).sensor
    assert sensor.noise_rms_n == pytest.approx(5e-3)
    assert f"sensor.noise_density_n_rthz = {density:.6g} N/rtHz" in told


def test_a_name_of_another_kind_says_the_kind():
    told = complaint({"sensor.damping": 0.02}, fl.paper())
    assert "sensor.q = 25" in told
    assert "--sensor.kind suspended" in told


@pytest.mark.slow
@pytest.mark.parametrize("given", [0.0, math.nan, math.inf, True, None, [1.0], "x"])
@pytest.mark.parametrize("word", [guess.words.split()[0] for guess in GUESSES])
@pytest.mark.parametrize("block", ["sensor", "plate", "controller"])
def test_no_value_makes_a_hint_fail(block, word, given):
    name = f"{block}.{word}_x"  # never a parameter
    assert repr(name) in complaint({name: given, f"{block}.{word}z": given})
    if word not in ("q", "kp", "filter", "range", "noise"):
        assert complaint({f"{block}.{word}": given}).startswith("unknown parameter")


@pytest.mark.parametrize(
    ("name", "given", "said"),
    [
        ("contact", "slider", "0 of a slider"),
        ("bristle_stiffness_n_m", 2e4, "0.6 N"),
        ("bristle_damping_n_s_m", 1.4, "no damper"),
    ],
)
def test_a_contact_of_before_is_told_its_slip_length(name, given, said):
    with pytest.raises(fl.FrictionloopError, match=f"finger.{name}.*finger.slip_length_um.*{said}") as error:
        fl.bench().evolve({f"finger.{name}": given})
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("compliance_um_per_n", "slip_length_um = 30 um"),
        ("skin_stiffness_n_m", "slip_length_um"),
        ("learning_s", "susceptibility_margin"),
        ("susceptibility_spread", "susceptibility_margin"),
    ],
)
def test_a_field_that_the_limit_observer_had_names_the_one_it_has(name, said):
    told = complaint({"controller.kind": "limit_observer", f"controller.{name}": 50.0})
    assert f"did you mean controller.{said}" in told and "\n" not in told
