"""Claims of Sec. 3 and 4.1 about the force sensor and the timing: plain formulas."""

from __future__ import annotations

import math

from frictionloop.report.claims.claim import Claim, Group, python
from frictionloop.report.results import Results
from frictionloop.report.tolerances import LAST_DIGIT, as_printed

RANGE_N, NOISE_N = 2.5, 5e-5
"""Largest force and noise of the sensor (paper, Sec. 3.1)."""
STIFFNESS_N_PER_M, MASS_KG = 1e6, 0.4
"""Stiffness of the suspension and mass of the plate (paper, Sec. 3.1)."""
AS_PRINTED = "as printed"
LOWPASS_HZ = 1000.0
"""Cutoff of the demodulator (paper, Sec. 3.2)."""


def _ratio(_: Results) -> Claim:
    return Claim(
        id="dynamic-range",
        note=27,
        quantity="ratio",
        title="2.5 N over 5×10⁻⁵ N is 1:50,000",
        place="Sec. 3.1",
        quote="lower than 5·10⁻⁵ N … while being able to resolve forces as high as 2.5 N … 1:50,000",
        published=50000.0,
        measure="range over noise",
        readings={AS_PRINTED: RANGE_N / NOISE_N},
        accepted=as_printed(50000),
        tolerance=LAST_DIGIT,
        explanation="Exactly so.",
        command=python("print(2.5 / 5e-5)"),
    )


def _decibels(_: Results) -> Claim:
    return Claim(
        id="dynamic-range-db",
        of=Group.SLIP,
        note=27,
        quantity="1:50,000",
        title="1:50,000 is 95 dB, and 93 dB",
        place="Sec. 3.1, Sec. 3.3",
        quote="a dynamic range figure of 1:50,000 or about 95 dB … is 1:50,000 or about 93dB",
        published="95 and 93 dB",
        unit="dB",
        measure="20 log₁₀ of the ratio",
        meant="94 dB",
        digits=4,
        readings={AS_PRINTED: 20 * math.log10(50000)},
        accepted=as_printed(94.0),
        tolerance="what was meant: half a unit of its last digit",
        explanation="20 log₁₀ 50,000 = 93.98 dB. 95 dB would be "
        f"1:{10 ** (95 / 20):,.0f}, 93 dB 1:{10 ** (93 / 20):,.0f}: one ratio has two figures.",
        command=python("import math; print(20 * math.log10(50000))"),
    )


def _resonance(_: Results) -> Claim:
    return Claim(
        id="resonance",
        note=25,
        quantity="resonance",
        title="400 g on 1 N/µm resonates at 250 Hz",
        place="Sec. 3.1",
        quote="f₀ = 1/2π √(k/m_p) = 250 Hz for a sensor stiffness of 1 N.µm",
        published=250.0,
        unit="Hz",
        measure="√(k/m)/2π",
        readings={AS_PRINTED: math.sqrt(STIFFNESS_N_PER_M / MASS_KG) / (2 * math.pi)},
        accepted=as_printed(250),
        tolerance=LAST_DIGIT,
        explanation="With the stiffness read as 1 N/µm; “N.µm” is no stiffness.",
        command=python("import math; print(math.sqrt(1e6 / 0.4) / (2 * math.pi))"),
    )


def _mass(_: Results) -> Claim:
    stiffness = (2 * math.pi * 145) ** 2 * MASS_KG / 1e6
    return Claim(
        id="measured-resonance",
        of=Group.QUESTION,
        note=25,
        quantity="mass for 145 Hz",
        title="The measured 145 Hz fits 400 g on 1 N/µm",
        place="Sec. 3.3, Fig. 4b",
        quote="The frequency response shows a first resonance at 145 Hz, owing to the large glass plate",
        published=MASS_KG,
        unit="kg",
        measure="k/(2π · 145 Hz)²",
        readings={AS_PRINTED: STIFFNESS_N_PER_M / (2 * math.pi * 145) ** 2},
        accepted=as_printed(MASS_KG),
        tolerance=LAST_DIGIT,
        explanation=f"145 Hz needs 1.2 kg on 1 N/µm, or {stiffness:.2f} N/µm under 400 g. The softer suspension moves "
        "7.5 µm at 2.5 N.",
        command=python("import math; print(1e6 / (2 * math.pi * 145) ** 2)"),
    )


def _displacement(_: Results) -> Claim:
    return Claim(
        id="displacement",
        note=25,
        quantity="displacement",
        title="2 N moves the sensor by 2 µm",
        place="Sec. 3.1",
        quote="to resolve 2 N, the sensor is displaced by 2 µm",
        published=2.0,
        unit="µm",
        measure="F/k",
        readings={AS_PRINTED: 2.0 / STIFFNESS_N_PER_M * 1e6},
        accepted=as_printed(2.0),
        tolerance=LAST_DIGIT,
        explanation="On 1 N/µm.",
        command=python("print(2.0 / 1e6 * 1e6)"),
    )


def _displacement_noise(_: Results) -> Claim:
    rms_pm = NOISE_N / STIFFNESS_N_PER_M * 1e12
    bandwidth_hz = math.pi / 2 * LOWPASS_HZ
    return Claim(
        id="displacement-noise",
        of=Group.SLIP,
        note=24,
        quantity="floor needed",
        meant="50 pm, or a density: 0.5 pm/√Hz is near it",
        title="The displacement sensor needs a floor of 0.5 pm",
        place="Sec. 3.1",
        quote="the underlying displacement sensor should have a noise floor of 0.5 pm",
        published=0.5,
        unit="pm",
        measure="noise/k",
        readings={"rms": rms_pm, "density below 1 kHz (pm/√Hz)": rms_pm / math.sqrt(bandwidth_hz)},
        accepted=as_printed(0.5),
        tolerance=LAST_DIGIT,
        explanation="5·10⁻⁵ N on 1 N/µm is 50 pm, a hundred times more. Spread over a first-order 1 kHz band (1571 "
        f"Hz of noise) it is {rms_pm / math.sqrt(bandwidth_hz):.1f} pm/√Hz, of the printed order but not the printed "
        "number.",
        command=python("print(5e-5 / 1e6 * 1e12)"),
    )


def _period(_: Results) -> Claim:
    return Claim(
        id="control-period",
        of=Group.SLIP,
        note=12,
        quantity="period of 5 kHz",
        meant="200 µs",
        title="The controller runs every 200 ms",
        place="Sec. 4.1",
        quote="low-latency 5 kHz timer … Every 200 ms the sensors are acquired",
        published=200.0,
        unit="ms",
        measure="1/rate",
        readings={"5 kHz timer": 1e3 / 5000.0},
        accepted=as_printed(200.0),
        tolerance=LAST_DIGIT,
        explanation="A 5 kHz timer ticks every 200 µs: a slip of the unit. A controller running every 200 ms could "
        "not even see a set-point that sweeps beyond 2.5 Hz.",
        command=python("print(1e3 / 5000)"),
    )


CLAIMS = (
    _ratio,
    _decibels,
    _resonance,
    _mass,
    _displacement,
    _displacement_noise,
    _period,
)
