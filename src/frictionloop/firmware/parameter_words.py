"""The firmware's parameter table from a System: what bench, sensors and limits decide beside the controller."""

from __future__ import annotations

import math
from typing import Any, cast

import numpy as np

from frictionloop.firmware.compiled_core import check_known, controller_words, tick_hz
from frictionloop.firmware.parameter_files import filled, to_words, word_of
from frictionloop.parameters import System
from frictionloop.parameters.plant import Sensor, SuspendedSensor
from frictionloop.quantities import must_be
from frictionloop.quantities.protocol_schema import parameter_words
from frictionloop.sensing.finger_tracking import board_touch

RANGE_N, ADC_BITS = 2.5, 16
"""Converter where the sensor is described without one (the bench's: paper, Fig. 4a, and assumed)."""
LIMIT_SHARE = 0.96
"""Largest plausible force over the converter's range (assumed: short of its end)."""
FORCE_S = 5e-3
"""Time until a force out of range is a fault (assumed)."""
STUCK_CHANCE, STUCK_LONGEST_S = 1e-15, 100.0
"""Chance that noise alone stays so long within one step (ten hours have 2e8 ticks); longest time that is asked for."""
TAP_N_S = 5e3
"""Fastest load: a fingertip of 5 g that is stopped from 1 m/s within 1 ms (assumed)."""
COEFFICIENT = 5.0
"""Largest coefficient of friction (assumed; 0.4 to 2.8 are published): no force without a load is above it."""
SOFTEST_N_M = 250.0
"""Stiffness of the softest skin: four standard deviations below the median of the population (physics/fingers)."""
HALF_MAINS_S, LONGEST_HALF_S = 9e-3, 10e-3
"""Half a period of the mains, between those of 50 and 60 Hz; as long as the firmware remembers."""
LARGEST = 8.0
"""Of a limit of these (protocol/frictionloop.toml)."""
OVERRUN_TICKS = 5
"""Late ticks in a second that are a fault (assumed: 0.1 %)."""


def firmware_words(system: System) -> np.ndarray:
    """Return the whole parameter table of the firmware, doubles in the order of protocol/frictionloop.toml."""
    return filled(controller_words(system) | device_words(system))


def device_words(system: System) -> dict[str, np.ndarray]:
    """Return the words that are not the controller's, by name: drive, force, touch, set-point, safety."""
    check_known(system, "touch", "board")
    tick_hz(system.controller.rate_hz)
    board, setpoint = system.board, cast("Any", system.setpoint)
    if setpoint.kind != "steps" and not hasattr(setpoint, "offset_n"):
        raise must_be("setpoint.kind", setpoint.kind, "constant, sine, steps or recording")
    level_n = setpoint.levels_n[0] if setpoint.kind == "steps" else setpoint.offset_n
    values = {
        **_drive(system),
        "force.axes": board.force_axes,
        "force.zero_counts": board.force_zero_counts,
        "force.n_per_count": (n_per_count(system), board.across_n_per_count),
        **_touch(system),
        "setpoint.hold_n": max(level_n, 0.0),
        **_safety(system),
    }
    return {name: to_words(word_of(name), value) for name, value in values.items()}


def n_per_count(system: System) -> float:
    """Return the newtons that a count of the first force channel stands for."""
    if system.board.force_n_per_count is not None:
        return system.board.force_n_per_count
    sensor = system.sensor
    range_n = sensor.range_n if isinstance(sensor, SuspendedSensor) else RANGE_N
    return 2.0 * range_n / 2**ADC_BITS


def _largest_reading_n(system: System) -> float:
    """Return the largest magnitude of the force that the converter can read, with its zeros."""
    board, half = system.board, 2 ** (ADC_BITS - 1)
    scales = (n_per_count(system), board.across_n_per_count)[: board.force_axes]
    zeros = board.force_zero_counts[: board.force_axes]
    return math.hypot(*(abs(n) * max(half + zero, half - 1 - zero) for n, zero in zip(scales, zeros, strict=True)))


def _drive(system: System) -> dict[str, Any]:
    """Return the values ``drive.*``."""
    largest_um, board = system.plate.max_amplitude_um, system.board
    ceiling_um = largest_um if board.ceiling_um is None else board.ceiling_um
    if ceiling_um > largest_um:
        raise must_be("board.ceiling_um", ceiling_um, f"at most plate.max_amplitude_um = {largest_um:g}", "um")
    return {
        "drive.largest_um": largest_um,
        "drive.ceiling_um": ceiling_um,
        "drive.ramp_um": largest_um / (board.ramp_s * system.controller.rate_hz),
    }


def _touch(system: System) -> dict[str, Any]:
    """Return the values ``touch.*`` of `touch_step`; a finger that always slides is valid whatever is measured."""
    board = system.board
    given = board_touch(system)
    if system.motion.kind != "sliding":
        for name in ("load_n_per_count", "position_m_per_count"):
            if getattr(board, name) == 0:
                raise must_be(f"board.{name}", 0.0, "other than 0")
    return {
        "touch.zero_counts": board.load_zero_counts,
        "touch.n_per_count": board.load_n_per_count,
        "touch.m_per_count": board.position_m_per_count,
        "touch.lead_s": system.controller.delay_s + 0.5 / system.controller.rate_hz,
        **{f"touch.{name}": value for name, value in given._asdict().items() if f"touch.{name}" in parameter_words()},
    }


def _safety(system: System) -> dict[str, Any]:
    """Return the values ``safety.*``; docs/firmware-states derives them."""
    rate_hz, position, load = system.controller.rate_hz, system.touch.position, system.touch.load
    range_n = abs(n_per_count(system)) * 2 ** (ADC_BITS - 1)
    limit_n = system.board.force_limit_n or LIMIT_SHARE * range_n
    if limit_n >= (largest_n := _largest_reading_n(system)):
        accepted = f"below {largest_n:.4g}, the largest reading; {LIMIT_SHARE * range_n:.4g} if left out"
        raise must_be("board.force_limit_n", limit_n, accepted, "N")
    return {
        "safety.force_limit_n": limit_n,
        "safety.force_ticks": round(FORCE_S * rate_hz),
        "safety.stuck_ticks": _stuck_ticks(system),
        "safety.overrun_ticks": OVERRUN_TICKS,
        "safety.force_jump_n": min(_fastest(system.sensor, 1.0 / rate_hz) * range_n, LARGEST),
        "safety.position_jump_m": 1e-3 * position.fastest_mm_s / rate_hz
        + 1e-6 * (8 * math.sqrt(2) * position.noise_um + position.resolution_um),
        "safety.load_jump_n": min(TAP_N_S / rate_hz + 8 * math.sqrt(2) * 2 * load.noise_n, LARGEST),
        "safety.contrary_n": min(COEFFICIENT * load.touch_n, LARGEST),
        "safety.turn_m": min(limit_n / SOFTEST_N_M, LARGEST),
        "safety.hum_n": min(system.board.hum_share * range_n, LARGEST),
        "safety.hum_ticks": _hum_ticks(system.sensor, rate_hz),
    }


def _fastest(sensor: Sensor, dt: float) -> float:
    """Return the largest change of a reading in a period over its range.

    Springs swing at their resonance, between the ends at most: 2 sin(w dt/2). Without springs the low-pass alone
    limits it, from end to end.
    """
    if isinstance(sensor, SuspendedSensor):
        return 2.0 * math.sin(min(math.pi * sensor.resonance_hz * dt, math.pi / 2))
    return -2.0 * math.expm1(-2.0 * math.pi * sensor.cutoff_hz * dt)


def _hum_ticks(sensor: Sensor, rate_hz: float) -> int:
    """Return the whole number of periods of the springs that is nearest to half a period of the mains at 55 Hz."""
    if not isinstance(sensor, SuspendedSensor):
        return round(HALF_MAINS_S * rate_hz)
    ticks = max(round(HALF_MAINS_S * sensor.resonance_hz), 1) * rate_hz / sensor.resonance_hz
    return round(ticks) if ticks <= LONGEST_HALF_S * rate_hz else round(HALF_MAINS_S * rate_hz)


def _stuck_ticks(system: System) -> int:
    """Return how long noise alone never stays within one step of the converter.

    Noise behind a low-pass goes on as n' = r n + sqrt(1 - r^2) s z, so a reading is within the two steps that the one
    before left with a chance of at most erf(1/(sqrt(2) sqrt(1 - r^2) s)), s in steps.
    """
    sensor, rate_hz, step_n = system.sensor, system.controller.rate_hz, abs(n_per_count(system))
    if isinstance(sensor, SuspendedSensor):
        step_n = max(step_n, sensor.step_n)
    decay = math.exp(-2.0 * math.pi * sensor.cutoff_hz / rate_hz)
    fresh = sensor.noise_rms_n * math.sqrt(1.0 - decay**2) / step_n
    stays, longest = math.erf(1.0 / (math.sqrt(2.0) * fresh)) if fresh else 1.0, round(STUCK_LONGEST_S * rate_hz)
    return min(math.ceil(math.log(STUCK_CHANCE) / math.log(stays)), longest) if stays < 1.0 else longest
