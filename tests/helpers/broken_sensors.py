"""Sensors that break while a finger slides: what they then tell, and how long the board takes to notice."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from whole_sensors import FIRST, population

import frictionloop as fl
from frictionloop.device.bench_boards import Converters, HostBoard, Sample
from frictionloop.device.codec import Decoder, encode
from frictionloop.firmware.parameter_words import firmware_words
from frictionloop.parameters.presets import RETUNED
from frictionloop.quantities.schema import schema
from tests.helpers.host_frames import SESSION, heartbeat, hello

COUNTS_A_NEWTON = 2**16 / 5
LEAST, LARGEST, TICK_HZ = -32768, 32767, 5000
TWO_PERIODS = TICK_HZ // 25
"""Of the mains at 50 Hz, in ticks."""
TICK_US = 1_000_000 // TICK_HZ

Broken = Callable[[Sample, Sample, int, np.random.Generator], Sample]
"""What is told, from what is so, what was told at the tick that the sensor broke, ticks since then, and chance."""


def told(force: float) -> int:
    """Return a reading of the force as a converter gives it, in counts."""
    return min(max(round(force), LEAST), LARGEST)


def dither(now: Sample, broke: Sample, k: int, rng: np.random.Generator) -> Sample:
    """The force stays, but for the last bit."""
    return now._replace(force=broke.force + int(rng.integers(2)))


def floating(now: Sample, broke: Sample, k: int, rng: np.random.Generator) -> Sample:
    """The cable of the force is off: what leaks in drifts by 1.5 N/s, and the mains couple in with 0.3 N (assumed)."""
    drift, hum = 1.5 * k / TICK_HZ, 0.3 * math.sin(2 * math.pi * 50 * k / TICK_HZ)
    return now._replace(force=told(broke.force + COUNTS_A_NEWTON * (drift + hum) + rng.normal()))


def random_codes(now: Sample, broke: Sample, k: int, rng: np.random.Generator) -> Sample:
    """Any code, each as likely."""
    return now._replace(force=int(rng.integers(LEAST, LARGEST + 1)))


def hum(amplitude_n: float, hz: float) -> Broken:
    """The mains on top of the force."""

    def broken(now: Sample, broke: Sample, k: int, rng: np.random.Generator) -> Sample:
        return now._replace(
            force=told(now.force + COUNTS_A_NEWTON * amplitude_n * math.sin(2 * math.pi * hz * k / TICK_HZ))
        )

    return broken


def reversed_sign(now: Sample, broke: Sample, k: int, rng: np.random.Generator) -> Sample:
    """Two wires exchanged."""
    return now._replace(force=told(-now.force))


def overload(on: int, off: int) -> Broken:
    """At its end for some ticks, whole for some."""
    return lambda now, broke, k, rng: now._replace(force=LARGEST) if k % (on + off) < on else now


def position_jumps(now: Sample, broke: Sample, k: int, rng: np.random.Generator) -> Sample:
    """The position is 60 mm from where the finger is, on the side where its converter has room."""
    return now._replace(position=now.position + (60_000 if broke.position < 0 else -60_000))


def no_load(now: Sample, broke: Sample, k: int, rng: np.random.Generator) -> Sample:
    """The load cells tell nothing."""
    return now._replace(load=int(rng.integers(-1, 2)))


class Failure(NamedTuple):
    """How a sensor breaks, the fault that it is, and the longest time until it is told, in ticks."""

    tells: Broken
    faults: tuple[str, ...]
    ticks: int = TICK_HZ // 50


HUMS = ("sensor_hums", "force_range")
"""A hum may take a large force out of its range."""
FAILURES = {
    "stuck with a bit of dither": Failure(dither, ("sensor_stuck",)),
    "floating": Failure(floating, (*HUMS, "sensor_jumps"), TWO_PERIODS),
    "random codes": Failure(random_codes, ("sensor_jumps",)),
    "mains, 50 Hz": Failure(hum(0.5, 50.0), HUMS, TWO_PERIODS),
    "mains, 60 Hz": Failure(hum(0.5, 60.0), HUMS, TWO_PERIODS),
    "mains, strong": Failure(hum(1.0, 50.0), HUMS, TWO_PERIODS),
    "reversed sign": Failure(reversed_sign, ("sensor_contrary",)),
    "intermittent overload": Failure(overload(10, 10), ("sensor_jumps", "sensor_saturated")),
    "position jumps": Failure(position_jumps, ("sensor_jumps",)),
    "no load": Failure(no_load, ("sensor_contrary", "sensor_jumps")),
}


LAWS = ("notch_pi", "limit_observer", "pi", "lookup")


def bench(law: str, force_n: float = 0.5) -> fl.System:
    """Return the bench with a law's own gains, the PI's those that hold, at a force that drives the plate."""
    plain = fl.bench().evolve(RETUNED).model_dump()
    if law != "pi":
        plain["controller"] = {"kind": law, "delay_s": 200e-6, "model": plain["controller"]["model"]}
    plain["setpoint"] = {"kind": "constant", "offset_n": force_n}
    plain["motion"]["start"] = 0.1
    return fl.System.model_validate(plain)


def slid(number: int, seed: int = FIRST) -> fl.System:
    """Return one of many benches: a law, a force, a speed and a finger of a population."""
    finger = population(seed)[37 * number % 1000]
    return bench(LAWS[number % len(LAWS)], (0.4, 0.5, 0.6, 0.8)[number % 4]).evolve(
        finger | {"motion.speed_mm_s": (20.0, 40.0, 80.0)[number % 3]}
    )


class Noticed(NamedTuple):
    """Name of the fault, ticks until it was told, and ticks from then until the duty was 0."""

    fault: str
    ticks: int
    down: int
    highest_um: float


def notice(
    system: fl.System, tells: Broken, *, seed: int = 0, lead_s: float = 0.8, most: int = TICK_HZ // 2
) -> Noticed | None:
    """Return what a board at a bench does about a sensor that breaks after a time; None when it told nothing.

    The board closes its loop at the first tick; the sensor breaks while the plate is driven.
    """
    plant, board, wires = fl.Stepper(system, seed), HostBoard(firmware_words(system)), Converters(system)
    rng, decoder, names = np.random.default_rng(seed), Decoder(), {n: name for name, n in schema()["faults"].items()}
    board.receive(hello() + encode("mode", 1, SESSION, state=schema()["states"]["closed"]), 0)
    lead, broke, found, highest = round(lead_s * TICK_HZ), None, None, 0.0
    for k in range(lead + most):
        sample = wires.sample(plant.measured)
        if k == lead:
            broke = sample
        if broke is not None:
            sample = tells(sample, broke, k - lead, rng)
        drive = board.tick(sample, TICK_US * k)
        if k % 500 == 0:
            board.receive(heartbeat(k + 2), TICK_US * k)
        highest = max(highest, drive.amplitude_um if broke else 0.0)
        for message in decoder.feed(board.transmit(TICK_US * k)):
            if message.name == "fault":
                found = names[message["fault"]], message["tick"] - lead
        if found and not broke:
            raise AssertionError(f"{found[0]} at tick {k} while every sensor was whole")
        if found and drive.duty == 0:
            return Noticed(*found, k + 1 - lead - found[1], highest)
        plant.tick(drive.amplitude_um)
    return None
