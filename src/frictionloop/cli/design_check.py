"""``frictionloop design check``: does the controller that is there hold on this bench, where not, and what would."""

from __future__ import annotations

from pathlib import Path

from frictionloop.cli import checks, flags, screen
from frictionloop.cli.must_hold import MustHold
from frictionloop.cli.other_fingers import OtherFingers

ARGUMENTS = "[FILE] [OPTIONS]"
EXAMPLES = r"""Examples

  frictionloop design check my-controller.toml
  frictionloop design check my-bench.toml --controller.kp 0.05 --controller.ki 60
  frictionloop design check my-controller.toml --speeds 20,60 --json
  frictionloop design check my-controller.toml --fingers 100
  frictionloop design check my-controller.toml --fingers 100 \
      --controller.kp 0.05 --controller.ki 60 --out my-gains.toml
"""
AS_USUAL = MustHold()
NOBODY = OtherFingers()


def command(
    file: flags.SystemFile = None,
    /,
    *,
    preset: flags.BenchPreset = None,
    overrides: flags.Overrides = None,
    must: MustHold = AS_USUAL,
    others: OtherFingers = NOBODY,
    out: flags.Result[Path | None] = None,
    json: flags.Json = False,
) -> None:
    """Check the controller of a system as it is: where it holds, where it does not and by how much, and what would.

    No other controller is searched for. It is looked at from slip length 0 to its own, at its speed, half and four
    times that, on a dry and a moist finger, with the resonance off.

    Parameters
    ----------
    out
        Write the system with this controller here (.toml), headed by what was found.
    """
    others.check()
    checks.check_output("out", out, checks.SYSTEMS)
    checks.check_new("out", out)
    given_system, origin = flags.given(file, preset, overrides, "bench")

    from frictionloop.analysis.levels import at_levels
    from frictionloop.cli import (
        check_table,
        check_text,
        controller_also,
        recorded,
        recorded_units,
        saved_controller,
    )
    from frictionloop.design.checking import check_controller, loops
    from frictionloop.design.over import with_longest_contact
    from frictionloop.parameters import write_toml

    wanted = must.wanted()
    system = with_longest_contact(at_levels(given_system), wanted.speeds_mm_s)
    recorded_units.ask(given_system)
    screen.tell_notes()  # before the look at all places, which takes some seconds
    people = others.people(system, overrides)
    count = loops(system, wanted)
    law = system.controller.kind
    more = others.takes(law, system, wanted)
    lasts = check_text.takes(count, check_text.EACH_S.get(law, check_text.OTHER_S))
    with screen.waiting(f"checking {law}", f" on up to {count} loops; this takes {lasts}{more}"):
        found = check_controller(system, wanted)
    many = others.look(system, people, wanted)
    with screen.waiting("checking a fully moist finger"):
        moist = controller_also.fully_moist(system, wanted)
    designed = saved_controller.by_file(file, must, others)
    shown = flags.again(file, preset, overrides, lambda path, _: path in ("controller.kp", "controller.ki"), "bench")
    given = flags.again(file, preset, overrides, _of_the_law, "bench")
    asked = [corner for place in found.places[: found.asked] for corner in place.corners]
    crowd = others.rows(many, system, wanted, asked, given=shown)
    verdict = check_text.verdict(found, system, wanted, given, moist, designed, crowd)
    stated = flags.stated(file, overrides) | controller_also.given_in(file)
    as_usual = controller_also.assumed(system, stated | must.stated)
    if out is not None:
        lines = saved_controller.checked(verdict, asked, wanted, others.again())
        assumed = controller_also.assumed_in_file(given_system, stated)
        write_toml(given_system, out, said=[*lines, assumed], given=stated)
    if json:
        told = check_text.as_json(found, system, wanted) | {"saved": {"controller": out}}
        screen.show_json(told | others.as_json(many))
        others.stop(many)
        return
    about = controller_also.moist_row(system, wanted, moist, bool(crowd))
    about += [("range", said)] if (said := controller_also.range_said(system, wanted)) else []
    notes = [*found.unseen, *recorded.at_design(given_system), *controller_also.never_moist(system)]
    notes += [said for said in (controller_also.unbelieved(system), as_usual) if said]
    screen.show(
        screen.columns([*verdict, *about]),
        "",
        screen.columns([("bench", origin), *check_text.controller_rows(system)]),
        "",
        *check_table.table(found, wanted),
        *(["", *map(screen.wrapped, notes)] if notes else []),
        *(["", *screen.saved({"controller": out})] if out is not None else []),
    )
    others.stop(many)


def _of_the_law(path: str, _: str) -> bool:
    """Tell whether a flag is of the controller alone, which a design for the same bench finds anew."""
    bench = path in ("controller.delay_s", "controller.rate_hz") or path.startswith("controller.model.")
    return path.startswith("controller.") and not bench
