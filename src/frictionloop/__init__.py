"""frictionloop: closed-loop friction displays, simulated, designed and run.

>>> import frictionloop as fl
>>> run = fl.simulate(fl.paper(), duration_s=1.0)
>>> bool(fl.r2_identity(run) <= fl.r2_bound(run))
True

A loop          paper  feasible  bench  preset  read_toml  write_toml  System (evolve)
its blocks      Sine  Recording  FingerFriction  ResonantPlate  SuspendedSensor  PiController  Skin  Strokes  ...
Run it          simulate  sweep  best  people  compare  Stepper  fingers  save  load
Judge it        diagnose  doubts  plot  metrics  r2_identity  rms_error  saturation_index  perceptual_index  METRICS
Look ahead      rings  linearise  operating_band  kp_limit  output_noise_rms_n
Find gains      design (controller  check  limits  plate  sensor)  retune  retune_notch  RETUNED
Effects, trials rendering  experiments (their own names: help(fl.rendering))
Run a device    connect  Device  device  firmware (their own names: help(fl.device))
Know a bench    identify (load  weights  pick_hits  response  modes  noise  friction  bench)
The page, paper studio (serve  export)  reproduce
Blocks of yours register  calibrate  Law  Vibration  Signal  StreamingMetric  RunMetric  step

``help(fl.simulate)`` explains a name. Distances are in um or mm, forces in N, times in s: names end with their units.
"""

from __future__ import annotations

import importlib
from typing import Any

_HOME = {
    "quantities": "FrictionloopError Lti",
    "quantities.units": "SignalWarning",
    "findings.catalogue": "explain",
    "parameters": "READINGS RETUNED System bench feasible paper preset read_toml write_toml",
    "parameters.toml_writer": "to_toml",
    "parameters.summary": "parameters_named",
    "parameters.system": "Board",
    "parameters.input_signals": "ColouredNoise Constant LogSweep Recording Samples Signal Sine Steps",
    "parameters.plant": "FingerFriction Friction FrictionLimit LowpassPlate LowpassSensor ResonantPlate RigidFinger"
    " Skin SuspendedSensor",
    "parameters.motion": "LoadCells PositionSensor Sliding Strokes Touch",
    "parameters.controller": "FilteredPiController LookupController Model NotchPiController PiController Timing",
    "control.limit_observer": "LimitObserverController",
    "control.law": "Clamp ForceCommand Law clamp_of",
    "physics.vibration": "Vibration",
    "quantities.scalar_math": "step",
    "loop.registered_blocks": "register",
    "loop.metric": "RunMetric Sample StreamingMetric",
    "physics.reach": "capable reachable",
    "physics.fingers": "coefficient_of fingers fingers_for",
    "physics.rough_contact": "RoughContactFriction",
    "physics.controller_belief": "calibrate",
    "physics.friction": "amplitude_for friction_force",
    "sensing.measurement": "Measurement",
    "analysis": "command_noise_rms_n kp_limit linearise operating_band output_noise_rms_n rings touch_spectrum",
    "design.pi_synthesis": "retune",
    "design.run_diagnosis": "diagnose",
    "design.bench_file": "described",
    "design.sweep_summary": "best",
    "design.comparison.effect_comparison": "compare_effects",
    "design.comparison.law_comparison": "compare",
    "design.comparison.comparison_run": "ComparisonInterrupted",
    "design.people_served": "PeopleInterrupted people",
    "design.robust_notch": "retune_notch",
    "loop.record": "load save system_of",
    "loop.input_findings": "doubts",
    "loop.simulate": "simulate",
    "loop.stepper": "Movement Stepper",
    "loop.sweep": "SweepInterrupted sweep",
    "loop.sweep_shards": "open_sweep sweep_status",
    "loop.sweep_quantiles": "sweep_quantiles",
    "loop.companion_runs": "metrics perceptual_index plain_like plain_stroke relative_index",
    "loop.transients": "step_times",
    "loop.band_residuals": "disturbance_left_by_band",
    "device.device": "Device connect",
    "device.errors": "DeviceError",
    "device.device_run": "Interrupted",
    "report.result_plot": "plot",
    "report.certificate": "write_certificate",
    "report.certificate_figures": "draw_refused",
    "report.reproduction": "reproduce",
    "loop.metrics": "METRICS output_noise r2_bound r2_identity r2_regression regression rms_error saturation_index"
    " scored_from",
}
_ROOM_OF = {name: f"frictionloop.{room}" for room, names in _HOME.items() for name in names.split()}
_ROOMS = {
    "figures": "frictionloop.figures",
    "outputs": "frictionloop.quantities.outputs",
    "progress": "frictionloop.loop.progress",
    "design": "frictionloop.design",
    "device": "frictionloop.device",
    "firmware": "frictionloop.firmware",
    "experiments": "frictionloop.experiments",
    "identify": "frictionloop.identification",
    "rendering": "frictionloop.rendering",
    "studio": "frictionloop.studio",
}
"""Rooms that are used by their own names, as in ``fl.identify.load``."""


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used, so that ``import frictionloop`` and ``--help`` stay quick."""
    if name == "__version__":
        return importlib.import_module("frictionloop.quantities.code_version").package_version()
    if name in _ROOMS:
        globals()[name] = importlib.import_module(_ROOMS[name])
        return globals()[name]
    if name not in _ROOM_OF:
        raise AttributeError(f"module 'frictionloop' has no attribute {name!r}")
    value = getattr(importlib.import_module(_ROOM_OF[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """Return the public names."""
    return sorted([*_ROOM_OF, *_ROOMS])
