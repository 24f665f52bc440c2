"""What any linear controller can reach on a bench, finger by finger: the waterbed's bound and the linear optimum.

``python -m studies.linear_reach`` keeps medians and worst deciles of the capable of 1,000 fingers, the first table of
*pages/limits-of-control.md*: half an hour.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
import xarray as xr
from joblib import Parallel, delayed

from frictionloop.analysis.limits import stubborn
from frictionloop.analysis.operating_point import law_at
from frictionloop.analysis.waterbed import waterbed_bound
from frictionloop.design.comparison import trial_protocol
from frictionloop.parameters import SuspendedSensor, System
from frictionloop.physics.friction import friction_force
from frictionloop.quantities import Array
from frictionloop.sensing.force_sensor import noise_coefficients
from studies.causes import mean_occlusion
from studies.conditions import conditions
from studies.friction_spectrum import MEASURED, disturbed_levels, own_systems, power_of
from studies.kept import both, keep
from studies.linear_optimum import linear_optimum

LEVELS_N = (0.4, 0.6, 0.8)
"""Middles of the set-points (paper, Sec. 4.2)."""
PEAKS = (1.7, 2.0)
KEPT = {
    "optimum_rms_n": "rms of f_a - f_r under the best linear controller found",
    "driven_rms_n": "rms of f_a - f_r under the best linear controller found whose drive is seldom cut",
    "bound_rms_n": "rms of f_a - f_r that no linear controller gets below",
    "noise_rms_n": "part of the optimum that sensor noise makes",
    "waterbed_rms_n": "rms of f_a - f_r that Bode's integral leaves any linear controller without sensor noise",
    "open_rms_n": "rms of f_a - f_r before any control",
}
"""What is told of a finger, in N."""
COLUMNS = (
    ("no control", "open_rms_n", 1.7),
    ("waterbed, 1.7", "waterbed_rms_n", 1.7),
    ("optimum, 1.7", "optimum_rms_n", 1.7),
    ("noise in it, 1.7", "noise_rms_n", 1.7),
    ("drive spared, 1.7", "driven_rms_n", 1.7),
    ("waterbed, 2.0", "waterbed_rms_n", 2.0),
    ("optimum, 2.0", "optimum_rms_n", 2.0),
    ("drive spared, 2.0", "driven_rms_n", 2.0),
)
"""What is kept of a speed and slip length: head, variable, largest |S|."""
CALM = 0.5
"""Largest rms of a command that is seldom cut, over the way to its nearer end: a normal one is, 5 % of the time."""


def linear_reach(
    system: System,
    fingers: Sequence[Mapping[str, Any]],
    duration_s: float = 11.0,
    seed: int = 0,
    *,
    score_from_s: float = 1.0,
    peaks: Sequence[float] = PEAKS,
    levels_n: Sequence[float] = LEVELS_N,
    measured: Sequence[str] = MEASURED,
) -> xr.Dataset:
    """Return `linear_optimum` of each finger on its own plant, beside `waterbed_bound` of the same disturbance.

    The disturbance, with and without a measured load fed forward, is that of `disturbed_levels`; the noise is the
    bench's (`reading_noise_psd`), and the set-point is taken to be fed forward without error. The plant is that
    from the force command, sampled exactly. Its plate lags, but a linear law divides that out
    (`control/lookup`), so that the plate costs the period in which the amplitude is reached and no more: the
    best case, with a drive that never saturates, contact and sensor known exactly.

    Parameters
    ----------
    system : System
        The bench: speed, contact, delay and sensor count; its law and set-point do not.
    fingers : sequence of mappings
        Fingers as overrides. One that cannot be given a level has NaN.
    duration_s, score_from_s : float
        Duration of the stroke and the start of its scored part, in s.
    seed : int
        Seed of tremor and roughness.
    peaks : sequence of float
        Largest |S| allowed, each above 1. Without a limit (infinity) the optimum is what of the disturbance
        cannot be predicted from these readings when the command is due: of normal noise on this linear plant no law
        leaves less, linear or not (minimum variance: Harris, "Assessment of control loop performance", Can. J. Chem.
        Eng. 67, 1989). The waterbed's bound is 0 then.
    levels_n : sequence of float
        Forces in N.
    measured : sequence of str
        What the law knows, of `MEASURED`.

    Returns
    -------
    xarray.Dataset
        The variables of `KEPT` (N) over ``measured``, ``sensitivity_peak`` and ``finger``;
        squares are averaged over levels.
    """
    asked = duration_s, seed, score_from_s, tuple(peaks), tuple(levels_n), tuple(measured)
    rows = Parallel(n_jobs=-1, prefer="threads")(delayed(_reach)(own, *asked) for own in own_systems(system, fingers))
    found = np.array(rows).reshape(len(rows), len(measured), len(peaks), len(KEPT))
    dims = ("measured", "sensitivity_peak", "finger")
    return xr.Dataset(
        {
            name: (dims, np.moveaxis(found[..., k], 0, -1), {"units": "N", "long_name": about})
            for k, (name, about) in enumerate(KEPT.items())
        },
        {"measured": list(measured), "sensitivity_peak": list(peaks)},
    )


def _reach(
    system: System,
    duration_s: float,
    seed: int,
    score_from_s: float,
    peaks: Sequence[float],
    levels: Sequence[float],
    measured: Sequence[str],
) -> Array:
    squares = np.zeros((len(measured), len(peaks), len(KEPT)))
    found = disturbed_levels(system, duration_s, seed, score_from_s, levels)
    if found is None:
        return np.full_like(squares, math.nan)
    occluded = mean_occlusion(system, score_from_s, duration_s)
    for level, (loop, frequency_hz, psds) in zip(levels, found, strict=True):
        delay, zeros = stubborn(loop)
        friction, reading = loop.plant.numerators()
        noise, nyquist_hz = reading_noise_psd(system, frequency_hz), loop.nyquist_hz
        poles, calm_n = np.poly(loop.plant.transition), CALM * way_n(system, occluded, level)
        for (m, known), (k, peak) in itertools.product(enumerate(measured), enumerate(peaks)):
            psd = psds[MEASURED.index(known)]
            least = partial(
                linear_optimum,
                frequency_hz,
                psd,
                noise,
                peak,
                nyquist_hz,
                reading=reading,
                friction=friction,
                poles=poles,
            )
            best, driven = least(), least(largest_drive_n=calm_n)
            bode_n = 0.0  # a peak without limit, narrow enough, pays for all that is taken out
            if peak < math.inf:
                bode = waterbed_bound(frequency_hz, psd, peak, nyquist_hz, delay_periods=delay, zeros=tuple(zeros))
                bode_n = bode.residual_rms_n
            told = best.residual_rms_n, driven.residual_rms_n, best.bound_rms_n, best.noise_rms_n, bode_n
            squares[m, k] += [*np.square(told), power_of(frequency_hz, psd, nyquist_hz)]
    return np.asarray(np.sqrt(squares / len(levels)))


def way_n(system: System, occluded: float, force_n: float) -> float:
    """Return how far friction can be moved from a level to its nearer end, N."""
    ends = friction_force(np.array([0.0, system.plate.max_amplitude_um]), law_at(system, occluded))
    return float(np.min(np.abs(ends - force_n)))


def reading_noise_psd(system: System, frequency_hz: Array) -> Array:
    """Return the one-sided density of the noise of a sampled reading, N^2/Hz: electronics, and rounding as white noise.

    n[k+1] = decay n[k] + gain z[k] behind the electronics' pole (`sensing/force_sensor`), so that what the sampling
    folds is in it; the converter adds step^2/12.
    """
    dt, sensor = 1.0 / system.controller.rate_hz, system.sensor
    decay, gain = noise_coefficients(sensor, dt)
    turn = np.exp(-2j * np.pi * np.asarray(frequency_hz) * dt)
    rounding = sensor.step_n**2 / 12.0 if isinstance(sensor, SuspendedSensor) else 0.0
    return np.asarray(2.0 * dt * ((gain / np.abs(1.0 - decay * turn)) ** 2 + rounding))


def linear_reach_table(
    system: System,
    fingers: Sequence[Mapping[str, Any]],
    speeds_mm_s: Sequence[float] = (20.0, 80.0),
    lengths_um: Sequence[float] = (11.5, 0.0),
    **options: Any,
) -> xr.Dataset:
    """Return `linear_reach` over ``speed_mm_s`` and ``slip_length_um`` too, for the same arguments."""
    found = []
    for speed, z in itertools.product(speeds_mm_s, lengths_um):
        own = system.evolve({"motion.speed_mm_s": speed, "finger.slip_length_um": z})
        at = {"speed_mm_s": [float(speed)], "slip_length_um": [float(z)]}
        found.append(linear_reach(own, fingers, **options).expand_dims(at))
    return xr.combine_by_coords(found)  # type: ignore[return-value]


def main() -> None:
    """Keep median and worst decile of each variable for each speed and slip length, mN."""
    heads = ("mm/s", "um", "fingers", *(head for head, _, _ in COLUMNS))
    keep("linear-reach", "linear_reach", heads, rows())


def rows() -> Iterator[list[Any]]:
    """Yield what is kept of each speed and slip length."""
    for name, system, people in conditions():
        both_known = linear_reach(system, people, seed=trial_protocol.EVALUATION_SEED, measured=["force and load"])
        found = both_known.squeeze("measured")
        cells = [both(1e3 * found[variable].sel(sensitivity_peak=peak).values) for _, variable, peak in COLUMNS]
        yield [*name.removesuffix(" um").split(" mm/s, "), len(people), *cells]


if __name__ == "__main__":
    main()
