"""Force to reading over frequency: H1 and coherence from hits of a hammer, or a table of another program."""

from __future__ import annotations

import os
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from frictionloop.findings import Condition, Finding
from frictionloop.identification.hits import hits_of, too_few
from frictionloop.identification.onsets import without_bow
from frictionloop.identification.recording_columns import READING, READING_UNITS, channel, rate_of
from frictionloop.identification.recording_file import Opened, Run
from frictionloop.quantities import must_be

UNKNOWN_SHARE = 0.01
"""Share of its size that a value of a table is taken to be off by where no coherence stands beside it (assumed)."""
LEAST = 8
"""Frequencies that a table must have."""
_NAMES = "frequency, and response or magnitude"

Array = NDArray[np.float64]


@dataclass(frozen=True)
class FrequencyResponse:
    """An estimate over frequency; all arrays have one shape."""

    frequency_hz: Array
    response: NDArray[np.complex128]
    """Reading over force, ``unit``."""
    coherence: Array
    """Share of the reading's power that follows from the force, 0 to 1."""
    relative_error: Array
    """Standard error of |response| over |response|, sqrt((1 - coherence)/(2 n coherence))."""
    input_density: Array
    """Power density of the force: how well each frequency was excited."""
    hits: int
    rate_hz: float
    unit: str
    findings: tuple[Finding, ...] = ()
    """Which channels are turned round."""

    def drawn(self, rows: Any = slice(None)) -> dict[str, list[float]]:
        """Return what is drawn of some of its rows."""
        curves = {"frequency_hz": self.frequency_hz, "magnitude": np.abs(self.response), "coherence": self.coherence}
        return {name: each[rows].tolist() for name, each in curves.items()}


def response(
    recording: Run | Sequence[Run],
    segment_s: float = 0.5,
    exclude: Collection[int] = (),
) -> FrequencyResponse:
    """Return force to reading over frequency and the coherence, averaged over the good hits of a hammer (`pick_hits`).

        H1 = S_xy/S_xx,   coherence = |S_xy|^2/(S_xx S_yy)

    The pieces are not tapered: force and response begin and end within them, so nothing leaks.
    Noise of the reading does not bias H1; noise of the hammer lowers it by its share of S_xx. H2, of which the opposite
    holds, is H1 over the coherence. A hammer that reads a push as negative is turned, and a recording whose reading
    goes the other way than most.

    Parameters
    ----------
    recording : xarray.Dataset or sequence of them
        Columns ``hammer`` in N and ``f_m`` in N, V or counts, over ``time`` in s; several at one rate are one
        measurement.
    segment_s : float
        Length of a piece in s; its inverse is the distance between frequencies. The response must have decayed.
    exclude : collection of int
        Numbers of hits to leave out, of one recording.

    Raises
    ------
    FrictionloopError
        For a column that is missing or has another unit, or fewer than two good hits.

    Notes
    -----
    Source: Bendat and Piersol, Random Data, 4th ed., Sec. 9.2 for the standard error (ours: n hits, one segment each).
    """
    if isinstance(recording, xr.Dataset):
        channel(recording, "hammer", ("N",))  # hits are found without one, too; a response is not
    forces, readings, rates, picked, names, unit = [], [], [], [], [], ""
    for run, found in hits_of(recording, segment_s, exclude):
        force, reading = channel(run, "hammer", ("N",)), channel(run, READING, READING_UNITS)
        rows = np.array(found.starts, dtype=int)[:, None] + np.arange(found.length)
        forces.append((-force if found.inverted else force)[rows])
        readings.append(without_bow(reading)[0][rows])
        rates.append(rate_of(run))
        picked.append(found)
        names.append(os.path.basename(run.attrs.get("file", "")) or f"recording {len(picked)}")
        unit = f"{run[READING].attrs['units']}/N"
    if len(set(rates)) > 1:
        raise must_be("recording: rates", sorted(set(rates)), "one", "Hz")
    hits = sum(len(force) for force in forces)
    if hits < 2:
        raise too_few(picked, hits)
    rate_hz, length = rates[0], forces[0].shape[1]
    x, y = ([np.fft.rfft(each - each.mean(axis=1, keepdims=True)) for each in some] for some in (forces, readings))
    crossed = [force.conj() * reading for force, reading in zip(x, y, strict=True)]

    def density(parts: list[Any]) -> Any:
        return np.concatenate(parts).mean(axis=0) * 2 / (rate_hz * length)

    frequency = np.fft.rfftfreq(length, 1 / rate_hz)
    of_force, of_reading = (density([np.abs(each) ** 2 for each in some]) for some in (x, y))
    # Well below the largest reading it follows the force, whatever modes there are.
    upto = (frequency > 0) & (frequency <= 0.5 * frequency[np.argmax(of_reading)])
    signs = [float(np.sign(np.sum(each.real[:, upto]))) for each in crossed]
    other = -1.0 if sum(signs) >= 0 else 1.0
    across = density([-each if sign == other else each for each, sign in zip(crossed, signs, strict=True)])
    static = float(np.sum(across.real[upto]) / max(float(np.sum(of_force[upto])), 1e-300))
    doubts = [
        _turned_round(min(hit.peak for hit in each.table), "N", name, "hammer")
        for name, each in zip(names, picked, strict=True)
        if each.inverted
    ]
    doubts += [
        _turned_round(-abs(static), unit, name) for name, sign in zip(names, signs, strict=True) if sign == other
    ]
    doubts += [_turned_round(static, unit, "", "f_m or hammer")] if static < 0 else []
    keep = (frequency > 0) & (of_force > 0) & (of_reading > 0) & (np.abs(across) > 0)
    across, of_force = across[keep], of_force[keep]
    coherence = np.clip(np.abs(across) ** 2 / (of_force * of_reading[keep]), 1e-300, 1.0)
    return FrequencyResponse(
        frequency_hz=frequency[keep],
        response=across / of_force,
        coherence=coherence,
        relative_error=np.sqrt((1 - coherence) / (2 * hits * coherence)),
        input_density=of_force,
        hits=hits,
        rate_hz=rate_hz,
        unit=unit,
        findings=tuple(doubts),
    )


def _turned_round(low: float, unit: str, recording: str, channel: str = "") -> Finding:
    where = Condition(recording=recording, channel=channel)
    return Finding("SIGN-DOUBT", unit=unit, where=where, remedy="sign = -1", more={"low": low, "high": 0.0})


def response_table(file: Opened) -> FrequencyResponse:
    """Return the response that a file lists over frequency.

    Parameters
    ----------
    file : Opened
        Channels ``frequency`` in Hz, and ``response`` (complex), ``real`` and ``imaginary``, or ``magnitude`` and
        ``phase_deg`` or ``phase_rad``; a ``coherence`` is used if it is there. A magnitude in dB is 20 log10 of it.
        Rows of one frequency are averaged, and their order does not matter. Without a phase the response is real and
        its fit goes by magnitude.

    Raises
    ------
    FrictionloopError
        For columns that are missing, fewer than eight frequencies, or values that are no numbers.
    """
    columns = {name: np.asarray(line.samples[:]) for name, line in file.picked.items()}
    if "frequency" not in columns:
        raise must_be(f"{file.where}: channels", ", ".join(columns), _NAMES)
    sizes = {name: values.size for name, values in columns.items()}
    if len(set(sizes.values())) > 1:
        raise must_be(f"{file.where}: samples of columns", sizes, "equal")
    hertz = np.asarray(columns["frequency"], dtype=float)
    values = _complex(file, columns)
    coherence = np.asarray(columns.get("coherence", np.full(hertz.size, np.nan)), dtype=float)
    fine = np.isfinite(hertz) & np.isfinite(values) & (hertz > 0)
    steps, place = np.unique(hertz[fine], return_inverse=True)
    if steps.size < LEAST:
        raise must_be(f"{file.where}: frequencies", int(steps.size), f"at least {LEAST}")
    count = np.bincount(place)
    total = np.bincount(place, values[fine].real) + 1j * np.bincount(place, values[fine].imag)
    mean = (total / count).astype(complex)
    shared = np.bincount(place, np.nan_to_num(coherence[fine], nan=1 / (1 + 2 * UNKNOWN_SHARE**2))) / count
    shared = np.clip(shared, 1e-6, 1.0)
    # No rate is told: the highest frequency stands for half of one.
    told = file.picked["magnitude" if "magnitude" in columns else "frequency"].unit
    return FrequencyResponse(
        steps, mean, shared, np.sqrt((1 - shared) / (2 * shared)), np.ones_like(steps), int(count.max()),
        2 * float(steps[-1]), told if "magnitude" in columns and told else "1",
    )  # fmt: skip


def has_phase(found: FrequencyResponse) -> bool:
    """Return whether a response is more than its magnitude."""
    return bool(np.any(np.abs(found.response.imag) > 0))


def _complex(file: Opened, columns: dict[str, NDArray[np.generic]]) -> NDArray[np.complex128]:
    if "response" in columns:
        return columns["response"].astype(complex)
    if "real" in columns and "imaginary" in columns:
        return np.asarray(columns["real"], dtype=float) + 1j * np.asarray(columns["imaginary"], dtype=float)
    if "magnitude" not in columns:
        raise must_be(f"{file.where}: channels", ", ".join(columns), _NAMES)
    size = np.asarray(columns["magnitude"], dtype=float)
    if _in_db(file):
        size = 10 ** (size / 20)
    if np.nanmin(size) < 0:
        raise must_be(f"{file.where}: magnitude", float(np.nanmin(size)), "0 or more, or dB")
    turn = np.zeros_like(size)
    if "phase_deg" in columns:
        turn = np.deg2rad(np.asarray(columns["phase_deg"], dtype=float))
    elif "phase_rad" in columns:
        turn = np.asarray(columns["phase_rad"], dtype=float)
    scale = file.chart.channels["magnitude"].scale or 1.0
    return np.asarray(scale * size * np.exp(1j * turn))


def _in_db(file: Opened) -> bool:
    line = file.picked["magnitude"]
    said = file.chart.channels["magnitude"].unit or line.unit or line.name.rpartition(" ")[2]
    return said.strip("[]() ").lower() == "db"
