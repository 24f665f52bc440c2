"""``frictionloop identify bench``: the recordings of a project file to the file of the bench and its certificate."""

from __future__ import annotations

import json as text
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from frictionloop.cli import checks, flags, screen
from frictionloop.quantities import FrictionloopError

if TYPE_CHECKING:
    from frictionloop.identification import Bench

ARGUMENTS = "FILE [OPTIONS]"
EXAMPLES = """Examples

  frictionloop identify bench lab.toml
  frictionloop identify bench lab.toml --out my-bench.toml --report certificate.html
"""
ProjectFile = Annotated[
    Path, Parameter(name="FILE", help="TOML file that lists the recordings and what each is.", group=flags.SYSTEM)
]
REPORTS = (".html",)


def command(
    file: ProjectFile,
    /,
    *,
    out: flags.Result[Path | None] = None,
    report: flags.Result[Path | None] = None,
    population: flags.Result[Path | None] = None,
    again: flags.Flag = False,
    without_refused: flags.Flag = False,
    json: flags.Json = False,
) -> None:
    """Turn a lab's recordings into the file of its bench: measured values, and "assumed" for the rest.

    Results are kept beside the project file: a recording that has not changed is not analysed twice.

    Parameters
    ----------
    out
        Write the system here (.toml), with a comment for each value.
    report
        Write the certificate here (.html); an older one is kept under a number.
    population
        Write the population of fingers here (.toml), for ``fl.fingers``.
    again
        Analyse everything anew.
    without_refused
        Go on without entries that are refused, and say which. Otherwise no bench is written, and the results of the
        others are kept.
    """
    checks.check_output("out", out, checks.SYSTEMS)
    checks.check_output("report", report, REPORTS)
    checks.check_output("population", population, checks.SYSTEMS)
    if report is not None:
        checks.check_drawing()
    from frictionloop.identification import bench, kept_results, to_toml
    from frictionloop.quantities import replacing

    kept = file.with_suffix(".results.json")
    with screen.waiting("analysing the recordings"), _pictured(file), _keeping(kept):
        found = bench(file, {} if again else _earlier(kept), without_refused=without_refused)
    _keep(kept, kept_results(found))
    older = None
    if population is not None:
        _write_population(found, population)
    if out is not None:
        with replacing(out) as beside:
            beside.write_text(to_toml(found), encoding="utf-8")
    if report is not None:
        from frictionloop.report.certificate import write_certificate

        with screen.waiting("drawing the certificate"):
            older = write_certificate(found, report)
    saved = {"bench": out, "certificate": report, "older certificate": older, "population": population}
    if json:
        screen.show_json(_as_json(found) | {"saved": saved})
        return
    screen.show(screen.columns(_rows(found)))
    for part in found.parts:
        screen.show("", screen.columns([(part.kind, screen.wrapped(line).plain) for line in part.told]))
    if found.told:
        screen.show("", *(screen.wrapped(line) for line in found.told))
    if found.resonance_error is not None:
        design = f"frictionloop design controller {out or 'my-bench.toml'} {found.design_flags}"
        ends = f" --corners {report}" if report and found.corners else ""
        screen.show("", f"gains for it: {design}{ends}")
    screen.show(*screen.saved(saved))


def _write_population(found: Bench, path: Path) -> None:
    import tomlkit

    from frictionloop.quantities import FrictionloopError, replacing

    if found.people is None:
        raise FrictionloopError(
            'population: slides of three fingers at least are needed; accepted: finger = "..." in the entries of kind '
            "slides or amplitude"
        )
    with replacing(path) as beside:
        tree = found.people.population.model_dump()
        beside.write_text(tomlkit.dumps(tree), encoding="utf-8")


def _keep(path: Path, results: Mapping[str, Any]) -> None:
    from frictionloop.quantities import replacing

    with replacing(path) as beside:
        beside.write_text(text.dumps(results, default=_number), encoding="utf-8")


@contextmanager
def _keeping(path: Path) -> Iterator[None]:
    """Keep the results of the entries that were analysed when another one is refused."""
    from frictionloop.identification.entries import Unfinished

    try:
        yield
    except Unfinished as unfinished:
        _keep(path, unfinished.results)
        raise


@contextmanager
def _pictured(file: Path) -> Iterator[None]:
    """Draw what an analysis saw when it refused, and name the picture in its line."""
    from frictionloop.identification.refused import Refused

    try:
        yield
    except Refused as refused:
        from frictionloop.report.refusal import draw_refused

        picture = file.with_suffix(".refused.png")
        drawn = draw_refused(refused, picture)
        raise FrictionloopError(f"{refused}; picture: {picture}" if drawn else str(refused)) from None


def _earlier(path: Path) -> dict[str, Any]:
    """Return the results of the last time, none if there are none that can be read."""
    with suppress(OSError, ValueError):
        found = text.loads(path.read_text(encoding="utf-8"))
        if isinstance(found, dict):
            return found
    return {}


def _number(value: Any) -> Any:
    return value.tolist() if hasattr(value, "tolist") else str(value)


def _rows(found: Bench) -> list[tuple[str, ...]]:
    rows: list[tuple[str, ...]] = []
    for each in found.measured.values():
        between = f"{each.between:.1g} between files" if len(each.files) > 1 else "one file"
        lines = f"{each.within:.1g} within a file, {between}, {each.method:.1g} of the method"
        rows.append((each.path, f"{each.estimate} (standard errors: {lines}), {each.how}"))
    return rows


def _as_json(found: Bench) -> dict[str, Any]:
    return {
        "project": str(found.project),
        "measured": [each.as_dict() for each in found.measured.values()],
        "stated": dict(found.stated),
        "parts": [{"kind": part.kind, "files": part.files, "told": part.told} for part in found.parts],
        "analysed": found.analysed,
        "resonance_error": found.resonance_error,
        "design_flags": found.design_flags,
        "corners": [each._asdict() for each in found.corners],
        "together": found.told,
        "refused": [each._asdict() for each in found.refused],
        "population": None if found.people is None else found.people.population.model_dump(),
        "system": found.system.model_dump(),
    }
