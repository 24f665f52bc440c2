"""The capacitive force sensor as it is built: springs, plates, electronics, surroundings (paper, Sec. 3).

Only primary quantities stand here. Stiffness, resonance, travel, capacitance and noise follow from them in ``sensing``.
Printed by the paper: four curved leaf springs of aluminium 2024, 0.4 kg, four electrodes, 120 kHz, a 1 kHz low-pass,
2.5 N and the 5 kHz timer. Every other number is assumed; the defaults give the measured resonance of 145 Hz.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from frictionloop.parameters.block import Block, Kinds, Number, Whole
from frictionloop.parameters.frozen_blocks import Description

LEAST, MOST = 1e-9, 1e9
"""Bounds of every number, far outside what can be built, within which no formula overflows."""
Positive = Annotated[Number, Field(gt=0, ge=LEAST, le=MOST)]
NotNegative = Annotated[Number, Field(ge=0, le=MOST)]
Arrangement = Literal["around", "parallel"]


class _Leaves(Block):
    count: Annotated[Whole, Field(ge=2, le=16, multiple_of=2)] = 4
    """Number of leaves; four in the paper (Sec. 3)."""
    arrangement: Arrangement = "around"
    """"around": half of the leaves turned by 90 degrees, one per side of the frame; "parallel": all turned alike, soft
    along x (assumed)."""
    width_mm: Positive = 20.0
    """Width of a leaf, along the axis about which it bends (assumed)."""
    thickness_mm: Positive = 0.699
    """Thickness of a leaf (assumed; gives 145 Hz with 0.4 kg)."""
    youngs_modulus_gpa: Positive = 73.1
    """Young's modulus; 73.1 GPa is aluminium 2024 (alloy: paper, Sec. 4; value assumed, from memory of handbooks)."""
    yield_mpa: Positive = 324.0
    """Stress at which it yields; 324 MPa is aluminium 2024-T3 (temper and value assumed)."""


class ArcSprings(_Leaves):
    """Leaf springs bent to a circular arc, both ends held against rotation."""

    kind: Literal["arc"] = "arc"
    radius_mm: Positive = 10.0
    """Radius of the arc's centre line (assumed)."""
    angle_deg: Annotated[Number, Field(ge=10, le=350)] = 180.0
    """Angle of the arc: 180 is a semicircle, 90 a quarter circle (assumed)."""


class StraightSprings(_Leaves):
    """Straight leaf springs, both ends held against rotation (guided beams)."""

    kind: Literal["straight"] = "straight"
    arrangement: Arrangement = "parallel"
    """"parallel": all leaves turned alike, soft along x only; "around" is stiff in both directions (assumed)."""
    thickness_mm: Positive = 1.15
    """Thickness of a leaf (assumed; gives 145 Hz with 0.4 kg)."""
    length_mm: Positive = 30.0
    """Free length of a leaf (assumed)."""


Springs = Annotated[ArcSprings | StraightSprings, Kinds(Block, ArcSprings, StraightSprings)]


class Moving(Block):
    """What moves on the springs: plate and inner frame."""

    mass_kg: Positive = 0.4
    """Moving mass (paper, Sec. 3.1)."""
    q: Positive = 20.0
    """Quality factor of the resonance (assumed)."""


class Load(Block):
    """What the sensor has to measure."""

    range_n: Positive = 2.5
    """Largest force in either direction (paper, Sec. 3.1)."""


class Electrodes(Block):
    """One electrode per side of the frame; two opposite ones make a differential pair (paper, Fig. 3)."""

    area_mm2: Positive = 200.0
    """Active area A of one electrode (assumed). Its guard keeps the field straight, so no fringe is counted."""
    gap_um: Positive = 100.0
    """Gap e at rest (assumed)."""
    imbalance: Annotated[Number, Field(ge=0, lt=0.5)] = 0.01
    """(C+ - C-)/(C+ + C-) at rest, from machining and mounting (assumed)."""


class Excitation(Block):
    """The sinusoidal voltage on the inner frame."""

    amplitude_v: Positive = 10.0
    """Amplitude, zero-to-peak (assumed)."""
    max_amplitude_v: Positive = 10.0
    """Largest amplitude the source gives (assumed); bounds what ``design sensor`` proposes."""
    frequency_hz: Annotated[Number, Field(ge=1e4, le=1e6)] = 120e3
    """Frequency (paper, Sec. 3.2)."""
    amplitude_noise_rthz: NotNegative = 1e-6
    """Relative amplitude noise per root hertz near the carrier (assumed)."""


class ChargeAmplifier(Block):
    """The op-amp that turns the charge of one electrode into a voltage, q/Cf."""

    feedback_pf: Positive = 22.0
    """Feedback capacitor Cf (assumed)."""
    feedback_mohm: Positive = 10.0
    """Feedback resistor Rf (assumed)."""
    parasitic_pf: NotNegative = 100.0
    """Capacitance of the electrode and its cable to guard and ground, Cpar (assumed)."""
    noise_nv_rthz: NotNegative = 4.5
    """Voltage noise of the op-amp (assumed: a low-noise type with FET input)."""
    current_noise_fa_rthz: NotNegative = 1.0
    """Current noise of the op-amp (assumed, as above)."""
    gain_bandwidth_mhz: Positive = 45.0
    """Gain-bandwidth product of the op-amp (assumed, as above)."""
    open_loop_gain: Annotated[Number, Field(ge=1e3)] = 1e6
    """Open-loop gain at zero frequency (assumed)."""
    swing_v: Positive = 12.0
    """Largest output voltage in either direction (assumed: supplies of +-15 V)."""


class Filters(Block):
    """The selective filter at the excitation's frequency and the low-pass after the demodulator."""

    bandpass_q: Annotated[Number, Field(ge=0.5, le=200)] = 4.0
    """Quality factor of the selective filter: resistor, then coil and capacitor to ground (assumed)."""
    bandpass_coil_uh: Positive = 100.0
    """Its coil; capacitor and resistor follow from it (assumed)."""
    buffer_noise_nv_rthz: NotNegative = 4.5
    """Voltage noise of the buffer after it (assumed)."""
    cutoff_hz: Positive = 1000.0
    """Cutoff of the first-order low-pass (paper, Sec. 3.2; 300 Hz is where Fig. 4b falls)."""
    lowpass_nf: Positive = 100.0
    """Capacitor of the low-pass; its resistor follows (assumed)."""


class Readout(Block):
    """How two demodulated voltages become one number."""

    form: Literal["subtraction", "ratio"] = "subtraction"
    """"subtraction": V+ - V- (paper, Sec. 3.2); "ratio": (V+ - V-)/(V+ + V-), with the sum as the converter's
    reference."""


class Adc(Block):
    """The converter; the gain before it makes its span the range in newtons."""

    bits: Annotated[Whole, Field(ge=4, le=32)] = 16
    """Effective bits (assumed; the converter of a Teensy 4.1 has 12, about 11 of them effective)."""
    range_n: Positive = 2.5
    """Force at the end of its span, in either direction (the paper's range)."""
    rate_hz: Positive = 5000.0
    """Samples per second (paper, Sec. 4)."""


class Environment(Block):
    """Where the sensor stands."""

    temperature_k: Positive = 295.0
    """Temperature (assumed)."""
    vibration_m_s2_rthz: NotNegative = 1e-6
    """Acceleration of the base along the axis, per root hertz (assumed: isolated bench; a floor has 10 to 1000 times
    this)."""
    tilt_urad: NotNegative = 1.0
    """Slow changes of the base's tilt, rms (assumed)."""


class SensorDesign(Description):
    """A capacitive force sensor from springs to converter."""

    springs: Springs = ArcSprings()
    """What holds the frame."""
    moving: Moving = Moving()
    """What moves."""
    load: Load = Load()
    """What is to be measured."""
    electrodes: Electrodes = Electrodes()
    """The capacitors that see the motion."""
    excitation: Excitation = Excitation()
    """The voltage that polarises them."""
    amplifier: ChargeAmplifier = ChargeAmplifier()
    """Charge to voltage."""
    filters: Filters = Filters()
    """Band-pass and low-pass."""
    readout: Readout = Readout()
    """Two voltages to one number."""
    adc: Adc = Adc()
    """To bits."""
    environment: Environment = Environment()
    """Temperature, vibration, tilt."""
