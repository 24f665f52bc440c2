"""What limits a notch on the bench: a design each with one part changed, by the command that a page names."""

from __future__ import annotations

import json
import shlex
import subprocess
import sys

from tables import table

COMMAND = "design controller --preset bench"
PARTS = {
    "as it is": "",
    "a resonance exactly as told": "--resonance-error 0",
    "a sensor's resonance of 1 kHz": "--sensor.resonance_hz 1000",
    "no computing delay": "--controller.delay_s 0",
    "for one slip length alone": "--slip-lengths-um 11.5",
    "a plate five times as fast": "--plate.q 46 --controller.model.plate_hz 500",
}
"""Flags of each bench."""


def notch_parts() -> str:
    """Return where |S| is 1 first, and what is left of friction noise, tremor and drift, by bench."""
    rows = []
    for name, flags in PARTS.items():
        words = [sys.executable, "-m", "frictionloop", *shlex.split(f"{COMMAND} {flags}"), "--json"]
        found = json.loads(subprocess.run(words, check=True, capture_output=True, text=True).stdout)["headroom"]
        left = f"{found['residual_mn']:.1f} of {found['disturbance_mn']:.0f} mN"
        rows.append((name, f"{found['zero_db_hz']:.0f} Hz", left, f"`{flags}`" if flags else ""))
    return table(("the bench", "$\\lvert S\\rvert$ reaches 1 at", "it leaves", f"`frictionloop {COMMAND}` with"), rows)
