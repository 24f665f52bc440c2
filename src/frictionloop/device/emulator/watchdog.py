"""The watchdog: its unlocking, its time, its refreshing."""

from __future__ import annotations

from frictionloop.device.emulator.bank import Bank
from frictionloop.quantities import FrictionloopError

UNLOCK = (0xC520, 0xD928)
REFRESH = (0xA602, 0xB480)
ENABLED, BUS_CLOCK = 1 << 0, 1 << 1
OSCILLATOR_HZ = 1000


class Watchdog:
    """WDOG on its own 1 kHz oscillator."""

    def __init__(self, bank: Bank) -> None:
        self._bank = bank
        self._last = 0
        self._now_s = self._refreshed_s = 0.0
        self._unlocked: list[int] = []
        self._first = False
        bank.on_write["WDOG_REFRESH"] = self._refresh
        bank.on_write["WDOG_UNLOCK"] = self._unlock

    def check_started(self) -> None:
        """Refuse an image that did not unlock the watchdog first, or does not use it.

        The two words must come within 256 cycles of reset, else the watchdog resets: the model has no cycles,
        so they must come before anything else is written.
        """
        if not self._first:
            raise FrictionloopError("image: watchdog not unlocked first", "BAD-IMAGE")
        if not self._bank.values["WDOG_STCTRLH"] & ENABLED:
            raise FrictionloopError("image: watchdog off", "BAD-IMAGE")
        if self._bank.values["WDOG_STCTRLH"] & BUS_CLOCK:
            raise FrictionloopError("image: watchdog's clock can stop", "BAD-IMAGE")

    def timeout_s(self) -> float:
        """Return how long it waits."""
        values = self._bank.values
        counts = values["WDOG_TOVALH"] << 16 | values["WDOG_TOVALL"]
        return counts * ((values["WDOG_PRESC"] >> 8 & 7) + 1) / OSCILLATOR_HZ

    def check(self, now_s: float) -> None:
        """Take the time; refuse to go on when the image was silent for too long."""
        self._now_s = now_s
        if now_s - self._refreshed_s > self.timeout_s():
            raise FrictionloopError(f"watchdog: not refreshed for {now_s - self._refreshed_s:g} s")

    def _unlock(self, value: int) -> None:
        self._unlocked.append(value)
        self._first = self._first or (tuple(self._unlocked) == UNLOCK and self._bank.untouched(but="WDOG_UNLOCK"))

    def _refresh(self, value: int) -> None:
        if (self._last, value) == REFRESH:
            self._refreshed_s = self._now_s
        self._last = value
