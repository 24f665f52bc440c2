"""One session on an engine, kept in its folder; it can be killed at any moment and goes on from there."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from itertools import islice
from pathlib import Path
from typing import Any

from frictionloop.device.errors import DeviceError
from frictionloop.experiments import session_folder
from frictionloop.experiments.lsl import Streams
from frictionloop.experiments.participant_reach import own_reach, reach_after
from frictionloop.experiments.protocol import Protocol
from frictionloop.experiments.respondent import Respondent
from frictionloop.experiments.session_folder import GIVEN_UP, RAW, TABLE, Folder, now
from frictionloop.experiments.simulated_participant import SimulatedParticipant
from frictionloop.experiments.study_run import about, hash_of, study_system
from frictionloop.experiments.trial_loop import BenchEngine, Engine, Session, guided, one
from frictionloop.experiments.trial_sequence import MOST_MARKED
from frictionloop.findings import Finding, Result
from frictionloop.parameters import System
from frictionloop.physics.fingers import fingers
from frictionloop.quantities import FrictionloopError

BENCH = "bench:"
"""Address of the simulated bench."""


class Ran(Result, schema="experiments.run/1"):
    """A session as its folder keeps it."""

    folder: Path
    participant: str
    trials: int
    counted: int
    levels_factor: float
    """Share of their range to which levels were drawn together for this finger's reach."""
    given_up: Mapping[str, int]
    """Conditions that ended because too many trials did not count: how many."""

    def rows(self) -> list[tuple[str, str]]:
        """Return how many trials there are, and the command that reports on them."""
        return [
            ("trials", f"{self.trials}, of which {self.counted} count: {self.folder / TABLE}"),
            ("report", f"frictionloop experiment report {self.folder} --out {self.folder.name}.html"),
        ]


def ran(path: Path) -> Ran:
    """Return what the folder of a session keeps."""
    rows, events = session_folder.rows_of(path), list(session_folder.logged(path))
    factors = [float(each["factor"]) for each in events if isinstance(each.get("factor"), float)]
    given_up = {each["condition"]: int(each["marked"]) for each in events if each["event"] == GIVEN_UP}
    found = [Finding("STUDY-GIVEN-UP", value=marked, more={"condition": name}) for name, marked in given_up.items()]
    found += [Finding("STUDY-LEVELS", value=100.0 * factors[-1], unit="%")] if factors else []
    return Ran(
        folder=path,
        participant=session_folder.read_session(path)[2]["participant"],
        trials=len(rows),
        counted=sum(row["counted"] for row in rows),
        levels_factor=factors[-1] if factors else 1.0,
        given_up=given_up,
        findings=(*found, *session_folder.unreadable([path])),
    )


def engine_at(address: str, system: System, time_s: float = 0.0, keep: Path | None = None) -> Engine:
    """Return what presents: the simulated bench at ``bench:``, whose clock goes on at a time, else a device."""
    if address == BENCH:
        return BenchEngine(time_s)
    from frictionloop.experiments.device_strokes import DeviceEngine

    return DeviceEngine(address, system, keep)


def run(
    protocol: Protocol,
    path: Path,
    participant: str,
    system: System | None = None,
    *,
    respondent: Respondent | None = None,
    address: str = BENCH,
    seed: int = 0,
    calibration: str = "",
    progress: Callable[[Mapping[str, Any]], Any] | None = None,
    trials: int | None = None,
    streams: Streams | None = None,
) -> Ran:
    """Begin a session and run it to its end.

    Parameters
    ----------
    protocol : Protocol
        What is asked.
    path : path
        New folder of the session.
    participant : str
        Code; letters and digits, nothing personal.
    system : System, optional
        The bench; that of `study_system` if not given.
    respondent : Respondent, optional
        Who answers; a simulated participant of the population if not given.
    address : str
        What presents: ``bench:`` is the simulated bench, others are addresses of devices, as of ``fl.connect``.
    seed : int
        Seed of the simulated participant.
    calibration : str
        Name of the calibration that the bench's system is from.
    progress : callable, optional
        Called with each row.
    trials : int, optional
        Rows after which it is left, to go on later.
    streams : Streams, optional
        What passes strokes and markers on to other recorders (`frictionloop.experiments.lsl`).

    Raises
    ------
    FrictionloopError
        For a folder with something in it, and for what ends a session early; its rows are then in the folder.
    """
    base = system or study_system()
    more: dict[str, Any] = {"calibration": calibration, "address": address}
    if respondent is None:
        (finger,) = fingers(1, seed)
        more |= about(finger, seed)
    with session_folder.new(path, protocol, base, participant, source_of(address), more) as kept:
        kept.log("begin", time=now(), participant=participant)
        _through(kept, respondent, progress, trials, streams)
    return ran(path)


def resume(
    path: Path,
    *,
    respondent: Respondent | None = None,
    progress: Callable[[Mapping[str, Any]], Any] | None = None,
    trials: int | None = None,
    streams: Streams | None = None,
) -> Ran:
    """Go on with a session that was left, killed or unplugged: same sequence, same posterior.

    Parameters
    ----------
    path : path
        Folder of the session.
    respondent, progress, trials, streams
        As of `run`.

    Raises
    ------
    FrictionloopError
        For a folder that is no session or in use, or whose rows are not those of its protocol.
    """
    with session_folder.opened(path) as kept:
        kept.log("resume", time=now(), rows=len(kept.rows), cut_bytes=kept.cut)
        _through(kept, respondent, progress, trials, streams)
    return ran(path)


def amend(path: Path, trial: int, reason: str) -> Ran:
    """Mark a trial of a session as one that does not count, with a reason.

    A row is added to ``trials.tsv``; that of the trial stays, and so does what the method was told.

    Parameters
    ----------
    path : path
        Folder of the session.
    trial : int
        Number of the trial, from 1.
    reason : str
        Why it does not count.

    Raises
    ------
    FrictionloopError
        For a folder that is no session or in use, a trial that it does not have, or no reason.
    """
    with session_folder.opened(path) as kept:
        kept.amend(trial, reason)
    return ran(path)


def _through(
    kept: Folder,
    respondent: Respondent | None,
    progress: Callable[[Mapping[str, Any]], Any] | None,
    most: int | None,
    streams: Streams | None,
) -> None:
    own, finger, seed = kept.system, {}, 0
    if respondent is None:
        if (told := kept.about.get("simulated")) is None:
            raise FrictionloopError(f"{kept.path}: respondent is missing")
        finger, seed = told["finger"], told["seed"]
        own = own.evolve(finger)
    time_s = kept.rows[-1]["offset_s"] + max(kept.rows[-1]["rt_s"], 0.0) if kept.rows else 0.0
    address = kept.about.get("address", BENCH)
    engine = engine_at(address, guided(own, kept.protocol), time_s, kept.path / RAW)
    shown, why = respondent or Respondent(), ""
    shown.log = kept.log
    own_seed = hash_of(kept.participant, seed)
    try:
        plan, own = own_reach(kept, engine, shown, own, own_seed)
        shown = respondent or SimulatedParticipant(plan, finger, own_seed)
        shown.log = kept.log
        session = Session(plan, kept.participant, own, shown)
        session.replay(kept.rows)
        for row in islice(_trials(kept, session, engine, streams), most):
            if progress is not None:
                progress(row)
        if session.order.finished:
            reach_after(kept, engine, shown, own, own_seed)
        kept.log("end" if session.order.finished else "left", time=now(), rows=len(kept.rows))
    except (FrictionloopError, KeyboardInterrupt) as error:
        why = str(error) or type(error).__name__
        with suppress(FrictionloopError):  # a full disk has no room for this either
            kept.log("stopped", time=now(), why=why, rows=len(kept.rows))
        raise
    finally:
        engine.close()
        shown.ended(why)


def _trials(kept: Folder, session: Session, engine: Engine, streams: Streams | None) -> Iterator[Mapping[str, Any]]:
    """Run trials, and yield the row of each once it is kept."""
    while (trial := session.order.next()) is not None:
        try:
            row, runs = one(session, engine, trial)
        except DeviceError as error:
            raise FrictionloopError(
                f"trial {trial.number}: {error}; kept until then: frictionloop experiment resume {kept.path}"
            ) from error
        row["raw"] = kept.keep(row["trial"], runs)
        kept.add(row)
        if "clock_jump" in row["reason"]:
            kept.log("clock jumped", time=now(), trial=row["trial"], reason=row["reason"])
        given_up = len(session.order.given_up)
        session.order.tell(row)
        for name in session.order.given_up[given_up:]:
            kept.log(GIVEN_UP, time=now(), condition=name, marked=MOST_MARKED)
        if streams is not None:
            streams.tell(row, runs)
        yield row


def source_of(address: str) -> str:
    """Return what a session's forces are of, by the address: simulated, emulated or device."""
    scheme = address.partition(":")[0]
    return {"bench": "simulated", "sim": "simulated", "emulated": "emulated"}.get(scheme, "device")
