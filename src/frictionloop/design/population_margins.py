"""One controller on many people: the loop gain that they bring, and how far each finger is from its limits."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from frictionloop.analysis.linear import LinearLoop
from frictionloop.analysis.operating_point import force_band, law_at, missed, occlusions
from frictionloop.design.grid_corners import MET, Place, at_mean, cases_of, rough_corners
from frictionloop.design.operating_grid import Lean, OperatingGrid
from frictionloop.design.plant_set import least_gain
from frictionloop.design.requirements import SEARCHED, Requirements
from frictionloop.findings import Condition, Finding
from frictionloop.loop.progress import progress_bar
from frictionloop.parameters import FingerFriction, Skin, Strokes, System
from frictionloop.parameters.summary import own_values
from frictionloop.physics.fingers import fingers
from frictionloop.physics.friction import is_gaussian
from frictionloop.physics.reach import ROUNDING
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.class_help import Brief

MOST_PEAK = 2.9
"""Ms above which a loop is said to come close to ringing: it returns a distance of 1/2.9 from -1 (assumed)."""
MANY = 0.02
"""Share of people from which on another law is worth it (assumed)."""
COUNT, SEED = 1000, 0
"""Fingers that are drawn where nobody brings a population."""


class LoopGains(NamedTuple):
    """How many people are close to ringing."""

    share: float
    """Of the people, 0 to 1."""
    critical: float
    """Loop gain over the believed one from which on Ms is above `MOST_PEAK`."""
    people: int
    median: float
    """Loop gain of the people, median and worst percentile."""
    highest: float

    @property
    def many(self) -> bool:
        """Whether it is more than `MANY` of them."""
        return self.share > MANY


def loop_gain(system: System) -> float:
    """Return the largest loop gain of a finger over that of the believed one, NaN where no force asked for is in reach.

        (dF/da)/(du/da) = (F/u) (tau/tau_model), u the command at which F is reached

    over lowest, mean and highest force asked for, just landed and moist. Where one is out of reach the command stays at
    its limit, and nothing can ring. A law that commands a logarithm sees tau over that of the model.
    """
    model, margin, found = system.controller.model, getattr(system.controller, "susceptibility_margin", None), []
    largest_um = min(system.plate.max_amplitude_um, model.max_amplitude_um)
    for occluded in occlusions(system):
        law: Any = law_at(system, occluded)
        tau, most = law.susceptibility_per_um2, largest_um * largest_um
        for force_n in force_band(system):
            square = math.log(law.nominal_n / force_n) / tau if force_n > 0.0 else math.inf
            if 0.0 <= square <= most:
                command_n = model.nominal_n * math.exp(-model.susceptibility_per_um2 * square)
                gain = 1.0 if margin else force_n / command_n
                found.append(gain * tau / model.susceptibility_per_um2)
    return max(found, default=math.nan)


def critical_gain(system: System, grid: OperatingGrid) -> float:
    """Return the loop gain over the believed one up to which Ms is at most `MOST_PEAK`, the resonance as told."""
    cases = cases_of(system, grid._replace(limits={0.0: MOST_PEAK}, lean=Lean()))
    return loop_gain(system) * least_gain([loop for loop, _, _ in cases], [MOST_PEAK] * len(cases))


def loop_gains(
    system: System, grid: OperatingGrid, people: Sequence[Mapping[str, Any]] | None = None
) -> LoopGains | None:
    """Return on how many people the controller of a System has an Ms above `MOST_PEAK`; None without a law in reach.

    A person's loop differs from the file's by its gain; contact and speed are those of ``grid``.

    Parameters
    ----------
    system
        The bench with its controller.
    grid
        Contacts and speeds to look at.
    people
        Overrides, one finger each; `COUNT` assumed ones if not given.
    """
    moves = isinstance(system.finger, Skin) and isinstance(system.motion, Strokes)
    if (
        not (moves and isinstance(system.friction, FingerFriction))
        or not is_gaussian(system.friction)
        or system.controller.kind == "lookup"
    ):
        return None
    some = fingers(COUNT, SEED) if people is None else people
    gains = np.array([loop_gain(system.evolve(dict(each))) for each in some])
    critical = critical_gain(system, grid)
    if math.isnan(critical) or np.all(np.isnan(gains)):
        return None
    share = float(np.mean(gains > critical))
    return LoopGains(share, critical, len(gains), float(np.nanmedian(gains)), float(np.nanpercentile(gains, 99)))


LEFT = 2e-3
"""Share of a factor on gains that is left for rounding these to four digits."""
TRIED, SAME = 0.5, 1e-6
"""A factor that is tried on the fields of a law, and the share by which its response may miss it."""


def rounded(gain: float) -> float:
    """Return the largest gain that holds with four digits, rounded so that it holds."""
    return float(f"{(1.0 - LEFT) * gain:.4g}")


def scaled_gains(system: System, factor: float) -> Mapping[str, float]:
    """Return overrides with which the loop of a law has ``factor`` times its gain; empty where no fields scale it.

    The fields are found by trying: those by which the response of the law is in proportion, the fewest of them.
    """
    values = {name: value for name, value in own_values(system).items() if isinstance(value, float) and value}
    some = [name for name in values if name.startswith("k")]
    wholes = [each for size in range(1, len(some) + 1) for each in combinations(some, size)]
    for names in [*wholes, *((name,) for name in values if name not in some)]:
        if _scales(system, {f"controller.{name}": TRIED * values[name] for name in names}):
            less = {f"controller.{name}": rounded(factor * values[name]) for name in names}
            return less if any(less.values()) else {}
    return {}


def _scales(system: System, changes: Mapping[str, float]) -> bool:
    """Tell whether changes multiply the response of a law by `TRIED`."""
    frequency = np.geomspace(1.0, 0.4 * system.controller.rate_hz, 50)
    try:
        before, after = (at_mean(each).law.response(frequency)[:, 1, 1] for each in (system, system.evolve(changes)))
    except FrictionloopError:
        return False
    return bool(np.all(np.abs(after - TRIED * before) <= SAME * np.abs(before)) and np.any(before))


class FingersInterrupted(KeyboardInterrupt, metaclass=Brief):
    """Ctrl-C while fingers are looked at; ``partial`` has those that were looked at before."""

    def __init__(self, partial: xr.Dataset) -> None:
        super().__init__(f"{partial.sizes['finger']} fingers looked at")
        self.partial = partial


ABOUT = {
    "sensitivity_peak": ("1", "Ms farthest beyond its limit"),
    "limit": ("1", "largest Ms there"),
    "gain_factor": ("1", "gain factor that still holds"),
    "slip_length_um": ("um", "slip length there"),
    "speed_mm_s": ("mm/s", "speed there"),
    "load_n": ("N", "mean load there"),
    "force_n": ("N", "friction force there"),
    "occluded": ("1", "occlusion there"),
    "resonance_off": ("1", "resonance off there"),
    "in_reach": ("", "all forces in reach"),
    "unseen": ("", "why not looked at"),
}
"""Variables of `check_fingers`, with units and meaning."""


def check_fingers(
    system: System,
    people: Sequence[Mapping[str, Any]],
    wanted: Requirements | None = None,
    *,
    progress: bool | None = None,
) -> xr.Dataset:
    """Return how near the loop of each finger of a population comes to instability, with one controller for all.

    Each finger is looked at as `check` looks at that of the system: at lowest, mean and highest force, just
    landed and moist, with the resonance off, at the slip lengths and speeds that are asked for, from slip length 0 to
    its own if none is. It is pressed with its own load, or with the ends of the loads that are asked for. What the
    controller believes stays as it is. Where none of the forces can be had, on a moist finger say, the command stays
    at its limit, and nothing is looked at.

    Parameters
    ----------
    system
        The bench with its controller, of any law that has a linear analysis.
    people
        Overrides, one finger each, as of `fingers`.
    wanted
        What must hold. None: `Requirements` as it is.
    progress
        Show a progress bar; None: on a terminal.

    Returns
    -------
    xarray.Dataset
        Over ``finger``: ``holds``, ``stable`` and the variables of `ABOUT`, those of the corner farthest beyond its
        limit. A finger that cannot be looked at has NaN, holds nowhere, and ``unseen`` says why.

    Raises
    ------
    FrictionloopError
        No finger, or a law that has no linear analysis: the reason is that of the first finger.
    FingersInterrupted
        On Ctrl-C once a finger has been looked at, carrying what was found.
    """
    must = wanted or Requirements()
    if not len(people):
        raise FrictionloopError("people: needs one at least")
    found: list[dict[str, Any]] = []
    with progress_bar("margins of fingers", len(people), progress) as bar:
        try:
            for person in people:
                try:
                    found.append(_of(system.evolve(dict(person)), must))
                except FrictionloopError as error:
                    found.append({"unseen": str(error)})
                bar()
        except KeyboardInterrupt:
            if all("unseen" in each for each in found):
                raise
            raise FingersInterrupted(_dataset(found)) from None
    if all("unseen" in each for each in found):
        raise FrictionloopError(f"people: none can be looked at: {found[0]['unseen']}")
    return _dataset(found)


def _dataset(found: Sequence[Mapping[str, Any]]) -> xr.Dataset:
    missing = {"in_reach": True, "unseen": ""}
    values = {name: ("finger", np.array([each.get(name, missing.get(name, math.nan)) for each in found]),
                     {"units": units, "long_name": said}) for name, (units, said) in ABOUT.items()}  # fmt: skip
    result = xr.Dataset(values, {"finger": np.arange(len(found))})
    result["stable"] = np.isfinite(result["sensitivity_peak"])
    result["holds"] = result["sensitivity_peak"] <= (1.0 + MET) * result["limit"]
    return result


def _of(there: System, wanted: Requirements) -> dict[str, Any]:
    """Return one finger's worst corner, and what limits the gain."""
    grid = wanted.grid(*SEARCHED)
    # With its command at a limit the loop is open: what a law would do there says nothing of its gains.
    cases = cases_of(there, grid, _asked_for)
    if not cases:
        raise FrictionloopError("no force asked for in reach")
    # The shared grid finds where to look, within a percent; there all of it is looked at closely.
    plants, found = rough_corners(cases)
    worst = Place.of(found).worst
    return {
        **worst.condition.values,
        "resonance_off": worst.off,
        "sensitivity_peak": worst.loop.sensitivity_peak(),
        "limit": worst.limit,
        "gain_factor": least_gain([each.loop for each in found], [each.limit for each in found], plants),
        "in_reach": not any(missed(each, occlusions(each)) for each in grid.systems(there)),
    }


def _asked_for(loop: LinearLoop) -> bool:
    """Tell whether a loop is at a force that is asked for: elsewhere its command stays at a limit, and cannot ring."""
    band, force_n = force_band(loop.system), loop.elements.force_n
    return band.low_n * (1.0 - ROUNDING) <= force_n <= band.high_n * (1.0 + ROUNDING)


MOST = 0.9
"""Share of the fingers for which gains are proposed beside those for all."""
NUMBERED = {"motion.load_n": "N", "friction.nominal_n": "N", "friction.susceptibility_per_um2": "um^-2"}
"""Values by which the finger of a file is held against others."""


def of_fingers(found: xr.Dataset, scaled: Any) -> Iterator[Finding]:
    """Yield what was found on fingers; ``scaled(factor)`` gives overrides with the loop gain times a factor."""
    count = found.sizes["finger"]
    seen = found.isel(finger=np.flatnonzero(found["unseen"].values == ""))
    held, rings = int(seen["holds"].sum()), int((~seen["stable"]).sum())
    if held < seen.sizes["finger"]:
        more = {"fingers": seen.sizes["finger"], "unstable": rings}
        yield Finding("PEOPLE-HOLD", "error" if held == 0 else None, held, more=more)
        yield worst_of(seen)
        yield from _gains(seen, scaled)
    missed = int((~seen["in_reach"]).sum())
    if missed:
        yield Finding("PEOPLE-REACH", value=missed, more={"fingers": count})
    reasons = Counter(said for said in found["unseen"].values.tolist() if said)
    if reasons:
        (reason, _), *_ = reasons.most_common(1)
        yield Finding("PEOPLE-UNSEEN", value=sum(reasons.values()), more={"fingers": count, "reason": reason})


def worst_of(seen: xr.Dataset) -> Finding:
    """Return the finger that needs least gain, and where."""
    worst = seen.isel(finger=int(np.nanargmin(seen["gain_factor"].values)))
    value = {str(name): worst[name].item() for name in worst.data_vars}
    names = ("slip_length_um", "speed_mm_s", "load_n", "force_n", "occluded", "resonance_off")
    there = {name: value[name] for name in names if not math.isnan(value[name])}
    where = Condition(finger=worst["finger"].item(), **there)
    return Finding("PEOPLE-WORST", value=value["sensitivity_peak"], limit=value["limit"], where=where)


def _gains(seen: xr.Dataset, scaled: Any) -> Iterator[Finding]:
    """Yield gains with which the limits hold on all fingers looked at, and on nine in ten."""
    factors = np.sort(seen["gain_factor"].values)[::-1]
    for share, factor in ((1.0, factors[-1]), (MOST, factors[math.ceil(MOST * factors.size) - 1])):
        if factor < 1.0:
            yield Finding(
                "PEOPLE-GAIN", value=float(factor), remedy=scaled(float(factor)), more={"share": 100.0 * share}
            )


def unlike(system: System, people: Sequence[Mapping[str, Any]]) -> Iterator[Finding]:
    """Yield each value by which none of some fingers is like that of the system."""
    for path, unit in NUMBERED.items():
        values = [each[path] for each in people if path in each]
        block, _, name = path.partition(".")
        own = getattr(getattr(system, block), name, None)
        if values and own is not None and not min(values) <= own <= max(values):
            ends = {"path": path, "low": min(values), "high": max(values)}
            yield Finding("PEOPLE-UNLIKE", value=own, unit=unit, more=ends)
