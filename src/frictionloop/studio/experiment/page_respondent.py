"""A person on a page as who answers, and an experimenter who watches, pauses, notes, aborts, and hears no secret."""

from __future__ import annotations

import math
import queue
import re
import time
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.experiments.protocol import Protocol
from frictionloop.experiments.respondent import Aborted, Live, Presented, Respondent, Response
from frictionloop.experiments.trial_records import force_of
from frictionloop.experiments.trial_sequence import Trial
from frictionloop.studio.experiment.page_messages import EXPERIMENTER, PARTICIPANT, Hearing

OPEN = ("trial", "block", "phase", "valid", "counted", "again", "repeat_of")
"""Columns that everybody may see."""
SECRET = ("condition", "requested", "delivered", "comparison", "correct", "response", "method_state")
"""Columns that are shown without blinding alone."""
POINTS = 150
"""Points of a trace on the page (assumed)."""
MOST_MN = 100.0
"""Largest error that is told blind: before the finger slides the error is the set-point itself (assumed)."""


def told_of(row: Mapping[str, Any], protocol: Protocol) -> dict[str, Any]:
    """Return of a row what the page may show; blind, the reason is without its number and interval."""
    found = {name: row[name] for name in OPEN}
    found["rt_s"] = finite(row["rt_s"])
    found["reason"] = row["reason"] if not protocol.blind else reason(row["reason"])
    if not protocol.blind:
        found |= {name: finite(row[name]) for name in SECRET}
    return found


def reason(text: str) -> str:
    """Return a reason without numbers and intervals, each part once."""
    plain = re.sub(r"=[^ ;]*| in \d", "", text)
    return "; ".join(dict.fromkeys(plain.split("; "))).replace("_", " ")


def live_of(sample: Live, blind: bool) -> dict[str, Any]:
    """Return a sample for the page; blind, the force is told beside its set-point alone."""
    error_mn = 1e3 * (sample.force_n - sample.setpoint_n)
    found = {
        "interval": sample.interval,
        "at_s": round(sample.elapsed_s, 3),
        "error_mn": finite(round(float(np.clip(error_mn, -MOST_MN, MOST_MN)), 2)),
        "speed_mm_s": finite(round(sample.speed_mm_s, 2)),
        "load_n": finite(round(sample.load_n, 3)),
    }
    return found if blind else found | {"force_n": finite(sample.force_n), "setpoint_n": finite(sample.setpoint_n)}


def trace_of(run: xr.Dataset, interval: int, duration_s: float, blind: bool) -> dict[str, Any]:
    """Return a stroke that is over as a trace for the page; blind, the error where it is scored, within limits."""
    every = max(run.sizes["time"] // POINTS, 1)
    part = run.isel(time=slice(None, None, every))
    force, setpoint = part[force_of(part)].values, part["f_r"].values
    error = np.where(part["scored"].values, np.clip(1e3 * (force - setpoint), -MOST_MN, MOST_MN), np.nan)
    lines = {"error_mn": error} if blind else {"force_n": force, "setpoint_n": setpoint}
    found = {name: [finite(round(float(each), 4)) for each in values] for name, values in lines.items()}
    return {"interval": interval, "duration_s": duration_s, **found}


def finite(value: Any) -> Any:
    """Return a value, None in place of what is no number: JSON has no NaN."""
    return None if isinstance(value, float) and not math.isfinite(value) else value


GRACE_S = 1.0
"""Time after the window in which an answer that was in time may still arrive (assumed)."""
LIVE_S = 1 / 30
"""How often a page is told of a stroke that goes on (assumed)."""
WAIT_S = 0.1
"""How often a wait looks whether it was ended (assumed)."""


class Desk(Respondent):
    """The session's thread calls it as a respondent; the server's loop tells `heard`."""

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
        time.sleep(self.protocol.timeline.cue_s)
        self._check()

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

    def give_feedback(self, trial: Trial, row: Mapping[str, Any]) -> None:
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

    def _check(self) -> None:
        if self.heard.aborted:
            raise Aborted("aborted by the experimenter")
