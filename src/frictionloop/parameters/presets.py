"""Ready-made systems: the paper's simulation, a feasible version, the readings of its text; and a still finger."""

from __future__ import annotations

from operator import attrgetter

from frictionloop.parameters.controller import Model, PiController
from frictionloop.parameters.input_signals import Constant, LogSweep, Sine
from frictionloop.parameters.motion import Strokes
from frictionloop.parameters.plant import (
    FingerFriction,
    Friction,
    LowpassPlate,
    LowpassSensor,
    ResonantPlate,
    Skin,
    SuspendedSensor,
)
from frictionloop.parameters.system import System


def paper() -> System:
    """Return the simulation of Section 2, reading the printed amplitudes as peak-to-peak (docs/paper-notes)."""
    return System(
        setpoint=LogSweep(offset_n=0.6, amplitude_n=0.6, start_hz=1.0, stop_hz=100.0, sweep_s=10.0),
        disturbance=Sine(offset_n=0.4, amplitude_n=0.4, frequency_hz=1.0),
        friction=Friction(),
        plate=LowpassPlate(),
        sensor=LowpassSensor(),
        controller=PiController(),
    )


def feasible() -> System:
    """Return the same loop with a set-point that is reachable at every sample.

    The reachable band is [g(a_max) + max d, f0 + min d] = [0.374, 0.800] N; the set-point is 0.58 +- 0.18 N.
    """
    return paper().evolve(
        {
            "setpoint.offset_n": 0.58,
            "setpoint.amplitude_n": 0.18,
            "disturbance.offset_n": 0.15,
            "disturbance.amplitude_n": 0.15,
        }
    )


def bench() -> System:
    """Return the device of Sections 3 and 4 under one finger, with the printed gains, which ring on it (docs/model).

    The set-point is the middle one of Section 4.2; ``RETUNED`` are gains that hold.
    """
    finger = FingerFriction(nominal_n=BENCH_NOMINAL_N)
    return System(
        setpoint=Sine(offset_n=0.6, amplitude_n=0.1, frequency_hz=1.0),
        disturbance=Constant(offset_n=0.0),
        friction=finger,
        plate=ResonantPlate(),
        sensor=SuspendedSensor(),
        controller=PiController(delay_s=200e-6, model=Model(nominal_n=BENCH_NOMINAL_N, resonance_hz=145.0)),
        finger=Skin(),
        motion=Strokes(),
    )


BENCH_NOMINAL_N = 0.95
"""Friction f0 of the bench's finger at 0.5 N: middle of 0.5 to 1.4 N (research on fingers, assumed)."""
PAPER_SLIP_LENGTH_UM = 30.0
"""Of the finger in the report's figures: that of a bristle of 2e4 N/m at 0.6 N (assumed)."""
RETUNED: dict[str, float] = {"controller.kp": 0.0, "controller.ki": 111.0}
"""Gains that are stable on ``bench()``: integral action alone, which crosses below the resonance of the sensor.

Chosen on the linear loop for Ms = 1.5 at 0.5 N, a finger just landed, 20 mm/s (docs/will-it-ring).
"""
READINGS: dict[str, dict[str, float]] = {
    "peak-to-peak": {},
    "zero-to-peak set-point": {"setpoint.amplitude_n": 1.2},
    "disturbance of Sec. 2.1": {"disturbance.amplitude_n": 0.8, "disturbance.offset_n": 0.4},
    "small disturbance": {"disturbance.amplitude_n": 0.2, "disturbance.offset_n": 0.2},
}
"""Other readings of the printed amplitudes, as overrides of ``paper()`` (docs/paper-notes)."""


STILL = {
    "motion.tremor_um": 0.0,
    "motion.tremor_n": 0.0,
    "motion.load_drift": 0.0,
    "friction.roughness_rms": 0.0,
    "friction.occlusion_ratio": 1.0,
    "friction.moist_loss": 0.0,
}
"""Values with which a finger has no variation of its own: no tremor, drift of load, roughness, moisture."""


def stirring(system: System) -> dict[str, float]:
    """Return what would still a finger that varies by itself, by its dotted name; nothing for any other."""
    if not (isinstance(system.friction, FingerFriction) and isinstance(system.motion, Strokes)):
        return {}
    return {path: value for path, value in STILL.items() if attrgetter(path)(system) != value}
