"""A limit observer whose command comes a period later than it believes, or that reads a speed with white noise.

No System has these: the delay of a controller is both what there is and what is believed, and the noise of the speed is
that of the position, filtered. ``python -m studies.untold 20 100 100`` runs the histories of `studies.histories` on a
law that has them, and writes *results/untold.csv*. Ms is that of every capable one of 100 fingers, at six speeds and
contacts and the loop gain `LEARNT`: the smallest and the largest of the six.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from typing import Any, Literal, NamedTuple, Self

from pydantic import model_validator

import frictionloop as fl
from frictionloop.control.limit_observer import LimitObserverController, limit_observer_gains, limit_observer_start
from frictionloop.control.limit_step import LimitGains, LimitState, limit_observer_step
from frictionloop.design.limit_linear import LEARNT
from frictionloop.parameters import Model
from studies.as_it_runs import SPEEDS_MM_S, peaks_as_run
from studies.conditions import conditions, limit_observer
from studies.histories import campaign
from studies.kept import keep

PERIOD_S = 200e-6
CASES: dict[str, dict[str, Any]] = {
    "one more period of delay": {"controller.delay_s": 2 * PERIOD_S},
    "white noise of 5 mm/s on the speed": {"controller.speed_noise_m_s": 5e-3},
}


class UntoldController(LimitObserverController):
    """As a limit observer's; it believes at most one period of delay."""

    kind: Literal["untold"] = "untold"  # type: ignore[assignment]
    speed_noise_m_s: float = 0.0
    model: Model = Model(resonance_hz=145.0)

    @model_validator(mode="after")
    def _one_period(self) -> Self:  # in place of the check of that name
        return self


class _State(NamedTuple):
    own: LimitState
    drawn: float


class _Gains(NamedTuple):
    noise: float
    own: LimitGains
    low: float
    high: float


@fl.step
def _noisy_step(state: _State, measurement: Any, setpoint_n: float, gains: _Gains, dt: float) -> Any:
    own, drawn = state
    noise, told = gains[0], gains[1]
    force, position, speed, load, valid = measurement
    # Park and Miller (1988): exact in doubles; uniform from -3^(1/2) to 3^(1/2), so its rms is 1.
    drawn = (16807.0 * drawn) % 2147483647.0
    speed = speed + noise * math.sqrt(3.0) * (2.0 * drawn / 2147483647.0 - 1.0)
    after, command = limit_observer_step(own, fl.Measurement(force, position, speed, load, valid), setpoint_n, told, dt)
    return _State(after, drawn), command


def _gains(controller: UntoldController) -> _Gains:
    told = limit_observer_gains(controller)
    return _Gains(controller.speed_noise_m_s, told, told.low, told.high)


fl.register(
    fl.Law("untold", _noisy_step, _State, _Gains, _gains, lambda c: _State(limit_observer_start(c), 1.0)),
    UntoldController,
)


def rows(count: int, people: int, margins: int) -> Iterator[list[Any]]:
    """Yield the rows of the table."""
    strokes = list(conditions(margins, speeds=SPEEDS_MM_S))
    for name, own in CASES.items():
        runs, more = campaign(count, people, {}, {"controller.kind": "untold", **own}), []
        for each in strokes:
            there: Any = each.system
            law = {**limit_observer(there.finger.slip_length_um), "controller.kind": "untold", **own}
            more.append([peaks_as_run(there.evolve(law), one, LEARNT)[0] for one in each.people])
        loudest, rang = max(run.rms_n for run in runs), sum(run.excess > 1.0 for run in runs)
        ms = [max(peaks) for peaks in more]
        yield [
            name, len(runs), rang, f"{max(run.excess for run in runs):.2f}", f"{1e3 * loudest:.1f}",
            f"{min(ms):.2f} to {max(ms):.2f}",
        ]  # fmt: skip


def main(count: int = 20, people: int = 100, margins: int = 100) -> None:
    """Write the table."""
    heads = ["what differs", "runs", "rang", "largest excess", "loudest window, mN", "largest Ms"]
    keep("untold", f"untold {count} {people} {margins}", heads, rows(count, people, margins))


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
