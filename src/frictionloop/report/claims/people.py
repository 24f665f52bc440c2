"""Numbers of the claims of Sec. 4.2 to 6 about the device that rest on other fingers than one."""

from __future__ import annotations

from functools import cache

import numpy as np
import xarray as xr

from frictionloop.physics.reach import capable
from frictionloop.report.beyond import MEDIAN, NOTCH, ORACLE, WORST
from frictionloop.report.claims.claim import Value
from frictionloop.report.claims.judging import Numbers, numbers
from frictionloop.report.device import PRINTED, RETUNED_GAINS
from frictionloop.report.numbers import number
from frictionloop.report.protocol import HIGH_N, LOW_N, SCORED_S, population
from frictionloop.report.results import Results

CONTACTS_S = {"after a stroke of 10 s": SCORED_S, "just landed": 0.0, "after 20 s": 20.0}
LOAD_MOVES = "after a stroke of 10 s whose load drifts and trembles, 95% of the time"


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
    retuned, ringing_mn = people[RETUNED_GAINS], 1e3 * people[PRINTED]["rms_n"]
    worst = retuned.isel(finger=int(np.argmax(retuned["rms_n"].values)))
    return numbers(
        found,
        median_mn=1e3 * float(retuned["rms_n"].median()),
        able=able[PRINTED].sizes["finger"],
        able_mn=1e3 * float(able[RETUNED_GAINS]["rms_n"].median()),
        worst_mn=1e3 * float(worst["rms_n"]),
        lowest=float(worst["lowest_n"]),
        highest=float(worst["highest_n"]),
        quietest=float(ringing_mn.min()),
        loudest=float(ringing_mn.max()),
    )


def _median(people: xr.Dataset) -> float:
    return float(people["regression"].median())


def higher_order_cancels(results: Results) -> Numbers:
    """Return the residual of the re-tuned PI over that of other laws, on fingers that no law was tuned on."""
    study = results.beyond
    found = {
        f"{law}, slip length {z:g} um, {words}": study.ratio(RETUNED_GAINS, law, z, "hold_rms_n", key)
        for law in (NOTCH, ORACLE)
        for key, words in ((MEDIAN, "median"), (WORST, "worst decile"))
        for z in study.slip_lengths_um
    }

    def left_mn(law: str, key: str) -> str:
        values = (1e3 * study.value(law, z, "hold_rms_n", key) for z in study.slip_lengths_um)
        return " and ".join(number(each, 2) for each in values)

    return numbers(
        found,
        notch=left_mn(NOTCH, MEDIAN),
        notch_worst=left_mn(NOTCH, WORST),
        pi_worst=left_mn(RETUNED_GAINS, WORST),
    )
