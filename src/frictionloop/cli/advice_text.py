"""What a person is told of a loop that rings, for verbs whose answer is no result yet."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING

from frictionloop.cli.advice import CLAMPED
from frictionloop.cli.ringing import HELD_PEAK, OFF, Band, Ringing
from frictionloop.cli.scores import between

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr

WIDTH = 100
LEADS = (
    "They stop the ringing of this PI. The answer to go by is that of `frictionloop design controller FILE`: its law "
    "has a notch, and holds its limits with the resonance off."
)
AGAIN = (
    "This is the law with its own filters, at the speed of this run. `frictionloop design controller FILE --speeds "
    "SLOWEST,FASTEST` designs it for a range of speeds."
)


def lines(found: Ringing, metrics: dict[str, float], swings: bool = False) -> list[str]:
    """Return what a person is told; ``swings`` of a loop that its clamp keeps swinging whatever the disturbance."""
    from frictionloop.analysis.stability import NEAR

    clamped = metrics["saturation_index"]
    signs = [f"{clamped:.0%} of the commands are clamped"] if clamped > CLAMPED else []
    signs += ["the force does not follow"] if metrics["r2_identity"] < 0 else []
    near = "" if found.frequency_hz is None else f"{',' if found.stable else ''} near {found.frequency_hz:.3g} Hz"
    moist = f" on a moist finger (occluded {found.band.occluded:.0%}), not on one just landed" * found.moist_alone
    close = "rings between the ends of its clamp, though a small change dies out" if swings else "is close to ringing"
    what = f"This loop {close if found.stable else 'rings'}{near}{moist}"
    said = textwrap.wrap(what + (f": {', '.join(signs)}." if signs else "."), WIDTH)
    said.append(
        f"{_gains(found)}: {'nearly ' if found.stable and not swings else ''}too much for this sensor, plate and delay."
    )
    if found.held:
        said.append(f"Gains that hold: {' '.join(f'--{path} {gain:g}' for path, gain in found.held.items())}")
        holds = f"They hold with Ms up to {HELD_PEAK:g}, {_where(found.band)}{found.band.where}, for this finger."
        said += textwrap.wrap(holds, WIDTH)
        if found.not_held:
            said += textwrap.wrap(f"They do not hold on {'; on '.join(found.not_held)}.", WIDTH)
        elif found.also_held:
            also = f"Ms stays below {NEAR:g} with the resonance {OFF:.0%} off, also on {'; on '.join(found.also_held)}."
            said += textwrap.wrap(also, WIDTH)
        said += textwrap.wrap(LEADS, WIDTH) if found.springs else []
    elif found.law != "pi":
        said += textwrap.wrap(AGAIN, WIDTH)
    return said


def _gains(found: Ringing) -> str:
    if found.kp is not None and found.ki is not None:
        return f"kp = {found.kp:.3g}, ki = {found.ki:.4g}"
    peak = "unstable" if found.sensitivity_peak is None else f"Ms {found.sensitivity_peak:.3g}"
    return f"Law {found.law} as tuned ({peak} {_where(found.band)})"


def _where(band: Band) -> str:
    states = f"dry and moist (occluded {band.occluded:.0%}), " if band.dry_and_moist else ""
    beyond = " and ".join(f"{force:.3g}" for force in band.out_of_reach_n)
    missing = f"; {beyond} N is out of reach" if beyond else ""
    return f"{states}at the set-point's levels ({between(band.low_n, band.high_n)}{missing})"


def at_ceiling(run: xr.Dataset, mask: np.ndarray, *_: float) -> list[str]:
    """Return that a force stays high as the amplitude may not get larger; often nothing."""
    from frictionloop.loop.run_findings import of_ceiling

    return [f"{each.severity} {each.code}: {each}" for each in of_ceiling(run, mask)]
