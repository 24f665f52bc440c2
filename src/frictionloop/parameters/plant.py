"""Parameters of what the device and the finger are: friction law, plate, force sensor."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import AfterValidator, Field

from frictionloop.parameters.block import Block, NotNegative, Positive, Whole
from frictionloop.parameters.kinds import Kinds


def _halved(ticks: int) -> int:
    if 0 < ticks < 4:
        raise ValueError("must be 0 or at least 4")
    return ticks


PulseTicks = Annotated[Whole, Field(ge=0, le=65536), AfterValidator(_halved)]


class FrictionLimit(Block):
    """What every friction law has, also one from outside: the friction force without vibration."""

    nominal_n: Positive = 0.8
    """Nominal friction force f0 at rest of the plate (paper, Sec. 2.1)."""
    if TYPE_CHECKING:

        @property
        def kind(self) -> str:
            """Name of the law."""


class FrictionLaw(FrictionLimit):
    """Friction under ultrasonic vibration, f = f0 exp(-tau a^2) + d (paper, eq. 1)."""

    susceptibility_per_um2: Positive = 0.38
    """Susceptibility tau to ultrasonic levitation (paper, Sec. 2.1)."""


class Friction(FrictionLaw):
    """The law of equation (1) with constant f0 and tau (paper, Sec. 2)."""

    kind: Literal["gaussian"] = "gaussian"


class LowpassPlate(Block):
    """Envelope of the vibrating plate: a first-order low-pass on amplitude (paper, Sec. 2.2)."""

    kind: Literal["lowpass"] = "lowpass"
    cutoff_hz: Positive = 100.0
    """Cutoff of the envelope (paper, Sec. 2.2, after ref. [10])."""
    max_amplitude_um: Positive = 2.5
    """Largest amplitude the drive reaches, zero-to-peak (paper, Sec. 2.2; zero-to-peak is assumed)."""
    pulse_ticks: PulseTicks = 0
    """Clock ticks of a carrier period: pulses are whole ticks wide; 783 on a Teensy 3.1 at 46 kHz, 0 is any width."""


class ResonantPlate(Block):
    """A plate driven at its resonance: the envelope follows its command with a first-order lag (docs/plate)."""

    kind: Literal["resonant"] = "resonant"
    frequency_hz: Positive = 46e3
    """Frequency of the mode (paper, Sec. 4.1)."""
    q: Positive = 230.0
    """Quality factor (230 gives the 100 Hz of the paper, Sec. 2.2)."""
    max_amplitude_um: Positive = 2.5
    """Largest amplitude the drive reaches, zero-to-peak (paper, Sec. 4.1; zero-to-peak is assumed)."""
    pulse_ticks: PulseTicks = 0
    """Clock ticks of a carrier period: pulses are whole ticks wide; 783 on a Teensy 3.1 at 46 kHz, 0 is any width."""

    @property
    def cutoff_hz(self) -> float:
        """Cutoff of the envelope, f/(2 Q)."""
        return self.frequency_hz / (2.0 * self.q)


class LowpassSensor(Block):
    """Force sensor S(s): noise is added to the force, then a first-order low-pass (paper, Sec. 2.2)."""

    kind: Literal["lowpass"] = "lowpass"
    cutoff_hz: Positive = 1000.0
    """Cutoff of the sensor (paper, Sec. 2.2)."""
    noise_rms_n: NotNegative = 1e-5
    """Standard deviation of the white noise, one draw per control period (paper, Sec. 2.3; "rms" is a reading)."""


class SuspendedSensor(Block):
    """Force sensor as it is built: plate on leaf springs, electronics with one pole, converter (docs/force-sensor)."""

    kind: Literal["suspended"] = "suspended"
    moving_mass_kg: Positive = 0.4
    """Mass on the springs (paper, Sec. 3.1)."""
    resonance_hz: Positive = 145.0
    """First resonance (paper, Sec. 3.3)."""
    q: Positive = 20.0
    """Quality factor of the resonance (assumed)."""
    cutoff_hz: Positive = 1000.0
    """Low-pass of the demodulator (paper, Sec. 3.2; Sec. 3.3 has 300 Hz)."""
    noise_density_n_rthz: NotNegative = 2.3e-6
    """White noise before the low-pass (5e-5 N rms below 300 Hz: paper, Sec. 3.3; "rms" is a reading)."""
    adc_bits: Annotated[Whole, Field(ge=1, le=32)] = 16
    """Bits of the converter (assumed)."""
    range_n: Positive = 2.5
    """The converter spans +-range_n (paper, Fig. 4a)."""

    @property
    def stiffness_n_m(self) -> float:
        """Stiffness of the springs, (2 pi f)^2 m."""
        return (2.0 * math.pi * self.resonance_hz) ** 2 * self.moving_mass_kg

    @property
    def noise_rms_n(self) -> float:
        """Noise of the measured force, density sqrt(pi/2 cutoff), without the converter's."""
        return self.noise_density_n_rthz * math.sqrt(math.pi / 2.0 * self.cutoff_hz)

    @property
    def step_n(self) -> float:
        """Step of the converter."""
        return 2.0 * self.range_n / 2.0**self.adc_bits


Plate = Annotated[LowpassPlate | ResonantPlate, Kinds(Block, LowpassPlate, ResonantPlate, default="lowpass")]
Sensor = Annotated[LowpassSensor | SuspendedSensor, Kinds(Block, LowpassSensor, SuspendedSensor, default="lowpass")]
