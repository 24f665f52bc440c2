"""Which friction forces a finger can be given, whatever the controller: without vibration and with the largest."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from frictionloop.parameters import FingerFriction, Friction, FrictionLimit, Sliding, Strokes, System, check_system
from frictionloop.physics.friction import Held, Law, friction_force, is_gaussian, limit_law
from frictionloop.physics.limit_scaling import limit_coefficients, limit_step
from frictionloop.physics.occlusion import occlusion_after
from frictionloop.quantities import FrictionloopError, must_be
from frictionloop.quantities.value_checks import number, numbers

if TYPE_CHECKING:
    import xarray as xr

ALL_BUT_A_TWENTIETH = 1.645
"""Standard deviations of a normal load below which, or above which, it is a twentieth of the time."""
LEAST_LOAD_N = 1e-3
"""Load that one which trembles below 0 counts as: next to no friction."""
ROUNDING = 1e-9
"""Share by which a force may be beyond the reach and counts as within: rounding of the steps between."""


class Reach(NamedTuple):
    """Lowest and highest friction force, N: numbers, or arrays over fingers or over time."""

    low_n: Any
    """With the largest vibration."""
    high_n: Any
    """Without vibration."""

    def plus(self, disturbance_n: ArrayLike) -> Reach:
        """Return what can be reached beside a disturbance, N."""
        return Reach(self.low_n + disturbance_n, self.high_n + disturbance_n)

    def nearest(self, force_n: ArrayLike) -> Any:
        """Return the nearest forces within, N."""
        return np.clip(force_n, self.low_n, self.high_n)

    def beyond(self, force_n: ArrayLike, slack_n: float = 0.0) -> NDArray[np.bool_]:
        """Tell which forces are out of reach, by more than rounding and some slack, N."""
        force = np.asarray(force_n, dtype=float)
        rounding = ROUNDING * np.maximum(np.abs(force), np.abs(self.high_n))
        return np.asarray((force < self.low_n - slack_n - rounding) | (force > self.high_n + slack_n + rounding))

    def covers(self, low_n: float, high_n: float) -> Any:
        """Tell whether all forces between two are within."""
        return ~(self.beyond(low_n) | self.beyond(high_n))


def law_at(friction: FrictionLimit, motion: Sliding | Strokes, occluded: float = 0.0) -> Friction | Held:
    """Return the friction law that holds at the mean load and the stroke's speed, for small signals.

    f0 (N/N0)^n (v/v0)^p (1 + (M - 1) w) and tau (1 - l w) of `FingerFriction`, without roughness, tremor and drift;
    other friction is its own law. ``occluded`` is w: 0 just landed, 1 after long contact.
    """
    moves = isinstance(friction, FingerFriction) and isinstance(motion, Strokes)
    factor, loss = _factor_and_loss(friction, motion, occluded) if moves else (1.0, 0.0)
    if not is_gaussian(friction):
        return limit_law(friction, factor, occluded)
    tau = friction.susceptibility_per_um2 * (1.0 - loss)
    return Friction(nominal_n=friction.nominal_n * factor, susceptibility_per_um2=tau)


def _factor_and_loss(friction: Any, motion: Any, occluded: float) -> tuple[float, float]:
    """Return the factor on f0, and the share of tau that moisture takes."""
    given = tuple(limit_coefficients(friction))
    factor = float(limit_step(motion.load_n, 1e-3 * motion.speed_mm_s, occluded, 0.0, given))
    return factor, friction.moist_loss * occluded


def reach(
    friction: FrictionLimit, motion: Sliding | Strokes, max_amplitude_um: float, occluded: Sequence[float] = (0.0,)
) -> Reach:
    """Return the forces that friction can be given at any time of a contact, at its mean load and speed.

    [max over w of g(a_max), min over w of f0], equation (1). Roughness, tremor and drift of the load are left out.

    Parameters
    ----------
    friction, motion
        The finger's friction, and how it moves.
    max_amplitude_um
        Largest amplitude, um.
    occluded
        States of the finger that count, 0 (just landed) to 1 (after long contact).
    """
    laws: list[Law] = [law_at(friction, motion, w) for w in occluded]
    return Reach(max(float(friction_force(max_amplitude_um, law)) for law in laws), min(law.nominal_n for law in laws))


def reachable(system: System, disturbance_n: np.ndarray | float = 0.0) -> Reach:
    """Return the band of forces reachable at every value of the disturbance: [g(a_max) + max d, f0 + min d].

    The band is empty (low above high) when the disturbance swings wider than f0 - g(a_max), as with the paper's
    printed numbers.

    Parameters
    ----------
    system : System
        Its friction just landed, load, speed, and the plate's a_max.
    disturbance_n : array or float
        Values of the disturbance d in N, at least one, of any shape.

    Raises
    ------
    FrictionloopError
        For what is not a System, or a disturbance that is empty or not finite.
    """
    check_system(system)
    disturbance = numbers("disturbance_n", disturbance_n, "N")
    if disturbance.size == 0:
        raise FrictionloopError("disturbance_n: needs one force at least")
    found = reach(system.friction, system.motion, system.plate.max_amplitude_um)
    return Reach(found.low_n + float(disturbance.max()), found.high_n + float(disturbance.min()))


def finger_reach(
    values: Mapping[str, Any],
    max_amplitude_um: float = 2.5,
    contact_s: float = 0.0,
    contacts: float = 1.0,
    *,
    load_moves: bool = False,
) -> Reach:
    """Return the forces that a finger by its values can be given, as `capable` has them for many."""
    if contact_s == math.inf:
        raise FrictionloopError("contact_s = inf s: must be finite; in the end is contacts = inf")
    for name, value, unit in (("max_amplitude_um", max_amplitude_um, "um"), ("contact_s", contact_s, "s")):
        number(name, value, unit, 0.0)
    if not contacts >= 1.0:
        raise must_be("contacts", contacts, "at least 1")
    friction, motion = _block(FingerFriction, "friction", values), _block(Strokes, "motion", values)
    last = occlusion_after(friction, contact_s, motion.lifted_s, contacts)
    states = _extremes(friction, friction.susceptibility_per_um2 * max_amplitude_um**2, last)
    # The low force is missed under a heavy load, the high one under a light load.
    sides = (ALL_BUT_A_TWENTIETH, -ALL_BUT_A_TWENTIETH) if load_moves else (0.0,)
    ends = [reach(friction, _pressing(motion, side), max_amplitude_um, states) for side in sides]
    return Reach(ends[0].low_n, ends[-1].high_n)


def population_reach(population: Sequence[Mapping[str, Any]], *about: float, load_moves: bool = False) -> Reach:
    """Return `finger_reach` of each finger, as arrays; ``about`` are amplitude, contact and contacts."""
    found = [finger_reach(each, *about, load_moves=load_moves) for each in population]
    return Reach(*np.array(found).reshape(-1, 2).T)


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
        Fingers, as from `fingers`: dotted paths to values; those of ``friction`` and of ``motion`` count, and what is
        missing is the default of `FingerFriction` and `Strokes`.
    low_n, high_n : float
        Forces asked for in N (0.3 and 0.9: paper, Sec. 4.2); the same twice asks for one force.
    max_amplitude_um : float
        Largest amplitude of the plate, at least 0 (2.5: paper, Sec. 4.1).
    contact_s : float
        Time since landing until which both forces must be held, at least 0.
    contacts : float
        Number of contacts of a finger that was dry, with ``motion.lifted_s`` in the air between two; the last one
        counts. At least 1, infinity allowed.
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
    found = population_reach(population, max_amplitude_um, contact_s, contacts, load_moves=load_moves)
    low, high = found.low_n <= low_n, found.high_n >= high_n
    variables = {
        "lowest_n": ("finger", found.low_n, {"units": "N"}),
        "highest_n": ("finger", found.high_n, {"units": "N"}),
        "reaches_low": ("finger", low),
        "reaches_high": ("finger", high),
        "capable": ("finger", low & high),
    }
    attributes = {"low_n": low_n, "high_n": high_n, "max_amplitude_um": max_amplitude_um, "contact_s": contact_s}
    attributes |= {"contacts": contacts, "load_moves": int(load_moves)}
    import xarray as xr

    return xr.Dataset(variables, {"finger": np.arange(len(population))}, attributes)


def _pressing(motion: Strokes, deviations: float) -> Strokes:
    """Return strokes whose load is some standard deviations of drift and tremor off its mean."""
    deviation_n = math.hypot(motion.load_drift * motion.load_n, motion.tremor_n)
    load_n = max(motion.load_n + deviations * deviation_n, LEAST_LOAD_N) if deviations else motion.load_n
    return motion.model_copy(update={"load_n": load_n})


def _extremes(friction: FingerFriction, exponent: float, reached: float) -> list[float]:
    """Return the w among which (1 + g w) e^(c l w) and 1 + g w are greatest and least; c = tau a_max^2."""
    gain, growth = friction.occlusion_ratio - 1.0, exponent * friction.moist_loss
    if gain >= 0.0 or growth == 0.0:
        return [0.0, reached]
    return [0.0, reached, min(max(-1.0 / growth - 1.0 / gain, 0.0), reached)]


def _block(block: Any, name: str, values: Mapping[str, Any]) -> Any:
    own = {path.removeprefix(f"{name}."): value for path, value in values.items() if path.startswith(f"{name}.")}
    return block(**own)
