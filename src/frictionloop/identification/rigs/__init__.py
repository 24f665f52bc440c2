"""Calibration rigs, simulated: each returns what a recorder at the real one would have written (docs/calibration)."""

from frictionloop.identification.rigs.plate_rigs import jumps_rig, plate_sweep_rig, plate_switch_rig
from frictionloop.identification.rigs.sensor_rig import floor_rig, half_sine_response, hammer_rig
from frictionloop.identification.rigs.weights import (
    UP_AND_DOWN_KG,
    bearing_friction_for,
    friction_exponent,
    pulled,
    string_friction_for,
    weights_rig,
)
