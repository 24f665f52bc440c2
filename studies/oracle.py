"""The oracle: a reference that knows the plant, and tries commands on it by the very step that will advance it.

An amplitude a* at the end of its period would put the friction limit onto the set-point. Where the force follows its
limit at once (no skin or no length) the overdriven plate gets there, and this is the command. Else it is late, and it
looks for the command after which, the amplitude driven back to a* from the next period on, the force is at the
set-point. Where the drive is strong enough that takes two periods: force and limit arrive together, and nothing rings.
*pages/limits-of-control.md* says what its figure is worth.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple
from unittest.mock import patch

from frictionloop.control.laws import law_of
from frictionloop.loop import simulate, sweep
from frictionloop.loop.kernel.law_tile import build_law
from frictionloop.loop.kernel.loop import Tile
from frictionloop.loop.kernel.lower_blocks import contact_of_step
from frictionloop.loop.kernel.lowering import lower
from frictionloop.loop.kernel.signal_generation import lift_spread
from frictionloop.loop.kernel.slab import ROW, vibration_rows
from frictionloop.loop.kernel.slab_access import doubles, load
from frictionloop.loop.kernel.step_lifting import Lifting, compiled_tile, lift, same_step
from frictionloop.loop.kernel.tile_compatibility import contact_of
from frictionloop.parameters import LookupController, System
from frictionloop.physics.bristle_contact import ContactCoefficients, ContactState
from frictionloop.physics.finger_step import FORCES, Motion, limits_of, substep_of
from frictionloop.physics.limit_scaling import AgeingCoefficients, aged_step
from frictionloop.physics.plate import PlateCoefficients, plate_coefficients
from frictionloop.physics.vibration import Vibration, inverse_of, vibration_of
from frictionloop.quantities import flat_tuples
from frictionloop.quantities.counter_noise import BLOCK
from frictionloop.quantities.scalar_math import exp2, fma, step

STEPS, LANDING, TRIALS = 4, 8, 3
"""Of a trial; more of any changes the residual on fingers(100, 3) by less than 0.1 mN."""
FLAT_N_PER_UM = -1e-9
"""Slope of the force with the command where a trial shows none: the drive then goes to its end."""
STAND_IN: dict[str, Any] = {"controller.kind": "lookup", "controller.overdrive": True}
"""Overrides of the law in whose place the oracle decides."""
PROBE = 0.05
"""Share of the drive's range by which the second trial differs from the first."""


class Finger(NamedTuple):
    """What a substep advances."""

    amplitude_um: float
    contact: ContactState


class Plant(NamedTuple):
    """What the oracle knows at t_k; ``after`` is t_k+1, or t_k again where all is taken to stay as it is."""

    now: Motion
    after: Motion
    switch: float
    ceiling_um: float
    limit_n: float
    ageing: AgeingCoefficients
    decay: float  # of the amplitude over a period
    own: Any  # coefficients of plate and contact, for a period's substeps
    coarse: Any  # for a trial's
    effect: Any  # coefficients of the friction law


class Trial(NamedTuple):
    """What is to be tried, and what the trial before has shown."""

    wanted_n: float
    last_um: float  # with which the landing ends: a*
    command_um: float
    saturated: float
    before_um: float
    error_before_n: float
    slope: float  # of the force with the command, N/um


class Own(NamedTuple):
    """The oracle's numbers of a lane, in the rows of the law in whose place it stands."""

    wanted: float
    ahead: Finger  # when the command takes effect
    tried: Finger
    trial: Trial
    plate: PlateCoefficients  # of a trial's substeps
    coarse: ContactCoefficients
    decay: float


OWN: Any = flat_tuples.shaped(Own, ROW["law"])
OLD, NEW = ROW["applied"]


@step
def drive_step(amplitude_um: float, wanted_um: float, decay: float) -> float:
    """(a_w - p a)/(1 - p): the command, which the drive may not reach, that takes the plate there in one period."""
    return fma(-decay, amplitude_um, wanted_um) / (1.0 - decay)


@step
def bounded_step(wanted_um: float, ceiling_um: float) -> tuple[float, float]:
    """The command that the drive can give, and 1 if it is another."""
    given_um = min(max(wanted_um, 0.0), ceiling_um)
    return given_um, 1.0 if given_um != wanted_um else 0.0


@step
def told_step(trial: Trial, log2_nominal: float, halving: float) -> tuple[float, float, float]:
    """Command, whether it is another than wanted, and the force that the model expects of it."""
    return trial.command_um, trial.saturated, exp2(log2_nominal - trial.command_um * trial.command_um / halving)


def advance_of(contact: str, vibration: Vibration) -> Any:
    """Return ``advance(j, of, finger, old_um, new_um, plant, stride)``: the finger after substep j of a period."""
    substep = substep_of(contact, vibration)

    @step
    def advance(j, of, finger, old_um, new_um, plant, stride):  # type: ignore[no-untyped-def]
        drive = old_um, new_um, plant.switch, plant.ceiling_um, finger.amplitude_um, stride[0]
        limit = plant.effect, plant.limit_n, plant.ageing
        a, state, _ = substep(j, of, plant.now, plant.after, *drive, *limit, finger.contact, stride[1])
        return Finger(a, state)

    return advance


def begin_of(vibration: Vibration) -> Any:
    """Return ``begin(ahead, finger, signals, plant)``: the first trial, of the amplitude whose limit is the set-point.

    With it come finger and command with which it starts. ``signals`` are set-point, disturbance and the disturbance
    later; ``ahead`` says how far beyond now, in the time to later, the line through both is followed.
    """
    inverse = inverse_of(vibration)

    @step
    def aim(fraction, finger, wanted_n, plant):  # type: ignore[no-untyped-def]
        now, after, ceiling_um = plant.now, plant.after, plant.ceiling_um
        factor = max(fma(fraction, after.factor - now.factor, now.factor), 0.0)
        limit_n = plant.limit_n * factor * aged_step(finger.contact.age_s, plant.ageing)
        return min(inverse(limit_n, wanted_n, now.occluded, ceiling_um, plant.effect), ceiling_um)

    @step
    def begin(ahead, finger, signals, plant):  # type: ignore[no-untyped-def]
        setpoint_n, disturbance_n, later_n = signals
        wanted_n = setpoint_n - fma(ahead, later_n - disturbance_n, disturbance_n)
        first_um, last_um = aim(1.0, finger, wanted_n, plant), aim(2.0 - 0.5 / STEPS, finger, wanted_n, plant)
        command_um, saturated = bounded_step(drive_step(finger.amplitude_um, first_um, plant.decay), plant.ceiling_um)
        return Trial(wanted_n, last_um, command_um, saturated, command_um, 0.0, FLAT_N_PER_UM), finger, command_um

    return begin


def improve_of(contact: str, vibration: Vibration) -> Any:
    """Return ``improve(begins, start, finger, trial, plant)``: the next trial, near the first, then by secants."""
    limits_at, force_at = limits_of(vibration), FORCES[contact]

    @step
    def improve(begins, start, finger, trial, plant):  # type: ignore[no-untyped-def]
        after, state, given = plant.after, finger.contact, plant.coarse[1]
        um = finger.amplitude_um, plant.ceiling_um, plant.effect
        _, _, limit_n = limits_at(plant.limit_n, after, *um, state.age_s, plant.ageing)
        error_n = after.direction * force_at(limit_n, after, state, given) - trial.wanted_n
        command_um, moved_um = trial.command_um, trial.command_um - trial.before_um
        slope = (error_n - trial.error_before_n) / (moved_um if moved_um != 0.0 else 1.0)
        slope = min(slope, FLAT_N_PER_UM) if moved_um != 0.0 else trial.slope
        probe_um = command_um + (PROBE if error_n > 0.0 else -PROBE) * plant.ceiling_um
        next_um, saturated = bounded_step(probe_um if begins else command_um - error_n / slope, plant.ceiling_um)
        if plant.own[1].length == 0.0:  # the force is its limit, at which the first trial aims
            next_um, saturated = command_um, trial.saturated
        return Trial(trial.wanted_n, trial.last_um, next_um, saturated, command_um, error_n, slope), start, next_um

    return improve


def build_oracle(lifting: Lifting, contact: str, vibration: Vibration, preview: bool) -> Any:
    """Return the tile that decides as an oracle; with ``preview`` it knows motion and signals of t_k+1."""
    given = ROW["switch"], ROW["max_amplitude"], ROW["limit_n"], ROW["ageing"], OWN.decay
    own, coarse = (ROW["plate_coefficients"], ROW["contact_coefficients"]), (OWN.plate, OWN.coarse)
    after = ROW["motion_next" if preview else "motion"]
    plant = Plant(ROW["motion"], after, *given, own, coarse, vibration_rows(vibration))
    advance, signals = advance_of(contact, vibration), (OWN.wanted, ROW["disturbance"], ROW["driven"])
    spread, tried = lift_spread(lifting), (OWN.trial, OWN.tried, OLD)
    trials = TRIALS if contact == "bristle" else 0  # whose force follows its limit late
    start = lift(lifting, same_step, (Finger(ROW["amplitude"], ROW["contact"]),), OWN.ahead)
    forward = lift(lifting, advance, (OWN.ahead, OLD, NEW, plant, plant.own), OWN.ahead)
    begin = lift(lifting, begin_of(vibration), (OWN.ahead, signals, plant), tried)
    attempt = lift(lifting, advance, (OWN.tried, OLD, OLD, plant, plant.coarse), OWN.tried)
    land = lift(lifting, drive_step, (OWN.tried.amplitude_um, OWN.trial.last_um, OWN.decay), OLD)
    improve = lift(lifting, improve_of(contact, vibration), (OWN.ahead, OWN.tried, OWN.trial, plant), tried)
    tell = lift(lifting, told_step, (OWN.trial, *ROW["model"][:2]), (ROW["command"], ROW["saturated"], ROW["u"]))
    (wanted, _, later), delay, switch, lanes = signals, ROW["delay_periods"], ROW["timing"][0], lifting.width

    @lifting.compiled
    def oracle(s, n, k, at, o):  # type: ignore[no-untyped-def]
        # A clairvoyant's signals are those of t_k+1: the next sample of the set-point, if its block is drawn, and the
        # disturbance on a line through t_k and the middle of the last substep.
        ahead = o.segments / (o.segments - 0.5) if preview else 0.0
        spread(s, n, wanted, doubles(o.setpoint), min(at + 1, BLOCK - 1) if preview else at, o.setpoint_shared)
        spread(s, n, later, doubles(o.disturbance), o.segments * BLOCK + at, o.disturbance_shared)
        # Under the commands in force, until the one to decide takes effect; the delay is the same in all lanes.
        history, segments, late = doubles(o.history), o.segments, int(load(s, 0, lanes, delay))
        start(s, n)
        for j in range(late * segments + round(load(s, 0, lanes, switch) * segments)):
            since = k + j // segments - late
            spread(s, n, OLD, history, (since - 1) & o.ring_mask, False)
            spread(s, n, NEW, history, since & o.ring_mask, False)
            forward(s, n, float(j % segments), float(segments))
        begin(s, n, ahead)
        for trial in range(trials):
            for j in range((1 + LANDING) * STEPS):
                if (j > 0) & (j % STEPS == 0):
                    land(s, n)
                # Motion and limit are taken to go on for one period more, and then to stay.
                attempt(s, n, float(min(j, 2 * STEPS - 1)), float(STEPS))
            improve(s, n, trial == 0)
        tell(s, n)

    return oracle


@contextmanager
def deciding(preview: bool = False) -> Iterator[dict[str, Any]]:
    """Let simulations, sweeps and comparisons of a bench run the oracle where these overrides are in force.

    Without ``preview`` limit, speed, disturbance and set-point are taken to stay as they are. With it those at the end
    of the period in which the command is in force are known, and a delay does not matter.
    """

    def lowered(systems: Sequence[System], seeds: Sequence[int], **options: Any) -> Tile:
        tile, first = lower(systems, seeds, **options), systems[0]
        law, width = first.controller, tile.slab.width
        if isinstance(law, LookupController) and law.overdrive and tile.kernel == "substeps":
            plant = contact_of(first), vibration_of(first.friction)
            replaced = compiled_tile(width, build_law, law_of(law), tile.shared.table_size > 0)
            decides = compiled_tile(width, build_oracle, *plant, preview)
            tile.shared.program("ticks", [decides if each == replaced else each for each in tile.shared.kept["ticks"]])
            tile.slab.fill(_numbers, [*systems, *[systems[-1]] * (width - len(systems))])
        return tile

    with patch.object(simulate, "lower", lowered), patch.object(sweep, "lower", lowered):
        yield STAND_IN | ({"controller.delay_s": 0.0} if preview else {})


def _numbers(system: System) -> dict[Any, Any]:
    period_s, h = 1.0 / system.controller.rate_hz, 1.0 / (STEPS * system.controller.rate_hz)
    whole, plate = (plate_coefficients(system.plate, each) for each in (period_s, h))
    return {OWN.plate: plate, OWN.coarse: contact_of_step(system, h), OWN.decay: whole.whole}
