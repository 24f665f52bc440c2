"""Channels of WAV files."""

from __future__ import annotations

import warnings

from frictionloop.parameters.sources import Recording
from frictionloop.recordings.arrays import in_array
from frictionloop.recordings.column import Column, column_number


def read_wav(recording: Recording) -> Column:
    """Return a channel of a WAV file; integers become -1 to 1 (full scale)."""
    from scipy.io import wavfile

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", wavfile.WavFileWarning)
        warnings.filterwarnings("error", "Reached EOF", wavfile.WavFileWarning)
        rate_hz, channels = wavfile.read(recording.path)
    channels = channels.reshape(len(channels), -1)
    samples = channels[:, column_number(recording, [], channels.shape[1])]
    place = in_array(recording, samples)
    if samples.dtype.kind in "iu":
        peak = 2.0 ** (8 * samples.dtype.itemsize - 1)
        samples = (samples - (peak if samples.dtype.kind == "u" else 0.0)) / peak
    others = [repr(str(k)) for k in range(channels.shape[1]) if str(k) != recording.column.strip()]
    head = f"channel {recording.column} of {len(others) + 1}; others by column: {', '.join(others)}" if others else ""
    by = "the header of the WAV file"
    return Column(samples, place, rate_hz=float(rate_hz), rate_by=by, full_scale=True, head=head)
