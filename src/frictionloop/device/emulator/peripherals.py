"""Peripherals behind the registers: clocks, converters with what starts them, serial port, watchdog."""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

from frictionloop.device.emulator.registers import Bank
from frictionloop.quantities import FrictionloopError, must_be

CRYSTAL_HZ = 24_000_000
CORE_HZ = 396_000_000
"""As the ROM leaves it, with the fuse BOOT_FREQ 0 (i.MX RT1060 Reference Manual, System Boot)."""
HIGHEST_BUS_HZ = 150_000_000
"""i.MX RT1060 data sheet, operating ranges."""


class Frequencies(NamedTuple):
    """Hz."""

    core: float
    bus: float
    timer: float
    port: float


class Clocks:
    """Clock controller: what the ROM has set, with the dividers and sources that an image may change."""

    def __init__(self, bank: Bank) -> None:
        self._values = bank.values

    def frequencies(self) -> Frequencies:
        """Return the frequencies of core, bus, tick timer and port now."""
        values = self._values
        bus = CORE_HZ / ((values["CCM_CBCDR"] >> 8 & 3) + 1)
        if bus > HIGHEST_BUS_HZ:
            raise must_be("bus", bus / 1e6, f"at most {HIGHEST_BUS_HZ / 1e6:g}", "MHz", "BAD-IMAGE")
        timer, port = values["CCM_CSCMR1"], values["CCM_CSCDR1"]
        return Frequencies(
            CORE_HZ,
            bus,
            (CRYSTAL_HZ if timer >> 6 & 1 else bus) / ((timer & 63) + 1),
            (CRYSTAL_HZ if port >> 6 & 1 else 80e6) / ((port & 63) + 1),
        )


CALIBRATE, MEAN = 1 << 7, 1 << 5
CFG_HARDWARE, CFG_12_BIT, BY_ETC = 1 << 13, 2 << 2, 16
FROM_PIT0 = 56
INPUTS = {("ADC1", 12): 0, ("ADC2", 11): 1, ("ADC1", 5): 2, ("ADC2", 3): 3}
"""What the bench connects to which channel: force along and across the motion, load, position (docs: wiring)."""
TRIGGERS = {"ADC1": (0, "XBARA1_SEL51"), "ADC2": (4, "XBARA1_SEL53")}
"""Number of the external trigger that starts a converter, and what its upper byte connects it to."""
CLOCKS = 25 + 8
"""Of a converter in a conversion."""
HALF, STEP_BITS = 32768, 4


def converted(counts: int) -> int:
    """Return what the image reads, from a converter on the chip of 12 bits, where one of 16 would give these counts."""
    raw = (counts + HALF) >> STEP_BITS
    return HALF - 1 if raw == 0xFFF else (raw << STEP_BITS) - HALF


class Converters:
    """ADC1, ADC2, the external trigger control, and LPSPI4 with an ADS8688: what the bench has at the inputs."""

    def __init__(self, bank: Bank, clocks: Clocks) -> None:
        self._values, self._clocks = bank.values, clocks
        self.counts = (0, 0, 0, 0)
        """Force along and across, load, position; 0 in the middle of the range."""
        self._started: list[tuple[str, list[int]]] = []
        for adc in TRIGGERS:
            bank.on_write[f"{adc}_GC"] = lambda value, adc=adc: self._calibrated(adc, value)  # type: ignore[misc]
        self._asked, self._answers = 0, deque[int]()
        bank.on_write["LPSPI4_TDR"] = self._frame
        bank.on_read["LPSPI4_RDR"] = lambda: self._answers.popleft() if self._answers else 0
        bank.on_read["LPSPI4_SR"] = lambda: 1 | bool(self._answers) << 1

    def _calibrated(self, adc: str, value: int) -> None:
        if value & CALIBRATE and self._values[f"{adc}_CFG"] & CFG_HARDWARE:
            raise FrictionloopError(f"{adc}: calibrated with a hardware trigger", "BAD-IMAGE")
        self._values[f"{adc}_GC"] = value & ~CALIBRATE

    def start(self) -> None:
        """Look up which inputs the timer starts on the chip, and refuse what is not done when a tick reads it."""
        values, self._started = self._values, []
        for adc, (number, connection) in TRIGGERS.items():
            if not values["ADC_ETC_CTRL"] >> number & 1 or values[connection] >> 8 & 0x7F != FROM_PIT0:
                continue
            trigger = f"ADC_ETC_TRIG{number}"
            chain, sources = values[f"{trigger}_CHAIN_1_0"], []
            for place in range((values[f"{trigger}_CTRL"] >> 8 & 7) + 1):
                segment = chain >> 16 * place
                source = INPUTS.get((adc, segment & 15))
                if source is None or values[f"{adc}_HC{place}"] != BY_ETC or segment >> 4 & 0xFF != 1 << place:
                    raise FrictionloopError(f"{trigger}_CHAIN_1_0 = {chain:#x}: nothing connected", "BAD-IMAGE")
                sources.append(source)
            self._check_done(adc, values[f"{trigger}_COUNTER"] & 0xFFFF, len(sources))
            self._started.append((f"{trigger}_RESULT_1_0", sources))

    def _check_done(self, adc: str, delay: int, conversions: int) -> None:
        values, (_, bus, timer, _) = self._values, self._clocks.frequencies()
        config = values[f"{adc}_CFG"]
        means = 4 << (config >> 14 & 3) if values[f"{adc}_GC"] & MEAN else 1
        clock = bus / (1, 2)[config & 1] / (1 << (config >> 5 & 3))
        wait = delay * ((values["ADC_ETC_CTRL"] >> 16 & 0xFF) + 1) / bus
        period = (values["PIT_LDVAL0"] + 1) / timer
        if config & 0xC != CFG_12_BIT or wait + conversions * means * CLOCKS / clock > period:
            raise FrictionloopError(f"{adc}: not done in a tick", "BAD-IMAGE")

    def convert(self) -> None:
        """Convert what is at these inputs."""
        for result, sources in self._started:
            raw = [(self.counts[source] + HALF) >> STEP_BITS for source in sources]
            self._values[result] = raw[0] | raw[-1] << 16

    def _frame(self, value: int) -> None:
        """One frame of the ADS8688: the answer to the command before this one (its data sheet, 8.4)."""
        self._answers.append(self.counts[self._asked >> 10 & 3] + HALF if self._asked >> 14 == 3 else 0)
        self._asked = value >> 16


QUEUE = 4
SEND_INTERRUPT, RECEIVE_INTERRUPT, SENDS, RECEIVES = 1 << 23, 1 << 21, 1 << 19, 1 << 18
EMPTY_RECEIVER = 1 << 14


class SerialPort:
    """LPUART6 with its queues of four bytes; 2 Mbaud are 40 bytes either way in a tick of 5 kHz."""

    def __init__(self, bank: Bank) -> None:
        self._values = bank.values
        self._queue: deque[int] = deque()
        self._wire: deque[int] = deque()
        self._sent = bytearray()
        self._room = self._coming = 0
        bank.on_read["LPUART6_DATA"] = lambda: self._queue.popleft() if self._queue else 1 << 12
        bank.on_read["LPUART6_WATER"] = self._water
        bank.on_read["LPUART6_STAT"] = lambda: 3 << 22 | self._has_enough() << 21
        bank.on_write["LPUART6_DATA"] = self._send
        bank.on_write["LPUART6_FIFO"] = lambda value: self._queue.clear() if value & EMPTY_RECEIVER else None

    def baud(self, clock_hz: float) -> float:
        """Return the bits a second at a clock of the port."""
        baud = self._values["LPUART6_BAUD"]
        return clock_hz / (((baud >> 24 & 31) + 1) * (baud & 0x1FFF))

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
        if not self._wire or not self._coming or not self._values["LPUART6_CTRL"] & RECEIVES:
            return False
        before = self._coming
        while self._wire and self._coming and len(self._queue) < QUEUE:
            self._queue.append(self._wire.popleft())
            self._coming -= 1
        return self._coming < before

    def interrupts(self) -> bool:
        """Return whether the port asks for its interrupt."""
        control = self._values["LPUART6_CTRL"]
        receives = control & RECEIVE_INTERRUPT and self._has_enough()
        return bool(receives or (control & SEND_INTERRUPT and self._room > 0))

    def _has_enough(self) -> bool:
        return len(self._queue) > (self._values["LPUART6_WATER"] >> 16 & 3)

    def _water(self) -> int:
        return self._values["LPUART6_WATER"] | (QUEUE - min(QUEUE, self._room)) << 8 | len(self._queue) << 24

    def _send(self, value: int) -> None:
        if self._room > 0 and self._values["LPUART6_CTRL"] & SENDS:  # a byte beyond the queue is lost
            self._room -= 1
            self._sent.append(value & 0xFF)


UNLOCK_WORD, REFRESH_WORD = 0xD928C520, 0xB480A602
ENABLED, CLOCK, TAKEN, UNLOCKED, BY_256 = 1 << 7, 3 << 8, 1 << 10, 1 << 11, 1 << 12
OSCILLATOR_HZ, NOT_MASKED = 32_768, 0xA


class Watchdog:
    """RTWDOG on its own oscillator."""

    def __init__(self, bank: Bank) -> None:
        self._values = bank.values
        self._unlocked = False
        self._now_s = self._refreshed_s = 0.0
        bank.on_write["RTWDOG_CNT"] = self._command
        bank.on_write["RTWDOG_CS"] = self._configure
        bank.on_read["RTWDOG_CS"] = lambda: self._values["RTWDOG_CS"] & ~UNLOCKED | self._unlocked * UNLOCKED

    def check_started(self) -> None:
        """Refuse an image that does not use the watchdog."""
        if not (status := self._values["RTWDOG_CS"]) & TAKEN or not status & ENABLED:
            raise FrictionloopError("image: watchdog off", "BAD-IMAGE")
        if self._values["SRC_SCR"] >> 28 != NOT_MASKED:
            raise FrictionloopError("image: watchdog masked", "BAD-IMAGE")
        if not status & CLOCK:
            raise FrictionloopError("image: watchdog's clock can stop", "BAD-IMAGE")

    def timeout_s(self) -> float:
        """Return how long it waits."""
        return self._values["RTWDOG_TOVAL"] * (256 if self._values["RTWDOG_CS"] & BY_256 else 1) / OSCILLATOR_HZ

    def check(self, now_s: float) -> None:
        """Take the time; refuse to go on when the image was silent for too long."""
        self._now_s = now_s
        if now_s - self._refreshed_s > self.timeout_s():
            raise FrictionloopError(f"watchdog: not refreshed for {now_s - self._refreshed_s:g} s")

    def _command(self, value: int) -> None:
        if value not in {UNLOCK_WORD, REFRESH_WORD}:  # it resets at once
            raise FrictionloopError(f"watchdog: 0x{value:08x} is none of its words", "BAD-IMAGE")
        self._unlocked = value == UNLOCK_WORD
        if value == REFRESH_WORD:
            self._refreshed_s = self._now_s

    def _configure(self, value: int) -> None:
        if not self._unlocked:
            raise FrictionloopError("image: watchdog not unlocked first", "BAD-IMAGE")
        self._values["RTWDOG_CS"], self._unlocked = value | TAKEN, False
