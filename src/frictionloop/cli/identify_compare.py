"""``frictionloop identify compare``: two certificates of a bench, and what has changed between them."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

import frictionloop as fl
from frictionloop.cli import flags, screen

ARGUMENTS = "BEFORE AFTER [OPTIONS]"
EXAMPLES = ("certificate-1.html certificate.html",)
Before = Annotated[Path, Parameter(name="BEFORE", help="The older certificate (.html, or --json).", group=flags.SYSTEM)]
After = Annotated[Path, Parameter(name="AFTER", help="The newer one.", group=flags.SYSTEM)]


def command(before: Before, after: After, /, *, shown: screen.Shown = screen.BRIEFLY) -> None:
    """Compare two certificates of a bench: which values have changed beyond their uncertainty."""
    shown.show(fl.identify.compare(before, after))
