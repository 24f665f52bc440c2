"""The default screens of sweeps and of comparisons, as they are: FRICTIONLOOP_GOLDEN=1 writes them anew."""

from __future__ import annotations

import pytest
from golden import check_screen

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
    answer = frictionloop(*SCREENS[name])
    assert answer.code == 0
    check_screen(name, answer.out)
