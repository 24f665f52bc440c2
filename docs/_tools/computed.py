"""Sphinx extension: what the pages insert as ``{{ name }}``, computed from the package when the pages are built."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bench_diagram
import filled
import findings_table
import protocol_tables
import sensor_tables
import tables
from page import command
from sphinx.application import Sphinx
from sphinx.config import Config
from sphinx.errors import ExtensionError

from frictionloop.parameters.plate_design import PlateDesign
from frictionloop.parameters.sensor_design import SensorDesign

VERBS = (
    *("simulate", "sweep", "compare", "reproduce", "design", "design sensor", "design plate", "design controller"),
    *("design check", "design limits", "explain"),
    *("effect", "effect list", "effect show", "effect check", "effect play", "effect import"),
    *("identify", "identify channels", "identify bench", "identify compare", "identify run"),
    "studio",
    *("firmware", "firmware export", "firmware law", "firmware build"),
    *("device", "device list", "device info", "device set", "device run", "device play", "device recover"),
    *("device clear", "device monitor", "device flash"),
    *("experiment", "experiment new", "experiment check", "experiment run", "experiment resume"),
    *("experiment amend", "experiment simulate", "experiment report", "experiment export", "experiment power"),
)


def substitutions(source: Path) -> dict[str, Any]:
    """Return every name that a page may insert."""
    found: dict[str, Any] = {
        "presets": tables.presets(),
        "metrics": tables.metrics(),
        "arrivals": tables.arrivals(),
        "arrivals_sentence": tables.arrivals_sentence(),
        "findings": findings_table.findings(),
        "design_plate": tables.design(PlateDesign),
        "design_sensor": tables.design(SensorDesign),
        "bench_diagram": bench_diagram.image(source),
    }
    found |= {f"parameters_{name}": tables.parameters(block) for name, block in tables.BLOCKS.items()}
    found |= {f"sensor_{name}": text for name, text in sensor_tables.texts().items()}
    found |= {f"protocol_{name}": text for name, text in protocol_tables.texts().items()}
    for words in ("", *VERBS):
        found[f"help_{words.replace(' ', '_') or 'all'}"] = f"```text\n{command(f'{words} --help'.strip())}```"
    return found


def compute(app: Sphinx, config: Config) -> None:
    """Fill in MyST's substitutions; stop where a page holds numbers that are not so."""
    if wrong := filled.changed(Path(app.confdir)):
        names = ", ".join(page.name for page in wrong)
        raise ExtensionError(f"{names}: numbers are not what the package computes; run python docs/_tools/filled.py")
    config.myst_substitutions = dict(config.myst_substitutions) | substitutions(Path(app.confdir))


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the extension; MyST reads its settings later, when the builder starts."""
    app.connect("config-inited", compute, priority=100)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
