"""The paper's thesis: a PI reduces the variability of the force."""

from __future__ import annotations

from frictionloop.report.claims.claim import Claim, Group, python
from frictionloop.report.claims.closed_loop import BENCH
from frictionloop.report.device import OPEN, PRINTED, RETUNED_GAINS, fit
from frictionloop.report.numbers import number
from frictionloop.report.protocol import POPULATION
from frictionloop.report.results import Results
from frictionloop.report.tolerances import RMS_FACTOR, RMS_RULE


def _reduces(results: Results) -> Claim:
    tracked, people = results.tracked, results.people

    def ratios(name: str) -> dict[str, float]:
        one = fit(tracked[OPEN]).rms_n / fit(tracked[name]).rms_n
        some = float((people[OPEN]["rms_n"] / people[name]["rms_n"]).median())
        return {f"{name}, one finger": one, f"{name}, median of {POPULATION} fingers": some}

    left, before = (1e3 * fit(tracked[name]).rms_n for name in (RETUNED_GAINS, OPEN))
    return Claim(
        id="pi-reduces-variability",
        of=Group.DEVICE,
        note=32,
        quantity="error, open over closed loop",
        title="A PI considerably reduces the variability",
        place="Sec. 6",
        quote="a PI controller was sufficient to considerably reduce the variability of the stimuli produced by "
        "ultrasonic friction modulation",
        published="considerably",
        measure="rms of f_a − f_r with the lookup table alone over that with the PI, three sines",
        readings=ratios(RETUNED_GAINS),
        compared=ratios(PRINTED),
        accepted=(RMS_FACTOR, float("inf")),
        tolerance=RMS_RULE,
        explanation=f"For one finger the error goes from {number(before)} to {number(left)} mN rms with gains that are "
        "stable on this bench. The printed gains ring here: most of the variability gives way to ringing.",
        command=python(
            BENCH + "found = [fit(tracking(the_finger(), CONTROLLERS[name])).rms_n for name in (OPEN, RETUNED_GAINS)]; "
            "print(found[0] / found[1])"
        ),
    )


CLAIMS = (_reduces,)
