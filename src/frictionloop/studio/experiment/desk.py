"""A person on a page as who answers, and an experimenter on another who watches, pauses, notes and aborts."""

from __future__ import annotations

import queue
import time
from collections.abc import Mapping
from typing import Any

import xarray as xr

from frictionloop.experiments.protocol import Protocol
from frictionloop.experiments.respondent import Aborted, Live, Presented, Respondent, Response
from frictionloop.experiments.sequence import Trial
from frictionloop.studio.experiment.blind import live_of, told_of, trace_of
from frictionloop.studio.experiment.hearing import Hearing
from frictionloop.studio.experiment.hub import EXPERIMENTER, PARTICIPANT

GRACE_S = 1.0
"""Time after the window in which an answer that was in time may still arrive (assumed)."""
LIVE_S = 1 / 30
"""How often a page is told of a stroke that goes on (assumed)."""
WAIT_S = 0.1
"""How often a wait looks whether it was ended (assumed)."""


class Desk(Respondent):
    """The session's thread calls it as a respondent; the server's loop tells `heard`.

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
        self.heard = Hearing(protocol, self._write)
        """What the pages say."""
        self.protocol, self.hub = protocol, self.heard.hub
        self._block, self._counted, self._live_s = 1, 0, 0.0
        guide = protocol.timeline.stroke
        self.hub.tell(
            PARTICIPANT, "hello", title=protocol.title, question=protocol.question, choices=list(protocol.choices),
            guide=guide.model_dump(), intervals=protocol.intervals, masking_db=self.heard.masking_db,
        )  # fmt: skip
        rules = protocol.validity
        self.hub.tell(
            EXPERIMENTER, "hello", title=protocol.title, name=protocol.name, participant=participant, source=source,
            blind=protocol.blind, guide=guide.model_dump(), speed_mm_s=rules.speed_mm_s, load_n=rules.load_n,
            blocks=len(protocol.conditions), expected=protocol.stop.trials, masking_db=self.heard.masking_db,
        )  # fmt: skip
        self._step("ready")

    def plain(self, when: str) -> None:
        """Show that the finger is measured."""
        self._hold()
        self._step("plain", when=when)
        self._checked_sleep(self.protocol.timeline.cue_s)

    def before(self, trial: Trial) -> None:
        """Wait for the participant, the end of a pause or of a break; then show the cue."""
        self.heard.trial = trial.number
        if trial.block != self._block:
            self._block, self._counted = trial.block, 0
        if trial.pause:
            self.heard.ready.clear()
            self._step("break")
        self._hold()
        self._step("cue", trial=trial.number, phase=trial.phase)

    def cued(self, interval: int, duration_s: float) -> None:
        """Start the guide."""
        self._check()
        self._step("stroke", interval=interval, duration_s=duration_s, trial=self.heard.trial)

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
                number, answer, at_s, sd_s = self.heard.answers.get(timeout=min(left, WAIT_S))
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
        self.heard.status("over", why)

    def _write(self, event: str, **told: Any) -> None:
        self.log(event, **told)  # which the session gives only when it has opened its folder

    def _step(self, what: str, **told: Any) -> None:
        self.hub.tell(PARTICIPANT, "step", what=what, **told)
        self.hub.tell(EXPERIMENTER, "step", what=what, trial=self.heard.trial)

    def _hold(self) -> None:
        """Wait until the participant is there and ready, and nobody pauses."""
        while not (self.heard.going.is_set() and self.heard.ready.is_set() and self.hub.pages(PARTICIPANT)):
            if not self.heard.going.is_set():
                self._step("paused")
                self.heard.going.wait(WAIT_S)
            elif not self.heard.ready.is_set():
                self._step("break" if self.heard.trial > 1 else "ready")
                self.heard.ready.wait(WAIT_S)
            else:
                time.sleep(WAIT_S)
            self._check()

    def _checked_sleep(self, seconds: float) -> None:
        time.sleep(seconds)
        self._check()

    def _check(self) -> None:
        if self.heard.aborted:
            raise Aborted("aborted by the experimenter")
