"""The numbers that the page's text quotes about the device, computed like everything else."""

from __future__ import annotations

import numpy as np

from frictionloop.parameters import RETUNED
from frictionloop.report import protocol
from frictionloop.report.calibration import SHAKING, STILL
from frictionloop.report.claims.people import capable_share
from frictionloop.report.claims.steps import this_skin_limit_ms
from frictionloop.report.device import CONTROLLERS, IDEAL, OPEN, PRINTED, RETUNED_GAINS, fit, spread_n
from frictionloop.report.numbers import number
from frictionloop.report.people import the_finger
from frictionloop.report.results import Results
from frictionloop.report.step_response import DIRECTIONS, SHARE_10_90, times_ms

SHORT = {OPEN: "open", PRINTED: "printed gains", RETUNED_GAINS: "retuned", IDEAL: "ideal"}
"""What the facts call the controllers."""


def device_facts(results: Results) -> dict[str, str]:
    """Return formatted numbers by name."""
    finger = the_finger()
    rigs, people = results.rigs, results.people[RETUNED_GAINS]
    found = {
        "finger number": str(protocol.chosen(protocol.population())),
        "finger f0": number(finger[protocol.F0]),
        "finger tau": number(finger[protocol.TAU], 2),
        "finger load": number(finger["motion.load_n"], 2),
        "finger stiffness": number(finger["finger.stiffness_n_m"]),
        "finger tremor": number(finger["motion.tremor_um"], 2),
        "open spread N": number(spread_n(results.tracked[OPEN]), 2),
        "retuned spread N": number(spread_n(results.tracked[RETUNED_GAINS]), 2),
        "retuned error N": number(fit(results.tracked[RETUNED_GAINS]).rms_n, 2),
        "retuned kp": number(RETUNED["controller.kp"]),
        "retuned ki": number(RETUNED["controller.ki"]),
        "skin limit": f"{this_skin_limit_ms():.0f}",
        "skin limit full": f"{this_skin_limit_ms() / SHARE_10_90:.0f}",
        "calibration missing": number(1 - rigs.weights.r2, 2),
        "calibration residual mN": number(1e3 * rigs.weights.residual_rms_n, 2),
        "rubbing friction": f"{rigs.rubbing_friction:.3f}",
        "hammer Hz": f"{rigs.resonance.resonance.value:.1f}",
        "floor still µN": number(1e6 * rigs.rms_n(STILL), 2),
        "floor shaking µN": number(1e6 * rigs.rms_n(SHAKING), 2),
        "capable": str(int(people["capable"].sum())),
        "people": str(people.sizes["finger"]),
        "median error mN": number(1e3 * float(people["rms_n"].median())),
        "capable error mN": number(1e3 * float(people["rms_n"].where(people["capable"]).median())),
        "capable landed": f"{capable_share(0.0):.0%}",
        "capable stroke": f"{capable_share(protocol.SCORED_S):.0%}",
        "relative printed gains": number(results.felt[PRINTED]["relative"], 2),
        "relative retuned": number(results.felt[RETUNED_GAINS]["relative"]),
        "relative ideal": number(results.felt[IDEAL]["relative"], 2),
    }
    return found | _fits(results) | _times(results)


def _fits(results: Results) -> dict[str, str]:
    found: dict[str, str] = {}
    for name in CONTROLLERS:
        runs, short = results.tracked[name], SHORT[name]
        pooled = fit(runs)
        levels = [fit(runs.sel(level=n)) for n in protocol.LEVELS_N]
        found |= {
            f"{short} r2": f"{pooled.regression:.2f}",
            f"{short} identity": f"{pooled.identity:.2f}" if pooled.identity > -1 else number(pooled.identity, 2),
            f"{short} error mN": number(1e3 * pooled.rms_n),
            f"{short} within": f"{np.mean([each.regression for each in levels]):.2f}",
            f"{short} within identity": number(float(np.mean([each.identity for each in levels])), 2),
            f"{short} saturated": f"{float(runs['saturated'].mean()):.0%}",
        }
    return found


def _times(results: Results) -> dict[str, str]:
    found: dict[str, str] = {}
    for name in CONTROLLERS:
        for direction in DIRECTIONS:
            times = times_ms(results.stepped[name], name, direction)
            for k, kind in enumerate(("63", "10-90")):
                found[f"{SHORT[name]} {direction} {kind}"] = f"{times.mean[k]:.0f} ± {times.sd[k]:.0f}"
    return found
