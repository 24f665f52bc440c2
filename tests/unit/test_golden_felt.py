"""What the verbs of effects, experiments and the report show: compared with the screens kept in tests/golden.

``FRICTIONLOOP_GOLDEN=1 pytest FILE`` writes them anew.
"""

from __future__ import annotations

import os
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import frictionloop as fl

GOLDEN = Path(__file__).parents[1] / "golden"
BENCH = fl.bench().evolve({"controller.kind": "notch_pi", "controller.feedforward": True})
R, X = fl.rendering, fl.experiments


def _imported():
    np.savetxt("cloth.csv", 0.4 + 0.1 * np.sin(np.arange(4000) / 7.0), header="force", comments="")
    return R.import_effect("cloth.csv", column="force", rate_hz=1000.0, speed_mm_s=40.0)


SHORT = {"timeline.stroke.length_mm": 10.0, "method.thresholds": 12, "method.spreads": 4, "method.levels": 8}


def _plan():
    return X.read_protocol("study-friction").evolve({**SHORT, "stop.trials": 15})


@cache
def _session():
    return X.run(_plan().evolve({"stop.trials": 5}), Path("P01"), "P01")


ANSWERS = {
    "effect-list": R.effects,
    "effect-check": lambda: R.check("grating", BENCH, 80.0),
    "effect-show": lambda: R.preview("grating", BENCH, 80.0, fingers=fl.fingers(4, 0)),
    "effect-play": lambda: R.play("bump", BENCH, 4.0),
    "effect-import": _imported,
    "experiment-new": lambda: X.new("mine.toml"),
    "experiment-check": lambda: X.check(X.read_protocol("jnd-friction-staircase")),
    "experiment-run": _session,
    "experiment-simulate": lambda: X.simulate(_plan(), participants=2, progress=False),
    "experiment-report": lambda: X.report(_session().folder),
    "experiment-export": lambda: X.export(_session().folder, "P01.csv", "csv"),
    "experiment-power": lambda: X.power(_plan(), 0.5, [4, 8], pool=3, studies=50),
    "studio-export": lambda: fl.studio.export("page.html"),
    "reproduce-claim": lambda: fl.reproduce(only=["resonance"]),
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("golden")


@pytest.mark.parametrize("name", ANSWERS)
def test_the_screen_is_as_kept(name, folder, monkeypatch):
    monkeypatch.chdir(folder)
    monkeypatch.setattr("frictionloop.report.results.cited_version", lambda: "VERSION")
    said = f"{ANSWERS[name]()}\n"
    path = GOLDEN / f"{name}.txt"
    if os.environ.get("FRICTIONLOOP_GOLDEN"):
        path.write_text(said, encoding="utf-8")
    assert said == path.read_text(encoding="utf-8")
    rows = said.splitlines()
    assert len(rows) <= 24 and max(map(len, rows)) <= 80
