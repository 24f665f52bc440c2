"""What a change does to Fig. 5a that its numbers alone do not say, in lines."""

from __future__ import annotations

import math
import statistics
from collections.abc import Mapping
from typing import Any

from frictionloop.analysis import operating_band, output_noise_rms_n
from frictionloop.analysis.operating import law_at, reach_n
from frictionloop.parameters import System
from frictionloop.physics.fingers import fingers
from frictionloop.quantities import FrictionloopError, unit_of
from frictionloop.report.changed_poles import moved
from frictionloop.report.changed_speed import speed
from frictionloop.report.device import CONTROLLERS, IDEAL, RETUNED_GAINS
from frictionloop.report.figures.closed_loop import HERE
from frictionloop.report.protocol import THE_SINES, Sines, occlusion_at_end, the_bench

NOISE = ("sensor.noise_density_n_rthz", "sensor.adc_bits", "sensor.range_n")
MEAN, DELAY, RATE = "setpoint.offset_n", "controller.delay_s", "controller.rate_hz"


def told(
    changes: Mapping[str, Any],
    base: System,
    rows: Mapping[str, Any],
    before: Mapping[str, Any],
    sines: Sines,
) -> list[str]:
    """Return the lines.

    Parameters
    ----------
    changes
        What was changed, by dotted names.
    base
        The bench with the protocol's finger, not changed.
    rows
        The numbers of the figure's controllers, by name.
    before
        The same of the bench unchanged; empty of gains of one's own on it.
    sines
        What the figure asks for.
    """
    return [
        *_own(changes, base, rows),
        *speed(changes, base, rows),
        *moved(changes, base, sines, RETUNED_GAINS in rows),
        *_amplitude(changes, base),
        *_sines(changes, before, sines),
        *_reach(base.evolve(changes), base, sines),
        *_delay(changes, base, rows),
        *_noise(changes, base, sines),
        *_here(changes, rows, before),
        *_unreached(changes, base, rows),
    ]


def _own(changes: Mapping[str, Any], base: System, rows: Mapping[str, Any]) -> list[str]:
    """Return what this finger had in the place of values that a finger brings."""
    said = []
    for path in (each for each in changes if each in fingers(1, 0)[0]):
        own, preset = (f"{_value(each, path):.3g} {unit_of(path) or ''}".rstrip() for each in (base, the_bench()))
        unchanged = f" (the preset's, for which {HERE} of the bench unchanged is found: {preset})" * (HERE in rows)
        said.append(f"{path} = {own}{unchanged}")
    return [f"this finger's own, which the change replaces: {', '.join(said)}"] if said else []


def _value(system: System, path: str) -> float:
    block, name = path.split(".")
    return float(getattr(getattr(system, block), name))


def _amplitude(changes: Mapping[str, Any], base: System) -> list[str]:
    """Return that another Q of the plate leaves its largest amplitude."""
    largest = "plate.max_amplitude_um"
    if "plate.q" not in changes or largest in changes:
        return []
    was: Any = base.plate
    plate: Any = base.evolve({"plate.q": changes["plate.q"]}).plate
    same_um = was.max_amplitude_um * plate.q / was.q
    return [
        f"{largest} stays {plate.max_amplitude_um:g}, as of another drive; with the same drive it scales with Q and is "
        f"{same_um:.3g}"
    ]


def _sines(changes: Mapping[str, Any], before: Mapping[str, Any], sines: Sines) -> list[str]:
    """Return that one sine has a smaller R2 than three together."""
    if MEAN not in changes:
        return []
    alone = before and all(path.startswith("setpoint.") for path in changes)
    other = "; below are the three" if alone else ", unchanged too" * bool(before)
    less = "" if _varies_n(sines) >= _varies_n(THE_SINES) else ": R2 is smaller, as the set-point varies less"
    return [f"one sine in place of the protocol's three{other}{less}; compare errors"]


def _varies_n(sines: Sines) -> float:
    """Return the standard deviation of the forces asked for."""
    return math.hypot(statistics.pstdev(sines.levels_n), sines.amplitude_n / math.sqrt(2.0))


def _reach(there: System, base: System, sines: Sines) -> list[str]:
    """Return which forces the finger cannot be given, whatever the gains; with what that was unchanged."""
    ends = [_band(each) for each in (there, base)]
    low_n, high_n = min(sines.levels_n) - sines.amplitude_n, max(sines.levels_n) + sines.amplitude_n
    (low, was_low), (high, was_high) = zip(*ends, strict=True)
    said = []
    if low_n < low:
        where = "at the end of the last stroke, moister than after one"
        said.append(f"below {low:.3g} N {where}{_was(low, was_low)}, and more where it presses harder")
    if high_n > high:
        said.append(f"above {high:.3g} N when it lands{_was(high, was_high)}, and more where it presses lighter")
    if said:
        return [f"out of this finger's reach at its mean load, whatever the gains: forces {'; '.join(said)}"]
    was = [f"below {was_low:.3g} N when moist"] * (low_n < was_low)
    was += [f"above {was_high:.3g} N when it lands"] * (high_n > was_high)
    if not was:
        return []
    return [f"all forces are in this finger's reach at its mean load; unchanged, those {' and '.join(was)} are not"]


def _was(now_n: float, before_n: float) -> str:
    return " (as unchanged)" if f"{now_n:.3g}" == f"{before_n:.3g}" else f" (unchanged {before_n:.3g})"


def _band(system: System) -> tuple[float, float]:
    """Return the least force at the end of the last stroke, and the largest on landing, at the mean load, N."""
    moist = occlusion_at_end(system)
    return reach_n(system, law_at(system, moist))[0], reach_n(system, law_at(system, 0.0))[1]


def _delay(changes: Mapping[str, Any], base: System, rows: Mapping[str, Any]) -> list[str]:
    """Return the delay with what hold and integral add to it."""
    was, now = base.controller, base.evolve(changes).controller
    if (now.delay_s, now.rate_hz) == (was.delay_s, was.rate_hz):
        return []
    period_s, beside = 1.0 / now.rate_hz, f'; not of "{IDEAL}"' if IDEAL in rows else ""
    lines = [
        f"controller.delay_s = {now.delay_s:g}: {1e3 * (now.delay_s + 0.5 * period_s):.3g} ms with half a period of "
        f"hold, {1e3 * (now.delay_s + period_s):.3g} ms with that of the integral{beside}"
    ]
    if now.rate_hz != was.rate_hz and DELAY not in changes and math.isclose(was.delay_s * was.rate_hz, 1.0):
        lines.append(f"a controller that computes for one period has controller.delay_s = {period_s:g} at this rate")
    if now.rate_hz != was.rate_hz:
        lines.append(
            "at another control rate the same seeds give other strokes, as tremor, drift and roughness are drawn once "
            "a period: spread and error of all controllers change by a few mN by chance"
        )
    return lines


def _noise(changes: Mapping[str, Any], base: System, sines: Sines) -> list[str]:
    """Return what the noise of the sensor makes of the force, which is too little to be seen in it."""
    if not any(path in changes for path in NOISE):
        return []
    force_n = sum(sines.levels_n) / len(sines.levels_n)
    found = []
    for system in (base.evolve(changes), base):
        try:
            (loop,) = operating_band(system.evolve(CONTROLLERS[RETUNED_GAINS]), [force_n], [0.0])
            found.append(1e6 * output_noise_rms_n(loop))
        except FrictionloopError:  # unstable, or out of reach
            return []
    if not all(map(math.isfinite, found)) or math.isclose(*found, rel_tol=0.01):
        return []
    return [
        f"noise of the sensor in the force: {found[0]:.3g} uN rms (unchanged {found[1]:.3g}), by the linear loop of "
        f"the {RETUNED_GAINS} at {force_n:.3g} N"
    ]


def _here(changes: Mapping[str, Any], rows: Mapping[str, Any], before: Mapping[str, Any]) -> list[str]:
    """Return for which finger gains were found anew, and that the change does not alter them."""
    if HERE not in rows or HERE not in before:
        return []
    forces = "these forces" if any(path.startswith("setpoint.") for path in changes) else "its forces"
    said = f"{HERE}: by fl.retune for one slip length and speed, the finger of the preset and {forces}, as the "
    said += f"{RETUNED_GAINS} were; this finger is another, and so is its Ms"
    pairs = [[each[HERE][name] for name in ("kp", "ki")] for each in (rows, before)]
    if all(math.isclose(now, was, rel_tol=1e-3, abs_tol=1e-6) for now, was in zip(*pairs, strict=True)):
        said += ". The change does not alter them: they are those of the bench unchanged too"
    return [said]


def _unreached(changes: Mapping[str, Any], base: System, rows: Mapping[str, Any]) -> list[str]:
    """Return which changes the ideal sensor takes away again."""
    if IDEAL not in rows:
        return []
    paths = [path for path, to in changes.items() if _taken_away({path: to}, base)]
    return [f'{" and ".join(paths)} {"do" if len(paths) > 1 else "does"} not reach "{IDEAL}"'] if paths else []


def _taken_away(change: Mapping[str, Any], base: System) -> bool:
    ideal = CONTROLLERS[IDEAL]
    try:
        return base.evolve(change).evolve(ideal) == base.evolve(ideal)
    except FrictionloopError:  # has a meaning only beside another one, as noise_rms_n beside its kind of sensor
        return False
