"""Numbers of the claims of Sec. 2 about gains, tracking, and the simulation's signals, Fig. 2a to 2d."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import xarray as xr

from frictionloop.analysis import kp_limit
from frictionloop.loop.reference_runs import disturbance_left
from frictionloop.parameters import System, paper
from frictionloop.physics.friction import friction_force
from frictionloop.report.claims.claim import Numbers, numbers
from frictionloop.report.gains import at, middle, optimum, spread, useful_range
from frictionloop.report.number_text import number
from frictionloop.report.results import HALF, Results
from frictionloop.report.systems import (
    FEASIBLE,
    PER_SAMPLE,
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
    return numbers(
        {name: middle(found) for name, found in ranges.items()},
        largest_sample=optimum(cuts[f"{WORKING}, {PER_SAMPLE}"]).kp,
        late_low=ranges[HALF].low,
        late_high=ranges[HALF].high,
    )


def ki_optimum(results: Results) -> Numbers:
    """Return the middle of the best integral gains at Kp = 10, in both units of a printed Ki."""
    ranges = {name: useful_range(cut["r2_identity"]) for name, cut in results.over_ki.items()}
    best = {name: middle(found) for name, found in ranges.items()}
    rate_hz = results.systems[WORKING].controller.rate_hz
    sampled = {f"{name}, {PER_SAMPLE}": ki and ki / rate_hz for name, ki in best.items()}
    return numbers(best | sampled, low=ranges[FEASIBLE].low, high=ranges[FEASIBLE].high)


def ki_influence(results: Results) -> Numbers:
    """Return how much the integral gain changes the fidelity at Kp = 10."""
    cuts = {name: cut["r2_identity"] for name, cut in results.over_ki.items()}
    changed = {name: spread(r2, 2.0, 1e4) for name, r2 in cuts.items()}
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
        reachable=bound[FEASIBLE] - r2[FEASIBLE],
    )


def kp_1_unsatisfactory(results: Results) -> Numbers:
    """Return how much more of the disturbance is left at Kp = 1 than at 10."""
    systems = in_both_units(results.systems)
    at_1, at_10 = (
        {name: disturbance_left(tracking_run(system, kp)) for name, system in systems.items()} for kp in (1.0, 10.0)
    )
    return numbers({name: at_1[name] / at_10[name] for name in systems}, at_1=at_1[FEASIBLE], at_10=at_10[FEASIBLE])


def kp_40_saturated(results: Results) -> Numbers:
    """Return how much more often the command is clamped at Kp = 40 than at 10."""
    index = {name: cut["saturation_index"] for name, cut in (results.over_kp | results.per_sample).items()}
    more = {name: at(each, 40.0) - at(each, 10.0) for name, each in index.items()}
    return numbers(
        more,
        printed_10=at(index[WORKING], 10.0),
        printed_40=at(index[WORKING], 40.0),
        reachable=at(index[FEASIBLE], 40.0),
    )


def kp_40_noisy(results: Results) -> Numbers:
    """Return how much louder the force is above 200 Hz at Kp = 40 than at 10."""
    runs = results.runs[FEASIBLE]
    return numbers(
        _louder(results, lambda system: tracking_run(system, 10.0)),
        at_40_mn=1e3 * noise_above_n(runs[40.0]),
        at_10_un=1e6 * noise_above_n(runs[10.0]),
    )


def kp_40_because_of_sensor_noise(results: Results) -> Numbers:
    """Return how much louder the force is above 200 Hz at Kp = 40 than with a noiseless sensor."""

    def quiet(system: System) -> xr.Dataset:
        return tracking_run(system, 40.0, sensor__noise_rms_n=0.0)

    return numbers(_louder(results, quiet), limit=kp_limit(results.systems[WORKING]))


def _louder(results: Results, than: Callable[[System], xr.Dataset]) -> Mapping[str, float]:
    """Return the noise at Kp = 40 over that of another run of each system, Ki in both units."""
    systems = in_both_units(results.systems)
    return {
        name: noise_above_n(tracking_run(system, 40.0)) / noise_above_n(than(system))
        for name, system in systems.items()
    }


def disturbance_amplitude(_: Results) -> Numbers:
    """Return the lowest friction force under both readings of the disturbance's amplitude."""
    mean_n = float(friction_force(2.5, paper().friction)) + 0.4
    return numbers({"0.8 N peak to peak": mean_n - 0.4, "0.8 N zero to peak": mean_n - 0.8})


def setpoint_reachable(results: Results) -> Numbers:
    """Return the share of the time at which the printed set-points can be followed."""
    share = {name: reachable_share(system) for name, system in readings().items()}
    bounds = (f"{number(float(results.over_kp[name]['r2_bound']), 2)} ({name})" for name in share)
    return numbers(share, bounds=", ".join(bounds))
