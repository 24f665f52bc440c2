"""The loop's ``sensor`` block of a force sensor as TOML, and in words what noise it leaves out."""

from __future__ import annotations

from typing import Any

from frictionloop.cli import screen
from frictionloop.hardware.sensor.answers import SensorAnalysis, suspended_values
from frictionloop.hardware.sensor.block import omitted

SHOWN = 0.01
"""What load adds is said if it is more than this share of all noise at rest."""


def block_text(found: SensorAnalysis) -> list[Any]:
    """Return the block below the line that says what is not in it."""
    return [
        screen.columns([("not in the block", _left_out(found))]),
        "",
        "the sensor in the loop, as a block of a system's TOML file:",
        block_toml(found),
    ]


def block_toml(found: SensorAnalysis) -> str:
    """Return the loop's ``sensor`` block as TOML."""
    lines = ["[sensor]"]
    for name, value in suspended_values(found.design).items():
        lines.append(f'{name} = "{value}"' if isinstance(value, str) else f"{name} = {_digits(value)}")
    return "\n".join(lines)


def _left_out(found: SensorAnalysis) -> str:
    missing, rest, loaded = omitted(found.at_rest, found.at_range), found.at_rest, found.at_range
    terms = sorted(missing.at_rest_n.items(), key=lambda item: -item[1])
    forces = ", ".join(f"{name}{'*' if name == rest.dominant.name else ''} {rms_n:.1e}" for name, rms_n in terms)
    said = f"{forces}: together {missing.rest_rms_n:.1e} of all {rest.rms_n:.1e} N rms at rest"
    if missing.under_load_n > SHOWN * rest.rms_n:
        name = max((term for term in loaded.terms if term.white), key=lambda term: term.rms_n).name
        largest = ", the largest there" if name == loaded.dominant.name else ""
        said += f"; under {missing.force_n:g} N also {name} {missing.under_load_n:.1e} N rms{largest}"
    return f"{said}. The block has the electronics' noise at rest, and through adc_bits the converter's."


def _digits(value: float) -> str:
    return str(value) if isinstance(value, int) else repr(float(f"{value:.6g}"))
