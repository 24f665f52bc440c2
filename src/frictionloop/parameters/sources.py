"""Signals over time: a set-point f_r or a disturbance d is any one of these kinds."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from frictionloop.parameters.block import Block, NotNegative, Number, Positive


class Constant(Block):
    """f(t) = offset."""

    kind: Literal["constant"] = "constant"
    offset_n: Number = 0.0
    """Level of the force."""


class Sine(Block):
    """f(t) = offset + amplitude sin(2 pi frequency t)."""

    kind: Literal["sine"] = "sine"
    offset_n: Number = 0.0
    """Mean of the force."""
    amplitude_n: Number = 0.0
    """Zero-to-peak amplitude."""
    frequency_hz: Positive = 1.0
    """Frequency."""


class LogSweep(Block):
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

    @model_validator(mode="after")
    def _two_frequencies(self) -> Self:
        if self.start_hz == self.stop_hz:
            raise ValueError("start_hz and stop_hz must differ (use kind 'sine' for one frequency)")
        return self


class Steps(Block):
    """f(t) = levels[k] from times[k] on; a step lands on the first control period at or after its time."""

    kind: Literal["steps"] = "steps"
    times_s: tuple[NotNegative, ...] = (0.0,)
    """Start of each level, rising, the first at 0."""
    levels_n: tuple[Number, ...] = (0.0,)
    """Force from that time on."""

    @model_validator(mode="after")
    def _one_level_per_time(self) -> Self:
        if len(self.times_s) != len(self.levels_n) or not self.times_s:
            raise ValueError(
                f"times_s ({len(self.times_s)}) and levels_n ({len(self.levels_n)}) need one level per time"
            )
        if self.times_s[0] != 0 or any(b <= a for a, b in zip(self.times_s, self.times_s[1:], strict=False)):
            raise ValueError("times_s must start at 0 and rise")
        return self


class ColouredNoise(Block):
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

    @model_validator(mode="after")
    def _band(self) -> Self:
        if self.low_hz >= self.high_hz:
            raise ValueError("low_hz must be below high_hz")
        return self


class Recording(Block):
    """f(t) = offset + scale * column(t), linear between the recorded samples; a run past the end is refused."""

    kind: Literal["recording"] = "recording"
    path: str
    """File: .csv, .tsv, .txt, .h5, .hdf5, .nc, .mat or .wav."""
    column: Annotated[str, Field(coerce_numbers_to_str=True)] = "0"
    """Column name or number; for HDF5 and MAT the dataset, with [:, k] for a column of it (``"dataQ[:, 0]"``)."""
    rate_hz: Positive | None = None
    """Sampling rate of the file; a WAV file brings its own."""
    scale: Number = 1.0
    """Newtons per unit of the column."""
    offset_n: Number = 0.0
    """Added after scaling."""
    unit: str = "N"
    """Unit of the column, for the record (scale turns it into newtons)."""
    start_s: NotNegative = 0.0
    """Where in the recording t = 0 lies."""
    stop_s: Positive | None = None
    """Where in the recording to stop (its end if not given)."""
    remove_mean: bool = False
    """Subtract the mean of the part used, so that offset_n alone sets the level."""

    @model_validator(mode="after")
    def _window(self) -> Self:
        if self.stop_s is not None and self.stop_s <= self.start_s:
            raise ValueError("stop_s must be after start_s")
        return self


Source = Annotated[Constant | Sine | LogSweep | Steps | ColouredNoise | Recording, Field(discriminator="kind")]


def largest_n(source: Source) -> float:
    """Return the largest magnitude of a signal in N; of noise and recordings only that of the offset is known."""
    if isinstance(source, Steps):
        return max(abs(level) for level in source.levels_n)
    return abs(source.offset_n) + (abs(source.amplitude_n) if isinstance(source, Sine | LogSweep) else 0.0)
