"""Units that a file of measurements may say, and what one of each is."""

from __future__ import annotations

UNITS: dict[str, tuple[str, float]] = {
    "N": ("N", 1.0),
    "mN": ("N", 1e-3),
    "uN": ("N", 1e-6),
    "kN": ("N", 1e3),
    "V": ("V", 1.0),
    "mV": ("V", 1e-3),
    "uV": ("V", 1e-6),
    "kg": ("kg", 1.0),
    "g": ("kg", 1e-3),
    "s": ("s", 1.0),
    "ms": ("s", 1e-3),
    "us": ("s", 1e-6),
    "min": ("s", 60.0),
}
"""Units that are known, in what they are counted, and how much of it they are."""
_SPELT = {"sec": "s", "secs": "s", "second": "s", "seconds": "s", "newton": "N", "newtons": "N", "volt": "V"}
_SPELT |= {"volts": "V", "µs": "us", "μs": "us", "µN": "uN", "μN": "uN", "msec": "ms", "millinewton": "mN"}


def known_unit(text: str) -> str | None:
    """Return how this package spells a unit, None for one that it does not know."""
    text = _SPELT.get(text.strip().lower(), _SPELT.get(text.strip(), text.strip()))
    return text if text in UNITS else None
