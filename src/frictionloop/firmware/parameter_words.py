"""The firmware's parameter table from a System: what bench, sensors and limits decide beside the controller."""

from __future__ import annotations

from typing import Any, cast

import numpy as np

from frictionloop.firmware.compiled import controller_words
from frictionloop.firmware.known import check_known
from frictionloop.firmware.words import filled, to_words, word_of
from frictionloop.parameters import System
from frictionloop.parameters.plant import SuspendedSensor
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.schema import parameter_words, schema
from frictionloop.sensing.touch import touch_coefficients

RANGE_N, ADC_BITS = 2.5, 16
"""Converter where the sensor is described without one (the bench's: paper, Fig. 4a, and assumed)."""
LIMIT_SHARE = 0.96
"""Largest plausible force over the converter's range (assumed: short of its end)."""
FORCE_S, STUCK_S, STUCK_LONGEST_S = 5e-3, 0.5, 100.0
"""Times until a force out of range and a reading that does not change are faults (assumed).

A sensor whose noise is below its converter's step may well tell the same for long: it is given the longest.
"""
OVERRUN_TICKS = 5
"""Late ticks in a second that are a fault (assumed: 0.1 %)."""


def firmware_words(system: System) -> np.ndarray:
    """Return the whole parameter table of the firmware, int32, in the order of protocol/frictionloop.toml.

    Raises
    ------
    FrictionloopError
        For a control rate that is not the firmware's, or a value outside the range of its word, naming both.
    """
    return filled(controller_words(system) | device_words(system))


def device_words(system: System) -> dict[str, np.ndarray]:
    """Return the words that are not the controller's, by name: drive, force, touch, set-point, safety."""
    check_known(system, "touch", "board")
    rate_hz = schema()["protocol"]["tick_hz"]
    if system.controller.rate_hz != rate_hz:
        raise FrictionloopError(
            f"controller.rate_hz = {system.controller.rate_hz:g} Hz: the firmware runs at {rate_hz} Hz"
        )
    board, setpoint = system.board, cast("Any", system.setpoint)
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


def _drive(system: System) -> dict[str, Any]:
    """Return the values ``drive.*``."""
    largest_um, board = system.plate.max_amplitude_um, system.board
    ceiling_um = largest_um if board.ceiling_um is None else board.ceiling_um
    if ceiling_um > largest_um:
        raise FrictionloopError(
            f"board.ceiling_um = {ceiling_um:g} um: must be at most plate.max_amplitude_um = {largest_um:g} um"
        )
    return {
        "drive.largest_um": largest_um,
        "drive.ceiling_um": ceiling_um,
        "drive.ramp_um": largest_um / (board.ramp_s * system.controller.rate_hz),
    }


def _touch(system: System) -> dict[str, Any]:
    """Return the values ``touch.*`` of `touch_step`; a finger that always slides is valid whatever is measured."""
    board = system.board
    given = touch_coefficients(system.touch, 1.0 / system.controller.rate_hz)
    if system.motion.kind == "sliding":
        given = given._replace(touch_n=0.0, touch_share=0.0, least_speed_m_s=0.0, developed_m=0.0)
    else:
        for name in ("load_n_per_count", "position_m_per_count"):
            if getattr(board, name) == 0:
                raise FrictionloopError(
                    f'board.{name} = 0: a finger with motion.kind = "strokes" never counts as sliding without that '
                    f'sensor; must not be 0, or motion.kind must be "sliding"'
                )
    return {
        "touch.zero_counts": board.load_zero_counts,
        "touch.n_per_count": board.load_n_per_count,
        "touch.m_per_count": board.position_m_per_count,
        **{f"touch.{name}": value for name, value in given._asdict().items() if f"touch.{name}" in parameter_words()},
    }


def _safety(system: System) -> dict[str, Any]:
    """Return the values ``safety.*``."""
    sensor, rate_hz, step_n = system.sensor, system.controller.rate_hz, abs(n_per_count(system))
    stuck_s = STUCK_S if sensor.noise_rms_n >= step_n / 2 else STUCK_LONGEST_S
    return {
        "safety.force_limit_n": system.board.force_limit_n or LIMIT_SHARE * step_n * 2 ** (ADC_BITS - 1),
        "safety.force_ticks": round(FORCE_S * rate_hz),
        "safety.stuck_ticks": round(stuck_s * rate_hz),
        "safety.overrun_ticks": OVERRUN_TICKS,
    }
