"""What a certificate holds for programs: measured values, and the corners at which gains have to hold."""

from __future__ import annotations

import json
import os
import re
from pathlib import Path
from typing import Any

from frictionloop.identification.agreement import Corner
from frictionloop.quantities import FrictionloopError

_HELD = re.compile(r'<script type="application/json" id="measured">(.*?)</script>', re.DOTALL)
ACCEPTED = "accepted: a certificate (.html) of identify bench, or what its --json printed"


def certified(path: str | os.PathLike[str]) -> Any:
    """Return what a certificate (.html), or the output of ``identify bench --json`` (.json), holds.

    Raises ``FrictionloopError`` for a file that cannot be read or holds nothing of the kind.
    """
    try:
        text = Path(path).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise FrictionloopError(f"{path}: cannot be read ({getattr(error, 'strerror', None) or error})") from None
    held = _HELD.search(text)
    try:
        return json.loads(held.group(1) if held else text)
    except ValueError:
        raise FrictionloopError(f"{path}: holds no measured values; {ACCEPTED}") from None


def certified_corners(path: str | os.PathLike[str]) -> tuple[Corner, ...]:
    """Return the ends of the intervals that a certificate lists: benches on which gains have to hold.

    Raises ``FrictionloopError`` for a file that cannot be read or lists none.
    """
    tree = certified(path)
    try:
        return tuple(Corner(str(each["path"]), float(each["value"]), str(each["side"])) for each in tree["corners"])
    except (ValueError, KeyError, TypeError):
        raise FrictionloopError(f"{path}: lists no corners; {ACCEPTED}") from None
