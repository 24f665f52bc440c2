"""The claim about more than a PI, judged on fingers that no law was tuned on."""

from __future__ import annotations

import math

from frictionloop.report.beyond import MEDIAN, NOTCH, ORACLE, SOURCE, TRACKER, WORST
from frictionloop.report.claims.claim import Claim, Group, python
from frictionloop.report.device import RETUNED_GAINS
from frictionloop.report.numbers import number
from frictionloop.report.results import Results
from frictionloop.report.tolerances import RMS_FACTOR, RMS_RULE

IMPORTS = "from frictionloop.report.beyond import *; "


def _higher_order(results: Results) -> Claim:
    study = results.beyond

    def over_pi(law: str) -> dict[str, float]:
        return {
            f"{law}, {at} contact, {words}": study.ratio(RETUNED_GAINS, law, at, "hold_rms_n", key)
            for key, words in ((MEDIAN, "median"), (WORST, "worst decile"))
            for at in study.contacts
        }

    left, worst, pi_worst, fixed, fixed_worst = (
        " and ".join(number(1e3 * study.value(law, at, "hold_rms_n", key), 2) for at in study.contacts)
        for law, key in ((TRACKER, MEDIAN), (TRACKER, WORST), (RETUNED_GAINS, WORST), (NOTCH, MEDIAN), (NOTCH, WORST))
    )
    return Claim(
        id="higher-order-cancels",
        of=Group.DEVICE,
        note=39,
        quantity="residual, PI over the law",
        title="A higher-order controller cancels the fluctuations",
        place="Sec. 5",
        quote="A frequency synthesis of the control that takes into account the friction noise could potentially lead "
        "to higher order controller that are able to cancel these fluctuations",
        published="could",
        unit="",
        measure="residual of the re-tuned PI over that of the law, held set-point, capable fingers, " + SOURCE,
        readings=over_pi(NOTCH),
        assumed=over_pi(TRACKER),
        compared=over_pi(ORACLE),
        accepted=(RMS_FACTOR, math.inf),
        tolerance=RMS_RULE,
        explanation=f"A notch with feed-forward is a fixed synthesis for plate, sensor and delay. It leaves {fixed} mN "
        f"under a {' and a '.join(study.contacts)} contact, {fixed_worst} mN in the worst decile, where the PI leaves "
        f"{pi_worst}. The tracker, experimental, learns the contact besides: {left} and {worst} mN.",
        command=python(IMPORTS + f"print(stored().ratio(RETUNED_GAINS, NOTCH, '{study.contacts[0]}', 'hold_rms_n'))"),
    )


CLAIMS = (_higher_order,)
