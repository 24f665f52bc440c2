"""A law inside the package is one file and one line: its kind, and where its parameters and its step stand."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
import xarray as xr

import frictionloop as fl
from frictionloop.control.laws import LAWS
from frictionloop.parameters.controller import CONTROLLERS

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
