"""``frictionloop experiment run`` and ``resume``: sessions."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from frictionloop.cli import checks, flags, screen
from frictionloop.cli.experiment import Bench, ProtocolName, bench_of
from frictionloop.quantities.units import FrictionloopError

if TYPE_CHECKING:
    from frictionloop.experiments.lsl import Streams
    from frictionloop.experiments.protocol import Protocol
    from frictionloop.experiments.respondent import Respondent

RUN_EXAMPLES = r"""Examples

  frictionloop experiment run my-study.toml --participant P01 --simulated
  frictionloop experiment run my-study.toml --participant P01 --folder data/P01 \
      --address serial:///dev/ttyACM0 --bench my-bench.toml
"""
RESUME_EXAMPLES = r"""Examples

  frictionloop experiment resume data/P01
"""
SessionFolder = Annotated[Path, Parameter(name="FOLDER", help="Folder of a session.", group=flags.SYSTEM)]


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
    from frictionloop.experiments.protocol import read_protocol
    from frictionloop.experiments.running import run as through
    from frictionloop.experiments.running import source_of

    plan = read_protocol(protocol)
    where = folder or Path(f"{plan.name}-{participant}")
    if simulated and studio:
        raise FrictionloopError("--simulated, --studio: a simulated participant sees no page; give one of the two")
    with _respondent(plan, participant, source_of(address), simulated, studio, host, port) as respondent:
        through(
            plan, where, participant, bench_of(bench), respondent=respondent,
            address=address, seed=seed, calibration=calibration, progress=_told(plan, simulated or studio),
            streams=_streams(participant, lsl),
        )  # fmt: skip
    _ended(where)


def resume(
    folder: SessionFolder,
    /,
    *,
    studio: flags.Run[flags.Flag] = False,
    host: flags.Run[str] = "127.0.0.1",
    port: flags.Run[flags.Whole] = 0,
    lsl: flags.Run[flags.Flag] = False,
) -> None:
    """Go on with a session that was left, killed or unplugged: same sequence, same posterior.

    Parameters
    ----------
    studio, host, port, lsl
        As of ``experiment run``.
    """
    from frictionloop.experiments import folder as folders
    from frictionloop.experiments.running import resume as through

    plan, _, about = folders.read(folder)
    simulated = "simulated" in about
    with _respondent(plan, about["participant"], about["source"], simulated, studio, host, port) as respondent:
        through(
            folder, respondent=respondent, progress=_told(plan, simulated or studio),
            streams=_streams(about["participant"], lsl),
        )  # fmt: skip
    _ended(folder)


@contextmanager
def _respondent(
    plan: Protocol, participant: str, source: str, simulated: bool, studio: bool, host: str, port: int
) -> Iterator[Respondent | None]:
    """Yield who answers: None is a simulated participant."""
    if simulated:
        yield None
    elif not studio:
        from frictionloop.experiments.keyboard import Keyboard

        yield Keyboard(plan)
    else:
        from frictionloop.studio.experiment.desk import Desk
        from frictionloop.studio.experiment.serving import served

        checks.check_count("port", port, 0, 65535)
        desk = Desk(plan, participant, source)
        with served(desk, host, port) as addresses:
            for name, told in addresses._asdict().items():
                screen.show(f"{name}'s page:", f"  {told}")
            screen.show("Ctrl-C ends it.")
            yield desk


def _streams(participant: str, wanted: bool) -> Streams | None:
    if not wanted:
        return None
    from frictionloop.experiments.lsl import Streams

    return Streams(participant)


def _told(plan: Protocol, rows: bool) -> Any:
    """Return what tells each row; a person at the keyboard sees its own lines."""

    def tell(row: Mapping[str, Any]) -> None:
        what = row["reason"] if row["reason"] else f"{row['response']}"
        screen.say(f"trial {row['trial']}: {row['condition']}, {row['requested']:.4g} {plan.level_unit}: {what}")

    return tell if rows else None


def _ended(where: Path) -> None:
    from frictionloop.experiments.folder import TABLE, logged
    from frictionloop.experiments.keyboard import levels_drawn
    from frictionloop.experiments.running import GIVEN_UP
    from frictionloop.experiments.table import read_rows

    rows = read_rows(where / TABLE)
    counted = sum(row["counted"] for row in rows)
    for told in logged(where):
        if told["event"] == "adjusted" and "factor" in told:
            screen.say(levels_drawn(told["factor"]))
        if told["event"] == GIVEN_UP:
            screen.say(f"condition {told['condition']} was given up: {told['marked']} trials did not count")
    screen.show(
        f"{len(rows)} trials, of which {counted} count, are in {where / TABLE}",
        f"Report: frictionloop experiment report {where} --out {where.name}.html",
    )
