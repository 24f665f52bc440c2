"""A run on a device: what it may be asked for, start, record, heartbeat, glitches, signals, stop."""

from __future__ import annotations

import contextlib
import itertools
import math
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from numbers import Integral, Real
from pathlib import Path
from types import FrameType
from typing import Any

import xarray as xr

from frictionloop.device.codec import HEADER, LAYOUTS, Message
from frictionloop.device.errors import (
    DeviceError,
    NoReply,
    Refused,
    Unplugged,
    fault_code,
    fault_error,
    fault_name,
    reading_of,
)
from frictionloop.device.link import RESETS, Link
from frictionloop.device.recording import ALL, CHANNELS, Recorder
from frictionloop.device.transport import Pipe
from frictionloop.loop.growing_file import is_taken
from frictionloop.quantities import FrictionloopError, must_be, why_unwritable
from frictionloop.quantities.protocol_schema import named, schema

ABOVE = "finite, above 0 s"


def number(name: str, value: Any, accepted: str = "a finite number") -> float:
    """Return a finite number; anything else is refused by name."""
    if not isinstance(value, Real) or not math.isfinite(value):
        raise must_be(name, value, accepted)
    return float(value)


def check_decimation(decimation: Any) -> None:
    """Refuse what is no number of ticks per sample."""
    if not (isinstance(decimation, Integral) and 1 <= int(decimation) <= 65535):
        raise must_be("decimation", decimation, "whole, 1 to 65535")


SHARE = 0.9
"""Of what a line carries for telemetry; the rest is for answers (assumed)."""


def carried(decimation: int, tick_hz: int) -> int:
    """Return the ticks per sample of a run: so many, or as many more as a line needs to carry every channel."""
    protocol, telemetry = schema()["protocol"], LAYOUTS["telemetry"]
    together = protocol["samples_a_frame"]
    frame = HEADER.size + telemetry.body.size + together * 2 * len(CHANNELS) + 5  # CRC, COBS, zero byte
    most_hz = SHARE * protocol["baud"] / 10.0 / frame * together
    return max(int(decimation), math.ceil(tick_hz / most_hz))


def rows_of(duration_s: Any, decimation: Any, tick_hz: int) -> int:
    """Return the samples of a run: its duration over theirs, rounded up."""
    check_decimation(decimation)
    if number("duration_s", duration_s, ABOVE) <= 0:
        raise must_be("duration_s", duration_s, ABOVE)
    rows = duration_s * tick_hz / decimation
    return max(math.ceil(rows * (1 - 1e-9)), 1)  # 0.3 s are 1500 ticks, whatever the last bit of 0.3 says


ENDING = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]
"""SIGHUP is not on every system."""


class Ending:
    """Signals while a run is recorded: the first raises KeyboardInterrupt, later ones wait for what is being saved."""

    def __init__(self) -> None:
        self._held = False

    def hold(self) -> None:
        """From now on no signal interrupts: the recording is being saved."""
        self._held = True

    def __call__(self, number: int, frame: FrameType | None) -> None:
        """Take a signal."""
        if self._held:
            print("saving the recording, wait", file=sys.stderr)
            return
        self._held = True
        raise KeyboardInterrupt(signal.Signals(number).name)


@contextmanager
def ending() -> Iterator[Ending]:
    """Take Ctrl-C, SIGTERM and SIGHUP alike, those that nohup or a shell had ignored not; only a main thread can."""
    taken = Ending()
    if threading.current_thread() is not threading.main_thread():
        yield taken
        return
    heeded = [number for number in ENDING if signal.getsignal(number) != signal.SIG_IGN]
    before = {number: signal.signal(number, taken) for number in heeded}
    try:
        yield taken
    finally:
        for number, handler in before.items():
            signal.signal(number, handler if handler is not None else signal.SIG_DFL)


SILENT_S = 2.0
"""A device that streams and says nothing for so long is given up (assumed)."""
REOPENED = 20
"""Attempts to open a line that went away, `PAUSE_S` apart: what an adapter takes to come back (assumed)."""
PAUSE_S = 0.1
STATES = schema()["states"]
NAMES = named("states")
NO_SESSION = schema()["refusals"]["no_session"]
KEPT_AS = "interrupted-run"
"""Stem of the file of a run that ended early and was given no path."""


class Interrupted(DeviceError):
    """A run that ended early; `run` is what was recorded, `path` its file; None without a path and a sample."""

    def __init__(
        self, why: FrictionloopError, run: xr.Dataset, path: str | os.PathLike[str] | None, samples: int
    ) -> None:
        super().__init__(f"{why}; {recorded_in(samples, path)}", why.code)
        self.run, self.path = run, path


def recorded_in(samples: int, path: str | os.PathLike[str] | None) -> str:
    """Return in words what a run that ended early leaves where."""
    return "nothing recorded" if path is None else f"{samples} samples are in {path}"


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
            raise DeviceError(f"fault {fault_name(status['fault'])}: clear() it first", fault_code(status["fault"]))
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
        longest_s = self.recorder.rows * self.recorder.decimation / self.recorder.tick_hz + SILENT_S
        while not self.recorder.is_full and self.link.pipe.clock() - self._since < longest_s:
            for message in self._messages():
                self._hear(message)
            if self.link.silent_s > SILENT_S:
                raise NoReply(f"no telemetry for {SILENT_S:g} s")
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
            raise fault_error(message["fault"], f"at tick {message['tick']}", reading_of(message))
        elif message.name == "status":
            self._check(message)
        elif message.name == "refused" and message["reason"] == NO_SESSION:
            raise DeviceError("session: ended, device began anew")

    def _check_table(self, status: Message) -> None:
        if status["commits"] != self._commits:
            raise DeviceError(f"table: changed before tick {status['tick']}, commit {status['commits']}")

    def _check(self, status: Message) -> None:
        if status["state"] == STATES["fault"]:
            raise fault_error(status["fault"], f"before tick {status['tick']}")
        if self._tick is not None and (status["tick"] - self._tick) % 2**32 >= 2**31:
            why = RESETS.get(status["reset"], "unknown")
            raise DeviceError(f"reset {why}: tick {status['tick']} after {self._tick}")
        self._tick = status["tick"]
        self._check_table(status)
        if status["state"] != self.recorder.state:
            raise DeviceError(f"state: {NAMES[status['state']]}, {NAMES[self.recorder.state]} asked")

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
    """Refuse a file that could not be written after a run, or that is there: what is recorded does not come again."""
    folder = Path.cwd() if path is None else Path(path).absolute().parent
    if why := why_unwritable(folder) if folder.is_dir() else f"no folder {folder}":
        raise FrictionloopError(f"{path or folder}: cannot be written ({why})")
    if path is not None and is_taken(Path(path)):
        raise FrictionloopError(f"{path}: exists; name a new file")


def free_path() -> Path:
    """Make and return an empty file that was not there: interrupted-run.h5, interrupted-run-2.h5 and so on."""
    for number in itertools.count(1):
        path = Path(f"{KEPT_AS}-{number}.h5" if number > 1 else f"{KEPT_AS}.h5")
        with contextlib.suppress(FileExistsError):
            path.touch(exist_ok=False)  # nobody else who looks for a name takes this one
            return path
    raise AssertionError("numbers have an end")
