"""``frictionloop design controller``: from a bench to a controller that holds on it, and what is left to gain."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from frictionloop.cli import checks, flags, screen
from frictionloop.cli.must_hold import ASKED, MustHold
from frictionloop.cli.other_fingers import OtherFingers

if TYPE_CHECKING:
    from frictionloop.design.corners import Corner
    from frictionloop.design.wanted import Designed, Wanted
    from frictionloop.parameters import System

ARGUMENTS = "[FILE] [OPTIONS]"
EXAMPLES = r"""Examples

  frictionloop design controller
  frictionloop design controller my-bench.toml --out my-controller.toml
  frictionloop design controller my-bench.toml --speeds 20,60 --loads 0.4,1.2
  frictionloop design controller my-bench.toml --corners certificate.html
  frictionloop design controller my-bench.toml --law hinf \
      --sensitivity-peak 1.5 --resonance-error 0.1 --plots figures
"""
AS_USUAL, NOBODY = MustHold(), OtherFingers()
SLOW = {"hinf", "lqg"}
"""Laws that identify the friction noise by simulation first."""


def command(
    file: flags.SystemFile = None,
    /,
    *,
    preset: flags.BenchPreset = None,
    overrides: flags.Overrides = None,
    law: Annotated[str | None, Parameter(group=ASKED)] = None,
    must: MustHold = AS_USUAL,
    others: OtherFingers = NOBODY,
    out: flags.Result[Path | None] = None,
    plots: flags.Result[Path | None] = None,
    json: flags.Json = False,
) -> None:
    """Find a controller for a bench: gains, margins on every finger and resonance, and what is left to gain.

    Parameters
    ----------
    law
        Control law: notch_pi, pi, observer, super_twisting, limit_observer, hinf or lqg; notch_pi if not given, pi for
        a force sensor without a resonance.
    out
        Write the system with its new controller here (.toml).
    plots
        Folder for figures, sensitivity and step, each as .svg and .png.
    """
    others.check()
    checks.check_output("out", out, checks.SYSTEMS)
    checks.check_new("out", out)
    checks.check_folder("plots", plots)
    system, origin = flags.given(file, preset, overrides, "bench", designed=law or "notch_pi")

    from frictionloop.analysis.headroom import headroom
    from frictionloop.analysis.levels import at_levels
    from frictionloop.cli import (
        controller_also,
        controller_followed,
        controller_text,
        controller_verdict,
        recorded,
        recorded_units,
    )
    from frictionloop.design.synthesis import default_law
    from frictionloop.firmware.board_fit import misfits_of_gains

    levels = at_levels(system)
    recorded_units.ask(system)
    for line in misfits_of_gains(system) if out is not None else ():
        screen.note(f"on the project's board: {line}")
    screen.tell_notes()  # before the search, which takes long
    wanted, name = must.wanted(), law or default_law(system)
    people = others.people(system, overrides)
    designed, wanted = _designed(levels, name, wanted, others.takes(name, levels, wanted))
    after, found = levels.evolve(dict(designed.overrides)), designed.corners
    new = after.evolve({"setpoint": system.setpoint, "disturbance": system.disturbance})
    stated = flags.stated(file, overrides)
    if out is not None:  # what took minutes is on the disk before what takes seconds
        _save(out, new, after, name, designed, wanted, stated, "")
    with screen.waiting("looking for what is left to gain"):
        left = headroom(after, wanted.sensitivity_peak)
    with screen.waiting("simulating how well the set-point is followed, for which the loop may be compiled first"):
        follows = controller_followed.followed(system, new)
    figures = {} if plots is None else _figures(levels, after, left, wanted, found)
    if plots is not None:
        with screen.waiting("writing the figures"):
            checks.write_figures("plots", plots, figures)
    with screen.waiting("checking a fully moist finger"):
        moist = controller_also.fully_moist(after, wanted)
    if out is not None:
        _save(out, new, after, name, designed, wanted, stated, moist)
    many = others.look(after, people, wanted)  # when all else is on the disk
    saved = {"controller": out, "figures": plots}
    if json:
        told = controller_text.as_json(name, designed, new, wanted, found, left)
        told |= {"followed": follows and follows._asdict(), "saved": saved}
        screen.show_json(told | others.as_json(many))
        others.stop(many)
        return
    given = flags.overrides_of(overrides)
    more = (
        controller_also.replaced(given, system, new),
        controller_also.unbelieved(system),
        *designed.notes,
        *recorded.at_design(system),
    )
    notes = [each for each in more if each]
    crowd = others.rows(many, after, wanted, found)
    verdict = controller_verdict.verdict(designed, after, wanted, out, moist, crowd)
    screen.show(
        screen.columns(verdict),
        "",
        screen.columns([("bench", origin), ("law", name), *controller_text.gain_rows(designed.overrides)]),
        "",
        *controller_text.margin_text(found, wanted),
        "",
        *controller_followed.followed_text(system, follows, controller_also.unbelieved(system)),
        "",
        *controller_text.headroom_text(left, wanted),
        *(["", screen.wrapped(said)] if (said := controller_also.assumed(system, stated | must.stated)) else []),
        *(["", *map(screen.wrapped, notes)] if notes else []),
        *([""] if any(saved.values()) else []),
        *screen.saved(saved),
    )
    others.stop(many)


def _save(
    out: Path,
    new: System,
    after: System,
    law: str,
    designed: Designed,
    wanted: Wanted,
    given: set[str],
    moist: str,
) -> None:
    """Write the system with its new controller, headed by what it holds for; ``given`` are a person's values."""
    from frictionloop.cli import controller_verdict, saved_controller
    from frictionloop.parameters import write_toml

    lines = controller_verdict.speeds_said(after, wanted, shlex.quote(str(out)))
    write_toml(new, out, said=[*saved_controller.holds(law, designed, after, wanted, moist), *lines], given=given)


def _designed(system: System, law: str, wanted: Wanted, more: str) -> tuple[Designed, Wanted]:
    """Return the controller and what it holds."""
    from frictionloop.cli.check_text import DESIGN_S, OTHER_DESIGN_S, takes
    from frictionloop.design.checking import loops
    from frictionloop.design.synthesis import design_controller

    noise = ", after the friction noise is identified by simulation" if law in SLOW else ""
    count = loops(system, wanted)
    lasts = takes(count, DESIGN_S.get(law, OTHER_DESIGN_S))
    forecast = f" and checking it on up to {count} loops{noise}; this takes {lasts}{more}"
    with screen.waiting(f"designing {law}", forecast):
        found = design_controller(system, law, wanted)
    if not found.not_both:
        return found, wanted
    finger: Any = system.finger
    # Sections that are synthesised have more freedom than a notch.
    hint = "" if law in SLOW else ". `--law hinf` may hold on both"
    return found._replace(not_both=found.not_both + hint), replace(wanted, contacts=(finger.contact,))


def _figures(before: System, after: System, left: Any, wanted: Wanted, found: Sequence[Corner]) -> Mapping[str, Any]:
    """Return every figure."""
    from frictionloop.report.figures.controller import drawings

    with screen.waiting("simulating a step, for which the loop may be compiled first, and drawing"):
        drawn = drawings(before, after, left, wanted.limits, max(found, key=lambda each: each.sensitivity_peak))
        return {name: draw() for name, draw in drawn.items()}
