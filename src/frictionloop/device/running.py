"""A run on a device: start, record, keep the heart beating, come back after a glitch, stop."""

from __future__ import annotations

import contextlib
import itertools
import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import xarray as xr

from frictionloop.device.codec import Message
from frictionloop.device.errors import DeviceError, NoReply, Refused, Unplugged
from frictionloop.device.fault_words import WORDS
from frictionloop.device.link import Link
from frictionloop.device.pipe import Pipe
from frictionloop.device.recorder import ALL, TICK_HZ, Recorder
from frictionloop.quantities import FrictionloopError, why_unwritable
from frictionloop.quantities.schema import named, schema

SILENT_S = 2.0
"""A device that streams and says nothing for so long is given up (assumed)."""
REOPENED = 20
"""Attempts to open a line that went away, `PAUSE_S` apart: what an adapter takes to come back (assumed)."""
PAUSE_S = 0.1
FAULTS, RESETS = named("faults"), named("resets")
STATES = schema()["states"]
NO_SESSION = schema()["refusals"]["no_session"]
READINGS = {name: (told["step"], told["unit"]) for name, told in schema()["fault_values"].items()}
"""What a fault tells of its cause: the size of a step, and the unit."""


KEPT_AS = "interrupted-run"
"""Stem of the file of a run that ended early and was given no path."""


class Interrupted(DeviceError):
    """A run that ended early; `run` is what was recorded, `path` its file; None without a path and a sample."""

    def __init__(self, why: str, run: xr.Dataset, path: str | os.PathLike[str] | None, samples: int) -> None:
        super().__init__(f"{why}; {recorded_in(samples, path)}")
        self.run, self.path = run, path


def recorded_in(samples: int, path: str | os.PathLike[str] | None) -> str:
    """Return in words what a run that ended early leaves where."""
    return "nothing was recorded" if path is None else f"{samples} samples recorded so far are in {path}"


class Running:
    """One run: `go` fills the recorder or raises what ended it."""

    def __init__(self, link: Link, reopen: Callable[[], Pipe], recorder: Recorder) -> None:
        self.link, self.reopen, self.recorder = link, reopen, recorder
        self.reconnects = 0
        self._since = link.pipe.clock()
        self._tick: int | None = None
        self._commits = 0

    def start(self) -> None:
        """Ask for telemetry, then for the state; what the device said of earlier runs does not count."""
        status = self.link.listen(self.recorder.decimation, ALL)
        if status["state"] == STATES["fault"]:
            raise DeviceError(
                f"the device has the fault {FAULTS.get(status['fault'])}: find its cause, then clear() it"
            )
        self.recorder.since = self._tick = status["tick"]
        self._commits = status["commits"]
        self.link.ask("mode", state=self.recorder.state)
        self.link.forget("status")  # what it said before
        self._since = self.link.pipe.clock()

    def go(
        self,
        keep: Callable[[], None],
        progress: Callable[[int], Any] | None = None,
        live: Callable[[dict[str, float]], Any] | None = None,
    ) -> None:
        """Record until the last row, and have rows kept; raises DeviceError when the device leaves the state."""
        longest_s = self.recorder.rows * self.recorder.decimation / TICK_HZ + SILENT_S
        while not self.recorder.is_full and self.link.pipe.clock() - self._since < longest_s:
            for message in self._messages():
                self._hear(message)
            if self.link.silent_s > SILENT_S:
                raise NoReply(f"the device has said nothing for {SILENT_S:g} s")
            keep()
            if progress:
                progress(self.recorder.reached)
            if live and self.recorder.newest:
                live(self.recorder.newest)
        self._check_table(self.link.ask("heartbeat"))  # also of the last samples

    def stop(self) -> None:
        """Ask the device to be idle and quiet, if it is there."""
        with contextlib.suppress(DeviceError):
            with contextlib.suppress(Refused):  # at fault it is off
                if not self.link.is_others:
                    self.link.ask("mode", state=STATES["idle"])
            self.link.ask("stream", decimation=0, mask=0)

    def _hear(self, message: Message) -> None:
        if message.name == "telemetry":
            self.recorder.take(message)
        elif message.name == "fault" and self.recorder.is_new(message["tick"]):
            raise DeviceError(_fault(message["fault"], f"at tick {message['tick']}{reading_told(message)}"))
        elif message.name == "status":
            self._check(message)
        elif message.name == "refused" and message["reason"] == NO_SESSION:
            raise DeviceError("the device knows this session no more: it began anew")

    def _check_table(self, status: Message) -> None:
        if status["commits"] != self._commits:
            raise DeviceError(
                f"the parameter table was changed during the run, before tick {status['tick']} (commit "
                f"{status['commits']}, at its start {self._commits})"
            )

    def _check(self, status: Message) -> None:
        if status["state"] == STATES["fault"]:
            raise DeviceError(_fault(status["fault"], f"before tick {status['tick']}"))
        if self._tick is not None and (status["tick"] - self._tick) % 2**32 >= 2**31:
            why = RESETS.get(status["reset"], "unknown")
            raise DeviceError(f"the device began anew (tick {status['tick']} after {self._tick}, reset: {why})")
        self._tick = status["tick"]
        self._check_table(status)
        if status["state"] == STATES["idle"]:
            raise DeviceError("the device is idle: another host stopped it, or it began anew")
        if status["state"] != self.recorder.state:
            raise DeviceError("the device is no longer in the state asked for: somebody else uses it, or it began anew")

    def _messages(self) -> list[Message]:
        try:
            return self.link.poll(SILENT_S)
        except Unplugged as gone:
            self.link.pipe.close()
            self.link.reopened(self._opened(gone))
            self.reconnects += 1
            return []

    def _opened(self, gone: Unplugged) -> Pipe:
        """Return the line opened again; the device has gone on meanwhile, or has ramped down."""
        for _ in range(REOPENED):
            try:
                return self.reopen()
            except DeviceError:
                time.sleep(PAUSE_S)
        raise gone


def check_folder(path: str | os.PathLike[str] | None) -> None:
    """Refuse a file that could not be written after a run, before it."""
    folder = Path.cwd() if path is None else Path(path).absolute().parent
    if why := why_unwritable(folder) if folder.is_dir() else f"no folder {folder}":
        raise FrictionloopError(f"{path or folder}: cannot be written ({why})")


def free_path() -> Path:
    """Make and return an empty file that was not there: interrupted-run.h5, interrupted-run-2.h5 and so on."""
    for number in itertools.count(1):
        path = Path(f"{KEPT_AS}-{number}.h5" if number > 1 else f"{KEPT_AS}.h5")
        with contextlib.suppress(FileExistsError):
            path.touch(exist_ok=False)  # nobody else who looks for a name takes this one
            return path
    raise AssertionError("numbers have an end")


def _fault(number: int, where: str) -> str:
    name = str(FAULTS.get(number, number))
    return f"fault {name} {where}" + (f": {WORDS[name]}" if name in WORDS else "")


def reading_told(fault: Message) -> str:
    """Return what a message `fault` tells of its cause, in brackets; an empty text where it tells none."""
    name = FAULTS.get(fault["fault"])
    if name not in READINGS:
        return ""
    step, unit = READINGS[name]
    value = step * fault["value"]
    return f" ({value:.0f} {unit})" if abs(value) >= 1000.0 else f" ({value:.3g} {unit})"
