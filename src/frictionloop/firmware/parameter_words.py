"""The firmware's parameter table from a System: what bench, sensors and limits decide beside the controller."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from frictionloop.firmware.compiled import controller_words
from frictionloop.firmware.known import check_known
from frictionloop.firmware.quantised import to_gain, to_places
from frictionloop.parameters import System
from frictionloop.parameters.plant import SuspendedSensor
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.schema import BITS, parameter_words, schema, word_count
from frictionloop.sensing.touch import TouchCoefficients, touch_coefficients

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
    table = np.zeros(word_count(), dtype=np.int32)
    for name, values in (controller_words(system) | device_words(system)).items():
        word = parameter_words()[name]
        table[word.first : word.first + word.words] = values
    return table


def device_words(system: System) -> dict[str, np.ndarray]:
    """Return the words that are not the controller's: drive, force, touch, set-point, safety."""
    check_known(system, "touch", "board")
    rate_hz = schema()["protocol"]["tick_hz"]
    if system.controller.rate_hz != rate_hz:
        raise FrictionloopError(
            f"controller.rate_hz = {system.controller.rate_hz:g} Hz: the firmware runs at {rate_hz} Hz"
        )
    return drive_words(system) | force_words(system) | touch_words(system) | held_words(system) | safety(system)


def drive_words(system: System) -> dict[str, np.ndarray]:
    """Return the words ``drive.*``: the carrier's fundamental goes with sin(pi duty), so duty = asin(a/a_max)/pi."""
    largest_um, board = system.plate.max_amplitude_um, system.board
    ceiling_um = largest_um if board.ceiling_um is None else board.ceiling_um
    if ceiling_um > largest_um:
        raise FrictionloopError(
            f"board.ceiling_um = {ceiling_um:g} um: must be at most plate.max_amplitude_um = {largest_um:g} um"
        )
    share = np.linspace(0.0, 1.0, parameter_words()["drive.duty"].count)
    return {
        "drive.largest_um": word("drive.largest_um", largest_um),
        "drive.ceiling_um": word("drive.ceiling_um", ceiling_um),
        "drive.ramp_um": word("drive.ramp_um", largest_um / (board.ramp_s * system.controller.rate_hz)),
        "drive.duty": np.round(np.arcsin(share) / math.pi * 2**17).astype(np.int32),
    }


def n_per_count(system: System) -> float:
    """Return the newtons that a count of the first force channel stands for."""
    if system.board.force_n_per_count is not None:
        return system.board.force_n_per_count
    sensor = system.sensor
    range_n = sensor.range_n if isinstance(sensor, SuspendedSensor) else RANGE_N
    return 2.0 * range_n / 2**ADC_BITS


def force_words(system: System) -> dict[str, np.ndarray]:
    """Return the words ``force.*``: which channels tell the force along the motion, as `Measurement` has it."""
    board = system.board
    scales = n_per_count(system), board.across_n_per_count
    return {
        "force.axes": word("force.axes", board.force_axes),
        "force.zero_counts": np.array(board.force_zero_counts, dtype=np.int32),
        "force.n_per_count": np.concatenate([gain("force.n_per_count", scale) for scale in scales]),
    }


def touch_words(system: System) -> dict[str, np.ndarray]:
    """Return the words ``touch.*`` of `touch_step`; a finger that always slides is valid whatever is measured."""
    given = touch_coefficients(system.touch, 1.0 / system.controller.rate_hz)
    if system.motion.kind == "sliding":
        given = given._replace(touch_n=0.0, touch_share=0.0, least_speed_m_s=0.0, developed_m=0.0)
    else:
        for name in ("load_n_per_count", "position_m_per_count"):
            if getattr(system.board, name) == 0:
                raise FrictionloopError(
                    f'board.{name} = 0: a finger with motion.kind = "strokes" never counts as sliding without that '
                    f'sensor; must not be 0, or motion.kind must be "sliding"'
                )
    same: tuple[str, ...] = ("position_gain", "touch_n", "touch_share", "mean_gain", "least_speed_m_s", "developed_m")
    assert set(same) < set(TouchCoefficients._fields)
    return {
        "touch.zero_counts": word("touch.zero_counts", system.board.load_zero_counts),
        "touch.n_per_count": gain("touch.n_per_count", system.board.load_n_per_count),
        "touch.m_per_count": gain("touch.m_per_count", system.board.position_m_per_count),
        "touch.speed_gain": gain("touch.speed_gain", given.speed_gain),
        **{f"touch.{name}": word(f"touch.{name}", getattr(given, name)) for name in same},
    }


def held_words(system: System) -> dict[str, np.ndarray]:
    """Return the words ``setpoint.*``: the level of the set-point, the first of its steps, within what is possible."""
    setpoint: Any = system.setpoint
    level_n = setpoint.levels_n[0] if setpoint.kind == "steps" else setpoint.offset_n
    return {"setpoint.hold_n": word("setpoint.hold_n", max(level_n, 0.0))}


def safety(system: System) -> dict[str, np.ndarray]:
    """Return the words ``safety.*``."""
    sensor, rate_hz, step_n = system.sensor, system.controller.rate_hz, abs(n_per_count(system))
    limit_n = system.board.force_limit_n or LIMIT_SHARE * step_n * 2 ** (ADC_BITS - 1)
    stuck_s = STUCK_S if sensor.noise_rms_n >= step_n / 2 else STUCK_LONGEST_S
    return {
        "safety.force_limit_n": word("safety.force_limit_n", limit_n),
        "safety.force_ticks": word("safety.force_ticks", round(FORCE_S * rate_hz)),
        "safety.stuck_ticks": word("safety.stuck_ticks", round(stuck_s * rate_hz)),
        "safety.overrun_ticks": word("safety.overrun_ticks", OVERRUN_TICKS),
    }


def word(name: str, value: float) -> np.ndarray:
    """Return a value as the word of a parameter, refused outside its range."""
    known = parameter_words()[name]
    low, high = (-math.inf if known.low is None else known.low), (math.inf if known.high is None else known.high)
    if not low <= value <= high:
        raise FrictionloopError(f"{name} = {value:g} {known.unit}: the firmware takes {low:g} to {high:g}")
    return np.array([to_places(value, BITS[known.format], name)], dtype=np.int32)


def gain(name: str, value: float) -> np.ndarray:
    """Return a value as mantissa and shift."""
    return np.array(to_gain(value, name), dtype=np.int32)
