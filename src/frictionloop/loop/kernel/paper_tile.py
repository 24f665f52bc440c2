"""The loop of Section 2: nothing feeds back inside a control period, so one step takes all of it."""

from __future__ import annotations

from typing import Any

from frictionloop.control.laws import LAWS
from frictionloop.loop.kernel.endpoint_quadrature import TERMS, end_step
from frictionloop.loop.kernel.irregular_ticks import lift_delay
from frictionloop.loop.kernel.law_tile import lift_law, lift_limits
from frictionloop.loop.kernel.loop import run_program
from frictionloop.loop.kernel.signal_generation import lift_spread
from frictionloop.loop.kernel.slab import ROW, SEGMENT_ROWS
from frictionloop.loop.kernel.slab_access import doubles, load, store
from frictionloop.loop.kernel.step_lifting import Lifting, lift, lifting
from frictionloop.loop.kernel.traces import build_record
from frictionloop.physics.friction import remaining_step
from frictionloop.physics.plate import limit_step, lowpass_step
from frictionloop.quantities.counter_noise import BLOCK
from frictionloop.quantities.scalar_math import step
from frictionloop.sensing.force_sensor import sensor_node, sensor_start


@step
def sum_step(friction: float, disturbance: float) -> float:
    """The first force, on which the sensor has settled."""
    return friction + disturbance


def lift_plant(lifting: Lifting) -> Any:
    """Lift plate, friction law and sensor over one segment of the period (loop/kernel/endpoint_quadrature.py).

    Inside, the amplitude is counted in the amplitude that halves friction, and the terms of the end carry f0. The
    disturbance's share of the reading is already summed over the nodes.
    """
    width, compiled, count = lifting
    force, friction_row, amplitude = ROW["measurement"].force, ROW["friction"], ROW["amplitude"]
    sensor_rows, driven = (force, ROW["normal"], ROW["sensor_decay"], ROW["noise_gain"]), ROW["driven"]
    plate_rows = amplitude, ROW["max_amplitude"], ROW["halving_amplitude"]
    first, after = ROW["segment"][:SEGMENT_ROWS], (force, amplitude, friction_row)
    segment_rows = first[0], first[1 : 1 + TERMS], first[1 + TERMS :]
    nominal = ROW["nominal"]

    @compiled
    def plant(s, n, command, segment):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            a, ceiling, (unit, per_unit) = load(s, i, width, plate_rows)
            start = a * per_unit
            held = limit_step(load(s, i, width, command), ceiling) * per_unit
            if segment == 0:
                f_m = sensor_start(*load(s, i, width, sensor_rows)) + load(s, i, width, driven)
            else:
                f_m = load(s, i, width, force)
            # The rows of a segment are those of the first, moved on.
            decay, terms, end_terms = load(s, segment * SEGMENT_ROWS * width + i, width, segment_rows)
            away = start - held
            f_m = sensor_node(f_m, load(s, i, width, friction_row), end_step(start, away, *terms))
            y = lowpass_step(start, held, decay)
            remaining = remaining_step(y)
            f_m = sensor_node(f_m, remaining, end_step(y, away * decay, *end_terms))
            store(s, i, width, after, (f_m, y * unit, load(s, i, width, nominal) * remaining))

    return plant


def build_paper(blockwise: Lifting, table: bool) -> Any:
    """Return the tile that runs a block of periods."""
    inlined = lifting("paper", blockwise.width, inlined=True)
    law = LAWS["pi"]
    pi, limits, record = lift_law(inlined, law, table), lift_limits(inlined, law), build_record(inlined, "quadrature")
    apply_late, plant, spread = lift_delay(inlined), lift_plant(inlined), lift_spread(inlined)
    settle = lift(inlined, sum_step, (ROW["friction"], ROW["disturbance"]), ROW["measurement"].force)
    command, (before, after), driven = ROW["command"], ROW["applied"], ROW["driven"]
    setpoint, disturbance, normal = ROW["setpoint"], ROW["disturbance"], ROW["normal"]

    @inlined.compiled
    def one_period(s, n, k, at, o):  # type: ignore[no-untyped-def]
        spread(s, n, setpoint, doubles(o.setpoint), at, o.setpoint_shared)
        spread(s, n, disturbance, doubles(o.disturbance), at, o.disturbance_shared)
        spread(s, n, normal, doubles(o.normals), at, o.noise_shared)
        spread(s, n, driven, doubles(o.driven), at, o.disturbance_shared)
        if k == 0:
            settle(s, n)
            limits(s, n)
        if o.external == 0:
            pi(s, n, o)
        run_program(s, k, at, o.extras, o.extras_count, o)
        if o.trace_size > 0:
            record(s, n, k, at, o)
        if (o.ring_mask == 0) & (o.segments == 1):
            plant(s, n, command, 0)
            return
        apply_late(s, n, k, o)
        for segment in range(o.segments):
            held = before if segment < o.before else after
            plant(s, n, held, segment)

    @blockwise.compiled
    def paper(s, n, start, end, o):  # type: ignore[no-untyped-def]
        first = start // BLOCK * BLOCK
        for k in range(start, end):
            one_period(s, n, k, k - first, o)

    return paper
