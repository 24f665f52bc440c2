"""``frictionloop experiment run`` and ``resume``: sessions."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

import frictionloop as fl
from frictionloop.cli import file_arguments, flags, screen
from frictionloop.cli.experiment import Bench, ProtocolName
from frictionloop.cli.verb import verb

if TYPE_CHECKING:
    from frictionloop.experiments import Protocol, Respondent

SessionFolder = Annotated[Path, Parameter(name="FOLDER", help="Folder of a session.", group=flags.SYSTEM)]


@verb(
    "run PROTOCOL --participant CODE [OPTIONS]",
    "my-study.toml --participant P01 --simulated",
    "my-study.toml --participant P01 --folder data/P01 --address serial:///dev/ttyACM0 --bench my-bench.toml",
)
def run(
    protocol: ProtocolName,
    /,
    *,
    participant: flags.Run[str],
    folder: flags.Result[Path | None] = None,
    bench: Bench = None,
    address: flags.Run[str] = "bench:",
    simulated: flags.Run[flags.Flag] = False,
    seed: flags.Run[flags.Whole] = 0,
    calibration: flags.Run[str] = "",
    studio: flags.Run[flags.Flag] = False,
    host: flags.Run[str] = "127.0.0.1",
    port: flags.Run[flags.Whole] = 0,
    lsl: flags.Run[flags.Flag] = False,
    shown: screen.Shown = screen.BRIEFLY,
) -> None:
    """Run a session with one participant, at the keyboard of this terminal, on a page, or a simulated one.

    Every trial is on the disk before the next begins. Ctrl-C leaves the session; ``experiment resume`` goes on.

    Parameters
    ----------
    participant
        Code of the participant, such as P01; nothing personal.
    folder
        New folder of the session; PROTOCOL-PARTICIPANT here if not given.
    address
        What presents: bench: simulates, sim:, serial:///dev/ttyACM0 and so on are devices.
    simulated
        A simulated participant answers.
    seed
        Seed of the simulated participant.
    calibration
        Name of the calibration that the bench's file is from, kept with the session.
    studio
        The participant answers on a page in a browser, and another page is for the experimenter.
    host
        Address that the pages are at; any but this machine's own lets them be on other machines.
    port
        Port of the pages; 0 takes a free one.
    lsl
        Forces, positions and markers also go out as streams of the Lab Streaming Layer.
    """
    if simulated and studio:
        raise fl.FrictionloopError("studio = True: goes with a person, not with simulated")
    plan, given = fl.experiments.read_protocol(protocol), flags.bench_of(bench)
    where = folder or Path(f"{plan.name}-{participant}")
    with _respondent(plan, participant, address, simulated, studio, host, port) as respondent:
        found = fl.experiments.run(
            plan, where, participant, given.system, respondent=respondent, address=address, seed=seed,
            calibration=calibration, progress=_progress(plan, simulated or studio),
            streams=fl.experiments.Streams(participant) if lsl else None,
        )  # fmt: skip
    shown.show(found.with_findings(given.findings))


@verb("resume FOLDER", "data/P01")
def resume(
    folder: SessionFolder,
    /,
    *,
    studio: flags.Run[flags.Flag] = False,
    host: flags.Run[str] = "127.0.0.1",
    port: flags.Run[flags.Whole] = 0,
    lsl: flags.Run[flags.Flag] = False,
    shown: screen.Shown = screen.BRIEFLY,
) -> None:
    """Go on with a session that was left, killed or unplugged: same sequence, same posterior.

    Parameters
    ----------
    studio, host, port, lsl
        As of ``experiment run``.
    """
    plan, _, about = fl.experiments.read_session(folder)
    simulated = "simulated" in about
    with _respondent(plan, about["participant"], about.get("address", "bench:"), simulated, studio, host, port) as who:
        found = fl.experiments.resume(
            folder, respondent=who, progress=_progress(plan, simulated or studio),
            streams=fl.experiments.Streams(about["participant"]) if lsl else None,
        )  # fmt: skip
    shown.show(found)


@verb("amend FOLDER TRIAL --reason TEXT", 'data/P01 12 --reason "the phone rang"')
def amend(
    folder: SessionFolder,
    trial: Annotated[int, Parameter(name="TRIAL", help="Number of the trial.", group=flags.SYSTEM)],
    /,
    *,
    reason: flags.Run[str],
    shown: screen.Shown = screen.BRIEFLY,
) -> None:
    """Mark a trial as one that does not count; its row stays, and so does what the method was told.

    Parameters
    ----------
    reason
        Why it does not count.
    """
    shown.show(fl.experiments.amend(folder, trial, reason))


@contextmanager
def _respondent(
    plan: Protocol, participant: str, address: str, simulated: bool, studio: bool, host: str, port: int
) -> Iterator[Respondent | None]:
    """Yield who answers: None is a simulated participant."""
    if simulated:
        yield None
    elif not studio:
        yield fl.experiments.Keyboard(plan)
    else:
        file_arguments.check_count("port", port, 0, 65535)
        with fl.studio.desk(plan, participant, address, host, port) as (desk, pages):
            screen.show(screen.columns([*pages._asdict().items(), ("end", "Ctrl-C")]))
            yield desk


def _progress(plan: Protocol, rows: bool) -> Any:
    """Return what tells each row; a person at the keyboard sees its own lines."""

    def tell(row: Mapping[str, Any]) -> None:
        level = f"{row['requested']:.4g} {plan.level_unit}"
        screen.say(f"trial {row['trial']}: {row['condition']}, {level}: {row['reason'] or row['response']}")

    return tell if rows else None
