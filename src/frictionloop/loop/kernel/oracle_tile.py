"""The tile of the oracle: it tries commands on the true plant, by the very tile that will advance it.

From the true state at t_k it runs the finger under the commands in force until its own takes effect. An amplitude a* at
the end of its period would put the friction limit onto the set-point. Where the force follows its limit at once (rigid,
slider) the overdriven plate gets there, and this is the command. A bristle follows late: there it looks for the command
after which, the amplitude driven back to a* from the next period on, the force is at the set-point. Where the drive is
strong enough that takes two periods: force and limit arrive together, and nothing rings (docs/oracle).
"""

from __future__ import annotations

from typing import Any

from frictionloop.loop.kernel.access import doubles, peek, poke
from frictionloop.loop.kernel.aim_tile import COMMAND, lift_aim
from frictionloop.loop.kernel.finger_tile import lift_finger
from frictionloop.loop.kernel.slab import ROW
from frictionloop.loop.kernel.tiles import Lifting
from frictionloop.loop.kernel.traces import lift_spread
from frictionloop.loop.kernel.trial_tile import lift_copy, lift_trials
from frictionloop.physics.vibration import Vibration
from frictionloop.quantities.arithmetic import exp2


def build_oracle(lifting: Lifting, contact: str, vibration: Vibration) -> Any:
    """Return the tile that decides as an oracle."""
    width, compiled, count = lifting
    finger, copy = lift_finger(lifting, contact, vibration), lift_copy(lifting)
    want, aim = lift_aim(lifting, lift_spread(lifting), vibration)
    search, searches = lift_trials(lifting, finger, copy), contact in ("dahl", "lugre")
    kept, trial, applied, command = ROW["trial_kept"], ROW["trial"], ROW["applied"], ROW["command"]
    now, after, contact_row, amplitude = ROW["motion"], ROW["motion_next"], ROW["contact"], ROW["amplitude"]
    model, u_row = ROW["model"], ROW["u"]

    @compiled
    def predict(s, n, k, o):  # type: ignore[no-untyped-def]
        history = doubles(o.history)
        for j in range(o.predicted):
            since = k + j // o.segments - o.late
            for i in range(count(n)):
                poke(s, applied * width + i, peek(history, ((since - 1) & o.ring_mask) * width + i))
                poke(s, (applied + 1) * width + i, peek(history, (since & o.ring_mask) * width + i))
            finger(s, n, float(j % o.segments), float(o.segments))

    @compiled
    def oracle(s, n, k, at, o):  # type: ignore[no-untyped-def]
        copy(s, n, amplitude, kept, 1)
        copy(s, n, contact_row, kept + 1, 4)
        copy(s, n, after, kept + 5, 7)
        if o.preview == 0:
            copy(s, n, now, after, 7)
        predict(s, n, k, o)
        want(s, n, at, o)
        aim(s, n, o)
        if searches:
            search(s, n, o)
        copy(s, n, kept, amplitude, 1)
        copy(s, n, kept + 1, contact_row, 4)
        copy(s, n, kept + 5, after, 7)
        for i in range(count(n)):
            c = peek(s, (trial + COMMAND) * width + i)
            poke(s, command * width + i, c)
            poke(s, u_row * width + i, exp2(peek(s, model * width + i) - c * c / peek(s, (model + 1) * width + i)))

    return oracle
