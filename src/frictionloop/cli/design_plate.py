"""``frictionloop design plate``: what an ultrasonic plate does, takes and needs, from its dimensions."""

from __future__ import annotations

from typing import Annotated

from cyclopts import Group, Parameter

import frictionloop as fl
from frictionloop.cli import flags, screen

ARGUMENTS = "[OPTIONS]"
EXAMPLES = (
    "",
    "--frequency-hz 40000 --bandwidth-hz 150",
    "--drive.finger-on true --drive.quality-factor 120",
)
Plate = Annotated[flags.T, Parameter(group=Group("Plate", sort_key=1))]
Asked = Annotated[flags.T, Parameter(group=Group("Asked", sort_key=2))]


def command(
    *,
    overrides: Annotated[Plate[list[str] | None], Parameter(name=flags.DOTTED, metavar="VALUE")] = None,
    frequency_hz: Asked[float | None] = None,
    bandwidth_hz: Asked[float | None] = None,
    check_carrier: Asked[flags.Flag] = False,
    readings: Asked[flags.Flag] = False,
    shown: screen.Shown = screen.BRIEFLY,
) -> None:
    """Say how a plate vibrates, what drives it, what a finger and the carrier change; with its [plate] block.

    Parameters
    ----------
    overrides
        Any parameter of the plate by its dotted name, such as --geometry.thickness-mm 4 or
        --drive.quality-factor 150. --json lists the names.
    frequency_hz
        Resonance wanted, in Hz: which mode, which thickness. All else is then of that mode, unless
        --geometry.nodal-lines names another.
    bandwidth_hz
        Envelope bandwidth wanted, in Hz: which Q.
    check_carrier
        Simulate the carrier and say how far the first-order envelope is off.
    readings
        Say which of the paper's numbers go together.
    """
    own = flags.overrides_of(overrides)
    asked = {"frequency_hz": frequency_hz, "bandwidth_hz": bandwidth_hz}
    with fl.progress.waiting("simulating the carrier" if check_carrier else "sizing a plate"):
        found = fl.design.plate(overrides=own, **asked, check_carrier=check_carrier, readings=readings)
    shown.show(found)
