"""``frictionloop design controller``: from a bench to a controller that holds on it, and what is left to gain."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

from cyclopts import Parameter

from frictionloop.cli import checks, flags, screen
from frictionloop.cli.must_hold import ASKED, MustHold
from frictionloop.cli.other_fingers import LOWERED, OtherFingers

if TYPE_CHECKING:
    import xarray as xr

    from frictionloop.design.corners import Corner
    from frictionloop.design.for_fingers import ForFingers
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
SLOW = {"hinf"}
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
        Control law: notch_pi, pi, limit_observer or hinf; notch_pi if not given, pi for
        a force sensor without a resonance.
    out
        Write the system with its new controller here (.toml).
    plots
        Folder for figures, sensitivity and step, each as .svg and .png.
    """
    others.check()
    checks.check_output("out", out, checks.SYSTEMS)
    checks.check_new("out", out)
    checks.check_new("out", interim(out) if others.fingers else None)
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
    from frictionloop.design.over import with_longest_contact
    from frictionloop.design.synthesis import default_law

    wanted = must.wanted()
    levels = with_longest_contact(at_levels(system), wanted.speeds_mm_s)
    recorded_units.ask(system)
    _tell_before(system, out)
    name = law or default_law(system)
    people = others.people(system, overrides)
    designed, wanted = _designed(levels, name, wanted, others.takes(name, levels, wanted, designs=True))
    made = _Made(
        system, levels, name, designed, wanted, flags.stated(file, overrides) | controller_also.given_in(file), out
    )
    made, many, lowered, crowd = _for_people(made, others, people)
    designed, found, new = made.designed, made.designed.corners, made.new
    made.save("", crowd)
    with screen.waiting("looking for what is left to gain"):
        left = headroom(made.after, wanted.sensitivity_peak)
    with screen.waiting("simulating how well the set-point is followed"):
        follows = controller_followed.followed(system, new, wanted.speeds_mm_s)
    if plots is not None:
        with screen.waiting("writing the figures"):
            checks.write_figures("plots", plots, _figures(levels, made.after, left, wanted, found))
    with screen.waiting("checking a fully moist finger"):
        moist = controller_also.fully_moist(made.after, wanted)
    made.save(moist, crowd)
    saved = {"controller": out, "figures": plots}
    if json:
        with screen.waiting("finding the margins of all loops"):
            told = controller_text.as_json(name, designed, new, wanted, found, left)
        told |= {"followed": follows and follows._asdict(), "saved": saved}
        screen.show_json(told | others.as_json(many, lowered))
        others.stop(many)
        return
    with screen.waiting("finding the least margins"):
        margins = controller_text.margin_text(found, wanted)
    unbelieved, still = controller_also.unbelieved(system), controller_also.never_moist(system)
    replaced = controller_also.replaced(flags.overrides_of(overrides), system, new)
    notes = [each for each in (replaced, unbelieved, *designed.notes, *still, *recorded.at_design(system)) if each]
    assumed = controller_also.assumed(system, made.given | must.stated)
    screen.show(
        screen.columns(controller_verdict.verdict(designed, made.after, wanted, out, moist, crowd)),
        "",
        screen.columns([("bench", origin), ("law", name), *controller_text.gain_rows(designed.overrides)]),
        "",
        *margins,
        "",
        *controller_followed.followed_text(system, follows, unbelieved),
        "",
        *controller_text.headroom_text(left, wanted),
        *(["", screen.wrapped(assumed)] if assumed else []),
        *(["", *map(screen.wrapped, notes)] if notes else []),
        *([""] if any(saved.values()) else []),
        *screen.saved(saved),
    )
    others.stop(many)


def interim(out: Path | None) -> Path | None:
    """Return where the gains for the finger of the file are kept while those for others are looked for.

    Under the name of the answer they would be taken for it.
    """
    return None if out is None else out.with_name(f"{out.stem}.own-finger{out.suffix}")


def _tell_before(system: System, out: Path | None) -> None:
    """Tell what would make the gains others, before a search that takes long."""
    from frictionloop.cli import controller_also
    from frictionloop.firmware.board_fit import misfits_of_gains

    told = [f"on the project's board: {each}" for each in misfits_of_gains(system)] if out is not None else []
    for line in filter(None, [*told, controller_also.unbelieved(system)]):
        screen.note(line)
    screen.tell_notes()


def _for_people(
    made: _Made, others: OtherFingers, people: Sequence[Any] | None
) -> tuple[_Made, xr.Dataset | None, ForFingers | None, Sequence[tuple[str, ...]]]:
    """Return the controller with gains that hold on the fingers, what was found on them, and what is told of it."""
    from frictionloop.design.for_fingers import for_fingers

    own = made._replace(out=interim(made.out) if people is not None and made.law in LOWERED else made.out)
    own.save()  # what took minutes is on the disk before the rest
    if own.out != made.out:
        file = shlex.quote(str(own.out))
        screen.note(f"{file} has gains for the finger of the file, until those for all {len(people or ())} are found")
        screen.note(_loads_said(people or (), made.wanted))
        screen.tell_notes()
    many = others.look(made.after, people, made.wanted)
    if many is None:
        return made, None, None, ()
    if own.out != made.out:
        _tell_unchecked(made, many)
    with screen.waiting("checking the gains for these fingers"):
        lowered = for_fingers(made.levels, made.designed, many, made.wanted)
    if own.out is not None and own.out != made.out:
        own.out.unlink()
    crowd = others.rows(many, made.after, made.wanted, lowered.designed.corners, lowered)
    return made._replace(designed=lowered.designed), many, lowered, crowd


def _loads_said(people: Sequence[Any], wanted: Wanted) -> str:
    """Return with which loads the fingers are looked at, before that takes minutes."""
    from frictionloop.cli.controller_holds import range_said

    if wanted.loads_n:
        return f"the fingers press with {range_said(wanted.loads_n)} N"
    loads = [each["motion.load_n"] for each in people]
    other = "as people press by themselves; `--loads 0.4,0.6`, say, looks at them between these"
    return f"the fingers press with {min(loads):.2g} to {max(loads):.2g} N, {other}"


def _tell_unchecked(made: _Made, many: xr.Dataset) -> None:
    """Tell the gains for all fingers before they are checked wherever the design was: that may take minutes."""
    from frictionloop.design.held import GAINS, lowered
    from frictionloop.design.synthesis import LEAST_KI

    factor = float(many["gain_factor"].min())
    lower = lowered(made.designed, factor) if factor < 1.0 else None
    if lower is not None and float(lower.overrides["controller.ki"]) > LEAST_KI:
        gains = " ".join(f"--{path} {lower.overrides[path]:.4g}" for path in GAINS)
        screen.note(f"gains for all {many.sizes['finger']} fingers, not checked yet: {gains}")
        screen.tell_notes()


class _Made(NamedTuple):
    """A controller that was designed, and where it goes."""

    system: System
    levels: System
    """The system with its signals as levels and its longest contacts, which it was designed for."""
    law: str
    designed: Designed
    wanted: Wanted
    given: set[str]
    """Paths of the values that a person gave."""
    out: Path | None

    @property
    def after(self) -> System:
        """What it was designed for, with it."""
        return self.levels.evolve(dict(self.designed.overrides))

    @property
    def new(self) -> System:
        """The system with it."""
        own = {name: getattr(self.system, name) for name in ("setpoint", "disturbance", "motion")}
        return self.after.evolve(own)

    def save(self, moist: str = "", crowd: Sequence[tuple[str, ...]] = ()) -> None:
        """Write the system with it, headed by what it holds for; nothing without a file."""
        from frictionloop.cli import controller_also, controller_verdict, saved_controller
        from frictionloop.parameters import write_toml

        if self.out is None:
            return
        lines = controller_verdict.speeds_said(self.after, self.wanted, shlex.quote(str(self.out)))
        holds = saved_controller.holds(self.law, self.designed, self.after, self.wanted, moist, crowd)
        assumed = controller_also.assumed_in_file(self.system, self.given)
        write_toml(self.new, self.out, said=[*holds, *lines, assumed], given=self.given)


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
    if not found.one_length:
        return found, wanted
    finger: Any = system.finger
    # Sections that are synthesised have more freedom than a notch.
    hint = "" if law in SLOW else ". `--law hinf` may hold at both ends"
    return found._replace(one_length=found.one_length + hint), replace(wanted, slip_lengths_um=(finger.slip_length_um,))


def _figures(before: System, after: System, left: Any, wanted: Wanted, found: Sequence[Corner]) -> Mapping[str, Any]:
    """Return every figure."""
    from frictionloop.report.figures.controller import drawings

    with screen.waiting("simulating a step and drawing"):
        drawn = drawings(before, after, left, wanted.limits, max(found, key=lambda each: each.sensitivity_peak))
        return {name: draw() for name, draw in drawn.items()}
