"""What the verbs of effects, experiments and the report show: compared with the screens kept in tests/golden.

``GOLDEN=write pytest FILE`` writes them anew.
"""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.quantities.version import cited_version

GOLDEN = Path(__file__).parents[1] / "golden"
BENCH = fl.bench().evolve({"controller.kind": "notch_pi", "controller.feedforward": True})
R, X = fl.rendering, fl.experiments


def _imported():
    np.savetxt("cloth.csv", 0.4 + 0.1 * np.sin(np.arange(4000) / 7.0), header="force", comments="")
    return R.import_effect("cloth.csv", column="force", rate_hz=1000.0, speed_mm_s=40.0)


ANSWERS = {
    "effect-list": R.effects,
    "effect-check": lambda: R.check("grating", BENCH, 80.0),
    "effect-show": lambda: R.preview("grating", BENCH, 80.0, fingers=fl.fingers(4, 0)),
    "effect-play": lambda: R.play("bump", BENCH, 4.0),
    "effect-import": _imported,
    "reproduce-claim": lambda: fl.reproduce(only=["resonance"]),
}


@pytest.mark.parametrize("name", ANSWERS)
def test_the_screen_is_as_kept(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    said = f"{ANSWERS[name]()}\n".replace(cited_version(), "VERSION")
    path = GOLDEN / f"{name}.txt"
    if os.environ.get("GOLDEN") == "write":
        path.write_text(said, encoding="utf-8")
    assert said == path.read_text(encoding="utf-8")
    rows = said.splitlines()
    assert len(rows) <= 24 and max(map(len, rows)) <= 80
