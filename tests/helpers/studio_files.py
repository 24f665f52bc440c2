"""Files that a page of the studio can bring along."""

from __future__ import annotations

import io

import numpy as np
from PIL import Image
from scipy.io import wavfile


def png(pixels, mode=None):
    """Return pixels as a PNG."""
    file = io.BytesIO()
    Image.fromarray(np.asarray(pixels, np.uint8), mode).save(file, "PNG")
    return file.getvalue()


def wav(samples, rate=8000):
    """Return samples as a WAV of 16 bits."""
    file = io.BytesIO()
    wavfile.write(file, rate, np.asarray(samples, np.int16))
    return file.getvalue()
