"""The System and its blocks: frozen, validated, TOML in and out."""

from frictionloop.parameters.controller import Controller, Model, PiController
from frictionloop.parameters.files import PRESETS, SCHEMA, preset, read_toml, to_toml, write_toml
from frictionloop.parameters.plant import Friction, LowpassPlate, LowpassSensor, Plate, Sensor
from frictionloop.parameters.presets import READINGS, feasible, paper
from frictionloop.parameters.sources import ColouredNoise, Constant, LogSweep, Recording, Sine, Source, Steps
from frictionloop.parameters.system import System, check_system

__all__ = [
    "PRESETS",
    "READINGS",
    "SCHEMA",
    "ColouredNoise",
    "Constant",
    "Controller",
    "Friction",
    "LogSweep",
    "LowpassPlate",
    "LowpassSensor",
    "Model",
    "PiController",
    "Plate",
    "Recording",
    "Sensor",
    "Sine",
    "Source",
    "Steps",
    "System",
    "check_system",
    "feasible",
    "paper",
    "preset",
    "read_toml",
    "to_toml",
    "write_toml",
]
