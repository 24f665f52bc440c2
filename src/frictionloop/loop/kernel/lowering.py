"""From Systems to the numbers of a tile: every block's coefficients, one column per lane."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from frictionloop.control.laws import law_of
from frictionloop.control.lookup import inverse_numbers, lookup_table, no_overdrive, overdrive_gains
from frictionloop.loop.kernel.loop import Tile
from frictionloop.loop.kernel.lower_blocks import keys_of, lower_bench, lower_plant, lower_signal, lower_swing
from frictionloop.loop.kernel.slab import LANES, law_rows, vibration_rows
from frictionloop.loop.kernel.slab_columns import Slab, column
from frictionloop.loop.kernel.step_lifting import compiled_tile
from frictionloop.loop.kernel.tile_compatibility import (
    divided,
    effect_of,
    is_irregular,
    kernel_of,
    moves,
    open_until,
    segments_of,
    substeps_of,
)
from frictionloop.loop.kernel.tile_order import set_programs
from frictionloop.loop.kernel.tile_record import Shared, scratch
from frictionloop.loop.kernel.traces import places_of, traces_of
from frictionloop.loop.metric import Tally
from frictionloop.parameters import Model, System
from frictionloop.physics.friction import halving_amplitude_um
from frictionloop.physics.vibration import vibration_of
from frictionloop.quantities import flat_tuples

SETPOINT_STREAM, DISTURBANCE_STREAM = 1, 2
"""Streams of coloured noise; 0 is the sensor noise."""


def lower(
    systems: Sequence[System],
    seeds: Sequence[int],
    *,
    score_from: int = 0,
    traces: np.ndarray | None = None,
    tallies: Sequence[Tally] = (),
    external: bool = False,
    guided: bool = False,
    compiled: Callable[..., int] = compiled_tile,
) -> Tile:
    """Return the tile that runs these systems (one, or up to ``LANES`` of equal structure) with these seeds.

    ``traces`` is what a run records, ``[trace][period][lane]``; ``guided`` fingers go where the record's ``path`` says.
    ``compiled`` gives the number by which the loop calls a tile: its address.
    """
    width = 1 if len(systems) == 1 else LANES
    # A tile is always full: lanes beyond the last system repeat it and are not read.
    systems = [*systems, *[systems[-1]] * (width - len(systems))]
    keys = keys_of(systems, [*seeds, *[seeds[-1]] * (width - len(seeds))])
    places, rows = places_of(tallies)
    first, slab = systems[0], Slab(width, rows)
    rate, name = first.controller.rate_hz, kernel_of(first)
    _lower_friction(slab, systems, name == "quadrature")
    delays_s = [s.controller.delay_s for s in systems]
    whole, switch = column(delays_s, lambda delay_s: divided(delay_s, rate))
    slab.view("delay_periods")[0] = whole
    shared = Shared(
        lanes=width,
        dt=1.0 / rate,
        score_from=score_from,
        external=external,
        given=guided,
        irregular=name == "substeps" and any(is_irregular(s) for s in systems),
        pulsed=name == "substeps" and any(s.plate.pulse_ticks for s in systems),
        open_until=open_until(first),
        noise_shared=bool(np.all(keys == keys[0])),
    )
    if name == "quadrature":
        before, after = segments_of(first)
        nodes = lower_plant(slab, systems, switch, before, after)
    else:
        before, after, nodes = 0, substeps_of(first), 1 + substeps_of(first)
        shared.point(roughness=lower_bench(slab, systems, keys))
        if (program := effect_of(first)) is not None:
            shared.point(effect=program.numbers)
    shared.set(segments=before + after, before=before, nodes=nodes)
    setpoints, disturbances = [s.setpoint for s in systems], [s.disturbance for s in systems]
    # Lanes share the disturbance's share of the reading if they also share the nodes and their weights.
    used = [slab.view(name)[:nodes] for name in ("node_time", "weight")]
    nodes_alike = all(bool(np.all(rows == rows[:, :1])) for rows in used)
    setpoint = lower_signal(slab, "setpoint_signal", setpoints, keys, SETPOINT_STREAM, rate, True)
    disturbance = lower_signal(slab, "disturbance_signal", disturbances, keys, DISTURBANCE_STREAM, rate, nodes_alike)
    shared.set(setpoint_shared=setpoint.shared, disturbance_shared=disturbance.shared)
    if name == "quadrature" and disturbance.how == "sine":
        lower_swing(slab, nodes)
    # A bench always looks up what the last command was: jitter may keep it in force.
    longest = max(max(delays_s) * rate, float(name == "substeps"))
    shared.point(**scratch(width, longest, nodes, name == "substeps" and moves(first)))
    shared.set(ring_mask=shared.kept["history"].size // width - 1, table_size=first.controller.model.table_size)
    shared.point(table=_lower_controller(slab, systems, external), seeds=keys)
    for tally, place in places.items():
        _lower_tally(slab, tally, place, systems)
    if traces is not None:
        shared.point(trace=traces)
        shared.set(trace_size=traces.size // len(traces_of(first)))
    set_programs(shared, slab, first, name, setpoint, disturbance, places, compiled)
    return Tile(name, slab, shared, setpoint.take, disturbance.take, places)


def _lower_friction(slab: Slab, systems: Sequence[System], quadrature: bool) -> None:
    frictions, plates = [s.friction for s in systems], [s.plate for s in systems]
    vibration = vibration_of(frictions[0])
    effect = vibration_rows(vibration)
    slab.fill(lambda f: {effect: vibration.coefficients_of(f), "nominal": f.nominal_n}, frictions)
    slab.fill(lambda plate: {"max_amplitude": plate.max_amplitude_um, "pulse_ticks": plate.pulse_ticks}, plates)
    slab.view("friction")[:] = slab.view("nominal")
    slab.view("measurement")[4] = slab.view("scored")[0] = 1.0
    if quadrature:
        susceptibility = column(frictions, lambda f: f.susceptibility_per_um2)
        unit = halving_amplitude_um(susceptibility)
        slab.view("halving_amplitude")[:] = unit, 1.0 / unit
        slab.view("floor")[:] = slab.view("nominal") * np.exp(-susceptibility * slab.view("max_amplitude") ** 2)


def _lower_controller(slab: Slab, systems: Sequence[System], external: bool) -> np.ndarray:
    """Set the rows of the controllers; return their lookup tables, ``[entry][lane]``."""
    controllers, size = [s.controller for s in systems], systems[0].controller.model.table_size
    models = [c.model for c in controllers]
    slab.fill(_model, models)
    # Of a kind without the field, as PI, pydantic takes microseconds to say so: asked once, not for each lane.
    if hasattr(controllers[0], "overdrive"):
        slab.fill(lambda c: {"overdrive_gains": overdrive_gains(c)}, controllers)
    if not external:
        law = law_of(controllers[0])
        state, gains, _ = law_rows(law)
        slab.fill(lambda c: {gains: law.gains_for(c)}, controllers)
        slab.fill(lambda c: {state: law.start_for(c)}, controllers if law.start_of else controllers[:1])
    if size == 0:
        return np.zeros(0)
    return np.array(np.broadcast_to(column(models, lookup_table), (size, slab.width)), order="C").ravel()


def _model(model: Model) -> dict[str, Any]:
    low, high, size = model.floor_n, model.nominal_n, model.table_size
    cells = (size - 1) / (high - low), size - 2
    return {
        "believed_clamp": (low, high),
        "overdrive_gains": no_overdrive(model),
        "model": (*inverse_numbers(model), low, *cells),
    }


def _lower_tally(slab: Slab, tally: Tally, place: int, systems: Sequence[System]) -> None:
    start_of, rate_hz = tally.start_of, systems[0].controller.rate_hz
    if start_of is not None:
        rows = flat_tuples.shaped(tally.state, range(place + 1, place + 1 + flat_tuples.size(tally.state)))
        slab.fill(lambda setpoint: {rows: start_of(setpoint, rate_hz)}, [s.setpoint for s in systems])
