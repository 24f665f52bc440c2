"""A Teensy 3.1 that is an image and a model of the registers: the same instructions, in lock-step with a bench."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from frictionloop.device.emulator.peripherals import Clocks, Converters, Frequencies, SerialPort, Watchdog
from frictionloop.device.emulator.processor import Processor
from frictionloop.device.emulator.registers import PIT0_INTERRUPT, UART0_INTERRUPT, Bank
from frictionloop.quantities import FrictionloopError

TICK, PORT, BACKGROUND = "tick", "port", "background"
PIN_CARRIER = 4
RESETS = {
    "power_on": {"RCM_SRS0": 0x82}, "pin": {"RCM_SRS0": 0x40}, "software": {"RCM_SRS0": 0, "RCM_SRS1": 0x04},
    "brown_out": {"RCM_SRS0": 0x02}, "watchdog": {"RCM_SRS0": 0x20}, "other": {"RCM_SRS0": 0, "RCM_SRS1": 0x02},
}  # fmt: skip
"""What the registers tell after a reset: POR and LVD, PIN, SW, LVD, WDOG, core lock-up (K20P64M72SF1RM, Reset Control
Module)."""
_EDGE_ALIGNED_HIGH = 0x28


class TeensyEmulator:
    """Runs a built image of the board ``teensy31``, tick by tick.

    The registers behave as the K20 manual says where the firmware relies on it, and an access to any other register
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
        Without the extra ``emulator``, for a file that is no image, and for an image that does not start: it touches
        what the model has not, sets a clock too fast, faults, or never comes to rest.
    """

    def __init__(self, image_path: str | os.PathLike[str], reset: str = "power_on") -> None:
        bank = self._bank = Bank(RESETS[reset])
        self._clocks, self._converters = Clocks(bank), Converters(bank)
        self._port, self._watchdog = SerialPort(bank), Watchdog(bank)
        self.runs = BACKGROUND
        """What runs: the interrupt of the tick or of the port, or the background."""
        self.on_enter: Callable[[str], None] | None = None
        """Called when something else begins to run."""
        self._running = False
        self.ticks = 0
        """Ticks so far."""
        self.late_us = 0.0
        """How long after its time the next ticks begin."""
        self._bus_hz, self._cycles_a_tick = 0.0, 0
        bank.on_read["PIT_CVAL0"] = self._timer
        bank.on_read["DWT_CYCCNT"] = self._cycles
        bank.on_read["PIT_TFLG0"] = lambda: 0
        bank.on_write["PORTC_PCR1"] = self._pin
        self.processor = Processor(Path(image_path), bank)
        self.processor.reset()
        self._watchdog.check_started()
        if not (self._enabled(PIT0_INTERRUPT) and self._enabled(UART0_INTERRUPT)) or bank.values["PIT_TCTRL0"] & 3 != 3:
            raise FrictionloopError(f"{image_path}: timer or port not started", "BAD-IMAGE")
        self._running = True
        frequencies = self.frequencies()
        self._tick_counts = bank.values["PIT_LDVAL0"] + 1
        self._bytes_a_tick = int(self.baud() / 10 * self._tick_counts / frequencies.bus)
        self._bus_hz = frequencies.bus
        self._cycles_a_tick = round(self._tick_counts * frequencies.core / frequencies.bus)

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
        processor, port = self.processor, self._port
        if processor.failure is not None:
            raise processor.failure
        port.begin(self._bytes_a_tick)
        self._converters.convert((*force_counts, load_counts, position))
        self._watchdog.check(self.ticks * self._tick_counts / self._bus_hz)
        self._enter(TICK)
        processor.interrupt(16 + PIT0_INTERRUPT)
        self.ticks += 1
        self._rest()
        while port.arrive() or port.interrupts():
            while port.interrupts():
                self._enter(PORT)
                processor.interrupt(16 + UART0_INTERRUPT)
            self._rest()
        return self.duty

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

    def bursts(self, count: int) -> None:
        """Let the port's interrupt find so many bytes from now on, 4 to 8."""
        self._port.burst = count

    def receive(self, data: bytes) -> None:
        """Put bytes on the wire to the device: as many as fit into a tick arrive in each."""
        self._port.feed(data)

    def transmit(self) -> bytes:
        """Take the bytes that the device has sent since the last call."""
        return self._port.collect()

    @property
    def compare(self) -> int:
        """The compare value of the carrier."""
        return self._bank.values["FTM0_C0V"]

    @property
    def period(self) -> int:
        """Counts of a period of the carrier."""
        return self._bank.values["FTM0_MOD"] + 1

    @property
    def duty(self) -> float:
        """Duty of the carrier at the pin: 0 unless the timer runs and the pin is its own."""
        values = self._bank.values
        on = values["FTM0_SC"] >> 3 & 3 == 1 and values["FTM0_C0SC"] & 0x3C == _EDGE_ALIGNED_HIGH
        return self.compare / self.period if on and values["PORTC_PCR1"] >> 8 & 7 == PIN_CARRIER else 0.0

    def frequencies(self) -> Frequencies:
        """Return the frequencies of core, bus and flash that the image has set, in Hz."""
        return self._clocks.frequencies()

    def baud(self) -> float:
        """Return the rate of the serial port in bits a second."""
        return self._port.baud(self.frequencies().core)

    def _timer(self) -> int:
        """Counts down; the background reads it in the middle of a period."""
        counts = self._bank.values["PIT_LDVAL0"] + 1
        passed = min(round(self.late_us * 1e-6 * self._bus_hz), counts - 1) if self.in_tick else counts // 2
        return counts - 1 - passed

    def _cycles(self) -> int:
        """Cycles by the tick alone: how long a tick takes is not known here, see `cycles`."""
        return self.ticks * self._cycles_a_tick & 0xFFFFFFFF

    def _pin(self, value: int) -> None:
        """Once it runs, the image gives up the pin only to stop for good."""
        if self._running and value >> 8 & 7 != PIN_CARRIER:
            self.processor.stop(FrictionloopError("image: has stopped itself, carrier off"))

    def _enabled(self, interrupt: int) -> int:
        return self._bank.values[f"NVIC_ISER{interrupt // 32}"] >> interrupt % 32 & 1
