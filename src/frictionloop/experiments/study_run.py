"""A study: simulated participants as lanes of one simulation, or sessions in a folder, and what it found."""

from __future__ import annotations

import os
import zlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas  # type: ignore[import-untyped]

from frictionloop.experiments import session_folder
from frictionloop.experiments.levels_within_reach import recruited
from frictionloop.experiments.measured_finger import simulated_finger
from frictionloop.experiments.participant_reach import reaches
from frictionloop.experiments.protocol import Protocol
from frictionloop.experiments.session_folder import once_each, read_trials, sessions_in
from frictionloop.experiments.simulated_participant import Observer, SimulatedParticipant
from frictionloop.experiments.study_summary import (
    contrasts,
    fits,
    funnel,
    groups,
    measure,
    named_found,
    pooled,
    unit_found,
)
from frictionloop.experiments.trial_loop import BenchEngine, Session, side_by_side
from frictionloop.experiments.trial_records import COLUMNS
from frictionloop.findings import Finding, Result
from frictionloop.findings.result import plain
from frictionloop.loop.progress import progress_bar
from frictionloop.parameters import System, bench
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.value_checks import whole

if TYPE_CHECKING:
    from matplotlib.figure import Figure


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
    pairs = [(f"P{number:02d}", finger) for number, finger in enumerate(people, 1)]
    sessions = [simulated_session(protocol, base, code, finger, seed, observer) for code, finger in pairs]
    engines = [BenchEngine() for _ in sessions]
    rows: list[dict[str, Any]] = []
    with ExitStack() as stack:
        folders = []
        if path is not None:
            for code, finger in pairs:
                own = path / f"sub-{code}"
                folder = session_folder.new(own, protocol, base, code, "simulated", about(finger, seed))
                folders.append(stack.enter_context(folder))
        with progress_bar("study", len(protocol.conditions) * len(sessions), progress) as advance:
            for k, row in _rows(sessions, engines):
                if folders:
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
    who = SimulatedParticipant(protocol, finger, hash_of(participant, seed), observer)
    return Session(protocol, participant, own, who)


def about(finger: Mapping[str, Any], seed: int) -> dict[str, Any]:
    """Return what is kept of a simulated participant, so that its session can go on."""
    return {"simulated": {"finger": dict(finger), "seed": seed}}


def hash_of(participant: str, seed: int) -> int:
    """Return the seed of a participant."""
    return (seed << 32) | zlib.crc32(participant.encode())


def study_system() -> System:
    """Return the bench with PI behind a notch, which holds on it: what the studies here run on."""
    return bench().evolve(STUDY)


TABLES = ("fits", "groups", "contrasts", "pooled", "funnel", "reaches")


class Study(Result, schema="experiments.study/1"):
    """What trials of one protocol have found."""

    protocol: Protocol
    about: str
    """How many sessions or participants, and what their forces are of."""
    trials: pandas.DataFrame
    """Rows as in ``trials.tsv``."""
    fits: pandas.DataFrame
    """As `fits`."""
    groups: pandas.DataFrame
    """As `groups`."""
    contrasts: pandas.DataFrame
    """As `contrasts`; no rows of one condition."""
    pooled: pandas.DataFrame
    """As `pooled`."""
    funnel: pandas.DataFrame
    """As `funnel`."""
    reaches: pandas.DataFrame
    """As `reaches`; no rows where it was not measured."""

    def rows(self) -> list[tuple[str, str]]:
        """Return the protocol, where the trials are from, and how many count."""
        counted = f"{len(self.trials)}, of which {int(self.trials['counted'].sum())} count"
        return [("protocol", self.protocol.name), ("from", self.about), ("trials", counted)]

    def tables(self) -> dict[str, pandas.DataFrame]:
        """Return groups and contrasts by condition and level, then what each participant gave, all, and each trial."""
        heads = {"mean": named_found(self.protocol), "low": "95 % from", "high": "to", "participants": "people"}
        columns = ["condition", "level", "participants", "mean", "low", "high"]
        both = pandas.concat([each for each in (self.groups, self.contrasts) if len(each)])
        shown = both[columns].rename(columns=heads).set_index("condition")
        more = {name: getattr(self, name) for name in TABLES if name not in ("groups", "contrasts")}
        return {"groups": shown} | {name: _indexed(each) for name, each in more.items() if len(each)}

    def plot(self) -> Figure:
        """Return what was found of each participant."""
        from frictionloop.experiments.study_figures import thresholds

        return thresholds(self.protocol, self.fits)

    def to_dict(self) -> dict[str, Any]:
        """Return everything but the trials by name, tables as rows."""
        found: dict[str, Any] = {"schema": self.SCHEMA, "protocol": self.protocol, "about": self.about}
        found |= {"trials": len(self.trials), "counted": int(self.trials["counted"].sum())}
        found |= {name: getattr(self, name).to_dict("records") for name in TABLES}
        return dict(plain(found | {"findings": self.findings}))


def _indexed(frame: pandas.DataFrame) -> pandas.DataFrame:
    return frame.set_index(frame.columns[0])


def study_of(
    protocol: Protocol,
    trials: pandas.DataFrame,
    about: str,
    of_fingers: pandas.DataFrame | None = None,
    findings: Sequence[Finding] = (),
) -> Study:
    """Return what trials have found."""
    fitted = fits(protocol, trials)
    return Study(
        protocol=protocol,
        about=about,
        trials=trials,
        fits=fitted,
        groups=groups(fitted).assign(unit=unit_found(protocol)),
        contrasts=contrasts(protocol, fitted),
        pooled=pooled(protocol, trials),
        funnel=funnel(trials),
        reaches=pandas.DataFrame() if of_fingers is None else of_fingers,
        findings=(*unfitted(fitted, measure(protocol)[0]), *outside(protocol, fitted), *findings),
    )


def unfitted(fitted: pandas.DataFrame, name: str) -> Iterator[Finding]:
    """Yield of how many participants and conditions nothing was found, by the reason."""
    over = fitted[(fitted["level"] == "requested") & (fitted["why"] != "")]
    for why, count in over["why"].value_counts(sort=False).items():
        yield Finding("STUDY-UNFITTED", value=int(count), more={"measure": name, "reason": str(why)})


def outside(protocol: Protocol, fitted: pandas.DataFrame) -> Iterator[Finding]:
    """Yield how many thresholds lie outside the levels that were asked for."""
    if measure(protocol)[0] in ("JND", "threshold"):
        value = fitted.loc[fitted["level"] == "requested", "value"].dropna()
        if count := int((~value.between(*protocol.method.extremes())).sum()):
            yield Finding("STUDY-OUTSIDE", value=count, more={"measure": measure(protocol)[0]})


def simulate(
    protocol: Protocol,
    system: System | None = None,
    participants: int = 24,
    seed: int = 0,
    *,
    path: Path | None = None,
    observer: Observer | None = None,
    population: Sequence[Mapping[str, Any]] | None = None,
    progress: bool | None = None,
) -> Study:
    """Return what a study with simulated participants finds.

    Parameters
    ----------
    protocol, system, participants, seed, path, observer, population, progress
        As of `simulate_trials`.

    Raises
    ------
    FrictionloopError
        For a number of participants below 1, or a folder with something in it.
    """
    trials = simulate_trials(
        protocol, system, participants, seed, path=path, observer=observer, population=population, progress=progress
    )
    looked, able = trials.attrs["looked_at"], trials.attrs["able"]
    about = f"{trials.attrs['participants']} simulated participants"
    about += f", of {looked} fingers" if able and looked > participants else ""
    scarce = [] if able else [Finding("STUDY-REACH", "warning", 0.0, "%")]
    return study_of(protocol, trials, about, findings=scarce)


def report(path: str | os.PathLike[str]) -> Study:
    """Return what sessions of one protocol have found.

    Parameters
    ----------
    path : path
        A session, or a folder of sessions.

    Raises
    ------
    FrictionloopError
        For a folder without sessions, sessions of different protocols or twice of one participant.
    """
    where = Path(path)
    found = sessions_in(where)
    once_each(found)
    protocol = session_folder.read_session(found[0])[0]
    for other in found[1:]:
        if session_folder.read_session(other)[0] != protocol:
            raise FrictionloopError(f"{other}: has another protocol than {found[0]}")
    sources = {str(session_folder.read_session(each)[2]["source"]) for each in found}
    about = f"{len(found)} session{'s' * (len(found) > 1)}, {' and '.join(sorted(sources))}"
    if (trials := read_trials(where)).empty:
        raise FrictionloopError(f"{where}: has no trial")
    return study_of(protocol, trials, about, reaches(where), session_folder.unreadable(found))
