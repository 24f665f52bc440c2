"""What a figure or a number of the report is cited by: version, command and seeds."""

from __future__ import annotations

from frictionloop.quantities.version import cited_version


def command_of(name: str) -> str:
    """Return the command that makes a figure again."""
    return f"frictionloop reproduce --only {name}"


def cited(command: str, seeds: str) -> tuple[str, str, str]:
    """Return version, command and seeds in words; of a clone the version ends with the commit."""
    words = f"seeds {seeds}" if seeds not in ("none", "") else "no random numbers"
    return f"frictionloop {cited_version()}", command, words
