"""``System.evolve``: dotted paths in, a new System or one clear line out."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from kinds import kinds_of

import frictionloop as fl
from frictionloop.parameters.controller import Timing
from frictionloop.parameters.description import _change_kind
from frictionloop.parameters.refusals import known_names
from frictionloop.parameters.sensor_design import SensorDesign, StraightSprings

PAPER = fl.paper()
PATHS = known_names(fl.System, PAPER.model_dump())


def complaint(overrides):
    with pytest.raises(fl.FrictionloopError) as failure:
        PAPER.evolve(overrides)
    text = str(failure.value)
    assert "\n" not in text
    return text


def test_changes_what_is_named_and_nothing_else():
    changed = PAPER.evolve({"controller.kp": 20.0, "controller.model.nominal_n": 0.9})
    assert changed.controller.kp == 20.0
    assert changed.controller.model.nominal_n == 0.9
    assert changed.evolve({"controller.kp": 10.0, "controller.model.nominal_n": 0.8}) == PAPER
    assert fl.paper() == PAPER  # the original is as it was


def test_every_path_can_be_set_to_what_it_is():
    values = {path: value(PAPER, path) for path in PATHS}
    assert len(values) >= 20
    assert PAPER.evolve(values) == PAPER


def value(system, path):
    for name in path.split("."):
        system = getattr(system, name)
    return system


def test_the_model_is_not_the_plant():
    changed = PAPER.evolve({"friction.nominal_n": 1.2})
    assert changed.controller.model.nominal_n == 0.8


def test_whole_blocks():
    sine = fl.Sine(offset_n=0.5, amplitude_n=0.1, frequency_hz=7.0)
    assert PAPER.evolve({"setpoint": sine}).setpoint == sine
    assert PAPER.evolve({"setpoint": sine.model_dump()}).setpoint == sine
    assert PAPER.evolve({"setpoint": PAPER.setpoint}) == PAPER


def test_a_mapping_without_a_kind_changes_values_inside_a_block():
    changed = PAPER.evolve({"controller": {"kp": 3.0, "model": {"table_size": 64}}})
    assert changed == PAPER.evolve({"controller.kp": 3.0, "controller.model.table_size": 64})


def test_blocks_may_be_given_by_name():
    sine = fl.Sine(offset_n=0.6, amplitude_n=0.1)
    changed = PAPER.evolve({"plate.cutoff_hz": 90.0}, controller={"kp": 3.0}, setpoint=sine)
    assert changed == PAPER.evolve({"plate.cutoff_hz": 90.0, "controller.kp": 3.0, "setpoint": sine})
    with pytest.raises(fl.FrictionloopError, match="unknown parameter 'controler'; did you mean controller"):
        PAPER.evolve(controler={"kp": 3.0})


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        (lambda: fl.Sine(amplitude=1.0), "Sine: unknown parameter 'amplitude'; did you mean amplitude_n (N)?"),
        (lambda: fl.Sine(1.0), "Sine takes its values by name: Sine(offset_n=...)"),
        (lambda: fl.PiController(kp=-1.0), "PiController: kp = -1.0 N/N: must be greater than or equal to 0"),
        (fl.Recording, "Recording: path is missing"),
        (lambda: fl.Steps(times_s=(1.0,)), "Steps: times_s = (1.0,): must be rising from 0"),
        (lambda: fl.PiController(model={"nominal": 1.0}), "PiController: unknown parameter 'model.nominal'; did you"),
    ],
)
def test_a_constructor_refuses_in_one_line(wrong, said):
    with pytest.raises(fl.FrictionloopError) as caught:
        wrong()
    assert str(caught.value).startswith(said)
    assert "\n" not in str(caught.value)


def test_a_signal_of_a_new_kind_starts_from_its_defaults():
    changed = PAPER.evolve({"setpoint.kind": "sine", "setpoint.frequency_hz": 3.0})
    assert changed.setpoint == fl.Sine(frequency_hz=3.0)
    assert PAPER.evolve({"setpoint.kind": "constant"}).setpoint == fl.Constant()


@pytest.mark.parametrize("kind", ["lookup", "filtered_pi", "notch_pi", "limit_observer"])
def test_a_law_of_a_new_kind_keeps_the_bench_and_no_gains(kind):
    told = {"controller.rate_hz": 4000.0, "controller.delay_s": 1e-4, "controller.jitter_s": 1e-6}
    told |= {"controller.model.resonance_hz": 120.0, "controller.model.nominal_n": 0.7}
    law = PAPER.evolve(told | {"controller.kp": 3.0, "controller.ki": 5.0}).evolve({"controller.kind": kind}).controller
    bench = {"rate_hz": 4000.0, "delay_s": 1e-4, "jitter_s": 1e-6}
    model = PAPER.controller.model.model_copy(update={"resonance_hz": 120.0, "nominal_n": 0.7})
    assert law == type(law)(**bench, model=model)


def test_a_finger_keeps_what_both_kinds_have():
    told = {"friction.nominal_n": 0.7, "friction.susceptibility_per_um2": 0.3}
    finger = PAPER.evolve(told | {"friction.kind": "finger", "motion.kind": "strokes"}).friction
    assert (finger.nominal_n, finger.susceptibility_per_um2) == (0.7, 0.3)
    assert PAPER.evolve({"plate.max_amplitude_um": 2.0, "plate.kind": "resonant"}).plate.max_amplitude_um == 2.0


@pytest.mark.parametrize("block", [name for name in fl.System.model_fields if len(kinds_of(name)) > 1])
def test_nothing_but_the_bench_is_taken_over_by_any_kind_from_any_other(block):
    """Values that no default is: they stay where both kinds have them and the block is not tuned, else start anew."""
    tuned = set(Timing.model_fields) if block == "controller" else set()
    untuned = block not in ("controller", "setpoint", "disturbance")
    for old, new in itertools.permutations(kinds_of(block), 2):
        fields = {name: field for name, field in old.model_fields.items() if isinstance(field.default, float)}
        values = {name: field.default + 2.0**-10 for name, field in fields.items()}
        tree = {block: old.model_construct(**values).__dict__}
        _change_kind(fl.System, tree, block, new.model_fields["kind"].default)
        for name, field in new.model_fields.items():
            if name in values and (untuned or name in tuned):
                assert tree[block][name] == values[name]
            elif name in tree[block] and name not in {"kind", "model"}:
                assert tree[block][name] == field.get_default(call_default_factory=True)


def test_what_was_chosen_for_one_kind_of_springs_is_not_taken_over():
    straight = SensorDesign().evolve({"springs.width_mm": 12.0, "springs.kind": "straight"}).springs
    assert straight == StraightSprings(width_mm=12.0)


def test_a_mapping_with_a_kind_is_a_change_of_kind():
    told = {"kind": "notch_pi", "kp": 2.0}
    law = PAPER.evolve({"controller.rate_hz": 4000.0, "controller": told}).controller
    assert law == fl.NotchPiController(kp=2.0, rate_hz=4000.0, model=PAPER.controller.model)
    assert PAPER.evolve({"controller": fl.NotchPiController(kp=2.0)}).controller == fl.NotchPiController(kp=2.0)


def test_a_new_kind_may_need_a_value_that_has_no_default():
    changed = PAPER.evolve({"disturbance.kind": "recording", "disturbance.path": "finger.csv"})
    assert changed.disturbance == fl.Recording(path="finger.csv")
    assert complaint({"disturbance.kind": "recording"}) == "disturbance.path is missing"


def test_optional_values_take_none():
    recorded = PAPER.evolve({"disturbance": fl.Recording(path="finger.csv", stop_s=2.0)})
    assert recorded.evolve({"disturbance.stop_s": None}).disturbance.stop_s is None


@pytest.mark.parametrize(
    ("path", "near"),
    [
        ("controller.kpp", "controller.kp (N/N)"),
        ("controler.kp", "controller.kp (N/N)"),
        ("kp", "controller.kp (N/N)"),
        ("nominal_n", "friction.nominal_n (N)"),
        ("controller.delay_ms", "controller.delay_s = 0.001 s"),  # a wrong unit suffix
        ("plate.cutoff_khz", "plate.cutoff_hz = 1000 Hz"),
        ("plate.max_amplitude_mm", "plate.max_amplitude_um = 1000 um"),
        ("controller.model.tabel_size", "controller.model.table_size"),
        ("setpoint.frequency_hz", "disturbance.frequency_hz (Hz)"),  # this kind has none
        ("friction.zzz", "friction.nominal_n (N)"),  # nothing near: the block's own names
    ],
)
def test_an_unknown_path_lists_near_ones(path, near):
    text = complaint({path: 1.0})
    assert text.startswith(f"unknown parameter {path!r}; did you mean ")
    assert near in text


@pytest.mark.parametrize(
    ("path", "block"), [("controler", "controller"), ("controller.modle", "controller.model"), ("plat", "plate")]
)
@pytest.mark.parametrize("given", [{}, {"kp": 3.0}, 1.0])
def test_an_unknown_block_lists_near_ones(path, block, given):
    assert complaint({path: given}).startswith(f"unknown parameter {path!r}; did you mean {block}")


@pytest.mark.parametrize(
    "path", ["", ".", "controller.", ".kp", "controller.kp.x", "kind", "controller.model.model.kp"]
)
def test_a_malformed_path_is_unknown(path):
    assert complaint({path: 1.0}).startswith(f"unknown parameter {path!r}")


@pytest.mark.parametrize(
    ("path", "bad", "accepted"),
    [
        ("friction.susceptibility_per_um2", -0.38, "um^-2: must be greater than 0"),
        ("friction.nominal_n", 0.0, "N: must be greater than 0"),
        ("controller.kp", -1.0, "N/N: must be greater than or equal to 0"),
        ("controller.kp", math.nan, "N/N: must be a finite number"),
        ("controller.ki", math.inf, "1/s: must be a finite number"),
        ("setpoint.offset_n", -math.inf, "N: must be a finite number"),
        ("controller.delay_s", -1e-6, "s: must be greater than or equal to 0"),
        ("controller.delay_s", 1.5, "s: must be less than or equal to 1"),
        ("controller.rate_hz", 0.0, "Hz: must be greater than 0"),
        ("controller.rate_hz", None, "Hz: must be a valid number"),
        ("controller.kp", "fast", "N/N: must be a valid number"),
        ("controller.kp", True, "N/N: must be a number"),
        ("setpoint.offset_n", False, "N: must be a number"),
        ("controller.model.table_size", True, ": must be a number"),
        ("controller.model.table_size", -1, ": must be greater than or equal to 0"),
        ("controller.model.table_size", 2.5, ": must be a valid integer"),
        ("sensor.noise_rms_n", -1e-5, "N: must be greater than or equal to 0"),
    ],
)
def test_a_bad_value_names_path_value_unit_and_what_is_accepted(path, bad, accepted):
    text = complaint({path: bad})
    assert text.startswith(f"{path} = {bad!r}")
    assert accepted in text


@pytest.mark.parametrize(
    ("overrides", "told"),
    [
        ({"controller.model.table_size": 1}, "table_size = 1: must be 0 or at least 2"),
        ({"setpoint.start_hz": 100.0}, "start_hz and stop_hz must differ"),
        ({"setpoint": fl.Steps().model_dump() | {"times_s": (0.0, 1.0)}}, "one level per time"),
        ({"setpoint": fl.Steps().model_dump() | {"times_s": (), "levels_n": ()}}, "one level per time"),
        ({"setpoint": {"kind": "steps", "times_s": (0.0, 2.0, 1.0), "levels_n": (1.0, 2.0, 3.0)}}, "rising from 0"),
        ({"setpoint": {"kind": "steps", "times_s": (0.5,), "levels_n": (1.0,)}}, "rising from 0"),
        ({"disturbance": {"kind": "noise", "low_hz": 500.0, "high_hz": 0.5}}, "low_hz must be below high_hz"),
        ({"disturbance": {"kind": "recording", "path": "a", "start_s": 2.0, "stop_s": 1.0}}, "stop_s must be after"),
        ({"setpoint.kind": "sin"}, "setpoint.kind = 'sin' is unknown; accepted: 'constant', 'sine', 'log_sweep'"),
        ({"setpoint": {"kind": "sin"}}, "setpoint"),
        ({"plate": 3.0}, "plate = 3.0"),
        ({"setpoint": fl.Friction()}, "setpoint"),  # a block of the wrong sort
    ],
)
def test_what_does_not_fit_together_is_said(overrides, told):
    assert told in complaint(overrides)


def test_a_clamp_must_have_two_ends():
    # g(a_max) rounds to f0, or vanishes: the lookup table would have no width, or an infinite entry.
    assert "susceptibility_per_um2" in complaint({"controller.model.susceptibility_per_um2": 1e-18})
    assert "susceptibility_per_um2" in complaint({"controller.model.susceptibility_per_um2": 1e3})
    assert "susceptibility_per_um2" in complaint({"controller.model.max_amplitude_um": 1e200})


def test_the_plate_must_leave_some_friction():
    told = "friction.susceptibility_per_um2 * plate.max_amplitude_um^2"
    assert told in complaint({"friction.susceptibility_per_um2": 1e3})
    assert told in complaint({"plate.max_amplitude_um": 1e200})
    assert PAPER.evolve({"friction.susceptibility_per_um2": 111.0})  # 694


def test_numpy_numbers_are_numbers():
    changed = PAPER.evolve({"controller.kp": np.float64(3.0), "controller.model.table_size": np.int64(8)})
    assert changed == PAPER.evolve({"controller.kp": 3.0, "controller.model.table_size": 8})


@given(st.sampled_from(PATHS), st.floats(allow_nan=True, allow_infinity=True))
def test_any_number_anywhere_is_taken_or_refused_in_one_line(path, number):
    try:
        changed = PAPER.evolve({path: number})
    except fl.FrictionloopError as refusal:
        assert path.rsplit(".", 1)[0] in str(refusal)
        assert "\n" not in str(refusal)
    else:
        assert value(changed, path) == number
        assert math.isfinite(number)


@given(st.text(max_size=30), st.none() | st.floats() | st.text(max_size=5) | st.lists(st.integers(), max_size=2))
def test_any_text_as_a_path_is_refused_in_one_line(path, anything):
    assert complaint({path: anything}).startswith("unknown parameter")
