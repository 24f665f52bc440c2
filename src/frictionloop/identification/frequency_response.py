"""Force to reading over frequency, from hits of a hammer: H1 and coherence."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.signal import csd

from frictionloop.identification.channels import READING, READING_UNITS, channel, pieces, rate_of, samples_in
from frictionloop.quantities import FrictionloopError

Array = NDArray[np.float64]
TRIGGER = 0.2
"""A hit begins where the hammer passes this share of its largest force."""


@dataclass(frozen=True)
class FrequencyResponse:
    """An H1 estimate over frequency; all arrays have one shape."""

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


def frequency_response(recording: xr.Dataset, segment_s: float = 0.5) -> FrequencyResponse:
    """Return H1 = S_xy/S_xx and coherence |S_xy|^2/(S_xx S_yy), averaged over the hits of a hammer.

    Each hit is cut out with a tenth of ``segment_s`` before it. The pieces are not tapered (csd with a boxcar): force
    and response begin and end within them, so nothing leaks. Noise of the reading does not bias H1; noise of the
    hammer lowers it by its share of S_xx.

    Parameters
    ----------
    recording : xarray.Dataset
        Columns ``hammer`` in N and ``f_m`` in N, V or counts, over ``time`` in s.
    segment_s : float
        Length of a piece in s; its inverse is the distance between frequencies. The response must have decayed.

    Raises
    ------
    FrictionloopError
        For a column that is missing or has another unit, fewer than two hits, or a response cut off before it has
        decayed.

    Notes
    -----
    Source: Bendat and Piersol, Random Data, 4th ed., Sec. 9.2 for the standard error (ours: n hits, one segment each).
    """
    force = channel(recording, "hammer", ("N",))
    reading = channel(recording, READING, READING_UNITS)
    rate_hz = rate_of(recording)
    length = samples_in("segment_s", segment_s, rate_hz, 16, force.size, "the length of the recording")
    still = force - np.median(force)
    starts = pieces(still > TRIGGER * still.max(), length, length // 10)
    if len(starts) < 2:
        raise FrictionloopError(
            f"recording: 'hammer' has {len(starts)} hits with segment_s = {segment_s:g} s around them: "
            "must have at least two"
        )
    x, y = (np.stack([column[k : k + length] for k in starts]) for column in (force, reading))
    _refuse_cut(y, length // 10, segment_s)

    def density(one: Array, other: Array) -> tuple[Array, NDArray[np.complex128]]:
        options = {"window": "boxcar", "nperseg": length, "noverlap": 0, "detrend": "constant"}
        return csd(one.ravel(), other.ravel(), rate_hz, **options)

    frequency, across = density(x, y)
    of_force, of_reading = density(x, x)[1].real, density(y, y)[1].real
    keep = (frequency > 0) & (of_force > 0) & (of_reading > 0)
    across, of_force = across[keep], of_force[keep]
    coherence = np.clip(np.abs(across) ** 2 / (of_force * of_reading[keep]), 1e-300, 1.0)
    return FrequencyResponse(
        frequency_hz=frequency[keep],
        response=across / of_force,
        coherence=coherence,
        relative_error=np.sqrt((1 - coherence) / (2 * len(starts) * coherence)),
        input_density=of_force,
        hits=len(starts),
        rate_hz=rate_hz,
        unit=f"{recording[READING].attrs['units']}/N",
    )


def _refuse_cut(reading: Array, before: int, segment_s: float) -> None:
    """Refuse pieces at whose ends there is more than noise."""
    still = reading - np.median(reading[:, :before], axis=1)[:, None]
    peak = float(np.max(np.abs(still)))
    start, end = (float(np.sqrt(np.mean(part**2))) for part in (still[:, :before], still[:, -before:]))
    if end > 0.01 * peak and end > 3 * start:
        raise FrictionloopError(
            f"segment_s = {segment_s:g} s: {100 * end / peak:.0f} % of the response is left at the end of a piece; "
            "must be longer"
        )
