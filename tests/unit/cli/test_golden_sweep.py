"""The default screens of sweeps and of comparisons, as they are: FRICTIONLOOP_GOLDEN=1 writes them anew."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

GOLDEN = Path(__file__).parents[2] / "golden"
PI = ("--controller.kp", "0.05", "--controller.ki", "60")
LAWS = ("--laws", "lookup,retuned_pi")
SCREENS = {
    "sweep": ("sweep", "--preset", "feasible", "--duration-s", "1", "--over", "controller.kp=1:16:14:log"),
    "sweep-few": ("sweep", "--preset", "bench", "--duration-s", "1", "--over", "controller.kp=0.02,0.05,0.5"),
    "sweep-fingers": ("sweep", "--preset", "bench", *PI, "--duration-s", "2", "--fingers", "12"),
    "compare": ("compare", *LAWS, "--fingers", "22", "--speeds", "20", "--duration-s", "1.6"),
    "compare-effects": ("compare", *LAWS, "--fingers", "6", "--speeds", "80", "--effects", "bump"),
}


@pytest.mark.parametrize("name", SCREENS)
def test_the_default_screen(frictionloop, name):
    answer, file = frictionloop(*SCREENS[name]), GOLDEN / f"{name}.txt"
    if os.environ.get("FRICTIONLOOP_GOLDEN"):
        file.parent.mkdir(exist_ok=True)
        file.write_text(answer.out, encoding="utf-8")
    assert (answer.code, answer.out) == (0, file.read_text(encoding="utf-8"))
    lines = answer.out.splitlines()
    assert len(lines) <= 24 and max(map(len, lines)) <= 80
