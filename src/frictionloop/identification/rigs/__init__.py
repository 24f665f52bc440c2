"""Calibration rigs, simulated: each returns what a recorder at the real one would have written (docs/calibration)."""

from frictionloop.identification.rigs.floor import FloorTerms, floor_rig, floor_terms, vibration_allowed_ug
from frictionloop.identification.rigs.hammer import half_sine_response, hammer_rig
from frictionloop.identification.rigs.pulley import bearing_friction_for, friction_exponent, pulled, string_friction_for
from frictionloop.identification.rigs.weights import UP_AND_DOWN_KG, weights_rig

__all__ = [
    "UP_AND_DOWN_KG",
    "FloorTerms",
    "bearing_friction_for",
    "floor_rig",
    "floor_terms",
    "friction_exponent",
    "half_sine_response",
    "hammer_rig",
    "pulled",
    "string_friction_for",
    "vibration_allowed_ug",
    "weights_rig",
]
