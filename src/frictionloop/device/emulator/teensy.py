"""A Teensy 4.1 that is an image and a model of the registers: the same instructions, in lock-step with a bench."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from frictionloop.device.emulator.peripherals import Clocks, Converters, Frequencies, SerialPort, Watchdog
from frictionloop.device.emulator.processor import Processor
from frictionloop.device.emulator.registers import LPUART6_INTERRUPT, PIT_INTERRUPT, Bank
from frictionloop.quantities import FrictionloopError

TICK, PORT, BACKGROUND = "tick", "port", "background"
PIN_CARRIER = 1
RESETS = {"power_on": 0x01, "pin": 0x08, "software": 0x02, "watchdog": 0x80, "other": 0x100}
"""What SRC_SRSR tells after a reset: power-up, button, SYSRESETREQ, WDOG3, temperature (i.MX RT1060 Reference Manual,
System Reset Controller)."""
_INDEPENDENT, _RUN, _OUTPUT_A, _FAULTS_HIGH = 1 << 13, 1 << 8, 1 << 8, 15 << 12
STEP = 100
"""Counts of the timer by which time goes on where the image waits for it, before its ticks."""


class TeensyEmulator:
    """Runs a built image of the board ``teensy41``, tick by tick.

    The registers behave as the RT1060 manual says where the firmware relies on it, and an access to any other register
    ends the run. Time is counted in ticks; within one it stands still, except for the microseconds given as `late_us`.
    Nothing here has been compared with silicon.

    Parameters
    ----------
    image_path
        The ELF file; it is never built here.
    reset
        What the reset that it begins with came from: one of `RESETS`.

    Raises
    ------
    FrictionloopError
        Without the extra ``emulator``, for a file that is no image of this board, and for an image that does not start:
        it touches what the model has not, leaves floating point off, sets a clock too fast, faults, or never comes to
        rest.
    """

    def __init__(self, image_path: str | os.PathLike[str], reset: str = "power_on") -> None:
        bank = self._bank = Bank({"SRC_SRSR": RESETS[reset]})
        self._clocks = Clocks(bank)
        self._converters = Converters(bank, self._clocks)
        self._port, self._watchdog = SerialPort(bank), Watchdog(bank)
        self.runs = BACKGROUND
        """What runs: the interrupt of the tick or of the port, or the background."""
        self.on_enter: Callable[[str], None] | None = None
        """Called when something else begins to run."""
        self._running = self._pin_low = False
        self.ticks = 0
        """Ticks so far."""
        self.late_us = 0.0
        """How long after its time the next ticks begin."""
        self.lasts_us = 0.0
        """How long they last, by the counter of cycles."""
        self._waited = self._looked = 0
        bank.on_read["PIT_CVAL0"] = self._timer
        bank.on_read["DWT_CYCCNT"] = self._cycles
        bank.on_read["PIT_TFLG0"] = lambda: int(not self._running and bank.values["PIT_TCTRL0"] & 1)
        bank.on_write["IOMUXC_MUX_AD_B1_08"] = self._pin
        self.processor = Processor(Path(image_path), bank)
        self.processor.reset()
        self._watchdog.check_started()
        if (
            not (self._enabled(PIT_INTERRUPT) and self._enabled(LPUART6_INTERRUPT))
            or bank.values["PIT_TCTRL0"] & 3 != 3
        ):
            raise FrictionloopError(f"{image_path}: timer or port not started", "BAD-IMAGE")
        self._running = True
        self._converters.start()
        self._tick_counts = bank.values["PIT_LDVAL0"] + 1
        self.tick_hz = self.frequencies().timer / self._tick_counts
        """Rate of the ticks."""
        self._cycles_a_tick = round(self.frequencies().core / self.tick_hz)
        self._bytes_a_tick = int(self.baud() / 10 / self.tick_hz)

    def tick(self, force_counts: tuple[int, int], load_counts: int, position: int) -> float:
        """Convert, run the tick, then the background until it rests; return the duty of the carrier, 0 to 1/2.

        Parameters
        ----------
        force_counts, load_counts, position
            What the converters give: along and across the motion, load, position; -32768 to 32767 each.

        Raises
        ------
        FrictionloopError
            When the image has stopped; the carrier is off then, and stays off.
        """
        if self.processor.failure is not None:
            raise self.processor.failure
        with self.processor.stretch():
            self._period((*force_counts, load_counts, position))
        return self.duty

    def _period(self, counts: tuple[int, int, int, int]) -> None:
        processor, port = self.processor, self._port
        port.begin(self._bytes_a_tick)
        self._converters.counts, self._looked = counts, 0
        self._converters.convert()
        self._watchdog.check(self.ticks / self.tick_hz)
        self._enter(TICK)
        processor.interrupt(16 + PIT_INTERRUPT)
        self.ticks += 1
        self._rest()
        while port.arrive() or port.interrupts():
            if port.interrupts():
                self._enter(PORT)
                processor.interrupt(16 + LPUART6_INTERRUPT, port.interrupts)
            self._rest()

    @property
    def in_tick(self) -> bool:
        """Whether the tick's interrupt runs."""
        return self.runs == TICK

    def _rest(self) -> None:
        self._enter(BACKGROUND)
        self.processor.rest()

    def _enter(self, what: str) -> None:
        self.runs = what
        if self.on_enter:
            self.on_enter(what)

    def receive(self, data: bytes) -> None:
        """Put bytes on the wire to the device: as many as fit into a tick arrive in each."""
        self._port.feed(data)

    def transmit(self) -> bytes:
        """Take the bytes that the device has sent since the last call."""
        return self._port.collect()

    @property
    def compare(self) -> int:
        """The compare value of the carrier."""
        return self._bank.values["PWM4_SM0VAL3"]

    @property
    def period(self) -> int:
        """Counts of a period of the carrier."""
        return self._bank.values["PWM4_SM0VAL1"] + 1

    @property
    def duty(self) -> float:
        """Duty of the carrier at the pin: 0 unless the timer runs, no fault input holds it, and the pin is its own."""
        values = self._bank.values
        runs = values["PWM4_MCTRL"] & _RUN and values["PWM4_OUTEN"] & _OUTPUT_A
        plain = values["PWM4_SM0CTRL2"] & _INDEPENDENT and values["PWM4_FCTRL0"] & _FAULTS_HIGH == _FAULTS_HIGH
        on = runs and plain and values["IOMUXC_MUX_AD_B1_08"] & 15 == PIN_CARRIER
        return self.compare / self.period if on else 0.0

    def frequencies(self) -> Frequencies:
        """Return the frequencies of core, bus, timer and port that the image runs with, in Hz."""
        return self._clocks.frequencies()

    def baud(self) -> float:
        """Return the rate of the serial port in bits a second."""
        return self._port.baud(self.frequencies().port)

    def _timer(self) -> int:
        """Counts down; the background reads it in the middle of a period."""
        last = self._bank.values["PIT_LDVAL0"]
        if not self._running:
            self._waited += STEP
            return last - self._waited
        passed = min(round(self.late_us * 1e-6 * self.frequencies().timer), last) if self.in_tick else last // 2
        return last - passed

    def _cycles(self) -> int:
        """Cycles by the tick, and what the next ticks are said to last when they look again."""
        if not self._running:
            return round(self._waited * self.frequencies().core / self.frequencies().timer) & 0xFFFFFFFF
        self._looked += self.in_tick
        passed = round(self.lasts_us * 1e-6 * self.frequencies().core) if self._looked > 1 else 0
        return self.ticks * self._cycles_a_tick + passed & 0xFFFFFFFF

    def _pin(self, value: int) -> None:
        """Once it was low, as an image begins, the image gives up the pin only to stop for good."""
        if value & 15 != PIN_CARRIER and self._pin_low:
            self.processor.stop(FrictionloopError("image: has stopped itself, carrier off"))
        self._pin_low = True

    def _enabled(self, interrupt: int) -> int:
        return self._bank.values[f"NVIC_ISER{interrupt // 32}"] >> interrupt % 32 & 1
