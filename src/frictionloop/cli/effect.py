"""``frictionloop effect``: the effects there are, what one asks for, and what a finger gets of it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from frictionloop.cli import checks, flags, screen
from frictionloop.quantities.units import FrictionloopError

if TYPE_CHECKING:
    from frictionloop.parameters import System

ARGUMENTS = "EFFECT [FILE] [OPTIONS]"
LIST_EXAMPLES = r"""Examples

  frictionloop effect list
  frictionloop effect list --json
"""
SHOW_EXAMPLES = r"""Examples

  frictionloop effect show grating --speed-mm-s 80 --plot grating.svg
  frictionloop effect show my-effect.toml my-bench.toml --fingers 8
  frictionloop effect show grating --effect.spacing_mm 3 --save my-effect.toml
"""
CHECK_EXAMPLES = r"""Examples

  frictionloop effect check my-effect.toml
  frictionloop effect check grating --speed-mm-s 150 --json
"""
PLAY_EXAMPLES = r"""Examples

  frictionloop effect play bump --out run.h5 --plot run.svg
  frictionloop effect play my-effect.toml my-bench.toml --duration-s 5 --seed 1
"""
Name = Annotated[
    str, Parameter(name="EFFECT", help="A name of the library, or a TOML file with an effect.", group=flags.SYSTEM)
]
Speed = Annotated[float | None, Parameter(help="Speed of the stroke in mm/s; that of the system if not given.")]
EFFECT = "effect."
PATH = ("setpoint.track.", "setpoint.position")
"""What a flag may say about where an effect is asked: the stroke's line over it, the place measured or predicted."""
EFFECT_FILES = (".toml", ".png", ".wav", ".hjif")
LAW = {"controller.kind": "notch_pi", "controller.feedforward": True}
"""What closes the loop of the bench, if neither a file nor a flag says it (docs/which-law)."""


def list_effects(*, json: flags.Json = False) -> None:
    """List the effects of the library: name, kind, and the forces that each asks for."""
    from frictionloop.cli import effect_text
    from frictionloop.rendering.library import LIBRARY

    rows = effect_text.library_rows(LIBRARY)
    if json:
        screen.show_json({row[0]: {"kind": row[1], "force": row[2]} for row in rows})
        return
    screen.show(screen.columns([("name", "kind", "asks for"), *rows]))


def show(
    effect: Name,
    file: flags.SystemFile = None,
    /,
    *,
    preset: flags.BenchPreset = None,
    overrides: flags.Overrides = None,
    speed_mm_s: flags.Run[Speed] = None,
    seed: flags.Run[flags.Whole] = 0,
    fingers: flags.Run[flags.Whole] = 0,
    plot: flags.Result[Path | None] = None,
    save: flags.Result[Path | None] = None,
    json: flags.Json = False,
) -> None:
    """Preview an effect: what a finger gets of it, open and closed loop, side by side.

    Parameters
    ----------
    seed
        Seed of all noise.
    fingers
        Show also how differently so many fingers are given it.
    plot
        Draw what is asked for and delivered over place here (.svg, .pdf or .png).
    save
        Write the effect here: .toml to change it, .png a map, .wav a wave, .hjif haptics.
    """
    checks.check_output("plot", plot, checks.FIGURES)
    checks.check_output("save", save, EFFECT_FILES)
    checks.check_new("save", save)
    checks.check_count("seed", seed, 0)
    checks.check_count("fingers", fingers, 0, 1000)
    wanted, system, origin = _given(effect, file, preset, overrides)
    with screen.waiting("simulating"):
        from frictionloop.cli import effect_text
        from frictionloop.preview import people, preview

        shown = preview(wanted, system, speed_mm_s, seed)
        crowd = None
        if fingers:
            from frictionloop.physics.fingers import fingers as drawn

            crowd = people(wanted, system, drawn(fingers, seed), speed_mm_s, seed)
    if plot is not None:
        from frictionloop.report.plot import plot as draw

        draw(shown, plot)
    left: tuple[str, ...] = ()
    if save is not None:
        from frictionloop.rendering.export import write

        left = write(shown.effect, save)
    saved = {"figure": plot, "effect": save}
    if json:
        screen.show_json(effect_text.as_json(shown, crowd) | {"saved": saved, "not_carried_over": left})
        return
    screen.show(
        screen.columns([("effect", effect_text.described(shown.effect)), ("system", origin)]),
        "",
        screen.wrapped(f"{shown.sentence}."),
        *([screen.wrapped(f"{crowd.sentence[:1].upper()}{crowd.sentence[1:]}.")] if crowd else []),
        "",
        screen.table(effect_text.delivered_rows(shown)),
        "",
        screen.columns(effect_text.limit_rows(shown)),
        *screen.saved(saved),
        *(f"not carried over: {each}" for each in left),
    )


def check(
    effect: Name,
    file: flags.SystemFile = None,
    /,
    *,
    preset: flags.BenchPreset = None,
    overrides: flags.Overrides = None,
    speed_mm_s: flags.Run[Speed] = None,
    json: flags.Json = False,
) -> None:
    """Check an effect without running it: whether it can be given and felt, and what is clamped of it."""
    wanted, system, _ = _given(effect, file, preset, overrides)

    from frictionloop.cli import effect_text
    from frictionloop.preview.asked import check as checked
    from frictionloop.preview.effect import prepared

    shown = prepared(wanted, system, speed_mm_s)
    asked = checked(shown)
    if json:
        screen.show_json(effect_text.checked_json(shown, asked))
        return
    screen.show(screen.columns(effect_text.checked_rows(shown, asked)))


def play(
    effect: Name,
    file: flags.SystemFile = None,
    /,
    *,
    preset: flags.BenchPreset = None,
    overrides: flags.Overrides = None,
    duration_s: flags.DurationS = 10.0,
    seed: flags.Run[flags.Whole] = 0,
    out: flags.Result[Path | None] = None,
    plot: flags.Result[Path | None] = None,
    json: flags.Json = False,
) -> None:
    """Play an effect under a simulated finger and keep the run.

    Parameters
    ----------
    seed
        Seed of all noise: the same seed gives the same run.
    out
        Save the traces here (HDF5, .h5); ``f_r_intended`` is what the effect asks for at the true place.
    plot
        Draw forces, amplitude and motion here (.svg, .pdf or .png).
    """
    checks.check_output("out", out, checks.RUN_FILES)
    checks.check_output("plot", plot, checks.FIGURES)
    checks.check_count("seed", seed, 0)
    wanted, system, origin = _given(effect, file, preset, overrides)

    from frictionloop.cli import effect_text
    from frictionloop.preview.asked import check as checked
    from frictionloop.preview.effect import prepared

    shown = prepared(wanted, system, None)
    checked(shown)
    with screen.waiting("simulating"):
        from frictionloop.loop.record import save
        from frictionloop.loop.simulate import simulate

        run = simulate(shown, duration_s, seed)
    if out is not None:
        save(run, out)
    if plot is not None:
        from frictionloop.report.plot import plot as draw

        draw(run, plot)
    errors = effect_text.run_errors(run)
    saved = {"run": out, "figure": plot}
    if json:
        screen.show_json({"effect": effect, "duration_s": duration_s, "seed": seed} | errors | {"saved": saved})
        return
    rows = [("effect", effect), ("system", origin), *effect_text.error_rows(errors)]
    screen.show(screen.columns(rows), *screen.saved(saved))


def _given(name: str, file: Path | None, preset: Any, overrides: list[str] | None) -> tuple[Any, System, str]:
    """Return the effect, changed by what begins with ``effect.``, and the bench that it is felt on.

    The preset has a law that closes its loop well.
    """
    own_values = [each for each in overrides or () if each.startswith(EFFECT)]
    of_path = [each for each in overrides or () if each.startswith(PATH)]
    overrides = [each for each in overrides or () if not each.startswith((EFFECT, *PATH))]
    effect: Any = name
    if own_values:
        from frictionloop.rendering.files import changed, find

        values = flags.overrides_of(own_values)
        effect = changed(find(name), {path.removeprefix(EFFECT): value for path, value in values.items()})
    system, origin = _system(file, preset, overrides)
    if of_path:
        values = flags.overrides_of(of_path)
        kind = {} if system.setpoint.kind == "effect" else {"setpoint.kind": "effect"}
        system, origin = system.evolve(kind | values), flags.changed(origin, values)
    return effect, system, origin


def _system(file: Path | None, preset: Any, overrides: list[str]) -> tuple[System, str]:
    """Return the bench that an effect is felt on."""
    wanted = flags.overrides_of(overrides)
    if any(name.startswith(("setpoint.effect", "setpoint.kind")) for name in wanted):
        raise FrictionloopError("setpoint: the effect is named by EFFECT; --effect.NAME VALUE changes it")
    from frictionloop.cli import recorded_units

    system, origin = flags.noted(file, preset, overrides, "bench")
    recorded_units.ask(system, ("disturbance",))
    if file is None and preset in (None, "bench") and not any(name.startswith("controller.") for name in wanted):
        system, origin = system.evolve(LAW), flags.changed(origin, LAW)  # no flag of a person's, so nothing to note
    return system, origin
