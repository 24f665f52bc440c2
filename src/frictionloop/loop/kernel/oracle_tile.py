"""The tile of the oracle: predictions and trials of all lanes side by side, and the command that comes of them."""

from __future__ import annotations

from typing import Any

from frictionloop.control.oracle import (
    LANDING,
    STEPS,
    TRIALS,
    Finger,
    Plant,
    Stride,
    Trial,
    advance_of,
    begin_of,
    improve_step,
    land_step,
)
from frictionloop.loop.kernel.access import doubles, load
from frictionloop.loop.kernel.signals import lift_spread
from frictionloop.loop.kernel.slab import ROW, vibration_rows
from frictionloop.loop.kernel.tiles import Lifting, lift, same_step
from frictionloop.physics.vibration import Vibration
from frictionloop.quantities.arithmetic import exp2, step
from frictionloop.quantities.normals import BLOCK

_FINGER, _AHEAD, _TRIED = Finger(ROW["amplitude"], ROW["contact"]), ROW["ahead"], ROW["tried"]
"""The finger now, when the command takes effect, and in a trial."""
_TRIAL, _DECAY, (_OLD, _NEW) = ROW["trial"], ROW["trial_decay"], ROW["applied"]


@step
def told_step(trial: Trial, log2_nominal: float, halving: float) -> tuple[float, float, float]:
    """Command, whether it is another than wanted, and the force that the model expects of it."""
    c = trial.command_um
    return c, trial.saturated, exp2(log2_nominal - c * c / halving)


def build_oracle(lifting: Lifting, contact: str, vibration: Vibration, preview: bool) -> Any:
    """Return the tile that decides as an oracle; with ``preview`` it knows motion and signals of t_k+1."""
    now, drive = ROW["motion"], (ROW["switch"], ROW["max_amplitude"], ROW["limit_n"], ROW["static"], _DECAY)
    own, coarse = Stride(ROW["plate_coefficients"], ROW["contact_coefficients"]), ROW["trial_stride"]
    after, spread = ROW["motion_next"] if preview else now, lift_spread(lifting)
    plant = Plant(now, after, *drive, own, coarse, vibration_rows(vibration))
    advance, signals = advance_of(contact, vibration), (ROW["wanted"], ROW["disturbance"], ROW["driven"])
    (wanted, _, later), tried, searches = signals, (_TRIAL, _TRIED, _OLD), contact == "bristle"
    predict = _lift_predict(lifting, advance, plant)
    begin = lift(lifting, begin_of(vibration), (_AHEAD, signals, plant), tried)
    attempt = lift(lifting, advance, (_TRIED, _OLD, _OLD, plant, plant.coarse), _TRIED)
    land = lift(lifting, land_step, (_TRIED, _TRIAL, _DECAY), _OLD)
    improve = lift(lifting, improve_step, (_AHEAD, _TRIED, _TRIAL, plant), tried)
    tell = lift(lifting, told_step, (_TRIAL, *ROW["model"][:2]), (ROW["command"], ROW["saturated"], ROW["u"]))

    @lifting.compiled
    def oracle(s, n, k, at, o):  # type: ignore[no-untyped-def]
        # A clairvoyant's signals are those of t_k+1: the next sample of the set-point, if its block is drawn, and the
        # disturbance on a line through t_k and the middle of the last substep.
        ahead = o.segments / (o.segments - 0.5) if preview else 0.0
        spread(s, n, wanted, doubles(o.setpoint), min(at + 1, BLOCK - 1) if preview else at, o.setpoint_shared)
        spread(s, n, later, doubles(o.disturbance), o.segments * BLOCK + at, o.disturbance_shared)
        predict(s, n, k, o)
        begin(s, n, ahead)
        for trial in range(TRIALS if searches else 0):
            for j in range((1 + LANDING) * STEPS):
                if (j > 0) & (j % STEPS == 0):
                    land(s, n)
                # Motion and limit are taken to go on for one period more, and then to stay.
                attempt(s, n, float(min(j, 2 * STEPS - 1)), float(STEPS))
            improve(s, n, trial == 0)
        tell(s, n)

    return oracle


def _lift_predict(lifting: Lifting, advance: Any, plant: Any) -> Any:
    """Return what runs the finger under the commands in force until the one to decide takes effect."""
    start = lift(lifting, same_step, (_FINGER,), _AHEAD)
    forward = lift(lifting, advance, (_AHEAD, _OLD, _NEW, plant, plant.own), _AHEAD)
    spread, delay, switch, lanes = lift_spread(lifting), ROW["delay_periods"], ROW["timing"][0], lifting.width

    @lifting.compiled
    def predict(s, n, k, o):  # type: ignore[no-untyped-def]
        start(s, n)
        # The delay is the same in all lanes.
        history, segments, late = doubles(o.history), o.segments, int(load(s, 0, lanes, delay))
        for j in range(late * segments + round(load(s, 0, lanes, switch) * segments)):
            since = k + j // segments - late
            spread(s, n, _OLD, history, (since - 1) & o.ring_mask, False)
            spread(s, n, _NEW, history, since & o.ring_mask, False)
            forward(s, n, float(j % segments), float(segments))

    return predict
