"""A project file: which recordings there are of a bench, and what each of them is."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field

from frictionloop.identification.channel_map import Channel, ChannelMap, Window, read_map
from frictionloop.parameters.block import Block, NotNegative, Number, Positive, Whole
from frictionloop.parameters.description import Description
from frictionloop.parameters.toml_files import read_tree
from frictionloop.quantities import must_be
from frictionloop.recordings.text_numbers import Decimal


class Take(Block):
    """Recordings of one kind, which are one measurement."""

    kind: Literal[
        "weights",
        "hits",
        "response",
        "quiet",
        "load",
        "position",
        "scale",
        "plate",
        "carrier",
        "delay",
        "slides",
        "amplitude",
    ]
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
