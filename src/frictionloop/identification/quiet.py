"""A quiet stretch of the sensor: where it is, its density, lines, rms by band, and whether a filter was there."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.findings import Finding
from frictionloop.identification.estimate import Estimate, measured
from frictionloop.identification.hit_onsets import quiet_noise
from frictionloop.identification.noise_density import (
    NoiseSpectrum,
    Spur,
    band_rms,
    converter_step,
    density_of,
    low_passed,
    noise_spectrum,
    spurs_of,
)
from frictionloop.identification.project_entry_result import (
    EntryResult,
    Rows,
    Sensor,
    in_newtons,
    log_rows,
    with_method,
)
from frictionloop.identification.project_file import Take
from frictionloop.identification.recording_columns import READING, READING_UNITS, channel, rate_of, runs_of
from frictionloop.quantities import Array, must_be

BANDS_HZ = (1.0, 10.0, 100.0, 1000.0, 10000.0)
LOUD = 2.0
"""A piece is quiet if its rms is below so many times that of the quietest quarter (assumed)."""
PIECE_S, SHORTEST_S = 0.1, 1.0


@dataclass(frozen=True)
class Quiet:
    """What a sensor reads while nothing happens."""

    density: Estimate
    """Of the electronics before their low-pass, N/rtHz."""
    band_hz: tuple[float, float]
    """Band in which it was taken."""
    other_density_n_rthz: float
    """The same in the upper half of the band: how much the method matters."""
    rms_n: dict[str, float]
    """By band."""
    spurs: tuple[Spur, ...]
    step_n: float
    """Least step of the reading, the converter's, 0 if there is none."""
    filtered: bool
    interval_s: tuple[float, float]
    spectrum: NoiseSpectrum
    findings: tuple[Finding, ...]


def noise(
    recording: xr.Dataset,
    interval_s: tuple[float, float] | None = None,
    sensitivity: float = 1.0,
    resonance_hz: float | None = None,
    cutoff_hz: float | None = None,
) -> Quiet:
    """Return the noise of a sensor from a recording in which nothing touches it.

    The density is that of the electronics: the mean power over a band that the vibration of the base does not reach,
    spurs left out, less the converter's step^2/12 over half the rate, over what the pole leaves of white noise. The
    band is from three times the resonance to twice the cutoff (the base is isolated there), or from 20 Hz where no
    resonance is told.

    Parameters
    ----------
    recording : xarray.Dataset
        Column ``f_m`` in N, V or counts over ``time`` in s.
    interval_s : tuple, optional
        From when to when it is quiet; None looks for the longest such stretch.
    sensitivity : float
        Unit of the reading per N, from `weights`.
    resonance_hz, cutoff_hz : float, optional
        Of the sensor, in Hz.

    Raises
    ------
    FrictionloopError
        For a column that is missing or has another unit, or no second of quiet.
    """
    reading, rate_hz = channel(recording, READING, READING_UNITS) / sensitivity, rate_of(recording)
    began_s = float(recording["time"][0])
    if interval_s is None:
        first, stop = quiet_stretch(reading, rate_hz)
    else:
        first, stop = given_stretch((interval_s[0] - began_s, interval_s[1] - began_s), reading.size, rate_hz)
    force = reading[first:stop]
    time = xr.Variable("time", np.arange(force.size) / rate_hz, {"units": "s"})
    still = xr.Dataset({READING: ("time", force, {"units": "N"})}, {"time": time})
    spectrum = noise_spectrum(still, min(1.0, force.size / rate_hz / 8))
    spurs, clean = spurs_of(spectrum)
    top = min(0.4 * rate_hz, 2 * cutoff_hz if cutoff_hz else math.inf)
    isolated = resonance_hz is not None and 4 * resonance_hz < top
    low = 3 * resonance_hz if isolated and resonance_hz else 20.0
    step = converter_step(force)
    density = density_of(spectrum, clean, (low, top), cutoff_hz, step)
    upper = density_of(spectrum, clean, (math.sqrt(low * top), top), cutoff_hz, step)
    filtered = low_passed(spectrum)
    coarse = bool(step and np.std(force) < 0.6 * step)
    also = {"the base": not isolated, "a low-pass of the file": filtered, "converter steps": coarse}
    doubts = [
        Finding("NOISE-DOUBT", more={"low": low, "high": top, "what": what}) for what, is_so in also.items() if is_so
    ]
    edges = [edge for edge in BANDS_HZ if edge < rate_hz / 2] + [rate_hz / 2]
    hertz = spectrum.frequency_hz
    bands = [(a, b) for a, b in pairwise(edges) if np.count_nonzero((hertz >= a) & (hertz <= b)) >= 4]
    rms = {f"{a:g} to {b:g} Hz": band_rms(spectrum, a, b).value for a, b in bands}
    return Quiet(
        density, (low, top), upper.value, rms, tuple(spurs), step, filtered,
        (began_s + first / rate_hz, began_s + stop / rate_hz), spectrum, tuple(doubts),
    )  # fmt: skip


def quiet_entry(take: Take, runs: Sequence[xr.Dataset], sensor: Sensor) -> EntryResult:
    """Return the density of the electronics."""
    scaled, doubts = in_newtons(runs, sensor)

    def at(cutoff_hz: float | None) -> list[Quiet]:
        return [noise(run, _there(run, take.interval_s), 1.0, sensor.resonance_hz, cutoff_hz) for run in scaled]

    found = at(sensor.cutoff_hz)
    off = at(sensor.cutoff_hz + sensor.cutoff_error_hz) if sensor.cutoff_hz else found
    shifts = [
        with_method(moved.density.value - each.density.value, each.other_density_n_rthz - each.density.value)
        for each, moved in zip(found, off, strict=True)
    ]
    first = found[0]
    (low, high), (start, stop) = first.band_hz, first.interval_s
    how = f"density {low:.0f} to {high:.0f} Hz, {start:.1f} to {stop:.1f} s"
    value = measured("sensor.noise_density_n_rthz", [each.density for each in found], shifts, how)
    rows: Rows = [("band", "rms (N)"), *((band, f"{rms:.3g}") for band, rms in first.rms_n.items())]
    doubts += [each for one in found for each in one.findings]
    numbers: dict[str, Any] = {"lines_hz": [s.frequency_hz for s in first.spurs[:5]]} if first.spurs else {}
    numbers |= {"lines_rms_n": [s.rms_n for s in first.spurs[:5]]} if first.spurs else {}
    if first.step_n:
        numbers |= {"converter_step_n": first.step_n, "density_counts_rthz": value.value / first.step_n}
    hertz, density = first.spectrum.frequency_hz, first.spectrum.density
    seen = log_rows(hertz)
    curves: dict[str, Any] = {"frequency_hz": hertz[seen].tolist(), "density": density[seen].tolist()}
    curves |= {"band_hz": first.band_hz, "level": value.value}
    rms = list(first.rms_n.values())
    if rms:
        bands = [*first.rms_n]
        said = f"{bands[0].partition(' ')[0]} to {bands[-1].rpartition('to ')[2]}"
        curves["floor"] = {"rms_n": float(np.linalg.norm(rms)), "band": said}
    return EntryResult([value], doubts, numbers, rows, curves)


def _there(run: xr.Dataset, interval_s: tuple[float, float] | None) -> tuple[float, float] | None:
    """Return as much of an interval as was read of a long recording."""
    if interval_s is None or not float(run["time"][0]):
        return interval_s
    return float(run["time"][0]), min(interval_s[1], float(run["time"][-1]))


def given_stretch(interval_s: tuple[float, float], size: int, rate_hz: float) -> tuple[int, int]:
    """Return the rows of a stretch that is given in s."""
    first, stop = (round(end * rate_hz) for end in interval_s)
    if not (0 <= first < stop <= size and (stop - first) >= SHORTEST_S * rate_hz):
        raise must_be("interval_s", tuple(interval_s), f"1 long within 0 to {size / rate_hz:g}", "s")
    return first, stop


def quiet_stretch(reading: Array, rate_hz: float) -> tuple[int, int]:
    """Return the longest stretch of pieces that are as quiet as the quietest quarter."""
    length = max(round(PIECE_S * rate_hz), 8)
    pieces = reading.size // length
    if pieces * length < SHORTEST_S * rate_hz:
        raise must_be("recording: duration", reading.size / rate_hz, "1 or more", "s")
    cut = reading[: pieces * length].reshape(pieces, length)
    limit = LOUD * max(quiet_noise(reading), float(np.median(np.sort(cut.std(axis=1))[: max(pieces // 4, 1)])))
    limit = max(limit, converter_step(reading))  # a reading that hardly leaves one step is quiet
    calm = cut.std(axis=1) <= limit
    first, stop = max(runs_of(calm), key=lambda run: run[1] - run[0])
    if (stop - first) * length < SHORTEST_S * rate_hz:
        raise must_be("recording: longest quiet stretch", (stop - first) * length / rate_hz, "1 or more", "s")
    return first * length, stop * length
