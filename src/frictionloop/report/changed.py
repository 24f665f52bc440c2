"""Fig. 5a with something changed, the bench or the gains: its protocol, its finger and its seeds."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import xarray as xr

from frictionloop.loop.progress import Bar
from frictionloop.parameters import RETUNED, System
from frictionloop.quantities import FrictionloopError
from frictionloop.report import protocol
from frictionloop.report.changed_check import Check
from frictionloop.report.changed_check import check as check_gains
from frictionloop.report.changed_runs import (
    GAINS,
    SHOWN,
    SINES,
    bench_of,
    each_alone,
    errors_by_level,
    runs_of,
    sines_of,
    tracked,
    words,
)
from frictionloop.report.changed_told import told
from frictionloop.report.cited import flags_of
from frictionloop.report.device import OPEN
from frictionloop.report.figures.closed_loop import HERE, HOLDS, figure_closed_loop
from frictionloop.report.numbers import number
from frictionloop.report.people import the_finger
from frictionloop.report.stability import asked_for, integral_alone
from frictionloop.report.stroke_numbers import Table

OTHER = {
    "fig-5a-population": "; by another protocol, with the re-tuned gains: frictionloop sweep --preset bench "
    "--controller.kp {kp:g} --controller.ki {ki:g} --setpoint.amplitude_n 0.3 --fingers 26 --fingers-seed 1 {changes}"
}
"""What does nearly the same on a changed bench."""
LETTERS = 36
"""Of a title, above each panel."""
KEPT = ("motion.stroke_mm", "setpoint.kind", "controller.kind", "friction.kind", "finger.kind", "motion.kind")


def check(names: Sequence[str], changes: Mapping[str, Any]) -> None:
    """Refuse figures and statements that are the paper's own, changes that the figure makes itself, and unknown ones.

    Raises
    ------
    FrictionloopError
        One of these.
    """
    has = " and ".join(SHOWN)
    if not names:
        raise FrictionloopError(f"{next(iter(changes))}: a changed bench is not the paper's; name {has} with only")
    for name in names:
        if name not in SHOWN:
            raise FrictionloopError(
                f"only = {name!r}: is of the paper's own bench; a changed one has {has} alone{_other(name, changes)}"
            )
    for path in changes:
        if path in KEPT:
            raise FrictionloopError(
                f"{path}: is set by the protocol of Fig. 5a, sines on strokes under a PI; change the bench, its gains, "
                f"speed and load of the strokes, or {', '.join(SINES)}"
            )
    given = [path for path in GAINS if path in changes]
    if len(given) == 1:
        missing = next(path for path in GAINS if path not in changes)
        raise FrictionloopError(f"{missing}: is missing beside {given[0]}; give both gains")
    if given and "fig-5a-printed" in names:
        raise FrictionloopError('only = "fig-5a-printed": is of the printed gains; gains of your own are for fig-5a')
    setpoint: Any = protocol.the_bench().evolve(changes).setpoint
    if setpoint.amplitude_n <= 0.0:
        raise FrictionloopError(
            f"{SINES[1]} = {setpoint.amplitude_n:g} N: must be above 0; R2 is of a set-point that varies"
        )


def _other(name: str, changes: Mapping[str, Any]) -> str:
    """Return the command that does nearly the same as a figure with the changes; empty where none does."""
    kp, ki = RETUNED.values()
    return OTHER.get(name, "").format(kp=kp, ki=ki, changes=" ".join(flags_of(changes)))


class Drawn(NamedTuple):
    """A figure on a changed bench."""

    figure: Any
    numbers: Table
    unchanged: Table
    """The same numbers of the bench that is not changed."""
    alone: Table
    """With one change at a time, the numbers of the first gains of the figure; empty of a single change."""
    checked: Check
    """What ``design check`` says of each pair of gains on the changed bench."""
    checked_before: Check
    """The same of the report's gains on the bench that is not changed; of nothing where it is that."""
    bench: System
    """The changed bench under the finger that is drawn, asked for all of its forces."""
    told: list[str]
    """What the numbers do not say of the change."""


def drawn(name: str, changes: Mapping[str, Any], bar: Bar) -> Drawn:
    """Return the figure, which says what was changed, and its numbers.

    Two pairs of gains are told apart: `RETUNED`, as given, and those that `retune` finds for either bench.
    """
    runs, numbers = tracked(name, changes, bar)
    found = check_gains(numbers, bench_of(changes), sines_of(changes), bar)
    if OPEN in numbers and found.instead:
        bar.doing(f"Fig. 5a, {HOLDS}")
        more, rows = runs_of({HOLDS: found.instead}, changes)
        runs, numbers = runs | more, numbers | rows
    held = {
        each: f"holds at {there.held} of {there.places}\nslip lengths and speeds"
        for each, there in found.places.items()
    }
    held |= {HOLDS: "holds at all slip\nlengths and speeds"}
    figure = figure_closed_loop(runs, list(runs), numbers, held)
    other = "Not the paper's bench: " if bench_of(changes) else "With gains as given: "
    title = textwrap.wrap(other + words(changes), LETTERS * len(runs), break_long_words=False)
    figure.suptitle("\n".join(title), fontsize=8.5, x=0.01, ha="left")
    # The bench unchanged is asked for the same, so that what the change does is seen alone.
    same = {path: value for path, value in changes.items() if path in SINES}
    same = {} if same == bench_of(changes) else same
    runs_before, before = tracked(name, same, bar) if bench_of(changes) else ({}, Table())
    own = {each: row for each, row in before.items() if each != HERE}
    usual = check_gains(own, bench_of(same), sines_of(same), bar)
    if HOLDS in numbers and runs_before:
        bar.doing(f"Fig. 5a on the bench unchanged, {HOLDS}")
        alone_before = usual.instead or integral_alone(asked_for(same, sines_of(same)))
        more, rows = runs_of({HOLDS: alone_before} if alone_before else {}, same)
        runs_before, before = runs_before | more, before | rows
    alone = each_alone(name, changes, bar)
    said = told(changes, protocol.finger_system(the_finger()), numbers, before, sines_of(changes))
    gains = {path: changes[path] for path in GAINS if path in changes} or found.instead or RETUNED
    there = asked_for(bench_of(changes) | dict(gains), sines_of(changes))
    said.append(_by_level(runs))
    said += [f"unchanged, {_by_level(runs_before)}"] if runs_before else []
    return Drawn(figure, numbers, before, alone, found, usual, there, said)


def _by_level(runs: Mapping[str, xr.Dataset]) -> str:
    """Return the error at each level in a line."""
    found = {each: errors_by_level(some) for each, some in runs.items()}
    levels = ", ".join(f"{at:g}" for at in next(iter(found.values())))
    listed = [f"{each} {', '.join(number(1e3 * error_n) for error_n in row.values())}" for each, row in found.items()]
    return f"error by level, {levels} N (mN): {'; '.join(listed)}"


def seeds_of(changes: Mapping[str, Any]) -> str:
    """Return the seeds of its runs."""
    return f"0 to {len(protocol.LOADS) * len(sines_of(changes).levels_n) - 1}"


def file_name(name: str, changes: Mapping[str, Any]) -> str:
    """Return the name of the figure's file without suffix.

    >>> file_name("fig-5a", {"sensor.resonance_hz": 200.0, "finger.slip_length_um": 0.0})
    'fig-5a-with-sensor.resonance_hz-200-finger.slip_length_um-0'
    """
    told = (f"{path}-{value:g}" if isinstance(value, float) else f"{path}-{value}" for path, value in changes.items())
    return "-".join([name, "with", *told])
