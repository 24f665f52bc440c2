"""From Systems to the numbers of a substep kernel: finger, motion, contact, suspension."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.special import ndtri

from frictionloop.control.oracle import STEPS
from frictionloop.loop.kernel.columns import column
from frictionloop.loop.kernel.slab import Slab
from frictionloop.loop.kernel.structure import substeps_of, switch_s
from frictionloop.parameters import FingerFriction, Skin, Strokes, System
from frictionloop.physics.contact import contact_coefficients
from frictionloop.physics.finger_step import Motion
from frictionloop.physics.friction_limit import limit_coefficients, occlusion_coefficients, static_coefficients
from frictionloop.physics.motion import load_plan, scored_edge_m, stroke_plan
from frictionloop.physics.plate import plate_coefficients
from frictionloop.physics.roughness import cells_per_m, roughness_table
from frictionloop.physics.tremor import tremor_coefficients, tremor_start
from frictionloop.sensing.suspended import converter, noise_coefficients, suspension_coefficients
from frictionloop.sensing.touch import touch_coefficients

_PERSON = 0x9E3779B97F4A7C15
"""2^64 over the golden ratio, odd: people with numbers 0, 1, ... get keys that are far apart."""
_PLAIN = FingerFriction(load_exponent=0.0, occlusion_ratio=1.0, moist_loss=0.0, roughness_rms=0.0)
"""A friction limit that depends on nothing: equation (1) under a finger that moves."""


def keys_of(systems: Sequence[System], seeds: Sequence[int]) -> np.ndarray:
    """Return the key of each lane's noise: the seed, moved on by the person's number."""
    people = column([s.motion for s in systems], lambda motion: motion.person if isinstance(motion, Strokes) else 0)
    return np.array(seeds, np.uint64) + np.uint64(_PERSON) * people.astype(np.uint64)  # modulo 2^64


def lower_finger(slab: Slab, systems: Sequence[System], keys: np.ndarray) -> np.ndarray:
    """Set the rows of finger, motion and sensor, one system per lane; return the tables of roughness."""
    dt = 1.0 / systems[0].controller.rate_hz
    substeps = substeps_of(systems[0])
    h = dt / substeps
    slab.view("node_time")[1 : 1 + substeps] = (h * (np.arange(substeps) + 0.5))[:, None]
    _fill(slab, "limit_n", [(s.friction.nominal_n,) for s in systems])
    _fill(slab, "plate_coefficients", [plate_coefficients(s.plate, h) for s in systems])
    _fill(slab, "contact_coefficients", [contact_of_step(s, h) for s in systems])
    skins = [s.finger for s in systems]
    _fill(slab, "compliance", [(1.0 / f.stiffness_n_m if isinstance(f, Skin) else 0.0,) for f in skins])
    _fill(slab, "suspension_coefficients", [suspension_coefficients(s.sensor, h) for s in systems])
    _fill(slab, "timing", [_timing(s) for s in systems])
    slab.view("switch")[:] = slab.view("timing")[:1]
    _fill(slab, "noise_coefficients", [noise_coefficients(s.sensor, dt) for s in systems])
    _fill(slab, "converter", [converter(s.sensor) for s in systems])
    if not isinstance(systems[0].motion, Strokes):
        for name in ("factor", "direction"):
            row = Motion._fields.index(name)
            slab.view("motion")[row] = slab.view("motion_next")[row] = 1.0
        return np.zeros(0)
    return _lower_motion(slab, systems, keys, dt)


def lower_oracle(slab: Slab, systems: Sequence[System]) -> None:
    """Set the rows that only an oracle reads."""
    period = 1.0 / systems[0].controller.rate_hz
    h = period / STEPS
    _fill(slab, "trial_decay", [(plate_coefficients(s.plate, period).whole,) for s in systems])
    _fill(slab, "trial_stride", [(*plate_coefficients(s.plate, h), *contact_of_step(s, h)) for s in systems])


def _timing(system: System) -> tuple[float, float, float]:
    c = system.controller
    lost_below = float(ndtri(c.lost_ticks)) if c.lost_ticks else -math.inf
    return switch_s(system) * c.rate_hz, c.jitter_s * c.rate_hz, lost_below


def contact_of_step(system: System, h: float) -> tuple[float, ...]:
    """Return the coefficients of the contact for a step of h seconds."""
    return contact_coefficients(system.finger, h) if isinstance(system.finger, Skin) else (0.0,) * 10


def _lower_motion(slab: Slab, systems: Sequence[System], keys: np.ndarray, dt: float) -> np.ndarray:
    motions = [s.motion for s in systems if isinstance(s.motion, Strokes)]
    frictions = [s.friction if isinstance(s.friction, FingerFriction) else _PLAIN for s in systems]
    seeds = [int(key) for key in keys]
    plans = [stroke_plan(m) for m in motions]
    _fill(slab, "stroke_plan", plans)
    _fill(slab, "load_plan", [load_plan(m, key) for m, key in zip(motions, seeds, strict=True)])
    trembles = [_tremors(m, dt) for m in motions]
    _fill(slab, "tremor_coefficients", [(*along, *across) for along, across in trembles])
    _fill(
        slab,
        "tremor",
        [
            (*tremor_start(along, key, 0), *tremor_start(across, key, 1))
            for (along, across), key in zip(trembles, seeds, strict=True)
        ],
    )
    _fill(slab, "limit_coefficients", [limit_coefficients(f) for f in frictions])
    _fill(slab, "occlusion_coefficients", [occlusion_coefficients(f, dt) for f in frictions])
    _fill(slab, "static", [static_coefficients(f) for f in frictions])
    _fill(slab, "roughness_per_m", [(cells_per_m(f.roughness_longest_mm),) for f in frictions])
    _fill(slab, "touch_coefficients", [touch_coefficients(s.touch, dt) for s in systems])
    edges = [scored_edge_m(m, s.finger) for m, s in zip(motions, systems, strict=True)]
    _fill(slab, "unscored", [(edge, 0.5 * m.load_n) for edge, m in zip(edges, motions, strict=True)])
    tables = [roughness_table(f.roughness_rms, key) for f, key in zip(frictions, seeds, strict=True)]
    return np.ascontiguousarray(np.array(tables).T).ravel()


def _tremors(motion: Strokes, dt: float) -> tuple[Any, Any]:
    shape = (motion.tremor_hz, motion.tremor_width_hz, dt)
    return tremor_coefficients(1e-6 * motion.tremor_um, *shape), tremor_coefficients(motion.tremor_n, *shape)


def _fill(slab: Slab, name: str, lanes: Sequence[Sequence[float]]) -> None:
    slab.view(name)[:] = np.array(lanes, dtype=float).T
