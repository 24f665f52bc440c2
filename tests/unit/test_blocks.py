"""Every block is a frozen, documented value with units; the presets are what the paper prints."""

from __future__ import annotations

import itertools
import math
import subprocess
import sys

import numpy as np
import pytest
import xarray as xr
from kinds import kinds_of
from pydantic import BaseModel, ValidationError

import frictionloop as fl
from frictionloop.control.laws import LAWS
from frictionloop.parameters.controller import CONTROLLERS
from frictionloop.rendering.effect_setpoint import EffectSource

BLOCKS = [
    fl.System,
    fl.Model,
    fl.PositionSensor,
    fl.LoadCells,
    *(kind for block in fl.System.model_fields for kind in kinds_of(block)),
]
BLOCKS = list(dict.fromkeys(BLOCKS))
# Numbers without a unit, and words. A recording's scale is newtons per whatever unit its column has.
DIMENSIONLESS = {
    "exponent", "table_size", "scale", "kind", "path", "column", "unit", "rectify", "remove_mean", "load_exponent",
    "speed_slope", "decimal", "occlusion_ratio", "roughness_rms", "q", "adc_bits", "lost_ticks", "contact", "start",
    "load_drift", "person", "moist_loss", "static_ratio", "touch_share", "speed_share", "resonance_q",
    "overdrive", "feedforward",
    "sections", "notch_depth", "notch_width", "schedule", "compliance_learning", "resonance_share",
    "broadened_q", "susceptibility_learning", "force_axes", "pulse_ticks", "position", "hum_share",
    "spring_noise", "susceptibility_margin", "gain_spread",
}  # fmt: skip


def test_the_list_of_blocks_is_whole():
    assert len(BLOCKS) == 30
    assert {fl.Recording, fl.PiController, fl.LowpassPlate, fl.Strokes, fl.Skin} < set(BLOCKS)


def test_every_block_is_documented_and_so_is_every_field_which_has_a_unit():
    for block in BLOCKS:
        assert block.__doc__ and block.__doc__ != BaseModel.__doc__, block
        for name, field in block.model_fields.items():
            assert name == "kind" or (field.description and field.description.strip()), f"{block}: {name}"
            nested = isinstance(field.annotation, type) and issubclass(field.annotation, BaseModel)
            if not nested and block is not fl.System:
                assert bool(fl.quantities.unit_of(name)) != (name in DIMENSIONLESS), f"{block}: {name}"


def test_every_block_is_a_frozen_hashable_value():
    blocks = [
     fl.paper(), fl.Model(), fl.Constant(), fl.Sine(), fl.LogSweep(), fl.Steps(), fl.ColouredNoise(),
     fl.Recording(path="a"), fl.Friction(), fl.LowpassPlate(), fl.LowpassSensor(), fl.PiController(), fl.bench(),
     fl.FingerFriction(), fl.ResonantPlate(), fl.SuspendedSensor(), fl.RigidFinger(), fl.Skin(), fl.Sliding(),
     fl.Strokes(), fl.Touch(), fl.PositionSensor(), fl.LoadCells(), fl.Board(), fl.LookupController(),
     fl.NotchPiController(), fl.FilteredPiController(sections=((1.0, 0.0, 0.0, 0.0, 0.0),)),
     fl.LimitObserverController(), fl.Samples(values_n=(0.0, 1.0), rate_hz=1.0), fl.RoughContactFriction(),
     EffectSource(effect=fl.rendering.Constant()),
    ]  # fmt: skip
    assert {type(block) for block in blocks} == set(BLOCKS)
    for block in blocks:
        name = next(iter(type(block).model_fields))
        with pytest.raises(fl.FrictionloopError, match="frozen"):
            setattr(block, name, getattr(block, name))
        with pytest.raises(fl.FrictionloopError, match="frozen"):
            delattr(block, name)
        same = type(block).model_validate(block.model_dump())
        assert same == block and hash(same) == hash(block)


def test_unknown_names_and_infinite_numbers_are_refused():
    for block in BLOCKS:
        with pytest.raises(ValidationError):
            block.model_validate({"no_such_name": 1.0})
        numbers = [name for name, field in block.model_fields.items() if field.annotation is float]
        for name, value in itertools.product(numbers, (math.inf, math.nan)):
            with pytest.raises(ValidationError, match="finite"):
                block.model_validate({name: value})


def test_the_paper_is_as_printed():
    """Values of Section 2; readings of what is ambiguous are in docs/paper-notes."""
    system = fl.paper()
    assert (system.friction.nominal_n, system.friction.susceptibility_per_um2) == (0.8, 0.38)
    assert (system.plate.cutoff_hz, system.plate.max_amplitude_um) == (100.0, 2.5)
    assert (system.sensor.cutoff_hz, system.sensor.noise_rms_n) == (1000.0, 1e-5)
    assert (system.controller.kp, system.controller.ki, system.controller.rate_hz) == (10.0, 2.0, 5000.0)
    assert (system.setpoint.start_hz, system.setpoint.stop_hz, system.setpoint.sweep_s) == (1.0, 100.0, 10.0)
    # Peak to peak 1.2 N for the set-point and 0.8 N for the disturbance, neither ever negative.
    assert (system.setpoint.offset_n, system.setpoint.amplitude_n) == (0.6, 0.6)
    assert (system.disturbance.offset_n, system.disturbance.amplitude_n) == (0.4, 0.4)
    model = system.controller.model
    assert (model.nominal_n, model.susceptibility_per_um2) == (0.8, 0.38)
    assert (model.max_amplitude_um, model.table_size) == (2.5, 0)


def test_the_bench_is_as_printed_and_researched():
    """Sections 3 and 4 of the paper, and a study of the literature for what it does not say."""
    system = fl.bench()
    plate, sensor, motion = system.plate, system.sensor, system.motion
    assert (plate.frequency_hz, plate.q, plate.max_amplitude_um) == (46e3, 230.0, 2.5)
    assert plate.cutoff_hz == pytest.approx(100.0, rel=1e-12)  # f/(2 Q), the 100 Hz of Section 2.2
    assert (sensor.moving_mass_kg, sensor.resonance_hz, sensor.cutoff_hz) == (0.4, 145.0, 1000.0)
    assert (sensor.noise_density_n_rthz, sensor.adc_bits, sensor.range_n) == (2.3e-6, 16, 2.5)
    assert sensor.stiffness_n_m == pytest.approx(0.33e6, rel=0.01)  # 0.33 N/um
    # 5e-5 N over the noise bandwidth of a 300 Hz pole (paper, Sec. 3.3).
    assert fl.SuspendedSensor(cutoff_hz=300.0).noise_rms_n == pytest.approx(5e-5, rel=0.01)
    assert (motion.speed_mm_s, motion.load_n) == (20.0, 0.5)
    c = system.controller
    assert (c.kp, c.ki, c.rate_hz, c.delay_s) == (10.0, 2.0, 5000.0, 200e-6)


def test_a_feasible_set_point_is_reachable_at_every_sample():
    system = fl.feasible()
    run = fl.simulate(system, 10.0)
    floor = 0.8 * math.exp(-0.38 * 2.5**2)  # equation (1)
    d, r = run["d"].values, run["f_r"].values
    assert np.all(r >= floor + d)
    assert np.all(r <= 0.8 + d)
    # Not only with the disturbance of the moment but with the largest and the smallest one.
    assert floor + d.max() <= r.min() and r.max() <= 0.8 + d.min()
    band = fl.reachable(system, d)
    assert band.low_n == pytest.approx(floor + 0.3, abs=1e-9)  # the sine reaches its crest at a sample
    assert band.high_n == pytest.approx(0.8, abs=1e-9)
    assert fl.r2_bound(run) == 1.0


def test_the_paper_is_not_reachable():
    run = fl.simulate(fl.paper(), 10.0)
    band = fl.reachable(fl.paper(), run["d"].values)
    assert band.low_n > band.high_n
    assert fl.r2_bound(run) < 0.6


@pytest.mark.parametrize("name", fl.READINGS)
def test_every_reading_is_an_override_of_the_paper(name):
    assert isinstance(fl.paper().evolve(fl.READINGS[name]), fl.System)


def test_an_unknown_preset_lists_the_known():
    with pytest.raises(fl.FrictionloopError, match="accepted: 'paper', 'feasible'"):
        fl.preset("bench2")


FILE = """
from typing import Literal
from frictionloop.control.law import Law
from frictionloop.control.pi import PiGains, PiState, pi_begin, pi_step
from frictionloop.parameters import Timing

class InsidePi(Timing):
    kind: Literal["inside_pi"] = "inside_pi"
    kp: float = 0.062
    ki: float = 134.0

LAW = Law("inside_pi", pi_step, PiState, PiGains, begin=pi_begin)
"""
BEGIN = """
from frictionloop.parameters.controller import CONTROLLERS
CONTROLLERS.beside["inside_pi"] = "inside_pi:InsidePi"
"""
USE = """
import frictionloop as fl
from frictionloop.control.laws import law_of
system = fl.bench().evolve({"controller.kind": "inside_pi"})
fl.write_toml(system, "system.toml")
assert fl.read_toml("system.toml") == system
fl.save(fl.simulate(system, 0.2), "run.h5")
print(law_of(system.controller).kind, fl.linearise(system).margins().sensitivity_peak)
"""


def python(folder, script):
    return subprocess.check_output([sys.executable, "-c", script], text=True, cwd=folder, timeout=280)


@pytest.mark.slow
def test_one_file_and_one_line_run_and_are_analysed(tmp_path):
    (tmp_path / "inside_pi.py").write_text(FILE, encoding="utf-8")
    kind, peak = python(tmp_path, BEGIN + USE).split()
    own = fl.bench().evolve({"controller.kp": 0.062, "controller.ki": 134.0})
    assert kind == "inside_pi"
    assert float(peak) == pytest.approx(fl.linearise(own).margins().sensitivity_peak, rel=1e-6)
    with xr.open_dataset(tmp_path / "run.h5", engine="h5netcdf") as run:
        np.testing.assert_array_equal(run.f_a.values, fl.simulate(own, 0.2).f_a.values)


def test_its_file_is_read_when_its_kind_is_used(tmp_path):
    (tmp_path / "inside_pi.py").write_text("raise AssertionError('read')", encoding="utf-8")
    other = 'import frictionloop as fl\nprint(fl.bench().evolve({"controller.kind": "lookup"}).controller.kind)'
    assert python(tmp_path, BEGIN + other).strip() == "lookup"
    used = BEGIN + "import frictionloop as fl\nfl.bench().evolve({'controller.kind': 'inside_pi'})"
    with pytest.raises(subprocess.CalledProcessError):
        python(tmp_path, used)


@pytest.mark.parametrize("kind", CONTROLLERS.beside)
def test_each_line_names_the_parameters_and_the_law_of_its_kind(kind):
    assert CONTROLLERS[kind].model_fields["kind"].default == kind == LAWS[kind].kind
