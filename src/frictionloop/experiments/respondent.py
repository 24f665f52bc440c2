"""Who answers, and what they are shown of a trial on its way; a person at the keyboard."""

from __future__ import annotations

import select
import sys
import time
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, TextIO

import xarray as xr

from frictionloop.experiments.protocol import Protocol
from frictionloop.experiments.session_folder import now
from frictionloop.experiments.trial_records import number_of
from frictionloop.experiments.trial_sequence import Trial
from frictionloop.parameters import System
from frictionloop.quantities import FrictionloopError


class Aborted(FrictionloopError):
    """A session that somebody ended; the running trial is lost."""


class Response(NamedTuple):
    """An answer, and when it was given."""

    response: str
    """One of the task's choices, or a number; empty if none came."""
    rt_s: float
    """From the end of the last stroke, on the device clock."""
    uncertainty_s: float = 0.0
    """Standard deviation of that by the mapping of clocks."""
    at_s: float | None = None
    """Host's time of the answer, which a device's engine maps to its clock; None where nobody took it."""


class Presented(NamedTuple):
    """One stroke that was presented."""

    run: xr.Dataset
    """As of `simulate`."""
    onset_s: float
    """Its start on the device clock."""
    offset_s: float
    """Its end on the device clock."""
    jump_s: float = 0.0
    """By how much clocks have jumped against each other meanwhile; such a trial does not count."""


class Live(NamedTuple):
    """The newest sample of a stroke that goes on."""

    interval: int
    """Counted from 1."""
    elapsed_s: float
    """Since the stroke's start."""
    force_n: float
    setpoint_n: float
    speed_mm_s: float
    load_n: float


class Respondent:
    """Who answers: a person at a keyboard or on a page, or a simulated participant. This one is shown nothing."""

    paced = False
    """Whether a simulated bench takes as long as a real one."""
    log: Callable[..., Any] = staticmethod(lambda event, **told: None)
    """Keeps what happens in the session's log."""

    def moves(self, system: System, trial: int, interval: int) -> System:
        """Return the system as its finger moves; a person's is as it is."""
        return system

    def finger(self, system: System, trial: int) -> System:
        """Return the system with the finger as it is before a trial; a person's is as it is."""
        return system

    def before(self, trial: Trial) -> None:
        """Show the cue, and a break if there is one before this trial."""

    def cued(self, interval: int, duration_s: float) -> None:
        """Show that a stroke begins."""

    def live(self, sample: Live) -> None:
        """Show a stroke that goes on."""

    def stroked(self, interval: int, run: xr.Dataset) -> None:
        """Show a stroke that is over."""

    def respond(self, trial: Trial, presented: list[Presented]) -> Response:
        """Return the answer to a trial."""
        raise NotImplementedError

    def give_feedback(self, trial: Trial, row: Mapping[str, Any]) -> None:
        """Give feedback, as far as the protocol has any."""

    def plain(self, when: str) -> None:
        """Show that two plain strokes come, ``before`` or ``after`` the session, by which the finger is measured."""

    def fitted(self, factor: float) -> None:
        """Show that levels were drawn together by a factor, since the finger cannot be given them all."""

    def ended(self, why: str) -> None:
        """Show that the session is over, and why if it ended early."""


BAR = 40
"""Characters of the guide."""
WORDS = "note TEXT keeps a note, pause waits for Enter, abort ends the session"


class Keyboard(Respondent):
    """Answers as lines: a choice, or its first letters. ``note TEXT``, ``pause`` and ``abort`` are for who watches.

    Parameters
    ----------
    protocol : Protocol
        What is asked.
    keys, shown : text stream
        Where answers come from, and where questions go. On a terminal the bench takes its time, and the guide moves.
    """

    def __init__(self, protocol: Protocol, keys: TextIO | None = None, shown: TextIO | None = None) -> None:
        self._protocol, self._keys, self._shown = protocol, keys or sys.stdin, shown or sys.stderr
        self.paced = self._shown.isatty()
        self._told = False

    def respond(self, trial: Trial, presented: list[Presented]) -> Response:
        """Ask until an answer is one of the choices, or a number."""
        choices = self._protocol.choices
        self._empty(trial)
        start = time.monotonic()
        asked = f"[{' / '.join(choices)}]" if choices else "[a number]"
        while True:
            self._say(f"trial {trial.number}: {self._protocol.question} {asked} ")
            line = self._line()
            at = time.monotonic()
            if answer := self._meant(line):
                return Response(answer, at - start, at_s=at)
            self._obey(line, trial)

    def before(self, trial: Trial) -> None:
        """Wait for Enter where there is a break; then say which stroke to make."""
        guide = self._protocol.timeline.stroke
        if not self._told:
            self._say(f"{WORDS}\n")
            self._told = True
        if trial.pause:
            self._wait("a break", trial)
        self._say(f"stroke {guide.length_mm:g} mm at {guide.speed_mm_s:g} mm/s, {guide.load_n:g} N\n")

    def live(self, sample: Live) -> None:
        """Move the guide: where the finger ought to be, and how fast it is."""
        guide = self._protocol.timeline.stroke
        if not self.paced:
            return
        done = min(sample.elapsed_s / guide.duration_s, 1.0)
        self._say(f"\r{sample.interval} {bar(done, guide.direction)} {_pace(sample.speed_mm_s, guide.speed_mm_s)}")

    def stroked(self, interval: int, run: xr.Dataset) -> None:
        """Take the guide away."""
        if self.paced:
            self._say("\r\033[K")

    def give_feedback(self, trial: Trial, row: Mapping[str, Any]) -> None:
        """Say why a trial is repeated; else whether the answer was right, in practice and where feedback is given."""
        if row["again"]:
            self._say(f"once more ({row['reason']})\n")
        elif trial.phase == "practice" or self._protocol.timeline.feedback:
            self._say({1.0: "right\n", 0.0: "wrong\n"}.get(row["correct"], ""))

    def plain(self, when: str) -> None:
        """Say that the finger is measured."""
        self._say(f"two plain strokes {when} the session measure this finger's friction\n")

    def fitted(self, factor: float) -> None:
        """Say that levels were drawn together."""
        self._say(f"levels drawn together to {100 * factor:.0f} %\n")

    def _meant(self, text: str) -> str:
        """Return the answer that a line means, empty if none; of a number that the task does not have it says why."""
        choices = self._protocol.choices
        if choices:
            found = [each for each in choices if text and each.startswith(text.lower())]
            return found[0] if len(found) == 1 else ""
        try:
            number_of(self._protocol.task, text)
        except FrictionloopError as error:
            if text and text[0] in "+-.0123456789":
                self._say(f"{error}\n")
            return ""
        return text

    def _obey(self, line: str, trial: Trial) -> None:
        """Do what a line that is no answer says."""
        word, _, rest = line.partition(" ")
        if word == "note" and rest:
            self.log("note", time=now(), trial=trial.number, text=rest)
        elif word == "pause":
            self.log("pause", time=now(), trial=trial.number)
            self._wait("paused", trial)
            self.log("go on", time=now(), trial=trial.number)
        elif word == "abort":
            self.log("abort", time=now(), trial=trial.number)
            raise Aborted("aborted at the keyboard")

    def _wait(self, why: str, trial: Trial) -> None:
        self._empty(trial)
        self._say(f"{why}; Enter goes on ")
        while line := self._line():
            self._obey(line, trial)

    def _empty(self, trial: Trial) -> None:
        """Drop what was typed on a terminal before it was asked for, but do what the words of who watches say."""
        if not self._keys.isatty():
            return
        if sys.platform == "win32":
            import msvcrt

            while msvcrt.kbhit():
                msvcrt.getwch()
            return
        import termios

        while select.select([self._keys], [], [], 0.0)[0]:
            self._obey(self._line(), trial)
        termios.tcflush(self._keys, termios.TCIFLUSH)  # a line without its end

    def _line(self) -> str:
        line = self._keys.readline()
        if not line:
            raise KeyboardInterrupt("the keyboard was closed")
        return line.strip()

    def _say(self, text: str) -> None:
        self._shown.write(text)
        self._shown.flush()


def bar(done: float, direction: str = "forth", width: int = BAR) -> str:
    """Return a line on which a finger is where it ought to be after a share of its stroke.

    >>> bar(0.5, width=9)
    '|    o    |'
    """
    way = {"forth": done, "back": 1.0 - done, "both": 1.0 - abs(2.0 * done - 1.0)}[direction]
    place = round(way * (width - 1))
    return f"|{' ' * place}o{' ' * (width - 1 - place)}|"


def _pace(speed_mm_s: float, wanted_mm_s: float) -> str:
    """Return how a speed compares; within a fifth it is as asked."""
    ratio = speed_mm_s / wanted_mm_s
    said = "slower" if ratio > 1.2 else "faster" if ratio < 0.8 else "good"
    return f"{speed_mm_s:4.0f} mm/s {said:6}"
