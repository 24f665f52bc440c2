"""``frictionloop reproduce``: the paper's figures and claims on one page."""

from __future__ import annotations

import json as json_text
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from frictionloop.cli import flags, screen
from frictionloop.quantities.extra import needed

if TYPE_CHECKING:
    from frictionloop.report.alone import Shown
    from frictionloop.report.stroke_numbers import Table

ARGUMENTS = "[OPTIONS]"
EXAMPLES = """Examples

  frictionloop reproduce
  frictionloop reproduce --out my-report --json
  frictionloop reproduce --only fig-5a,closed-loop-r2
  frictionloop reproduce --only fig-5a --sensor.resonance_hz 200
"""
UNITS = {"_n_rthz": ("uN/rtHz", 1e6), "_n": ("mN", 1e3), "_ms": ("ms", 1.0), "_hz": ("Hz", 1.0)}
"""What numbers are shown in, by the end of their names."""
HEADS = {"r2_regression": "R2 regr.", "r2_identity": "R2 ident.", "r2_bound": "R2 bound"}
NARROW = {
    "sensitivity_peak": "Ms",
    "stable_from_n": "from",
    "r2_regression": "R2",
    "r2_identity": "R2 id.",
    "spread_n": "spread",
    "error_n": "error",
}
STROKES = [
    "  Ms: largest peak of sensitivity of the linear loop of this finger, just landed, at the",
    "  forces asked for, 300 to 900 mN; ∞ is unstable. from: lowest of them from which on it is",
    "  stable (mN); - is at none. R2: of the regression; id.: about f_a = f_r. Spread and",
    "  error in mN.",
]
"""Heads of the numbers of Fig. 5a, which are many, and what they mean."""
FACTORS = [
    "  spread divided by: the median of what it is divided by for each finger, which is not the",
    "  quotient of the medians beside it.",
]


Changed = Annotated[
    list[str] | None,
    Parameter(
        name=flags.DOTTED,
        metavar="VALUE",
        help="Change the bench, such as --sensor.resonance_hz 200, or give PI gains, --controller.kp 0.0146 "
        "--controller.ki 31.5. For --only fig-5a, and of the bench fig-5a-printed, which are not the paper's then: "
        "title and file say what was changed, and no statement is judged.",
        group=flags.RESULT,
    ),
]


def command(
    *,
    out: flags.Result[Path] = Path("report"),
    only: Annotated[flags.Result[str | None], Parameter(metavar="NAME,...")] = None,
    overrides: Changed = None,
    json: flags.Json = False,
) -> None:
    """Rebuild the paper's figures and check its numbers: index.html and claims.json in a folder.

    Parameters
    ----------
    out
        Folder for the page and the claims.
    only
        Make these figures and claims alone, with their numbers, and no page: fig-5a,closed-loop-r2. The page names
        each.
    """
    needed("matplotlib", "matplotlib", "report")
    needed("jinja2", "jinja2", "report")
    with screen.waiting("loading what simulates and draws"):
        from frictionloop.report.build import reproduce
        from frictionloop.report.claims.told import claims_tables, summary

    names = [] if only is None else [name.strip() for name in only.split(",")]
    if names or overrides:
        _some(names, flags.overrides_of(overrides), out, json)
        return
    claims = reproduce(out)
    page = out / "index.html"
    if json:
        screen.show_json(json_text.loads((out / "claims.json").read_text(encoding="utf-8")) | {"page": page})
    else:
        screen.show(*claims_tables(claims), *summary(claims), f"The page: {page}")


def _some(names: list[str], changes: dict[str, Any], out: Path, json: bool) -> None:
    """Make some figures and claims, and show them with all of their numbers."""
    from frictionloop.cli.plausible import differing
    from frictionloop.parameters import bench
    from frictionloop.report.alone import alone
    from frictionloop.report.changed import check
    from frictionloop.report.claims.told import claim_lines

    if changes:
        check(names, changes)
        for line in differing(bench().evolve(changes), changes):
            screen.note(line)
        screen.tell_notes()
    claims, figures = alone(out, names, changes)
    if json:
        screen.show_json(
            {"claims": [claim.as_dict() for claim in claims], "figures": [figure._asdict() for figure in figures]}
        )
        return
    for claim in claims:
        screen.show(*claim_lines(claim))
    for figure in figures:
        screen.show(*_figure(figure))


def _figure(figure: Shown) -> list[Any]:
    """Return a figure for a terminal: what was changed, its numbers, its seeds and where it is."""
    from frictionloop.report.changed import bench_of, words
    from frictionloop.report.cited import cited

    strokes = any("sensitivity_peak" in row for row in figure.numbers.values())
    other = "bench" if bench_of(figure.changed) else "gains"
    before = ["  the bench unchanged:", _table(figure.unchanged)] if figure.unchanged else []
    return [
        figure.name + (f", not the paper's {other}: {words(figure.changed)}" if figure.changed else ""),
        *([_table(figure.numbers)] if figure.numbers else []),
        *(f"  {line}" for line in figure.told),
        *before,
        *(STROKES if strokes else []),
        *_scored(figure.numbers),
        *(FACTORS if any("spread_divided_by" in row for row in figure.numbers.values()) else []),
        *_checked(figure),
        f"  cite: {' · '.join(cited(figure.command, figure.seeds))}",
        f"The figure: {figure.file}",
        "  beside it the same as .png",
    ]


def _checked(figure: Shown) -> list[str]:
    """Return at how many contacts and speeds the gains hold on a changed bench, and the command that says more."""
    from frictionloop.report.cited import flags_of

    if not figure.checked:
        return []
    from frictionloop.report.changed import bench_of

    changed = " on the changed bench" if bench_of(figure.changed) else ""
    lines = [f"  What frictionloop design check says of them{changed}:"]
    for name, found in figure.checked.items():
        ringing = f", unstable at {found.unstable}:" if found.unstable else ""
        lines.append(f"  {name}: hold at {found.held} of {found.places} contacts and speeds{ringing}")
        lines += [f"    {where}" for where in found.unstable_on]
    name = max(figure.checked, key=lambda each: (figure.checked[each].held, -figure.checked[each].unstable))
    gains = {f"controller.{each}": figure.numbers[name][each] for each in ("kp", "ki")}
    given = figure.changed | {path: float(f"{value:.4g}") for path, value in gains.items() if value is not None}
    command = "frictionloop design check --preset bench"
    return [*lines, f"  More of {name}, and what would hold: {' '.join([command, *flags_of(given)])}"]


def _table(numbers: Table) -> Any:
    columns = list(dict.fromkeys(name for row in numbers.values() for name in row if name != "scored"))
    short = NARROW if "sensitivity_peak" in columns else {}
    rows = [("", *(short.get(key) or _head(key) for key in columns), "")]
    rows += [(name, *(_shown(key, row.get(key)) for key in columns), "") for name, row in numbers.items()]
    return screen.table(rows)


def _scored(numbers: Table) -> list[str]:
    """Return a line where reversals, which do not count, take some of the time."""
    shares = [share for row in numbers.values() if (share := row.get("scored")) is not None]
    if not shares:
        return []
    return [f"  Reversals, where the finger turns round, do not count: {1 - min(shares):.1%} of the time."]


def _unit(name: str) -> tuple[str, str, float]:
    """Return the words of a number's name, its unit, and by what it is multiplied for that."""
    for end, (unit, factor) in UNITS.items():
        if name.endswith(end):
            return name.removesuffix(end).replace("_", " "), unit, factor
    return name.replace("_", " "), "", 1.0


def _head(name: str) -> str:
    words, unit, _ = _unit(HEADS.get(name, name))
    return f"{words}, {unit}" if unit else words


def _shown(name: str, value: float | None) -> str:
    from frictionloop.cli.comparison_text import number

    return "-" if value is None else number(_unit(name)[2] * value)
