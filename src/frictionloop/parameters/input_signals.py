"""Signals over time: a set-point f_r or a disturbance d is any one of these kinds, or an array of xarray."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from numbers import Real
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BeforeValidator, Field, model_validator
from pydantic_core import PydanticCustomError

from frictionloop.parameters.block import Kinded, Kinds, NotNegative, Number, Positive
from frictionloop.quantities import must_be
from frictionloop.quantities.timestamp_jitter import uneven_in
from frictionloop.quantities.units import UNITS, known_unit

SLOWEST_S = 0.5
"""Steps of times without a unit from which on they may count, or be in ms (assumed: no force is recorded so slowly)."""
EVEN = 1e-3
"""Deviation of a step of time from the usual one that counts as none, and of two rates that are one, as a share."""


def in_newtons(values: Any) -> Any:
    """Return an array as a list, in N if it says that it is in a unit of force; other things as they are."""
    array = getattr(values, "values", values)
    if not isinstance(array, np.ndarray):
        return values
    unit = getattr(values, "attrs", {}).get("units", "N")
    of, factor = UNITS.get(known_unit(str(unit)) or "", ("", 1.0))
    if of != "N":
        raise must_be("unit", unit, "one of " + ", ".join(name for name, (kind, _) in UNITS.items() if kind == "N"))
    if array.ndim != 1 or array.dtype.kind not in "iuf":
        over = f" over {', '.join(map(repr, values.dims))}" if hasattr(values, "dims") else ""
        raise ValueError(f"{array.dtype} of shape {array.shape}{over}: needs numbers, one dimension")
    return (factor * array).tolist()


def with_rate(values: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the values of ``Samples`` with the rate that the times of a variable tell; others as they are.

    Raises
    ------
    ValueError
        Times that are missing, uneven, of an unknown unit, or contradict a rate that is given.
    """
    array: Any = values.get("values_n")
    given_hz: Any = values.get("rate_hz")
    known = isinstance(given_hz, Real) and float(given_hz) > 0
    if not hasattr(array, "coords") or len(array.dims) != 1:  # of more dimensions `in_newtons` tells
        return values
    if given_hz is not None and (not known or array.dims[0] not in array.coords):
        return values
    rate_hz = _rate_of(array, given_hz)
    if known and abs(given_hz - rate_hz) > EVEN * rate_hz:
        raise must_be("rate_hz", given_hz, f"the array's own, {rate_hz:g}")
    return {**values, "rate_hz": rate_hz}


def _rate_of(array: Any, given_hz: Any) -> float:
    """Return the rate in Hz of the times of a variable over one dimension."""
    (dimension,) = array.dims
    if dimension != "time":
        raise must_be("array: dimension", dimension, "'time'")
    if "time" not in array.coords:
        raise ValueError("an array over 'time' without times: array.assign_coords(time=times_s)")
    time_s = _seconds(array.coords["time"], given_hz)
    if time_s.size < 2:
        raise must_be("array", time_s.size, "at least 2", "samples")
    usual_s = float(np.median(np.diff(time_s)))
    uneven = uneven_in(time_s, abs(usual_s) or 1.0, EVEN)
    if uneven is not None:
        said = uneven.describe(lambda row: f"index {row}: {time_s[row]:g} s")
        raise ValueError(f"{said}; accepted: even steps (most are {usual_s:.4g} s)")
    return float(f"{(time_s.size - 1) / (time_s[-1] - time_s[0]):.9g}")


def _seconds(time: Any, given_hz: Any) -> np.ndarray:
    """Return times of any kind that xarray has in s; a rate that is given settles what they count."""
    times = np.asarray(time)
    if times.dtype.kind in "mM":
        return np.asarray((times - times[:1]) / np.timedelta64(1, "s"), dtype=float)
    if times.dtype.kind not in "iuf":
        raise must_be("times: dtype", str(times.dtype), "numbers, datetime64 or timedelta64")
    said = time.attrs.get("units")
    of, factor = UNITS.get(known_unit(str(said or "s")) or "", ("", 1.0))
    if of != "s":
        raise must_be("times: units", said, "s, ms, us, ns or min")
    step = float(np.median(np.diff(times))) if times.size > 1 else 0.0
    if said is None and step >= SLOWEST_S:
        if given_hz is not None:
            return np.asarray(times / step / given_hz, dtype=float)
        raise ValueError(f'times rise by {step:.6g} without a unit: array.time.attrs["units"]')
    return factor * np.asarray(times, dtype=float)


class Signal(Kinded):
    """A force over time. One from outside is a subclass with a ``kind`` and a function ``force_n(time_s)``."""

    @property
    def longest_s(self) -> float:
        """How long the signal lasts, s; a run past its end is refused."""
        return math.inf

    def force_n(self, time_s: np.ndarray) -> np.ndarray:
        """Return the force in N at times in s, an array of the same shape; of the kinds of this package, `evaluate`."""
        raise NotImplementedError(f"{type(self).__name__}.force_n(time_s) is missing")


class Constant(Signal):
    """f(t) = offset."""

    kind: Literal["constant"] = "constant"
    offset_n: Number = 0.0
    """Level of the force."""


class Sine(Signal):
    """f(t) = offset + amplitude sin(2 pi frequency t)."""

    kind: Literal["sine"] = "sine"
    offset_n: Number = 0.0
    """Mean of the force."""
    amplitude_n: Number = 0.0
    """Zero-to-peak amplitude."""
    frequency_hz: Positive = 1.0
    """Frequency."""


class LogSweep(Signal):
    """f(t) = offset + amplitude sin(2 pi f1 T/L (exp(L t/T) - 1)), L = ln(f2/f1): a sweep of equal time per octave."""

    kind: Literal["log_sweep"] = "log_sweep"
    offset_n: Number = 0.0
    """Mean of the force."""
    amplitude_n: Number = 0.0
    """Zero-to-peak amplitude."""
    start_hz: Positive = 1.0
    """Frequency f1 at t = 0."""
    stop_hz: Positive = 100.0
    """Frequency f2 at t = sweep_s."""
    sweep_s: Positive = 10.0
    """Duration T of the sweep; a run longer than this is refused."""

    @property
    def longest_s(self) -> float:
        """T."""
        return self.sweep_s

    def _check(self) -> None:
        if self.start_hz == self.stop_hz:
            raise ValueError("start_hz and stop_hz must differ")


class Steps(Signal):
    """f(t) = levels[k] from times[k] on; a step lands on the first control period at or after its time."""

    kind: Literal["steps"] = "steps"
    times_s: tuple[NotNegative, ...] = (0.0,)
    """Start of each level, rising, the first at 0."""
    levels_n: tuple[Number, ...] = (0.0,)
    """Force from that time on."""

    def _check(self) -> None:
        if len(self.times_s) != len(self.levels_n) or not self.times_s:
            raise ValueError(
                f"times_s ({len(self.times_s)}) and levels_n ({len(self.levels_n)}) need one level per time"
            )
        if self.times_s[0] != 0 or any(b <= a for a, b in zip(self.times_s, self.times_s[1:], strict=False)):
            raise must_be("times_s", self.times_s, "rising from 0")


class ColouredNoise(Signal):
    """f(t) = offset + rms * n(t), n Gaussian of unit variance with a power spectrum falling as 1/f^exponent."""

    kind: Literal["noise"] = "noise"
    offset_n: Number = 0.0
    """Mean of the force."""
    rms_n: NotNegative = 0.0
    """Standard deviation, over all frequencies up to half the control rate."""
    exponent: Annotated[Number, Field(ge=0, le=2)] = 1.0
    """0 white, 1 pink (friction of a sliding finger, ref. [18]), 2 Brownian."""
    low_hz: Positive = 0.5
    """The spectrum is flat below."""
    high_hz: Positive = 500.0
    """The spectrum falls as 1/f^2 more above."""

    def _check(self) -> None:
        if self.low_hz >= self.high_hz:
            raise ValueError("low_hz must be below high_hz")


class Recording(Signal):
    """f(t) = offset + scale * column(t), linear between samples; the last is held for one of its own periods."""

    kind: Literal["recording"] = "recording"
    path: Annotated[str, BeforeValidator(lambda path: os.fspath(path) if isinstance(path, os.PathLike) else path)]
    """File: .csv, .tsv, .txt, .dat, .asc, .h5, .hdf5, .nc, .mat, .npy, .npz, .wav, .lvm, .tdms, .uff or .unv."""
    column: Annotated[str, Field(coerce_numbers_to_str=True)] = "0"
    """Column name or number; for HDF5, MAT and NPZ the dataset, with [:, k] for a column of it (``"dataQ[:, 0]"``)."""
    rate_hz: Positive | None = None
    """Sampling rate; not needed where the times, an attribute (``fs``, ``dt``, ``sampling_rate``) or a WAV tell it."""
    resample_hz: Positive | None = None
    """Rate to which samples at uneven times are brought, by straight lines between them; at least their mean rate."""
    unit: str | None = None
    """Unit of the column, if the file says none: N, mN, cN, uN, kN, gf, kgf, lbf are scaled, others need ``scale``."""
    scale: Number | None = None
    """Newtons per unit of the column; not needed where the unit is one of force."""
    offset_n: Number = 0.0
    """Added after scaling."""
    decimal: Literal[".", ","] | None = None
    """Decimal mark of a text file, found if not given; with a comma the columns are apart by anything else."""
    start_s: Number | None = None
    """Where in the recording t = 0 lies: a time of its column of times, or s after its first sample where it has none
    or they are dates; its beginning if not given."""
    stop_s: Number | None = None
    """Where in the recording to stop, counted likewise (its end if not given)."""
    rectify: bool | None = None
    """Take the magnitude, |scale * column|, before a mean is removed: of friction whose sign is that of the motion;
    false: the signs are right as they are; not given: as they are, and asked about where they seem those of strokes."""
    remove_mean: bool = False
    """Subtract the mean of the part used, so that offset_n alone sets the level."""

    def _check(self) -> None:
        of, factor = UNITS.get(known_unit(self.unit or "") or "", ("", 1.0))
        if self.scale is not None and of == "N" and not math.isclose(self.scale, factor):
            raise ValueError(f'scale = {self.scale:g} contradicts unit = "{self.unit}", {factor:g} N; give one of them')
        if self.rate_hz is not None and self.resample_hz is not None:
            raise ValueError("rate_hz and resample_hz: give one")
        if self.stop_s is not None and self.start_s is not None and self.stop_s <= self.start_s:
            raise ValueError("stop_s must be after start_s")


class Samples(Signal):
    """f(t) = values[k] at t = k / rate, linear between; the last is held for 1 / rate."""

    kind: Literal["samples"] = "samples"
    values_n: Annotated[tuple[Number, ...], BeforeValidator(in_newtons), Field(min_length=2)]
    """Forces: a list, a NumPy array or an xarray variable of one dimension."""
    rate_hz: Positive
    """Samples per second; not needed of an xarray variable over even ``time``."""

    @model_validator(mode="before")
    @classmethod
    def _rate_of_its_times(cls, values: Any) -> Any:
        return with_rate(values) if isinstance(values, Mapping) else values

    def force_n(self, time_s: np.ndarray) -> np.ndarray:
        """Return the force at times in s."""
        known = np.arange(len(self.values_n)) / self.rate_hz
        return np.interp(time_s, known, self.values_n)

    @property
    def longest_s(self) -> float:
        """Time of the last sample, and one period more, in which it is held."""
        return len(self.values_n) / self.rate_hz


class Sources(Kinds):
    """The kinds of signals; an xarray variable over time is one too."""

    def sampled(self, value: Any) -> Mapping[str, Any]:
        """Return the values of ``Samples`` of an xarray variable over even ``time``."""
        if not isinstance(getattr(value, "values", value), (np.ndarray, list, tuple)):
            return super().sampled(value)
        if not hasattr(value, "coords"):
            text = "an array needs its rate_hz"
            raise PydanticCustomError("array", "{text}", {"text": text})
        return {"kind": "samples", "values_n": value}


SOURCES = Sources(
    Signal, Constant, Sine, LogSweep, Steps, ColouredNoise, Recording, Samples,
    tuned=True, beside={"effect": "frictionloop.rendering.effect_setpoint:EffectSource"},
)  # fmt: skip
Source = Annotated[Signal, SOURCES]


def largest_n(source: Signal) -> float:
    """Return the largest magnitude of a signal in N; of noise and recordings only that of the offset is known.

    Nothing is known of a signal from outside: 0.
    """
    if source.kind == "effect":  # limited to the controller's band, whatever it asks for
        return 0.0
    if isinstance(source, Steps):
        return max(abs(level) for level in source.levels_n)
    if isinstance(source, Samples):
        return max(map(abs, source.values_n))
    known = abs(getattr(source, "offset_n", 0.0))
    return known + (abs(source.amplitude_n) if isinstance(source, Sine | LogSweep) else 0.0)
