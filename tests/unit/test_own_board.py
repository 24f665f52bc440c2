"""The page on a board of one's own: its few lines are the law that the simulation runs."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.control.notch import notch_section

PAGE = Path(__file__).parents[2] / "docs" / "how-to" / "a-board-of-my-own.md"


@pytest.mark.parametrize(
    "setpoint", [fl.Constant(offset_n=0.5), fl.Sine(offset_n=0.5, amplitude_n=0.3, frequency_hz=3.0)]
)
@pytest.mark.parametrize(("delay_s", "forward"), [(200e-6, True), (200e-6, False), (480e-6, True), (750e-6, True)])
def test_the_lines_of_the_page_are_the_law(setpoint, delay_s, forward):
    (law, _) = re.findall(r"^```python\n(.*?)^```$", PAGE.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
    law = law.replace('"feedforward": True', f'"feedforward": {forward}, "delay_s": {delay_s}')
    there = {}
    exec(compile(law, str(PAGE), "exec"), there)
    run = fl.simulate(there["bench"].evolve({"setpoint": setpoint, "motion.contact_s": 0.5}), 2.0)
    signals = zip(run.f_r.values, run.f_m.values, run.sliding.values, strict=True)
    commands = np.array([there["tick"](*map(float, each))[0] for each in signals])
    assert 0.0 < run.sliding.values.mean() < 1.0
    np.testing.assert_allclose(commands, run.u.values, rtol=0, atol=1e-12)


def test_the_closed_form_of_the_page_is_the_notch():
    f0, fs, depth, width = 149.0, 4000.0, 0.05, 1.2
    t = math.tan(math.pi * f0 / fs)
    below = 1 + t**2 + 2 * width * t
    b1 = 2 * (t**2 - 1) / below
    expected = ((1 + t**2 + 2 * depth * t) / below, b1, (1 + t**2 - 2 * depth * t) / below)
    found = notch_section(f0, depth, width, fs)
    assert found == pytest.approx((*expected, b1, (1 + t**2 - 2 * width * t) / below), rel=1e-12)
