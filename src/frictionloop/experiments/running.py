"""One session on an engine, kept in its folder; it can be killed at any moment and goes on from there."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from frictionloop.experiments import folder
from frictionloop.experiments.engine import BenchEngine, Engine
from frictionloop.experiments.folder import Folder
from frictionloop.experiments.participant import Observer
from frictionloop.experiments.protocol import Protocol
from frictionloop.experiments.session import Respondent, Session, one
from frictionloop.experiments.study import about, simulated_session, study_system
from frictionloop.parameters import System
from frictionloop.physics.fingers import fingers
from frictionloop.quantities import FrictionloopError

BENCH = "bench:"
"""Address of the simulated bench."""


def engine_at(address: str, system: System, time_s: float) -> Engine:
    """Return what presents: the simulated bench at ``bench:``, whose clock goes on at a time, else a device.

    Raises
    ------
    FrictionloopError
        As ``fl.connect``.
    """
    if address == BENCH:
        return BenchEngine(time_s)
    from frictionloop.experiments.device_engine import DeviceEngine

    return DeviceEngine(address, system)


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
) -> Path:
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

    Returns
    -------
    Path
        The folder.

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
    with folder.new(path, protocol, base, participant, source_of(address), more) as kept:
        kept.log("begin", time=_now(), participant=participant)
        _through(kept, respondent, progress, trials)
    return path


def resume(
    path: Path,
    *,
    respondent: Respondent | None = None,
    progress: Callable[[Mapping[str, Any]], Any] | None = None,
    trials: int | None = None,
) -> Path:
    """Go on with a session that was left, killed or unplugged: same sequence, same posterior.

    Parameters
    ----------
    path : path
        Folder of the session.
    respondent, progress, trials
        As of `run`.

    Raises
    ------
    FrictionloopError
        For a folder that is no session or in use, or whose rows are not those of its protocol.
    """
    with folder.opened(path) as kept:
        kept.log("resume", time=_now(), rows=len(kept.rows), cut_bytes=kept.cut)
        _through(kept, respondent, progress, trials)
    return path


def _through(
    kept: Folder,
    respondent: Respondent | None,
    progress: Callable[[Mapping[str, Any]], Any] | None,
    most: int | None,
) -> None:
    session = session_of(kept, respondent)
    session.told(kept.rows)
    time_s = kept.rows[-1]["offset_s"] + max(kept.rows[-1]["rt_s"], 0.0) if kept.rows else 0.0
    engine = engine_at(kept.about.get("address", BENCH), session.device_system, time_s)
    done = 0
    try:
        while (most is None or done < most) and (found := one(session, engine)) is not None:
            row, runs = found
            row["raw"] = kept.keep(row["trial"], runs)
            kept.add(row)
            session.order.tell(row)
            done += 1
            if progress is not None:
                progress(row)
    except (FrictionloopError, KeyboardInterrupt) as error:
        kept.log("stopped", time=_now(), why=str(error) or type(error).__name__, rows=len(kept.rows))
        raise
    finally:
        engine.close()
    kept.log("end" if session.order.finished else "left", time=_now(), rows=len(kept.rows))


def session_of(kept: Folder, respondent: Respondent | None) -> Session:
    """Return the session of a folder at its start; without a respondent that of its simulated participant."""
    if respondent is not None:
        return Session(kept.protocol, kept.participant, kept.system, respondent)
    if (told := kept.about.get("simulated")) is None:
        raise FrictionloopError(f"{kept.path}: a person answers in this session; give who does")
    observer = Observer(**told["observer"]) if "observer" in told else None
    return simulated_session(kept.protocol, kept.system, kept.participant, told["finger"], told["seed"], observer)


def source_of(address: str) -> str:
    """Return what a session's forces are of, by the address: simulated, emulated or device."""
    scheme = address.partition(":")[0]
    return {"bench": "simulated", "sim": "simulated", "emulated": "emulated"}.get(scheme, "device")


def _now() -> str:
    return time.strftime("%Y-%m-%dT%H:%M:%S%z")
