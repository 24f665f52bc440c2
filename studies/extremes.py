"""The force of fingers at rest on a level when the drive goes to one of its ends: the plant of the bench itself.

At rest means as after a long hold: the tip slides at the speed of the bone, skin and bristle carry the level, and the
amplitude is the one that gives it. Nothing disturbs: no tremor, no texture, no drift; the law of friction stays as it
is. The plant is the kernel's, in steps of a substep instead of a control period, so that a passage is told to 20 us.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from frictionloop.analysis.operating import law_at
from frictionloop.loop.kernel.loop import Tile
from frictionloop.loop.kernel.lowering import lower
from frictionloop.loop.kernel.placing import placed
from frictionloop.loop.kernel.slab import LANES
from frictionloop.loop.kernel.structure import substeps_of
from frictionloop.loop.kernel.traces import BENCH_TRACES
from frictionloop.parameters import Constant, System
from frictionloop.physics.friction import amplitude_for, is_gaussian

_QUIET = {
    "setpoint": Constant(),
    "disturbance": Constant(),
    "controller.kind": "lookup",
    "controller.form": "float",
    "controller.jitter_s": 0.0,
    "controller.lost_ticks": 0.0,
    "plate.pulse_ticks": 0,
    "motion.start": 0.25,
    "motion.contact_s": 0.0,
    "motion.load_drift": 0.0,
    "motion.tremor_um": 0.0,
    "motion.tremor_n": 0.0,
    "friction.load_exponent": 0.0,
    "friction.speed_slope": 0.0,
    "friction.occlusion_ratio": 1.0,
    "friction.moist_loss": 0.0,
    "friction.roughness_rms": 0.0,
}
"""What is taken from a finger, in the middle of its stroke, so that nothing but the drive moves its force."""


def undisturbed(system: System, occluded: float = 0.0) -> System:
    """Return a finger's system without what disturbs it, its law of friction that at the mean load (`law_at`).

    Parameters
    ----------
    system
        A bench with a finger's own values, friction of kind "finger" and motion of kind "strokes".
    occluded
        How far occlusion has come, 0 to 1.
    """
    law = law_at(system, occluded)
    assert is_gaussian(law)
    own = {"friction.nominal_n": law.nominal_n, "friction.susceptibility_per_um2": law.susceptibility_per_um2}
    return system.evolve(_QUIET | own)


def forces_from_rest(
    systems: Sequence[System], level_n: float, command_um: float, duration_s: float
) -> tuple[np.ndarray, float]:
    """Return the forces in N after a step at which every finger's command goes to one value, and their spacing in s.

    Parameters
    ----------
    systems
        Bench and finger each, `undisturbed`, of equal structure; each must have the level.
    level_n
        Where the force rests until then, N.
    command_um
        Amplitude command from then on, in force ``controller.delay_s`` later.
    duration_s
        How long to look on, not past the end of the stroke.

    Returns
    -------
    tuple
        Forces of shape (times, fingers), the first at the step, and the time between two in s.
    """
    rate_hz = systems[0].controller.rate_hz * substeps_of(systems[0])
    fine = [placed(each, [{"controller.rate_hz": rate_hz}])[0] for each in systems]
    count = int(np.ceil(duration_s * rate_hz))
    parts = [
        _tile_from_rest(fine[first : first + LANES], level_n, command_um, count) for first in range(0, len(fine), LANES)
    ]
    return np.concatenate(parts, axis=1), 1.0 / rate_hz


def _tile_from_rest(systems: Sequence[System], level_n: float, command_um: float, count: int) -> np.ndarray:
    traces = np.zeros((len(BENCH_TRACES), count + 1, 1 if len(systems) == 1 else LANES))
    tile = lower(systems, [0] * len(systems), traces=traces.reshape(-1), external=True)
    unused = np.zeros(1)
    tile.advance(0, 1, unused, unused, 0)
    _rest(tile, systems, level_n)
    tile.slab.view("command")[:] = command_um
    tile.advance(1, count + 1, unused, unused, 1)
    forces = traces[BENCH_TRACES.index("f_a"), :, : len(systems)]
    forces[0] = level_n
    return forces


def _rest(tile: Tile, systems: Sequence[System], level_n: float) -> None:
    """Put plate, skin and bristle where they are after a long hold of the level, and the commands under way."""
    amplitudes = np.array([float(amplitude_for(level_n, each.friction)) for each in systems])
    amplitudes = np.append(amplitudes, np.repeat(amplitudes[-1], tile.slab.width - len(systems)))
    view = tile.slab.view
    view("contact")[:] = level_n * view("compliance")[0], np.zeros(tile.slab.width), np.full(tile.slab.width, level_n)
    view("amplitude")[:] = amplitudes
    tile.shared.kept["history"].reshape(-1, tile.slab.width)[:] = amplitudes
