"""Claims of Sec. 4.2 and 5 about the amplitude behind a step, Fig. 5c: its overshoot, and what more of it would do."""

from __future__ import annotations

import math

from frictionloop.report.claims.claim import Claim, Group, Value, having, python
from frictionloop.report.claims.closed_loop import STEPS
from frictionloop.report.claims.steps import ratio
from frictionloop.report.device import CLOSED, IDEAL, PRINTED, RETUNED_GAINS
from frictionloop.report.results import Results
from frictionloop.report.step_response import overshoot, times_ms
from frictionloop.report.tolerances import OVERSHOOT, OVERSHOOT_RULE, SAME, SAME_RULE


def _stronger(results: Results) -> Claim:
    stepped, stronger = results.stepped, results.stronger

    def change(name: str, direction: str) -> Value:
        with_more, with_less = (times_ms(runs[name], name, direction).from_10_to_90 for runs in (stronger, stepped))
        return ratio(with_more, with_less)

    def changes(name: str) -> dict[str, Value]:
        return {f"{name}, {direction}": change(name, direction) for direction in ("rising", "falling")}

    return Claim(
        id="stronger-plate-faster",
        of=Group.DEVICE,
        note=37,
        quantity="time, stronger over built",
        title="A stronger plate would respond faster",
        place="Sec. 5",
        quote="The results could be more dramatic with a more powerful actuator, since the current dynamic is only "
        "limited by the maximum amplitude that the plate can achieve",
        published="faster",
        measure="time from 10 to 90 % with a plate of 5 µm over that with 2.5 µm",
        readings=changes(RETUNED_GAINS),
        assumed=changes(IDEAL),
        digits=4,
        accepted=(0.0, 1.0 - SAME),
        tolerance=f"faster: {SAME_RULE}",
        explanation="A rising step needs less amplitude, not more: it is the skin that limits it, and twice the "
        "plate changes nothing. A falling one gains where the plate saturated.",
        command=python(
            STEPS
            + "found = [times_ms(stepping(the_finger(), each), RETUNED_GAINS, 'rising').from_10_to_90 for each in "
            "(stronger(CONTROLLERS[RETUNED_GAINS]), CONTROLLERS[RETUNED_GAINS])]; print(found[0] / found[1])"
        ),
    )


def _overshoot(results: Results) -> Claim:
    stepped = results.stepped
    readings = {
        f"{name}, {direction}": overshoot(stepped[name], direction)
        for direction in ("falling", "rising")
        for name in CLOSED
    }
    return Claim(
        id="amplitude-overshoot",
        of=Group.DEVICE,
        note=38,
        quantity="overshoot over the step, falling",
        title="The amplitude overshoots after a step",
        place="Sec. 4.2, Fig. 5c",
        quote="In order to achieve fast response, the controller overshoots the amplitude value and then converges "
        "back to a lower steady-state value",
        published="overshoots",
        measure="amplitude beyond where it settles, over its step; of the mean over all steps",
        readings=having(readings, [RETUNED_GAINS]),
        assumed=having(readings, [IDEAL]),
        compared=having(readings, [PRINTED]),
        accepted=(OVERSHOOT, math.inf),
        tolerance=OVERSHOOT_RULE,
        explanation="On falling steps, of which the paper's “lower steady-state value” speaks, the amplitude barely "
        f"overshoots ({readings[f'{RETUNED_GAINS}, falling']:.0%} re-tuned, {readings[f'{IDEAL}, falling']:.0%} with "
        "an ideal sensor). On rising steps it overshoots by more than the step itself: while the skin is stuck the "
        "error stays, and the amplitude keeps falling below what it settles at. The printed gains overshoot because "
        "they ring.",
        command=python(STEPS + "print(overshoot(stepping(the_finger(), CONTROLLERS[RETUNED_GAINS]), 'falling'))"),
    )


CLAIMS = (_stronger, _overshoot)
