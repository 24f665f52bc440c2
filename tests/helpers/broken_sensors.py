"""Sensors that break while a finger slides: what they then tell, and how long the board takes to notice."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from whole_sensors import FIRST, population

import frictionloop as fl
from frictionloop.device.codec import Decoder, encode
from frictionloop.device.simulated_boards import Converters, HostBoard, Sample
from frictionloop.firmware.parameter_words import firmware_words
from frictionloop.parameters.presets import RETUNED
from frictionloop.quantities.protocol_schema import schema
from tests.helpers.host_frames import SESSION, heartbeat, hello

COUNTS_A_NEWTON = 2**16 / 5
LEAST, LARGEST, TICK_HZ = -32768, 32767, 5000
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


def scaled(times: float = 1.0, more_n: float = 0.0, drift_n_s: float = 0.0, noise_n: float = 0.0) -> Broken:
    """Another gain, an offset, a drift and noise."""

    def broken(now: Sample, broke: Sample, k: int, rng: np.random.Generator) -> Sample:
        more = more_n + drift_n_s * k / TICK_HZ + noise_n * rng.standard_normal()
        return now._replace(force=told(times * now.force + COUNTS_A_NEWTON * more))

    return broken


def late(ticks: int, every: int = 1) -> Broken:
    """A force of some ticks ago, and of those one of ``every``."""
    kept: deque[int] = deque(maxlen=ticks + 1)

    def broken(now: Sample, broke: Sample, k: int, rng: np.random.Generator) -> Sample:
        if k == 0:
            kept.clear()
        if k % every == 0:
            kept.append(now.force)
        return now._replace(force=kept[0])

    return broken


def stuck_bit(bit: int) -> Broken:
    """A bit of the converter is 1."""
    return lambda now, broke, k, rng: now._replace(force=now.force | 1 << bit)


class Failure(NamedTuple):
    """How a sensor breaks, the fault that it is, and the longest time until it is told, in ticks."""

    tells: Broken
    faults: tuple[str, ...]
    ticks: int = TICK_HZ // 50


HUMS = ("sensor_hums", "force_range")
"""A hum may take a large force out of its range."""
THIRTEEN = 15 * TICK_HZ // 100
"""Ticks of 13 swings of the mains at 50 Hz, and of two more until they are told apart from the force."""
FAILURES = {
    "stuck with a bit of dither": Failure(dither, ("sensor_stuck",)),
    "floating": Failure(floating, (*HUMS, "sensor_jumps"), THIRTEEN),
    "random codes": Failure(random_codes, ("sensor_jumps",)),
    "mains, 50 Hz": Failure(hum(0.5, 50.0), HUMS, THIRTEEN),
    "mains, 60 Hz": Failure(hum(0.5, 60.0), HUMS, THIRTEEN),
    "mains, strong": Failure(hum(1.0, 50.0), HUMS, THIRTEEN),
    "reversed sign": Failure(reversed_sign, ("sensor_contrary",)),
    "open input": Failure(scaled(0.0, noise_n=1e-4), ("sensor_jumps", "sensor_contrary")),
    "an offset": Failure(scaled(more_n=1.0), ("sensor_jumps", "force_range")),
    "half the gain": Failure(scaled(0.5), ("sensor_jumps",)),
    "a tenth of the gain": Failure(scaled(0.1), ("sensor_jumps", "sensor_contrary")),
    "intermittent overload": Failure(overload(10, 10), ("sensor_jumps", "sensor_saturated")),
    "position jumps": Failure(position_jumps, ("sensor_jumps",)),
    "no load": Failure(no_load, ("sensor_contrary", "sensor_jumps")),
}


UNTOLD = {
    "twice the gain": scaled(2.0),
    "a drift of 0.5 N/s": scaled(drift_n_s=0.5),
    "ten times the noise": scaled(noise_n=9e-4),
    "every second sample": late(0, 2),
    "2 ms late": late(10),
    "10 ms late": late(50),
    "a hum of 100 Hz": hum(0.5, 100.0),
    "a hum of 400 Hz": hum(0.5, 400.0),
    "bit 12": stuck_bit(12),
    "bit 13": stuck_bit(13),
}
"""What no fault, or none for certain, tells."""
FROM_THE_START = {
    "open input": scaled(0.0, noise_n=1e-4),
    "an offset": scaled(more_n=1.0),
    "half the gain": scaled(0.5),
    "a tenth of the gain": scaled(0.1),
}
"""Of sensors that broke before the loop was closed."""


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
    """Name of the fault, empty if none; ticks until it was told, and from then until the duty was 0.

    The highest amplitude since the sensor broke; and of the last 0.1 s the means of the force on the finger, over the
    set-point, and of the amplitude.
    """

    fault: str
    ticks: int
    down: int
    highest_um: float
    force_share: float
    amplitude_um: float


def notice(
    system: fl.System, tells: Broken, *, seed: int = 0, lead_s: float = 0.8, most: int = TICK_HZ // 2
) -> Noticed:
    """Return what a board at a bench does about a sensor that breaks after a time.

    The board closes its loop at the first tick; the sensor breaks while the plate is driven.
    """
    plant, board, wires = fl.Stepper(system, seed), HostBoard(firmware_words(system)), Converters(system)
    rng, decoder, names = np.random.default_rng(seed), Decoder(), {n: name for name, n in schema()["faults"].items()}
    board.receive(hello() + encode("mode", 1, SESSION, state=schema()["states"]["closed"]), 0)
    lead, broke, found = round(lead_s * TICK_HZ), None, None
    driven: list[tuple[float, float]] = []
    for k in range(lead + most):
        sample = wires.sample(plant.measured)
        if k == lead:
            broke = sample
        if broke is not None:
            sample = tells(sample, broke, k - lead, rng)
        drive = board.tick(sample, TICK_US * k)
        if k % 500 == 0:
            board.receive(heartbeat(k + 2), TICK_US * k)
        driven.append((drive.amplitude_um, plant.force_n))
        for message in decoder.feed(board.transmit(TICK_US * k)):
            if message.name == "fault":
                found = names[message["fault"]], message["tick"] - lead
        if found and not broke:
            raise AssertionError(f"{found[0]} at tick {k} while every sensor was whole")
        if found and drive.duty == 0:
            break
        plant.tick(drive.amplitude_um)
    amplitude_um, force_n = np.mean(driven[-TICK_HZ // 10 :], axis=0)
    fault, ticks = found or ("", most)
    left = force_n / system.setpoint.offset_n, amplitude_um
    return Noticed(fault, ticks, k + 1 - lead - ticks, max(driven[lead:])[0], *left)
