"""How each law is on the median finger: margins over levels and resonances, its steps, and a comparison as rows."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from frictionloop.analysis.linear import LinearLoop, linearise
from frictionloop.analysis.margins import Margins
from frictionloop.control.instruction_cost import worst_tick
from frictionloop.design.comparison import trial_protocol
from frictionloop.design.comparison.comparison_run import LawRuns, occluded_at
from frictionloop.design.comparison.comparison_scores import SCORES, spread
from frictionloop.design.comparison.trial_protocol import on_device
from frictionloop.design.population_margins import loop_gain
from frictionloop.loop.simulate import simulate
from frictionloop.parameters import System
from frictionloop.quantities import FrictionloopError

STEPS_S = 2.0
LEVEL_N = 0.6
"""Where |S| is taken: the middle of the levels."""
SHIFTS = (0.0, 0.05, 0.1)
"""How far off the device's resonance may be, either way."""
HIGH_GAIN = 2.7
"""Loop gain over the believed one, of a PI, of the finger that laws are tried on beside the median one."""


class Robustness(NamedTuple):
    """Margins of one law on the median finger, the worst over the levels; NaN where it has no linear loop."""

    sensitivity_peak: float = math.nan
    """Ms = max |1/(1 + G)| with the resonance as the bench says; infinite if unstable."""
    sensitivity_peak_5: float = math.nan
    """The same, worst with the true resonance up to 5 % off; then 10 %."""
    sensitivity_peak_10: float = math.nan
    sensitivity_peak_gain: float = math.nan
    """The same on the finger of `HIGH_GAIN`; then with the resonance 10 % lower."""
    sensitivity_peak_gain_low: float = math.nan
    gain_margin: float = math.nan
    """Factor on G nearest to 1 that makes the loop unstable."""
    phase_margin_deg: float = math.nan
    """Phase above -180 degrees at the crossover nearest to -1; negative beyond a resonance of a stable loop."""
    delay_margin_s: float = math.nan
    stable: bool | None = None
    """At all levels, with the true resonance up to 10 % off."""


def median_system(comparison: LawRuns, law: str, speed_mm_s: float, slip_length_um: float) -> System | None:
    """Return the bench with the median of the capable fingers under a law; None if none is capable."""
    some = trial_protocol.able(comparison.system, comparison.people, speed_mm_s, comparison.duration_s)
    finger = trial_protocol.median_finger(comparison.people, some)
    return None if finger is None else _with(comparison, law, speed_mm_s, slip_length_um, finger)


def _with(comparison: LawRuns, law: str, speed_mm_s: float, slip_length_um: float, finger: Mapping[str, Any]) -> System:
    at = trial_protocol.Condition(speed_mm_s, slip_length_um, trial_protocol.SINES[1])
    own = {path: value for path, value in finger.items() if path != "sensor.resonance_hz"}
    return comparison.system.evolve({**trial_protocol.overrides_of(at), **comparison.laws[law], **own})


def high_gain_finger(comparison: LawRuns, speed_mm_s: float) -> Mapping[str, Any] | None:
    """Return the capable finger whose loop gain is nearest to `HIGH_GAIN`; None if none is capable."""
    some = trial_protocol.able(comparison.system, comparison.people, speed_mm_s, comparison.duration_s)
    plain = comparison.system.evolve(
        {"controller.kind": "pi", "setpoint": trial_protocol.setpoint_of(trial_protocol.HOLDS[1])}
    )
    able = [comparison.people[i] for i in some.nonzero()[0]]
    gains = [loop_gain(plain.evolve({**each, "motion.speed_mm_s": speed_mm_s})) for each in able]
    return able[int(np.nanargmin(np.abs(np.log(gains) - math.log(HIGH_GAIN))))] if able else None


def loop_at(system: System, level_n: float, occlude_s: float) -> LinearLoop | None:
    """Return the loop for small signals around a level, None for a law that has none."""
    occluded = occluded_at(system, occlude_s)
    loop = linearise(system, force_n=level_n, occluded=occluded)
    try:
        return loop if loop.law else None
    except FrictionloopError:  # a law that is saturated or has no rest
        return None


def robustness(comparison: LawRuns, law: str, speed_mm_s: float, slip_length_um: float) -> Robustness:
    """Return the margins of a law at one speed and slip length."""
    system = median_system(comparison, law, speed_mm_s, slip_length_um)
    found = None if system is None else {shift: _around(system, shift, comparison.middle_s) for shift in SHIFTS}
    if found is None or any(each is None for margins in found.values() for each in margins):
        return Robustness()
    every: Mapping[float, Any] = found
    strong = high_gain_finger(comparison, speed_mm_s) or {}
    high = _with(comparison, law, speed_mm_s, slip_length_um, strong)
    as_told, low = (_peak(on_device(high, factor), comparison.middle_s) for factor in (1.0, 0.9))
    nominal: list[Margins] = every[0.0]
    peaks = [max(each.sensitivity_peak for shift in SHIFTS[: k + 1] for each in every[shift]) for k in range(3)]
    return Robustness(
        peaks[0],
        peaks[1],
        peaks[2],
        as_told,
        low,
        min((each.gain_margin for each in nominal), key=lambda factor: abs(math.log(factor))),
        min((each.phase_margin_deg for each in nominal), key=abs),
        min(each.delay_margin_s for each in nominal),
        all(each.stable for margins in every.values() for each in margins),
    )


def _around(system: System, shift: float, occlude_s: float) -> list[Margins | None]:
    true_hz: float = getattr(system.sensor, "resonance_hz", 0.0)
    factors = (1.0 - shift, 1.0 + shift) if shift and true_hz else (1.0,)
    found: list[Margins | None] = []
    for factor in factors:
        off = on_device(system, factor)
        loops = [loop_at(off, level, occlude_s) for level in trial_protocol.LEVELS_N]
        found += [None if loop is None else loop.margins() for loop in loops]
    return found


def _peak(system: System, occlude_s: float) -> float:
    """Return the largest Ms over the levels that a finger can be given."""
    loops = [loop_at(system, level, occlude_s) for level in trial_protocol.LEVELS_N]
    return max((math.nan if loop is None else loop.sensitivity_peak() for loop in loops), default=math.nan)


def step_traces(comparison: LawRuns, speed_mm_s: float) -> xr.Dataset:
    """Return ``f_r`` and ``f_a`` (N) over law, slip length and time: the first steps of the median finger.

    Empty if no finger is capable at that speed.
    """
    runs = []
    for law in comparison.laws:
        for z in trial_protocol.lengths_of(comparison.system):
            system = median_system(comparison, law, speed_mm_s, z)
            if system is None:
                return xr.Dataset()
            stepped = system.evolve({"setpoint": trial_protocol.setpoint_of(trial_protocol.STEPPED, STEPS_S)})
            run = simulate(stepped, STEPS_S, trial_protocol.noise_seed(comparison.seed, trial_protocol.STEPPED))[
                ["f_r", "f_a"]
            ]
            run.attrs = {}
            runs.append(run.expand_dims(law=[law], slip_length_um=[z]))
    traces = xr.combine_by_coords(runs, combine_attrs="drop")
    # Combining sorts by name; the order of the laws decides their colours; the longer length comes first.
    return traces.sel(law=list(comparison.laws), slip_length_um=list(trial_protocol.lengths_of(comparison.system)))  # type: ignore[return-value]


def sensitivities(
    comparison: LawRuns, speed_mm_s: float, frequency_hz: np.ndarray
) -> dict[tuple[str, float], np.ndarray | None]:
    """Return |S| by law and slip length around 0.6 N: None if a loop is unstable, no entry if it is not linear."""
    found: dict[tuple[str, float], np.ndarray | None] = {}
    for law in comparison.laws:
        for z in trial_protocol.lengths_of(comparison.system):
            system = median_system(comparison, law, speed_mm_s, z)
            loop = None if system is None else loop_at(system, LEVEL_N, comparison.middle_s)
            if loop is not None:
                found[law, z] = np.abs(loop.responses(frequency_hz)["S"]) if loop.is_stable() else None
    return found


Row = dict[str, Any]
MARGINS = dict.fromkeys((*Robustness._fields, "tick_instructions"), "1")
"""What the margins of a law are, with units."""
MARGINS |= {"phase_margin_deg": "deg", "delay_margin_s": "s"}


def score_rows(scored: xr.Dataset) -> list[Row]:
    """Return a row for each law, speed, contact, population and score: median and worst decile over fingers."""
    found = []
    for law in scored["law"].values:
        for v, speed in enumerate(scored["speed_mm_s"].values):
            able = scored["capable"].values[v]
            populations = {"all": np.ones_like(able), "capable": able}
            for z in scored["slip_length_um"].values:
                cell = scored.sel(law=law, speed_mm_s=speed, slip_length_um=z)
                for population, some in populations.items():
                    where = {"law": str(law), "speed_mm_s": float(speed), "slip_length_um": float(z)}
                    where |= {"population": population, "fingers": int(some.sum())}
                    found += [where | _spread(name, cell[name].values[some]) for name in SCORES]
    return found


def _spread(name: str, values: np.ndarray) -> Row:
    median, worst = spread(values, SCORES[name].larger_is_better)
    return {"score": name, "unit": SCORES[name].units, "median": median, "worst_decile": worst}


def margin_rows(comparison: LawRuns, done: Callable[[], Any] = lambda: None) -> list[Row]:
    """Return a row for each law, speed and slip length: margins for small signals, and instructions a tick.

    ``done()`` is called after each law.
    """
    found = []
    for law, overrides in comparison.laws.items():
        cost = {"tick_instructions": worst_tick(comparison.system.evolve(overrides).controller.kind)}
        for speed in comparison.speeds_mm_s:
            for z in comparison.cells["slip_length_um"].values:
                where = {"law": law, "speed_mm_s": speed, "slip_length_um": float(z)}
                found.append(where | robustness(comparison, law, speed, float(z))._asdict() | cost)
        done()
    return found


def tidy_rows(scored: list[Row], margins: list[Row]) -> list[Row]:
    """Return everything in one table: margins as scores of the median finger."""
    found = list(scored)
    for row in margins:
        where = {name: row[name] for name in ("law", "speed_mm_s", "slip_length_um")}
        for name, unit in MARGINS.items():
            value = math.nan if row[name] is None else float(row[name])
            about = {"population": "median capable finger", "fingers": 1, "score": name, "unit": unit}
            found.append(where | about | {"median": value, "worst_decile": math.nan})
    return found


def value_of(rows: list[Row], key: str, **where: Any) -> float:
    """Return one number of the rows, NaN where there is none."""
    for row in rows:
        if all(row[name] == value for name, value in where.items()):
            return float(row[key])
    return math.nan
