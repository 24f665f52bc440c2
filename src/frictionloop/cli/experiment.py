"""``frictionloop experiment``: a protocol, what it will do, sessions of it, and simulated participants."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from frictionloop.cli import checks, flags, screen
from frictionloop.quantities.units import FrictionloopError

if TYPE_CHECKING:
    from frictionloop.experiments.protocol import Protocol
    from frictionloop.parameters import System

NEW_EXAMPLES = r"""Examples

  frictionloop experiment new my-study.toml
  frictionloop experiment new my-study.toml --from grating-spacing
"""
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
CHECK_EXAMPLES = r"""Examples

  frictionloop experiment check my-study.toml
"""
REPORT_EXAMPLES = r"""Examples

  frictionloop experiment report data --out study.html
"""
EXPORT_EXAMPLES = r"""Examples

  frictionloop experiment export data bids-data
  frictionloop experiment export data/P01 P01.csv --as csv
"""
POWER_EXAMPLES = r"""Examples

  frictionloop experiment power study-friction --effect 0.2 --participants 6:40
"""
ProtocolName = Annotated[
    str,
    Parameter(name="PROTOCOL", help="A TOML file, or the name of a protocol that comes with it.", group=flags.SYSTEM),
]
SessionFolder = Annotated[Path, Parameter(name="FOLDER", help="Folder of a session.", group=flags.SYSTEM)]
Bench = Annotated[
    Path | None,
    Parameter(
        help="TOML file of the bench; the simulated one with PI behind a notch if not given.", group=flags.SYSTEM
    ),
]


def new(
    file: Annotated[Path, Parameter(name="FILE", help="File to write (.toml).", group=flags.RESULT)],
    /,
    *,
    start: Annotated[flags.Run[str], Parameter(name="from")] = "jnd-friction-staircase",
) -> None:
    """Write a protocol to begin with, each key with its unit and meaning.

    Parameters
    ----------
    start
        The protocol to copy: a file, or a name of one that comes with the package.
    """
    from frictionloop.experiments.protocol import read_protocol, to_toml
    from frictionloop.quantities import replacing

    checks.check_output("file", file, checks.SYSTEMS)
    checks.check_new("file", file)
    text = to_toml(read_protocol(start))
    with replacing(file) as beside:
        beside.write_text(text, encoding="utf-8")
    screen.show(*screen.saved({"the protocol": file}), f"Check it with: frictionloop experiment check {file}")


def check(protocol: ProtocolName, /, *, bench: Bench = None, json: flags.Json = False) -> None:
    """Run every branch of a protocol dry: trials, duration, forces, and the share of fingers that can be given them."""
    from frictionloop.experiments.dry_run import check as checked
    from frictionloop.experiments.protocol import read_protocol

    plan = read_protocol(protocol)
    found = checked(plan, _bench(bench))
    low, high = sorted(found.trials)
    if json:
        screen.show_json({"protocol": plan.name, **found._asdict(), "needed": found.needed._asdict()})
        return
    screen.show(
        screen.columns(
            [
                ("protocol", f"{plan.name}: {plan.title}"),
                ("trials", f"{low}" if low == high else f"{low} to {high}"),
                ("takes", f"{screen.about(found.duration_s)} at most, breaks and repetitions aside"),
                ("forces", f"{found.needed.low_n:.3g} to {found.needed.high_n:.3g} N"),
                ("in reach", f"of {100 * found.share_in_reach:.0f} % of fingers"),
            ]
        )
    )


def export(
    folder: Annotated[Path, Parameter(name="FOLDER", help="A session, or a folder of sessions.", group=flags.SYSTEM)],
    out: Annotated[Path, Parameter(name="OUT", help="New folder, or file, to write.", group=flags.RESULT)],
    /,
    *,
    form: Annotated[flags.Run[Literal["bids", "csv", "hdf5"]], Parameter(name="as")] = "bids",
) -> None:
    """Write sessions for other programs.

    Parameters
    ----------
    form
        bids: a folder in the shape of BIDS; csv: one table, as PsychoPy writes; hdf5: one file with all traces.
    """
    from frictionloop.experiments.export import WRITERS

    if form != "bids":
        checks.check_output("out", out, {"csv": checks.TABLES, "hdf5": checks.RUN_FILES}[form])
    WRITERS[form](folder, out)
    screen.show(*screen.saved({"the sessions": out}))


def power(
    protocol: ProtocolName,
    /,
    *,
    effect: flags.Run[float] = 0.2,
    participants: flags.Run[str] = "6:24",
    studies: flags.Run[flags.Whole] = 400,
    pool: flags.Run[flags.Whole] = 24,
    seed: flags.Run[flags.Whole] = 0,
    bench: Bench = None,
    json: flags.Json = False,
) -> None:
    """Tell by simulation how many participants a study needs to find a difference, condition by condition.

    Participants are simulated with and without the effect; studies are drawn from them, a paired test in each.

    Parameters
    ----------
    effect
        Relative change of what is found between two states of the participants, such as 0.2 for a fifth.
    participants
        Numbers of participants, from:to or from:to:step.
    studies
        Studies that are drawn for each number.
    pool
        Participants that are simulated, from whom studies are drawn.
    seed
        Seed of everything.
    """
    from frictionloop.experiments.planning import power as needed
    from frictionloop.experiments.protocol import read_protocol

    numbers = _range(participants)
    found = needed(read_protocol(protocol), effect, numbers, _bench(bench), pool=pool, studies=studies, seed=seed)
    if json:
        screen.show_json({"power": found.to_dict("records"), "effect": effect})
        return
    names = list(dict.fromkeys(found["condition"]))
    rows = [("participants", *names, "")]
    for number in numbers:
        own = found[found["participants"] == number].set_index("condition")["power"]
        rows.append((str(number), *(f"{100 * own[name]:.0f} %" for name in names), ""))
    screen.show(f"share of studies that find a change of {100 * effect:g} % at p < 0.05", "", screen.table(rows))


def _range(text: str) -> list[int]:
    try:
        first, last, *step = (int(each) for each in text.split(":"))
    except ValueError:
        first, last, step = 0, 0, []
    if not 2 <= first <= last <= 1000 or len(step) > 1 or (step and step[0] < 1):
        raise FrictionloopError(f"participants = {text!r}: must be from:to, such as 6:40, each from 2 to 1000")
    return list(range(first, last + 1, step[0] if step else max((last - first) // 8, 1)))


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
        plan, where, participant, _bench(bench), respondent=None if simulated else _keyboard(plan),
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
    trials = study(plan, _bench(bench), participants, seed, path=folder)
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


def _bench(file: Path | None) -> System:
    from frictionloop.experiments.study import study_system
    from frictionloop.parameters import read_toml

    return study_system() if file is None else read_toml(file)


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
