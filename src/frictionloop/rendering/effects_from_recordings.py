"""Effects from recordings: textures by place, waves over time, envelopes of vibration, a texture fitted."""

from __future__ import annotations

import os
import struct
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from pydantic import Field

from frictionloop.parameters.block import NotNegative, Number, Positive, Whole
from frictionloop.parameters.input_signals import Recording
from frictionloop.quantities import FrictionloopError, must_be, replacing
from frictionloop.quantities.counter_noise import normals
from frictionloop.quantities.value_checks import ABOVE_0, number, numbers, whole
from frictionloop.quantities.whole_files import json_of
from frictionloop.recordings.force_channel import scaled
from frictionloop.recordings.sampling import resampled
from frictionloop.recordings.wav import COMMENT
from frictionloop.rendering.effect import Effect, Touch
from frictionloop.rendering.force_tables import MOST_CELLS, Map, Wave


def read_texture(recording: Recording, speed_mm_s: float, pitch_mm: float = 0.05) -> Map:
    """Return a recording of a finger that slid at one speed as a map that repeats: x is the speed times the time.

    At another speed its frequencies are those of the place. What this loses: whatever was of the time and not of the
    place (tremor, the finger's own resonance), what changes with speed and load, and the transient at both ends.

    Parameters
    ----------
    recording : Recording
        File and column, with its scale in N; ``offset_n`` and ``remove_mean`` set the level.
    speed_mm_s : float
        Speed at which it was recorded, mm/s.
    pitch_mm : float
        Distance from value to value of the map, mm; the recording is resampled band-limited.

    Raises
    ------
    FrictionloopError
        As ``read_recording``, for a speed or a pitch that is not above 0, and for a recording with no scale.
    """
    speed, pitch = number("speed_mm_s", speed_mm_s, "mm/s", ABOVE_0), number("pitch_mm", pitch_mm, "mm", ABOVE_0)
    force = _read(recording, speed / pitch)
    return Map(values_n=force.tolist(), pitch_mm=pitch, beyond="repeat")


def read_wave(recording: Recording, rate_hz: float) -> Wave:
    """Return a recording as a wave over time, at a rate in Hz.

    Raises
    ------
    FrictionloopError
        As `read_texture`.
    """
    return Wave(values_n=_read(recording, rate_hz).tolist(), rate_hz=rate_hz)


def _read(recording: Recording, rate_hz: float) -> np.ndarray:
    taken = scaled(recording)
    if taken.unit_by == "full scale":
        raise must_be(f"{recording.path}: scale", None, "a number", "N")
    force = resampled(taken.force, taken.rate_hz, rate_hz, recording.path)
    if force.size > MOST_CELLS:
        raise must_be(recording.path, force.size, f"at most {MOST_CELLS}", "values")
    return force


def write_wave(wave: Wave, path: str | os.PathLike[str]) -> None:
    """Write a wave as a WAV of 16 bits that carries its scale; ``read_wave`` gives it back to 1/65534 of its range.

    Raises
    ------
    FrictionloopError
        For what is no wave, a rate that is not whole, or a file that cannot be written.
    """
    if not isinstance(wave, Wave):
        raise must_be("wave", wave, "a Wave")
    if wave.rate_hz != round(wave.rate_hz):
        raise must_be("wave.rate_hz", wave.rate_hz, "whole", "Hz")
    values = np.array(wave.values_n)
    offset = 0.5 * float(values.max() + values.min())
    scale = 0.5 * float(values.max() - values.min()) * 32768 / 32767 or 1.0
    samples = np.round((values - offset) / scale * 32768).astype("<i2").tobytes()
    rate = round(wave.rate_hz)
    comment = COMMENT + f"{scale!r} {offset!r}".encode() + b"\0"
    comment += b"\0" * (len(comment) % 2)
    info = b"INFO" + _chunk(b"ICMT", comment)
    body = _chunk(b"fmt ", struct.pack("<HHIIHH", 1, 1, rate, 2 * rate, 2, 16))
    body += _chunk(b"data", samples) + _chunk(b"LIST", info)
    with replacing(path) as beside:
        beside.write_bytes(_chunk(b"RIFF", b"WAVE" + body))


def _chunk(name: bytes, content: bytes) -> bytes:
    return name + struct.pack("<I", len(content)) + content


TRANSIENT_S = 0.01
"""Duration of a transient, which AHAP leaves to the actuator (assumed)."""


class Carried(NamedTuple):
    """What a file gave, and what of it could not be carried over."""

    wave: Wave
    left: tuple[str, ...]


def read_envelope(path: str | os.PathLike[str], full_n: float, rate_hz: float = 1000.0) -> Carried:
    """Return the envelope of amplitude of a vibration effect as a wave of force.

    Parameters
    ----------
    path : path
        ``.haptic`` or ``.ahap``.
    full_n : float
        Force that the full amplitude stands for, N.
    rate_hz : float
        Values per second of the wave.

    Raises
    ------
    FrictionloopError
        For a file that cannot be read, or that has no envelope.
    """
    tree = json_of(path)
    kind = Path(path).suffix.lower()
    if kind not in (".haptic", ".ahap"):
        raise must_be(f"{path}: format", kind, ".haptic or .ahap")
    try:
        times, levels, left = (_of_haptic if kind == ".haptic" else _of_ahap)(tree)
    except (KeyError, TypeError, ValueError, IndexError) as error:
        raise FrictionloopError(f"{path}: is no {kind} file ({type(error).__name__}: {error})") from None
    if len(times) < 2 or times[-1] <= 0:
        raise FrictionloopError(f"{path}: has no envelope")
    count = int(np.ceil(times[-1] * rate_hz)) + 1
    if count > MOST_CELLS:
        raise FrictionloopError(f"{path}: lasts {times[-1]:g} s; at most {MOST_CELLS / rate_hz:g} s at {rate_hz:g} Hz")
    values = full_n * np.interp(np.arange(max(count, 2)) / rate_hz, times, levels)
    return Carried(Wave(values_n=values.tolist(), rate_hz=rate_hz), tuple(left))


def _of_haptic(tree: Any) -> tuple[list[float], list[float], list[str]]:
    envelopes = tree["signals"]["continuous"]["envelopes"]
    points = envelopes["amplitude"]
    left = ["frequency envelope"] if envelopes.get("frequency") else []
    left += ["emphasis"] if any("emphasis" in point for point in points) else []
    return [float(each["time"]) for each in points], [float(each["amplitude"]) for each in points], left


def _of_ahap(tree: Any) -> tuple[list[float], list[float], list[str]]:
    pieces: list[tuple[float, float, float]] = []
    left: set[str] = set()
    curves: list[tuple[float, float]] = []
    for entry in tree["Pattern"]:
        if "ParameterCurve" in entry:
            curve = entry["ParameterCurve"]
            if curve["ParameterID"] != "HapticIntensityControl":
                left.add(curve["ParameterID"])
                continue
            start = float(curve["Time"])
            curves += [
                (start + float(p["Time"]), float(p["ParameterValue"])) for p in curve["ParameterCurveControlPoints"]
            ]
            continue
        event = entry.get("Event")
        if event is None or event["EventType"] not in ("HapticTransient", "HapticContinuous"):
            left.add(next(iter(entry)) if event is None else event["EventType"])
            continue
        given = {each["ParameterID"]: float(each["ParameterValue"]) for each in event.get("EventParameters", ())}
        left |= given.keys() - {"HapticIntensity"}
        start = float(event["Time"])
        lasts = float(event["EventDuration"]) if event["EventType"] == "HapticContinuous" else TRANSIENT_S
        pieces.append((start, start + lasts, given.get("HapticIntensity", 1.0)))
    edges = sorted({0.0, *(edge for piece in pieces for edge in piece[:2])})
    times = [each for edge in edges for each in (edge, edge + 1e-6)]
    times = sorted({*times, *(time for time, _ in curves)})
    levels = [max((level for start, stop, level in pieces if start < time <= stop), default=0.0) for time in times]
    if curves:
        known, factors = zip(*sorted(curves), strict=True)
        levels = [level * float(np.interp(time, known, factors)) for time, level in zip(times, levels, strict=True)]
    return times, levels, sorted(left)


RESYNTHESIS_STREAM = 31
"""Stream of the counter-based noise that drives it."""


class Resynthesis(Effect):
    """f = offset + n, n[k] = a1 n[k-1] + a2 n[k-2] + ... + noise: the spectrum of a recording, not its waveform.

    Culbertson and others fit such models to tapped and dragged tools (World Haptics 2013); here it runs over place.
    """

    kind: Literal["resynthesis"] = "resynthesis"
    offset_n: Number = 0.45
    """Mean force."""
    coefficients: Annotated[tuple[Number, ...], Field(min_length=1, max_length=64)] = (0.9,)
    """a1, a2, ...; the model must be stable."""
    noise_n: NotNegative = 0.02
    """Standard deviation of the noise."""
    pitch_mm: Positive = 0.1
    """Distance from value to value."""
    values: Annotated[Whole, Field(ge=64, le=32768)] = 2048
    """Values after which it repeats."""
    seed: Annotated[Whole, Field(ge=0, lt=2**31)] = 0
    """The same seed gives the same surface."""

    def _check(self) -> None:
        largest = float(np.max(np.abs(np.roots([1.0, *(-each for each in self.coefficients)])), initial=0.0))
        if not largest < 1.0:
            raise must_be("coefficients: growth per value", largest, "below 1, to be stable")

    @property
    def period_mm(self) -> float | None:
        """The way after which it repeats."""
        return self.values * self.pitch_mm

    def force_of(self, touch: Touch) -> Any:
        """Return the force in N, linear between values."""
        table = _period_of(self.coefficients, self.noise_n, self.values, self.seed)
        u = np.asarray(touch.x_mm, float) / self.pitch_mm
        u = u - self.values * np.floor(u / self.values)
        return self.offset_n + np.interp(u, np.arange(self.values + 1), np.append(table, table[0]))


@lru_cache(maxsize=64)
def _period_of(coefficients: tuple[float, ...], noise_n: float, values: int, seed: int) -> np.ndarray:
    """Return a period of it, by its spectrum: what begins where it ends has no transient."""
    white = np.fft.rfft(normals(seed, RESYNTHESIS_STREAM, 0, values))
    shape = np.fft.rfft(np.concatenate([[1.0], -np.array(coefficients)]), values)
    white[0] = 0.0
    return np.asarray(noise_n * np.fft.irfft(white / shape, values))


def fit_texture(values_n: Any, pitch_mm: float, order: int = 12, seed: int = 0) -> Resynthesis:
    """Return the model of a recording over place: its mean, and the coefficients by the Yule-Walker equations.

    Parameters
    ----------
    values_n
        Forces in N, ``pitch_mm`` apart: of a map from `read_texture`, ``map.values_n[0]``.
    pitch_mm : float
        Distance from value to value, mm.
    order : int
        Number of coefficients, 1 to 64.
    seed : int
        Seed of the surface.

    Raises
    ------
    FrictionloopError
        For fewer values than four times the order, what is no number, or values that do not vary.
    """
    from scipy.linalg import solve_toeplitz

    force = numbers("values_n", values_n, "N").ravel()
    order = whole("order", order, 1, 64)
    if force.size < 4 * order:
        raise must_be("values_n", force.size, f"at least {4 * order}", "values")
    mean = float(force.mean())
    centred = force - mean
    products = np.array([centred[: force.size - lag] @ centred[lag:] for lag in range(order + 1)]) / force.size
    if not products[0] > 1e-18:
        raise FrictionloopError("values_n: must vary")
    coefficients = solve_toeplitz(products[:-1], products[1:])
    noise = float(np.sqrt(max(products[0] - coefficients @ products[1:], 0.0)))
    return Resynthesis(offset_n=mean, coefficients=coefficients.tolist(), noise_n=noise, pitch_mm=pitch_mm, seed=seed)
