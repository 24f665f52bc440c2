"""The oracle: it tries commands on the true plant, by the very step that will advance it (docs/oracle).

An amplitude a* at the end of its period would put the friction limit onto the set-point. Where the force follows its
limit at once (rigid, slider) the overdriven plate gets there, and this is the command. A bristle follows late: there it
looks for the command after which, the amplitude driven back to a* from the next period on, the force is at the
set-point. Where the drive is strong enough that takes two periods: force and limit arrive together, and nothing rings.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from frictionloop.physics.contact import ContactCoefficients, ContactState
from frictionloop.physics.finger_step import Motion, Static, substep_of
from frictionloop.physics.friction_limit import static_step
from frictionloop.physics.plate import PlateCoefficients
from frictionloop.physics.vibration import Vibration, inverse_of
from frictionloop.quantities.arithmetic import fma, step

STEPS, LANDING, TRIALS = 4, 8, 3
"""Of a trial; more of any changes the residual on fingers(100, 3) by less than 0.1 mN (docs/oracle).

In 8 periods of 200 us the envelope of 100 Hz gets from rest to 63 % of what the drive can do.
"""
FLAT_N_PER_UM = -1e-9
"""Slope of the force with the command where a trial shows none: the drive then goes to its end."""
PROBE = 0.05
"""Share of the drive's range by which the second trial differs from the first."""


class Finger(NamedTuple):
    """What a substep advances."""

    amplitude_um: float
    contact: ContactState


class Stride(NamedTuple):
    """Coefficients of a substep of one length."""

    plate: PlateCoefficients
    contact: ContactCoefficients


class Plant(NamedTuple):
    """What the oracle knows at t_k."""

    now: Motion
    after: Motion
    """At t_k+1; that of t_k for an oracle who takes it to stay as it is."""
    switch: float
    """When in the period the command changes, 0 to 1."""
    ceiling_um: float
    limit_n: float
    static: Static
    decay: float
    """Of the amplitude over a period."""
    own: Stride
    coarse: Stride
    """Of a period's substeps, and of a trial's."""
    effect: Any
    """Coefficients of the friction law."""


class Trial(NamedTuple):
    """What is to be tried, and what the trial before has shown."""

    wanted_n: float
    """Force along the motion."""
    last_um: float
    """Amplitude with which the landing ends: a*."""
    command_um: float
    saturated: float
    """1 where the drive cannot give what is wanted."""
    before_um: float
    """Command of the trial before."""
    error_before_n: float
    slope: float
    """Of the force with the command, N/um."""


@step
def drive_step(amplitude_um: float, wanted_um: float, decay: float) -> float:
    """(a_w - p a)/(1 - p): the command, which the drive may not reach, that takes the plate there in one period."""
    return fma(-decay, amplitude_um, wanted_um) / (1.0 - decay)


@step
def bounded_step(wanted_um: float, ceiling_um: float) -> tuple[float, float]:
    """The command that the drive can give, and 1 if it is another."""
    saturated = 1.0 if (wanted_um < 0.0) | (wanted_um > ceiling_um) else 0.0
    return min(max(wanted_um, 0.0), ceiling_um), saturated


def advance_of(contact: str, vibration: Vibration) -> Any:
    """Return ``advance(j, of, finger, old_um, new_um, plant, stride)``: the finger after substep j of a period."""
    substep = substep_of(contact, vibration)

    @step
    def advance(j, of, finger, old_um, new_um, plant, stride):  # type: ignore[no-untyped-def]
        drive = old_um, new_um, plant.switch, plant.ceiling_um, finger.amplitude_um, stride.plate
        limit = plant.effect, plant.limit_n, plant.static
        a, state, _ = substep(j, of, plant.now, plant.after, *drive, *limit, finger.contact, stride.contact)
        return Finger(a, state)

    return advance


@step
def land_step(finger: Finger, trial: Trial, decay: float) -> float:
    """The command of a period of the landing."""
    return drive_step(finger.amplitude_um, trial.last_um, decay)


def begin_of(vibration: Vibration) -> Any:
    """Return ``begin(ahead, finger, signals, plant)``: the first trial, of the amplitude whose limit is the set-point.

    With it come finger and command with which it starts, as from `improve_step`. ``finger`` is as it will be when the
    command takes effect, ``signals`` set-point, disturbance and the disturbance later; ``ahead`` says how far beyond
    now, in the time to later, the line through both is followed.
    """
    inverse = inverse_of(vibration)

    @step
    def aim(fraction, finger, wanted_n, plant):  # type: ignore[no-untyped-def]
        now, after, ceiling_um = plant.now, plant.after, plant.ceiling_um
        factor = max(fma(fraction, after.factor - now.factor, now.factor), 0.0)
        slip = fma(fraction, after.speed - now.speed, now.speed) - finger.contact.lag_speed_m_s
        limit_n = plant.limit_n * factor * static_step(slip, plant.static.gain, plant.static.per_speed)
        return min(inverse(limit_n, wanted_n, now.occluded, ceiling_um, plant.effect), ceiling_um)

    @step
    def begin(ahead, finger, signals, plant):  # type: ignore[no-untyped-def]
        setpoint_n, disturbance_n, later_n = signals
        wanted_n = setpoint_n - fma(ahead, later_n - disturbance_n, disturbance_n)
        first_um, last_um = aim(1.0, finger, wanted_n, plant), aim(2.0 - 0.5 / STEPS, finger, wanted_n, plant)
        wanted_um = drive_step(finger.amplitude_um, first_um, plant.decay)
        command_um, saturated = bounded_step(wanted_um, plant.ceiling_um)
        trial = Trial(wanted_n, last_um, command_um, saturated, command_um, 0.0, FLAT_N_PER_UM)
        return trial, finger, command_um

    return begin


@step
def improve_step(
    begins: bool, start: Finger, finger: Finger, trial: Trial, plant: Plant
) -> tuple[Trial, Finger, float]:
    """The next trial, from where the finger is after one: near the first, then by secants."""
    along = plant.after.direction
    error_n = fma(along, finger.contact.force_n, -trial.wanted_n)
    command_um, moved_um = trial.command_um, trial.command_um - trial.before_um
    slope = (error_n - trial.error_before_n) / (moved_um if moved_um != 0.0 else 1.0)
    slope = min(slope, FLAT_N_PER_UM) if moved_um != 0.0 else trial.slope
    probe_um = command_um + (PROBE if error_n > 0.0 else -PROBE) * plant.ceiling_um
    wanted_um = probe_um if begins else command_um - error_n / slope
    next_um, saturated = bounded_step(wanted_um, plant.ceiling_um)
    if plant.own.contact.length == 0.0:  # the force is its limit, at which the first trial aims
        next_um, saturated = command_um, trial.saturated
    return Trial(trial.wanted_n, trial.last_um, next_um, saturated, command_um, error_n, slope), start, next_um
