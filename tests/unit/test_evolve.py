"""``System.evolve``: dotted paths in, a new System or one clear line out."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from kinds import kinds_of
from pydantic import BaseModel

import frictionloop as fl
from frictionloop.loop.kernel.lane_grouping import placed
from frictionloop.loop.kernel.slab_columns import column
from frictionloop.parameters.controller import Timing
from frictionloop.parameters.frozen_blocks import _change_kind, _values
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


@given(mu=st.floats(0.1, 2.0), load_n=st.floats(0.1, 1.2))
def test_a_coefficient_is_friction_over_the_reference_load_at_every_door(tmp_path_factory, mu, load_n):
    """f0 = mu N0, which the finger then has and the controller believes: by path, by block, from a file."""
    base = fl.bench().evolve({"friction.reference_load_n": load_n})
    found = base.evolve({"friction.coefficient": mu})
    assert found.friction.nominal_n == found.controller.model.nominal_n == mu * load_n
    assert fl.coefficient_of({f"friction.{k}": v for k, v in found.friction} | {"motion.load_n": load_n}) == (
        pytest.approx(mu)
    )
    assert found == base.evolve({"friction": {"coefficient": mu}})
    both = {"friction.coefficient": mu, "friction.reference_load_n": load_n, "controller.model.nominal_n": 0.3}
    assert fl.bench().evolve(both) == found.evolve({"controller.model.nominal_n": 0.3})
    path = tmp_path_factory.getbasetemp() / "mu.toml"
    path.write_text(f'preset = "bench"\n[friction]\ncoefficient = {mu}\nreference_load_n = {load_n}\n')
    assert fl.read_toml(path) == found
    whole = fl.to_toml(base).replace("\nnominal_n = 0.95", f"\ncoefficient = {mu}", 1)
    path.write_text(whole)  # which says what the controller believes, too
    assert fl.read_toml(path) == found.evolve({"controller.model.nominal_n": 0.95})


def test_a_swept_coefficient_is_the_friction_it_stands_for():
    over, own = ("friction.coefficient", [1.6, 2.4]), [0.8, 1.2]
    found = fl.sweep(fl.bench(), dict([over]), 0.5, metrics=["rms_error"])["rms_error"].values.ravel()
    told = [{"friction.nominal_n": f0, "controller.model.nominal_n": f0} for f0 in own]
    assert found.tolist() == fl.sweep(fl.bench(), told, 0.5, metrics=["rms_error"])["rms_error"].values.ravel().tolist()
    assert found[0] != found[1]


@pytest.mark.parametrize(
    "overrides",
    [
        {"friction.coefficient": 0.5, "friction.nominal_n": 0.4},
        {"friction": {"coefficient": 0.5, "nominal_n": 0.4}},
        {"friction.coefficient": 0.0},
        {"friction.coefficient": [0, 6]},
    ],
)
def test_a_coefficient_beside_a_friction_or_that_is_none_is_refused(overrides):
    with pytest.raises(fl.FrictionloopError, match=r"friction\.coefficient"):
        fl.bench().evolve(overrides)


CASES = {
    "two gains": [{"controller.kp": float(k), "controller.ki": 2.0} for k in (1, 2, 3)],
    "several blocks": [{"plate.max_amplitude_um": 2.0, "controller.model.nominal_n": n} for n in (0.8, 0.9)],
    "another kind": [{"controller.kind": "lookup"}, {"controller.kind": "pi", "controller.kp": 3.0}],
    "different paths": [{"controller.kp": 1.0}, {"friction.nominal_n": 1.1}, {}],
}


@pytest.mark.parametrize("system", [fl.paper(), fl.bench()], ids=["paper", "bench"])
@pytest.mark.parametrize("overrides", CASES.values(), ids=CASES)
def test_placed_systems_are_those_that_evolve_makes(system, overrides):
    found = placed(system, overrides)
    for made, override in zip(found, overrides, strict=True):
        wanted = system.evolve(override)
        assert made == wanted
        assert made.model_dump() == wanted.model_dump()
    assert system == type(system).model_validate(system.model_dump())  # nothing was written into the one they share


def test_blocks_that_no_path_enters_stay_one_object():
    system = fl.paper()
    one, other = placed(system, [{"controller.kp": 1.0}, {"controller.kp": 2.0}])
    assert one.plate is other.plate is system.plate
    assert one.controller is not other.controller
    assert one.controller.model is system.controller.model


def test_a_column_is_asked_once_of_a_shared_object():
    shared, asked = object(), []
    assert column([shared] * 4, lambda each: asked.append(each) or 3.0).shape == (1,)
    assert len(asked) == 1
    np.testing.assert_array_equal(column([1.0, 2.0], lambda x: (x, -x)), [[1.0, 2.0], [-1.0, -2.0]])


@pytest.mark.parametrize("system", [fl.paper(), fl.bench()], ids=["paper", "bench"])
def test_a_block_is_read_as_pydantic_dumps_it(system):
    for name in type(system).model_fields:
        block = getattr(system, name)
        if isinstance(block, BaseModel):
            assert _values(block) == block.model_dump()
