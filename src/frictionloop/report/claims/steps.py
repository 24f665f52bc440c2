"""Claims of Sec. 4.2 and 5 about steps, Fig. 5b and 5c, on the bench under one finger."""

from __future__ import annotations

import math
from functools import partial

from frictionloop.report.claims.claim import Claim, Group, Value, having, python
from frictionloop.report.claims.closed_loop import STEPS
from frictionloop.report.device import CLOSED, IDEAL, OPEN, PRINTED, RETUNED_GAINS
from frictionloop.report.people import the_finger
from frictionloop.report.protocol import STEP_LEVELS_N, finger_system
from frictionloop.report.results import Results
from frictionloop.report.step_response import DIRECTIONS, skin_limit_ms, times_ms
from frictionloop.report.tolerances import TIME_RATIO, WITHIN_SD, as_measured

PRINTED_MS = {"falling": (37.0, 20.0), "rising": (32.0, 16.0)}
"""Mean and standard deviation of the response (paper, Sec. 4.2)."""
KINDS = {"to 63 %": "to_63", "10 to 90 %": "from_10_to_90"}


def this_skin_limit_ms() -> float:
    """Return the least time from 10 to 90 % of the steps up, for the chosen finger."""
    return skin_limit_ms(finger_system(the_finger()), STEP_LEVELS_N[1] - STEP_LEVELS_N[0])


def _time(direction: str, results: Results) -> Claim:
    stepped = results.stepped
    mean, sd = PRINTED_MS[direction]
    times = {name: times_ms(stepped[name], name, direction) for name in CLOSED}
    readings: dict[str, Value] = {
        f"{name}, {kind}": getattr(found, field) for kind, field in KINDS.items() for name, found in times.items()
    }
    found = times[RETUNED_GAINS]
    ours = (
        f"re-tuned gains: {found.mean[0]:.0f} ± {found.sd[0]:.0f} ms to 63 %, "
        f"{found.mean[1]:.0f} ± {found.sd[1]:.0f} ms from 10 to 90 %"
    )
    why = {
        "falling": f"The force falls many times as fast as printed ({ours}): nothing in this bench holds it back but "
        "loop and plate. Candidates outside it are the 20 ms in which skin lets go of its strain, a weaker plate, "
        "another criterion.",
        "rising": "A rise waits for the skin: it cannot go from 10 to 90 % in less than 0.8 ΔF/(k_s v) = "
        f"{this_skin_limit_ms():.0f} ms at a steady 20 mm/s, k_s being skin and stuck contact in "
        f"series, whatever the controller ({ours}). That is the printed order; half "
        "the stiffness, 500 N/m, would nearly double it.",
    }
    return Claim(
        id={"falling": "fall-time", "rising": "rise-time"}[direction],
        of=Group.DEVICE,
        note=36,
        quantity="time to 63 %",
        title=f"A {direction} step takes {mean:.0f} ms",
        place="Sec. 4.2, Fig. 5b",
        quote=f"a time response of … {mean:.0f} ± {sd:.0f} ms (SD) for a {direction} friction step, … exploration "
        "speed of approximately 20 mm·s⁻¹",
        published=mean,
        unit="ms",
        measure=f"mean time of {direction} steps between 0.4 and 0.8 N; where the force rings, between its own levels",
        readings=having(readings, [RETUNED_GAINS]),
        assumed=having(readings, [IDEAL]),
        compared=having(readings, [PRINTED]),
        accepted=(mean - sd, mean + sd),
        tolerance=WITHIN_SD,
        explanation=why[direction],
        command=python(
            STEPS + "print(times_ms(stepping(the_finger(), CONTROLLERS[RETUNED_GAINS]), RETUNED_GAINS, "
            f"'{direction}').to_63)"
        ),
    )


def ratio(over: float | None, under: float | None) -> Value:
    """Return over / under, None where one of them does not exist."""
    return None if over is None or not under else over / under


def _faster(results: Results) -> Claim:
    stepped = results.stepped

    def taken(name: str, direction: str) -> float | None:
        return times_ms(stepped[name], name, direction).from_10_to_90

    def ms(name: str, direction: str) -> str:
        return f"{taken(name, direction) or math.nan:.0f}"

    def gained(name: str) -> dict[str, Value]:
        ways = ("rising", "falling")
        return {f"{name}, {way}": ratio(taken(OPEN, way), taken(name, way)) for way in ways}

    return Claim(
        id="faster-than-open",
        of=Group.DEVICE,
        note=36,
        quantity="open over closed, rising",
        title="Closing the loop makes the response 2.5 times faster",
        place="Sec. 5",
        quote="The time response is also improved compared to open-loop condition, going from 50ms to 20ms for slow "
        "sliding speed",
        published=50.0 / 20.0,
        measure="time from 10 to 90 %, open over closed loop",
        readings=gained(RETUNED_GAINS),
        assumed=gained(IDEAL),
        accepted=as_measured(50.0 / 20.0),
        tolerance=TIME_RATIO,
        explanation=f"Rising, the lookup alone "
        f"takes {ms(OPEN, 'rising')} ms (printed: 50), the re-tuned gains {ms(RETUNED_GAINS, 'rising')} ms and "
        f"an ideal sensor {ms(IDEAL, 'rising')} ms (printed: 20): in stuck skin the force creeps to its new limit, and "
        f"the loop lowers the amplitude further than it needs to in the end, so that it follows the skin's limit to "
        f"the last. Falling, {ms(OPEN, 'falling')} ms open, {ms(RETUNED_GAINS, 'falling')} ms re-tuned and "
        f"{ms(IDEAL, 'falling')} ms with an ideal sensor.",
        command=python(
            STEPS + "found = {name: times_ms(stepping(the_finger(), CONTROLLERS[name]), name, 'rising').from_10_to_90 "
            "for name in (OPEN, RETUNED_GAINS)}; print(found[OPEN] / found[RETUNED_GAINS])"
        ),
    )


CLAIMS = (*(partial(_time, direction) for direction in DIRECTIONS), _faster)
