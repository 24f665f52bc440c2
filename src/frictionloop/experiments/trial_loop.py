"""Running a session: present strokes, on the simulated bench here or a device, ask, judge and make the row."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple
from typing import Protocol as Interface

import xarray as xr

from frictionloop.experiments.measured_finger import MeasuredFinger, simulated_finger
from frictionloop.experiments.protocol import Protocol
from frictionloop.experiments.respondent import Live, Presented, Respondent, Response
from frictionloop.experiments.trial_records import MEASURED, delivered_level, force_of, measures, scored, why_invalid
from frictionloop.experiments.trial_sequence import Trial, TrialOrder
from frictionloop.experiments.trial_structure import Timeline
from frictionloop.loop.kernel.lane_grouping import tiles_of
from frictionloop.loop.kernel.tile_compatibility import structure
from frictionloop.loop.parallel_runs import shared_out, worker_count
from frictionloop.loop.simulate import traced
from frictionloop.parameters import System
from frictionloop.parameters.motion import Strokes
from frictionloop.quantities import FrictionloopError
from frictionloop.rendering.effect_setpoint import EffectSource

SHOWN_S = 0.03
"""How often a stroke that goes on is shown (assumed: 30 times a second)."""


class Stroke(NamedTuple):
    """One stroke to present: the system with its effect and its motion, how long, and the seed of all noise."""

    system: System
    duration_s: float
    seed: int


class Engine(Interface):
    """What presents strokes and tells the time."""

    source: str
    """simulated, or device."""

    def present(self, strokes: Sequence[Stroke], timeline: Timeline, shown: Respondent) -> list[Presented]:
        """Present the strokes of a trial one after the other, with cue and gaps, and return what was recorded."""
        ...

    def answered(self, response: Response, presented: Sequence[Presented]) -> tuple[Response, float]:
        """Return an answer with its time on the device clock, and by how much clocks have jumped meanwhile, s."""
        ...

    def reach(self, system: System, seed: int) -> MeasuredFinger:
        """Return what the finger can be given, by plain strokes."""
        ...

    def close(self) -> None:
        """Let go of the device."""
        ...


class BenchEngine:
    """The simulated bench: a clock that is counted."""

    source = "simulated"

    def __init__(self, time_s: float = 0.0) -> None:
        self.time_s = time_s

    def present(self, strokes: Sequence[Stroke], timeline: Timeline, shown: Respondent) -> list[Presented]:
        """Simulate the strokes of a trial; for a person in the time that a device takes."""
        runs = simulated(strokes, 1)
        for interval, (run, stroke) in enumerate(zip(runs, strokes, strict=True), 1):
            if shown.paced:
                time.sleep(timeline.cue_s if interval == 1 else timeline.gap_s)
            shown.cued(interval, stroke.duration_s)
            if shown.paced:
                _show(run, interval, stroke.duration_s, shown)
            shown.stroked(interval, run)
        return self.timed(runs, strokes, timeline)

    def timed(self, runs: Sequence[xr.Dataset], strokes: Sequence[Stroke], timeline: Timeline) -> list[Presented]:
        """Return the runs of a trial's strokes with their times, and count on."""
        found: list[Presented] = []
        for run, stroke in zip(runs, strokes, strict=True):
            onset = self.time_s + (timeline.gap_s if found else timeline.cue_s)
            self.time_s = onset + stroke.duration_s
            found.append(Presented(run, onset, self.time_s))
        return found

    def answered(self, response: Response, presented: Sequence[Presented]) -> tuple[Response, float]:
        """Count on."""
        self.time_s += max(response.rt_s, 0.0)
        return response, 0.0

    def reach(self, system: System, seed: int) -> MeasuredFinger:
        """Return that of the simulated finger."""
        return simulated_finger(system, seed)

    def close(self) -> None:
        """Do nothing: there is nothing to let go of."""


def _show(run: xr.Dataset, interval: int, duration_s: float, shown: Respondent) -> None:
    """Show a run as it would come from a device."""
    start = time.monotonic()
    force = run[force_of(run)].values
    while (elapsed := time.monotonic() - start) < duration_s:
        k = min(int(elapsed / duration_s * force.size), force.size - 1)
        setpoint, speed, load = (float(run[name].values[k]) for name in ("f_r", "speed", "load"))
        shown.live(Live(interval, elapsed, float(force[k]), setpoint, 1e3 * speed, load))
        time.sleep(SHOWN_S)


def simulated(strokes: Sequence[Stroke], n_jobs: int | None = None) -> list[xr.Dataset]:
    """Return the runs of strokes: those of one structure and duration as lanes of a tile, tiles over threads."""
    keys = [(structure(each.system), each.duration_s) for each in strokes]
    tiles = list(tiles_of(keys, range(len(strokes))))
    found: dict[int, xr.Dataset] = {}
    workers = min(worker_count(n_jobs), len(tiles))
    for lanes, runs in shared_out(_tile, (([(k, strokes[k]) for k in lanes],) for lanes in tiles), workers):
        found |= dict(zip(lanes, runs, strict=True))
    return [found[k] for k in range(len(strokes))]


def _tile(strokes: list[tuple[int, Stroke]]) -> tuple[list[int], list[xr.Dataset]]:
    lanes, some = [k for k, _ in strokes], [stroke for _, stroke in strokes]
    return lanes, list(traced([each.system for each in some], [each.seed for each in some], some[0].duration_s))


class Session:
    """One participant's way through a protocol."""

    def __init__(self, protocol: Protocol, participant: str, system: System, respondent: Respondent) -> None:
        self.protocol, self.participant, self.respondent = protocol, participant, respondent
        self.order = TrialOrder(protocol, participant)
        base = system.evolve(protocol.system)
        self._systems = {each.name: base.evolve(each.system) for each in protocol.conditions}

    def replay(self, rows: Sequence[Mapping[str, Any]]) -> None:
        """Tell the rows of a session that goes on."""
        for row in rows:
            trial = self.order.next()
            if trial is None or (trial.condition.name, trial.level) != (row["condition"], row["requested"]):
                raise FrictionloopError(f"trial {row['trial']}: differs from the protocol")
            self.order.tell(row)

    def strokes(self, trial: Trial) -> list[Stroke]:
        """Return the strokes of a trial."""
        guide, found = self.protocol.timeline.stroke, []
        for interval in range(1, self.protocol.intervals + 1):
            level = trial.level if interval == trial.comparison else None
            effect = self.protocol.stimulus.at(level, trial.condition.effect)
            system = self._systems[trial.condition.name]
            system = system.model_copy(update={"setpoint": EffectSource(effect=effect), "motion": _slow(system, guide)})
            moved = self.respondent.moves(system, trial.number, interval)
            rate = system.controller.rate_hz
            found.append(Stroke(moved, round(guide.duration_s * rate) / rate, trial.seeds[interval - 1]))
        return found

    def row(self, trial: Trial, presented: list[Presented], response: Response, jump_s: float = 0.0) -> dict[str, Any]:
        """Return the row of a trial that was presented and answered; ``jump_s`` is that of clocks before the answer."""
        p, stimulus = self.protocol, self.protocol.stimulus
        asked = [stimulus.value(trial.level if k == trial.comparison else None) for k in range(1, p.intervals + 1)]
        found = [measures(each.run, p, value) for each, value in zip(presented, asked, strict=True)]
        why = [f"{said} in {k}" for k, each in enumerate(found, 1) if (said := why_invalid(each, p.validity))]
        jumps = [f"clock_jump={each:.3g}" for each in (*(part.jump_s for part in presented), jump_s) if each]
        why += jumps
        right, result = math.nan, math.nan
        if not response.response or not (0.0 <= response.rt_s <= p.timeline.response_s or jumps):
            why.append("no answer in time")
        elif response.rt_s < p.validity.least_response_s and not jumps:
            why.append(f"rt_s={response.rt_s:.2g}")
        else:
            right, result = scored(p, trial.level, trial.comparison, response.response)
        delivered = delivered_level(p, trial.level, trial.comparison, found)
        if not math.isfinite(delivered):
            why = why or ["nothing was delivered"]
        again = bool(why) and p.validity.then == "repeat" and self.order.repeats < p.validity.repeats
        row = {
            "trial": trial.number,
            "participant": self.participant,
            "condition": trial.condition.name,
            "requested": trial.level,
            "delivered": delivered,
            "onset_s": presented[0].onset_s,
            "offset_s": presented[-1].offset_s,
            "response": response.response,
            "correct": right,
            "result": result,
            "rt_s": response.rt_s,
            "rt_uncertainty_s": response.uncertainty_s,
            "valid": int(not why),
            "reason": "; ".join(why),
            "counted": int(not why and trial.phase == "main"),
            "again": int(again),
            "method_state": trial.state,
        }
        row |= {name: getattr(trial, name) for name in ("block", "phase", "track", "comparison", "repeat_of")}
        for k, each in enumerate(found, 1):
            row |= {f"{name}_{k}": getattr(each, name) for name in MEASURED}
        return row


def one(session: Session, engine: Engine, trial: Trial) -> tuple[dict[str, Any], list[xr.Dataset]]:
    """Run a trial of a session on an engine and return its row and its runs."""
    session.respondent.before(trial)
    presented = engine.present(session.strokes(trial), session.protocol.timeline, session.respondent)
    return _answered(session, engine, trial, presented), [each.run for each in presented]


def side_by_side(sessions: Sequence[Session], engines: Sequence[BenchEngine]) -> list[tuple[int, dict[str, Any]]]:
    """Run one trial of each simulated session, their strokes together, and return the row of each by its place."""
    going = [(k, trial) for k, session in enumerate(sessions) if (trial := session.order.next()) is not None]
    strokes = [sessions[k].strokes(trial) for k, trial in going]
    runs = iter(simulated([each for some in strokes for each in some]))
    found = []
    for (k, trial), some in zip(going, strokes, strict=True):
        own = [next(runs) for _ in some]
        presented = engines[k].timed(own, some, sessions[k].protocol.timeline)
        found.append((k, _answered(sessions[k], engines[k], trial, presented)))
    return found


def _answered(session: Session, engine: Engine, trial: Trial, presented: list[Presented]) -> dict[str, Any]:
    response, jump_s = engine.answered(session.respondent.respond(trial, presented), presented)
    row = session.row(trial, presented, response, jump_s)
    session.respondent.give_feedback(trial, row)
    return row


def guided(system: System, protocol: Protocol) -> System:
    """Return what a device is set up from: the protocol's system, whose finger moves by the guide."""
    base = system.evolve(protocol.system)
    return base.model_copy(update={"motion": _slow(base, protocol.timeline.stroke)})


def _slow(system: System, guide: Any) -> Strokes:
    """Return the motion of a system at the speed and over the way of a guide."""
    motion = system.motion
    if not isinstance(motion, Strokes):
        raise FrictionloopError('motion.kind: must be "strokes"')
    return motion.model_copy(
        update={
            "speed_mm_s": guide.speed_mm_s,
            "stroke_mm": guide.length_mm,
            "load_n": guide.load_n,
            "start": 0.5 if guide.direction == "back" else 0.0,
            "reversal_s": min(motion.reversal_s, 0.5 * guide.length_mm / guide.speed_mm_s),
        }
    )
