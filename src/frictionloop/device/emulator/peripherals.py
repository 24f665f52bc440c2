"""Peripherals behind the registers: clocks, converters with the block that starts them, serial port, watchdog."""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

from frictionloop.device.emulator.registers import Bank
from frictionloop.quantities import FrictionloopError, must_be

CRYSTAL_HZ = 16_000_000
INTERNAL_HZ = 20_971_520
"""Of the FLL after reset: 32.768 kHz times 640."""
HIGHEST_HZ = {"core": 72_000_000, "bus": 50_000_000, "flash": 25_000_000}
"""K20P64M72SF1 data sheet, device clock specifications."""
FLL, INTERNAL, EXTERNAL, PLL = range(4)
"""Source of the clock as MCG_S.CLKST has it."""


class Frequencies(NamedTuple):
    """Hz."""

    core: float
    bus: float
    flash: float


class Clocks:
    """Multipurpose clock generator (K20P64M72SF1RM): modes follow at once, a wrong order shows in the status."""

    def __init__(self, bank: Bank) -> None:
        self._values = bank.values
        bank.on_read["MCG_S"] = self._status
        bank.on_write["MCG_C1"] = bank.on_write["SIM_CLKDIV1"] = lambda _: self._refuse_too_fast()

    def _status(self) -> int:
        crystal = self._crystal()
        pll = crystal and self._values["MCG_C6"] >> 6 & 1
        internal = self._values["MCG_C1"] >> 2 & 1
        return crystal << 1 | self._source() << 2 | internal << 4 | pll << 5 | pll << 6

    def _crystal(self) -> int:
        """1 when the oscillator runs: EREFS, and a range for 16 MHz."""
        range_and_source = self._values["MCG_C2"] & 0x34
        return int(range_and_source in {0x14, 0x24, 0x34})

    def _source(self) -> int:
        wanted = self._values["MCG_C1"] >> 6
        if wanted == 2 and self._crystal():
            return EXTERNAL
        if wanted == 0 and self._values["MCG_C6"] >> 6 & 1 and self._crystal():
            return PLL
        return INTERNAL if wanted == 1 else FLL

    def frequencies(self) -> Frequencies:
        """Return the frequencies of core, bus and flash now."""
        source = {FLL: INTERNAL_HZ, INTERNAL: 32_768.0, EXTERNAL: CRYSTAL_HZ}.get(self._source(), 0.0) or self._pll()
        dividers = self._values["SIM_CLKDIV1"]
        return Frequencies(*(source / ((dividers >> shift & 15) + 1) for shift in (28, 24, 16)))

    def _pll(self) -> float:
        reference = CRYSTAL_HZ / ((self._values["MCG_C5"] & 31) + 1)
        if not 2e6 <= reference <= 4e6:
            raise must_be("MCG_C5: PLL input", reference / 1e6, "2 to 4", "MHz", "BAD-IMAGE")
        return reference * ((self._values["MCG_C6"] & 31) + 24)

    def _refuse_too_fast(self) -> None:
        for name, hz in self.frequencies()._asdict().items():
            if hz > HIGHEST_HZ[name]:
                raise must_be(name, hz / 1e6, f"at most {HIGHEST_HZ[name] / 1e6:g}", "MHz", "BAD-IMAGE")


CALIBRATE, DONE = 1 << 7, 1 << 7
INPUTS = {("ADC0", 8): 0, ("ADC1", 9): 1, ("ADC0", 12): 2, ("ADC1", 0): 3}
"""What the bench connects to which channel: force along and across the motion, load, position (docs: wiring)."""
HALF = 32768
PDB_ON, PDB_TIMER_0 = 1 << 7 | 1 << 0, 4
"""PDBEN, and LDOK that takes modulus and delays over; TRGSEL: the timer PIT0."""


class Converters:
    """ADC0, ADC1 and PDB: a conversion gives what the bench has at the input it is set to."""

    def __init__(self, bank: Bank) -> None:
        self._bank = bank
        for adc in ("ADC0", "ADC1"):
            bank.on_write[f"{adc}_SC3"] = lambda value, adc=adc: self._calibrated(adc, value)  # type: ignore[misc]

    def _calibrated(self, adc: str, value: int) -> None:
        if value & CALIBRATE:
            hertz = self._bank.values[f"{adc}_CFG1"]
            if hertz & 0x60 != 0x60:  # ADIV by 8: 36 MHz / 2 / 8 is below the 4 MHz that calibrating takes
                raise FrictionloopError(f"{adc}: calibrated above 4 MHz", "BAD-IMAGE")
            self._bank.values[f"{adc}_SC3"] = value & ~CALIBRATE

    def convert(self, counts: tuple[int, int, int, int]) -> None:
        """Convert force along and across, load, position (0 counts in the middle), if the delay block starts it."""
        values = self._bank.values
        if values["PDB_SC"] & PDB_ON != PDB_ON or values["PDB_SC"] >> 8 & 15 != PDB_TIMER_0:
            return
        for channel, adc in enumerate(("ADC0", "ADC1")):
            started = values[f"PDB_CH{channel}C1"]
            if not values[f"PDB_CH{channel}DLY0"] <= values["PDB_MOD"] <= values["PIT_LDVAL0"]:
                raise FrictionloopError(f"PDB_CH{channel}DLY0, PDB_MOD: {adc} not done in a tick", "BAD-IMAGE")
            for pretrigger, (control, result) in enumerate((("SC1A", "RA"), ("SC1B", "RB"))):
                if started >> pretrigger & 1:
                    source = INPUTS.get((adc, values[f"{adc}_{control}"] & 0x3F))
                    if source is None:
                        raise FrictionloopError(f"{adc}_{control} = {values[f'{adc}_{control}']:#x}: nothing connected")
                    values[f"{adc}_{result}"] = counts[source] + HALF


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


UNLOCK_WORDS = (0xC520, 0xD928)
REFRESH_WORDS = (0xA602, 0xB480)
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
        self._first = self._first or (tuple(self._unlocked) == UNLOCK_WORDS and self._bank.untouched(but="WDOG_UNLOCK"))

    def _refresh(self, value: int) -> None:
        if (self._last, value) == REFRESH_WORDS:
            self._refreshed_s = self._now_s
        self._last = value
