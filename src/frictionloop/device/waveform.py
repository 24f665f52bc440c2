"""Set-points as the firmware plays them: a table over time or position, or an effect, as long as there is room."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from numbers import Integral
from typing import Any, NamedTuple

import numpy as np

from frictionloop.device.device_run import number
from frictionloop.device.link import Link
from frictionloop.firmware.effect_tables import EffectTables, effect_tables
from frictionloop.parameters import Constant, LogSweep, Signal, Sine, System
from frictionloop.physics.signal_values import evaluate, sampler
from frictionloop.quantities import must_be
from frictionloop.quantities.protocol_schema import schema
from frictionloop.rendering.effect import Effect
from frictionloop.rendering.effect_player import PLATE_MM
from frictionloop.rendering.effect_program import MOST_TRIGGERS
from frictionloop.rendering.effect_setpoint import EffectSource

N_PER_POINT = 1e-4
POINTS_A_FRAME = schema()["protocol"]["points_a_frame"]
PHASE = 2.0**24
FURTHEST_M = 2000.0
"""Start of a table over position at most: 32 bits of um hold 2147 m."""
LARGEST_ERROR_N = 2e-3
"""RMS by which a table may miss its set-point: a tenth of the smallest difference felt, 20 mN (assumed)."""


class Table(NamedTuple):
    """A set-point table: points in 0.1 mN, and how it is played."""

    points: np.ndarray
    source: str
    loops: bool
    step: int
    """Points per tick, or per um, in 2^-24."""
    start_um: int = 0
    error_n: float = 0.0
    """RMS of what is played against what was asked for."""

    def send(self, link: Link) -> None:
        """Write the table into the copy that waits and put it in force."""
        for _ in _frames(link, self.points, self.source, int(self.loops), self.step, self.start_um):
            pass


def _frames(link: Link, points: np.ndarray, source: str, loops: int, step: int, start_um: int) -> Iterator[None]:
    """Write points into the copy that waits, with a pause after each frame, and put them in force."""
    for first in range(0, len(points), POINTS_A_FRAME):
        link.ask("waveform", first=first, values=points[first : first + POINTS_A_FRAME])
        yield
    crc, number = zlib.crc32(points.astype("<i2").tobytes()), schema()["sources"][source]
    link.ask("play", source=number, loops=loops, count=len(points), step=step, start_um=start_um, crc=crc)


def table(
    force_n: Any, most: int, tick_hz: int, spacing_s: float | None, spacing_m: float | None, start_m: float, loops: bool
) -> Table:
    """Return the table of forces at even times or places.

    Parameters
    ----------
    force_n : array
        Forces in N, 1 to `most` of them, within -3.2768 to 3.2767.
    most : int
        Points the device takes.
    tick_hz : int
        Its ticks.
    spacing_s, spacing_m : float, optional
        Time in s or way in m from one to the next; one of the two.
    start_m : float
        Position of the first.
    loops : bool
        Whether it begins again at its end.

    Raises
    ------
    FrictionloopError
        For too many points, a force out of range, or a spacing that the firmware cannot follow.
    """
    points = _points(force_n, most)
    for told, given in ("spacing_s", spacing_s), ("spacing_m", spacing_m), ("start_m", start_m):
        if given is not None:
            number(told, given)
    if abs(start_m) > FURTHEST_M:
        raise must_be("start_m", start_m, f"{-FURTHEST_M:g} to {FURTHEST_M:g}", "m")
    if (spacing_s is None) == (spacing_m is None):
        raise must_be("spacing_s, spacing_m", (spacing_s, spacing_m), "one of them")
    spacing, per = (spacing_s, tick_hz) if spacing_s is not None else (spacing_m, 1e6)
    name = "spacing_s" if spacing_s is not None else "spacing_m"
    step = PHASE / (spacing * per) if spacing is not None and spacing > 0 else 0.0
    if not 1 <= step < 2**32:
        raise must_be(name, spacing, f"{PHASE / (per * 2.0**32):.2g} to {PHASE / per:.2g}")
    return Table(points, "time" if spacing_s is not None else "position", loops, round(step), round(start_m * 1e6))


def checked(setpoint: Any) -> Signal | np.ndarray:
    """Return the set-point of a run: a source as it is, a force as one that is held, forces as an array."""
    if isinstance(setpoint, Signal):
        return setpoint
    try:
        force = np.asarray(setpoint, dtype=float)
    except (TypeError, ValueError):
        force = np.empty((0, 0))
    if force.ndim > 1:
        raise must_be("setpoint", type(setpoint).__name__, "a source or forces, N")
    if force.ndim == 0:
        _in_range(np.atleast_1d(force), "setpoint")
        return Constant(offset_n=float(force))
    _in_range(force, "setpoint", "tick")
    return force


def table_of(setpoint: Signal | np.ndarray, duration_s: float, most: int, tick_hz: int) -> Table:
    """Return the table of a set-point for a run: a source, or forces at every tick."""
    if isinstance(setpoint, Constant):
        return table([setpoint.offset_n], most, tick_hz, 1 / tick_hz, None, 0.0, False)
    if isinstance(setpoint, Sine):
        phase = np.arange(most) / most
        force = setpoint.offset_n + setpoint.amplitude_n * np.sin(2 * np.pi * phase)
        return table(force, most, tick_hz, 1 / (setpoint.frequency_hz * most), None, 0.0, True)
    return _sampled(setpoint, duration_s, most, tick_hz)


def with_setpoint(system: System | None, setpoint: Signal | np.ndarray) -> System | None:
    """Return the System with the set-point that a run was given, as far as a System can hold it."""
    if system is None or isinstance(setpoint, np.ndarray):
        return system
    return system.model_copy(update={"setpoint": setpoint})


def _sampled(setpoint: Signal | np.ndarray, duration_s: float, most: int, tick_hz: int) -> Table:
    """Return the table of what does not repeat: at every tick if they are few enough, else spread over the run."""
    ticks = max(round(duration_s * tick_hz), 1)
    wanted = _at_ticks(setpoint, duration_s, ticks, tick_hz)
    places = np.linspace(0.0, ticks, min(most, ticks + 1))
    forces = np.interp(places, np.arange(ticks + 1), wanted)
    found = table(forces, most, tick_hz, places[1] / tick_hz, None, 0.0, False)
    played = np.interp(np.arange(ticks + 1), places, found.points * N_PER_POINT)
    error = float(np.sqrt(np.mean((played - wanted) ** 2)))
    if error > LARGEST_ERROR_N:
        accepted = f"at most {LARGEST_ERROR_N:g}, of {most} points in {duration_s:g} s"
        raise must_be("setpoint: rms error", float(f"{error:.2g}"), accepted, "N", "BOARD-STEPS")
    return found._replace(error_n=error)


def _at_ticks(setpoint: Signal | np.ndarray, duration_s: float, ticks: int, tick_hz: int) -> np.ndarray:
    """Return the forces at the ticks 0 to `ticks` of a run."""
    if isinstance(setpoint, np.ndarray):
        if setpoint.size < ticks:
            raise must_be("setpoint", setpoint.size, f"at least {ticks}, or one", "forces")
        return np.append(setpoint[:ticks], setpoint[ticks] if setpoint.size > ticks else setpoint[-1])
    if duration_s > setpoint.longest_s:
        raise must_be("duration_s", float(duration_s), f"at most {setpoint.longest_s:g}, as the set-point", "s")
    if (take := sampler(setpoint, tick_hz, 0, 0)) is not None:
        return take(0, ticks)
    assert isinstance(setpoint, Constant | Sine | LogSweep)  # what has no sampler
    return evaluate(setpoint, np.arange(ticks + 1) / tick_hz)


def _points(force_n: Any, most: int) -> np.ndarray:
    try:
        force = np.atleast_1d(np.asarray(force_n, dtype=float))
    except (TypeError, ValueError):
        raise must_be("force_n", type(force_n).__name__, "forces in N") from None
    if force.ndim != 1 or not 1 <= force.size <= most:
        raise must_be("force_n", force.size, f"1 to {most}", "points")
    _in_range(force, "force_n")
    return np.rint(force / N_PER_POINT).astype(np.int16)


def _in_range(force: np.ndarray, name: str, place: str = "point") -> None:
    points = np.rint(force / N_PER_POINT)
    wrong = np.flatnonzero(~((points >= -(2**15)) & (points < 2**15)))
    if wrong.size:
        where = f" at {place} {wrong[0]}" if force.size > 1 else ""
        raise must_be(f"{name}{where}", float(force[wrong[0]]), "-3.2768 to 3.2767", "N")


ALL_TRIGGERS: int = schema()["protocol"]["all_triggers"]


class EffectUpload(NamedTuple):
    """An effect for a device."""

    source: EffectSource
    tables: EffectTables

    @property
    def error_n(self) -> float:
        """Largest difference of its tables from those of the simulator, N."""
        return self.tables.error_n

    def send(self, link: Link) -> None:
        """Write the effect into the copy that waits, and put it in force: the one that plays goes on until then."""
        for _ in self.sending(link):
            pass

    def sending(self, link: Link) -> Iterator[None]:
        """As `send`, with a pause after each frame, for who has to listen to the device meanwhile."""
        return _frames(link, self.tables.words, "effect", 0, 0, 0)


def upload_of(effect: Any, system: System | None, most: int, tick_hz: int) -> EffectUpload | None:
    """Return an effect or an `EffectSource` for a device of so many words; None for anything else."""
    if isinstance(effect, Effect):
        effect = EffectSource(effect=effect)
    if not isinstance(effect, EffectSource):
        return None
    length_mm = system.touch.load.length_mm if system else PLATE_MM
    return EffectUpload(effect, effect_tables(effect, length_mm, tick_hz, most))


def trigger_effect(link: Link, number: Any) -> None:
    """Change over a trigger of the effect that plays; None begins its waves anew."""
    if number is not None and not (isinstance(number, Integral) and 0 <= int(number) < MOST_TRIGGERS):
        raise must_be("number", number, f"0 to {MOST_TRIGGERS - 1}, or None")
    link.ask("trigger", number=ALL_TRIGGERS if number is None else int(number))
