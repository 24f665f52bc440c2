"""Fig. 5a with something changed, bench or gains: its protocol, finger and seeds, beside the bench unchanged."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import xarray as xr

from frictionloop.design.controller_check import Check, check
from frictionloop.design.pi_synthesis import retune
from frictionloop.findings import Finding, shown
from frictionloop.loop.progress import Bar
from frictionloop.parameters import System
from frictionloop.parameters.unit_sanity import differing, unusual
from frictionloop.quantities import FrictionloopError, must_be
from frictionloop.report import protocol
from frictionloop.report.device import CONTROLLERS, IDEAL, OPEN, PRINTED, RETUNED_GAINS, fit, tracking
from frictionloop.report.figures.closed_loop import GIVEN, HERE, HOLDS, figure_closed_loop
from frictionloop.report.people import the_finger
from frictionloop.report.stability import asked_for, places_of
from frictionloop.report.stroke_numbers import Table, of_strokes

SHOWN = {"fig-5a": (OPEN, RETUNED_GAINS, HERE), "fig-5a-printed": (PRINTED, IDEAL)}
"""Figures that a changed bench has a meaning for, and their controllers."""
SINES = ("setpoint.offset_n", "setpoint.amplitude_n", "setpoint.frequency_hz")
"""What may be changed of the set-point; a mean of one's own makes the three sines one."""
GAINS = ("controller.kp", "controller.ki")
"""Gains of one's own, which get a panel of Fig. 5a."""
SET = ("motion.stroke_mm", "setpoint.kind", "controller.kind", "friction.kind", "finger.kind", "motion.kind")
"""What the protocol sets."""
NO_BENCH = (OPEN, IDEAL)
"""Controllers that no bench has, which are not checked."""
OF_REACH = ("FORCE-REACH", "PLACE-UNSEEN")
"""Findings of a check that are of bench and finger, whatever the gains."""
LETTERS = 36
"""Of a title, above each panel."""


class Changed(NamedTuple):
    """Fig. 5a on a changed bench or with gains of one's own."""

    figure: Any
    numbers: Table
    """By controller, as `of_strokes`."""
    unchanged: Table
    """The same of the bench that is not changed; empty of gains of one's own on it."""
    levels: dict[str, dict[str, float]]
    """Error at each level in N, by controller."""
    replaced: dict[str, tuple[Any, Any]]
    """What was changed: the value, and what this finger and bench have instead."""
    checks: dict[str, Check]
    """What `design.check` says of each pair of gains, on the finger and the forces of the figure."""
    checks_unchanged: dict[str, Check]
    bench: System
    """The changed bench under the finger of the figure, asked for all of its forces."""
    findings: tuple[Finding, ...]


def check_changes(names: Sequence[str], changes: Mapping[str, Any]) -> None:
    """Refuse figures and claims that are the paper's own, changes that the figure makes itself, and unknown ones.

    Raises
    ------
    FrictionloopError
        One of these.
    """
    if not names or any(name not in SHOWN for name in names):
        other = next((name for name in names if name not in SHOWN), "")
        raise must_be("only", other, f"{' or '.join(SHOWN)} where {next(iter(changes))} is changed")
    for path in changes:
        if path in SET:
            raise FrictionloopError(f"{path}: is set by the protocol of Fig. 5a")
    own = [path for path in GAINS if path in changes]
    if len(own) == 1:
        raise FrictionloopError(f"{next(path for path in GAINS if path not in own)}: is missing beside {own[0]}")
    if own and "fig-5a-printed" in names:
        raise FrictionloopError(f"{own[0]}: goes with fig-5a")
    setpoint: Any = protocol.the_bench().evolve(changes).setpoint
    if setpoint.amplitude_n <= 0.0:
        raise must_be(SINES[1], setpoint.amplitude_n, "above 0", "N")


def changed_figure(name: str, changes: Mapping[str, Any], bar: Bar) -> Changed:
    """Return the figure, which says what was changed, its numbers, and where its gains hold.

    Gains stand beside each other: those of the report, those that `retune` finds for this bench, gains of one's own,
    and an integral that holds at all slip lengths and speeds, if others do not.
    """
    bench, sines = bench_of(changes), sines_of(changes)
    # The bench unchanged is asked for the same, so that what the change does is seen alone.
    same = {path: value for path, value in changes.items() if path in SINES}
    same = {} if same == bench else same
    runs, numbers, checks, would = _compared(name, changes, bar)
    before, checks_before = Table(), dict[str, Check]()
    if bench:
        _, before, checks_before, _ = _compared(name, same, bar)
    gains = {path: changes[path] for path in GAINS if path in changes} or would
    held = {each: f"holds at {places_of(found)} slip\nlengths and speeds" for each, found in checks.items()}
    figure = figure_closed_loop(runs, list(runs), numbers, held | {HOLDS: "holds at all slip\nlengths and speeds"})
    other = "Not the paper's bench: " if bench else "With gains as given: "
    title = textwrap.wrap(other + words(changes), LETTERS * len(runs), break_long_words=False)
    figure.suptitle("\n".join(title), fontsize=8.5, x=0.01, ha="left")
    base, there = protocol.finger_system(the_finger()), asked_for({**bench, **gains}, sines)
    return Changed(
        figure=figure,
        numbers=numbers,
        unchanged=before,
        levels={each: errors_by_level(some) for each, some in runs.items()},
        replaced={path: (value, _value(base, path)) for path, value in changes.items()},
        checks=checks,
        checks_unchanged=checks_before,
        bench=there,
        findings=tuple(_findings(changes, there, checks)),
    )


def _compared(
    name: str, changes: Mapping[str, Any], bar: Bar
) -> tuple[dict[str, xr.Dataset], Table, dict[str, Check], Mapping[str, float]]:
    """Return runs, numbers and checks of each pair of gains, and the integral that holds where others do not."""
    bench, sines = bench_of(changes), sines_of(changes)
    given = {path: changes[path] for path in GAINS if path in changes}
    found: dict[str, Mapping[str, Any]] = {each: CONTROLLERS[each] for each in SHOWN[name] if each != HERE}
    if HERE in SHOWN[name] and (bench or not changes):  # not beside gains of one's own alone
        found[HERE] = retune(protocol.the_bench().evolve(bench)).overrides
    found |= {GIVEN: given} if given else {}
    there, checks = asked_for(bench, sines), dict[str, Check]()
    for each in (each for each in found if each not in NO_BENCH):
        bar.doing(f"design check, {each}")
        try:
            checks[each] = check(there.evolve(dict(found[each])))
        except FrictionloopError:  # no force is in reach, which the numbers show
            break
    tuned, would = checks.get(RETUNED_GAINS), dict[str, float]()
    if tuned is not None and all(each.places and not each.holds_everywhere for each in checks.values()):
        would = {"controller.kp": 0.0, **tuned.would_hold} if tuned.would_hold else {}
    found |= {HOLDS: would} if would else {}
    base = protocol.finger_system(the_finger()).evolve(protocol.with_path(bench))
    runs = dict[str, xr.Dataset]()
    for each, overrides in found.items():
        bar.doing(f"Fig. 5a{', unchanged' * (not changes)}, {each}")
        runs[each] = tracking(base, overrides, sines)
    return runs, of_strokes(runs, found, base, sines), checks, would


def _findings(changes: Mapping[str, Any], there: System, checks: Mapping[str, Check]) -> Iterator[Finding]:
    """Yield what is in doubt of the changes, and what of the forces is out of reach whatever the gains."""
    yield from unusual(there)
    yield from differing(there, changes)
    for found in list(checks.values())[:1]:
        yield from (each for each in found.findings if each.code in OF_REACH)
    rate_hz: float = protocol.the_bench().controller.rate_hz
    if there.controller.rate_hz != rate_hz:
        yield Finding("STROKES-DIFFER", value=there.controller.rate_hz, unit="Hz", limit=rate_hz)


def bench_of(changes: Mapping[str, Any]) -> dict[str, Any]:
    """Return what is changed of the bench."""
    return {path: value for path, value in changes.items() if path not in GAINS}


def sines_of(changes: Mapping[str, Any]) -> protocol.Sines:
    """Return the sines of a figure: one of a mean that is given."""
    mean, size, pace = (changes.get(path) for path in SINES)
    usual = protocol.THE_SINES
    return protocol.Sines(
        usual.levels_n if mean is None else (float(mean),),
        usual.amplitude_n if size is None else float(size),
        usual.frequency_hz if pace is None else float(pace),
    )


def errors_by_level(runs: xr.Dataset) -> dict[str, float]:
    """Return the rms error in N of each level of the set-point, by its name."""
    return {f"{at:g} N": fit(runs.sel(level=[at])).rms_n for at in runs["level"].values.tolist()}


def _value(system: System, path: str) -> Any:
    """Return a value of a system by dotted name; None where a block of another kind has none."""
    found: Any = system
    for part in path.split("."):
        found = getattr(found, part, None)
    return found


def words(changes: Mapping[str, Any]) -> str:
    """Return what was changed."""
    return ", ".join(f"{path} = {shown(value, 4)}" for path, value in changes.items())


def seeds_of(changes: Mapping[str, Any]) -> str:
    """Return the seeds of its runs."""
    return f"0 to {len(protocol.LOADS) * len(sines_of(changes).levels_n) - 1}"


def file_name(name: str, changes: Mapping[str, Any]) -> str:
    """Return the name of the figure's file without suffix.

    >>> file_name("fig-5a", {"sensor.resonance_hz": 200.0, "finger.slip_length_um": 0.0})
    'fig-5a-with-sensor.resonance_hz-200-finger.slip_length_um-0'
    """
    parts = (f"{path}-{value:g}" if isinstance(value, float) else f"{path}-{value}" for path, value in changes.items())
    return "-".join([name, "with", *parts])
