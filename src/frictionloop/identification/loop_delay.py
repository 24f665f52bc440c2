"""The delay of the loop: how long after a known jump the answer begins."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from scipy.optimize import least_squares

from frictionloop.findings import Finding
from frictionloop.identification.estimate import Estimate, averaged, measured
from frictionloop.identification.hit_onsets import quiet_noise
from frictionloop.identification.project_entry_result import EntryResult, Sensor
from frictionloop.identification.project_file import Take
from frictionloop.identification.recording_columns import channel, pieces, rate_of
from frictionloop.quantities import Array, must_be
from frictionloop.quantities.value_checks import number

ANY = ("N", "V", "um", "m/s", "counts", "")
LEAST_JUMPS = 3
BEFORE = 0.2
"""Share of the window that lies before the jump and gives the level the answer starts from."""
SURE = 5.0
"""The answer has begun where it is so many times its noise away (one sample in a million by chance)."""
EARLIEST = 0.05
"""Share of an answer that is seen first; the straight line through it and four times it points back to where it began
(assumed)."""
WORST_MISFIT = 0.3
"""Most of an answer that a delayed exponential may leave unexplained (assumed)."""


@dataclass(frozen=True)
class LoopDelay:
    """The delay, by jumps."""

    delay: Estimate
    """``controller.delay_s``: from the sample to the new command, in s."""
    whole: Estimate
    """From the jump to where the answer begins, in s, with the wait for the next sample in it."""
    method_s: float
    """Standard error in s: how far the begin of a fitted exponential and of a straight line back are apart."""
    spread_s: float
    """Standard deviation over jumps in s; waits of up to a control period make it a period over sqrt(12)."""
    jumps: int
    findings: tuple[Finding, ...]
    time_s: Array
    """Of the first jump, drawn."""
    answer: Array
    fitted: Array


def loop_delay(recording: xr.Dataset, control_hz: float, window_s: float = 0.01, waits: bool = True) -> LoopDelay:
    """Return the delay of a loop from a known jump at its input and what it makes of it.

        y(t) = y0 + c (1 - e^(-(t - D)/T)) for t > D,   delay = mean D - 1/(2 rate)

    D and T by least squares for every jump. A jump that knows nothing of the controller's clock waits half a control
    period on average for the next sample, which the model of the loop has by itself (half the hold); so it is taken
    off. Whatever lags the answer as a low-pass does (the plate) is in T.

    Parameters
    ----------
    recording : xarray.Dataset
        ``jump`` (a voltage put in where the sensor's signal enters, or a trigger) and ``answer`` (best the drive's
        command, else the envelope of the vibration), over ``time`` in s; the rate ten times the control rate or more.
    control_hz : float
        Control rate in Hz.
    window_s : float
        Time in s that is looked at for each jump.
    waits : bool
        Whether jumps come at any time; False where the controller's own clock makes them.

    Raises
    ------
    FrictionloopError
        For a column that is missing, fewer than three jumps, a rate too low, or an answer that is no delayed rise.
    """
    control_hz = number("control_hz", control_hz, "Hz", 1.0)
    jump, answer, rate_hz = channel(recording, "jump", ANY), channel(recording, "answer", ANY), rate_of(recording)
    if rate_hz < 4 * control_hz:
        raise must_be("recording: rate", rate_hz, f"at least {4 * control_hz:g} (4 control_hz)", "Hz")
    length, before = round(window_s * rate_hz), round(BEFORE * window_s * rate_hz)
    change = np.abs(np.diff(jump))
    starts = pieces(np.concatenate([[False], change > 0.5 * change.max()]), length, before)
    if len(starts) < LEAST_JUMPS:
        raise must_be("recording: jumps of 'jump'", len(starts), f"at least {LEAST_JUMPS}")
    fits = [_begin(answer[k : k + length], before, rate_hz) for k in starts]
    # The jump lies between two samples.
    begins = np.array([fit[0] for fit in fits]) + 0.5 / rate_hz
    lines = np.array([fit[1] for fit in fits]) + 0.5 / rate_hz
    misfit = float(np.median([fit[2] for fit in fits]))
    if misfit > WORST_MISFIT:
        raise must_be("recording: misfit of delayed exponential", misfit, f"at most {WORST_MISFIT:g}")
    whole, spread = averaged(begins, "s"), float(begins.std(ddof=1))
    delay = whole._replace(value=whole.value - (0.5 / control_hz if waits else 0.0))
    method = math.hypot(abs(float(lines.mean()) - whole.value) / math.sqrt(3), 0.5 / rate_hz / math.sqrt(3))
    expected = 1 / control_hz / math.sqrt(12)
    # Jumps that come at any time scatter by a control period over sqrt(12), those of its clock hardly.
    doubted = waits == (spread < 0.5 * expected)
    remedy = f"waits = {str(not waits).lower()}"
    found = (Finding("DELAY-WAITS", value=1e6 * spread, limit=1e6 * expected * waits, remedy=remedy),) * doubted
    return LoopDelay(
        delay, whole, method, spread, begins.size, found,
        (np.arange(length) - before) / rate_hz, answer[starts[0] : starts[0] + length], fits[0][3],
    )  # fmt: skip


def _begin(piece: Array, before: int, rate_hz: float) -> tuple[float, float, float, Array]:
    """Return where an answer begins in s after the jump, by an exponential and by a line back, misfit and curve."""
    level = float(piece[:before].mean())
    rise = piece - level
    end = float(rise[-max(piece.size // 10, 1) :].mean())
    time = (np.arange(piece.size) - before) / rate_hz
    share = rise / end if end else np.zeros_like(rise)
    noise = max(quiet_noise(piece[:before] - level), 1e-9 * abs(end)) / max(abs(end), 1e-300)
    after = share[before:]

    def crossing(value: float) -> float:
        k = int(np.argmax(after > value))
        if k == 0:
            return 0.0
        return (k - 1 + float((value - after[k - 1]) / (after[k] - after[k - 1]))) / rate_hz

    low = max(EARLIEST, SURE * noise)
    first, second = crossing(low), crossing(min(4 * low, 0.8))
    line = first - (second - first) * low / (min(4 * low, 0.8) - low)

    def shape(x: Array) -> Array:
        late = np.maximum(time - x[0] / rate_hz, 0.0)
        return np.asarray(-np.expm1(-late * rate_hz / max(math.exp(x[1]), 1e-3)))

    def fitted(x: Array) -> Array:
        form = shape(x)
        return np.asarray(form * float(form @ rise) / max(float(form @ form), 1e-300))

    constant = max((crossing(0.63) - first) * rate_hz, 0.3)
    tried = [
        least_squares(lambda x: fitted(x) - rise, [first * rate_hz - back, math.log(constant)], x_scale=[1.0, 0.3])
        for back in (0.0, 1.0)
    ]
    best = min(tried, key=lambda fit: float(fit.cost))
    curve = fitted(best.x)
    misfit = float(np.linalg.norm(curve - rise) / max(float(np.linalg.norm(rise)), 1e-300))
    return float(best.x[0]) / rate_hz, line, misfit, curve + level


def delay_entry(take: Take, runs: Sequence[xr.Dataset], sensor: Sensor) -> EntryResult:
    """Return the delay of the loop from known jumps."""
    if take.control_hz is None:
        raise must_be("control_hz", None, "the control rate", "Hz")
    found = [loop_delay(run, take.control_hz, waits=take.waits) for run in runs]
    how = f"{sum(f.jumps for f in found)} jumps" + ", less half a period" * take.waits
    value = measured("controller.delay_s", [f.delay for f in found], [f.method_s for f in found], how)
    first = found[0]
    numbers = {"jumps": [f.jumps for f in found], "scatter_us": [1e6 * f.spread_s for f in found]}
    curves = {"x": first.time_s.tolist(), "y": first.answer.tolist(), "fitted": first.fitted.tolist()}
    return EntryResult([value], [each for f in found for each in f.findings], numbers, [], {"answer": curves})
