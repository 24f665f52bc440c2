"""The file of a bench: a comment tells of each value whether it is measured, stated, chosen or assumed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from frictionloop.identification.measured import Measured
from frictionloop.quantities.version import package_version

if TYPE_CHECKING:
    from frictionloop.identification.bench_identification import Bench


BELIEVED = {
    "sensor.resonance_hz": "controller.model.resonance_hz",
    "sensor.q": "controller.model.resonance_q",
    "sensor.cutoff_hz": "controller.model.sensor_hz",
    "friction.nominal_n": "controller.model.nominal_n",
    "friction.susceptibility_per_um2": "controller.model.susceptibility_per_um2",
    "plate.max_amplitude_um": "controller.model.max_amplitude_um",
}
"""What the controller believes follows what was measured."""


def to_toml(found: Bench) -> str:
    """Return the System as TOML text; a comment says whether a value is measured, stated, chosen or assumed."""
    import tomlkit

    from frictionloop.parameters.written import to_toml

    document = tomlkit.parse(to_toml(found.system, every=False))
    said = {name: source_of(each) for name, each in found.measured.items() if "." in name}
    said |= {BELIEVED[name]: f"as {name}" for name in said if name in BELIEVED}
    said |= dict(found.stated)
    _comment(document, "", said)
    head = [f"# Bench of {found.project.name}, by frictionloop {package_version()}."]
    head += [f"# {each['path']}: sha256 {each['sha256']}" for part in found.parts for each in part.files]
    if (line := found.measured.get("sensitivity")) is not None:
        head.append(f"# sensitivity of the reading: {line.estimate} ({source_of(line)})")
    if found.resonance_error is not None:
        head.append(f"# gains for it: frictionloop design controller FILE {found.design_flags}")
    body = document.as_string().split("\n", 1)[1] if document.as_string().startswith("#") else document.as_string()
    return "\n".join(head) + "\n" + body


CHOSEN = ("setpoint.", "disturbance.", "controller.kp", "controller.ki", "motion.speed", "motion.stroke")


def _comment(table: Any, prefix: str, said: Mapping[str, str]) -> None:
    for key in list(table):
        item, name = table[key] if hasattr(table[key], "trivia") else table.item(key), f"{prefix}{key}"
        if hasattr(item, "keys"):
            _comment(item, f"{name}.", said)
        elif name not in ("schema",) and key != "kind":
            old = item.trivia.comment.lstrip("# ")
            word = said.get(name) or ("chosen" if name.startswith(CHOSEN) else "assumed") + (f"; {old}" if old else "")
            unit = old.partition(":")[0] if name in said and ":" in old and len(old.partition(":")[0]) < 8 else ""
            item.comment(f"{unit}: {word}" if unit else word)
            item.trivia.comment_ws = "  "


def source_of(each: Measured) -> str:
    """Return where a value comes from, with its interval."""
    files = each.files[0] if len(each.files) == 1 else f"{each.files[0]} and {len(each.files) - 1} more"
    return f"measured, {each.estimate} (95 %); {files}; {each.how}; {each.date}"
