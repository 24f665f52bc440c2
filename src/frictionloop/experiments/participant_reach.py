"""The participant's own reach in a session: measured before and after, kept in the log, and what follows from it."""

from __future__ import annotations

from pathlib import Path

import pandas  # type: ignore[import-untyped]

from frictionloop.experiments.levels_within_reach import fitted
from frictionloop.experiments.measured_finger import MeasuredFinger
from frictionloop.experiments.protocol import Protocol
from frictionloop.experiments.respondent import Respondent
from frictionloop.experiments.session_folder import Folder, logged, now, read_session, sessions_in
from frictionloop.experiments.trial_loop import Engine, guided
from frictionloop.parameters import System, write_toml
from frictionloop.quantities import FrictionloopError

EVENT = "reach"
"""Name in the log."""
COLUMNS = ["participant", "when", "low_n", "high_n", "susceptibility_per_um2", "growth_per_s"]
FINGER = "finger.toml"
"""Bench with what the strokes tell of the finger, in the folder of a session: a design takes its gain spread."""


def own_reach(kept: Folder, engine: Engine, shown: Respondent, system: System, seed: int) -> tuple[Protocol, System]:
    """Return protocol and system as they are for this participant's finger; a session that goes on has its first reach.

    Two plain strokes tell the friction without and with the largest vibration. The controller then believes these, and
    levels out of reach are drawn together, refused or left (`Protocol.out_of_reach`). All of that is in the log.

    Parameters
    ----------
    kept : Folder
        The session.
    engine : Engine
        What presents.
    shown : Respondent
        Who is told that plain strokes come.
    system : System
        Bench, and finger if it is simulated.
    seed : int
        Seed of the strokes' noise.

    Raises
    ------
    FrictionloopError
        For a finger that cannot be given the forces, or a stroke of which nothing is scored.
    """
    if not kept.protocol.fit_to_finger:
        return kept.protocol, system
    first = next((told for told in kept.logged(EVENT) if told.get("when") == "before"), None)
    if first is None:
        shown.plain("before")
        finger = engine.reach(_plain(system, kept.protocol, engine), seed)
        kept.log(EVENT, time=now(), when="before", **finger.row)
        for name, value in finger.changes.items():
            kept.log("adjusted", time=now(), what=name, value=value, why="own reach")
        write_toml(system.evolve(finger.changes), kept.path / FINGER, given=finger.changes)
    else:
        finger = MeasuredFinger.of(first)
    plan, factor = fitted(kept.protocol, finger.reach)
    if first is None and factor < 1.0:
        kept.log("adjusted", time=now(), what="levels", factor=factor, extremes=plan.method.extremes(), why="own reach")
        shown.fitted(factor)
    return plan, system.evolve(finger.changes)


def reach_after(kept: Folder, engine: Engine, shown: Respondent, system: System, seed: int) -> None:
    """Measure the reach again at the end and keep it in the log; that it could not be measured is kept as well."""
    if not kept.protocol.fit_to_finger or any(told.get("when") == "after" for told in kept.logged(EVENT)):
        return
    shown.plain("after")
    try:
        finger = shown.finger(system, len(kept.rows))
        found = engine.reach(_plain(finger, kept.protocol, engine), seed)
        kept.log(EVENT, time=now(), when="after", **found.row)
    except FrictionloopError as error:
        kept.log(EVENT, time=now(), when="after", why=str(error))


def reaches(path: Path) -> pandas.DataFrame:
    """Return what each participant's finger could be given before and after, from the logs of sessions.

    Columns participant, when, low_n, high_n, susceptibility_per_um2, growth_per_s; no rows where none measured.
    """
    rows = []
    for each in sessions_in(path):
        participant = read_session(each)[2]["participant"]
        for told in logged(each):
            if told["event"] == EVENT and "high_n" in told:
                rows.append({"participant": participant} | told)
    return pandas.DataFrame(rows, columns=COLUMNS)


def _plain(system: System, protocol: Protocol, engine: Engine) -> System:
    """Return the system for plain strokes: a simulated bench moves as it does by itself, a device by the guide."""
    return system if engine.source == "simulated" else guided(system, protocol)
