"""Telemetry as the channels of a live session, tick by tick, and what a device says of itself."""

from __future__ import annotations

import numpy as np

from frictionloop.device.codec import Message
from frictionloop.device.device_run import NAMES, NO_SESSION, STATES, carried
from frictionloop.device.errors import fault_line, reading_of
from frictionloop.device.link import RESETS, Link
from frictionloop.device.recording import ALL, SCALES, state_of
from frictionloop.device.recording import CHANNELS as TOLD
from frictionloop.device.transport import Pipe
from frictionloop.live.live_engines import CHANNELS

LONGEST_GAP_S = 2.0
"""What may be missing in one piece (a device is given up after it); a longer way is another beginning."""
_AT = {name: row for row, name in enumerate(CHANNELS)}
_FROM = {name: row for row, name in enumerate(TOLD)}


class Rows:
    """Samples of every tick as they come in; where a line carries one in `every`, it stands for the ticks up to it."""

    def __init__(self, tick: int, tick_hz: int) -> None:
        self.every, self._longest_gap = carried(1, tick_hz), round(LONGEST_GAP_S * tick_hz)
        self.next_tick, self.lost, self.state = (tick + 1) % 2**32, 0, 0
        self._first = self.next_tick
        self._waiting: list[np.ndarray] = []

    def began_anew(self, tick: int) -> bool:
        """Tell whether a tick of the device is far from those that came, and go on from there if so."""
        ahead = (tick - self.next_tick + 2**31) % 2**32 - 2**31
        if abs(ahead) <= self._longest_gap:
            return False
        self.next_tick = self._first = (tick + 1) % 2**32
        self._waiting.clear()
        return True

    def take(self, message: Message) -> None:
        """Take a frame of telemetry of every channel."""
        values = message["values"]
        if (message["decimation"], message["mask"]) != (self.every, ALL) or values.size % len(TOLD):
            return
        ahead = (message["tick"] - self.every + 1 - self.next_tick + 2**31) % 2**32 - 2**31
        samples = values.reshape(-1, len(TOLD)).repeat(self.every, axis=0)[max(-ahead, 0) :]
        if abs(ahead) > self._longest_gap or not len(samples):
            return
        if ahead > 0:
            self.lost += ahead
            self._waiting.append(np.full((ahead, len(TOLD)), np.nan))
        self._waiting.append(samples * SCALES)
        self.next_tick = (self.next_tick + max(ahead, 0) + len(samples)) % 2**32
        self.state = int(state_of(samples[-1:, _FROM["flags"]])[0])

    def taken(self, pipe: Pipe) -> np.ndarray:
        """Return the channels of the ticks that came since, shape (channels, ticks).

        The friction force is known where a bench is simulated; that of open loop and that of closed loop are the same
        force, told in the one or the other channel by the state of the board.
        """
        if not self._waiting:
            return np.empty((len(CHANNELS), 0))
        told = np.concatenate(self._waiting).T
        self._waiting.clear()
        felt = pipe.felt(self._first, told.shape[1], 1)
        self._first = self.next_tick
        return channels_of(told, np.full(told.shape[1], np.nan) if felt is None else felt)


def channels_of(told: np.ndarray, felt_n: np.ndarray) -> np.ndarray:
    """Return the channels of a session from those of a device, shape (8, ticks), and the force on the finger (N)."""
    there = np.isfinite(told[_FROM["flags"]])
    flags = np.where(there, told[_FROM["flags"]], 0.0).astype(np.int32)
    closed, is_open = state_of(flags) == STATES["closed"], state_of(flags) == STATES["open"]
    rows = np.full((len(CHANNELS), told.shape[1]), np.nan)
    rows[_AT["x_mm"]], rows[_AT["load_n"]] = 1e3 * told[_FROM["position"]], told[_FROM["load"]]
    rows[_AT["asked_n"]], rows[_AT["measured_n"]] = told[_FROM["f_r"]], told[_FROM["f_m"]]
    for name, runs in (("open", is_open), ("closed", closed)):
        rows[_AT[f"{name}_n"]] = np.where(runs, felt_n, np.nan)
        rows[_AT[f"{name}_um"]] = np.where(runs, told[_FROM["a"]], np.nan)
    rows[_AT["saturated"]] = closed & (flags >> 1 & 1 == 1)
    return rows


class News:
    """What came in from a device that was asked for every sample, or for as many as a line carries."""

    def __init__(self, link: Link, tick_hz: int) -> None:
        self._link, self._tick_hz = link, tick_hz
        self.fault = ""
        """The fault that is in force, in a line; empty without one."""
        self.listen()

    @property
    def state(self) -> str:
        """State of the board as its last sample tells it."""
        return NAMES.get(self.rows.state, "unknown")

    def listen(self) -> None:
        """Ask for samples from now on, of a device that may have forgotten whom it tells."""
        status = self._link.listen(carried(1, self._tick_hz), ALL)
        self._note_fault(status)
        self.rows = Rows(status["tick"], self._tick_hz)

    def take(self, message: Message) -> str:
        """Take a message; return why the device has to be set up anew, empty where it has not."""
        if message.name == "telemetry":
            self.rows.take(message)
        elif message.name == "status":
            self._note_fault(message)
            if self.rows.began_anew(message["tick"]):
                return f"reset: {RESETS.get(message['reset'], 'unknown')}"
        elif message.name == "fault":
            self.fault = fault_line(message["fault"], reading_of(message))
        elif message.name == "refused" and message["reason"] == NO_SESSION:
            return "session ended"
        return ""

    def _note_fault(self, status: Message) -> None:
        if status["state"] == STATES["fault"] and not self.fault:
            self.fault = fault_line(status["fault"])
