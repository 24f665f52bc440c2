"""The words and numbers that stand in the blocks of the diagram, read from their parameters."""

from __future__ import annotations

from frictionloop.parameters import (
    ColouredNoise,
    Constant,
    Controller,
    FrictionLaw,
    FrictionLimit,
    LogSweep,
    Model,
    PiController,
    Plate,
    Recording,
    Sensor,
    Sine,
    Source,
    Steps,
)
from frictionloop.report.numbers import number


def source_label(source: Source) -> str:
    """Return what a set-point or disturbance does over time."""
    if isinstance(source, Constant):
        return f"constant {number(source.offset_n)} N"
    if isinstance(source, Recording):
        return "recording"
    if isinstance(source, Steps):
        return f"{len(source.levels_n)} levels, {number(min(source.levels_n))} to {number(max(source.levels_n))} N"
    if isinstance(source, ColouredNoise):
        return f"1/f{_power(source.exponent)} noise, {number(source.rms_n)} N rms"
    return _swing_label(source) if isinstance(source, Sine | LogSweep) else source.kind


def _swing_label(source: Sine | LogSweep) -> str:
    around = f"{number(source.offset_n)} ± {number(source.amplitude_n)} N"
    if isinstance(source, Sine):
        return f"sine {number(source.frequency_hz)} Hz\n{around}"
    return f"sweep {number(source.start_hz)}–{number(source.stop_hz)} Hz\n{around}"


def _power(exponent: float) -> str:
    return "" if exponent == 1 else f"^{number(exponent)}"


def controller_label(controller: Controller) -> list[str]:
    """Return gains (or the kind of a law that is not PI), rate and delay."""
    rate = f"{number(controller.rate_hz / 1000)} kHz"
    delay = f", delay {number(controller.delay_s * 1e6)} µs" if controller.delay_s else ", no delay"
    if not isinstance(controller, PiController):
        return [controller.kind, rate + delay]
    return [f"$K_p$ = {number(controller.kp)}", f"$K_i$ = {number(controller.ki)} s⁻¹", rate + delay]


def lookup_label(model: Model) -> list[str]:
    """Return what the lookup table inverts and the clamp before it."""
    table = "exact inverse of $g$" if model.table_size == 0 else f"{model.table_size} entries"
    return [
        table,
        f"{number(model.floor_n, 2)} ≤ $u$ ≤ {number(model.nominal_n)} N",
        f"0 ≤ $a$ ≤ {number(model.max_amplitude_um)} µm",
    ]


def plate_label(plate: Plate) -> list[str]:
    """Return the dynamics and the limit of the plate."""
    return ["first-order low-pass", f"{number(plate.cutoff_hz)} Hz", f"$a$ ≤ {number(plate.max_amplitude_um)} µm"]


def friction_label(friction: FrictionLimit) -> list[str]:
    """Return the friction law, equation (1)."""
    if not isinstance(friction, FrictionLaw):
        return [friction.kind]
    f0, tau = number(friction.nominal_n), number(friction.susceptibility_per_um2)
    return ["$f_0\\,\\exp(-\\tau a^2)$", f"$f_0$ = {f0} N", f"$\\tau$ = {tau} µm⁻²"]


def sensor_label(sensor: Sensor) -> list[str]:
    """Return the dynamics of the sensor."""
    return ["first-order low-pass", f"{number(sensor.cutoff_hz)} Hz"]


def noise_label(sensor: Sensor) -> str:
    """Return the sensor noise."""
    return f"white, {number(sensor.noise_rms_n)} N rms"
