"""What a figure or a number of the report is cited by: version, command and seeds."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from frictionloop.quantities.version import cited_version


def command_of(name: str, changes: Mapping[str, Any] | None = None) -> str:
    """Return the command that makes a figure again, on a bench that is changed too.

    >>> command_of("fig-5a", {"sensor.resonance_hz": 200.0})
    'frictionloop reproduce --only fig-5a --sensor.resonance_hz 200'
    """
    return " ".join([f"frictionloop reproduce --only {name}", *flags_of(changes or {})])


def flags_of(overrides: Mapping[str, Any]) -> list[str]:
    """Return overrides as flags of the command line."""
    values = {path: f"{value:.9g}" if isinstance(value, float) else value for path, value in overrides.items()}
    return [f"--{path} {value}" for path, value in values.items()]


def cited(command: str, seeds: str) -> tuple[str, str, str]:
    """Return version, command and seeds in words; of a clone the version ends with the commit."""
    words = f"seeds {seeds}" if seeds not in ("none", "") else "no random numbers"
    return f"frictionloop {cited_version()}", command, words
