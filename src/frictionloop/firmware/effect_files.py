"""What a device is given of an effect, as a file for a person and for other hosts."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from frictionloop.firmware.effect_tables import HEAD, STEP, EffectTables
from frictionloop.quantities import replacing
from frictionloop.quantities.schema import named


def tables_tree(tables: EffectTables) -> dict[str, Any]:
    """Return the steps by name with their fields, the values in N, and all words as they are sent."""
    size = STEP.itemsize // 2
    count = len(tables.program.code)
    steps = tables.words[HEAD : HEAD + count * size].copy().view(STEP)
    names, fields = named("steps"), (STEP.names or ())[1:-1]
    return {
        "steps": [{"what": names[int(step["what"])]} | {name: int(step[name]) for name in fields} for step in steps],
        "values_n": tables.program.values.tolist(),
        "words": tables.words.tolist(),
        "error_n": tables.error_n,
        "findings": [each.to_dict() for each in tables.findings],
    }


def write_tables(tables: EffectTables, path: Path) -> None:
    """Write these as JSON; the old file stays whole until the new one is complete.

    Raises
    ------
    FrictionloopError
        For a file that cannot be written.
    """
    with replacing(path) as beside:
        beside.write_text(json.dumps(tables_tree(tables)), encoding="utf-8")
