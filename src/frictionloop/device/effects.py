"""Effects on a device: uploaded with a check sum, put in force at a tick, triggered from here."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from numbers import Integral
from typing import Any, NamedTuple

from frictionloop.device.link import Link
from frictionloop.device.waveform import POINTS_A_FRAME
from frictionloop.firmware.effect_tables import EffectTables, effect_tables
from frictionloop.parameters import System
from frictionloop.quantities import must_be
from frictionloop.quantities.schema import schema
from frictionloop.rendering.effect import Effect
from frictionloop.rendering.player import PLATE_MM
from frictionloop.rendering.program import MOST_TRIGGERS
from frictionloop.rendering.source import EffectSource

ALL: int = schema()["protocol"]["all_triggers"]


class Played(NamedTuple):
    """An effect for a device."""

    source: EffectSource
    tables: EffectTables

    @property
    def error_n(self) -> float:
        """Largest difference of its tables from those of the simulator, N."""
        return self.tables.error_n

    def send(self, link: Link) -> None:
        """Write the effect into the copy that waits, and put it in force: the one that plays goes on until then."""
        for _ in self.sending(link):
            pass

    def sending(self, link: Link) -> Iterator[None]:
        """As `send`, with a pause after each frame, for who has to listen to the device meanwhile."""
        words = self.tables.words
        for first in range(0, len(words), POINTS_A_FRAME):
            link.ask("waveform", first=first, values=words[first : first + POINTS_A_FRAME])
            yield
        crc = zlib.crc32(words.astype("<i2").tobytes())
        source = schema()["sources"]["effect"]
        link.ask("play", source=source, loops=0, count=len(words), step=0, start_um=0, crc=crc)


def played(effect: Any, system: System | None, most: int) -> Played | None:
    """Return an effect or an `EffectSource` for a device of so many words; None for anything else."""
    if isinstance(effect, Effect):
        effect = EffectSource(effect=effect)
    if not isinstance(effect, EffectSource):
        return None
    length_mm = system.touch.load.length_mm if system else PLATE_MM
    return Played(effect, effect_tables(effect, length_mm, most))


def trigger(link: Link, number: Any) -> None:
    """Change over a trigger of the effect that plays; None begins its waves anew."""
    if number is not None and not (isinstance(number, Integral) and 0 <= int(number) < MOST_TRIGGERS):
        raise must_be("number", number, f"0 to {MOST_TRIGGERS - 1}, or None")
    link.ask("trigger", number=ALL if number is None else int(number))
