"""Numbers of the claims of Sec. 4 to 6 about the device, on the bench under one finger, Fig. 5a."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.analysis import kp_limit
from frictionloop.parameters import paper
from frictionloop.report.claims.judging import Numbers, numbers
from frictionloop.report.device import CLOSED, CONTROLLERS, IDEAL, OPEN, PRINTED, RETUNED_GAINS, Fit, fit
from frictionloop.report.people import LOOKUPS
from frictionloop.report.protocol import LEVELS_N, the_bench
from frictionloop.report.results import Results
from frictionloop.report.step_response import steady_error_n
from frictionloop.report.systems import in_both_units

BENCHES: dict[str, Mapping[str, Any]] = {
    "the bench": {},
    "without computing delay": {"controller.delay_s": 0.0},
    "without the resonance": {"sensor.kind": "lowpass"},
    "without either": CONTROLLERS[IDEAL],
}
"""The bench and what keeps the printed gains from holding on it."""
ONE_SINE, PER_NEWTON = ", within one sine", ", per newton of slope"


def pi_reduces_variability(results: Results) -> Numbers:
    """Return the spread of the force with the lookup table alone over that with the PI, and the same over the slope."""
    tracked, people = results.tracked, results.people
    found, opened = {}, fit(tracked[OPEN])
    for name in (RETUNED_GAINS, PRINTED):
        closed = fit(tracked[name])
        found[f"{name}, one finger"] = opened.spread_n / closed.spread_n
        found[f"{name}, one finger{PER_NEWTON}"] = opened.spread_n / opened.slope * closed.slope / closed.spread_n
        some = float((people[OPEN]["spread_n"] / people[name]["spread_n"]).median())
        found[f"{name}, median of {people[name].sizes['finger']} fingers"] = some
    return numbers(
        found,
        compared=[PER_NEWTON.removeprefix(", ")],
        before=1e3 * opened.rms_n,
        left=1e3 * fit(tracked[RETUNED_GAINS]).rms_n,
        ringing=1e3 * fit(tracked[PRINTED]).rms_n,
        open_spread=opened.spread_n,
        spread=fit(tracked[RETUNED_GAINS]).spread_n,
    )


def printed_gains_stable(results: Results) -> Numbers:
    """Return the largest stable Kp."""
    systems = in_both_units({name: the_bench().evolve(changes) for name, changes in BENCHES.items()})
    limits = {name: None if math.isnan(limit := kp_limit(system)) else limit for name, system in systems.items()}
    slider = the_bench().evolve({**BENCHES["without either"], "finger.slip_length_um": 0.0})
    return numbers(
        limits,
        assumed=list(BENCHES)[1:],
        rigid=kp_limit(paper()),
        slider=kp_limit(slider),
        stable_from=results.checked.ideal_from_n,
    )


def open_loop_r2(results: Results) -> Numbers:
    """Return the squared correlation of force and set-point without control."""
    fits = {name: fit(runs) for name, runs in _tables(results).items()}
    first = LOOKUPS[0]
    opened = results.tracked[OPEN]
    within, over = _within(opened), opened["f_a"].mean(("stroke", "time")) / opened["f_r"].mean(("stroke", "time"))
    found = {f"{name}, pooled": each.regression for name, each in fits.items()}
    found |= {f"{first}, mean of the levels": within, f"{first}, to f_a = f_r": fits[first].identity}
    return numbers(
        found,
        compared=["to f_a = f_r"],
        ours=fits[first].regression,
        within=within,
        closed=fit(results.tracked[RETUNED_GAINS]).regression,
        closed_within=_within(results.tracked[RETUNED_GAINS]),
        identity=fits[first].identity,
        least_over=float(over.min()),
        most_over=float(over.max()),
        over_at_moments=float((opened["f_a"] / opened["f_r"]).quantile(0.99)),
    )


def open_loop_variation(results: Results) -> Numbers:
    """Return how far the force lies from its regression, and from the set-point, without control, in N."""
    tables = _tables(results)
    found = {f"{name}, about the regression": fit(runs).spread_n for name, runs in tables.items()}
    return numbers(found | {f"{name}, from the set-point": fit(runs).rms_n for name, runs in tables.items()})


def _tables(results: Results) -> dict[str, xr.Dataset]:
    """Return the runs without control by the lookup table that commanded them."""
    return {LOOKUPS[0]: results.tracked[OPEN]} | {name: results.tracked[name] for name in LOOKUPS[1:]}


def _levels(runs: xr.Dataset) -> list[Fit]:
    return [fit(runs.sel(level=level_n)) for level_n in LEVELS_N]


def _within(runs: xr.Dataset) -> float:
    """Return the squared correlation within one sine, mean of the levels."""
    return float(np.mean([each.regression for each in _levels(runs)]))


def closed_loop_r2(results: Results) -> Numbers:
    """Return both kinds of fit of the closed loop, levels pooled and within one sine, the mean of the three."""
    fits = {name: fit(results.tracked[name]) for name in CLOSED}
    errors_mn = {name: 1e3 * found.rms_n for name, found in fits.items()}
    within = {name: _levels(results.tracked[name]) for name in CLOSED}
    one_sine = {f"{name}{ONE_SINE}": value for name, value in _both_fits(within).items()}
    low, middle, high = (each.identity for each in within[RETUNED_GAINS])
    return numbers(
        _both_fits({name: [found] for name, found in fits.items()}) | one_sine,
        retuned=errors_mn[RETUNED_GAINS],
        printed=errors_mn[PRINTED],
        ideal=errors_mn[IDEAL],
        low=low,
        middle=middle,
        high=high,
        open_pooled=fit(results.tracked[OPEN]).regression,
        open_within=_within(results.tracked[OPEN]),
        ringing_spread=fits[PRINTED].spread_n,
        ringing_slope=fits[PRINTED].slope,
    )


def _both_fits(fits: Mapping[str, list[Fit]]) -> dict[str, float]:
    """Return the mean of both kinds of R2, the regression's first."""
    found = {f"{name}, regression": float(np.mean([each.regression for each in some])) for name, some in fits.items()}
    return found | {
        f"{name}, to f_a = f_r": float(np.mean([each.identity for each in some])) for name, some in fits.items()
    }


def low_forces_err_most(results: Results) -> Numbers:
    """Return the share of the lowest level in the squared error of all."""
    tracked, found = results.tracked, {}
    for name in (RETUNED_GAINS, IDEAL, PRINTED):
        squares = [each.rms_n**2 for each in _levels(tracked[name])]
        found[name] = squares[0] / sum(squares)
    low = tracked[RETUNED_GAINS].sel(level=LEVELS_N[0])
    return numbers(found, saturated=float(low["saturated"].mean()))


def steady_20_mn(results: Results) -> Numbers:
    """Return the error from 200 ms after a step on, in N."""
    errors = {name: steady_error_n(results.stepped[name]) for name in CLOSED}
    rms = {f"{name}, rms": float(np.sqrt(np.mean(error**2))) for name, error in errors.items()}
    bounds = {f"{name}, 95% of the time": float(np.quantile(np.abs(error), 0.95)) for name, error in errors.items()}
    return numbers(rms | bounds)


def fluctuations_of_the_finger(results: Results) -> Numbers:
    """Return the error at a constant set-point over that without tremor and roughness."""
    fluctuations = results.fluctuations
    milli = {name: 1e3 * each for name, each in fluctuations[RETUNED_GAINS].items()}
    return numbers(
        {name: fluctuations[name]["all"] / fluctuations[name]["neither"] for name in (RETUNED_GAINS, IDEAL, PRINTED)},
        left=milli["all"],
        no_tremor=milli["no tremor"],
        no_roughness=milli["no roughness"],
        neither=milli["neither"],
        noiseless=milli["no sensor noise"],
        printed=1e3 * fluctuations[PRINTED]["neither"],
        ideal=1e3 * fluctuations[IDEAL]["neither"],
    )


def clean_of_artefacts(results: Results) -> Numbers:
    """Return what is felt of the error over what is felt of plain sliding."""
    felt = results.felt
    found = {name: felt[name]["relative"] for name in (RETUNED_GAINS, IDEAL, PRINTED)}
    return numbers(found, ringing=felt[PRINTED]["index"])
