"""``frictionloop experiment simulate`` and ``report``: what a study, or sessions, found."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from frictionloop.cli import checks, flags, screen
from frictionloop.cli.experiment import Bench, ProtocolName, bench_of

if TYPE_CHECKING:
    from frictionloop.report.experiment import Report

SIMULATE_EXAMPLES = r"""Examples

  frictionloop experiment simulate jnd-friction-staircase --participants 24 \
      --out study.html
  frictionloop experiment simulate my-study.toml --participants 8 --folder data
"""
REPORT_EXAMPLES = r"""Examples

  frictionloop experiment report data --out study.html
"""


def simulate(
    protocol: ProtocolName,
    /,
    *,
    participants: flags.Run[flags.Whole] = 24,
    seed: flags.Run[flags.Whole] = 0,
    bench: Bench = None,
    folder: flags.Result[Path | None] = None,
    out: flags.Result[Path | None] = None,
    figure: flags.Result[Path | None] = None,
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
    figure
        Write the figure of what was found of each participant here (.svg, .pdf, .png).
    """
    from frictionloop.experiments.protocol import read_protocol
    from frictionloop.experiments.study import simulate as study

    _check_results(out, figure)
    from frictionloop.report.experiment import study as reported
    from frictionloop.report.experiment import write_page

    checks.check_count("participants", participants, 1, 10_000)
    checks.check_count("seed", seed, 0)
    plan = read_protocol(protocol)
    trials = study(plan, bench_of(bench), participants, seed, path=folder)
    found = reported(plan, trials, f"{participants} simulated participants{_chosen(trials)}")
    if out is not None:
        write_page(found, out)
    _found(found, out, figure, json)


def report(
    folder: Annotated[Path, Parameter(name="FOLDER", help="A session, or a folder of sessions.", group=flags.SYSTEM)],
    /,
    *,
    out: flags.Result[Path | None] = None,
    figure: flags.Result[Path | None] = None,
    json: flags.Json = False,
) -> None:
    """Fit what sessions of one protocol have found, and write it as one page.

    Parameters
    ----------
    out
        Write the page here (.html), with its tables beside it.
    figure
        Write the figure of what was found of each participant here (.svg, .pdf, .png).
    """
    _check_results(out, figure)
    from frictionloop.report.experiment import report as reported

    found = reported(folder, out)
    _found(found, out, figure, json)


def _check_results(out: Path | None, figure: Path | None) -> None:
    """Refuse results that could not be written or drawn, before anything starts."""
    checks.check_output("out", out, (".html",))
    checks.check_output("figure", figure, checks.FIGURES)
    checks.check_drawing()


def _found(found: Report, out: Path | None, figure: Path | None, json: bool) -> None:
    if figure is not None:
        from frictionloop.report.experiment import write_figure

        write_figure(found, figure)
    plan, trials, saved = found.protocol, found.trials, {"page": out, "figure": figure}
    if json:
        told = {"protocol": plan.name, "about": found.about, "groups": found.groups.to_dict("records")}
        screen.show_json({**told, "saved": saved})
        return
    from frictionloop.experiments.summary import measure

    rows = [("condition", "level", "participants", measure(plan)[0], "95 %")]
    for each in found.groups.itertuples():
        value = (f"{each.mean:.3g}", f"{each.low:.3g} to {each.high:.3g}") if each.participants else ("–", "")
        rows.append((each.condition, each.level, str(each.participants), *value))
    counted = int(trials["counted"].sum())
    screen.show(
        screen.columns(
            [("protocol", plan.name), ("from", found.about), ("trials", f"{len(trials)}, of which {counted} count")]
        ),
        "",
        screen.table(rows),
        *without(found.fits, measure(plan)[0]),
        *screen.saved({"the page": out, "the figure": figure}),
    )


def _chosen(trials: Any) -> str:
    """Return in words which fingers took part."""
    from frictionloop.experiments.needed import SCARCE

    looked, able = trials.attrs["looked_at"], trials.attrs["able"]
    if not able:
        return f", of whom not all can be given the forces: fewer than one in {SCARCE} fingers can"
    return (
        f", the first of {looked} fingers that can be given all forces" if looked > trials.attrs["participants"] else ""
    )


def without(fitted: Any, name: str) -> list[str]:
    """Return a line for each reason why nothing was found of some participants and conditions."""
    over = fitted[(fitted["level"] == "requested") & (fitted["why"] != "")]
    return [f"{count} without a {name}: {why}" for why, count in over["why"].value_counts(sort=False).items()]
