"""A whole study with simulated participants: sessions side by side, their strokes as lanes of one simulation."""

from __future__ import annotations

import zlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pandas  # type: ignore[import-untyped]

from frictionloop.experiments import folder
from frictionloop.experiments.engine import BenchEngine
from frictionloop.experiments.measured_finger import simulated_finger
from frictionloop.experiments.needed import recruited
from frictionloop.experiments.participant import Observer, SimulatedParticipant
from frictionloop.experiments.protocol import Protocol
from frictionloop.experiments.respondent import Simulated
from frictionloop.experiments.session import Session, side_by_side
from frictionloop.experiments.table import COLUMNS
from frictionloop.loop.progress import progress_bar
from frictionloop.parameters import System, bench
from frictionloop.quantities.checks import whole

STUDY = {
    "controller.kind": "notch_pi",
    "controller.kp": 3.468,
    "controller.ki": 382.6,
    "controller.notch_hz": 144.5,
    "controller.notch_depth": 0.0866,
    "controller.notch_width": 10.0,
}
"""Gains of ``fl.retune_notch(fl.bench())``, rounded."""


def simulate_trials(
    protocol: Protocol,
    system: System | None = None,
    participants: int = 24,
    seed: int = 0,
    *,
    path: Path | None = None,
    observer: Observer | None = None,
    population: Sequence[Mapping[str, Any]] | None = None,
    progress: bool | None = None,
) -> pandas.DataFrame:
    """Return the trials of a study in which simulated participants take part.

    Participants P01, P02, ... are fingers of the population that can be given the protocol's forces, and decide as an
    `Observer` does. The same protocol, system and seed give the same table, whoever is simulated beside them.

    Parameters
    ----------
    protocol : Protocol
        What is asked.
    system : System, optional
        The bench; that of `study_system` if not given.
    participants : int
        How many.
    seed : int
        Seed of fingers, motor errors and decisions; the protocol's own seed draws the order of trials.
    path : path, optional
        Folder in which each participant gets the folder of a session, without traces.
    observer : Observer, optional
        How all of them decide.
    population : sequence of mappings, optional
        Fingers instead of ``fl.fingers(participants, seed)``.
    progress : bool, optional
        Show a progress bar; by default on a terminal.

    Returns
    -------
    pandas.DataFrame
        Rows as in ``trials.tsv``; the attribute ``looked_at`` says how many fingers were looked at to find these, and
        ``able`` whether these can be given all forces.

    Raises
    ------
    FrictionloopError
        For a number of participants below 1, or a folder with something in it.
    """
    base, looked_at, able = system or study_system(), 0, True
    people = population
    if people is None:
        people, looked_at, able = recruited(protocol, base, whole("participants", participants, 1, 10_000), seed)
    sessions, engines = [], []
    for number, finger in enumerate(people, 1):
        sessions.append(simulated_session(protocol, base, f"P{number:02d}", finger, seed, observer))
        engines.append(BenchEngine())
    with ExitStack() as stack:
        folders = None
        if path is not None:
            folders = [
                stack.enter_context(
                    folder.new(
                        path / f"sub-{s.participant}", protocol, base, s.participant, "simulated", about(finger, seed)
                    )
                )
                for s, finger in zip(sessions, people, strict=True)
            ]
        rows: list[dict[str, Any]] = []
        blocks = len(protocol.conditions) * len(sessions)
        with progress_bar("study", blocks, progress) as advance:
            for k, row in _rows(sessions, engines):
                if folders is not None:
                    folders[k].add(row)
                block = sessions[k].order.block
                sessions[k].order.tell(row)
                rows.append(row)
                for _ in range(sessions[k].order.block - block):
                    advance()
    table = pandas.DataFrame(rows, columns=list(COLUMNS))
    table = table.sort_values(["participant", "trial"], ignore_index=True)
    table.attrs = {"participants": len(people), "looked_at": looked_at or len(people), "able": able}
    return table


def _rows(sessions: Sequence[Session], engines: Sequence[BenchEngine]) -> Iterator[tuple[int, dict[str, Any]]]:
    while found := side_by_side(sessions, engines):
        yield from found


def simulated_session(
    protocol: Protocol,
    system: System,
    participant: str,
    finger: Mapping[str, Any],
    seed: int,
    observer: Observer | None = None,
) -> Session:
    """Return the session of a simulated participant, at its start."""
    own = system.evolve(finger)
    if protocol.fit_to_finger:
        own = own.evolve(simulated_finger(own, hash_of(participant, seed)).changes)
    return Session(protocol, participant, own, simulated_respondent(protocol, participant, finger, seed, observer))


def simulated_respondent(
    protocol: Protocol,
    participant: str,
    finger: Mapping[str, Any],
    seed: int,
    observer: Observer | None = None,
) -> Simulated:
    """Return a simulated participant as who answers."""
    return Simulated(SimulatedParticipant(protocol, finger, hash_of(participant, seed), observer))


def about(finger: Mapping[str, Any], seed: int) -> dict[str, Any]:
    """Return what is kept of a simulated participant, so that its session can go on."""
    return {"simulated": {"finger": dict(finger), "seed": seed}}


def hash_of(participant: str, seed: int) -> int:
    """Return the seed of a participant."""
    return (seed << 32) | zlib.crc32(participant.encode())


def study_system() -> System:
    """Return the bench with PI behind a notch, which holds on it: what the studies here run on."""
    return bench().evolve(STUDY)
