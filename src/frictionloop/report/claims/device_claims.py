"""Numbers of the claims of Sec. 4 to 6 about the device, on the bench: under one finger, Fig. 5a, and under others."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.analysis import kp_limit
from frictionloop.parameters import RETUNED
from frictionloop.physics.reach import capable
from frictionloop.report.claims.claim import Numbers, Value, numbers
from frictionloop.report.control_law_study import MEDIAN, NOTCH, ORACLE, WORST
from frictionloop.report.other_fingers import FLUCTUATING, LOOKUPS
from frictionloop.report.paper_protocol import (
    CLOSED,
    CONTROLLERS,
    HIGH_N,
    IDEAL,
    LEVELS_N,
    LOW_N,
    OPEN,
    PRINTED,
    RETUNED_GAINS,
    SCORED_S,
    Fit,
    fit,
    population,
    the_bench,
)
from frictionloop.report.results import Results
from frictionloop.report.step_response import steady_error_n
from frictionloop.report.system_comparison import in_both_units

BENCHES: dict[str, Mapping[str, Any]] = {
    "the bench": {},
    "without computing delay": {"controller.delay_s": 0.0},
    "without the resonance": {"sensor.kind": "lowpass"},
    "without either": CONTROLLERS[IDEAL],
}
"""The bench and what keeps the printed gains from holding on it."""
QS = (5.0, 2.0, 0.7)
"""Quality factors of the sensor beside the assumed 20 of the bench."""
IN_MILLI = "in mN/N"
"""One of the units that the 10 of a device may have."""
ONE_SINE, PER_NEWTON = ", within one sine", ", per newton of slope"
SLOPED = "a finger of slope 0.75"
"""Whose open loop has the slope that R2 = 0.22 has with 0.25 N about the line (paper, Sec. 4.2 and 5)."""
FLUCTUATIONS_N = 0.02
"""Of the force in closed loop (paper, Sec. 5)."""


def pi_reduces_variability(results: Results) -> Numbers:
    """Return the spread of the force with the lookup table alone over that with the PI, and the same over the slope."""
    tracked, people = results.tracked, results.people
    found, opened = {}, fit(tracked[OPEN])
    for name in (RETUNED_GAINS, PRINTED):
        closed = fit(tracked[name])
        found[f"{name}, one finger{PER_NEWTON}"] = opened.spread_n / opened.slope * closed.slope / closed.spread_n
        found[f"{name}, one finger"] = opened.spread_n / closed.spread_n
        some = float((people[OPEN]["spread_n"] / people[name]["spread_n"]).median())
        found[f"{name}, median of {people[name].sizes['finger']} fingers"] = some
    return numbers(
        found,
        compared=[],
        before=1e3 * opened.error_n,
        left=1e3 * fit(tracked[RETUNED_GAINS]).error_n,
        ringing=1e3 * fit(tracked[PRINTED]).error_n,
        open_spread=opened.spread_n,
        spread=fit(tracked[RETUNED_GAINS]).spread_n,
        kp=RETUNED["controller.kp"],
        ki=RETUNED["controller.ki"],
    )


def printed_gains_stable(_: Results) -> Numbers:
    """Return the largest stable Kp."""
    systems = in_both_units({name: the_bench().evolve(changes) for name, changes in BENCHES.items()})
    systems |= {f"Q of {q:g}": the_bench().evolve({"sensor.q": q}) for q in QS}
    limits = {name: None if math.isnan(limit := kp_limit(system)) else limit for name, system in systems.items()}
    limits[IN_MILLI] = 1e3 * kp_limit(the_bench())
    return numbers(limits, compared=list(BENCHES)[1:], assumed=[IN_MILLI, *(f"Q of {q:g}" for q in QS)])


def open_loop_r2(results: Results) -> Numbers:
    """Return the squared correlation of force and set-point without control."""
    fits = {name: fit(runs) for name, runs in _tables(results).items()}
    first, people, tracked = LOOKUPS[0], results.people[OPEN], results.tracked[OPEN]
    spread_n = float(tracked["f_r"].std())
    printed, closed = (math.sqrt(r2 / (1.0 - r2)) * off_n / spread_n for r2, off_n in ((0.22, 0.25), (0.98, 0.02)))
    near = people.isel(finger=int(np.argmin(np.abs(people["slope"].values - printed))))
    found = {f"{name}, pooled": each.r2_regression for name, each in fits.items()}
    found |= {f"{first}{ONE_SINE}": _within(tracked), SLOPED: float(near["r2_regression"])}
    return numbers(
        found | {f"{first}, to f_a = f_r": fits[first].r2_identity},
        compared=["to f_a = f_r"],
        assumed=[SLOPED],
        slope=fits[first].slope,
        printed_slope=printed,
        closed_slope=closed,
        near_r2=found[SLOPED],
        near_slope=float(near["slope"]),
        near_spread=float(near["spread_n"]),
    )


def open_loop_variation(results: Results) -> Numbers:
    """Return how far the force lies from its regression, and from the set-point, without control, in N."""
    tables = _tables(results)
    found = {f"{name}, about the regression": fit(runs).spread_n for name, runs in tables.items()}
    return numbers(found | {f"{name}, from the set-point": fit(runs).error_n for name, runs in tables.items()})


def _tables(results: Results) -> dict[str, xr.Dataset]:
    """Return the runs without control by the lookup table that commanded them."""
    return {LOOKUPS[0]: results.tracked[OPEN]} | {name: results.tracked[name] for name in LOOKUPS[1:]}


def _levels(runs: xr.Dataset) -> list[Fit]:
    return [fit(runs.sel(level=level_n)) for level_n in LEVELS_N]


def _within(runs: xr.Dataset) -> float:
    """Return the squared correlation within one sine, mean of the levels."""
    return float(np.mean([each.r2_regression for each in _levels(runs)]))


def closed_loop_r2(results: Results) -> Numbers:
    """Return both kinds of fit of the closed loop, levels pooled and within one sine, the mean of the three."""
    fits = {name: fit(results.tracked[name]) for name in CLOSED}
    within = {name: _levels(results.tracked[name]) for name in CLOSED}
    one_sine = {f"{name}{ONE_SINE}": value for name, value in _both_fits(within).items()}
    pooled = _both_fits({name: [found] for name, found in fits.items()})
    return numbers(
        {f"{name}, pooled": value for name, value in pooled.items()} | one_sine,
        printed=1e3 * fits[PRINTED].error_n,
        ringing_spread=fits[PRINTED].spread_n,
        ringing_slope=fits[PRINTED].slope,
    )


def _both_fits(fits: Mapping[str, list[Fit]]) -> dict[str, float]:
    """Return the mean of both kinds of R2, the regression's first."""
    found: dict[str, float] = {}
    for words, kind in (("regression", "r2_regression"), ("to f_a = f_r", "r2_identity")):
        for name, some in fits.items():
            found[f"{name}, {words}"] = float(np.mean([getattr(each, kind) for each in some]))
    return found


def low_forces_err_most(results: Results) -> Numbers:
    """Return the share of the lowest level in the squared error of all."""
    tracked, found = results.tracked, {}
    for name in (RETUNED_GAINS, IDEAL, PRINTED):
        squares = [each.error_n**2 for each in _levels(tracked[name])]
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
    left, neither = (1e3 * fluctuations[RETUNED_GAINS][name] for name in FLUCTUATING)
    found = {
        name: fluctuations[name]["all"] / fluctuations[name]["neither"] for name in (RETUNED_GAINS, IDEAL, PRINTED)
    }
    return numbers(found, left=left, neither=neither)


def clean_of_artefacts(results: Results) -> Numbers:
    """Return what is felt of the error over what is felt of plain sliding."""
    felt = results.felt
    found = {name: felt[name]["relative"] for name in (RETUNED_GAINS, IDEAL, PRINTED)}
    return numbers(found, compared=[IDEAL], ringing=felt[PRINTED]["index"])


STROKE = "after a stroke of 10 s"
CONTACTS_S = {STROKE: SCORED_S, "just landed": 0.0, "after 20 s": 20.0}
LOAD_MOVES = f"{STROKE} whose load drifts and trembles, 95% of the time"


@cache
def capable_share(contact_s: float, load_moves: bool = False) -> float:
    """Return the share of the population that reaches 0.3 and 0.9 N at any time of a contact.

    Under the mean load; or all but a twentieth of the time while the load drifts and trembles, as on the strokes.
    """
    return float(capable(population(), LOW_N, HIGH_N, contact_s=contact_s, load_moves=load_moves)["capable"].mean())


def range_achievable(_: Results) -> Numbers:
    """Return the share of fingers that reach both ends of the range."""
    steady = {name: capable_share(contact_s) for name, contact_s in CONTACTS_S.items()}
    return numbers(steady | {LOAD_MOVES: capable_share(SCORED_S, load_moves=True)})


def population_r2(results: Results) -> Numbers:
    """Return the median fit of a population."""
    people = {name: results.people[name] for name in (PRINTED, RETUNED_GAINS)}
    able = {name: some.where(some["capable"], drop=True) for name, some in people.items()}
    found: dict[str, Value] = {f"{name}, all fingers": _median(some) for name, some in people.items()}
    found |= {f"{name}, capable fingers": _median(some) for name, some in able.items()}
    return numbers(
        found,
        median_mn=1e3 * float(people[RETUNED_GAINS]["error_n"].median()),
        able=able[PRINTED].sizes["finger"],
        able_mn=1e3 * float(able[RETUNED_GAINS]["error_n"].median()),
    )


def _median(people: xr.Dataset) -> float:
    return float(people["r2_regression"].median())


def higher_order_cancels(results: Results) -> Numbers:
    """Return the printed fluctuations over what other laws leave, on fingers that no law was tuned on."""
    study = results.beyond
    found = {
        f"{law}, slip length {z:g} um, {words}": FLUCTUATIONS_N / study.value(law, z, "hold_rms_n", key)
        for law in (NOTCH, ORACLE, RETUNED_GAINS)
        for key, words in ((MEDIAN, "median"), (WORST, "worst decile"))
        for z in study.slip_lengths_um
    }
    left = study.value(NOTCH, study.slip_lengths_um[0], "hold_rms_n")
    return numbers(found, compared=[ORACLE, RETUNED_GAINS], notch=1e3 * left)
