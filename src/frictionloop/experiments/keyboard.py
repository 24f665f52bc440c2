"""A person at the keyboard of a terminal: a guide of the stroke, and keys for answers."""

from __future__ import annotations

import sys
import time
from collections.abc import Mapping
from typing import Any, TextIO

from frictionloop.experiments.engine import Presented
from frictionloop.experiments.protocol import Protocol
from frictionloop.experiments.sequence import Trial
from frictionloop.experiments.session import Response
from frictionloop.parameters import System


class Keyboard:
    """Answers as lines: a choice, or its first letters.

    Parameters
    ----------
    protocol : Protocol
        What is asked.
    keys, shown : text stream
        Where answers come from, and where questions go.
    """

    def __init__(self, protocol: Protocol, keys: TextIO | None = None, shown: TextIO | None = None) -> None:
        self._protocol, self._keys, self._shown = protocol, keys or sys.stdin, shown or sys.stderr

    def moves(self, system: System, trial: int, interval: int) -> System:
        """Return the system as it is: the finger is the person's."""
        return system

    def respond(self, trial: Trial, presented: list[Presented]) -> Response:
        """Ask until an answer is one of the choices, or a number."""
        choices, start = self._protocol.choices, time.monotonic()
        asked = f"[{' / '.join(choices)}]" if choices else "[a number]"
        while True:
            self._say(f"trial {trial.number}: {self._protocol.question} {asked} ")
            line = self._keys.readline()
            if not line:
                raise KeyboardInterrupt("the keyboard was closed")
            rt = time.monotonic() - start
            if answer := _meant(line.strip(), choices):
                return Response(answer, rt, presented[-1].uncertainty_s)

    def before(self, trial: Trial) -> None:
        """Wait for Enter where there is a break; then say which stroke to make."""
        guide = self._protocol.timeline.stroke
        if trial.pause:
            self._say("a break; Enter goes on ")
            if not self._keys.readline():
                raise KeyboardInterrupt("the keyboard was closed")
        self._say(f"stroke {guide.length_mm:g} mm at {guide.speed_mm_s:g} mm/s, {guide.load_n:g} N\n")

    def told(self, trial: Trial, row: Mapping[str, Any]) -> None:
        """Say why a trial is repeated; else whether the answer was right, in practice and where feedback is given."""
        if row["again"]:
            self._say(f"once more ({row['reason']})\n")
        elif trial.phase == "practice" or self._protocol.timeline.feedback:
            self._say({1.0: "right\n", 0.0: "wrong\n"}.get(row["correct"], ""))

    def _say(self, text: str) -> None:
        self._shown.write(text)
        self._shown.flush()


def _meant(text: str, choices: tuple[str, ...]) -> str:
    if not choices:
        try:
            float(text)
        except ValueError:
            return ""
        return text
    found = [each for each in choices if text and each.startswith(text.lower())]
    return found[0] if len(found) == 1 else ""
