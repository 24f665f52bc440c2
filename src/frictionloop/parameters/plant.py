"""Parameters of what the device and the finger are: friction law, plate, force sensor, skin."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from frictionloop.parameters.block import Block, Kinded, Kinds, NotNegative, Number, Positive, Whole


def _halved(ticks: int) -> int:
    if 0 < ticks < 4:
        raise ValueError("must be 0 or at least 4")
    return ticks


PulseTicks = Annotated[Whole, Field(ge=0, le=65536), AfterValidator(_halved)]


class FrictionLimit(Kinded):
    """What every friction law has, also one from outside: the friction force without vibration."""

    nominal_n: Positive = 0.8
    """Nominal friction force f0 at rest of the plate (paper, Sec. 2.1)."""


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
    """Clock ticks of a carrier period: pulses are whole ticks wide; 2870 on a Teensy 4.1 at 46 kHz, 0 is any width."""


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
    """Clock ticks of a carrier period: pulses are whole ticks wide; 2870 on a Teensy 4.1 at 46 kHz, 0 is any width."""

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


class FingerFriction(FrictionLaw):
    """Friction limit of a finger: f0 (N/N0)^n (v/v0)^p M(t) (1 + n(x)) exp(-tau(t) a^2), physics/friction_limit.

    ``nominal_n`` is the limit at the reference load and speed, just landed, on average over the plate.
    """

    kind: Literal["finger"] = "finger"
    reference_load_n: Positive = 0.5
    """Load N0 at which the limit is ``nominal_n`` (0.49 to 0.64 N in active touch: Smith 2002)."""
    load_exponent: Annotated[Number, Field(ge=0, le=2)] = 0.9
    """Exponent n of the load (2/3 to 1 on smooth glass: Dzidek 2014; 0.79 from Seo 2009; 0.9 is assumed)."""
    speed_slope: Annotated[Number, Field(ge=-1, le=1)] = 0.0
    """Slope p = dlnF/dlnv (-0.15 to 0.15 from person to person, assumed; both signs are published)."""
    reference_speed_mm_s: Positive = 20.0
    """Speed v0 at which the limit is ``nominal_n`` (paper, Sec. 4.2)."""
    slow_mm_s: Positive = 1.0
    """Speed below which the limit no longer depends on it (assumed)."""
    static_ratio: Annotated[Number, Field(ge=1, le=5)] = 1.0
    """Limit after a second at rest over that of sliding; 1 is none (1.44 on one finger: finger-validation).

    A contact ages: dA/dt = 1 - |v| A/D, its limit rises as ln(1 + A/t1) (Baumberger and Caroli 2006).
    """
    static_s: Positive = 0.1
    """Rest t1 after which ageing is felt (assumed)."""
    static_um: Positive = 100.0
    """Way D over which sliding makes a contact young again (assumed: one finger's friction fell within 270 um)."""
    occlusion_ratio: Annotated[Number, Field(gt=0, le=20)] = 2.0
    """Limit after long contact over that just after landing; 1 is none (1 to 10: Adams 2013; 2 is assumed)."""
    occlusion_s: Positive = 20.0
    """Time constant of the rise: 20 s is published as one (Pasumarty 2011, Dzidek 2014).

    "Within 20 s" (PMC5642691), read as 95 %, would be 7 s.
    """
    drying_s: Positive = 20.0
    """Time constant of the recovery while lifted (assumed: as in contact)."""
    moist_loss: Annotated[Number, Field(ge=0, lt=1)] = 0.3
    """Share of tau lost when occlusion is complete (direction: Gueorguiev 2017; 0.3 is assumed)."""
    roughness_rms: Annotated[Number, Field(ge=0, le=0.3)] = 0.05
    """Standard deviation of n(x) over the plate (0.02 to 0.10, assumed; within 0.10 in Derler & Rotaru)."""
    roughness_longest_mm: Positive = 100.0
    """Longest wavelength of n(x), after which it repeats; the shortest is 1/1024 of it (assumed)."""


class RigidFinger(Block):
    """No skin: the friction force equals its limit at once (paper, Sec. 2)."""

    kind: Literal["rigid"] = "rigid"


class Skin(Block):
    """Fingertip in the sliding direction: mass, spring and damper in series with the contact (physics/contact)."""

    kind: Literal["skin"] = "skin"
    stiffness_n_m: Positive = 1000.0
    """Stiffness k (robomechjournal 10.1186/s40648-017-0080-8, Table 1; 500 to 2000 in other studies)."""
    damping_n_s_m: NotNegative = 1.0
    """Damping c (same table)."""
    mass_kg: Positive = 1e-4
    """Moving mass m (same table)."""
    slip_length_um: Annotated[Number, Field(ge=0, le=1000)] = 11.5
    """How far it slides while friction follows its limit, z; 0: at once (13.8 Hz per mm/s: arXiv 2505.11162)."""


Finger = Annotated[RigidFinger | Skin, Kinds(Block, RigidFinger, Skin, default="rigid")]
FRICTIONS = Kinds(
    FrictionLimit,
    Friction,
    FingerFriction,
    default="gaussian",
    beside={"rough_contact": "frictionloop.physics.rough_contact:RoughContactFriction"},
)
AnyFriction = Annotated[FrictionLimit, FRICTIONS]
