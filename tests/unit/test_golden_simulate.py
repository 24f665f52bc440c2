"""What simulate shows, compared with the screens kept in tests/golden; ``GOLDEN=write pytest FILE`` writes them."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.findings import CATALOGUE

GOLDEN = Path(__file__).parents[1] / "golden"


def _recorded():
    at_s = np.arange(4000) / 1000.0
    force_n = 0.3 + 0.02 * np.sin(3.0 * at_s) + 0.01 * np.sin(150.0 * at_s)
    np.savetxt("slide.csv", np.c_[at_s, force_n], header="time_s,Ft [N]", comments="", delimiter=",")
    slide = fl.Recording(path="slide.csv", column="Ft", remove_mean=True)
    run = fl.simulate(fl.bench().evolve({"disturbance": slide, "motion.stroke_mm": 40.0} | fl.RETUNED), 3.0)
    return fl.diagnose(run, split_hz=(8,))


ANSWERS = {
    "simulate": lambda: fl.diagnose(fl.simulate(fl.bench())),
    "simulate-paper": lambda: fl.diagnose(fl.simulate(fl.paper())),
    "simulate-recorded": _recorded,
}


@pytest.mark.parametrize("name", ANSWERS)
def test_the_screen_is_as_kept(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    found = ANSWERS[name]()
    said = f"{found}\n"
    if os.environ.get("GOLDEN") == "write":
        (GOLDEN / f"{name}.txt").write_text(said, encoding="utf-8")
    assert said == (GOLDEN / f"{name}.txt").read_text(encoding="utf-8")
    assert len(said.splitlines()) <= 24 and max(map(len, said.splitlines())) <= 80
    assert {each.code for each in found.findings} <= CATALOGUE.keys()
