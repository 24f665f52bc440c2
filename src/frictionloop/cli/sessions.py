"""``frictionloop experiment run``, ``resume``, ``simulate`` and ``report``: sessions, and what they found."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from frictionloop.cli import checks, flags, screen
from frictionloop.cli.experiment import Bench, ProtocolName, bench_of
from frictionloop.quantities.units import FrictionloopError

if TYPE_CHECKING:
    from frictionloop.experiments.protocol import Protocol

RUN_EXAMPLES = r"""Examples

  frictionloop experiment run my-study.toml --participant P01 --simulated
  frictionloop experiment run my-study.toml --participant P01 --folder data/P01 \
      --address serial:///dev/ttyACM0 --bench my-bench.toml
"""
RESUME_EXAMPLES = r"""Examples

  frictionloop experiment resume data/P01
"""
SIMULATE_EXAMPLES = r"""Examples

  frictionloop experiment simulate jnd-friction-staircase --participants 24 \
      --out study.html
  frictionloop experiment simulate my-study.toml --participants 8 --folder data
"""
REPORT_EXAMPLES = r"""Examples

  frictionloop experiment report data --out study.html
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
) -> None:
    """Run a session with one participant, at the keyboard of this terminal or a simulated one.

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
    """
    from frictionloop.experiments.protocol import read_protocol
    from frictionloop.experiments.running import run as through

    plan = read_protocol(protocol)
    where = folder or Path(f"{plan.name}-{participant}")
    through(
        plan, where, participant, bench_of(bench), respondent=None if simulated else _keyboard(plan),
        address=address, seed=seed, calibration=calibration, progress=_told(plan, simulated),
    )  # fmt: skip
    _ended(where)


def resume(folder: SessionFolder, /) -> None:
    """Go on with a session that was left, killed or unplugged: same sequence, same posterior."""
    from frictionloop.experiments import folder as folders
    from frictionloop.experiments.running import resume as through

    plan, _, about = folders.read(folder)
    simulated = "simulated" in about
    through(folder, respondent=None if simulated else _keyboard(plan), progress=_told(plan, simulated))
    _ended(folder)


def simulate(
    protocol: ProtocolName,
    /,
    *,
    participants: flags.Run[flags.Whole] = 24,
    seed: flags.Run[flags.Whole] = 0,
    bench: Bench = None,
    folder: flags.Result[Path | None] = None,
    out: flags.Result[Path | None] = None,
    json: flags.Json = False,
) -> None:
    """Run a whole study with simulated participants, and say what it found.

    Parameters
    ----------
    participants
        How many take part.
    seed
        Seed of the participants.
    folder
        Keep a session's folder for each participant here, without traces.
    out
        Write the page of the study here (.html), with its tables beside it.
    """
    from frictionloop.experiments.protocol import read_protocol
    from frictionloop.experiments.study import simulate as study
    from frictionloop.experiments.summary import fits, groups

    checks.check_output("out", out, (".html",))
    checks.check_count("participants", participants, 1, 10_000)
    checks.check_count("seed", seed, 0)
    plan = read_protocol(protocol)
    trials = study(plan, bench_of(bench), participants, seed, path=folder)
    _found(plan, trials, groups(fits(plan, trials)), f"{participants} simulated participants", out, json)


def report(
    folder: Annotated[Path, Parameter(name="FOLDER", help="A session, or a folder of sessions.", group=flags.SYSTEM)],
    /,
    *,
    out: flags.Result[Path | None] = None,
    json: flags.Json = False,
) -> None:
    """Fit what sessions of one protocol have found, and write it as one page.

    Parameters
    ----------
    out
        Write the page here (.html), with its tables beside it.
    """
    from frictionloop.experiments import folder as folders
    from frictionloop.experiments.summary import fits, groups, read_trials, sessions_in

    checks.check_output("out", out, (".html",))
    found = sessions_in(folder)
    plan = folders.read(found[0])[0]
    for other in found[1:]:
        if folders.read(other)[0] != plan:
            raise FrictionloopError(f"{other}: has another protocol than {found[0]}; report them apart")
    sources = {str(folders.read(each)[2]["source"]) for each in found}
    trials = read_trials(folder)
    said = f"{len(found)} session{'s' * (len(found) > 1)}, {' and '.join(sorted(sources))}"
    _found(plan, trials, groups(fits(plan, trials)), said, out, json)


def _found(plan: Protocol, trials: Any, found: Any, about: str, out: Path | None, json: bool) -> None:
    if out is not None:
        checks.check_drawing()
        from frictionloop.report.experiment import write_page

        write_page(plan, trials, about, out)
    if json:
        screen.show_json(
            {"protocol": plan.name, "about": about, "groups": found.to_dict("records"), "saved": {"page": out}}
        )
        return
    from frictionloop.experiments.summary import measure

    rows = [("condition", "level", "participants", measure(plan)[0], "95 %")]
    for each in found.itertuples():
        interval = f"{each.low:.3g} to {each.high:.3g}"
        rows.append((each.condition, each.level, str(each.participants), f"{each.mean:.3g}", interval))
    counted = int(trials["counted"].sum())
    screen.show(
        screen.columns(
            [("protocol", plan.name), ("from", about), ("trials", f"{len(trials)}, of which {counted} count")]
        ),
        "",
        screen.table(rows),
        *screen.saved({"the page": out}),
    )


def _keyboard(plan: Protocol) -> Any:
    from frictionloop.experiments.keyboard import Keyboard

    return Keyboard(plan)


def _told(plan: Protocol, simulated: bool) -> Any:
    """Return what tells each row of a simulated participant; a person sees the keyboard's own lines."""

    def tell(row: Mapping[str, Any]) -> None:
        what = row["reason"] if row["reason"] else f"{row['response']}"
        screen.say(f"trial {row['trial']}: {row['condition']}, {row['requested']:.4g} {plan.level_unit}: {what}")

    return tell if simulated else None


def _ended(where: Path) -> None:
    from frictionloop.experiments.folder import TABLE
    from frictionloop.experiments.table import read_rows

    rows = read_rows(where / TABLE)
    counted = sum(row["counted"] for row in rows)
    screen.show(
        f"{len(rows)} trials, of which {counted} count, are in {where / TABLE}",
        f"Report: frictionloop experiment report {where} --out {where.name}.html",
    )
