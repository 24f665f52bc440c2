"""Parameters of what the device and the finger are: friction law, plate, force sensor."""

from __future__ import annotations

from typing import Literal

from frictionloop.parameters.block import Block, NotNegative, Positive


class Friction(Block):
    """Friction under ultrasonic vibration, f = f0 exp(-tau a^2) + d (paper, eq. 1)."""

    nominal_n: Positive = 0.8
    """Nominal friction force f0 at rest of the plate (paper, Sec. 2.1)."""
    susceptibility_per_um2: Positive = 0.38
    """Susceptibility tau to ultrasonic levitation (paper, Sec. 2.1)."""


class LowpassPlate(Block):
    """Envelope of the vibrating plate: a first-order low-pass on amplitude (paper, Sec. 2.2)."""

    kind: Literal["lowpass"] = "lowpass"
    cutoff_hz: Positive = 100.0
    """Cutoff of the envelope (paper, Sec. 2.2, after ref. [10])."""
    max_amplitude_um: Positive = 2.5
    """Largest amplitude the drive reaches, zero-to-peak (paper, Sec. 2.2; zero-to-peak is assumed)."""


class LowpassSensor(Block):
    """Force sensor S(s): noise is added to the force, then a first-order low-pass (paper, Sec. 2.2)."""

    kind: Literal["lowpass"] = "lowpass"
    cutoff_hz: Positive = 1000.0
    """Cutoff of the sensor (paper, Sec. 2.2)."""
    noise_rms_n: NotNegative = 1e-5
    """Standard deviation of the white noise, one draw per control period (paper, Sec. 2.3; "rms" is a reading)."""


Plate = LowpassPlate
Sensor = LowpassSensor
