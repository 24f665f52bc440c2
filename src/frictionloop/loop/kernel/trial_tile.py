"""The trials of an oracle: what would come of a command, and which to try next."""

from __future__ import annotations

from typing import Any

from frictionloop.loop.kernel.access import peek, poke
from frictionloop.loop.kernel.aim_tile import (
    COMMAND,
    COMMAND_BEFORE,
    ERROR,
    ERROR_BEFORE,
    LAST,
    SETPOINT,
    SLOPE,
    drive_step,
)
from frictionloop.loop.kernel.motion_tile import NEXT
from frictionloop.loop.kernel.slab import COUNT, ROW
from frictionloop.loop.kernel.tiles import Lifting
from frictionloop.quantities.arithmetic import fma

FLAT_N_PER_UM = -1e-9
"""Slope of the force with the command where a trial shows none: the drive then goes to its end."""
PROBE = 0.05
"""Share of the drive's range by which the second trial differs from the first."""
COEFFICIENTS = COUNT["trial_coefficients"]
"""Rows from ``contact_coefficients`` to ``plate_coefficients``."""


def lift_copy(lifting: Lifting) -> Any:
    """Return the tile that copies some rows in sequence."""
    width, compiled, count = lifting

    @compiled
    def copy(s, n, source, target, many):  # type: ignore[no-untyped-def]
        for row in range(many):
            for i in range(count(n)):
                poke(s, (target + row) * width + i, peek(s, (source + row) * width + i))

    return copy


def lift_trials(lifting: Lifting, finger: Any, copy: Any) -> Any:
    """Return the tile that tries commands on the state there is and leaves the one to give in ``trial``."""
    width, compiled, count = lifting
    attempt, improve = _build_attempt(lifting, finger, copy), _build_improve(lifting)
    start, amplitude, contact = ROW["trial_start"], ROW["amplitude"], ROW["contact"]
    own, coarse = ROW["contact_coefficients"], ROW["trial_coefficients"]

    @compiled
    def swap(s, n):  # type: ignore[no-untyped-def]
        for row in range(COEFFICIENTS):
            for i in range(count(n)):
                value = peek(s, (own + row) * width + i)
                poke(s, (own + row) * width + i, peek(s, (coarse + row) * width + i))
                poke(s, (coarse + row) * width + i, value)

    @compiled
    def search(s, n, o):  # type: ignore[no-untyped-def]
        copy(s, n, amplitude, start, 1)
        copy(s, n, contact, start + 1, 4)
        swap(s, n)
        for trials in range(o.trials):
            attempt(s, n, o)
            improve(s, n, trials == 0)
        swap(s, n)

    return search


def _build_attempt(lifting: Lifting, finger: Any, copy: Any) -> Any:
    width, compiled, count = lifting
    trial, start, decay = ROW["trial"], ROW["trial_start"], ROW["trial_decay"]
    own, contact = ROW["contact_coefficients"], ROW["contact"]
    amplitude, applied = ROW["amplitude"], ROW["applied"]

    @compiled
    def hold(s, n):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            c = peek(s, (trial + COMMAND) * width + i)
            poke(s, applied * width + i, c)
            poke(s, (applied + 1) * width + i, c)

    @compiled
    def land(s, n):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            a, last = peek(s, amplitude * width + i), peek(s, (trial + LAST) * width + i)
            c = drive_step(a, last, peek(s, decay * width + i))
            poke(s, applied * width + i, c)
            poke(s, (applied + 1) * width + i, c)

    @compiled
    def attempt(s, n, o):  # type: ignore[no-untyped-def]
        copy(s, n, start, amplitude, 1)
        copy(s, n, start + 1, contact, 4)
        hold(s, n)
        # A clairvoyant takes motion and limit to go on for one period more, and then to stay.
        steps, last = o.steps, 2 * o.steps - 1
        for j in range((1 + o.landing) * steps):
            if (j > 0) & (j % steps == 0):
                land(s, n)
            finger(s, n, float(min(j, last)), float(steps))
        for i in range(count(n)):
            along = peek(s, NEXT.direction * width + i) * peek(s, (own + 6) * width + i)
            error = fma(along, peek(s, (contact + 2) * width + i), -peek(s, (trial + SETPOINT) * width + i))
            poke(s, (trial + ERROR) * width + i, error)

    return attempt


def _build_improve(lifting: Lifting) -> Any:
    width, compiled, count = lifting
    trial, ceiling, saturated = ROW["trial"], ROW["max_amplitude"], ROW["saturated"]

    @compiled
    def improve(s, n, begins):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            c, error = peek(s, (trial + COMMAND) * width + i), peek(s, (trial + ERROR) * width + i)
            c_0, error_0 = peek(s, (trial + COMMAND_BEFORE) * width + i), peek(s, (trial + ERROR_BEFORE) * width + i)
            top = peek(s, ceiling * width + i)
            moved = c != c_0
            slope = (error - error_0) / (c - c_0 if moved else 1.0)
            slope = slope if moved else peek(s, (trial + SLOPE) * width + i)
            # The first slope is found by a small move towards the set-point; then secants.
            slope = FLAT_N_PER_UM if begins else min(slope, FLAT_N_PER_UM)
            wanted = c - error / slope
            wanted = c + (PROBE if error > 0.0 else -PROBE) * top if begins else wanted
            poke(s, (trial + SLOPE) * width + i, slope)
            poke(s, (trial + COMMAND_BEFORE) * width + i, c)
            poke(s, (trial + ERROR_BEFORE) * width + i, error)
            poke(s, (trial + COMMAND) * width + i, min(max(wanted, 0.0), top))
            poke(s, saturated * width + i, 1.0 if (wanted < 0.0) | (wanted > top) else 0.0)

    return improve
