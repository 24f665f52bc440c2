"""A system in words: one row per block under the names that flags use, and what follows from its numbers.

Of the signals and of the law all values are said, of other blocks those that are not their defaults.
"""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel

from frictionloop.cli import screen
from frictionloop.parameters import (
    Board,
    FingerFriction,
    Recording,
    ResonantPlate,
    Skin,
    Strokes,
    SuspendedSensor,
    System,
    Timing,
)
from frictionloop.quantities import FrictionloopError

Row = tuple[str, ...]
WHOLE = ("setpoint", "disturbance", "controller")
"""Blocks of which every value is said; of a controller those of its law."""


def system_rows(system: System) -> list[Row]:
    """Return (block, its kind and what is said of it) for each block, nested blocks after the one that holds them."""
    rows: list[Row] = []
    notes = notes_of(system)
    for name, block in system:
        # Where the finger is and how hard it presses is neither known nor used without a motion, and the wiring of a
        # board by no simulation: worth a row only where somebody has set it.
        unused = (name == "touch" and system.motion.kind == "sliding") or (name == "board" and block == Board())
        if not unused:
            rows += _block_rows(name, block, notes)
    return rows


def _block_rows(name: str, block: BaseModel, notes: dict[str, str]) -> list[Row]:
    kind, values, inner = "", [], []
    usual = _usual(name, block)
    for key in block.model_dump():  # in the order of files: a law's own values before what all controllers have
        value = getattr(block, key)
        if key == "kind":
            kind = str(value)
        elif isinstance(value, BaseModel):
            inner += _block_rows(f"{name}.{key}", value, notes)
        elif value is not None and not (key in usual and value == usual[key]):
            values.append(f"{key}={short(value)}")
    said = ": ".join(part for part in (kind, ", ".join(values)) if part)
    note: list[Row] = [("", f"-> {notes[name]}")] if name in notes else []
    own: list[Row] = [(name, said)] if said else [(name, note.pop()[1])] if note else []
    return [*own, *note, *inner]


def _usual(name: str, block: BaseModel) -> dict[str, Any]:
    """Return the values that are not worth a word, by their names: defaults."""
    fields = Timing.model_fields if name == "controller" else {} if name in WHOLE else type(block).model_fields
    return {key: each.get_default(call_default_factory=True) for key, each in fields.items() if not each.is_required()}


def short(value: Any) -> str:
    """Return a value with at most six digits, a long list by its first values."""
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, (list, tuple)):
        shown = ", ".join(map(short, value[:6]))
        return f"[{shown}]" if len(value) <= 6 else f"[{shown}, ... {len(value)} values]"
    return '","' if value == "," else str(value)


def notes_of(system: System) -> dict[str, str]:
    """Return what a person wants to know of each block besides its values, by the block's dotted name."""
    found: dict[str, str] = {}
    for name, signal in (("setpoint", system.setpoint), ("disturbance", system.disturbance)):
        if isinstance(signal, Recording):
            from frictionloop.recordings.told import told

            found[name] = told(signal)
    friction, plate, sensor, controller = system.friction, system.plate, system.sensor, system.controller
    if isinstance(friction, FingerFriction) and (band := _band(system)):
        found["friction"] = f"{band[0]:.3g} to {band[1]:.3g} N within reach just after landing"
    if isinstance(plate, ResonantPlate):
        found["plate"] = f"envelope cutoff {plate.cutoff_hz:.4g} Hz"
    if isinstance(sensor, SuspendedSensor):
        found["sensor"] = (
            f"springs {sensor.stiffness_n_m * 1e-6:.3g} N/um, noise {sensor.noise_rms_n * 1e3:.3g} mN rms, "
            f"ADC step {sensor.step_n * 1e3:.3g} mN"
        )
    if controller.delay_s > 0:
        found["controller"] = f"{_delay(controller.delay_s + 0.5 / controller.rate_hz)} with half the hold"
    if isinstance(system.motion, Strokes):
        found |= _moving(system.motion, system)
    return found


def _moving(motion: Strokes, system: System) -> dict[str, str]:
    model = system.controller.model
    found = {
        "controller.model": f"force command from {model.floor_n:.3g} to {model.nominal_n:.3g} N",
        "motion": f"{motion.speed_mm_s:g} mm/s, {motion.cycle_s:.3g} s there and back, reversals included",
    }
    if isinstance(system.finger, Skin):
        slew = system.finger.stiffness_n_m * motion.speed_mm_s * 1e-3
        found["finger"] = f"friction rises by at most {slew:.3g} N/s, stiffness of the skin times speed"
    return found


def finger_values(system: System) -> dict[str, Any]:
    """Return the values of friction and motion under their dotted names, as `capable` reads them."""
    blocks = {"friction": system.friction, "motion": system.motion}
    return {f"{name}.{key}": value for name, block in blocks.items() for key, value in block}


def _band(system: System) -> tuple[float, float] | None:
    from frictionloop.physics.capable import reach

    try:
        return reach(finger_values(system), system.plate.max_amplitude_um)
    except FrictionloopError:
        return None


def _delay(value_s: float) -> str:
    """Return a delay in us, and from 1 ms on as other durations are told."""
    return f"{1e6 * value_s:.4g} us" if value_s < 1e-3 else screen.seconds(value_s)
