"""A project file: which recordings there are of a bench, what each is, and what files do not say of channels."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
import xarray as xr
from pydantic import Field
from scipy.ndimage import shift

from frictionloop.findings import Finding
from frictionloop.parameters.block import Block, NotNegative, Number, Positive, Whole
from frictionloop.parameters.frozen_blocks import Description
from frictionloop.parameters.toml_reader import read_tree
from frictionloop.quantities import Array, must_be
from frictionloop.quantities.units import UNITS, known_unit
from frictionloop.recordings import contents as found
from frictionloop.recordings.channel_excerpt import clock_to_resample
from frictionloop.recordings.contents import Samples
from frictionloop.recordings.sampling import even_times, resampling
from frictionloop.recordings.text_numbers import Decimal

Window = tuple[Number, Number]
USUAL = {"mass": "kg", "frequency": "Hz", "vibration": "um", "envelope": "um", "amplitude": "um", "a": "um"}
USUAL |= {"drive": "", "jump": "V", "answer": "V", "minutes": "min", "temperature": "degC"}
USUAL |= {"position": "m", "speed": "m/s"}
"""Unit of a channel of which nothing is said, by its name; of the others it is N."""


class Channel(Block):
    """One channel: value = sign * scale * (column - its mean over ``zero_s``), after wraps are undone."""

    column: str | Whole = 0
    """Name in the file, as ``frictionloop identify channels`` lists it, or its number from 0.

    In a project file ``name[:, *]`` takes every line of an array, and ``name{*}`` every cell, each as a recording of
    its own; of weights each is what the sensor read under one of the masses."""
    unit: str | None = None
    """Unit of the column, where the file says none or a wrong one: N, mN, V, mV, kg, g, m, mm, m/s, mm/s, counts."""
    scale: Annotated[Number, Field(description="One column unit, in ``gives``.")] | None = None
    gives: str | None = None
    """Unit after ``scale``: N, V, kg, m, um, Hz or counts; left out, what a channel of that name usually has: kg for
    mass, m for position, um for vibration, N for forces."""
    newtons_per_unit: Number | None = None
    """What one unit is in N by an earlier calibration; it counts only where the project has no weights."""
    sign: Annotated[Whole, Field(ge=-1, le=1)] = 1
    """-1 turns the channel round."""
    zero_s: Window | None = None
    """From when to when, in s after the first sample, nothing acted: the mean over it is taken off. Rows of a table
    count as seconds."""
    wrap: Positive | None = None
    """Where a counter starts again from 0, in the column's unit."""
    crosstalk: Annotated[dict[str, Number], Field(default_factory=dict)]
    """What the channel reads of others, by their names: ``{ load = 0.02 }`` takes 0.02 times the load off, after
    scales."""
    delay_s: Number = 0.0
    """How much later than the others the channel was recorded, in s: it is moved forward by this."""


class ChannelMap(Description):
    """The channels of a file by the names that the analyses know: ``f_m``, ``hammer``, ``mass``, ``load`` ..."""

    rate_hz: Positive | None = None
    """Sampling rate in Hz, where the file tells none or two."""
    resample_hz: Positive | None = None
    """Rate in Hz to which channels at uneven times are brought, by straight lines between their samples."""
    decimal: Decimal | None = None
    """Decimal mark of a text, "." or ",", where its numbers can be read in two ways."""
    channels: dict[str, Channel]
    """By name."""


def read_map(source: ChannelMap | Mapping[str, Any] | str | os.PathLike[str]) -> ChannelMap:
    """Return a channel map from itself, from ``{name: {"column": ...}}`` or ``{name: column}``, or from a TOML file.

    Raises
    ------
    FrictionloopError
        For a file that cannot be read, or a field that is unknown or out of range.
    """
    if isinstance(source, ChannelMap):
        return source
    if isinstance(source, Mapping):
        tree = {
            name: entry if isinstance(entry, (Mapping, Channel)) else {"column": entry}
            for name, entry in source.items()
        }
        return ChannelMap.from_tree({"channels": tree}, "channels: ")
    return ChannelMap.from_tree(read_tree(source), f"{source}: ")


class Place(NamedTuple):
    """Where the rows stand that a column is asked for, and how they are taken."""

    first: int
    stop: int
    rate_hz: float
    dim: str
    mapped: bool
    """Whether a map names the column: then it must hold numbers that are not all alike."""


def variable(where: str, name: str, line: found.Channel, told: Channel, place: Place) -> xr.Variable:
    """Return rows of a column unwrapped, less its zero, scaled, turned and moved as the map says."""
    if line.samples.dtype.kind == "c":
        raise must_be(f"{where}: column {line.name!r}", "complex", "samples in time")
    values = np.asarray(line.samples[place.first : place.stop], dtype=float)
    if place.mapped:
        _refuse_no_numbers(where, line, values, place)
    if told.wrap is not None:
        values = np.unwrap(values, period=told.wrap)
    if told.zero_s is not None:
        values = values - _zero(where, name, line.samples, told, place.rate_hz)
    factor, unit = _factor(where, name, line, told, place.mapped)
    values = (told.sign or 1) * factor * values
    if told.delay_s:
        values = shift(values, -told.delay_s * place.rate_hz, order=3, mode="nearest")
    attributes: dict[str, object] = {"units": unit, "long_name": line.name}
    if told.newtons_per_unit is not None:
        attributes["newtons_per_unit"] = told.newtons_per_unit
    return xr.Variable(place.dim, values, attributes)


def _refuse_no_numbers(where: str, line: found.Channel, values: Array, place: Place) -> None:
    bad = np.flatnonzero(~np.isfinite(values))
    if bad.size:
        row = place.first + int(bad[0])
        accepted = f"a number; {bad.size} are none"
        raise must_be(f"{where}: column {line.name!r} at row {row}", float(values[bad[0]]), accepted, "", "DATA-GAPS")
    if line.samples.size == values.size > 1 and np.ptp(values) == 0:
        raise must_be(f"{where}: column {line.name!r}", f"{values[0]:g} throughout", "one that varies")


def _zero(where: str, name: str, samples: Samples, told: Channel, rate_hz: float) -> float:
    window = told.zero_s or (0.0, 0.0)
    first, stop = round(window[0] * rate_hz), round(window[1] * rate_hz)
    if not 0 <= first < stop <= samples.size:
        accepted = f"rising within 0 to {samples.size / rate_hz:g}"
        raise must_be(f"{where}: channels.{name}.zero_s", window, accepted, "s")
    values = np.asarray(samples[first:stop], dtype=float)
    return float(values.mean() if told.wrap is None else np.unwrap(values, period=told.wrap).mean())


def _factor(where: str, name: str, line: found.Channel, told: Channel, mapped: bool) -> tuple[float, str]:
    """Return what a column is multiplied by, and the unit that this gives."""
    stated = told.unit or line.unit
    base = UNITS.get(known_unit(stated or "") or "")
    if told.scale is not None:
        return told.scale, told.gives or USUAL.get(name, "N")
    if base is not None:
        if told.gives is not None and told.gives != base[0]:
            raise must_be(f"{where}: channels.{name}.gives", told.gives, f"{base[0]}, or with a scale")
        return base[1], base[0]
    if told.gives is not None or not mapped:
        return 1.0, told.gives or stated or ""
    # A channel of which nothing is said is in the unit of its kind; counts and the like are kept as they are.
    return 1.0, stated or USUAL.get(name, "N")


def resampled(
    where: str, picked: Mapping[str, found.Channel], chart: ChannelMap, resample_hz: float
) -> tuple[dict[str, found.Channel], Finding]:
    """Return channels at even times, as `recordings.sampling` has them, and what was done.

    A counter is unwrapped first.
    """
    lines, even_s = dict[str, found.Channel](), np.zeros(0)
    for name, line in picked.items():
        at_s = clock_to_resample(where, line.times, resample_hz)[1].at_s
        even_s = even_s if lines else even_times(where, at_s, resample_hz)
        values = np.asarray(line.samples[: line.samples.size], dtype=float)
        if (wrap := chart.channels[name].wrap) is not None:
            values = np.unwrap(values, period=wrap)
        lines[name] = replace(line, samples=np.interp(even_s, at_s, values))
    return lines, resampling(at_s, resample_hz)


OfSensors = Literal["weights", "hits", "response", "quiet", "load", "position"]


class Take(Block):
    """Recordings of one kind, which are one measurement."""

    kind: Literal[OfSensors, "scale", "plate", "carrier", "delay", "slides", "amplitude"]
    """What was done: known weights on the force sensor, hits (of a hammer that measures or of a pen), a frequency
    response that is listed (of a stepped sine), nothing; weights on the load cells, a known way, drives under a
    vibrometer, a stepped sine or a switched plate, a resonance over time, known jumps; slides of a finger on the still
    plate, and under amplitude commands."""
    files: Annotated[tuple[str, ...], Field(min_length=1)]
    """Paths, as seen from the project file."""
    map: str | None = None
    """TOML file with a channel map; or write ``channels`` here."""
    channels: dict[str, Channel] | None = None
    """By the names that each kind asks for (docs/calibration): f_m, mass, hammer, load, position or speed, reading,
    drive, frequency, vibration, envelope, amplitude, jump, answer."""
    rate_hz: Positive | None = None
    """Sampling rate, where the files tell none or two."""
    resample_hz: Positive | None = None
    """Rate to which recordings at uneven times are brought, by straight lines between their samples."""
    decimal: Decimal | None = None
    """Decimal mark of texts, where their numbers can be read in two ways."""
    date: str | None = None
    """When it was recorded, where the files do not say."""
    masses_g: tuple[NotNegative, ...] | None = None
    """Weights: masses in g, one for each file or each line of ``name[:, *]``, where no channel tells them."""
    settle_s: NotNegative = 1.0
    """Weights: time left out after each change."""
    gravity_m_s2: Positive | None = None
    """Weights: gravity at the bench; left out, the standard value, whose doubt is then in the interval."""
    tolerance: Annotated[Number, Field(ge=0, lt=1)] = 0.0
    """Weights: their relative tolerance."""
    mode: Literal["first", "strongest"] = "first"
    """Hits and response: which mode is the sensor's resonance."""
    count: Annotated[Whole, Field(ge=1, le=8)] | None = None
    """Hits and response: how many modes to list in the certificate, from the lowest up."""
    band_hz: Window | None = None
    """Hits and response: between which frequencies it lies."""
    segment_s: Positive | None = None
    """Hits: length of a piece; left out, as the hits allow."""
    exclude: tuple[Whole, ...] = ()
    """Hits: numbers of those to leave out."""
    interval_s: Window | None = None
    """Quiet, slides: from when to when, s after the first sample; left out, the longest quiet stretch, or all."""
    full_drive: Positive | None = None
    """Scale: the drive at its largest, in the unit of the channel; gives the largest amplitude."""
    frequency_hz: Positive | None = None
    """Scale: frequency of the vibration, where the vibrometer gives its velocity."""
    control_hz: Positive | None = None
    """Delay: control rate."""
    waits: bool = True
    """Delay: whether jumps come at any time of a control period."""
    plate_hz: Positive | None = None
    """Amplitude: cutoff of the plate's envelope, where the channel is a command and not a measurement."""
    finger: str | None = None
    """Slides, amplitude: whose finger; several make a population."""

    def chart(self, folder: Path) -> ChannelMap | None:
        """Return the channel map, None if the files name their columns as the analyses do."""
        if self.channels is not None:
            return ChannelMap(channels=self.channels, **self.reading)
        return None if self.map is None else read_map(folder / self.map).evolve(self.reading)

    @property
    def reading(self) -> dict[str, Any]:
        """What is given of how files are read."""
        given = {"rate_hz": self.rate_hz, "resample_hz": self.resample_hz, "decimal": self.decimal}
        return {name: value for name, value in given.items() if value is not None}


class Converter(Block):
    """The converter behind the sensor, by its data sheet."""

    bits: Annotated[Whole, Field(ge=1, le=32)]
    """Bits that do not flicker."""
    full_scale: Positive
    """It spans +- this, in the unit of the reading."""


class Project(Description):
    """The recordings of a bench."""

    preset: Literal["bench"] = "bench"
    """What everything that was not measured is taken from."""
    recording: Annotated[tuple[Take, ...], Field(min_length=1)]
    """The measurements."""
    converter: Converter | None = None
    """Known rather than measured."""
    known: Annotated[dict[str, float], Field(default_factory=dict)]
    """Values known from elsewhere (a scale, a data sheet), by their dotted names in the System."""


def read_project(path: str | os.PathLike[str]) -> Project:
    """Return the project that a TOML file describes."""
    project = Project.from_tree(read_tree(path), f"{path}: ")
    for take in project.recording:
        for name in take.files:
            if not (Path(path).parent / name).is_file():
                raise must_be(f"{path}: {take.kind}", name, "a file beside it")
    return project
