"""Is a force felt? Thresholds, and the index D of a residual: spectral, and the filter that accumulates it."""

from frictionloop.perception.index import (
    index_db,
    index_of_residual,
    index_of_spectrum,
    is_perceptible,
    slow_error_felt,
)
from frictionloop.perception.thresholds import (
    Fingertip,
    Impedance,
    displacement_threshold_um,
    force_threshold_n,
)
from frictionloop.perception.weighting import weighting_sos

__all__ = [
    "Fingertip",
    "Impedance",
    "displacement_threshold_um",
    "force_threshold_n",
    "index_db",
    "index_of_residual",
    "index_of_spectrum",
    "is_perceptible",
    "slow_error_felt",
    "weighting_sos",
]
