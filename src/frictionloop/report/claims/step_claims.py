"""Numbers of the claims of Sec. 4.2 and 5 about steps, Fig. 5b and 5c, on the bench under one finger."""

from __future__ import annotations

from typing import Any

from frictionloop.report.claims.claim import WITHOUT_VOTE, Numbers, Value, numbers
from frictionloop.report.paper_protocol import CLOSED, IDEAL, OPEN, RETUNED_GAINS, SLOW, WITH_KP
from frictionloop.report.results import Results
from frictionloop.report.step_response import (
    DIRECTIONS,
    PRINTED_MS,
    Times,
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
    found: dict[str, Value] = {f"{name}, 10 to 90 %": each.from_10_to_90 for name, each in times.items()}
    retuned = times[RETUNED_GAINS]
    return numbers(
        found | {f"{name}, to 63 %": each.to_63 for name, each in times.items()},
        mean_63=retuned.mean[0],
        sd_63=retuned.sd[0],
        mean_10_90=retuned.mean[1],
        sd_10_90=retuned.sd[1],
        **told,
    )


def faster_than_open(results: Results) -> Numbers:
    """Return both times in open over closed loop."""
    found, told = dict[str, Value](), dict[str, Any]()
    for way, up in (("rising", "up"), ("falling", "down")):
        opened = times_ms(results.stepped[OPEN], OPEN, way)
        closed = {name: times_ms(results.stepped[name], name, way) for name in (RETUNED_GAINS, SLOW, IDEAL)}
        for name, each in closed.items():
            found |= _ratios(f"{name}, {way}", opened, each)
        told |= {f"open_{up}": opened.from_10_to_90, f"retuned_{up}": closed[RETUNED_GAINS].from_10_to_90}
    return numbers(found, **told)


def closed_loop_time(_: Results) -> Numbers:
    """Return the times that Section 4.2 prints, in ms."""
    printed = {direction: mean for direction, (mean, _) in PRINTED_MS.items()}
    return numbers(printed, down=OPEN_MS / printed["falling"], up=OPEN_MS / printed["rising"])


def stronger_plate_faster(results: Results) -> Numbers:
    """Return both times with a plate of twice the amplitude over those with the plate as built."""
    found = dict[str, Value]()
    for name in (RETUNED_GAINS, IDEAL):
        for direction in reversed(DIRECTIONS):
            times = (times_ms(runs[name], name, direction) for runs in (results.stronger, results.stepped))
            found |= _ratios(f"{name}, {direction}", *times)
    return numbers(found)


def _ratios(name: str, over: Times, under: Times) -> dict[str, Value]:
    """Return one over the other for each way to tell the time of a step, of which the paper names none."""
    return {
        f"{name}, 10 to 90 %": _ratio(over.from_10_to_90, under.from_10_to_90),
        f"{name}, to 63 %": _ratio(over.to_63, under.to_63),
    }


def _ratio(over: float | None, under: float | None) -> Value:
    """Return over / under, None where one of them does not exist."""
    return None if over is None or not under else over / under


def amplitude_overshoot(results: Results) -> Numbers:
    """Return how far the commanded amplitude goes beyond where it settles, over its step."""
    over = {way: {name: overshoot(results.stepped[name], way) for name in (*CLOSED, WITH_KP)} for way in DIRECTIONS}
    found = {f"{name}, {way}": each for way, some in over.items() for name, each in some.items()}
    runs = results.stepped[RETUNED_GAINS]
    return numbers(found, compared=[*WITHOUT_VOTE, "rising"], with_kp=over["falling"][WITH_KP], peak=mean_peak_n(runs))
