"""A person on a page as who answers, and an experimenter on another who watches, pauses, notes and aborts."""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Mapping
from typing import Any

import xarray as xr

from frictionloop.experiments.folder import now
from frictionloop.experiments.protocol import Protocol
from frictionloop.experiments.respondent import Aborted, Live, Presented, Respondent, Response
from frictionloop.experiments.sequence import Trial
from frictionloop.experiments.table import number_of
from frictionloop.quantities import FrictionloopError
from frictionloop.studio.experiment.blind import live_of, told_of, trace_of
from frictionloop.studio.experiment.hub import EXPERIMENTER, PARTICIPANT, Hub

GRACE_S = 1.0
"""Time after the window in which an answer that was in time may still arrive (assumed)."""
LIVE_S = 1 / 30
"""How often a page is told of a stroke that goes on (assumed)."""
LONGEST_NOTE = 500
"""Characters of a note (assumed)."""
WAIT_S = 0.1
"""How often a wait looks whether it was ended (assumed)."""


class Desk(Respondent):
    """The session's thread calls it as a respondent; the server's loop calls `hear`.

    Parameters
    ----------
    protocol : Protocol
        What is asked.
    participant : str
        Code.
    source : str
        What the forces are of.
    """

    paced = True

    def __init__(self, protocol: Protocol, participant: str, source: str) -> None:
        self.protocol, self.hub = protocol, Hub()
        self._answers: queue.Queue[tuple[int, str, float, float]] = queue.Queue()
        self._ready, self._going = threading.Event(), threading.Event()
        self._going.set()
        self._aborted, self._trial, self._block, self._counted = False, 0, 1, 0
        self._live_s = 0.0
        guide = protocol.timeline.stroke
        self._masking_db = protocol.masking_db
        self.hub.tell(
            PARTICIPANT, "hello", title=protocol.title, question=protocol.question, choices=list(protocol.choices),
            guide=guide.model_dump(), intervals=protocol.intervals, masking_db=self._masking_db,
        )  # fmt: skip
        rules = protocol.validity
        self.hub.tell(
            EXPERIMENTER, "hello", title=protocol.title, name=protocol.name, participant=participant, source=source,
            blind=protocol.blind, guide=guide.model_dump(), speed_mm_s=rules.speed_mm_s, load_n=rules.load_n,
            blocks=len(protocol.conditions), expected=protocol.stop.trials, masking_db=self._masking_db,
        )  # fmt: skip
        self._step("ready")

    # What the session calls.

    def plain(self, when: str) -> None:
        """Show that the finger is measured."""
        self._hold()
        self._step("plain", when=when)
        self._checked_sleep(self.protocol.timeline.cue_s)

    def before(self, trial: Trial) -> None:
        """Wait for the participant, the end of a pause or of a break; then show the cue."""
        self._trial = trial.number
        if trial.block != self._block:
            self._block, self._counted = trial.block, 0
        if trial.pause:
            self._ready.clear()
            self._step("break")
        self._hold()
        self._step("cue", trial=trial.number, phase=trial.phase)

    def cued(self, interval: int, duration_s: float) -> None:
        """Start the guide."""
        self._check()
        self._step("stroke", interval=interval, duration_s=duration_s, trial=self._trial)

    def live(self, sample: Live) -> None:
        """Pass a sample on to the experimenter."""
        self._check()
        if abs(sample.elapsed_s - self._live_s) >= LIVE_S:
            self._live_s = sample.elapsed_s
            self.hub.pass_on(EXPERIMENTER, "live", **live_of(sample, self.protocol.blind))

    def stroked(self, interval: int, run: xr.Dataset) -> None:
        """Show the experimenter the whole stroke."""
        duration_s = self.protocol.timeline.stroke.duration_s
        self.hub.tell(EXPERIMENTER, "trace", **trace_of(run, interval, duration_s, self.protocol.blind))
        self._step("between")

    def respond(self, trial: Trial, presented: list[Presented]) -> Response:
        """Ask, and return the first answer to this trial, empty when the window has closed."""
        start, window_s = time.monotonic(), self.protocol.timeline.response_s
        self._step("answer", trial=trial.number)
        while (left := start + window_s + GRACE_S - time.monotonic()) > 0:
            self._check()
            try:
                number, answer, at_s, sd_s = self._answers.get(timeout=min(left, WAIT_S))
            except queue.Empty:
                continue
            if number == trial.number:
                return Response(answer, at_s - start, sd_s, at_s)
        return Response("", window_s)

    def told(self, trial: Trial, row: Mapping[str, Any]) -> None:
        """Give the participant feedback where there is any, and tell the experimenter what became of the trial."""
        self._counted += row["counted"]
        self.hub.tell(EXPERIMENTER, "progress", block=trial.block, counted=self._counted)
        self.hub.tell(EXPERIMENTER, "row", **told_of(row, self.protocol))
        if row["again"]:
            self._step("feedback", said="Once more, please.")
        elif (trial.phase == "practice" or self.protocol.timeline.feedback) and row["correct"] in (0.0, 1.0):
            self._step("feedback", said="Right." if row["correct"] else "Wrong.")
        else:
            self._step("between")

    def ended(self, why: str) -> None:
        """Show both that the session is over."""
        self._step("end")
        self._status("over", why)

    # What the server calls.

    def hear(self, role: str, message: Mapping[str, Any]) -> None:
        """Take what a page says.

        Raises
        ------
        FrictionloopError
            For what a page may not say, or what makes no sense.
        """
        what = message.get("do")
        if what == "ready":
            self._ready.set()
        elif what == "answer":
            self._take(message)
        elif role != EXPERIMENTER:
            raise FrictionloopError(f"do = {what!r}: must be ready, answer or clock on this page")
        elif what == "pause":
            self._going.clear()
            self._status("paused")
            self.log("pause", time=now(), trial=self._trial)
        elif what == "go":
            self._going.set()
            self._status("running")
            self.log("go on", time=now(), trial=self._trial)
        elif what == "note":
            text = str(message.get("text", "")).strip()
            if not 0 < len(text) <= LONGEST_NOTE:
                raise FrictionloopError(f"note: {len(text)} characters; must be 1 to {LONGEST_NOTE}")
            self.log("note", time=now(), trial=self._trial, text=text)
            self.hub.pass_on(EXPERIMENTER, "noted", text=text, trial=self._trial)
        elif what == "abort":
            self._aborted = True
            self.log("abort", time=now(), trial=self._trial)
            self._status("aborting")
        elif what == "masking":
            self._mask(message.get("db"))
        else:
            raise FrictionloopError(f"do = {what!r}: must be pause, go, note, abort or masking")

    def connected(self) -> None:
        """Tell the experimenter whether the participant's page is there."""
        self.hub.tell(EXPERIMENTER, "pages", participant=self.hub.pages(PARTICIPANT))

    def _take(self, message: Mapping[str, Any]) -> None:
        answer, heard = str(message.get("answer", "")), time.monotonic()
        choices = self.protocol.choices
        try:
            trial, at_s, sd_s = int(message["trial"]), float(message["at_s"]), float(message["sd_s"])
        except (KeyError, TypeError, ValueError):
            raise FrictionloopError("answer: needs trial, at_s, sd_s and a choice or a number") from None
        if not choices:
            number_of(self.protocol.task, answer)
        elif answer not in choices:
            raise FrictionloopError(f"answer = {answer!r}: accepted: {', '.join(choices)}")
        # A page whose clock is not known, or that says it answered later than it was heard, counts as heard.
        if not (0.0 <= sd_s < 1.0 and heard - 10.0 < at_s <= heard):
            at_s, sd_s = heard, max(sd_s, 0.0) if 0.0 <= sd_s < 1.0 else 0.1
        self._answers.put((trial, answer, at_s, sd_s))

    def _mask(self, level: Any) -> None:
        if level is not None and not (isinstance(level, (int, float)) and -60.0 <= level <= 0.0):
            raise FrictionloopError(f"masking: db = {level!r}: must be -60 to 0, or none")
        self.log("adjusted", time=now(), what="masking_db", value=level, before=self._masking_db, why="experimenter")
        self._masking_db = level
        for role in (PARTICIPANT, EXPERIMENTER):
            self.hub.tell(role, "masking", db=level)

    def _step(self, what: str, **told: Any) -> None:
        self.hub.tell(PARTICIPANT, "step", what=what, **told)
        self.hub.tell(EXPERIMENTER, "step", what=what, trial=self._trial)

    def _status(self, state: str, why: str = "") -> None:
        self.hub.tell(EXPERIMENTER, "status", state=state, why=why)

    def _hold(self) -> None:
        """Wait until the participant is there and ready, and nobody pauses."""
        while not (self._going.is_set() and self._ready.is_set() and self.hub.pages(PARTICIPANT)):
            if not self._going.is_set():
                self._step("paused")
                self._going.wait(WAIT_S)
            elif not self._ready.is_set():
                self._step("break" if self._trial > 1 else "ready")
                self._ready.wait(WAIT_S)
            else:
                time.sleep(WAIT_S)
            self._check()

    def _checked_sleep(self, seconds: float) -> None:
        time.sleep(seconds)
        self._check()

    def _check(self) -> None:
        if self._aborted:
            raise Aborted("aborted by the experimenter")
