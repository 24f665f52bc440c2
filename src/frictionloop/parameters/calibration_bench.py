"""What is imperfect about a calibration: weights on a string, an impact hammer, the base it all stands on.

The paper (Sec. 3.3) names the three measurements and gives none of these numbers; they are assumed unless a source is
named. [OIML] is OIML R 111-1, class M1, as tabled at en.kern-lab.com; [Koyo] is the bearing catalogue at
koyo.jtekt.co.jp, table 8-1.
"""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from frictionloop.parameters.block import Block, NotNegative, Number, Positive
from frictionloop.parameters.frozen_blocks import Description
from frictionloop.parameters.plant import SuspendedSensor

Share = Annotated[Number, Field(ge=0, lt=1)]


class SensorErrors(Block):
    """How the reading of the sensor differs from the force on its springs."""

    gain_error: Annotated[Number, Field(gt=-0.9, lt=9)] = 0.01
    """Relative error of the gain before it is calibrated (assumed)."""
    offset_n: Number = 0.005
    """Reading without a force (assumed)."""
    nonlinearity: Annotated[Number, Field(gt=-0.3, lt=0.3)] = 0.0057
    """Relative excess of the reading at ``sensor.range_n``, growing with the square of the force. Default: (x/e)^2 of
    the subtraction for 7.5 um (2.5 N on 0.4 kg at 145 Hz) in a gap of 100 um (docs/force-sensor; gap assumed)."""


class Pulley(Block):
    """A string from the frame over a pulley to a hook (paper, Sec. 3.3: "via a string and pulley system")."""

    radius_mm: Positive = 25.0
    """Radius at which the string runs (assumed)."""
    axle_radius_mm: Positive = 3.0
    """Radius to which ``bearing_friction`` refers, half the bore (assumed)."""
    wrap_deg: Annotated[Number, Field(gt=0, le=360)] = 90.0
    """Angle over which the string touches: from level to vertical."""
    bearing_friction: NotNegative = 0.0015
    """Torque over load and axle radius; 0.0010 to 0.0015 for a ball bearing, 0.01 to 0.2 for a plain one [Koyo]."""
    string_friction: NotNegative = 0.2
    """Friction of the string on the pulley, which decides once the bearing holds it still (assumed)."""
    drag_n: NotNegative = 2e-4
    """Force at the string that turns the unloaded pulley: seals, grease, stiffness of the string (assumed)."""


class Weights(Block):
    """Standard weights, put on the hook and taken off by hand."""

    tolerance: Share = 5e-5
    """Largest relative error of a weight; 5e-5 from 100 g upwards, more below [OIML]."""
    placing_s: Positive = 0.2
    """Time it takes to put one on (assumed)."""
    swing_deg: Annotated[Number, Field(ge=0, le=30)] = 2.0
    """Angle of the hook's swing after that (assumed)."""
    swing_decay_s: Positive = 5.0
    """Time constant of the swing's decay (assumed)."""
    string_m: Positive = 0.2
    """Length of the pendulum (assumed)."""
    gravity_m_s2: Positive = 9.80665
    """Gravity at the bench (the standard value; 9.78 to 9.83 on Earth)."""


class Hammer(Block):
    """An impact hammer with a force sensor in its tip, swung by hand."""

    gain_error: Annotated[Number, Field(gt=-0.9, lt=9)] = 0.01
    """Relative error of its force (assumed)."""
    noise_n: NotNegative = 1e-3
    """Standard deviation of one sample of its force (assumed)."""
    peak_spread: Share = 0.15
    """Standard deviation of the logarithm of the peaks (assumed)."""
    width_spread: Share = 0.1
    """Standard deviation of the logarithm of the pulses' durations (assumed)."""


class Base(Block):
    """What the sensor stands on."""

    vibration_ug: NotNegative = 20.0
    """Acceleration along the axis, 1e-6 g rms (assumed: 20 to 100 on a bench)."""
    corner_hz: Positive = 100.0
    """Its density is flat up to this frequency and falls as 1/f in amplitude above (assumed)."""


class CalibrationBench(Description):
    """The sensor and everything it is calibrated with."""

    sensor: SuspendedSensor = SuspendedSensor()
    """The sensor, as the loop has it."""
    errors: SensorErrors = SensorErrors()
    """What calibration is to find."""
    pulley: Pulley = Pulley()
    """Between weights and frame."""
    weights: Weights = Weights()
    """Known forces."""
    hammer: Hammer = Hammer()
    """Short forces."""
    base: Base = Base()
    """Unwanted forces."""
