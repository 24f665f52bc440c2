"""Claims of Sec. 2.3 about gains that are too high or too low, Fig. 2b and 2d."""

from __future__ import annotations

import math
from collections.abc import Mapping

import xarray as xr

from frictionloop.analysis import kp_limit
from frictionloop.parameters import READINGS
from frictionloop.report.claims.claim import Claim, python
from frictionloop.report.gains import at
from frictionloop.report.numbers import number
from frictionloop.report.results import Results
from frictionloop.report.systems import FEASIBLE, WORKING
from frictionloop.report.tolerances import R2_RULE, R2_STEP, RMS_FACTOR, RMS_RULE, SATURATION_RULE, SATURATION_STEP
from frictionloop.report.tracking import noise_above_n, tracking_run

RUN = "import frictionloop as fl; from frictionloop.report.tracking import *; "


def _saturated(results: Results) -> Claim:
    def more(cut: xr.Dataset) -> float:
        return at(cut["saturation_index"], 40.0) - at(cut["saturation_index"], 10.0)

    index = at(results.over_kp[FEASIBLE]["saturation_index"], 40.0)
    return Claim(
        id="kp-40-saturated",
        note=16,
        quantity="saturation index rises by",
        title="Kp = 40 saturates the command",
        place="Sec. 2.3, Fig. 2b",
        quote="A high gain as in Fig 2b, results in noisy and saturated command",
        published="saturated",
        measure="saturation index at Kp = 40 minus that at Kp = 10",
        readings={name: more(results.over_kp[name]) for name in READINGS},
        assumed={FEASIBLE: more(results.over_kp[FEASIBLE])},
        accepted=(SATURATION_STEP, math.inf),
        tolerance=f"more than at Kp = 10; {SATURATION_RULE}",
        explanation=f"With a reachable set-point Kp = 10 never saturates, and Kp = 40 does in {index:.0%} of the "
        "periods.",
        command=python(
            "import frictionloop as fl; from frictionloop.report.gains import *; "
            "cut = fidelity_over(fl.paper(), KP).saturation_index; print(at(cut, 40) - at(cut, 10))"
        ),
    )


def _noisy(results: Results) -> Claim:
    def louder(runs: Mapping[float, xr.Dataset]) -> float:
        return noise_above_n(runs[40.0]) / noise_above_n(runs[10.0])

    runs = results.runs[FEASIBLE]
    return Claim(
        id="kp-40-noisy",
        note=16,
        quantity="noise rises by a factor of",
        title="Kp = 40 is noisy",
        place="Sec. 2.3, Fig. 2b",
        quote="Over-corrected signal leads to noise",
        published="noisy",
        measure="rms of f_a above 200 Hz at Kp = 40 over that at Kp = 10",
        readings={name: louder(results.runs[name]) for name in READINGS},
        assumed={FEASIBLE: louder(runs)},
        accepted=(RMS_FACTOR, math.inf),
        tolerance=f"{RMS_RULE}; 200 Hz is twice the highest frequency asked for",
        explanation=f"{number(1e3 * noise_above_n(runs[40.0]))} mN against {number(1e6 * noise_above_n(runs[10.0]))} "
        "µN with a reachable set-point. With the printed amplitudes the corners where the clamp engages add to both, "
        "and where the set-point is largest they leave no room for the difference.",
        command=python(
            RUN + "print(noise_above_n(tracking_run(fl.paper(), 40.0)) / noise_above_n(tracking_run(fl.paper(), 10.0)))"
        ),
    )


def _because_of_noise(results: Results) -> Claim:
    def louder(name: str) -> float:
        quiet = tracking_run(results.systems[name], 40.0, sensor__noise_rms_n=0.0)
        return noise_above_n(results.runs[name][40.0]) / noise_above_n(quiet)

    limit = kp_limit(results.systems[WORKING])
    return Claim(
        id="kp-40-because-of-sensor-noise",
        note=16,
        quantity="noise, with over without sensor noise",
        title="At Kp = 40 the noise comes from the sensor",
        place="Sec. 2.3",
        quote="A higher set of gain … results in an amplification of the noise introduced by the sensor",
        published="implied",
        measure="rms of f_a above 200 Hz at Kp = 40 over that with a noiseless sensor",
        digits=4,
        readings={name: louder(name) for name in READINGS},
        assumed={FEASIBLE: louder(FEASIBLE)},
        accepted=(RMS_FACTOR, math.inf),
        tolerance=RMS_RULE,
        explanation=f"It is the same with a noiseless sensor. Above Kp = {limit:.1f} the loop sampled at 5 kHz is "
        "unstable and swings between the limits of its amplitude: a limit cycle, not amplified noise. Equation (2), "
        "in continuous time, is stable at any gain and cannot show it.",
        command=python(
            RUN + "print(noise_above_n(tracking_run(fl.paper(), 40.0))"
            " / noise_above_n(tracking_run(fl.paper(), 40.0, sensor__noise_rms_n=0.0)))"
        ),
    )


def _low_gain(results: Results) -> Claim:
    def lost(cut: xr.Dataset) -> float:
        return at(cut["r2_identity"], 10.0) - at(cut["r2_identity"], 1.0)

    r2 = results.over_kp[FEASIBLE]["r2_identity"]
    return Claim(
        id="kp-1-unsatisfactory",
        note=23,
        quantity="R² falls by",
        title="Kp = 1 is unsatisfactory",
        place="Sec. 2.3, Fig. 2d",
        quote="Low gain leads to unsatisfactory disturbance rejection",
        published="unsatisfactory",
        measure="R² at Kp = 10 minus R² at Kp = 1",
        readings={name: lost(results.over_kp[name]) for name in READINGS},
        assumed={FEASIBLE: lost(results.over_kp[FEASIBLE])},
        accepted=(R2_STEP, math.inf),
        tolerance=R2_RULE,
        explanation=f"Clearest with a reachable set-point: R² = {at(r2, 1.0):.2f} at Kp = 1 against "
        f"{at(r2, 10.0):.2f} at 10.",
        command=python(
            "import frictionloop as fl; from frictionloop.report.gains import *; "
            "cut = fidelity_over(fl.paper(), KP).r2_identity; print(at(cut, 10) - at(cut, 1))"
        ),
    )


CLAIMS = (_saturated, _noisy, _because_of_noise, _low_gain)
