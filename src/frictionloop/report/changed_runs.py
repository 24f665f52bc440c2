"""The strokes of a changed Fig. 5a: its protocol and seeds, on a bench or with gains that are not the paper's."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import xarray as xr

from frictionloop.design.pi_synthesis import retune
from frictionloop.loop.progress import Bar
from frictionloop.quantities import FrictionloopError
from frictionloop.report import protocol
from frictionloop.report.device import CONTROLLERS, IDEAL, OPEN, PRINTED, RETUNED_GAINS, fit, tracking
from frictionloop.report.figures.closed_loop import GIVEN, HERE
from frictionloop.report.numbers import number
from frictionloop.report.people import the_finger
from frictionloop.report.stroke_numbers import Table, of_strokes

SHOWN = {"fig-5a": (OPEN, RETUNED_GAINS, HERE), "fig-5a-printed": (PRINTED, IDEAL)}
"""Figures that a changed bench has a meaning for, and their controllers."""
SINES = ("setpoint.offset_n", "setpoint.amplitude_n", "setpoint.frequency_hz")
"""What may be changed of the set-point; a mean of one's own makes the three sines one."""
GAINS = ("controller.kp", "controller.ki")
"""Gains of one's own, which get a panel of Fig. 5a."""
UNCHANGED, TOGETHER = "nothing changed", "all together"
"""What stands beside the changes alone."""


def bench_of(changes: Mapping[str, Any]) -> dict[str, Any]:
    """Return what is changed of the bench."""
    return {path: value for path, value in changes.items() if path not in GAINS}


def tracked(name: str, changes: Mapping[str, Any], bar: Bar) -> tuple[dict[str, xr.Dataset], Table]:
    """Return the strokes of each controller on a bench, and their numbers."""
    of_bench = bench_of(changes)
    again = HERE in SHOWN[name] and (of_bench or not changes)  # found anew, but not beside gains of one's own alone
    found = {HERE: retune(protocol.the_bench().evolve(of_bench)).overrides} if again else {}
    if gains := {path: changes[path] for path in GAINS if path in changes}:
        found[GIVEN] = gains
    controllers = {
        each: {**CONTROLLERS, **found}[each] for each in (*SHOWN[name], GIVEN) if each in {**CONTROLLERS, **found}
    }
    runs, numbers = dict[str, xr.Dataset](), Table()
    for each, overrides in controllers.items():
        bar.doing(f"Fig. 5a on {'another bench' if of_bench else 'the bench unchanged'}, {each}")
        more, rows = runs_of({each: overrides}, changes)
        runs, numbers = runs | more, numbers | rows
    return runs, numbers


def runs_of(
    controllers: Mapping[str, Mapping[str, Any]], changes: Mapping[str, Any]
) -> tuple[dict[str, xr.Dataset], Table]:
    """Return the strokes of some controllers, and their numbers."""
    base, sines = protocol.finger_system(the_finger()).evolve(protocol.with_path(bench_of(changes))), sines_of(changes)
    runs = {each: tracking(base, overrides, sines) for each, overrides in controllers.items()}
    return runs, of_strokes(runs, controllers, base, sines)


def sines_of(changes: Mapping[str, Any]) -> protocol.Sines:
    """Return the sines of a figure: one of a mean that is given."""
    names = {path: float(changes[path]) for path in SINES if path in changes}
    mean, size, pace = (names.get(path) for path in SINES)
    usual = protocol.THE_SINES
    return protocol.Sines(
        usual.levels_n if mean is None else (mean,),
        usual.amplitude_n if size is None else size,
        usual.frequency_hz if pace is None else pace,
    )


def each_alone(name: str, changes: Mapping[str, Any], bar: Bar) -> Table:
    """Return the numbers of the first gains of a figure with one change at a time, by what it is.

    The error in open loop and that at each level are among them, and the bench unchanged and with all changes stand
    beside. Nothing of a single change. What is changed of the set-point counts as one; a change that has a meaning
    beside another one alone has no numbers.
    """
    groups: dict[str, dict[str, Any]] = {}
    for path, value in bench_of(changes).items():
        groups.setdefault("setpoint" if path in SINES else path, {})[path] = value
    gains = {path: changes[path] for path in GAINS if path in changes}
    pair = GIVEN if gains else next(each for each in SHOWN[name] if each != OPEN)
    controllers = {OPEN: CONTROLLERS[OPEN], pair: gains or CONTROLLERS[pair]}
    found = Table()
    if len(groups) < 2:
        return found
    of_each = {words(group): group for group in groups.values()}
    for which, group in {UNCHANGED: dict[str, Any](), **of_each, TOGETHER: bench_of(changes)}.items():
        bar.doing(f"Fig. 5a, {which}{' alone' * (which in of_each)}")
        try:
            runs, rows = runs_of(controllers, group)
        except FrictionloopError:  # noise_rms_n without its kind of sensor, say
            found[which] = {}
            continue
        more: dict[str, float | None] = {
            f"error_at_{at:g}_n": error_n for at, error_n in errors_by_level(runs[pair]).items()
        }
        found[which] = rows[pair] | {"open_error_n": rows[OPEN]["error_n"]} | more
    return found


def errors_by_level(runs: xr.Dataset) -> dict[float, float]:
    """Return the rms error in N of each level of the set-point, which a change of reach moves at one end alone."""
    return {at: fit(runs.sel(level=[at])).rms_n for at in runs["level"].values.tolist()}


def words(changes: Mapping[str, Any]) -> str:
    """Return what was changed."""
    return ", ".join(f"{path} = {_plain(value)}" for path, value in changes.items())


def _plain(value: Any) -> str:
    return number(value, 4) if isinstance(value, float) else str(value)
