"""Sizing the force sensor: from a geometry to figures, from a requirement to a geometry, and back."""

from __future__ import annotations

import math
import tomllib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictionloop.hardware.sensor import front_end
from frictionloop.hardware.sensor.sensor_answers import clips_from_n, sensor
from frictionloop.hardware.sensor.sensor_search import GAP_PER_TRAVEL, LARGEST_GAP_UM, SensorRequirement, propose_sensor
from frictionloop.parameters.sensor_design import SensorDesign
from frictionloop.parameters.toml_reader import read_design
from frictionloop.parameters.toml_writer import to_toml, write_toml
from frictionloop.quantities import FrictionloopError

LOOP_BLOCK = {
    "kind": "suspended",
    "moving_mass_kg": 0.4,
    "resonance_hz": 145.0,
    "q": 20.0,
    "cutoff_hz": 1000.0,
    "noise_density_n_rthz": 2.3e-6,
    "adc_bits": 16,
    "range_n": 2.5,
}
"""The sensor of ``fl.bench()`` (DESIGN)."""
QUIET = SensorDesign().evolve({"environment.vibration_m_s2_rthz": 1e-9, "environment.tilt_urad": 0.01})


def test_the_figures_of_the_paper():
    """0.4 kg at 145 Hz, by hand."""
    found = sensor(SensorDesign())
    assert found.stiffness.x_n_per_m == pytest.approx(0.4 * (2 * math.pi * found.resonance_hz) ** 2, rel=1e-12)
    assert found.travel_um == pytest.approx(2.5 / 0.332, rel=2e-3)
    assert found.amplitude_v == pytest.approx(10 * 17.7083755 / 22, rel=1e-3)
    # Band-pass Q/(pi f), op-amp's noise gain/(2 pi GBW), and the corner of Rf and Cf, fc/(2 pi f^2).
    corner = 1 / (2 * math.pi * 10e6 * 22e-12)
    delay = 4 / (math.pi * 120e3) + (1 + 117.7 / 22) / (2 * math.pi * 45e6) + corner / (2 * math.pi * 120e3**2)
    assert found.delay_s == pytest.approx(delay, rel=1e-4)
    assert found.dynamic_range_db == pytest.approx(20 * math.log10(2.5 / found.at_rest.rms_n), rel=1e-12)
    assert found.stress_mpa < 5


def test_the_nonlinearity_is_the_square_of_the_travel_over_the_gap():
    balanced = SensorDesign().evolve({"electrodes.imbalance": 0.0})
    found = sensor(balanced)
    part = found.travel_um / 100
    assert found.nonlinearity == pytest.approx(part**2 / (1 - part**2), rel=1e-9)
    assert sensor(balanced.evolve({"readout.form": "ratio"})).nonlinearity == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize(("swing", "expected"), [(12.0, None), (7.0, 0.0)])
def test_no_clipping_and_clipping_at_rest(swing, expected):
    assert clips_from_n(SensorDesign().evolve({"amplifier.swing_v": swing})) == expected


@pytest.mark.parametrize(("swing_v", "from_n"), [(8.4, 1.07), (7.0, 0.0)])
def test_a_sensor_that_clips_has_no_range_and_no_block_and_says_what_does_not(swing_v, from_n):
    found = sensor(overrides={"amplifier.swing_v": swing_v})
    (clips,) = found.findings
    assert found.clips and clips.code == "AMP-CLIPS" and clips.value == pytest.approx(from_n, rel=0.01)
    assert (found.dynamic_range_db, found.suspended, found.omitted) == (None, None, None)
    withheld = ("sensor", "not_in_sensor", "block_error", "dynamic_range_db", "nonlinearity")
    assert {found.to_dict()[name] for name in withheld} == {None} and "[sensor]" not in str(found)
    assert None not in [sensor().to_dict()[name] for name in withheld]
    assert not sensor(overrides={"amplifier.swing_v": swing_v, **clips.remedy}).clips


def test_what_the_block_lacks_and_the_noise_of_the_excitation_are_findings():
    loud, lacks = sensor().findings
    rest = {term.name: 1e6 * term.rms_n for term in sensor().at_rest.terms}
    outside = [rest[name] for name in ("base vibration", "tilt", "thermomechanical")]
    assert lacks.code == "NOISE-OUTSIDE" and lacks.value == pytest.approx(math.hypot(*outside))
    assert lacks.more["term"] == "base vibration"
    assert loud.code == "EXCITATION-LOUD" and loud.limit == pytest.approx(1e6 * sensor().at_rest.rms_n)
    assert [each.code for each in sensor(overrides=loud.remedy).findings] == ["NOISE-OUTSIDE"]


def test_a_block_is_shown_as_toml_of_the_loop():
    found = sensor()
    shown = str(found)
    block = tomllib.loads(shown[shown.index("[sensor]") : shown.rindex("\n\n")])["sensor"]
    assert block == {
        name: pytest.approx(value, rel=1e-5) if isinstance(value, float) else value
        for name, value in found.suspended.items()
    }


def test_a_file_and_overrides_say_the_same_and_a_search_begins_with_both(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text("[electrodes]\ngap_um = 150.0\n[springs]\nkind = 'straight'\nlength_mm = 30.0\n")
    overrides = {"electrodes.gap_um": 150.0, "springs.kind": "straight", "springs.length_mm": 30.0}
    assert sensor(path).to_dict() == sensor(overrides=overrides).to_dict()
    assert sensor(path).design.electrodes.gap_um == 150.0
    found = sensor(path, resonance_hz=200.0, noise_rms_n=1e-4)
    assert found.resonance_hz == pytest.approx(200.0, rel=1e-9) and found.design.springs.kind == "straight"
    assert found.at_rest.rms_n == pytest.approx(1e-4, rel=1e-6)
    assert [option.area_mm2 for option in found.proposal.options] == [100, 200, 400, 800]
    assert sensor(range_n=2.5).proposal.requirement.noise_rms_n == 5e-5
    with pytest.raises(FrictionloopError, match="must be one of them"):
        sensor(noise_rms_n=1e-4, noise_density_n_rthz=1e-6)


@pytest.mark.parametrize("form", ["subtraction", "ratio"])
def test_the_block_and_what_it_leaves_out_are_all_noise(form):
    """In power: electronics of the block, its converter, what is left out."""
    found = sensor(SensorDesign().evolve({"readout.form": form}))
    left, design = found.omitted, found.design
    white = sum(term.rms_n**2 for term in found.at_rest.terms if term.white)
    step = 2 * design.adc.range_n / 2**design.adc.bits
    assert white + step**2 / 12 + left.rest_rms_n**2 == pytest.approx(found.at_rest.rms_n**2, rel=1e-12)
    assert sorted(left.at_rest_n) == ["base vibration", "thermomechanical", "tilt"]
    # Tilt by hand, m g theta; the load adds to the electronics only.
    assert left.at_rest_n["tilt"] == pytest.approx(0.4 * 9.80665 * 1e-6, rel=1e-12)
    assert left.force_n == design.load.range_n
    added = found.at_range.rms_n**2 - found.at_rest.rms_n**2
    assert left.under_load_n**2 == pytest.approx(max(added, 0.0), rel=1e-6, abs=1e-14)


@settings(max_examples=25)
@given(st.floats(8.2, 8.7))
def test_clipping_starts_where_the_amplitude_reaches_the_swing(swing):
    design = SensorDesign().evolve({"amplifier.swing_v": swing})
    force = clips_from_n(design)
    assert force is not None
    assert front_end.peak_amplifier_v(design, force) == pytest.approx(swing, rel=1e-6)
    # With an ideal amplifier eps0 A (1 + imbalance) V/(Cf (e - x)) is the swing. Rf and the op-amp change the amplitude
    # by less than 0.1 %, and with it e - x, which is k e = 33 N.
    left_m = 8.8541878e-12 * 200e-6 * 1.01 * 10 / (22e-12 * swing)
    k = sensor(SensorDesign()).stiffness.x_n_per_m
    assert force == pytest.approx(k * (100e-6 - left_m), abs=0.033)


@pytest.mark.slow
@settings(max_examples=15, deadline=None)
@given(st.floats(60, 300), st.floats(0.5, 5), st.floats(6e-5, 1e-3), st.sampled_from(["subtraction", "ratio"]))
def test_what_is_proposed_does_what_was_asked(resonance, range_n, noise, form):
    base = QUIET.evolve({"readout.form": form})
    proposal = propose_sensor(SensorRequirement(resonance, range_n, noise_rms_n=noise), base)
    found = sensor(proposal.design)
    assert found.resonance_hz == pytest.approx(resonance, rel=1e-9)
    assert found.clips_from_n is None
    assert found.design.electrodes.gap_um >= GAP_PER_TRAVEL * found.travel_um
    if proposal.gap_is_largest:
        assert found.at_rest.rms_n <= noise
    else:
        assert found.at_rest.rms_n == pytest.approx(noise, rel=1e-6)
    for option in proposal.options:
        assert option.design is None or sensor(option.design).at_rest.rms_n <= noise * (1 + 1e-6)


def proposed(block):
    """A geometry that has the values of a loop's sensor block."""
    changes = {"moving.mass_kg": "moving_mass_kg", "moving.q": "q", "filters.cutoff_hz": "cutoff_hz"}
    base = SensorDesign().evolve({path: block[name] for path, name in (changes | {"adc.bits": "adc_bits"}).items()})
    noise = block["noise_density_n_rthz"]
    return propose_sensor(SensorRequirement(block["resonance_hz"], block["range_n"], noise_density_n_rthz=noise), base)


@pytest.mark.parametrize("cutoff", [300.0, 1000.0])
def test_the_block_of_the_loop_comes_back(cutoff):
    block = LOOP_BLOCK | {"cutoff_hz": cutoff}
    found = sensor(proposed(block).design).suspended
    assert found.keys() == block.keys()
    for name, value in block.items():
        assert found[name] == (value if isinstance(value, str) else pytest.approx(value, rel=1e-9)), name


@pytest.mark.slow
@settings(max_examples=10, deadline=None)
@given(
    mass=st.floats(0.2, 1),
    resonance=st.floats(80, 250),
    q=st.floats(2, 100),
    cutoff=st.floats(200, 2000),
    bits=st.integers(10, 20),
    range_n=st.floats(1, 5),
)
def test_any_block_comes_back(mass, resonance, q, cutoff, bits, range_n):
    block = {
        "kind": "suspended",
        "moving_mass_kg": mass,
        "resonance_hz": resonance,
        "q": q,
        "cutoff_hz": cutoff,
        "noise_density_n_rthz": 1e-6 * mass * resonance**2 / (0.4 * 145**2),
        "adc_bits": bits,
        "range_n": range_n,
    }
    found = sensor(proposed(block).design).suspended
    for name, value in block.items():
        assert found[name] == (value if isinstance(value, str) else pytest.approx(value, rel=1e-9)), name


def test_the_loop_accepts_the_block():
    plant = pytest.importorskip("frictionloop.parameters.plant")
    if not hasattr(plant, "SuspendedSensor"):
        pytest.skip("this version has no sensor block of kind 'suspended'")
    block = plant.SuspendedSensor(**sensor().suspended)
    assert block.resonance_hz == pytest.approx(145, abs=0.05)
    default = plant.SuspendedSensor().model_dump()
    back = sensor(proposed(default).design).suspended
    assert {k: v for k, v in back.items() if k != "kind"} == pytest.approx(
        {k: v for k, v in default.items() if k != "kind"}, rel=1e-9
    )


def test_the_loops_block_is_the_baseband_model_after_a_delay():
    """Within 0.1 % and 0.1 degree to 500 Hz, as asked of the baseband model."""
    f = np.linspace(1, 500, 500)
    ratio = front_end.loop_response(SensorDesign(), f) / front_end.sensor_response(SensorDesign(), f)
    assert np.max(np.abs(np.abs(ratio) - 1)) < 1e-3
    assert np.max(np.abs(np.angle(ratio, deg=True))) < 0.1


def test_an_easy_requirement_ends_at_the_widest_gap():
    proposal = propose_sensor(SensorRequirement(145, 2.5, noise_rms_n=0.1))
    assert proposal.gap_is_largest
    assert proposal.design.electrodes.gap_um == LARGEST_GAP_UM


@pytest.mark.parametrize("overrides", [{}, {"springs.kind": "straight", "springs.length_mm": 25.0, "adc.bits": 18}])
def test_a_file_comes_back(tmp_path, overrides):
    design = SensorDesign().evolve(overrides)
    write_toml(design, tmp_path / "sensor.toml")
    assert read_design(tmp_path / "sensor.toml", SensorDesign()) == design
    assert (tmp_path / "sensor.toml").read_text() == to_toml(design)


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("x = [", "s.toml: is not TOML"),
        ("schema = 99", "s.toml: schema = 99: "),
        ("[electrodes]\ngap = 3", "s.toml: unknown parameter 'electrodes.gap'"),
        ("[moving]\nq = -1", "s.toml: moving.q = -1: must be greater than 0"),
        ("[moving]\nq = 'x'", "s.toml: moving.q = 'x': "),
        ("moving = 3", "s.toml: moving = 3: "),
        (None, "s.toml: cannot be read (No such file or directory)"),
    ],
)
def test_a_bad_file_is_one_line(tmp_path, monkeypatch, text, line):
    monkeypatch.chdir(tmp_path)
    if text is not None:
        (tmp_path / "s.toml").write_text(text)
    with pytest.raises(FrictionloopError) as caught:
        read_design("s.toml", SensorDesign())
    assert line in str(caught.value)
    assert "\n" not in str(caught.value)
