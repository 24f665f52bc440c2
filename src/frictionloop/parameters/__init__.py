"""The System and its blocks: frozen, validated, TOML in and out."""

from frictionloop.parameters.board import Board
from frictionloop.parameters.controller import (
    Controller,
    LookupController,
    PiController,
)
from frictionloop.parameters.files import PRESETS, SCHEMA, preset, read_toml
from frictionloop.parameters.filtered import FilteredPiController, NotchPiController
from frictionloop.parameters.finger import FingerFriction, RigidFinger, Skin
from frictionloop.parameters.motion import LoadCells, PositionSensor, Sliding, Strokes, Touch
from frictionloop.parameters.plant import (
    Friction,
    FrictionLaw,
    FrictionLimit,
    LowpassPlate,
    LowpassSensor,
    ResonantPlate,
    Sensor,
    SuspendedSensor,
)
from frictionloop.parameters.presets import READINGS, RETUNED, bench, feasible, paper
from frictionloop.parameters.sources import (
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
from frictionloop.parameters.system import System, check_system
from frictionloop.parameters.timing import Model, Timing
from frictionloop.parameters.written import write_toml
