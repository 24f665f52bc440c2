"""The filtered PI's numbers in the firmware (firmware/core/law_filtered_pi.c), and places that fit what is in them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from scipy.signal import sosfilt

from frictionloop.control.expected import expected_gains
from frictionloop.control.filtered_pi import FREE, hold_gain, sections_of
from frictionloop.control.notch import Section
from frictionloop.firmware.quantised import Gain, to_gain
from frictionloop.parameters.controller import FILTERS
from frictionloop.quantities import must_be

LARGEST_N = 8.0
"""Forces and their differences in the firmware are within this: 2^31 steps of 2^-28 N."""
MOST_PLACES = 40
"""Of a quiet section (assumed: far beyond what a force within 0.2 mN needs)."""
LONGEST = 1 << 20
"""Control periods over which an impulse response is summed at most (assumed)."""
_TAIL = 1e-3
"""Share of an impulse response that is left when the sum ends; `_MARGIN` covers it and rounding."""
_MARGIN = 1.02


class Sizes(NamedTuple):
    """Largest magnitudes in the filter, N."""

    sections: tuple[float, ...]
    """Of each section: outputs, memories and products."""
    output: float
    """Behind all sections, as the PI would first see it."""


def section_sizes(sections: Sequence[Section], kp: float, held: bool) -> Sizes:
    """Bound what sections can hold, for errors and forces within 8 N.

    A free section gives at most the sum of |h| of all up to it times the largest error. Held ones are what the inverse
    of PI and sections makes of a command within the clamp: y = (u - I)/kp behind the last, and so back through each
    inverse. Before the command is clipped, the PI sees b0 of each and its memory.
    """
    outputs = _chain(sections[:FREE] if held else sections)
    if held:
        behind = 2.0 * LARGEST_N / kp
        first, *inputs = _before_held(sections[FREE:], behind)
        outputs = [*outputs[:-1], max(outputs[-1], first), *inputs, behind]
    sizes, first, before = [], LARGEST_N, LARGEST_N
    for i, (section, after) in enumerate(zip(sections, outputs, strict=True)):
        b0, b1, b2, a1, a2 = map(abs, section)
        memory = after + b0 * before
        trial = b0 * first + memory if held and i >= FREE else after
        sizes.append(max(after, trial, memory, b1 * before, a1 * after, b2 * before + a2 * after))
        first, before = trial, after
    return Sizes(tuple(sizes), first)


def places_for(size: float, most: int = MOST_PLACES) -> int:
    """Return the most binary places with which 32 bits hold a magnitude."""
    return min(math.floor(31.0 - math.log2(max(size * _MARGIN, 2.0**-most))), most)


def _before_held(sections: Sequence[Section], behind: float) -> list[float]:
    """Return the largest input of each held section, given the largest output of the last."""
    inverses = [Section(1.0, a1, a2, b1 / b0, b2 / b0) for b0, b1, b2, a1, a2 in reversed(sections)]
    inputs, gain = [], behind / LARGEST_N
    for section, total in zip(reversed(sections), _chain(inverses), strict=True):
        gain /= abs(section[0])
        inputs.append(total * gain)
    return inputs[::-1]


def _chain(sections: Sequence[Section]) -> list[float]:
    """Return 8 N times the sum of |h| of the first section, of the first two, and so on."""
    if not sections:
        return []
    impulse = np.zeros(_length(sections))
    impulse[0] = LARGEST_N
    sums = []
    for b0, b1, b2, a1, a2 in sections:
        impulse = sosfilt([[b0, b1, b2, 1.0, a1, a2]], impulse)
        sums.append(float(np.sum(np.abs(impulse))))
    return sums


def _length(sections: Sequence[Section]) -> int:
    """Return after how many periods little is left of an impulse."""
    radius = max(float(np.max(np.abs(np.roots((1.0, a1, a2))), initial=0.0)) for *_, a1, a2 in sections)
    if radius >= 1.0 or (periods := _forgotten(radius, len(sections))) > LONGEST:
        raise must_be("controller.sections: radius", float(radius), f"forgotten in {LONGEST} periods")
    return periods


def _forgotten(radius: float, count: int) -> int:
    """Return n with n^(2 count) radius^n below the tail: poles may coincide."""
    if radius < 1e-3:
        return 64
    decay = -math.log(radius)
    n = 64.0 + 1.0 / decay
    for _ in range(50):
        n = max(n, (2 * count * math.log(max(n * decay, 1.0)) - math.log(_TAIL * 1e-2)) / decay)
    return math.ceil(n)


COARSEST_N = 1e-5
"""Coarsest steps of the force command that are accepted, N (assumed: a twentieth of the 0.2 mN allowed)."""
NOTHING = Gain(0, 0)


class Places(NamedTuple):
    """Binary places of the law's signals."""

    sections: tuple[int, ...]
    integral: int
    """And of the PI's command."""
    springs: int
    """Spring, rate and reading of the expected reading."""


def filtered_places(controller: Any) -> Places:
    """Return the places of a controller's signals, so that none overflows.

    Raises
    ------
    FrictionloopError
        When the force command would come in steps of more than 0.01 mN, or a section remembers too long.
    """
    sections, kp, dt = sections_of(controller), controller.kp, 1.0 / controller.rate_hz
    held = hold_gain(kp, controller.ki, sections, dt) != 0.0
    sizes = section_sizes(sections, kp, held)
    # Held, the integral is a mean of commands; otherwise it stops at most ki dt y beyond the clamp.
    integral = LARGEST_N if held else LARGEST_N + controller.ki * dt * sizes.output
    size = kp * sizes.output + integral + LARGEST_N
    places = Places(tuple(map(places_for, sizes.sections)), places_for(size, 28), _spring_places(controller))
    coarse = 2.0**-places.integral
    gain = kp
    for section, own in zip(reversed(sections), reversed(places.sections), strict=True):
        coarse += gain * 2.0**-own
        gain *= abs(section[0])
    if not coarse <= COARSEST_N:
        raise must_be("controller.sections: step", float(f"{coarse:.2g}"), f"at most {COARSEST_N:g}: less gain", "N")
    return places


def filtered_state_places(controller: Any) -> tuple[int, ...]:
    """Return the places of each state: integral, two of each section, the expected reading."""
    sections, integral, springs = filtered_places(controller)
    each = (*sections, *(28,) * (FILTERS - len(sections)))
    return (integral, *(own for own in each for _ in range(2)), *(28,) * 5, *(springs,) * 3)


def filtered_gains(controller: Any) -> list[Gain]:
    """Return the gains of fl_filtered_pi_step, in its order."""
    sections, dt = sections_of(controller), 1.0 / controller.rate_hz
    places = filtered_places(controller)
    hold = hold_gain(controller.kp, controller.ki, sections, dt)
    steps = (28, *places.sections)
    out, free = steps[-1], steps[min(FREE, len(sections))]
    gains = [
        Gain(len(sections), 0),
        _between(controller.kp, out, places.integral, "controller.kp"),
        _between(controller.ki * dt, out, places.integral, "controller.ki / rate_hz"),
        _between(hold, places.integral, free, "1/(kp prod b0)"),
        *_convert(places.integral),
    ]
    for i, (b0, b1, b2, a1, a2) in enumerate(sections):
        name = f"controller.sections[{i}]"
        gains += [_between(b, steps[i], steps[i + 1], name) for b in (b0, b1, b2)]
        gains += [to_gain(a, name) for a in (a1, a2)]
    gains += [NOTHING] * (5 * (FILTERS - len(sections)))
    return gains + _expected(controller, places.springs)


def _expected(controller: Any, springs: int) -> list[Gain]:
    e = expected_gains(controller)
    rest = [e.overdrive, 1.0 - e.decay, *e[2:]]
    if e.whole < 0.0:
        return [Gain(-1, 0), *[NOTHING] * (len(rest) + 2)]
    return [Gain(round(e.whole), 0), *(to_gain(value, "controller.model") for value in rest), *_convert(springs)]


def _between(value: float, before: int, after: int, name: str) -> Gain:
    """Return a gain from a signal with some binary places to one with others."""
    return to_gain(math.ldexp(value, after - before), name)


def _convert(places: int) -> tuple[Gain, Gain]:
    """Return the gains from 28 places to these, and back."""
    return Gain(1, 28 - places), Gain(1 << (28 - places), 0)


def _spring_places(controller: Any) -> int:
    """Return the places of the springs: at resonance they swing by 4 Q/pi of what drives them, in the worst case.

    The sum of |h| of w^2/(s^2 + s w/Q + w^2) is coth(pi/(2 sqrt(4 Q^2 - 1))) for Q > 1/2, and 1 below; that of the rate
    is at most the same and 1 more.
    """
    model = controller.model
    swing = 1.0
    if model.resonance_hz and model.resonance_q > 0.5:
        swing = 1.0 / math.tanh(math.pi / (2.0 * math.sqrt(4.0 * model.resonance_q**2 - 1.0)))
    places = places_for(LARGEST_N * (swing + 2.0), 28)
    if places < 18:  # steps of 4 uN
        raise must_be("controller.model.resonance_q", float(model.resonance_q), "lower on a board")
    return places
