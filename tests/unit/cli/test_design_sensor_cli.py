"""``frictionloop design``: the sensor as a person and as a program asks for it."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

SENSOR = ("design", "sensor")


@pytest.fixture(autouse=True)
def wide(monkeypatch):
    monkeypatch.setenv("COLUMNS", "100")


@pytest.mark.parametrize("tokens", [("design", "--help"), ("design",)])
def test_help_lists_the_parts(frictionloop, tokens):
    answer = frictionloop(*tokens)
    assert (answer.code, answer.err) == (0, "")
    assert "    sensor " in answer.out
    assert "    plate " in answer.out


@pytest.mark.parametrize("columns", [80, 120])
def test_help_has_examples_that_fit(frictionloop, monkeypatch, columns):
    monkeypatch.setenv("COLUMNS", str(columns))
    answer = frictionloop(*SENSOR, "--help")
    assert "\n  frictionloop design sensor" in answer.out
    assert max(len(line.rstrip()) for line in answer.out.splitlines()) <= columns


@pytest.mark.parametrize(
    ("more", "last"),
    [
        ((), "paper's 0.5 pm"),
        (("--resonance-hz", "145", "--noise-rms-n", "5e-5"), "paper's 0.5 pm"),
        (("--amplifier.swing_v", "8.4"), "no range, no verdict"),
    ],
)
def test_the_answer_fits_a_hundred_columns(frictionloop, more, last):
    answer = frictionloop(*SENSOR, *more)
    assert (answer.code, answer.err) == (0, "")
    assert max(len(line.rstrip()) for line in answer.out.splitlines()) <= 100
    for said in ("resonance", "stress", "base vibration", "* largest at rest", last):
        assert said in answer.out


@pytest.mark.parametrize("columns", [80, 100])
def test_names_of_flags_are_never_broken(frictionloop, monkeypatch, columns):
    monkeypatch.setenv("COLUMNS", str(columns))
    answer = frictionloop(*SENSOR, "--resonance-hz", "145", "--noise-rms-n", "5e-5")
    assert max(len(line.rstrip()) for line in answer.out.splitlines()) <= columns
    for term in frictionloop(*SENSOR, "--json").json()["noise_at_rest"]["terms"]:
        assert term["parameter"] in answer.out
    assert sum(line.rstrip().endswith(" *") for line in answer.out.splitlines()) == 2  # proposed, and largest


@pytest.mark.parametrize("columns", [80, 100])
def test_the_plate_fits(frictionloop, monkeypatch, columns):
    monkeypatch.setenv("COLUMNS", str(columns))
    answer = frictionloop("design", "plate", "--frequency-hz", "40000", "--bandwidth-hz", "150", "--readings")
    assert (answer.code, answer.err) == (0, "")
    assert max(len(line.rstrip()) for line in answer.out.splitlines()) <= columns


def test_the_block_is_toml_of_the_loop(frictionloop):
    out = frictionloop(*SENSOR).out
    block = tomllib.loads(out[out.index("[sensor]") :])["sensor"]
    values = frictionloop(*SENSOR, "--json").json()["sensor"]
    assert block.keys() == values.keys()
    assert block["kind"] == "suspended"
    assert all(block[name] == pytest.approx(values[name], rel=1e-5) for name in values if name != "kind")


def test_flags_and_files_say_the_same(frictionloop):
    Path("mine.toml").write_text("[electrodes]\ngap_um = 150.0\n[springs]\nkind = 'straight'\nlength_mm = 30.0\n")
    from_file = frictionloop(*SENSOR, "mine.toml", "--json").json()
    flags = ("--electrodes.gap-um", "150", "--springs.length_mm=30", "--springs.kind", "straight")
    assert frictionloop(*SENSOR, *flags, "--json").json() == from_file
    assert from_file["design"]["electrodes"]["gap_um"] == 150


def test_a_search_can_be_saved_and_read_again(frictionloop):
    wanted = ("--resonance-hz", "200", "--range-n", "2", "--noise-rms-n", "1e-4")
    found = frictionloop(*SENSOR, *wanted, "--save-design", "s.toml", "--spice", "s.cir", "--json").json()
    assert found["resonance_hz"] == pytest.approx(200, rel=1e-9)
    assert found["noise_at_rest"]["rms_n"] == pytest.approx(1e-4, rel=1e-6)
    assert found["saved"] == {"design": "s.toml", "netlist": "s.cir"}
    assert [option["area_mm2"] for option in found["options"]] == [100, 200, 400, 800]
    assert frictionloop(*SENSOR, "s.toml", "--json").json()["sensor"] == found["sensor"]
    assert Path("s.cir").read_text().endswith(".end\n")


def test_clipping_is_said(frictionloop):
    assert "CLIPS from 1.0" in frictionloop(*SENSOR, "--amplifier.swing_v", "8.4").out
    assert "CLIPS at rest" in frictionloop(*SENSOR, "--amplifier.swing_v", "7").out
    assert frictionloop(*SENSOR, "--amplifier.swing_v", "7", "--json").json()["clips_from_n"] == 0


@pytest.mark.parametrize("more", [("--electrodes.gap_um", "30"), ("--amplifier.swing_v", "8.4")], ids=["rest", "load"])
def test_a_sensor_that_clips_has_no_range_no_verdict_and_no_block(frictionloop, more):
    answer = frictionloop(*SENSOR, *more)
    assert (answer.code, answer.err) == (0, "")
    for withheld in ("dB", "paper's", "[sensor]\n", "block below", "noise_density", "% high"):
        assert withheld not in answer.out
    assert "\nno range, no verdict and no [sensor] block: an amplifier clips within the range" in answer.out
    found = frictionloop(*SENSOR, *more, "--json").json()
    assert found["clips"] is True
    withheld = ("sensor", "not_in_sensor", "block_error", "dynamic_range_db", "nonlinearity")
    assert [found[name] for name in withheld] == [None] * 5
    fine = frictionloop(*SENSOR, "--json").json()
    assert fine["clips"] is False
    assert None not in [fine[name] for name in withheld]


def test_what_the_block_leaves_out_is_said_above_it(frictionloop):
    found = frictionloop(*SENSOR, "--json").json()
    out = " ".join(frictionloop(*SENSOR).out.split())
    said = out[out.index("not in the block") : out.index("[sensor]")]
    rest = {term["name"]: term["rms_n"] for term in found["noise_at_rest"]["terms"]}
    for name in ("base vibration", "tilt", "thermomechanical"):
        assert f"{name}{'*' * (name == found['noise_at_rest']['dominant'])} {rest[name]:.1e}" in said
    assert said.count("*") == 1
    assert "under 2.5 N also excitation amplitude 1.1e-04 N rms, the largest there." in said
    quiet = " ".join(frictionloop(*SENSOR, "--readout.form", "ratio", "--adc.bits", "12").out.split())
    said = quiet[quiet.index("not in the block") : quiet.index("[sensor]")]
    assert "excitation" not in said  # common to both sides
    assert "*" not in said  # the converter is largest, and the block has it


@pytest.mark.parametrize(
    ("tokens", "line"),
    [
        (("--electrodes.gap_um", "5"), "electrodes.gap_um = 5 um: must be greater than the travel of 7.5"),
        (("--adc.range_n", "1"), "adc.range_n = 1 N: must be at least load.range_n = 2.5 N"),
        (("--electrodes.gap", "5"), "unknown parameter 'electrodes.gap'; did you mean electrodes.gap_um"),
        (("--noise-rms-n", "1e-6"), "remain with perfect electronics, most of it base vibration"),
        (("--noise-rms-n", "1e-4", "--noise-density-n-rthz", "1e-6"), "one of them is needed, not both"),
        (("--resonance-hz", "x"), "Invalid value"),
        (("no.toml",), "no.toml: cannot be read (No such file or directory)"),
        (("--save-design", "a.yaml"), "--save-design = 'a.yaml': must end in .toml"),
        (("--spice", "a.txt"), "spice = 'a.txt': must end in .cir"),
    ],
)
def test_bad_input_is_one_line(frictionloop, tokens, line):
    answer = frictionloop(*SENSOR, *tokens)
    assert (answer.code, answer.out) == (2, "")
    assert answer.err.startswith("error: ")
    assert answer.err.count("\n") == 1
    assert line in answer.err


def test_a_saved_design_is_never_replaced(frictionloop):
    Path("s.toml").write_text("# mine\n")
    answer = frictionloop(*SENSOR, "--save-design", "s.toml")
    assert answer.code == 2
    assert "delete it first, or choose another name" in answer.err
