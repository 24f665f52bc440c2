"""What is said of a designed controller besides its corners."""

from __future__ import annotations

import math

import pytest

import frictionloop as fl
from frictionloop.cli import controller_also as also
from frictionloop.cli import flags
from frictionloop.cli.controller_holds import also_said
from frictionloop.design.corners import Corner
from frictionloop.design.elsewhere import Elsewhere, Place
from frictionloop.design.over import with_longest_contact
from frictionloop.design.requirements import Designed, Requirements
from frictionloop.parameters.motion import one_stroke_a_contact

WEAK = fl.bench().evolve({"controller.kind": "pi", "controller.kp": 0.0, "controller.ki": 7.0})


def test_a_finger_that_never_lifts_is_judged_fully_moist():
    said = also.fully_moist(WEAK, Requirements())
    assert said.startswith("the file's finger at 100 % occlusion (not lifted for about 60 s): stable, Ms is ")
    assert also.moist_row(WEAK, Requirements(), said, False) == [("fully moist", said)]
    *_, (_, others) = also.moist_row(WEAK, Requirements(), said, True)
    stay = "which are less moist above: run it if people stay on the plate"
    assert others == f"`--motion.contact_s 60` looks at the other fingers so, {stay}"
    for ki, dry, told in ((120.0, False, "lift the finger before"), (3000.0, True, "as on a finger just landed")):
        strong = WEAK.evolve({"controller.ki": ki})
        assert any(math.isinf(loop.sensitivity_peak()) for loop in fl.operating_band(strong, occluded=(0.0,))) == dry
        said = also.fully_moist(strong, Requirements())
        assert "UNSTABLE" in said and told in said and ("lift the finger" in said) == (not dry)
    assert also.fully_moist(WEAK.evolve({"motion.contact_s": 10.0}), Requirements()) == ""
    assert also.fully_moist(fl.feasible(), Requirements()) == ""


def test_a_range_below_the_friction_of_a_moist_finger_is_told():
    # Friction without vibration when occlusion is complete: nominal_n times occlusion_ratio.
    top_n = WEAK.friction.nominal_n * WEAK.friction.occlusion_ratio
    said = also.range_said(WEAK.evolve({"sensor.range_n": 0.9 * top_n}), Requirements())
    assert f"{top_n:.3g} N without vibration" in said and f"{0.9 * top_n:.3g} N" in said
    assert also.range_said(WEAK.evolve({"sensor.range_n": 1.1 * top_n}), Requirements()) == ""
    heavy = also.range_said(WEAK.evolve({"sensor.range_n": 1.1 * top_n}), Requirements(loads_n=(0.4, 1.0)))
    assert heavy.startswith("a fully moist finger pressed with 1 N has ")


def test_what_is_as_the_bench_has_it_is_called_assumed_unless_it_is_stated():
    cutoff = f"sensor.cutoff_hz = {fl.bench().sensor.cutoff_hz:g} Hz"
    assert cutoff in also.assumed(fl.bench(), ())
    assert "sensor.cutoff_hz" not in also.assumed(fl.bench().evolve({"sensor.cutoff_hz": 777.0}), ())
    stated = also.assumed(fl.bench(), {"sensor.cutoff_hz"})
    assert cutoff not in stated and "sensor.q" in stated


def test_a_file_beside_its_preset_and_flags_state_values(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text('preset = "bench"\n[controller]\ndelay_s = 200e-6\n[controller.model]\nplate_hz = 40.0\n')
    named = {"controller.delay_s", "controller.model.plate_hz", "sensor.q"}
    assert flags.stated(path, ["sensor.q=20"]) == named
    fl.write_toml(fl.bench(), path)
    assert flags.stated(path, None) == set()


def test_noise_is_that_of_the_analysis():
    loop = fl.linearise(WEAK)
    row = also.noise(loop)
    assert row[1] == f"{1e3 * fl.output_noise_rms_n(loop):.3g} mN"


def test_other_places_are_grouped_by_contact():
    held = Corner(0.0, 1.7, fl.linearise(WEAK), 1.2)
    at = [(0.0, 100.0), (0.0, 30.0), (11.5, 240.0)]
    there = tuple(Place(length_um, (speed,), (held,)) for length_um, speed in at)
    (line,) = also_said(Designed({}, elsewhere=Elsewhere(there)))
    assert line.endswith("slip length 0 um at 30, 100 mm/s; slip length 11.5 um at 240 mm/s.")
    assert also_said(Designed({})) == []


def test_a_fully_moist_finger_out_of_reach_is_said_so_in_place_of_margins():
    law = {"controller.kind": "notch_pi", "controller.feedforward": True, "controller.overdrive": True}
    moist = fl.bench().evolve(law | {"friction.nominal_n": 1.1, "plate.max_amplitude_um": 1.6})
    said = also.fully_moist(moist.evolve({"controller.model.max_amplitude_um": 1.6}), Requirements())
    assert "are out of reach" in said and "no loop is closed" in said


@pytest.mark.parametrize(("density", "said"), [(1e-6, False), (1e-2, True)])
def test_a_command_that_is_louder_than_a_synthesis_may_make_it_is_told(density, said):
    system = fl.bench().evolve(fl.RETUNED | {"controller.kp": 0.1, "sensor.noise_density_n_rthz": density})
    assert ("more than the 30 mN" in also.noise(fl.linearise(system))[2]) == said


def test_an_unstable_finger_that_just_landed_is_named_with_its_contact():
    system = fl.bench().evolve({"controller.kp": 0.165, "controller.ki": 194.0, "sensor.resonance_hz": 190.0})
    dry = {length_um: system.evolve({"finger.slip_length_um": length_um}) for length_um in (11.5, 0.0)}
    rings = [name for name, each in dry.items() if math.isinf(max(map(peak, fl.operating_band(each, occluded=(0.0,)))))]
    assert rings == [0.0]
    assert also.fully_moist(system, Requirements()).endswith("as on a finger just landed, slip length 0 um")


def peak(loop):
    return loop.sensitivity_peak()


def test_a_flag_that_a_design_sets_otherwise_is_told():
    before = fl.bench().evolve({"controller.kind": "notch_pi", "controller.overdrive": False})
    after = before.evolve({"controller.overdrive": True})
    assert also.replaced(["controller.overdrive"], before, after).endswith("otherwise: controller.overdrive = True")
    assert also.replaced(["controller.overdrive", "controller.kind", "sensor.q"], before, before) == ""


def test_a_finger_that_does_not_get_moist_is_told():
    dry = fl.bench().evolve({"friction.occlusion_ratio": 1.0, "friction.moist_loss": 0.0})
    assert "does not get moist" in also.never_moist(dry)[0]
    assert also.never_moist(fl.bench()) == also.never_moist(fl.feasible()) == []


def test_a_range_of_speeds_tells_how_long_the_slowest_stroke_of_one_length_lasts():
    lifts = fl.bench().evolve({"motion.contact_s": 1.0, "motion.speed_mm_s": 50.0})
    ((_, said),) = also.moist_row(lifts, Requirements(speeds_mm_s=(30.0, 80.0)), "", False)
    assert "if each is a stroke of 50 mm, the slowest lasts 1.67 s" in said
    assert said.endswith("`--motion.contact_s 1.667` looks at it")
    ((_, alone),) = also.moist_row(lifts, Requirements(), "", False)
    ((_, faster),) = also.moist_row(lifts, Requirements(speeds_mm_s=(50.0, 80.0)), "", False)
    assert alone == faster and "slowest" not in alone


def test_strokes_that_are_contacts_last_longer_where_they_are_slower():
    lifts = fl.bench().evolve({"motion.contact_s": 2.0, "motion.lifted_s": 1.0, "motion.speed_mm_s": 30.0})
    strokes = lifts.evolve(lifts.motion.in_contacts())
    assert one_stroke_a_contact(strokes.motion) and not one_stroke_a_contact(lifts.motion)
    longest = with_longest_contact(strokes, (15.0, 45.0))
    assert longest.motion.contact_s == 4.0 and one_stroke_a_contact(longest.motion)
    assert longest.motion.contact_s * 15.0 == strokes.motion.contact_s * strokes.motion.speed_mm_s
    for other in (lifts, fl.bench(), fl.feasible()):
        assert with_longest_contact(other, (15.0, 45.0)) is other
    assert with_longest_contact(strokes, (30.0, 45.0)) is with_longest_contact(strokes, ()) is strokes
    ((_, said),) = also.moist_row(longest, Requirements(speeds_mm_s=(15.0, 45.0)), "", False)
    assert said.startswith("contacts of 4 s, as long as a stroke at 15 mm/s, 1 s apart") and "looks at it" not in said
