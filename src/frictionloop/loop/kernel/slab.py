"""The rows of a slab, which is the state of a tile of lanes: a row per quantity, a column per lane.

Rows have fixed numbers, so the compiler knows the distance between any two of them and vectorises the loops over lanes
without checking for overlap.
"""

from __future__ import annotations

from itertools import count, islice
from typing import Any

from frictionloop.control.law import Law
from frictionloop.control.lookup import OverdriveGains
from frictionloop.loop.kernel.endpoint_quadrature import TERMS
from frictionloop.loop.kernel.period_quadrature import MAX_SEGMENTS, NODES
from frictionloop.physics.bristle_contact import ContactCoefficients, ContactState
from frictionloop.physics.finger_step import Motion
from frictionloop.physics.limit_scaling import AgeingCoefficients, LimitCoefficients, OcclusionCoefficients
from frictionloop.physics.motion import LoadPlan, StrokePlan
from frictionloop.physics.plate import PlateCoefficients
from frictionloop.physics.tremor import TremorCoefficients, TremorState
from frictionloop.physics.vibration import Vibration
from frictionloop.quantities import FrictionloopError, flat_tuples
from frictionloop.rendering.effect_program import STACK, EffectState
from frictionloop.sensing.finger_tracking import TouchCoefficients, TouchState
from frictionloop.sensing.force_sensor import Converter, NoiseCoefficients, SuspensionCoefficients, SuspensionState
from frictionloop.sensing.measurement import Measurement

LANES = 32
"""Lanes of a full tile: best of 16 to 256 in C, and 4 registers of 8 doubles."""
NODES_MAX = 2 * MAX_SEGMENTS * (NODES - 1) + 1
SEGMENT_ROWS = 1 + 2 * TERMS
VIBRATION_ROWS = 16
"""Room for the coefficients of a friction law."""
LAW_ROWS = 256
"""Room for a law: its state, its gains, and its state before a tick that may be lost."""

_SHAPES: dict[str, Any] = {
    # what changes every period
    "measurement": Measurement,
    "setpoint": 1,
    "disturbance": 1,
    "normal": 1,
    "driven": 1,  # what the disturbance adds to the reading over the period
    "u": 1,
    "saturated": 1,
    "command": 1,
    "amplitude": 1,
    "friction": 1,  # g(a) at t_k
    "applied": 2,  # amplitude command in force before and after the switch
    # coefficients
    "believed_clamp": 2,  # lowest and highest force command; while the loop is open or closes the clamp is another
    "overdrive": 1,  # believed amplitude
    "overdrive_gains": OverdriveGains,
    "model": 5,  # log2 f0, ln 2 / tau, clamp low, table cells per newton, last cell
    "at_limits": 2,  # commands at the low and the high end of the clamp
    "nominal": 1,
    "halving_amplitude": 2,  # in um, and its inverse
    "max_amplitude": 1,
    "floor": 1,
    "pulse_ticks": 1,
    "weight": NODES_MAX,  # of the disturbance at the nodes
    "segment": 2 * MAX_SEGMENTS * SEGMENT_ROWS,  # each: the plate's decay, and the terms of start and end
    "sensor_decay": 1,
    "noise_gain": 1,
    "delay_periods": 1,
    "node_time": NODES_MAX,
    "setpoint_signal": 4,  # offset, amplitude, two of the phase
    "disturbance_signal": 4,
    "swing": 3,  # of a sine's share of the reading: steady, in phase, a quarter turn later
    # the bench: a finger that moves, skin that yields, a sensor that resonates
    "motion": Motion,  # at t_k
    "motion_next": Motion,  # at t_k+1
    "rough": 1,
    "stroke_plan": StrokePlan,
    "load_plan": LoadPlan,
    "tremor_along": TremorState,
    "tremor_across": TremorState,
    "tremor_along_coefficients": TremorCoefficients,
    "tremor_across_coefficients": TremorCoefficients,
    "limit_coefficients": LimitCoefficients,
    "occlusion_coefficients": OcclusionCoefficients,
    "ageing": AgeingCoefficients,
    "vibration": VIBRATION_ROWS,  # coefficients of the friction law
    "roughness_per_m": 1,
    "touch": TouchState,
    "touch_coefficients": TouchCoefficients,
    "draws": 4,  # unit normals of both tremors, of position and load
    "limit_n": 1,  # f0
    "scored": 1,  # 1 where a period counts
    "unscored": 2,  # way from the middle, in m, beyond which nothing counts; least load that counts, in N
    "switch": 1,  # when in the period the command changes, 0 to 1
    "timing": 3,  # the same without jitter, jitter in periods, normal below which a tick is lost
    "timing_draws": 2,
    "kept": 4,  # commands before a tick that may be lost
    "contact": ContactState,
    "contact_coefficients": ContactCoefficients,
    "compliance": 1,  # of the skin, m/N
    "plate_coefficients": PlateCoefficients,
    "suspension": SuspensionState,
    "suspension_coefficients": SuspensionCoefficients,
    "noise": 1,
    "noise_coefficients": NoiseCoefficients,
    "converter": Converter,
    # an effect as the set-point: what it keeps, at the place that is known and at the true one
    "effect_seen": EffectState,
    "effect_true": EffectState,
    "effect_stack": STACK,
    "effect_lead": 1,  # s from the sample to where the place is wanted, below 0 for the sample itself
    "intended": 1,  # set-point at the true place
    "law": LAW_ROWS,
}


def _numbered() -> dict[str, Any]:
    numbers, found = count(), {}
    for name, shape in _SHAPES.items():
        size = shape if isinstance(shape, int) else flat_tuples.size(shape)
        own = tuple(islice(numbers, size))
        found[name] = flat_tuples.shaped(shape, own) if isinstance(shape, type) else own if size > 1 else own[0]
    return found


ROW = _numbered()
"""Row numbers of every quantity, in the shape that its step takes: a number, a tuple or a named tuple."""
ROWS = 1 + ROW["law"][-1]


def law_rows(law: Law) -> tuple[Any, Any, tuple[int, ...]]:
    """Return the row numbers of a law's state, of its gains, and of its state before a tick that may be lost.

    Those of state and gains have the shapes that its step takes.

    Raises
    ------
    FrictionloopError
        For a law with more numbers than there is room for.
    """
    states, gains, numbers = flat_tuples.size(law.state), flat_tuples.size(law.gains), ROW["law"]
    if 2 * states + gains > LAW_ROWS:
        raise FrictionloopError(
            f'law "{law.kind}": {states} states, {gains} gains: 2 x states + gains at most {LAW_ROWS}'
        )
    kept = numbers[states + gains : 2 * states + gains]
    return flat_tuples.shaped(law.state, numbers), flat_tuples.shaped(law.gains, numbers[states:]), kept


def vibration_rows(vibration: Vibration) -> Any:
    """Return the row numbers of a friction law's coefficients, in the shape that its step takes."""
    needed = flat_tuples.size(vibration.coefficients)
    if needed > VIBRATION_ROWS:
        raise FrictionloopError(f'friction law "{vibration.kind}": {needed} coefficients; at most {VIBRATION_ROWS}')
    return flat_tuples.shaped(vibration.coefficients, ROW["vibration"])
