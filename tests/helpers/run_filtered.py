"""The law `filtered_pi` run on readings, and readings of any kind to run it on."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st

from frictionloop.control.filtered_pi import filtered_pi_gains, filtered_pi_start, filtered_pi_step
from frictionloop.quantities.flat_tuples import flat
from frictionloop.sensing.measurement import Measurement

RATE = 5000.0
CLAMP = (0.1, 0.9)
WILD = st.floats(-1e3, 1e3) | st.sampled_from([0.0, -1e3, 1e3])
TOLD = st.lists(st.tuples(WILD, st.floats(-2, 3), st.booleans()), min_size=1, max_size=150)
"""Forces, set-points and whether the finger slides."""


def columns(told):
    """Forces, set-points and validity as arrays."""
    return (np.array(column, dtype=float) for column in zip(*told, strict=True))


def run(controller, setpoints, forces, valid=None, clamp=CLAMP):
    """Commands, saturated and the state after each step."""
    gains = filtered_pi_gains(controller)._replace(low=clamp[0], high=clamp[1])
    state = filtered_pi_start(controller)
    out, states = [], []
    for r, f, ok in zip(setpoints, forces, np.ones(len(forces)) if valid is None else valid, strict=True):
        told = Measurement(float(f), 0.0, 0.0, 0.0, float(ok))
        state, command = filtered_pi_step(state, told, float(r), gains, 1.0 / RATE)
        out.append(tuple(command))
        states.append(flat(state))
    return np.array(out), np.array(states)
