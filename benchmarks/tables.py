"""The results as tables: on the terminal (rich) and in Markdown, from the same cells."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from rich.console import Console
from rich.table import Table

from contenders import OURS, C

Cells = tuple[str, list[str], list[list[str]]]
"""Title, header and rows of one table."""
TITLES = {
    "one run": "One run of 10 s with traces (50 000 control periods, noise drawn)",
    "grid": "32 x 32 gains, 10 s each, metrics only (51.2 million control periods)",
    "bench": "The bench block by block: 256 lanes with seeds of their own, 10 s each, metrics only",
    "effect": "The bench without and with an effect as its set-point: 256 lanes, 10 s each, metrics only",
    "population": "A population on the bench: 10 s each, three metrics",
    "start-up": "Fresh process, warm cache",
    "cold": "Fresh process, empty cache",
}
NOTES = (
    "Contenders take turns; the shortest round counts. Spread: median of the rounds over the shortest, minus one.",
    "(x): ran a part of the 10 s and was extrapolated.",
    "Difference, without noise: of one run, the largest in f_a in N (C from a solver with a relative tolerance of 1e-12"
    " over the first 0.2 s, the others from C); of the grid, the largest in R2 from C below Kp 15, above which the loop"
    " is chaotic.",
)


def duration(seconds: float) -> str:
    return (
        f"{seconds * 1e3:.2f} ms"
        if seconds < 0.01
        else f"{seconds * 1e3:.0f} ms"
        if seconds < 1
        else f"{seconds:.3g} s"
    )


def times(ratio: float) -> str:
    return f"{ratio:,.0f}" if ratio >= 100 else f"{ratio:.3g}"


def tables(result: dict[str, Any]) -> Iterator[Cells]:
    for name, rows in result["sections"].items():
        if rows and name in ("start-up", "cold"):
            yield (
                TITLES[name],
                ["", "time", "spread"],
                [[r["name"], duration(r["seconds"]), f"{r['spread']:.0%}"] for r in rows],
            )
        elif rows and name in ("bench", "effect", "population"):
            yield _bench(name, rows)
        elif rows:
            yield _section(name, rows, result["threads"])
    for name, curve in result["curves"].items():
        if curve:
            yield _curve(name, curve)
    if result["targets"]:
        yield "Targets", ["", "measured", "to reach", ""], [_target(target) for target in result["targets"]]


def _bench(name: str, rows: list[dict[str, Any]]) -> Cells:
    """In the order of the blocks, with what each adds per control period of a lane, over all threads."""
    cells, before = [], 0.0
    for row in rows:
        per_period = 1e9 / row["periods_per_s"]
        added = f"{per_period - before:.1f} ns" if row["name"].startswith("+") else ""
        cells.append([row["name"], duration(row["seconds"]), f"{row['spread']:.0%}"])
        cells[-1] += [times(row["periods_per_s"] / 1e6), f"{per_period:.1f} ns", added]
        before = before if row["name"].startswith(" ") else per_period
    return TITLES[name], ["", "time", "spread", "million periods/s", "per period", "added"], cells


def _section(name: str, rows: list[dict[str, Any]], threads: int) -> Cells:
    best = {row["name"]: row["seconds"] for row in rows}
    suffix = "" if name == "one run" else f", {threads} thread{'s' * (threads > 1)}"
    c, mine = best.get(f"{C}{suffix}"), best.get(f"{OURS}{suffix}")
    header = ["", "time", "spread", "million periods/s", f"/ {C}{suffix}", f"/ {OURS}{suffix}", "difference"]
    cells = [
        [
            row["name"] + (" (x)" if row["extrapolated"] else ""),
            duration(row["seconds"]),
            f"{row['spread']:.0%}",
            times(row["periods_per_s"] / 1e6),
            times(row["seconds"] / c) if c else "",
            times(row["seconds"] / mine) if mine else "",
            "" if row["difference"] is None else f"{row['difference']:.0e}",
        ]
        for row in sorted(rows, key=lambda row: row["seconds"])
    ]
    return TITLES[name], header, cells


def _curve(name: str, curve: dict[str, list[float]]) -> Cells:
    titles = {
        "lanes": "Cost against lanes (2 s of signal, 1 thread)",
        "duration_s": "Cost against duration in s (1 thread)",
        "threads": "Cost against threads (1024 lanes, 2 s)",
        "memory": "Peak memory in MiB of a process sweeping 64 lanes, against duration in s",
    }
    show = (lambda value: f"{value:.0f}") if name == "memory" else duration
    contenders = [key for key in curve if key != "x"]
    rows = [[f"{x:g}", *(show(curve[key][index]) for key in contenders)] for index, x in enumerate(curve["x"])]
    return titles[name], ["duration" if name == "memory" else name.removesuffix("_s"), *contenders], rows


def _target(target: dict[str, Any]) -> list[str]:
    measured = duration(target["value"]) if target["unit"] == "s" else times(target["value"])
    limit, sign = target["limit"], ">=" if target["at_least"] else "<="
    asked = "" if limit is None else f"{sign} {limit:g}{' s' if target['unit'] == 's' else ''}"
    return [target["what"], measured, asked, {True: "met", False: "missed", None: ""}[target["met"]]]


def setting(result: dict[str, Any]) -> str:
    found = result["machine"]
    packages = ", ".join(f"{name} {version}" for name, version in found["packages"].items())
    origin = ", ".join(f"{key} {found[key]}" for key in ("commit", "date") if found[key])
    quick = " Quick run: few repeats." if result["quick"] else ""
    return (
        f"{found['processor']}, {found['cores']} cores, {found['system']}, Python {found['python']},"
        f" {found['compiler']}; {packages}. {origin or 'not a commit'}.{quick}"
    )


def show(result: dict[str, Any], console: Console) -> None:
    console.print(setting(result), highlight=False)
    for title, header, rows in tables(result):
        console.print(f"\n{title}", style="bold", highlight=False)
        table = Table()
        for index, name in enumerate(header):
            table.add_column(name, justify="left" if index == 0 else "right")
        for row in rows:
            table.add_row(*row)
        console.print(table)
    for note in NOTES:
        console.print(note, highlight=False, style="dim")


def markdown(result: dict[str, Any]) -> str:
    parts = ["# Speed", setting(result)]
    for title, header, rows in tables(result):
        rule = ["---", *["---:"] * (len(header) - 1)]
        parts += [f"## {title}", "\n".join(f"| {' | '.join(row)} |" for row in (header, rule, *rows))]
    return "\n\n".join([*parts, *NOTES]) + "\n"
