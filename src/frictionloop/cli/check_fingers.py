"""A controller that was checked on a population of fingers, as rows of the verdict and as a program is shown it."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from frictionloop.cli.comparison_text import number
from frictionloop.cli.controller_also import off_said
from frictionloop.cli.controller_holds import finger
from frictionloop.design.checking import ROUNDING
from frictionloop.parameters import PiController
from frictionloop.parameters.filtered import FeedForward

if TYPE_CHECKING:
    from frictionloop.design.for_fingers import ForFingers
    from frictionloop.parameters import System

Row = tuple[str, ...]
REASONS = 3
"""Most reasons that are told."""
SAVED = (
    "`frictionloop design check {}`, with these gains and `--out my-gains.toml`, checks them on others and writes them "
    "to a file"
)
SERVED = (
    "whom a loop holds on is not yet served by it: `frictionloop sweep FILE --fingers N`, with your --loads, says for "
    "how many people it works"
)
MANY = 100
"""Other fingers that are proposed to look at (chosen)."""
NONE_LEFT = 1.005
"""Factor on the gain below which no room is told (chosen: it would be read as 1)."""
MOST = 0.9
"""Share of the fingers for which gains are proposed beside those for all."""


def rows(found: xr.Dataset, system: System, drawn: str, where: str, again: str) -> list[Row]:
    """Return rows of a verdict: on how many fingers the limits hold, the worst of them, and gains for more of them.

    ``drawn`` says from what the fingers were drawn, ``where`` at which slip lengths, speeds and loads they
    were looked at, ``again`` are the system and the flags that look at others so.
    """
    count = found.sizes["finger"]
    seen = found.isel(finger=np.flatnonzero(found["unseen"].values == ""))
    held, rings = int(seen["holds"].sum()), int((~seen["stable"]).sum())
    beyond, unseen = seen.sizes["finger"] - held, count - seen.sizes["finger"]
    of = f"{count}" if not unseen else f"{seen.sizes['finger']} that can be looked at, of {count}"
    who = f"all {of}" if held and unseen and not beyond else f"{held} of {of}"
    said = f"the limits hold on {who} fingers of {drawn}; {where}"
    said += f"; on {beyond - rings} the loop is stable, beyond a limit; on {rings} it is unstable" if beyond else ""
    said += f"; {unseen} cannot be looked at: {_reasons(found)}" if unseen else ""
    name = "NOT ON ALL FINGERS" if beyond or not held else "on fingers"
    told: list[Row] = [(name, said)]
    if beyond:
        told += [("", _worst(seen)), *_less(seen, system, again)]
    elif held:
        told.append(("", f"{_worst(seen)}{_room(float(seen['gain_factor'].min()))}"))
    return [*told, *_missed(seen, system)]


def lowered_rows(found: xr.Dataset, system: System, factor: float, drawn: str, where: str, again: str) -> list[Row]:
    """Return rows of a design whose gains were lowered until the limits hold on all fingers that can be looked at.

    ``system`` has the gains before, of which ``found`` is; ``again`` are the flags that look at other fingers so.
    """
    seen = found.isel(finger=np.flatnonzero(found["unseen"].values == ""))
    count, held, rings = seen.sizes["finger"], int(seen["holds"].sum()), int((~seen["stable"]).sum())
    unseen = found.sizes["finger"] - count
    of = f"all {count}" if not unseen else f"all {count} that can be looked at, of {count + unseen}"
    controller: Any = system.controller
    said = f"the limits hold on {of} fingers of {drawn}; {where}. For that the gains are {number(factor)} times those "
    said += f"for the finger of the file alone, kp {controller.kp:.4g} and ki {controller.ki:.4g} 1/s. Those hold on "
    said += f"{held} of these fingers, and are unstable on {rings}"
    told: list[Row] = [("on fingers", said)]
    most = _most(seen)
    if factor < most < 1.0:
        told.append(("", _gains(f"on nine in ten of {count}", most, system, "those")))
    told += [("", f"with the gains for the finger of the file {_worst(seen)}"), *_of_others(count, again)]
    if unseen:
        told.append(("", f"{unseen} cannot be looked at: {_reasons(found)}"))
    return [*told, *_missed(seen, system, "those", "the gains for the finger of the file")]


def _of_others(count: int, again: str) -> list[Row]:
    """Return rows with what gains that hold on all of some fingers say of others of the same population.

    One more finger is as likely as each of these to be the worst of all: 1 in count + 1. A share p of fingers beyond
    the limits is missed by all of them with (1 - p)^count, which is below 5 % for p above 1 - 0.05^(1/count).
    """
    most = 1.0 - 0.05 ** (1.0 / count)
    said = f"of other fingers 1 in {count + 1} is to be expected beyond the limits, and up to {most:.0%} may be, with "
    return [
        ("", f"{said}95 % confidence: one draw in twenty is worse, and a seed draws the same fingers each time"),
        ("", f"`frictionloop design check FILE{again}` looks at others: before a device has these gains, run it"),
    ]


def not_lowered(lowered: ForFingers | None) -> list[Row]:
    """Return a row of a design that did not lower its gains, as little would be left; none of any other."""
    if lowered is None or not lowered.wanting:
        return []
    if lowered.least_ki is None:
        return [("", "the gains were not lowered for all: this law has no kp and ki")]
    said = f"the gains were not lowered for all: a ki of {lowered.least_ki:.3g} 1/s lowers nothing that is felt"
    return [("", said)]


def _missed(seen: xr.Dataset, system: System, *gains: str) -> list[Row]:
    """Return rows on the fingers that cannot be given every force, and on gains for the others; none where all can.

    ``gains`` are the words of `_gains`.
    """
    missed = int((~seen["in_reach"]).sum())
    if not missed:
        return []
    who = "none of them can" if missed == seen.sizes["finger"] > 1 else f"{missed} cannot"
    said = f"{who} be given every force asked for at every load looked at, dry and moist; they were "
    told: list[Row] = [("", said + "looked at where they can; other forces asked for may serve more")]
    served = float(seen["gain_factor"].where(seen["in_reach"]).min())
    if NONE_LEFT * float(seen["gain_factor"].min()) < min(served, 1.0):  # the others bear more gain
        told.append(("", _gains(f"on the {seen.sizes['finger'] - missed} others", served, system, *gains)))
    return [*told, ("", SERVED)]


def _reasons(found: xr.Dataset) -> str:
    """Return why fingers were not looked at, the most frequent reasons first."""
    counted = Counter(said for said in found["unseen"].values.tolist() if said)
    listed = [f"{times} as {said}" if len(counted) > 1 else said for said, times in counted.most_common(REASONS)]
    more = sum(counted.values()) - sum(times for _, times in counted.most_common(REASONS))
    return "; ".join([*listed, *([f"{more} for other reasons"] if more else [])])


def _room(gain: float) -> str:
    """Return how much more gain all of the fingers bear, who hold; empty where there is no limit."""
    if not math.isfinite(gain):
        return ""
    if gain < NONE_LEFT:
        return "; with a higher gain of the loop it is beyond its limits"
    return f"; for all of these the gain of the loop may be {number(gain)} times as high"


def _worst(seen: xr.Dataset) -> str:
    """Return which finger is the worst, and where."""
    worst = seen.isel(finger=_worst_of(seen))
    value = {str(name): worst[name].item() for name in worst}
    where = [] if math.isnan(value["slip_length_um"]) else [f"slip length {value['slip_length_um']:g} um"]
    where += [f"{value['speed_mm_s']:.3g} mm/s"] if math.isfinite(value["speed_mm_s"]) else []
    where += [f"pressed with {value['load_n']:.2g} N"] if math.isfinite(value["load_n"]) else []
    where += [f"at {value['force_n']:.3g} N, {finger(value['occluded'])}{off_said(value['resonance_off'])}"]
    how = f"Ms is {value['sensitivity_peak']:.3g}, {value['limit']:.3g} the limit" if value["stable"] else "unstable"
    missed = "" if value["in_reach"] else "; it cannot be given every force asked for"
    return f"the worst is finger {worst['finger'].item()}: {how}, {', '.join(where)}{missed}"


def _worst_of(seen: xr.Dataset) -> int:
    """Return the place of the finger that needs least gain."""
    return int(np.nanargmin(seen["gain_factor"].values))


def _less(seen: xr.Dataset, system: System, again: str) -> list[Row]:
    """Return rows on which gains hold on nine fingers in ten, and on all, of those that can be looked at."""
    count, least = seen.sizes["finger"], float(seen["gain_factor"].min())
    wanted = [(f"on nine in ten of {count} fingers", _most(seen)), (f"on all {count}", least)]
    rows: list[Row] = [("", _gains(who, factor, system)) for who, factor in wanted]
    return [*rows, ("", SAVED.format(again))] if isinstance(system.controller, PiController | FeedForward) else rows


def _most(seen: xr.Dataset) -> float:
    """Return the factor on the gain with which the limits hold on `MOST` of the fingers."""
    factors = np.sort(seen["gain_factor"].values)[::-1]
    return float(factors[math.ceil(MOST * factors.size) - 1])


def _gains(who: str, factor: float, system: System, what: str = "the gain", whole: str = "these gains") -> str:
    """Return with which gains the limits hold; ``what`` is multiplied, ``whole`` are the gains of the system."""
    controller: Any = system.controller
    if factor >= 1.0:
        return f"{who} the limits hold with {whole}"
    if not isinstance(controller, PiController | FeedForward):
        return f"{who} the limits hold with {number(factor)} times the gain of the loop"
    less = {name: f"{(1.0 - ROUNDING) * factor * getattr(controller, name):.4g}" for name in ("kp", "ki")}
    flags = " ".join(f"--controller.{name} {value}" for name, value in less.items() if float(value))
    return f"{who} the limits hold with `{flags}`, {number(factor)} times {what}"


def as_json(found: xr.Dataset, seed: int) -> dict[str, Any]:
    """Return everything by name, a list over fingers each; NaN is what cannot be looked at."""
    values: dict[str, Sequence[Any]] = {str(name): each.values.tolist() for name, each in found.data_vars.items()}
    return {"count": found.sizes["finger"], "seed": seed, "hold": int(found["holds"].sum()), **values}
