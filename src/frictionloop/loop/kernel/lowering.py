"""From Systems to the numbers of a tile: every block's coefficients, one column per lane."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from frictionloop.control.laws import law_number, law_of
from frictionloop.control.lookup import lookup_table
from frictionloop.control.overdrive import no_overdrive, overdrive_gains
from frictionloop.loop.formulas import Sums
from frictionloop.loop.kernel.columns import column
from frictionloop.loop.kernel.exchange import (
    EXTERNAL,
    FIRMWARE,
    NO_WORDS,
    NOTHING,
    ORACLE,
    Buffers,
    Options,
    buffers,
    ring_size,
)
from frictionloop.loop.kernel.felt_tile import FADE_S
from frictionloop.loop.kernel.lower_finger import keys_of, lower_finger
from frictionloop.loop.kernel.lower_oracle import lower_oracle, plan_of
from frictionloop.loop.kernel.lower_plant import lower_plant, lower_swing
from frictionloop.loop.kernel.lower_signals import lower_signal
from frictionloop.loop.kernel.score_tile import PERCEPTION
from frictionloop.loop.kernel.signals import SINE
from frictionloop.loop.kernel.slab import LANES, Slab
from frictionloop.loop.kernel.structure import (
    contact_of,
    divided,
    is_irregular,
    kernel_of,
    late_s,
    moving_of,
    open_until,
    segments_of,
    substeps_of,
)
from frictionloop.parameters import OracleController, System
from frictionloop.physics.friction import halving_amplitude_um
from frictionloop.physics.sources import Sampler

SETPOINT_STREAM, DISTURBANCE_STREAM = 1, 2
"""Streams of coloured noise; 0 is the sensor noise."""


@dataclass(frozen=True)
class Tile:
    """Lanes of one structure, ready for the kernel."""

    kernel: str
    slab: Slab
    options: Options
    buffers: Buffers
    setpoint: Sampler
    disturbance: Sampler


def lower(
    systems: Sequence[System],
    seeds: Sequence[int],
    *,
    groups: int = 0,
    score_from: int = 0,
    recording: bool = False,
    external: bool = False,
) -> Tile:
    """Return the tile that runs these systems (one, or up to ``LANES`` of equal structure) with these seeds."""
    width = 1 if len(systems) == 1 else LANES
    # A tile is always full: lanes beyond the last system repeat it and are not read.
    systems = [*systems, *[systems[-1]] * (width - len(systems))]
    keys = keys_of(systems, [*seeds, *[seeds[-1]] * (width - len(seeds))])
    slab, rate, name = Slab(width), systems[0].controller.rate_hz, kernel_of(systems[0])
    _lower_friction(slab, systems)
    lates = [late_s(s) for s in systems]
    whole, switch = column(lates, lambda late: divided(late, rate))
    slab.view("delay_periods")[0] = whole
    roughness = NOTHING
    if name == "quadrature":
        before, after = segments_of(systems[0])
        nodes = lower_plant(slab, systems, switch, before, after)
    else:
        before, after = 0, substeps_of(systems[0])
        nodes, roughness = after + 1, lower_finger(slab, systems, keys)
    table = _lower_controller(slab, systems)
    fixed = systems[0].controller.form == "firmware" and not external
    core = _lower_core(systems) if fixed else NO_WORDS
    setpoints, disturbances = [s.setpoint for s in systems], [s.disturbance for s in systems]
    # Lanes share the disturbance's share of the reading if they also share the nodes and their weights.
    used = [slab.view(name)[:nodes] for name in ("node_time", "weight")]
    nodes_alike = all(bool(np.all(rows == rows[:, :1])) for rows in used)
    setpoint = lower_signal(slab, "setpoint_signal", setpoints, keys, SETPOINT_STREAM, rate, True)
    disturbance = lower_signal(slab, "disturbance_signal", disturbances, keys, DISTURBANCE_STREAM, rate, nodes_alike)
    if name == "quadrature" and disturbance.how == SINE:
        lower_swing(slab, nodes)
    slab.view("shift")[0] = slab.view("setpoint_signal")[0]
    # A bench always looks up what the last command was: jitter may keep it in force.
    ring = ring_size(max(max(lates) * rate, float(name == "substeps")))
    options = Options(
        law=EXTERNAL if external else _number(systems[0].controller),
        segments=before + after,
        before=before,
        setpoint=setpoint.how,
        setpoint_shared=setpoint.shared,
        disturbance=disturbance.how,
        disturbance_shared=disturbance.shared,
        noise_shared=bool(np.all(keys == keys[0])),
        groups=groups,
        score_from=score_from,
        recording=recording,
        table_size=systems[0].controller.model.table_size,
        ring_mask=ring - 1,
        dt=1.0 / rate,
        moving=moving_of(systems[0]),
        irregular=name == "substeps" and any(is_irregular(s) for s in systems),
        contact=contact_of(systems[0]),
        plan=plan_of(systems[0]),
        pulsed=name == "substeps" and any(s.plate.pulse_ticks for s in systems),
        core=_core_address() if fixed else 0,
        core_words=core.size // width,
        open_until=open_until(systems[0]),
    )
    if options.law == ORACLE:
        lower_oracle(slab, systems)
    weighting = _lower_perception(slab, rate) if groups & PERCEPTION else NOTHING
    scratch = buffers(width, ring, nodes, table, keys, roughness, weighting, core)
    return Tile(name, slab, options, scratch, setpoint.take, disturbance.take)


def _number(controller: Any) -> int:
    if controller.form == "firmware":
        return FIRMWARE
    return ORACLE if isinstance(controller, OracleController) else law_number(controller)


def _lower_friction(slab: Slab, systems: Sequence[System]) -> None:
    nominal, susceptibility = column(
        [s.friction for s in systems], lambda friction: (friction.nominal_n, friction.susceptibility_per_um2)
    )
    ceiling, ticks = column([s.plate for s in systems], lambda plate: (plate.max_amplitude_um, plate.pulse_ticks))
    slab.view("nominal")[0] = slab.view("friction")[0] = nominal
    unit = halving_amplitude_um(susceptibility)
    slab.view("halving_amplitude")[:] = unit, 1.0 / unit
    slab.view("max_amplitude")[0] = ceiling
    slab.view("floor")[0] = nominal * np.exp(-susceptibility * ceiling**2)
    slab.view("pulse_ticks")[0] = ticks
    slab.view("measurement")[4] = slab.view("scored")[0] = 1.0


def _lower_controller(slab: Slab, systems: Sequence[System]) -> np.ndarray:
    controllers = [s.controller for s in systems]
    models = [c.model for c in controllers]
    low, high, halving = column(models, lambda m: (m.floor_n, m.nominal_n, math.log(2.0) / m.susceptibility_per_um2))
    size = models[0].table_size
    if not isinstance(controllers[0], OracleController):
        _lower_law(slab, controllers)
    for clamp in (slab.view("clamp"), slab.view("believed_clamp")):
        clamp[0], clamp[1] = low, high
    # Of a kind without the field, as PI, pydantic takes microseconds to say so: asked once, not for each lane.
    may_overdrive = hasattr(controllers[0], "overdrive")
    gains = column(controllers, overdrive_gains) if may_overdrive else column(models, no_overdrive)
    slab.view("overdrive_gains")[:] = gains
    model = slab.view("model")
    model[0] = np.log2(high)
    model[1] = halving
    model[2] = low
    model[3] = (size - 1) / (high - low)
    model[4] = size - 2
    if size == 0:
        return np.zeros(0)
    return np.array(np.broadcast_to(column(models, lookup_table), (size, slab.width)), order="C").ravel()


def _core_address() -> int:
    from frictionloop.firmware.simulated import core_address

    return core_address()


def _lower_core(systems: Sequence[System]) -> np.ndarray:
    from frictionloop.firmware.simulated import core_context

    return np.concatenate([core_context(s) for s in systems])


def _lower_law(slab: Slab, controllers: Sequence[Any]) -> None:
    law = law_of(controllers[0])
    slab.view("controller_gains")[: law.gains] = column(controllers, law.gains_of)
    if law.start_of is not None:
        slab.view("controller_state")[: law.states] = column(controllers, law.start_of)


def sums_of(tile: Tile, lanes: int, periods: int) -> Sums:
    """Return the sums of a tile's first lanes after a run in which so many periods may have counted."""
    view = tile.slab.view
    *rows, scored = view("sums")[:, :lanes]
    # Where nothing is scored nothing can be said: NaN, which passes through the formulas without a warning.
    count = np.where(scored > 0, scored, np.nan) if tile.kernel == "substeps" else np.full(lanes, float(periods))
    more = (view("percept")[1, :lanes], *view("step_sums")[:, :lanes], tile.options.dt, view("shift")[0, :lanes])
    return Sums._make([*rows, count, *more])


def _lower_perception(slab: Slab, rate_hz: float) -> np.ndarray:
    from frictionloop.perception.weighting import weighting_sos  # half a second of scipy, not needed for every run

    slab.view("taper")[0] = 1.0 - math.exp(-1.0 / (FADE_S * rate_hz))
    return np.ascontiguousarray(weighting_sos(rate_hz)[:, [0, 1, 2, 4, 5]]).ravel()
