"""The System and its blocks: frozen, validated, TOML in and out."""

from frictionloop.parameters.controller import (
    Controller,
    FilteredPiController,
    LookupController,
    Model,
    NotchPiController,
    PiController,
    Timing,
)
from frictionloop.parameters.input_signals import (
    ColouredNoise,
    Constant,
    LogSweep,
    Recording,
    Samples,
    Signal,
    Sine,
    Source,
    Steps,
)
from frictionloop.parameters.motion import LoadCells, PositionSensor, Sliding, Strokes, Touch
from frictionloop.parameters.plant import (
    FingerFriction,
    Friction,
    FrictionLaw,
    FrictionLimit,
    LowpassPlate,
    LowpassSensor,
    ResonantPlate,
    RigidFinger,
    Sensor,
    Skin,
    SuspendedSensor,
)
from frictionloop.parameters.presets import READINGS, RETUNED, bench, feasible, paper
from frictionloop.parameters.system import Board, System, check_system
from frictionloop.parameters.toml_reader import PRESETS, SCHEMA, preset, read_toml
from frictionloop.parameters.toml_writer import write_toml
