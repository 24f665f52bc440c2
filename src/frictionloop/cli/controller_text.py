"""A designed controller as a person and as a program is shown it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from frictionloop.cli import screen
from frictionloop.cli.comparison_text import number
from frictionloop.cli.controller_also import noise
from frictionloop.cli.controller_holds import ends_said
from frictionloop.design.worst_margins import Group, worst_margins

if TYPE_CHECKING:
    from frictionloop.analysis.headroom import Headroom
    from frictionloop.analysis.margins import Margins
    from frictionloop.design.corners import Corner
    from frictionloop.design.wanted import Designed, Wanted
    from frictionloop.parameters import System

Row = tuple[str, ...]
LEGEND = (
    "Ms: largest gain on a disturbance. gain, phase, delay left: what it takes besides to make the loop unstable; of "
    "phase the least turn, and whether it is one of lag or of lead."
)
"""Of the table of margins."""
UNITS = {"ki": "1/s", "k1": "sqrt(N)/s", "k2": "N/s^2"}
"""Units that a parameter's name does not tell."""


def gain_rows(values: Mapping[str, Any]) -> list[Row]:
    """Return one row per value of a law, by its dotted name."""
    rows: list[Row] = []
    for path, value in values.items():
        name = path.removeprefix("controller.")
        if name == "sections":
            rows.append(("sections", f"{len(value)} of second order; their coefficients are in the file and --json"))
        elif name == "notch_depth":
            rest = value / values["controller.notch_width"]
            rows.append((name, f"{value:.3g}; the notch lets {100 * rest:.2g} % through at notch_hz"))
        elif name != "kind":
            rows.append((name, _value(name, value)))
    return rows


def _value(name: str, value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    unit = UNITS.get(name, "Hz" if name.endswith("_hz") else "")
    return f"{value:.4g} {unit}".rstrip()


def margin_text(found: Sequence[Corner], wanted: Wanted) -> list[Any]:
    """Return the table of margins, worst over forces and strokes, per resonance on a dry and a moist finger."""
    moist = max(each.loop.elements.occluded for each in found)
    said = "margins, the worst of all that" + (f", the file's finger just landed/moist ({moist:.0%})" if moist else "")
    head: Row = ("resonance", "Ms", "asked", "gain", "phase, deg", "delay left, ms", "")
    worst = worst_margins(found)
    rows = [head, *(_margin_row(worst, off, wanted) for off in sorted({each.off for each in found}))]
    return [screen.wrapped(said), screen.table(rows), *map(screen.wrapped, [LEGEND, *ends_said(wanted)])]


def turn(phase_margin_deg: float, unit: str = "") -> str:
    """Return a phase margin by its size and direction: a stable loop may have a negative one, of lead."""
    if not math.isfinite(phase_margin_deg):
        return number(phase_margin_deg)
    return f"{abs(phase_margin_deg):.0f}{unit} {'lag' if phase_margin_deg >= 0 else 'lead'}"


def _margin_row(worst: Mapping[Group, Sequence[Margins]], off: float, wanted: Wanted) -> Row:
    groups = [worst[at] for at in sorted(worst) if at[0] == off]
    asked = {round(error, 9): peak for error, peak in wanted.limits.items()}[round(abs(off), 9)]

    def both(values: Sequence[float]) -> str:
        return "/".join(map(number, values))

    return (
        _off_by(off),
        both([max(m.sensitivity_peak for m in group) for group in groups]),
        f"{asked:.3g}",
        both([min((m.gain_margin for m in group), key=lambda factor: abs(math.log(factor))) for group in groups]),
        "/".join(turn(min((m.phase_margin_deg for m in group), key=abs)) for group in groups),
        both([1e3 * min(m.delay_margin_s for m in group) for group in groups]),
        "",
    )


def _off_by(off: float) -> str:
    return f"{100 * off:+.3g} %" if off else "as described"


def headroom_text(left: Headroom, wanted: Wanted) -> list[Any]:
    """Return what is left to gain, and what limits it."""
    lag, periods = left.lag, left.delay_periods
    rows: list[Row] = []
    if math.isfinite(left.least_rms_n):
        rows += [
            (
                "disturbance",
                _mn(left.disturbance_rms_n),
                f"friction noise, tremor and drift without control, rms; {_mn(left.disturbance_felt_rms_n)} of it from "
                "1 Hz on",
            ),
            (
                "this loop",
                _mn(left.residual_rms_n),
                f"of it left, without the sensor's noise; |S| is 1 at {number(left.zero_db_hz)} Hz",
            ),
            (
                "Bode's least",
                _mn(left.least_rms_n),
                f"of any linear law with Ms up to {wanted.sensitivity_peak:g}; |S| is 1 at "
                f"{number(left.least_zero_db_hz)} Hz; not to be had with sensor noise",
            ),
        ]
    rows += [noise(left.loop)]
    rows += [
        (
            "delay",
            f"{number(left.delay_limit_hz)} Hz",
            "no law crosses over higher with 45 deg of margin, whatever else it cancels; one that cancels nothing, not "
            f"above {number(left.plain_limit_hz)} Hz. A reading sees the answer to a force {periods} "
            f"period{'s' * (periods != 1)} later, as for any delay from {periods - 1} to below {periods} periods",
        ),
        (
            "phase lag",
            f"{_degrees(lag.total)} deg",
            f"where |S| is 1: springs {_degrees(lag.springs)}, plate and contact {_degrees(lag.plate)}, electronics "
            f"{_degrees(lag.electronics)}, delay {_degrees(lag.delay)}, hold {_degrees(lag.hold)}. The largest is "
            "not always what limits: a design with that part changed shows it",
        ),
    ]
    return ["what is left to gain, at the mean force on a dry finger", screen.columns(rows)]


def _degrees(angle: float) -> str:
    return f"{round(angle)}" if math.isfinite(angle) else "-"


def _mn(force_n: float) -> str:
    return f"{1e3 * force_n:.3g} mN"


def as_json(
    law: str, designed: Designed, system: System, wanted: Wanted, found: Sequence[Corner], left: Headroom
) -> dict[str, Any]:
    """Return everything by name, SI units."""
    lean = left._asdict()
    for name in ("loop", "frequency_hz", "sensitivity", "least"):
        del lean[name]
    lean["lag"] = left.lag._asdict() | {"fixed": left.lag.fixed, "total": left.lag.total}
    return {
        "law": law,
        "controller": dict(designed.overrides),
        "warnings": designed.warnings,
        "notes": designed.notes,
        "wanted": wanted_json(wanted),
        "margins": [
            {
                "resonance_off": each.off,
                "force_n": each.loop.elements.force_n,
                "occluded": each.loop.elements.occluded,
                "stroke": each.stroke.removeprefix(", "),
                **asdict(each.margins),
            }
            for each in found
        ],
        "headroom": lean,
        "people": designed.people and designed.people._asdict(),
        "system": system.model_dump(),
    }


def wanted_json(wanted: Wanted) -> dict[str, Any]:
    """Return what had to hold, with the limits."""
    return asdict(wanted) | {"limits": {f"{e:g}": peak for e, peak in sorted(wanted.limits.items())}}
