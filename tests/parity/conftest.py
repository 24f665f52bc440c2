"""The two forms of a law side by side: the float64 step in compiled loops, and the C core; and what they are fed."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from numba import njit

import frictionloop as fl
from frictionloop.control.laws import law_of
from frictionloop.firmware.compiled_core import host_library, host_words, quantised_start, state_places
from frictionloop.loop.kernel.access import doubles, load, store
from frictionloop.quantities import trees
from frictionloop.sensing.measurement import Measurement


@cache
def loop(law):
    """Return (states, measurements, set-points, gains, dt) -> states before and after each tick, and u.

    Ticks follow one another from the first state, or begin each at its own where there is one for each.
    """
    step, states = law.step, trees.size(law.state)
    state_rows, gain_rows = (trees.shaped(shape, range(trees.size(shape))) for shape in (law.state, law.gains))

    @njit
    def go(starts, rows, setpoints, numbers, dt):
        before, after, forces = np.empty((len(rows), states)), np.empty((len(rows), states)), np.empty(len(rows))
        state, gains = starts[0].copy(), load(doubles(numbers.ctypes.data), 0, 1, gain_rows)
        held = doubles(state.ctypes.data)
        for k in range(len(rows)):
            if len(starts) > 1:
                state[:] = starts[k]
            row = rows[k]
            measured = Measurement(row[0], row[1], row[2], row[3], row[4])
            before[k] = state
            next_state, command = step(load(held, 0, 1, state_rows), measured, setpoints[k], gains, dt)
            store(held, 0, 1, state_rows, next_state)
            after[k], forces[k] = state, command.u
        return before, after, forces

    return go


class FloatLaw:
    """A controller's float64 law, batch by batch."""

    def __init__(self, controller):
        law = law_of(controller)
        self._loop, self._dt = loop(law), 1.0 / controller.rate_hz
        self._numbers = np.array(trees.flat(law.gains_for(controller)), dtype=float)
        self.state = np.array(trees.flat(law.start_for(controller)), dtype=float)

    def along(self, rows, setpoints):
        """Go on by these ticks: states before each."""
        before, after, _ = self._loop(self.state[np.newaxis], rows, setpoints, self._numbers, self._dt)
        self.state = after[-1]
        return before

    def each(self, states, rows, setpoints):
        """One step from each state: the next ones, and commands."""
        return self._loop(states, rows, setpoints, self._numbers, self._dt)[1:]


class FixedLaw:
    """A controller's law in the C core."""

    def __init__(self, controller, library=None):
        self.ffi, self._lib = library or host_library()
        self.words = host_words(fl.bench().evolve({"controller": controller}))
        self.scale = 2.0 ** np.array(state_places(controller))
        self.state, self.believed = np.array(quantised_start(controller), dtype=np.int32), np.zeros(1, dtype=np.int32)

    def stored(self, states, clip=False):
        """Words of float64 states."""
        words = np.rint(states * self.scale)
        held = np.clip(words, -(2.0**31), 2.0**31 - 1)
        assert clip or np.array_equal(held, words), "a state overflows its format"
        return held.astype(np.int32)

    def meant(self, words):
        """What words of states stand for."""
        return words / self.scale

    def _at(self, array):
        return self.ffi.cast("int32_t *", array.ctypes.data)

    def each(self, states, rows, setpoints):
        """One step from each state: the next ones, and rows of (u, saturated)."""
        after, out = states.copy(), np.empty((len(rows), 2), dtype=np.int32)
        self._lib.fl_host_steps(self._at(self.words), len(rows), *map(self._at, (after, rows, setpoints, out)))
        return after, out

    def run(self, rows, setpoints):
        """Go on by these ticks: rows of (u, saturated, amplitude command)."""
        out = np.empty((len(rows), 3), dtype=np.int32)
        arrays = (self.state, self.believed, rows, setpoints, out)
        self._lib.fl_host_run(self._at(self.words), len(rows), *map(self._at, arrays))
        return out

    def lookup(self, forces):
        """Amplitudes at forces."""
        out = np.empty_like(forces)
        self._lib.fl_host_lookup(self._at(self.words), len(forces), self._at(forces), self._at(out))
        return out

    def overdrive(self, believed, wanted):
        """New beliefs, and commands."""
        believed, out = believed.copy(), np.empty_like(wanted)
        self._lib.fl_host_overdrive(self._at(self.words), len(wanted), *map(self._at, (believed, wanted, out)))
        return believed, out


def wild_inputs(count, seed):
    """Set-points and forces that jump anywhere the sensor and the tables reach, for short and long, and gaps."""
    rng = np.random.default_rng(seed)

    def held(low, high, mean):
        changes = rng.random(count) < 1.0 / mean
        changes[0] = True
        return rng.uniform(low, high, count)[changes][np.cumsum(changes) - 1]

    steady = held(0, 1, 500) < 0.5
    forces = np.where(steady, held(-2.5, 2.5, 100), rng.uniform(-2.5, 2.5, count))
    setpoints = np.where(held(0, 1, 500) < 0.5, held(0, 3.2, 200), rng.uniform(0, 3.2, count))
    rows = np.column_stack([forces, rng.uniform(0, 0.1, count), rng.uniform(-0.3, 0.3, count),
                            rng.uniform(0, 3, count), held(0, 1, 300) < 0.9])  # fmt: skip
    return rows, setpoints


@cache
def realistic_inputs(count, seed):
    """What the sensors tell and the set-point is in a run of the bench."""
    run = fl.simulate(fl.bench().evolve(fl.RETUNED), duration_s=count / 5000.0, seed=seed)
    rows = np.column_stack([run[name].values for name in ("f_m", "position", "speed", "load", "sliding")])
    return rows.astype(float), run["f_r"].values.astype(float)


def quantised(rows, setpoints):
    """The same inputs as the firmware gets them, and what these numbers are in float64."""
    counts = np.rint(rows * 2.0**28)
    counts[:, 4] = rows[:, 4]
    told = np.rint(setpoints * 2.0**28)
    back = counts / 2.0**28
    back[:, 4] = rows[:, 4]
    fixed = np.ascontiguousarray(counts.astype(np.int32)), told.astype(np.int32)
    return fixed, (np.ascontiguousarray(back), told / 2.0**28)


class Parity:
    """What tests of parity need, in one place."""

    FloatLaw, FixedLaw = FloatLaw, FixedLaw
    wild, realistic, quantised = staticmethod(wild_inputs), staticmethod(realistic_inputs), staticmethod(quantised)

    @staticmethod
    def one_step(controller, inputs, chunk=100_000):
        """Difference of u in N, u in float64, and differences of the next states from those in float64.

        Both forms start each tick from the same state: that of a float64 run along the inputs, quantised.
        """
        law, fixed, found = FloatLaw(controller), FixedLaw(controller), []
        for k in range(0, len(inputs[0]), chunk):
            counts, back = quantised(inputs[0][k : k + chunk], inputs[1][k : k + chunk])
            stored = fixed.stored(law.along(*back))
            after, forces = law.each(fixed.meant(stored), *back)
            state, out = fixed.each(stored, *counts)
            found.append((out[:, 0] / 2.0**28 - forces, forces, fixed.meant(state) - after))
        return tuple(np.concatenate(part) for part in zip(*found, strict=True))


@pytest.fixture(scope="session")
def parity():
    return Parity
