"""A System's control law as one file of C99, for a board of one's own: law, inverse, overdrive, gains, start."""

from __future__ import annotations

import os
from pathlib import Path
from string import Template
from typing import Any

import numpy as np

from frictionloop.analysis.stability import rings_if_linear
from frictionloop.control.law import Law
from frictionloop.control.laws import law_of
from frictionloop.control.lookup import (
    OverdriveGains,
    interpolate_step,
    inverse_numbers,
    inverse_step,
    lookup_table,
    no_overdrive,
    overdrive_gains,
    overdrive_step,
    table_position,
)
from frictionloop.findings import Result
from frictionloop.findings.result import Row
from frictionloop.firmware.c_types import REAL, identifier, literal
from frictionloop.firmware.translation import INCLUDES, Translation
from frictionloop.parameters import Model, System
from frictionloop.parameters.summary import gains_said
from frictionloop.quantities import flat_tuples, replacing
from frictionloop.quantities.code_version import package_version
from frictionloop.sensing.finger_tracking import TouchCoefficients, TouchState, board_touch, touch_step
from frictionloop.sensing.measurement import Measurement

TESTED = 10_000
"""Periods of the bit test."""
TEMPLATE = Path(__file__).with_name("law.c.txt")


class LawSource(Result, schema="firmware.law/1"):
    """A law as C99; its file is there."""

    system: System
    law: str
    rate_hz: float
    lines: int
    digest: str
    """Of u and amplitude over the bit test, as the simulator's compiled step computes them: hexadecimal, 64 bits."""
    path: str

    def rows(self) -> list[Row]:
        """Return the law, the file, and how to test it."""
        return [
            (self.law, gains_said(self.system)),
            ("file", f"{self.lines} lines, one call per {1e6 / self.rate_hz:g} us"),
            ("bit test", f"built with -DBIT_TEST it prints {self.digest}"),
        ]


def law(system: System, out: str | os.PathLike[str]) -> LawSource:
    """Write the control law of a System as C99 with its gains: readings and set-point in, u and amplitude out.

    What finds out whether the finger slides, and waits after a turn (`touch_step`), is in it.

    The law of a user's own (`fl.register`) is translated like a built-in one, from its compiled step. The file has a
    bit test: `TESTED` periods on any board give the digest of the simulator, or some bit differs.

    Parameters
    ----------
    system
        The bench with its controller.
    out
        File to write, ``law.c``.

    Raises
    ------
    FrictionloopError
        NO-C, with function, line and text, for a step with something that has no C.
    """
    own, path = law_of(system.controller), Path(out)
    text, digest = law_source(system, own)
    ringing = rings_if_linear(system)
    found = ringing.finding if ringing is not None else None
    with replacing(path) as beside:
        beside.write_text(text, encoding="utf-8")
    return LawSource(
        system=system,
        law=system.controller.kind,
        rate_hz=system.controller.rate_hz,
        lines=text.count("\n"),
        digest=digest,
        path=str(path),
        findings=(found,) if found is not None else (),
    )


def law_source(system: System, own: Law) -> tuple[str, str]:
    """Return the C of a law with its constants, and the digest of its bit test."""
    controller, within = system.controller, Translation()
    shapes = own.state, own.gains, Measurement, OverdriveGains
    state, gains, measurement, overdriven = (within.struct(shape) for shape in shapes)
    name, after = within.function(own.step, [state, measurement, REAL, gains, REAL])
    plate, plate_after = within.function(overdrive_step, [REAL, REAL, overdriven])
    touch, seen = within.struct(TouchState), within.struct(TouchCoefficients)
    touched, touched_after = within.function(touch_step, [touch, *[REAL] * 4, seen])
    felt = board_touch(system)
    looked_up, tables = _lookup(system, within)
    start, values = own.start_for(controller), own.gains_for(controller)
    digest = f"{bit_test(system, own):016x}"
    filled = {
        "kind": controller.kind, "version": package_version(), "gains_said": gains_said(system),
        "period_us": f"{1e6 / controller.rate_hz:g}", "delay_us": f"{1e6 * controller.delay_s:g}",
        "periods": TESTED, "digest": digest, "translated": within.text(), "tables": tables, "look_up": looked_up,
        "State": state, "Gains": gains, "step": name, "After": after, "dt": literal(1.0 / controller.rate_hz),
        "start": _initialised(own.state, start), "gains": _initialised(own.gains, values),
        "overdrive": _initialised(OverdriveGains, _drive(controller)),
        "overdrive_step": plate, "PlateAfter": plate_after,
        "TouchState": touch, "TouchCoefficients": seen, "touch_step": touched, "Touched": touched_after,
        "touch": _initialised(TouchCoefficients, felt), "landed": _initialised(TouchState, _landed(felt)),
    }  # fmt: skip
    return INCLUDES + Template(TEMPLATE.read_text(encoding="utf-8")).substitute(filled), digest


def _lookup(system: System, within: Translation) -> tuple[str, str]:
    """Return C that looks ``u`` up, the exact inverse or between entries of a table, and the table."""
    model = system.controller.model
    if model.table_size == 0:
        name, _ = within.function(inverse_step, [REAL, REAL, REAL])
        return f"return {name}(u, {', '.join(map(literal, inverse_numbers(model)))});", ""
    position, place = within.function(table_position, [REAL, REAL, REAL, REAL])
    between, _ = within.function(interpolate_step, [REAL, REAL, REAL])
    squares = ",\n    ".join(literal(float(each)) for each in lookup_table(model))
    return (
        f"{place} at = {position}(u, {', '.join(map(literal, _table(model)))});\n"
        f"    return {between}(at.of2, SQUARE_UM2[at.of0], SQUARE_UM2[at.of1]);",
        f"static const double SQUARE_UM2[] = {{\n    {squares}}};\n",
    )


def _initialised(shape: type, value: Any) -> str:
    """Return a named tuple as an initialiser, each field with its name."""
    parts = [
        f".{identifier(name)} = {literal(float(each)) if inner is None else _initialised(inner, each)}"
        for (name, inner), each in zip(flat_tuples.parts(shape), value, strict=True)
    ]
    return f"{{{', '.join(parts)}}}"


def bit_test(system: System, own: Law) -> int:
    """Return the digest of u and amplitude over `TESTED` periods of readings that any machine makes alike (FNV-1a)."""
    controller, model = system.controller, system.controller.model
    state, gains = floats(own.start_for(controller)), floats(own.gains_for(controller))
    drive, plate_um, dt, digest = _drive(controller), 0.0, 1.0 / controller.rate_hz, 0xCBF29CE484222325
    felt = board_touch(system)
    touch = _landed(felt)
    for k in range(TESTED):
        force_n = 0.5 + (k * 7 % 512 - 256) / 1024 + ((k * 40503 & 65535) // 256 - 128) / 4096
        place, load_n = min(k % 2048, 2048 - k % 2048), 0.0 if k % 5000 < 60 else 0.5
        touch, seen = touch_step(touch, (place - 512) / 32768, load_n, 0.0, 0.0, felt)
        signed_n = force_n if k % 2048 < 1024 else -force_n
        reading = Measurement(touch[5] * signed_n, *seen)
        state, (u, _) = own.step(state, reading, 0.5 + (k * 3 % 1024 - 512) / 2048, gains, dt)
        plate_um, amplitude_um = overdrive_step(plate_um, _amplitude_um(float(u), model), drive)
        for value in (u, amplitude_um):
            digest = (digest ^ int(np.float64(value).view(np.uint64))) * 0x100000001B3 % 2**64
    return digest


def _landed(felt: TouchCoefficients) -> TouchState:
    return TouchState(0.0, 0.0, 0.0, felt.developed_m, 0.0, 1.0, 0.0)


def _drive(controller: Any) -> OverdriveGains:
    return overdrive_gains(controller) if hasattr(controller, "overdrive") else no_overdrive(controller.model)


def _amplitude_um(u: float, model: Model) -> float:
    if model.table_size == 0:
        return float(inverse_step(u, *inverse_numbers(model)))
    below, above, fraction = table_position(u, *_table(model))
    squares = lookup_table(model)
    return float(interpolate_step(fraction, float(squares[below]), float(squares[above])))


def _table(model: Model) -> tuple[float, float, float]:
    low_n, high_n, size = model.floor_n, model.nominal_n, model.table_size
    return low_n, (size - 1) / (high_n - low_n), float(size - 2)


def floats(value: Any) -> Any:
    """Return a named tuple with all its numbers doubles."""
    return type(value)(*(floats(each) if isinstance(each, tuple) else float(each) for each in value))
