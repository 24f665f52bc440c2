"""Numbers of the claims of Sec. 4.2 and 5 about steps, Fig. 5b and 5c, on the bench under one finger."""

from __future__ import annotations

from typing import Any

from frictionloop.report.claims.claim import Value
from frictionloop.report.claims.judging import Numbers, numbers
from frictionloop.report.device import CLOSED, IDEAL, OPEN, RETUNED_GAINS
from frictionloop.report.results import Results
from frictionloop.report.step_response import (
    DIRECTIONS,
    PRINTED_MS,
    mean_peak_n,
    overshoot,
    this_skin_limit_ms,
    times_ms,
)

OPEN_MS = 50.0
"""Time of the response in open loop (paper, Sec. 5)."""


def fall_time(results: Results) -> Numbers:
    """Return the times of falling steps in ms."""
    return _times(results, "falling")


def rise_time(results: Results) -> Numbers:
    """Return the times of rising steps in ms."""
    return _times(results, "rising", skin_limit=this_skin_limit_ms())


def _times(results: Results, direction: str, **told: Any) -> Numbers:
    times = {name: times_ms(results.stepped[name], name, direction) for name in CLOSED}
    found: dict[str, Value] = {f"{name}, to 63 %": each.to_63 for name, each in times.items()}
    retuned = times[RETUNED_GAINS]
    return numbers(
        found | {f"{name}, 10 to 90 %": each.from_10_to_90 for name, each in times.items()},
        mean_63=retuned.mean[0],
        sd_63=retuned.sd[0],
        mean_10_90=retuned.mean[1],
        sd_10_90=retuned.sd[1],
        **told,
    )


def faster_than_open(results: Results) -> Numbers:
    """Return the time from 10 to 90 % in open over closed loop."""
    taken = {
        (name, direction): times_ms(results.stepped[name], name, direction).from_10_to_90
        for name in (OPEN, RETUNED_GAINS, IDEAL)
        for direction in reversed(DIRECTIONS)
    }
    found = {f"{name}, {way}": _ratio(taken[OPEN, way], each) for (name, way), each in taken.items() if name != OPEN}
    return numbers(
        found,
        printed_down=OPEN_MS / PRINTED_MS["falling"][0],
        printed_up=OPEN_MS / PRINTED_MS["rising"][0],
        open_up=taken[OPEN, "rising"],
        retuned_up=taken[RETUNED_GAINS, "rising"],
        ideal_up=taken[IDEAL, "rising"],
        open_down=taken[OPEN, "falling"],
        retuned_down=taken[RETUNED_GAINS, "falling"],
        ideal_down=taken[IDEAL, "falling"],
    )


def closed_loop_time(_: Results) -> Numbers:
    """Return the times that Section 4.2 prints, in ms."""
    printed = {direction: mean for direction, (mean, _) in PRINTED_MS.items()}
    return numbers(printed, down=OPEN_MS / printed["falling"], up=OPEN_MS / printed["rising"])


def stronger_plate_faster(results: Results) -> Numbers:
    """Return the time from 10 to 90 % with a plate of twice the amplitude over that with the plate as built."""
    found = {}
    for name in (RETUNED_GAINS, IDEAL):
        for direction in reversed(DIRECTIONS):
            with_more, with_less = (
                times_ms(runs[name], name, direction).from_10_to_90 for runs in (results.stronger, results.stepped)
            )
            found[f"{name}, {direction}"] = _ratio(with_more, with_less)
    return numbers(found)


def _ratio(over: float | None, under: float | None) -> Value:
    """Return over / under, None where one of them does not exist."""
    return None if over is None or not under else over / under


def amplitude_overshoot(results: Results) -> Numbers:
    """Return how far the amplitude goes beyond where it settles, over its step."""
    over = {way: {name: overshoot(results.stepped[name], way) for name in CLOSED} for way in DIRECTIONS}
    found = {f"{name}, {way}": each for way, some in over.items() for name, each in some.items()}
    return numbers(found, compared=["rising"], peak=mean_peak_n(results.stepped[RETUNED_GAINS]))
