"""Force to reading over frequency, from hits of a hammer: H1, H2, Hv and coherence."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple, get_args

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.signal import csd

from frictionloop.identification.hits import Hits, hits_of, too_few
from frictionloop.identification.long import Run
from frictionloop.identification.onsets import without_bow
from frictionloop.identification.recording_columns import READING, READING_UNITS, channel, rate_of
from frictionloop.quantities import must_be

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


Estimator = Literal["H1", "H2", "Hv"]


def response(
    recording: Run | Sequence[Run],
    segment_s: float = 0.5,
    estimator: Estimator = "H1",
    exclude: Collection[int] = (),
) -> FrequencyResponse:
    """Return force to reading over frequency and the coherence, averaged over the good hits of a hammer (`pick_hits`).

        H1 = S_xy/S_xx,   H2 = S_yy/S_yx,   Hv = sqrt(H1 H2),   coherence = |S_xy|^2/(S_xx S_yy) = H1/H2

    The pieces are not tapered (csd with a boxcar): force and response begin and end within them, so nothing leaks.
    Noise of the reading does not bias H1; noise of the hammer lowers it by its share of S_xx. With H2 it is the other
    way round. A hammer that reads a push as negative is turned.

    Parameters
    ----------
    recording : xarray.Dataset or sequence of them
        Columns ``hammer`` in N and ``f_m`` in N, V or counts, over ``time`` in s; several at one rate are one
        measurement.
    segment_s : float
        Length of a piece in s; its inverse is the distance between frequencies. The response must have decayed.
    estimator : str
        "H1", "H2" or "Hv".
    exclude : collection of int
        Numbers of hits to leave out, of one recording.

    Raises
    ------
    FrictionloopError
        For a column that is missing or has another unit, fewer than two good hits, or another estimator.

    Notes
    -----
    Source: Bendat and Piersol, Random Data, 4th ed., Sec. 9.2 for the standard error (ours: n hits, one segment each);
    Rocklin, Crowley and Vold, IMAC 1985, for Hv.
    """
    if estimator not in get_args(Estimator):
        raise must_be("estimator", estimator, "'H1', 'H2' or 'Hv'")
    if isinstance(recording, xr.Dataset):
        channel(recording, "hammer", ("N",))  # hits are found without one, too; a response is not
    cut = [_pieces(run, found) for run, found in hits_of(recording, segment_s, exclude)]
    if len({piece.rate_hz for piece in cut}) > 1:
        raise must_be("recording: rates", sorted({piece.rate_hz for piece in cut}), "one", "Hz")
    hits = sum(len(piece.force) for piece in cut)
    if hits < 2:
        raise too_few([piece.found for piece in cut], hits)
    x, y = (np.concatenate(parts) for parts in ([piece.force for piece in cut], [piece.reading for piece in cut]))
    rate_hz, length = cut[0].rate_hz, x.shape[1]

    def density(one: Array, other: Array) -> tuple[Array, NDArray[np.complex128]]:
        options = {"window": "boxcar", "nperseg": length, "noverlap": 0, "detrend": "constant"}
        return csd(one.ravel(), other.ravel(), rate_hz, **options)

    frequency, across = density(x, y)
    of_force, of_reading = density(x, x)[1].real, density(y, y)[1].real
    keep = (frequency > 0) & (of_force > 0) & (of_reading > 0) & (np.abs(across) > 0)
    across, of_force = across[keep], of_force[keep]
    coherence = np.clip(np.abs(across) ** 2 / (of_force * of_reading[keep]), 1e-300, 1.0)
    power = {"H1": 0.0, "H2": 1.0, "Hv": 0.5}[estimator]
    return FrequencyResponse(
        frequency_hz=frequency[keep],
        response=across / of_force / coherence**power,
        coherence=coherence,
        relative_error=np.sqrt((1 - coherence) / (2 * hits * coherence)),
        input_density=of_force,
        hits=hits,
        rate_hz=rate_hz,
        unit=cut[0].unit,
    )


class _Pieces(NamedTuple):
    """The good hits of a recording, cut out: arrays of shape (hits, rows)."""

    force: Array
    reading: Array
    rate_hz: float
    found: Hits
    unit: str


def _pieces(run: xr.Dataset, found: Hits) -> _Pieces:
    force, reading = channel(run, "hammer", ("N",)), channel(run, READING, READING_UNITS)
    rows = np.array(found.starts, dtype=int)[:, None] + np.arange(found.length)
    return _Pieces(
        (-force if found.inverted else force)[rows],
        without_bow(reading)[0][rows],
        rate_of(run),
        found,
        f"{run[READING].attrs['units']}/N",
    )
