"""The tile of a streaming metric from outside."""

from __future__ import annotations

from typing import Any

from frictionloop.loop.kernel.access import load, peek, store
from frictionloop.loop.kernel.slab import ROW, rows
from frictionloop.loop.kernel.tiles import Lifting
from frictionloop.loop.metric import Sample, StreamingMetric
from frictionloop.quantities import trees


def build_metric(lifting: Lifting, metric: StreamingMetric, first: int) -> Any:
    """Lift a metric's step over the scored periods; its state begins at row ``first``."""
    width, compiled, count = lifting
    step, friction, disturbance, scored = metric.step, ROW["friction"], ROW["disturbance"], ROW["scored"]
    state_rows = trees.shaped(metric.state, range(first, first + trees.size(metric.state)))
    given = Sample(
        ROW["setpoint"],
        friction,
        ROW["measurement"],
        ROW["u"],
        ROW["amplitude"],
        disturbance,
        ROW["saturated"],
        *rows("motion")[:3],
    )

    @compiled
    def update(s, n, k, at, o):  # type: ignore[no-untyped-def]
        if k >= o.score_from:
            for i in range(count(n)):
                if peek(s, scored * width + i) > 0.0:
                    f_r, f_a, f_m, u, a, d, saturated, x, v, pressed = load(s, i, width, given)
                    sample = Sample(f_r, f_a + d, f_m, u, a, d, saturated, x, v, pressed)
                    store(s, i, width, state_rows, step(load(s, i, width, state_rows), sample, o.dt))

    return update
