"""Scalar steps lifted to tiles: one loop over lanes each, so that the compiler vectorises it.

A tile loads the rows a step needs, calls it, and stores what it returns. The steps themselves live in their rooms and
know nothing of lanes.
"""

from __future__ import annotations

from typing import Any

from numba import njit

from frictionloop.control.lookup import interpolate_step, inverse_step, table_position
from frictionloop.loop.quadrature import NODES
from frictionloop.loop.slab import ROW, load, peek, poke, rows, store
from frictionloop.physics.friction import friction_step
from frictionloop.physics.plate import limit_step, lowpass_step
from frictionloop.quantities.arithmetic import fma
from frictionloop.quantities.normals import BLOCK
from frictionloop.sensing.lowpass import sensor_node, sensor_start
from frictionloop.sensing.measurement import Measurement

IDENTITY, SATURATION, REGRESSION, BOUND = 1, 2, 4, 8
"""Groups of streaming sums a run may ask for, as bits."""
TRACES = ("f_r", "f_a", "f_m", "u", "a", "d", "saturated")

compiled = njit(error_model="numpy")


def lane_count(width: int) -> Any:
    """Return n -> number of lanes to run: the constant 1 for single runs, so that their loops vanish."""
    if width == 1:
        return compiled(lambda n: 1)
    return compiled(lambda n: n)


def build_inputs(width: int) -> Any:
    """Return the tiles that bring a signal into its row, and that start the sensor settled on the first force."""
    count = lane_count(width)
    force, friction_row, disturbance = ROW["measurement"], ROW["friction"], ROW["disturbance"]

    @compiled
    def spread(s, n, row, values, k, shared):  # type: ignore[no-untyped-def]
        if shared:
            value = peek(values, k)
            for i in range(count(n)):
                poke(s, row * width + i, value)
        else:
            for i in range(count(n)):
                poke(s, row * width + i, peek(values, k * width + i))

    @compiled
    def settle(s, n):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            poke(s, force * width + i, peek(s, friction_row * width + i) + peek(s, disturbance * width + i))

    return spread, settle


def build_control(width: int, law: Any, states: int, gains: int) -> Any:
    """Lift a control law ``law(state, measurement, setpoint, gains, dt) -> state, (u, saturated)`` and the lookup.

    With the exact inverse both are one loop, so that the force command stays in a register; a table is a gather, which
    does not vectorise, and has a loop of its own.
    """
    count = lane_count(width)
    setpoint, u_row, model, command = ROW["setpoint"], ROW["u"], ROW["model"], ROW["command"]
    state_rows, gain_rows = rows("controller_state", states), rows("controller_gains", gains)
    measurement_rows, command_rows, model_rows = rows("measurement"), (u_row, ROW["saturated"]), rows("model")

    @compiled
    def decide(s, i, dt):  # type: ignore[no-untyped-def]
        f, x, v, normal_force, valid = load(s, i, width, measurement_rows)
        measured = Measurement(f, x, v, normal_force, valid)
        given = load(s, i, width, gain_rows)
        state, wanted = law(load(s, i, width, state_rows), measured, peek(s, setpoint * width + i), given, dt)
        store(s, i, width, state_rows, state)
        store(s, i, width, command_rows, wanted)
        return wanted[0]

    @compiled
    def control(s, n, dt, table, table_size):  # type: ignore[no-untyped-def]
        if table_size == 0:
            for i in range(count(n)):
                a = inverse_step(decide(s, i, dt), peek(s, model * width + i), peek(s, (model + 1) * width + i))
                poke(s, command * width + i, a)
        else:
            for i in range(count(n)):
                decide(s, i, dt)
            for i in range(count(n)):
                _, _, low, cells_per_n, last = load(s, i, width, model_rows)
                cell, fraction = table_position(peek(s, u_row * width + i), low, cells_per_n, last)
                square_0, square_1 = peek(table, cell * width + i), peek(table, (cell + 1) * width + i)
                poke(s, command * width + i, interpolate_step(fraction, square_0, square_1))

    return control


def build_delay(width: int) -> Any:
    """Pick the commands in force during this period when they are applied later than the sample."""
    count = lane_count(width)
    command, applied, delay = ROW["command"], ROW["applied"], ROW["delay_periods"]

    @compiled
    def apply_late(s, n, k, history, mask):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            poke(history, (k & mask) * width + i, peek(s, command * width + i))
            since = k - int(peek(s, delay * width + i))
            poke(s, (applied + 1) * width + i, peek(history, (since & mask) * width + i))
            poke(s, applied * width + i, peek(history, ((since - 1) & mask) * width + i))

    return apply_late


def build_plant(width: int) -> Any:
    """Lift plate, friction law and sensor over one segment of the period by quadrature (loop/quadrature.py).

    The number of nodes is a constant, so the loop over nodes unrolls and the loop over lanes vectorises.
    """
    count = lane_count(width)
    decay, weight = ROW["decay"], ROW["weight"]
    force, normal, friction_row, amplitude = ROW["measurement"], ROW["normal"], ROW["friction"], ROW["amplitude"]
    sensor_rows = (force, normal, ROW["sensor_decay"], ROW["noise_gain"])
    law_rows, after, ceiling = (ROW["nominal"], ROW["halvings"]), (force, amplitude, friction_row), ROW["max_amplitude"]

    def lifted(d_step: int, d_lane: int) -> Any:
        """Disturbance of node j, lane i at d[j * d_step + i * d_lane]: one column for all lanes, or one for each."""

        @compiled
        def plant(s, n, d, at, command, first):  # type: ignore[no-untyped-def]
            for i in range(count(n)):
                start, g = peek(s, amplitude * width + i), peek(s, friction_row * width + i)
                law = load(s, i, width, law_rows)
                held = limit_step(peek(s, command * width + i), peek(s, ceiling * width + i))
                # Two partial sums: a lane alone waits for the chain of additions.
                f_m = sensor_start(*load(s, i, width, sensor_rows)) if first == 0 else peek(s, force * width + i)
                f = g + peek(d, at + first * d_step + i * d_lane)
                rest = sensor_node(0.0, f, peek(s, (weight + first) * width + i) if first == 0 else 0.0)
                a = start
                for m in range(1, NODES):
                    j = first + m
                    a = lowpass_step(start, held, peek(s, (decay + j) * width + i))
                    g = friction_step(a, *law)
                    f, w = g + peek(d, at + j * d_step + i * d_lane), peek(s, (weight + j) * width + i)
                    if m % 2:
                        f_m = sensor_node(f_m, f, w)
                    else:
                        rest = sensor_node(rest, f, w)
                store(s, i, width, after, (f_m + rest, a, g))

        return plant

    one_column, one_each = lifted(BLOCK, 0), lifted(BLOCK * width, 1)

    @compiled
    def plant(s, n, d, k, shared, command, first):  # type: ignore[no-untyped-def]
        if shared:
            one_column(s, n, d, k, command, first)
        else:
            one_each(s, n, d, k * width, command, first)

    return plant


def build_scores(width: int) -> Any:
    """Lift the streaming sums of the metrics (loop/metrics.py turns them into numbers)."""
    count = lane_count(width)
    sums, shift = ROW["sums"], ROW["shift"]
    r_row, g_row, d_row, sat = ROW["setpoint"], ROW["friction"], ROW["disturbance"], ROW["saturated"]
    floor, nominal = ROW["floor"], ROW["nominal"]

    @compiled
    def add(s, i, row, x, y):  # type: ignore[no-untyped-def]
        poke(s, (sums + row) * width + i, fma(x, y, peek(s, (sums + row) * width + i)))

    @compiled
    def scores(s, n, groups):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            r = peek(s, r_row * width + i)
            error = peek(s, g_row * width + i) + peek(s, d_row * width + i) - r
            r = r - peek(s, shift * width + i)
            add(s, i, 0, error, error)
            add(s, i, 1, r, 1.0)
            add(s, i, 2, r, r)
        if groups & SATURATION:
            for i in range(count(n)):
                add(s, i, 3, peek(s, sat * width + i), 1.0)
        if groups & REGRESSION:
            for i in range(count(n)):
                f = peek(s, g_row * width + i) + peek(s, d_row * width + i) - peek(s, shift * width + i)
                add(s, i, 4, f, 1.0)
                add(s, i, 5, f, f)
                add(s, i, 6, f, peek(s, r_row * width + i) - peek(s, shift * width + i))
        if groups & BOUND:
            for i in range(count(n)):
                r, d = peek(s, r_row * width + i), peek(s, d_row * width + i)
                best = min(max(r, peek(s, floor * width + i) + d), peek(s, nominal * width + i) + d)
                add(s, i, 7, best - r, best - r)

    return scores


def build_record(width: int) -> Any:
    """Return the tile that writes the traces of one period, ``[trace][period][lane]``."""
    count = lane_count(width)
    force, u, sat, r, d = ROW["measurement"], ROW["u"], ROW["saturated"], ROW["setpoint"], ROW["disturbance"]
    amplitude, friction_row = ROW["amplitude"], ROW["friction"]

    @compiled
    def record(s, n, k, out, size):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            at = k * width + i
            disturbance = peek(s, d * width + i)
            poke(out, at, peek(s, r * width + i))
            poke(out, size + at, peek(s, friction_row * width + i) + disturbance)
            poke(out, 2 * size + at, peek(s, force * width + i))
            poke(out, 3 * size + at, peek(s, u * width + i))
            poke(out, 4 * size + at, peek(s, amplitude * width + i))
            poke(out, 5 * size + at, disturbance)
            poke(out, 6 * size + at, peek(s, sat * width + i))

    return record
