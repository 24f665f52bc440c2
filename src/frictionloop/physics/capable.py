"""Which forces each finger can be made to feel, whatever the controller."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.parameters.motion import Strokes
from frictionloop.parameters.plant import FingerFriction
from frictionloop.physics.friction import halving_amplitude_um
from frictionloop.physics.friction_limit import limit_coefficients, limit_step
from frictionloop.physics.occlusion import occlusion_after
from frictionloop.physics.vibration import vibrated_step
from frictionloop.quantities import FrictionloopError, must_be
from frictionloop.quantities.checks import number

ALL_BUT_A_TWENTIETH = 1.645
"""Standard deviations of a normal load below which, or above which, it is a twentieth of the time."""
LEAST_LOAD_N = 1e-3
"""Load that one which trembles below 0 counts as: next to no friction."""


def reach(
    values: Mapping[str, Any], max_amplitude_um: float = 2.5, contact_s: float = 0.0, contacts: float = 1.0
) -> tuple[float, float]:
    """Return the lowest and the highest friction in N that a sliding finger can be given at any time of a contact.

    With w growing from 0 at landing, the highest force is the limit without vibration where it is least, the lowest one
    the limit at ``max_amplitude_um`` where it is greatest. Roughness, tremor and drift of the load are left out.

    Parameters
    ----------
    values : mapping
        Dotted paths to values, as from `fingers`; those of ``friction`` and of ``motion`` count, and what is missing is
        the default of `FingerFriction` and `Strokes`.
    max_amplitude_um : float
        Largest amplitude of the plate, at least 0 (2.5: paper, Sec. 4.1).
    contact_s : float
        Time since landing until which both forces must be held, at least 0.
    contacts : float
        Number of contacts of a finger that was dry, with ``motion.lifted_s`` in the air between two; the last one
        counts. At least 1, infinity allowed.

    Raises
    ------
    FrictionloopError
        For a value out of its range.
    """
    if contact_s == math.inf:
        raise FrictionloopError(
            "contact_s = inf s: must be finite; contact upon contact, in the end, is contacts = inf"
        )
    for name, value, unit in (("max_amplitude_um", max_amplitude_um, "um"), ("contact_s", contact_s, "s")):
        number(name, value, unit, 0.0)
    if not contacts >= 1.0:
        raise must_be("contacts", contacts, "at least 1")
    friction, motion = _block(FingerFriction, "friction", values), _block(Strokes, "motion", values)
    y = max_amplitude_um / float(halving_amplitude_um(friction.susceptibility_per_um2))
    reached = occlusion_after(friction, contact_s, motion.lifted_s, contacts)
    states = _extremes(friction, y * y * math.log(2.0), reached)
    factors = [_factor(friction, motion, w) for w in states]
    low = max(f * vibrated_step(y, w, friction.moist_loss) for f, w in zip(factors, states, strict=True))
    return friction.nominal_n * low, friction.nominal_n * min(factors)


def capable(
    population: Sequence[Mapping[str, Any]],
    low_n: float = 0.3,
    high_n: float = 0.9,
    max_amplitude_um: float = 2.5,
    contact_s: float = 0.0,
    contacts: float = 1.0,
    *,
    load_moves: bool = False,
) -> xr.Dataset:
    """Return which fingers can be given which forces.

    A finger that is capable at its mean load may not be where the load has drifted and trembled to: whatever the law,
    it is short of the high force then, or above the low one. With ``load_moves`` both must be within reach all but a
    twentieth of the time. Drift and tremor are taken to be normal (the drift is two sines, which are within these ends
    for longer), over many periods of the drift; a run of 11 s has one.

    Parameters
    ----------
    population : sequence of mappings
        Fingers, as from `fingers`; friction falls or rises with ``motion.speed_mm_s``, which is 20 mm/s unless each
        has its own.
    low_n, high_n : float
        Forces asked for in N (0.3 and 0.9: paper, Sec. 4.2); the same twice asks for one force.
    max_amplitude_um, contact_s, contacts : float
        As for `reach`.
    load_moves : bool
        Whether the load drifts and trembles, as it does on strokes; else it stays at its mean.

    Returns
    -------
    xarray.Dataset
        Over ``finger``: ``lowest_n`` and ``highest_n`` (N), ``reaches_low``, ``reaches_high`` and ``capable`` (both).

    Raises
    ------
    FrictionloopError
        For a value out of its range.
    """
    if not 0 < low_n <= high_n < math.inf:
        raise must_be(f"low_n = {low_n!r} N, high_n", high_n, "above 0, and low not above high", "N")
    sides = (ALL_BUT_A_TWENTIETH, -ALL_BUT_A_TWENTIETH) if load_moves else (0.0, 0.0)
    # The low force is missed under a heavy load, the high one under a light load.
    ends = [
        [reach(_pressing(each, side), max_amplitude_um, contact_s, contacts) for side in sides] for each in population
    ]
    band = np.array([(heavy[0], light[1]) for heavy, light in ends]).reshape(-1, 2)
    low, high = band[:, 0] <= low_n, band[:, 1] >= high_n
    variables = {
        "lowest_n": ("finger", band[:, 0], {"units": "N"}),
        "highest_n": ("finger", band[:, 1], {"units": "N"}),
        "reaches_low": ("finger", low),
        "reaches_high": ("finger", high),
        "capable": ("finger", low & high),
    }
    attributes = {"low_n": low_n, "high_n": high_n, "max_amplitude_um": max_amplitude_um, "contact_s": contact_s}
    attributes |= {"contacts": contacts, "load_moves": int(load_moves)}
    return xr.Dataset(variables, {"finger": np.arange(len(band))}, attributes)


def _pressing(finger: Mapping[str, Any], deviations: float) -> Mapping[str, Any]:
    """Return a finger whose load is some standard deviations of drift and tremor off its mean."""
    if deviations == 0.0:
        return finger
    motion = _block(Strokes, "motion", finger)
    deviation_n = math.hypot(motion.load_drift * motion.load_n, motion.tremor_n)
    return {**finger, "motion.load_n": max(motion.load_n + deviations * deviation_n, LEAST_LOAD_N)}


def _factor(friction: FingerFriction, motion: Strokes, occluded: float) -> float:
    speed_m_s = 1e-3 * motion.speed_mm_s
    return float(limit_step(motion.load_n, speed_m_s, occluded, 0.0, tuple(limit_coefficients(friction))))


def _extremes(friction: FingerFriction, exponent: float, reached: float) -> list[float]:
    """Return the w among which (1 + g w) e^(c l w) and 1 + g w are greatest and least; c = tau a_max^2."""
    gain, growth = friction.occlusion_ratio - 1.0, exponent * friction.moist_loss
    if gain >= 0.0 or growth == 0.0:
        return [0.0, reached]
    return [0.0, reached, min(max(-1.0 / growth - 1.0 / gain, 0.0), reached)]


def _block(block: Any, name: str, values: Mapping[str, Any]) -> Any:
    own = {path.removeprefix(f"{name}."): value for path, value in values.items() if path.startswith(f"{name}.")}
    return block(**own)
