"""Every metric of a run by its name."""

from __future__ import annotations

import math
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.loop import metrics as plain
from frictionloop.loop.felt import perceptual_index, relative_index
from frictionloop.loop.metric import RunMetric
from frictionloop.loop.open_loop import disturbance_left
from frictionloop.loop.record import system_of
from frictionloop.loop.reversals import reversal_metrics
from frictionloop.parameters import Recording
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.units import SignalWarning

PLAIN = ("r2_identity", "r2_bound", "rms_error", "output_noise", "saturation_index")
REGRESSION = ("r2_regression", "slope", "intercept")
FELT = ("perceptual_index", "relative_index")
TURNS = ("rms_error_turns", "turn_peak", "feedback_share")


def metrics(run: xr.Dataset, mask: Any = None) -> dict[str, float]:
    """Return every metric of a run by name, NaN where one has no meaning (R2 of a constant set-point).

    ``disturbance_left`` compares with the same run under the disturbance's mean. ``slope`` and
    ``intercept`` (N) belong to r2_regression. Metrics of runs that are registered come last.

    Parameters
    ----------
    run : xarray.Dataset
        From ``simulate`` or ``load``.
    mask : array of bool, optional
        The control periods to score, shape (time,); all that are ``scored`` if not given.

    Raises
    ------
    FrictionloopError
        For what is no run, a mask of another shape or that keeps nothing, or a run without its System.

    Warns
    -----
    SignalWarning
        Where a metric that simulates the run again is NaN, as the recording that it read is not there.
    """
    if "time" not in getattr(run, "dims", ()):
        grid = isinstance(run, xr.Dataset)
        given = "a grid, whose variables are metrics already" if grid else f"a {type(run).__name__}"
        raise FrictionloopError(f"run is {given}: must be a run of fl.simulate")
    keep = mask if mask is not None else run["scored"].values if "scored" in run else np.ones(run.sizes["time"], bool)
    # What is felt of a finger that is none says little, and costs half a second of imports.
    felt = system_of(run).motion.kind == "strokes"
    own = {name: each.of for name, each in plain.METRICS.items() if isinstance(each, RunMetric)}
    return {
        **{name: float(getattr(plain, name)(run, keep)) for name in PLAIN},
        "disturbance_left": _or_nan(disturbance_left, run, keep),
        **dict(zip(REGRESSION, plain.regression(run, keep), strict=True)),
        **reversal_metrics(run, np.asarray(keep, bool)),
        "perceptual_index": _or_nan(perceptual_index, run, keep) if felt else math.nan,
        "relative_index": _or_nan(relative_index, run, keep) if felt else math.nan,
        **{name: float(of(run.isel(time=np.asarray(keep, bool)))) for name, of in own.items()},
    }


def _or_nan(metric: Any, run: xr.Dataset, mask: np.ndarray) -> float:
    try:
        return float(metric(run, mask))
    except FrictionloopError as error:  # a control rate without a filter; a mean force that no constant amplitude gives
        system = system_of(run)
        read = [each.path for each in (system.setpoint, system.disturbance) if isinstance(each, Recording)]
        if not all(Path(path).is_file() for path in read):
            warnings.warn(f"{metric.__name__} is NaN, it simulates the run again: {error}", SignalWarning, stacklevel=3)
        return math.nan
