"""A figure that was made alone, for a terminal: what was changed, its numbers, and what its gains hold for."""

from __future__ import annotations

import math
import shlex
import textwrap
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from frictionloop.cli import screen

if TYPE_CHECKING:
    from frictionloop.report.alone import Shown
    from frictionloop.report.stroke_numbers import Row, Table

UNITS = {"_n_rthz": ("uN/rtHz", 1e6), "_n": ("mN", 1e3), "_ms": ("ms", 1.0), "_hz": ("Hz", 1.0)}
"""What numbers are shown in, by the end of their names."""
HEADS = {"r2_regression": "R2 regr.", "r2_identity": "R2 ident.", "r2_bound": "R2 bound"}
NARROW = {
    "sensitivity_peak": "Ms",
    "sensitivity_peak_moist": "moist",
    "r2_regression": "R2",
    "r2_identity": "id.",
    "spread_n": "spread",
    "error_n": "error",
    "open_error_n": "open",
}
HIDDEN = ("scored", "stable_from_n")
"""Numbers that a line tells, where they are no matter of course."""
ALONE = ("sensitivity_peak", "sensitivity_peak_moist", "error_n", "open_error_n")
"""Numbers that are shown of each change alone, beside a long name and the errors at each level."""
WIDTH = 90
UNTOLD = 5e-4
"""Share of the time from which on it is told: less is 0.0 % (chosen)."""
STROKES = (
    "Ms: largest peak of sensitivity of the linear loop of this finger, just landed, at those of the forces asked for, "
    "{}, that it can be given; ∞ is unstable. moist: the same at the end of the last stroke, {} occluded. "
    "R2: of the regression, large even of a loop that rings; id.: about f_a = f_r. Spread and error in mN."
)
"""Heads of the numbers of Fig. 5a, which are many, and what they mean."""
FACTORS = [
    "  spread divided by: the median of what it is divided by for each finger, which is not the",
    "  quotient of the medians beside it.",
]


def figure_text(figure: Shown) -> list[Any]:
    """Return a figure for a terminal: what was changed, its numbers, its seeds and where it is."""
    from frictionloop.report.changed_runs import bench_of, words
    from frictionloop.report.cited import cited
    from frictionloop.report.figures.closed_loop import GIVEN

    strokes = any("sensitivity_peak" in row for row in figure.numbers.values())
    other = "not the paper's bench" if bench_of(figure.changed) else "with gains as given"
    before = ["  the bench unchanged:", _table(figure.unchanged)] if figure.unchanged else []
    names = [name for name, row in figure.numbers.items() if row.get("kp") is not None]
    gains = GIVEN if GIVEN in names else next(iter(names), "")
    alone = {
        name: {key: value for key, value in row.items() if key.startswith("error_at_") or key in ALONE}
        for name, row in figure.alone.items()
    }
    said = f"what each change does, {gains}; open: error in open loop; then the error at each level:"
    one = [*_indented(said), _table(alone)] if alone else []
    return [
        figure.name + (f", {other}: {words(figure.changed)}" if figure.changed else ""),
        *([_table(figure.numbers)] if figure.numbers else []),
        *_answer(figure, gains),
        *(each for line in figure.told for each in _indented(line)),
        *one,
        *before,
        *(_indented(STROKES.format(_asked(figure), _moist(figure))) if strokes else []),
        *_stable_from(figure.numbers),
        *_scored(figure.numbers),
        *(FACTORS if any("spread_divided_by" in row for row in figure.numbers.values()) else []),
        *_checked(figure),
        f"  cite: {' · '.join(cited(figure.command, figure.seeds))}",
        f"The figure: {figure.file}",
        "  beside it the same as .png",
    ]


def _answer(figure: Shown, name: str) -> list[str]:
    """Return what gains do on a changed bench, and which to use there; nothing of a figure that is not checked."""
    from frictionloop.report.figures.closed_loop import HOLDS

    there = figure.checked.places.get(name)
    if there is None:
        return []
    errors = [_shown("error_n", row["error_n"]) for row in (figure.numbers[name], figure.unchanged.get(name)) if row]
    usual = figure.checked_before.places.get(name)
    was = f", unchanged at {usual.held}" if usual else ""
    said = [
        f"{name}: {', unchanged '.join(errors)} mN of error; they hold at {there.held} of {there.places} slip lengths "
        f"and speeds looked at{was}"
    ]
    if HOLDS in figure.numbers:
        row, before = figure.numbers[HOLDS], figure.unchanged.get(HOLDS)
        own = f" (unchanged {_integral(before)})" if before else ""
        said.append(
            f"where slip length and speed are not known use {HOLDS}, an integral alone with the largest ki that holds "
            f"at all of them: {_integral(row)}{own}"
        )
    return [each for line in said for each in _indented(line)]


def _integral(row: Row) -> str:
    return f"{row['ki']:.4g} 1/s leaves {_shown('error_n', row['error_n'])} mN"


def _moist(figure: Shown) -> str:
    """Return how moist the finger is at the end of the last stroke."""
    from frictionloop.parameters import read_toml
    from frictionloop.report import protocol
    from frictionloop.report.stability import asked_for

    return f"{protocol.occlusion_at_end(read_toml(figure.bench) if figure.bench else asked_for({})):.0%}"


def _moistest(figure: Shown) -> str:
    """Return how moist the finger is that a check looks at."""
    from frictionloop.analysis.occlusions import moistest
    from frictionloop.parameters import read_toml

    assert figure.bench is not None  # as of every figure that is checked
    bench: Any = read_toml(figure.bench)
    lifts = ", as contact upon contact leaves it in the end" * (bench.motion.contact_s > 0)
    return f"{moistest(bench.friction, bench.motion):.0%} occluded{lifts}"


def _asked(figure: Shown) -> str:
    """Return the forces that the figure asks for, with those of the bench unchanged where they differ."""
    from frictionloop.report.changed_runs import sines_of

    def ends(changes: Mapping[str, Any]) -> str:
        sines = sines_of(changes)
        low, high = (end(sines.levels_n) + sign * sines.amplitude_n for end, sign in ((min, -1), (max, 1)))
        return f"{1e3 * low:.3g} to {1e3 * high:.3g} mN"

    here, usual = ends(figure.changed), ends({})
    alone = all(path.startswith("setpoint.") for path in figure.changed)
    return f"{here}, unchanged {usual}" if alone and here != usual else here


def _stable_from(numbers: Table) -> list[str]:
    """Return from which force on gains are stable, of those that are unstable at a lower one."""
    return [
        f"  {name}: stable from {1e3 * from_n:g} mN on, just landed"
        for name, row in numbers.items()
        if (from_n := row.get("stable_from_n")) is not None and row["sensitivity_peak"] == math.inf
    ]


def _indented(line: str) -> list[str]:
    return textwrap.wrap(line, WIDTH, initial_indent="  ", subsequent_indent="  ")


def _checked(figure: Shown) -> list[str]:
    """Return at how many slip lengths and speeds the gains hold on a changed bench, and the command that says more."""
    found, before = figure.checked, figure.checked_before
    if not found.places:
        return [each for line in found.said for each in _indented(line)]
    from frictionloop.report.changed_runs import bench_of

    changed = " on the changed bench" if bench_of(figure.changed) else ""
    lines = _indented(
        f"What frictionloop design check says of them{changed}: on this finger with its own load, slip length 0 and "
        f"its own, at its speed, half and four times that, just landed and {_moistest(figure)}, with the resonance off"
    )
    for name, there in found.places.items():
        ringing = f", unstable at {there.unstable}" if there.unstable else ""
        usual = before.places.get(name)
        was = f" (unchanged: {usual.held}, unstable at {usual.unstable})" if usual else ""
        lines.append(f"  {name}: hold at {there.held} of {there.places} slip lengths and speeds{ringing}{was}")
        lines += [f"    {where}" for where in there.unstable_on]
    name = found.best
    gains = [f"--controller.{each} {figure.numbers[name][each]:.4g}" for each in ("kp", "ki")]
    more = " ".join(["frictionloop design check", shlex.quote(str(figure.bench)), *gains])
    return [*lines, *_instead(figure), f"  More of {name}: {more}", *_people(figure)]


def _people(figure: Shown) -> list[str]:
    """Return the command that looks at gains which hold at all places on other people's fingers."""
    if not figure.checked.instead:
        return []
    gains = " ".join(f"--{path} {value:.4g}" for path, value in figure.checked.instead.items())
    said = "On how many other fingers these hold: "
    return [f"  {said}frictionloop design check {shlex.quote(str(figure.bench))} {gains} --fingers 100"]


def _speeds(figure: Shown) -> str:
    """Return the slowest and the fastest speed that a check looks at."""
    from frictionloop.design.elsewhere import FASTER, SLOWER
    from frictionloop.parameters import read_toml

    assert figure.bench is not None  # as of every figure that is checked
    motion: Any = read_toml(figure.bench).motion  # strokes, by the protocol
    return ",".join(f"{factor * motion.speed_mm_s:g}" for factor in (SLOWER, FASTER[-1]))


def _instead(figure: Shown) -> list[str]:
    """Return which gains would hold at all places."""
    from frictionloop.report.figures.closed_loop import HOLDS

    gains = figure.checked.instead
    if not gains:
        return []
    ki = f"{gains['controller.ki']:.4g}"
    if HOLDS not in figure.numbers:
        return _indented(f"an integral alone, kp 0 and ki {ki} 1/s, would hold at all of them")
    more = "it asks for more, a finger as moist as slower strokes leave it, and the error that it tells is of one sine:"
    return [
        *_indented(f"a design may leave less, with a notch where the sensor rings; {more}"),
        f"    frictionloop design controller {shlex.quote(str(figure.bench))} --speeds {_speeds(figure)}",
    ]


def _table(numbers: Table) -> Any:
    columns = list(dict.fromkeys(name for row in numbers.values() for name in row if name not in HIDDEN))
    levels = {key: key.removeprefix("error_at_").replace("_n", " N") for key in columns if key.startswith("error_at_")}
    short = NARROW | levels if "sensitivity_peak" in columns else {}
    rows = [("", *(short.get(key) or _head(key) for key in columns), "")]  # no words behind the numbers
    rows += [(name, *(_shown(key, row.get(key)) for key in columns), "") for name, row in numbers.items()]
    return screen.table(rows)


def _scored(numbers: Table) -> list[str]:
    """Return a line where reversals, which do not count, take some of the time."""
    shares = [share for row in numbers.values() if (share := row.get("scored")) is not None]
    if not shares or 1 - min(shares) < UNTOLD:
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
