"""How late commands come by chance: read back from the plate's amplitude, which is exponential before and after."""

from __future__ import annotations

import math

import numpy as np
import pytest

import frictionloop as fl

PERIOD_S, PERIODS = 200e-6, 5000


def lateness_s(jitter_s: float, delay_s: float) -> np.ndarray:
    """Time from each sample at which the command in force changes, by the plate's closed form."""
    quick = fl.Sine(offset_n=0.5, amplitude_n=0.1, frequency_hz=1234.5)
    system = fl.paper().evolve(
        {"controller": fl.LookupController(delay_s=delay_s, jitter_s=jitter_s), "setpoint": quick}
    )
    run = fl.simulate(system, PERIODS * PERIOD_S, seed=7)
    a = run["a"].values
    command = np.sqrt(np.log(0.8 / run["u"].values) / 0.38)
    rate = 2 * math.pi * 100.0
    old, new = command[:-2], command[1:-1]
    # a2 = new + (old - new) e^-w(T - t) + (a1 - old) e^-wT, of which t is the only unknown.
    left = a[2:] - new - (a[1:-1] - old) * math.exp(-rate * PERIOD_S)
    clear = np.abs(old - new) > 0.1
    return PERIOD_S + np.log(left[clear] / (old - new)[clear]) / rate


@pytest.mark.parametrize("delay_s", [0.0, 60e-6])
def test_a_command_is_late_by_half_a_normal_of_the_jitter(delay_s):
    jitter_s = 12e-6
    late = lateness_s(jitter_s, delay_s) - delay_s
    count = late.size
    assert count > 1000
    # Of |z|: mean sqrt(2/pi), variance 1 - 2/pi, a quarter below 0.3186, half below 0.6745 (the quartiles of normals).
    wanted = math.sqrt(2 / math.pi), math.sqrt(1 - 2 / math.pi), 0.3186, 0.6745, 1.1503
    found = late.mean(), late.std(), *np.quantile(late, [0.25, 0.5, 0.75])
    # Four standard errors, the widest that of the upper quartile: sqrt(3/16)/density there, 0.4117. Within the substep
    # of 20 us in which it changes the plate sees the command's mean, which costs up to 0.2 us, 0.02 of the jitter.
    slack = 4 * max(0.603, math.sqrt(3 / 16) / 0.4117) / math.sqrt(count)
    np.testing.assert_allclose(np.array(found) / jitter_s, wanted, atol=slack + 0.02)


def test_without_jitter_a_command_is_late_by_its_delay():
    np.testing.assert_allclose(lateness_s(1e-12, 60e-6), 60e-6, atol=0.2e-6)
