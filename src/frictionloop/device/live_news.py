"""What a device says of itself: its samples, its state, its faults, and that it began anew."""

from __future__ import annotations

from frictionloop.device.codec import Message
from frictionloop.device.fault_codes import fault_line, reading_of
from frictionloop.device.link import Link
from frictionloop.device.live_rows import Rows
from frictionloop.device.recorder import ALL
from frictionloop.device.running import NAMES, NO_SESSION, RESETS, STATES


class News:
    """What came in from a device that was asked for every sample.

    Parameters
    ----------
    link : Link
        The line to it.
    """

    def __init__(self, link: Link) -> None:
        self._link = link
        self.fault = ""
        """The fault that is in force, in a line; empty without one."""
        self.listen()

    @property
    def state(self) -> str:
        """State of the board as its last sample tells it."""
        return NAMES.get(self.rows.state, "unknown")

    def listen(self) -> None:
        """Ask for every sample from now on, of a device that may have forgotten whom it tells."""
        status = self._link.listen(1, ALL)
        self._note_fault(status)
        self.rows = Rows(status["tick"])

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
