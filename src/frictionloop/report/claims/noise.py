"""Claims of Sec. 2.3 about how much sensor noise harms, Fig. 2e and 2f."""

from __future__ import annotations

from frictionloop.parameters import feasible
from frictionloop.report.claims.claim import Claim, Value, having, lacking, python
from frictionloop.report.noise import NOISE, NOISE_READINGS, knee_n
from frictionloop.report.numbers import number
from frictionloop.report.results import Results
from frictionloop.report.steady import steady_noise
from frictionloop.report.systems import FEASIBLE
from frictionloop.report.tolerances import HALF_DECADE, R2_RULE, R2_STEP, SATURATION_RULE, SATURATION_STEP, half_decade

METRIC = {
    "r2_identity": ("fidelity R²", R2_STEP, R2_RULE),
    "saturation_index": ("saturation index", SATURATION_STEP, SATURATION_RULE),
}
KNEE = "import frictionloop as fl; from frictionloop.report.noise import *; "
PERCEIVED_N = 5e-4
"""Lowest force perceived (paper, Sec. 2.3, after its ref. [14])."""


def _precision(results: Results) -> Claim:
    return _knee(
        results,
        "r2_identity",
        id="noise-precision",
        title="Noise above 10⁻⁴ N lowers the precision",
        quote="Noise level higher than 10⁻⁴ N of the force sensor will decrease significantly the precision",
    )


def _saturation(results: Results) -> Claim:
    return _knee(
        results,
        "saturation_index",
        id="noise-saturation",
        title="Noise above 10⁻⁴ N saturates the output",
        quote="… and increase the likelihood of saturating the output",
    )


def _knee(results: Results, metric: str, id: str, title: str, quote: str) -> Claim:
    words, step, rule = METRIC[metric]
    knees = {name: knee_n(sweep[metric], step) for name, sweep in results.noise.items()}
    readings: dict[str, Value] = {}
    for reading, of in NOISE_READINGS.items():
        for name, sigma in knees.items():
            readings[f"{reading} ({of.unit}), {name}"] = None if sigma is None else of.level(sigma)
    feasible_n = knees[FEASIBLE]
    assert feasible_n is not None
    return Claim(
        id=id,
        note=18,
        quantity="harm starts at",
        title=title,
        place="Sec. 2.3, Fig. 2e" if metric == "r2_identity" else "Sec. 2.3, Fig. 2f",
        quote=quote,
        published=1e-4,
        unit="N",
        measure=f"noise at which the {words} has moved by {step:g}, in the unit of each reading; densities "
        "one-sided to 2.5 kHz",
        readings=lacking(readings, [FEASIBLE]),
        assumed=having(readings, [FEASIBLE]),
        accepted=half_decade(1e-4),
        tolerance=f"{HALF_DECADE}; {rule}",
        explanation=f"Harm starts at {number(1e3 * feasible_n)} mN rms with a reachable set-point "
        f"(some {number(feasible_n / 1e-4, 1)} times the level "
        "printed if that is rms). Of the four readings of “10⁻⁴” this is "
        f"{number(NOISE_READINGS['variance'].level(feasible_n), 2)} N² as a variance and "
        f"{number(NOISE_READINGS['amplitude density'].level(feasible_n), 2)} N/√Hz as a one-sided "
        "density up to 2.5 kHz.",
        command=python(KNEE + f"print(knee_n(noise_sweep(fl.paper()).{metric}, {step:g}))"),
    )


def _subliminal(_: Results) -> Claim:
    def output_n(reading: str) -> float:
        sigma_n = NOISE_READINGS[reading].sigma_n(5e-5)
        return steady_noise(feasible().evolve({NOISE: sigma_n}))["f_a"]

    return Claim(
        id="noise-subliminal",
        note=20,
        quantity="noise of the force",
        title="5×10⁻⁵ N of sensor noise stays imperceptible",
        place="Sec. 2.3",
        quote="A sensor with a noise level of 5·10⁻⁵ N produces an output noise that remains subliminal",
        published=PERCEIVED_N,
        unit="N",
        measure="rms of f_a, everything else held; densities one-sided to 2.5 kHz",
        readings={f"{reading} ({of.unit})": output_n(reading) for reading, of in NOISE_READINGS.items()},
        accepted=(0.0, PERCEIVED_N),
        tolerance="below the perceivable force printed, 5·10⁻⁴ N",
        explanation="True if the noise is an rms value, by a wide margin. The readings that put the harm of Fig. 2e "
        "near 10⁻⁴ make this one false: no single reading of “noise level” gives both.",
        command=python(
            "import frictionloop as fl; from frictionloop.report.steady import steady_noise; "
            "print(steady_noise(fl.feasible().evolve({'sensor.noise_rms_n': 5e-5}))['f_a'])"
        ),
    )


CLAIMS = (_precision, _saturation, _subliminal)
