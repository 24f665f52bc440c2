"""What each fault of the firmware means, for a page that shows it; docs/firmware-states.md says the same at length."""

from __future__ import annotations

WORDS = {
    "force_range": "the force is outside `safety.force_limit_n` for `safety.force_ticks` in a row",
    "sensor_saturated": "a channel, of force, load or position, is at an end of its converter",
    "sensor_stuck": "a force channel stays within one count, dithering or not",
    "sensor_jumps": "the position of a sliding finger has moved once, or force or load three times, further than it "
    "can in a tick",
    "sensor_contrary": "for 15 ms the force is above `safety.contrary_n` without load, or as much along the motion",
    "sensor_hums": "the force swings three times, by `safety.hum_n` and by half of the force at least, at the beat of "
    "the mains",
    "host_silent": "the session that switched the loop on gave no sign of life for more than 200 ms",
    "tick_overrun": "`safety.overrun_ticks` ticks began late within a second",
    "no_finger": "the loop has been on for 60 s in which no reading was valid",
    "bad_parameter": "the table that the board started with fails its checks",
    "bad_image": "the check sum of the flash, built-in table and all, was wrong at reset",
    "brown_out": "the supply fell too low and the processor was reset",
    "watchdog": "no tick came for 50 ms, or the firmware stopped itself after an exception",
}
"""The first words of the page on each fault, by its name in the protocol."""


def in_words(name: str, reading: str) -> str:
    """Return a fault with what it means; ``reading`` is what the board told of its cause, in brackets."""
    return f"{name}{reading}: {WORDS.get(name, 'a fault that this version does not know')}"
