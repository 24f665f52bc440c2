"""Numbers as people read them."""

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
