"""The words of the firmware's table that a System decides: they stand for its values and keep their ranges."""

from __future__ import annotations

import math

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.firmware.parameter_words import firmware_words
from frictionloop.quantities.protocol_schema import parameter_words
from frictionloop.sensing.finger_tracking import touch_coefficients

SYSTEMS = {"paper": fl.paper(), "feasible": fl.feasible(), "bench": fl.bench()}


def values(system: fl.System) -> dict[str, np.ndarray]:
    """Return the numbers of the table by name."""
    table = firmware_words(system)
    return {word.name: table[word.first : word.first + word.count] for word in parameter_words().values()}


@pytest.mark.parametrize("name", SYSTEMS)
def test_every_word_is_within_its_range(name: str):
    read = values(SYSTEMS[name])
    for word in parameter_words().values():
        assert np.all((read[word.name] >= word.low) & (read[word.name] <= word.high)), word.name
        assert word.format != "count" or np.all(read[word.name] == np.rint(read[word.name]))


def test_touch_of_the_bench():
    read, wanted = values(fl.bench()), touch_coefficients(fl.bench().touch, 2e-4)
    for name in ("position_gain", "touch_n", "touch_share", "mean_gain", "least_speed_m_s", "developed_m"):
        assert read[f"touch.{name}"][0] == getattr(wanted, name)
    assert read["touch.speed_gain"][0] == wanted.speed_gain


def test_a_finger_that_always_slides_is_always_valid():
    read = values(fl.paper())
    assert [read[f"touch.{name}"][0] for name in ("touch_n", "touch_share", "least_speed_m_s", "developed_m")] == [
        0
    ] * 4


@pytest.mark.parametrize("name", SYSTEMS)
def test_the_drive(name: str):
    read = values(SYSTEMS[name])
    assert read["drive.largest_um"] == read["drive.ceiling_um"] == 2.5
    assert 2.5 / read["drive.ramp_um"][0] / 5000 == pytest.approx(0.01)


def test_the_force_converter_is_the_one_of_the_sensor():
    assert values(fl.bench())["force.n_per_count"] == pytest.approx([5 / 2**16, 0])
    wide = fl.bench().evolve({"sensor.range_n": 4.0, "sensor.adc_bits": 12})
    assert values(wide)["force.n_per_count"] == pytest.approx([8 / 2**16, 0])
    assert values(wide)["safety.force_limit_n"][0] == pytest.approx(0.96 * 4)


def test_the_held_set_point_is_the_level():
    assert values(fl.bench())["setpoint.hold_n"][0] == pytest.approx(0.6)
    steps = fl.bench().model_dump() | {"setpoint": {"kind": "steps", "times_s": (0.0, 1.0), "levels_n": (0.5, 0.7)}}
    assert values(fl.System.model_validate(steps))["setpoint.hold_n"][0] == pytest.approx(0.5)


def test_a_sensor_quieter_than_its_converter_may_tell_the_same_for_long():
    assert values(fl.bench())["safety.stuck_ticks"][0] == 72  # ln 1e-15 over ln erf(1/(1.146 sqrt 2))
    assert values(fl.paper())["safety.stuck_ticks"][0] == 500_000


def test_what_a_sensor_cannot_tell_follows_from_bench_and_finger():
    told = {name: float(value[0]) for name, value in values(fl.bench()).items() if name.startswith("safety.")}
    assert told["safety.force_jump_n"] == pytest.approx(2 * math.sin(math.pi * 145 / 5000) * 2.5)
    assert told["safety.position_jump_m"] == pytest.approx(0.5 / 5000 + 8 * math.sqrt(2) * 10e-6, rel=1e-4)
    assert told["safety.load_jump_n"] == pytest.approx(1.0 + 8 * math.sqrt(2) * 2e-3)
    assert told["safety.contrary_n"] == pytest.approx(5 * 0.02)
    assert told["safety.turn_m"] == pytest.approx(2.4 / 250, rel=1e-6)
    assert told["safety.hum_n"] == pytest.approx(0.3)
    assert told["safety.hum_ticks"] == round(5000 / 145)
    assert values(fl.bench().evolve({"sensor.resonance_hz": 300.0}))["safety.hum_ticks"][0] == 50  # 3 periods
    assert values(fl.bench().evolve({"sensor.resonance_hz": 90.0}))["safety.hum_ticks"][0] == 45  # none fits
    assert values(fl.paper())["safety.hum_ticks"][0] == 45
