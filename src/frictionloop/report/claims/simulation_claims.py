"""Numbers of the claims of Sec. 2 about gains, tracking, and the simulation's signals, Fig. 2a to 2d."""

from __future__ import annotations

from functools import cache

import xarray as xr

from frictionloop.analysis import kp_limit
from frictionloop.loop.companion_runs import disturbance_left
from frictionloop.loop.metrics import saturation_index
from frictionloop.parameters import System, paper
from frictionloop.physics.friction import friction_force
from frictionloop.report.claims.claim import Numbers, numbers
from frictionloop.report.gain_maps import at, middle, optimum, spread, useful_range
from frictionloop.report.number_text import number
from frictionloop.report.results import HALF, Results
from frictionloop.report.system_comparison import (
    FEASIBLE,
    PER_SAMPLE,
    PER_SECOND,
    WORKING,
    in_both_units,
    noise_above_n,
    reachable_share,
    readings,
    tracking_run,
)


def _fidelity(results: Results) -> dict[str, xr.DataArray]:
    """Return the fidelity over Kp of each reading: of the amplitudes, and of the unit of Ki = 2."""
    return {name: cut["r2_identity"] for name, cut in (results.over_kp | results.per_sample).items()}


def kp_range_low(results: Results) -> Numbers:
    """Return where useful gains begin, at Ki = 2."""
    return numbers({name: useful_range(r2).low for name, r2 in _fidelity(results).items()})


def kp_range_high(results: Results) -> Numbers:
    """Return where useful gains end, at Ki = 2."""
    high = {name: useful_range(r2).high for name, r2 in _fidelity(results).items()}
    return numbers(high, r2_at_100=at(results.over_kp[WORKING]["r2_identity"], 100.0))


def kp_optimum(results: Results) -> Numbers:
    """Return the middle of the best gains at Ki = 2, also with the noise and the delay that the text leaves open."""
    cuts = _fidelity(results) | {name: cut["r2_identity"] for name, cut in results.variants.items()}
    ranges = {name: useful_range(r2) for name, r2 in cuts.items()}
    late = ranges[f"{FEASIBLE}, {HALF}"]
    return numbers(
        {name: middle(found) for name, found in ranges.items()},
        largest_sample=optimum(cuts[f"{WORKING}, {PER_SAMPLE}"]).kp,
        late_low=late.low,
        late_high=late.high,
    )


def ki_optimum(results: Results) -> Numbers:
    """Return by how much R2 at Ki = 2 is less than with the best integral gain, in both units of a printed Ki."""
    cuts = {name: cut["r2_identity"] for name, cut in results.over_ki.items()}
    missing = {name: float(r2.max()) - at(r2, 2.0) for name, r2 in cuts.items()}
    missing |= {f"{name}, {PER_SAMPLE}": float(r2.max()) - at(r2, 1e4) for name, r2 in cuts.items()}
    useful = useful_range(cuts[FEASIBLE])
    return numbers(missing, low=useful.low, high=useful.high)


def ki_influence(results: Results) -> Numbers:
    """Return how much the integral gain changes the fidelity at Kp = 10."""
    cuts = {name: cut["r2_identity"] for name, cut in results.over_ki.items()}
    changed = {f"{name}, {PER_SECOND}": spread(r2, 2.0, 1e4) for name, r2 in cuts.items()}
    changed |= {f"{name}, {PER_SAMPLE}": spread(r2, 1e4, 1e5) for name, r2 in cuts.items()}
    beside = spread(results.over_kp[FEASIBLE]["r2_identity"], 1.0, 40.0)
    return numbers(changed, beside=beside)


def close_to_possible(results: Results) -> Numbers:
    """Return what the printed gains leave of the fidelity that any controller could reach."""
    r2 = {name: at(each, 10.0) for name, each in _fidelity(results).items()}
    bound = {name: float(cut["r2_bound"]) for name, cut in (results.over_kp | results.per_sample).items()}
    return numbers(
        {name: bound[name] - found for name, found in r2.items()},
        working=r2[WORKING],
        bound=bound[WORKING],
        share=r2[WORKING] / bound[WORKING],
        feasible=r2[FEASIBLE],
    )


def kp_1_unsatisfactory(results: Results) -> Numbers:
    """Return how much more of the disturbance is left at Kp = 1 than at 10."""
    systems = in_both_units(results.systems)
    at_1, at_10 = (
        {name: disturbance_left(tracking_run(system, kp)) for name, system in systems.items()} for kp in (1.0, 10.0)
    )
    return numbers({name: at_1[name] / at_10[name] for name in systems}, at_1=at_1[FEASIBLE], at_10=at_10[FEASIBLE])


RATES_HZ = {"5 kHz": 5e3, "50 kHz": 5e4}
"""Of the device (paper, Sec. 4.1), and one nearer to the continuous time of Section 2 (assumed)."""


def _at_rates(results: Results) -> dict[str, System]:
    """Return each system sampled at both rates, Ki in both units."""
    rates = {
        f"{name}, {rate}": system.evolve({"controller.rate_hz": rate_hz})
        for rate, rate_hz in RATES_HZ.items()
        for name, system in results.systems.items()
    }
    return in_both_units(rates)


@cache
def _noise_and_saturation(system: System, kp: float, noiseless: bool = False) -> tuple[float, float]:
    """Return the rms of the force above 200 Hz, N, and the saturation index of one run."""
    run = tracking_run(system.evolve({"sensor.noise_rms_n": 0.0}) if noiseless else system, kp)
    return noise_above_n(run), saturation_index(run)


def _at_gains(results: Results, which: int) -> list[dict[str, float]]:
    """Return one of both at Kp = 10 and at 40."""
    systems = _at_rates(results).items()
    return [{name: _noise_and_saturation(system, kp)[which] for name, system in systems} for kp in (10.0, 40.0)]


def kp_40_saturated(results: Results) -> Numbers:
    """Return how much more often the command is clamped at Kp = 40 than at 10."""
    at_10, at_40 = _at_gains(results, 1)
    printed, reachable = f"{WORKING}, 5 kHz", f"{FEASIBLE}, 5 kHz"
    return numbers(
        {name: at_40[name] - at_10[name] for name in at_40},
        printed_10=at_10[printed],
        printed_40=at_40[printed],
        reachable=at_40[reachable],
    )


def kp_40_noisy(results: Results) -> Numbers:
    """Return how much louder the force is above 200 Hz at Kp = 40 than at 10."""
    at_10, at_40 = _at_gains(results, 0)
    reachable = f"{FEASIBLE}, 5 kHz"
    return numbers(
        {name: at_40[name] / at_10[name] for name in at_40},
        at_40_mn=1e3 * at_40[reachable],
        at_10_un=1e6 * at_10[reachable],
    )


def kp_40_because_of_sensor_noise(results: Results) -> Numbers:
    """Return how much louder the force is above 200 Hz at Kp = 40 than with a noiseless sensor."""
    systems = _at_rates(results)
    limit, limit_fast = (kp_limit(systems[f"{WORKING}, {rate}"]) for rate in RATES_HZ)
    return numbers(
        {
            name: _noise_and_saturation(system, 40.0)[0] / _noise_and_saturation(system, 40.0, noiseless=True)[0]
            for name, system in systems.items()
        },
        limit=limit,
        limit_fast=limit_fast,
    )


def disturbance_amplitude(_: Results) -> Numbers:
    """Return the lowest friction force under both readings of the disturbance's amplitude."""
    mean_n = float(friction_force(2.5, paper().friction)) + 0.4
    return numbers({"0.8 N peak to peak": mean_n - 0.4, "0.8 N zero to peak": mean_n - 0.8})


def setpoint_reachable(results: Results) -> Numbers:
    """Return the share of the time at which the printed set-points can be followed."""
    share = {name: reachable_share(system) for name, system in readings().items()}
    bounds = (f"{number(float(results.over_kp[name]['r2_bound']), 2)} ({name})" for name in share)
    return numbers(share, bounds=", ".join(bounds))
