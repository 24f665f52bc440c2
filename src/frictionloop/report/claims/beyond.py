"""Claims about control itself, judged on fingers that no law was tuned on: what a PI does, and what more could do."""

from __future__ import annotations

import math

from frictionloop.report.beyond import MEDIAN, NOTCH, ORACLE, SOURCE, TRACKER, WORST, Beyond
from frictionloop.report.claims.claim import Claim, python
from frictionloop.report.device import OPEN, PRINTED, RETUNED_GAINS
from frictionloop.report.numbers import number
from frictionloop.report.tolerances import RMS_FACTOR, RMS_RULE

IMPORTS = "from frictionloop.report.beyond import *; "


def beyond_claims(found: Beyond) -> list[Claim]:
    """Return the claims that the stored study decides."""
    return [_pi_suffices(found), _higher_order(found)]


def _pi_suffices(study: Beyond) -> Claim:
    found = {
        f"{law}, {contact} contact": study.ratio(OPEN, law, contact, "residual_rms_n")
        for law in (PRINTED, RETUNED_GAINS)
        for contact in study.contacts
    }
    left = " and ".join(number(1e3 * study.value(RETUNED_GAINS, at, "residual_rms_n"), 2) for at in study.contacts)
    return Claim(
        id="pi-reduces-variability",
        title="A PI reduces the variability",
        place="Sec. 6",
        quote="a PI controller was sufficient to considerably reduce the variability of the stimuli produced by "
        "ultrasonic friction modulation",
        published="considerably",
        unit="",
        measure="residual of the lookup table alone over that with the PI, sines, median of the capable fingers, "
        + SOURCE,
        readings={name: value for name, value in found.items() if name.startswith(PRINTED)},
        compared={name: value for name, value in found.items() if name.startswith(RETUNED_GAINS)},
        accepted=(RMS_FACTOR, math.inf),
        tolerance=RMS_RULE,
        explanation="With the printed gains most of the variability gives way to ringing. With the re-tuned "
        f"ones {left} mN are left under a {' and a '.join(study.contacts)} contact.",
        command=python(IMPORTS + f"print(stored().ratio(OPEN, PRINTED, '{study.contacts[0]}', 'residual_rms_n'))"),
    )


def _higher_order(study: Beyond) -> Claim:
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
        title="A higher-order controller cancels the fluctuations",
        place="Sec. 5",
        quote="A frequency synthesis of the control that takes into account the friction noise could potentially lead "
        "to higher order controller that are able to cancel these fluctuations",
        published="could",
        unit="",
        measure="residual of the re-tuned PI over that of the law, held set-point, capable fingers, " + SOURCE,
        readings=over_pi(TRACKER),
        compared=over_pi(NOTCH) | over_pi(ORACLE),
        accepted=(RMS_FACTOR, math.inf),
        tolerance=RMS_RULE,
        explanation="The tracker's gains are Kalman gains for a model of the friction noise; it learns the contact "
        f"besides, which a fixed synthesis does not. It leaves {left} mN under a {' and a '.join(study.contacts)} "
        f"contact, {worst} mN in the worst decile, where the PI leaves {pi_worst}. The "
        f"notch with feed-forward, a fixed synthesis, leaves {fixed} mN, {fixed_worst} mN in the worst decile.",
        command=python(IMPORTS + f"print(stored().ratio(RETUNED_GAINS, TRACKER, '{study.contacts[0]}', 'hold_rms_n'))"),
    )
