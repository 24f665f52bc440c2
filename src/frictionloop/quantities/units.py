"""Units carried by names and by files of measurements, and the error every bad value raises."""

from __future__ import annotations

from functools import lru_cache

from frictionloop.quantities.class_help import Brief

_UNITS = {
    **{"n": "N", "m": "m", "mm": "mm", "um": "um", "kg": "kg", "s": "s", "hz": "Hz", "rthz": "rtHz", "mhz": "MHz"},
    **{"m3": "m^3", "mm2": "mm^2", "um2": "um^2", "s2": "s^2", "deg": "deg", "urad": "urad", "ug": "1e-6 g", "k": "K"},
    **{"v": "V", "nv": "nV", "fa": "fA", "vm": "V m", "mohm": "Mohm", "pf": "pF", "nf": "nF", "uh": "uH"},
    **{"pa": "Pa", "mpa": "MPa", "gpa": "GPa", "count": "count", "counts": "counts"},
}
"""Units by the word that stands for them at the end of a name."""
_UNITS_WITHOUT_SUFFIX = {"kp": "N/N", "ki": "1/s"}


class FrictionloopError(ValueError, metaclass=Brief):
    """A request that cannot be met, said in one line: what was given, where, and what would be accepted.

    ``code`` is its entry in the catalogue of findings: ``frictionloop explain CODE`` says more.
    """

    def __init__(self, said: str = "", code: str = "BAD-VALUE") -> None:
        super().__init__(said)
        self.code = code


def must_be(name: str, value: object, accepted: str, unit: str = "", code: str = "BAD-VALUE") -> FrictionloopError:
    """Return the error of a value that is not accepted: ``name = value unit: must be accepted``, or that is missing.

    >>> str(must_be("speeds_mm_s", 0.0, "above 0, e.g. 20", "mm/s"))
    'speeds_mm_s = 0 mm/s: must be above 0, e.g. 20'
    >>> str(must_be("scale", None, "a number", "N"))
    'scale is missing: a number, in N'
    """
    if value is None:
        return FrictionloopError(f"{name} is missing: {accepted}{f', in {unit}' if unit else ''}", code)
    said = f"{value:g}" if isinstance(value, float) else f"{value!r:.80}"
    return FrictionloopError(f"{name} = {' '.join(filter(None, (said, unit)))}: must be {accepted}", code)


class SignalWarning(UserWarning, metaclass=Brief):
    """A recorded signal or an array is probably read wrongly, its unit, sign, mean or column, or its file is gone.

    ``warnings.simplefilter("ignore", fl.SignalWarning)`` says that all of them are meant so.
    """


@lru_cache(4096)
def unit_of(name: str) -> str:
    """Return the unit that a parameter's name carries, ``""`` for a pure number or a word.

    >>> unit_of("controller.delay_s"), unit_of("controller.ki"), unit_of("plate.kind")
    ('s', '1/s', '')
    """
    leaf = name.rsplit(".", 1)[-1]
    if leaf in _UNITS_WITHOUT_SUFFIX:
        return _UNITS_WITHOUT_SUFFIX[leaf]
    words = leaf.split("_")
    first = len(words)
    while first > 1 and (words[first - 1] in _UNITS or words[first - 1] == "per"):
        first -= 1
    if words[1:2] == ["per"] and words[0] in _UNITS:
        first = 0
    return _written(words[first:])


def _written(words: list[str]) -> str:
    """Return ["n", "s", "per", "m"] as "N s/m"; without "per" all but the first word are below: ["mm", "s"], "mm/s"."""
    if words in ([], ["count"]):
        return ""  # a number of something
    if "per" not in words:
        above = {"rthz": 0, "n s m": 2}.get(" ".join(words), 1)  # a density of a pure number, a damping
        words = [*words[:above], "per", *words[above:]]
    cut = words.index("per")
    over, under = ([_UNITS[word] for word in part] for part in (words[:cut], words[cut + 1 :]))
    if not over and "^" in under[0]:
        return under[0].replace("^", "^-")
    return (" ".join(over) or "1") + "".join(f"/({unit})" if " " in unit else f"/{unit}" for unit in under)


UNITS: dict[str, tuple[str, float]] = {
    **{"N": ("N", 1.0), "mN": ("N", 1e-3), "uN": ("N", 1e-6), "kN": ("N", 1e3), "cN": ("N", 1e-2)},
    **{"gf": ("N", 9.80665e-3), "kgf": ("N", 9.80665), "lbf": ("N", 4.4482216152605)},
    **{"V": ("V", 1.0), "mV": ("V", 1e-3), "uV": ("V", 1e-6)},
    **{"kg": ("kg", 1.0), "g": ("kg", 1e-3)},
    **{"m": ("m", 1.0), "cm": ("m", 1e-2), "mm": ("m", 1e-3), "m/s": ("m/s", 1.0), "mm/s": ("m/s", 1e-3)},
    **{"s": ("s", 1.0), "ms": ("s", 1e-3), "us": ("s", 1e-6), "ns": ("s", 1e-9), "min": ("s", 60.0)},
}
"""Units that a file of measurements may say: in what each is counted, and how much of that it is."""
_SPELT = {"sec": "s", "secs": "s", "second": "s", "seconds": "s", "newton": "N", "newtons": "N", "volt": "V"}
_SPELT |= {"volts": "V", "µs": "us", "μs": "us", "µN": "uN", "μN": "uN", "msec": "ms", "millinewton": "mN"}
_SPELT |= dict.fromkeys(("g-force", "gram-force", "grams-force", "gramforce", "gramf", "pond"), "gf")
_SPELT |= {"millinewtons": "mN", "milliseconds": "ms", "millisecond": "ms", "microseconds": "us", "nanoseconds": "ns"}


def known_unit(text: str) -> str | None:
    """Return how this package spells a unit, None for one that it does not know."""
    text = _SPELT.get(text.strip().lower(), _SPELT.get(text.strip(), text.strip()))
    return text if text in UNITS else None
