"""Gains that hold over one operating grid: slip length, speed, load, moisture, resonance, people.

controller  check             find a controller, look at one that is there
plate  sensor                 size the parts: from dimensions to figures, or back (PlateDesign, SensorDesign)
Requirements                  what must hold
retune  retune_notch  design_hinf   the syntheses by themselves, on loops of your own
"""

from __future__ import annotations

from frictionloop.quantities.optional_libraries import lazily

HOMES = {
    "controller_design": "ControllerDesign controller",
    "controller_check": "Check check",
    "limiting_parts": "BenchLimits LimitedPart limits",
    "requirements": "Requirements",
    "bench_file": "DesignedTable changed_since read_designed write_controller",
    "people_served": "metrics_for",
    "population_margins": "check_fingers",
    "hinf": "Synthesised design_hinf",
    "robust_notch": "Notched retune_notch",
    "pi_synthesis": "Retuned retune",
    "run_diagnosis": "Diagnosis diagnose",
    ".hardware.plate.plate_answers": "PlateAnswers plate",
    ".hardware.sensor.sensor_answers": "SensorAnswers sensor",
    ".hardware.sensor.netlist": "to_spice write_spice",
    ".parameters.plate_design": "PlateDesign",
    ".parameters.sensor_design": "SensorDesign",
}
__getattr__, __all__, __dir__ = lazily(__name__, HOMES)
