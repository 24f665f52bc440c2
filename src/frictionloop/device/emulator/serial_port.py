"""UART0 as the wire sees it."""

from __future__ import annotations

from collections import deque

from frictionloop.device.emulator.bank import Bank

QUEUE = 8
SEND_INTERRUPT, RECEIVE_INTERRUPT, SENDS, RECEIVES = 1 << 7, 1 << 5, 1 << 3, 1 << 2
EMPTY_RECEIVER = 1 << 6


class SerialPort:
    """UART0 with its queues of eight bytes; 2 Mbaud are 40 bytes a tick either way."""

    def __init__(self, bank: Bank) -> None:
        self._values = bank.values
        self._queue: deque[int] = deque()
        self._wire: deque[int] = deque()
        self._sent = bytearray()
        self._room = self._coming = 0
        self.burst = QUEUE
        """Bytes that wait when the interrupt comes: half a queue where it is served at once, a whole one where not."""
        bank.on_read["UART0_D"] = lambda: self._queue.popleft() if self._queue else 0
        bank.on_read["UART0_RCFIFO"] = lambda: len(self._queue)
        bank.on_read["UART0_TCFIFO"] = lambda: QUEUE - min(QUEUE, self._room)
        bank.on_read["UART0_S1"] = lambda: 0xC0 | (len(self._queue) >= self._values["UART0_RWFIFO"]) << 5
        bank.on_write["UART0_D"] = self._send
        bank.on_write["UART0_CFIFO"] = lambda value: self._queue.clear() if value & EMPTY_RECEIVER else None

    def baud(self, clock_hz: float) -> float:
        """Return the bits a second at a clock of the core."""
        divider = (self._values["UART0_BDH"] & 31) << 8 | self._values["UART0_BDL"]
        return clock_hz / (16 * (divider + (self._values["UART0_C4"] & 31) / 32))

    def feed(self, data: bytes) -> None:
        """Put bytes on the wire to the device."""
        self._wire.extend(data)

    def collect(self) -> bytes:
        """Take what the device has sent."""
        sent = bytes(self._sent)
        self._sent.clear()
        return sent

    def begin(self, count: int) -> None:
        """Give the wire time for `count` bytes either way."""
        self._room = self._coming = count

    def arrive(self) -> bool:
        """Move bytes from the wire into the queue; returns whether there were any."""
        if not self._wire or not self._coming or not self._values["UART0_C2"] & RECEIVES:
            return False
        before = self._coming
        while self._wire and self._coming and len(self._queue) < self.burst:
            self._queue.append(self._wire.popleft())
            self._coming -= 1
        return self._coming < before

    def interrupts(self) -> bool:
        """Return whether the port asks for its interrupt."""
        control = self._values["UART0_C2"]
        receives = control & RECEIVE_INTERRUPT and len(self._queue) >= self._values["UART0_RWFIFO"]
        return bool(receives or (control & SEND_INTERRUPT and self._room > 0))

    def _send(self, value: int) -> None:
        if self._room > 0 and self._values["UART0_C2"] & SENDS:  # a byte beyond the queue is lost
            self._room -= 1
            self._sent.append(value & 0xFF)
