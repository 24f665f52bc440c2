"""Measure frictionloop beside hand-written C and what people write today, in one run.

    python benchmarks/run.py                    every table and curve (about ten minutes)
    python benchmarks/run.py --quick            fewer repeats, slow contenders cut short
    python benchmarks/run.py --only grid        one section: one, grid, bench, start-up, cold or curves
    python benchmarks/run.py --docs             also draw docs/_static/benchmarks.svg

Contenders take turns, and the shortest of several repeats counts. Results go to latest.json and latest.md in
benchmarks/results/.
"""

from __future__ import annotations

import argparse
import json
from functools import partial
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.live import Live

import contenders
import curves
import ours
import tables
import targets
from build import Reference
from timing import Contender, commit_date, cores, machine, side_by_side

HERE = Path(__file__).parent
SECTIONS = ("one", "grid", "bench", "start-up", "cold", "curves")


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="fewer repeats; slow contenders run a shorter part")
    parser.add_argument("--only", choices=SECTIONS, action="append", help="measure this section alone (repeatable)")
    parser.add_argument("--patience-s", type=float, default=120.0, help="longest wait for a quiet machine per section")
    parser.add_argument("--date", help="date to print, by default that of the commit")
    parser.add_argument("--docs", action="store_true", help="draw the curves to docs/_static/benchmarks.svg")
    parser.add_argument("--results", type=Path, default=HERE / "results", help="folder of latest.json and latest.md")
    return parser.parse_args()


def rows(timed: list[Contender], differences: dict[str, float], lanes: int) -> list[dict[str, Any]]:
    work = lanes * contenders.PERIODS
    return [
        {
            "name": each.name,
            "seconds": each.best,
            "spread": each.spread,
            "rounds": len(each.seconds),
            "extrapolated": each.part < 1,
            "part": each.part,
            "periods_per_s": work / each.best,
            "difference": differences.get(each.name),
        }
        for each in timed
    ]


def measure(options: argparse.Namespace, console: Console) -> dict[str, Any]:
    wanted, threads = options.only or SECTIONS, cores()
    c = Reference()
    found = machine(c.version) | {"date": options.date or commit_date()}
    result: dict[str, Any] = {
        "machine": found,
        "threads": threads,
        "quick": options.quick,
        "sections": {},
        "curves": {},
    }
    sections = result["sections"]
    # Shown between the calls alone: a spinner's thread would take turns with what is measured.
    with Live(console=console, auto_refresh=False, transient=True) as live:
        tell = partial(live.update, refresh=True)
        if "one" in wanted:
            tell("checking that all traces agree")
            timed, differences = contenders.one_run(c, options.quick)
            sections["one run"] = rows(side_by_side(timed, options.patience_s, tell), differences, 1)
        if "grid" in wanted:
            tell("checking that all grids agree")
            timed, differences = contenders.grid(c, threads, options.quick)
            sections["grid"] = rows(side_by_side(timed, options.patience_s, tell), differences, 1024)
        if "bench" in wanted and ours.version():
            for name, timed, lanes in curves.bench(threads, options.quick):
                sections[name] = rows(side_by_side(timed, options.patience_s, tell), {}, lanes)
        if "start-up" in wanted:
            sections["start-up"] = rows(curves.start_up(options.patience_s, tell), {}, 1)
        if "cold" in wanted:
            sections["cold"] = rows(curves.cold(options.patience_s, tell), {}, 1)
        if "curves" in wanted:
            result["curves"] = curves.measure(c, options.patience_s, tell)
    best = {name: {row["name"]: row["seconds"] for row in section} for name, section in sections.items()}
    result["targets"] = [target.row() for target in targets.of(best, threads)]
    return result


def main() -> None:
    options, console = arguments(), Console()
    console = console if console.is_terminal else Console(width=130)
    if not ours.version():
        console.print("frictionloop is not installed: only the others are measured")
    result = measure(options, console)
    tables.show(result, console)
    options.results.mkdir(parents=True, exist_ok=True)
    (options.results / "latest.json").write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    (options.results / "latest.md").write_text(tables.markdown(result), encoding="utf-8")
    console.print(f"stored in {options.results / 'latest.json'} and latest.md")
    if options.docs and result["curves"]:
        curves.draw(result["curves"], HERE.parent / "docs" / "_static" / "benchmarks.svg")


if __name__ == "__main__":
    main()
