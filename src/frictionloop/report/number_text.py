"""Numbers as people read them, with their unit."""

from __future__ import annotations

POWERS = {"-": "⁻", "0": "⁰", "1": "¹", "2": "²", "3": "³", "4": "⁴", "5": "⁵", "6": "⁶", "7": "⁷", "8": "⁸", "9": "⁹"}


def number(value: float, digits: int = 3) -> str:
    """Return a number for people: 0.4, 250, 1.2×10⁻⁵.

    >>> number(0.4), number(251.65), number(1e-5), number(-0.0000523)
    ('0.4', '252', '10⁻⁵', '−5.23×10⁻⁵')
    """
    if value == 0 or 1e-3 <= abs(value) < 10**6:
        # One digit before the point is as many as 1e6 needs: whole numbers are not rounded.
        text = f"{value:.0f}" if abs(value) >= 10 ** (digits - 1) else f"{value:.{digits}g}"
        return text.replace("-", "−")
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    mantissa = mantissa.rstrip("0").rstrip(".") if "." in mantissa else mantissa
    power = "10" + "".join(POWERS[digit] for digit in str(int(exponent)))
    return power if mantissa == "1" else f"{mantissa}×{power}".replace("-", "−")


def milli(value: float) -> str:
    """Return a number in thousandths with two digits, as mN or ms are shown."""
    return number(1e3 * value, 2)


NEARLY_ONE = 0.9999
"""A number above this and below 1 is shown as what is missing from 1."""


def shown(value: float | str | None, digits: int = 3) -> str:
    """Return a value of a claim as it is printed in tables: just below 1 as what is missing.

    >>> shown(0.999995), shown(0.98)
    ('1 − 5×10⁻⁶', '0.98')
    """
    if value is None:
        return "none"
    if isinstance(value, str):
        return value
    if NEARLY_ONE < value < 1 and number(value, digits) == "1":
        return f"1 − {number(1 - value, 2)}"
    return number(value, digits)


def with_unit(value: float | str | None, unit: str, digits: int = 3) -> str:
    """Return a value with its unit, which only a number carries."""
    text = shown(value, digits)
    return f"{text} {unit}".strip() if isinstance(value, (int, float)) else text
