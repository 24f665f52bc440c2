"""A device behind a live page: set up beside its telemetry, opened again where its line went away."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable, Iterator

import numpy as np

from frictionloop.device.codec import Message
from frictionloop.device.device import Device
from frictionloop.device.errors import DeviceError, Refused, Unplugged
from frictionloop.device.simulated_boards import ENDS, BenchPipe
from frictionloop.device.waveform import EffectUpload, upload_of
from frictionloop.live.telemetry_channels import News
from frictionloop.loop.stepper import Movement
from frictionloop.parameters import System
from frictionloop.quantities import FrictionloopError, must_be

RETRY_S = 1.0
"""How often a line that went away is tried again (assumed)."""
LONGEST_TRY_S = 5.0
"""How long the end waits for a try that is under way: longer than a device may take to answer."""


class LineAgain:
    """Tries to open a line again, on a thread of its own, until it is there; while it is `away` nobody else uses it."""

    def __init__(self, reconnect: Callable[[], None]) -> None:
        self._reconnect, self._thread = reconnect, threading.Thread()
        self._began_s, self._opened = -RETRY_S, False
        self.away = False
        """Whether the line is not there: who finds that it went says so, and a try that succeeds says otherwise."""

    def try_on(self) -> None:
        """Begin a try where the line is away, unless one is under way or began less than `RETRY_S` ago."""
        if not self.away or self._thread.is_alive() or time.monotonic() - self._began_s < RETRY_S:
            return
        self._began_s = time.monotonic()
        self._thread = threading.Thread(target=self._try, daemon=True)
        self._thread.start()

    def opened(self) -> bool:
        """Return, once, that a try has succeeded."""
        was, self._opened = self._opened, False
        return was

    def end(self) -> None:
        """Wait for a try that is under way."""
        if self._thread.is_alive():
            self._thread.join(LONGEST_TRY_S)

    def _try(self) -> None:
        try:
            self._reconnect()
        except DeviceError:  # silent still, or gone again: the next try is due in a second
            return
        self._opened, self.away = True, False


CHANGEABLE = "controller", "setpoint"
"""Blocks of a System that a page may change on a device: all else is the bench that stands there."""
KEPT_EFFECTS = 32
"""Effects whose tables are kept: more than the library has."""


class SetUp:
    """What a device is set up from, and what of it has still to be written."""

    def __init__(self, device: Device, system: System) -> None:
        self._device = device
        self._steps: Iterator[None] = iter(())
        self.wanted = self._in_force = system
        """What was asked for last."""
        self.ceiling_um = 0.0
        """Largest amplitude that the board allows."""
        self._plays: np.ndarray | None = None
        self._played: dict[object, EffectUpload] = {}
        self.again()
        for _ in self._steps:
            pass

    def again(self) -> None:
        """Write everything anew, to a device that may have forgotten it."""
        self._plays = None
        self.begin(self.wanted)

    def begin(self, system: System) -> None:
        """Let a System be written from now on, in place of what is on its way."""
        for name in type(system).model_fields:
            if name not in CHANGEABLE and getattr(system, name) != getattr(self._in_force, name):
                raise FrictionloopError(f"{name}: fixed; accepted: {', '.join(CHANGEABLE)}")
        self.prepare(system)
        self._steps, self.wanted = self._writing(system, self._played[_effect_of(system)]), system

    def ready(self, system: System) -> bool:
        """Tell whether the tables of a System's effect are made: `begin` then takes no time."""
        return _effect_of(system) in self._played

    def prepare(self, system: System) -> None:
        """Make the tables of a System's effect, which takes a second for a rough one; may run in another thread."""
        if self.ready(system):
            return
        played = upload_of(system.setpoint, system, self._device.info.waveform, self._device.info.tick_hz)
        if played is None:
            raise must_be("setpoint.kind", system.setpoint.kind, "effect")
        kept = dict(list(self._played.items())[1 - KEPT_EFFECTS :])
        self._played = kept | {_effect_of(system): played}

    def go_on(self) -> None:
        """Send one more frame of what has still to be written."""
        try:
            next(self._steps, None)
        except Unplugged:
            raise
        except FrictionloopError:
            self._steps, self.wanted = iter(()), self._in_force
            raise

    def _writing(self, system: System, played: EffectUpload) -> Iterator[None]:
        device = self._device
        yield from device.uploading(system)
        words = played.tables.words
        if self._plays is None or not np.array_equal(words, self._plays):
            self._plays = None
            yield from played.sending(device._link)
            self._plays = words
        self.ceiling_um = float(device.parameters["drive.ceiling_um"])
        self._in_force = system


def _effect_of(system: System) -> object:
    """Return what decides on the tables of an effect."""
    return system.setpoint, system.touch.load.length_mm


class DeviceEngine:
    """A device as what stands behind a session.

    The board is set up from the System, plays its effect, and is idle until it is armed. Behind a simulated or emulated
    board the bench is simulated too: the finger of the page moves on it, and the force on the finger is known.
    """

    def __init__(self, device: Device, system: System) -> None:
        self._device, self._link = device, device._link
        self._bench = device._link.pipe if isinstance(device._link.pipe, BenchPipe) else None
        self._moves: deque[Movement] = deque()
        if self._bench is not None:
            self._bench.moves = self._moves
        self.source = self._link.pipe.source
        self.trouble = ""
        """What is wrong with the line, empty while nothing is."""
        self._gone = ""
        self.armed = "idle"
        """The state that was asked for: idle, open or closed."""
        self.refused: list[str] = []
        """What the device has refused of a change, in words; emptied by who tells it."""
        self._again = LineAgain(self._anew)
        self._set_up = SetUp(device, system)
        self.ready, self.prepare = self._set_up.ready, self._set_up.prepare
        self._news = News(self._link, device.info.tick_hz)

    @property
    def system(self) -> System:
        """What the device is set up from, or is being set up from: a change is written beside the telemetry."""
        return self._set_up.wanted

    @property
    def rate_hz(self) -> float:
        """Ticks per second."""
        return float(self._device.info.tick_hz)

    @property
    def is_paced(self) -> bool:
        """Whether its time passes only while it is asked to advance, as behind a simulated board."""
        return self._bench is not None

    @property
    def reach_mm(self) -> float:
        """How far from the middle the position sensor of the bench reads, mm."""
        return 1e3 * ENDS[1] * self.system.board.position_m_per_count

    def advance(self, path: np.ndarray) -> np.ndarray:
        """Go on by the path, or to now where a device has its own time, and return the `CHANNELS` that came in.

        Samples that were lost are NaN; how many come is the device's affair.
        """
        self._again.try_on()
        if not self._again.away:
            if self._again.opened():
                self.trouble = f"{self._gone}; back, plate off"
            try:
                for message in self._heard(path):
                    if why := self._news.take(message):
                        self._began_anew(why)
                if self._news.fault:
                    self.armed = "idle"
            except Unplugged as gone:
                self._gone, self.armed = str(gone), "idle"
                self.trouble = f"{gone}; trying again"
                self._again.away = True
        return self._news.rows.taken(self._link.pipe)

    def change(self, system: System) -> bool:
        """Begin to put another controller or effect in force, frame by frame; return whether the law goes on."""
        went_on = system.controller.kind == self.system.controller.kind
        self._set_up.begin(system)
        return went_on

    def arm(self, state: str) -> None:
        """Let the loop run: ``"open"`` or ``"closed"``."""
        if state not in ("open", "closed"):
            raise must_be("state", state, "open or closed")
        self._refuse_while_away()
        self._device.mode(state)
        self.armed, self.trouble = state, ""

    def disarm(self) -> None:
        """Ask for the plate at rest, which the board brings it to within 0.1 s."""
        self.armed = "idle"
        if self._again.away:  # without its host the board switches off by itself
            return
        try:
            self._device.mode("idle")
        except Refused:  # at fault the plate is at rest
            return
        except DeviceError as error:
            self.trouble = f"{error}; off by itself after 0.2 s"

    def clear(self) -> None:
        """Clear a fault; refused while its cause lasts."""
        self._refuse_while_away()
        self._device.clear()
        self._news.fault = ""

    def device_status(self) -> dict[str, object]:
        """Return what pages are told of the device."""
        info = self._device.info
        return {
            "name": {"host": "firmware on this computer"}.get(info.board, info.board),
            "address": self._device.address,
            "revision": info.revision,
            "armed": self.armed,
            "state": self.state,
            "fault": self._news.fault,
            "trouble": self.trouble,
            "lost": self._news.rows.lost,
            "ceiling_um": self._set_up.ceiling_um,
            "has_finger": self.is_paced,
            "reach_mm": self.reach_mm,
        }

    @property
    def state(self) -> str:
        """State of the board as its last sample tells it."""
        return self._news.state

    def close(self) -> None:
        """Switch the plate off and let go of the line."""
        self._again.end()
        self._device.close()

    def _refuse_while_away(self) -> None:
        if self._again.away:
            raise FrictionloopError(self.trouble, "DEVICE-LOST")

    def _heard(self, path: np.ndarray) -> list[Message]:
        if self._bench is None:
            self._write_on()
            return self._link.poll(0.0)
        self._moves.extend(Movement(*row) for row in path.tolist())
        until, messages = self._bench.clock() + (len(self._moves) - 0.5) / self.rate_hz, []
        while (left := until - self._bench.clock()) > 0:
            messages += self._link.poll(left)
            self._write_on()
        return messages

    def _write_on(self) -> None:
        """Write one more frame of what the device is set up from."""
        try:
            self._set_up.go_on()
        except Unplugged:
            raise
        except FrictionloopError as refused:
            self.refused.append(str(refused))

    def _began_anew(self, why: str) -> None:
        """Set up a device that has forgotten what it was set up from, and whom it tells of its samples."""
        self.armed, self.trouble = "idle", f"began anew: {why}"
        self._link.resume()
        self._set_up.again()
        self._news.listen()

    def _anew(self) -> None:
        """Open the line again and set the device up; the board has switched its plate off meanwhile."""
        self._device.reconnect()
        self._set_up.again()
        self._news.listen()
