"""The System and its blocks: frozen, validated, TOML in and out."""

from frictionloop.parameters.controller import Controller, Model, PiController
from frictionloop.parameters.files import PRESETS, SCHEMA, preset, read_toml, to_toml, write_toml
from frictionloop.parameters.finger import AnyFriction, Finger, FingerFriction, RigidFinger, Skin
from frictionloop.parameters.motion import Motion, Sliding, Strokes
from frictionloop.parameters.plant import (
    Friction,
    FrictionLaw,
    LowpassPlate,
    LowpassSensor,
    Plate,
    ResonantPlate,
    Sensor,
    SuspendedSensor,
)
from frictionloop.parameters.presets import READINGS, RETUNED, bench, feasible, paper
from frictionloop.parameters.sources import ColouredNoise, Constant, LogSweep, Recording, Sine, Source, Steps
from frictionloop.parameters.system import System, check_system
from frictionloop.parameters.touch import LoadCells, PositionSensor, Touch

__all__ = [
    "PRESETS",
    "READINGS",
    "RETUNED",
    "SCHEMA",
    "AnyFriction",
    "ColouredNoise",
    "Constant",
    "Controller",
    "Finger",
    "FingerFriction",
    "Friction",
    "FrictionLaw",
    "LoadCells",
    "LogSweep",
    "LowpassPlate",
    "LowpassSensor",
    "Model",
    "Motion",
    "PiController",
    "Plate",
    "PositionSensor",
    "Recording",
    "ResonantPlate",
    "RigidFinger",
    "Sensor",
    "Sine",
    "Skin",
    "Sliding",
    "Source",
    "Steps",
    "Strokes",
    "SuspendedSensor",
    "System",
    "Touch",
    "bench",
    "check_system",
    "feasible",
    "paper",
    "preset",
    "read_toml",
    "to_toml",
    "write_toml",
]
