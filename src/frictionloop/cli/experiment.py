"""``frictionloop experiment``: a protocol, what it will do, sessions of it, and simulated participants."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from frictionloop.cli import checks, flags, screen
from frictionloop.quantities.units import FrictionloopError

if TYPE_CHECKING:
    from frictionloop.parameters import System

NEW_EXAMPLES = r"""Examples

  frictionloop experiment new my-study.toml
  frictionloop experiment new my-study.toml --from grating-spacing
"""
CHECK_EXAMPLES = r"""Examples

  frictionloop experiment check my-study.toml
"""
EXPORT_EXAMPLES = r"""Examples

  frictionloop experiment export data bids-data
  frictionloop experiment export data/P01 P01.csv --as csv
"""
POWER_EXAMPLES = r"""Examples

  frictionloop experiment power study-friction --effect 0.2 --participants 6:40
  frictionloop experiment power my-study.toml --participants 12:24:12 \
      --trials 20:60:20
"""
ProtocolName = Annotated[
    str,
    Parameter(name="PROTOCOL", help="A TOML file, or the name of a protocol that comes with it.", group=flags.SYSTEM),
]
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
    """Write a protocol to begin with, each key with its unit, meaning and what it accepts.

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
    found = checked(plan, bench_of(bench))
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
    trials: flags.Run[str | None] = None,
    studies: flags.Run[flags.Whole] = 400,
    pool: flags.Run[flags.Whole] = 24,
    seed: flags.Run[flags.Whole] = 0,
    bench: Bench = None,
    json: flags.Json = False,
) -> None:
    """Tell by simulation how many participants and trials a study needs to find a difference, condition by condition.

    Participants are simulated with and without the effect; studies are drawn from them, a paired test in each. The
    interval beside each share is over other participants that might have been simulated.

    Parameters
    ----------
    effect
        Relative change of what is found between two states of the participants, such as 0.2 for a fifth.
    participants
        Numbers of participants, from:to or from:to:step; without a step some nine of them.
    trials
        Numbers of trials of a condition that count, likewise; all of the protocol if not given.
    studies
        Studies that are drawn for each number.
    pool
        Participants that are simulated, from whom studies are drawn.
    seed
        Seed of everything.
    """
    from frictionloop.experiments.planning import power as needed
    from frictionloop.experiments.planning import summary
    from frictionloop.experiments.protocol import read_protocol

    checks.check_count("pool", pool, 2, 10_000)
    checks.check_count("studies", studies, 1, 1_000_000)
    numbers = _range("participants", participants, 2)
    lengths = None if trials is None else _range("trials", trials, 5)
    found = needed(
        read_protocol(protocol), effect, numbers, bench_of(bench), trials=lengths, pool=pool, studies=studies, seed=seed
    )
    if json:
        screen.show_json({"power": found.to_dict("records"), "effect": effect})
        return
    title = f"share of studies that find a change of {100 * effect:g} % at p < 0.05, and its 95 % interval"
    without = int(found["without"].max())
    left_out = f"Of {pool} participants {without} at most were left out: no function could be fitted to their answers."
    screen.show(title, "", screen.table(summary(found)), *([left_out] if without else []))


def _range(name: str, text: str, least: int) -> list[int]:
    try:
        first, last, *step = (int(each) for each in text.split(":"))
    except ValueError:
        first, last, step = 0, 0, []
    if not least <= first <= last <= 1000 or len(step) > 1 or (step and step[0] < 1):
        raise FrictionloopError(f"{name} = {text!r}: must be from:to, such as 6:40, each from {least} to 1000")
    return list(range(first, last + 1, step[0] if step else max((last - first) // 8, 1)))


def bench_of(file: Path | None) -> System:
    """Return the bench of a file, the simulated one of the studies without it."""
    from frictionloop.experiments.study import study_system
    from frictionloop.parameters import read_toml
    from frictionloop.parameters.unit_sanity import unusual

    bench = study_system() if file is None else read_toml(file)
    screen.note_findings(unusual(bench))
    screen.tell_notes()  # before the work, which may take long
    return bench
