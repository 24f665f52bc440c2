"""The C that an image has of a control law and of what stands around every law, translated from their steps.

A law registered from outside (`fl.register`) goes the same way as a built-in one.
"""

from __future__ import annotations

import re
import zlib
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from string import Template

from frictionloop.control.law import CLOSING, Clamp, ForceCommand, Law, switched_clamp
from frictionloop.control.lookup import (
    NoState,
    OverdriveGains,
    interpolate_step,
    inverse_step,
    open_loop_step,
    overdrive_step,
    table_position,
)
from frictionloop.firmware.c_types import INT, REAL
from frictionloop.firmware.translation import Translation
from frictionloop.quantities import flat_tuples, must_be
from frictionloop.quantities.protocol_schema import parameter_words
from frictionloop.sensing.finger_tracking import TouchCoefficients, TouchState, touch_step
from frictionloop.sensing.measurement import Measurement

TEMPLATE = Path(__file__).with_name("board_law.c.txt")
FILE = "board_law.c"
"""Its name in a build folder."""
LOOKUP = 0
"""``law.hash`` of the lookup, which every image has."""
KIND_BYTES = 32
"""Of ``identity.law``."""


@dataclass(frozen=True)
class BoardLaw:
    """A law as an image has it."""

    kind: str
    text: str
    hash: int
    """CRC-32 of the C without its comments."""

    def write(self, folder: Path) -> Path:
        """Write it into a folder, and return its path; a file that is so already stays."""
        path = folder / FILE
        if not path.is_file() or path.read_text(encoding="utf-8") != self.text:
            path.write_text(self.text, encoding="utf-8")
        return path


@cache
def board_law(law: Law) -> BoardLaw:
    """Return the C of a law, as an image is built with.

    Raises
    ------
    FrictionloopError
        NO-C for a step with something that has no C; for a law with more numbers than a device's table has room for.
    """
    words, kind = parameter_words(), law.kind
    for what, size in ("gains", flat_tuples.size(law.gains) - 2), ("start", flat_tuples.size(law.state)):
        if size > (room := words[f"law.{what}"].count):
            raise must_be(f"{kind}: {what}", size, f"at most {room} on a board", "numbers")
    if not (kind.isascii() and kind.isprintable() and '"' not in kind and "\\" not in kind and len(kind) < KIND_BYTES):
        raise must_be("kind", kind, f"letters, at most {KIND_BYTES - 1}, on a board")
    filled = {**_parts(law), "kind": kind, "closing": CLOSING}
    template = Template(TEMPLATE.read_text(encoding="utf-8"))
    code = re.sub(r"/\*.*?\*/", "", template.substitute(filled, hash="0"), flags=re.DOTALL)
    number = zlib.crc32(code.encode()) or 1
    return BoardLaw(kind, template.substitute(filled, hash=f"{number:08x}"), number)


def _parts(law: Law) -> dict[str, object]:
    """Return what the template is filled with."""
    within = Translation()
    # Those that the template names come first, so that no tuple of the law's has their names.
    shapes = Measurement, NoState, Clamp, ForceCommand, TouchState, TouchCoefficients, OverdriveGains
    measured, none, clamp, _, touch, seen, drive = map(within.struct, shapes)
    state, gains = within.struct(law.state), within.struct(law.gains)
    step, after = within.function(law.step, [state, measured, REAL, gains, REAL])
    open_step, _ = within.function(open_loop_step, [none, measured, REAL, clamp, REAL])
    switched, moved = within.function(switched_clamp, [REAL, REAL, REAL, INT])
    touched, touched_after = within.function(touch_step, [touch, *[REAL] * 4, seen])
    position, place = within.function(table_position, [REAL, REAL, REAL, REAL])
    inverse, between = (within.function(each, [REAL] * 3)[0] for each in (inverse_step, interpolate_step))
    overdrive, driven = within.function(overdrive_step, [REAL, REAL, drive])
    begin = "    (void)state, (void)force, (void)setpoint, (void)p, (void)clamp;\n"
    if law.begin is not None:
        own, _ = within.function(law.begin, [state, REAL, REAL, gains])
        begin = (
            f"    {state} own;\n    memcpy(&own, state, sizeof own);\n"
            f"    own = {own}(own, force, setpoint, gains_of(p, clamp));\n    memcpy(state, &own, sizeof own);\n"
        )
    told = [name for name, _ in flat_tuples.parts(TouchCoefficients) if f"touch.{name}" in parameter_words()]
    return {
        "translated": within.text(), "State": state, "Gains": gains, "step": step, "After": after, "begin": begin,
        "open_step": open_step, "switched_clamp": switched, "Switched": moved, "touch_step": touched,
        "Touched": touched_after, "table_position": position, "Place": place, "inverse_step": inverse,
        "interpolate_step": between, "overdrive_step": overdrive, "Driven": driven,
        "coefficients": "".join(f"        .{name} = p->touch_{name},\n" for name in told),
    }  # fmt: skip
