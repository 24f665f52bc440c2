"""``frictionloop effect``: the effects there are, what one asks for, and what a finger gets of it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

import frictionloop as fl
from frictionloop.cli import file_arguments, flags, screen
from frictionloop.findings import Finding

if TYPE_CHECKING:
    from frictionloop.rendering import Effect

ARGUMENTS = "EFFECT [FILE] [OPTIONS]"
LIST_EXAMPLES = ("",)
SHOW_EXAMPLES = (
    "grating --speed-mm-s 80 --plot grating.svg",
    "my-effect.toml my-bench.toml --fingers 8",
    "grating --effect.spacing_mm 3 --save my-effect.toml",
)
CHECK_EXAMPLES = (
    "my-effect.toml",
    "grating --speed-mm-s 150 --json",
)
PLAY_EXAMPLES = (
    "bump --out run.h5 --plot run.svg",
    "my-effect.toml my-bench.toml --duration-s 5 --seed 1",
)
Name = Annotated[str, Parameter(name="EFFECT", help="Name of the library, or TOML file.", group=flags.SYSTEM)]
Speed = Annotated[float | None, Parameter(help="Of the stroke, mm/s; else the system's.")]
EFFECT = "effect."
PATH = ("setpoint.track.", "setpoint.position")
"""What a flag may say about where an effect is asked: the stroke's line over it, the place measured or predicted."""
EFFECT_FILES = (".toml", ".png", ".wav", ".hjif")
LAW = {"controller.kind": "notch_pi", "controller.feedforward": True}
"""What closes the loop of the bench, if neither a file nor a flag says it (docs/which-law)."""


def list_effects(*, shown: screen.Shown = screen.BRIEFLY) -> None:
    """List the effects of the library: name, kind, and the forces that each asks for."""
    shown.show(fl.rendering.effects())


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
    shown: screen.Shown = screen.BRIEFLY,
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
    file_arguments.check_output("plot", plot, file_arguments.FIGURES)
    file_arguments.check_output("save", save, EFFECT_FILES)
    file_arguments.check_new("save", save)
    file_arguments.check_count("seed", seed, 0)
    file_arguments.check_count("fingers", fingers, 0, 1000)
    wanted, given = _given(effect, file, preset, overrides)
    people = fl.fingers(fingers, seed) if fingers else ()
    with fl.progress.waiting("simulating"):
        found = fl.rendering.preview(wanted, given.system, speed_mm_s, seed, fingers=people)
    if plot is not None:
        fl.plot(found, plot)
    left = fl.rendering.write(found.effect, save) if save is not None else ()
    more = [Finding("EFFECT-LEFT", value=", ".join(left))] if left else []
    shown.show(found.with_findings([*given.findings, *more]), saved={"figure": plot, "effect": save})


def check(
    effect: Name,
    file: flags.SystemFile = None,
    /,
    *,
    preset: flags.BenchPreset = None,
    overrides: flags.Overrides = None,
    speed_mm_s: flags.Run[Speed] = None,
    shown: screen.Shown = screen.BRIEFLY,
) -> None:
    """Check an effect without running it: whether it can be given and felt, and what is clamped of it."""
    wanted, given = _given(effect, file, preset, overrides)
    shown.show(fl.rendering.check(wanted, given.system, speed_mm_s).with_findings(given.findings))


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
    shown: screen.Shown = screen.BRIEFLY,
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
    file_arguments.check_output("out", out, file_arguments.RUN_FILES)
    file_arguments.check_output("plot", plot, file_arguments.FIGURES)
    file_arguments.check_count("seed", seed, 0)
    wanted, given = _given(effect, file, preset, overrides)
    with fl.progress.waiting("simulating"):
        found = fl.rendering.play(wanted, given.system, duration_s, seed)
    if out is not None:
        fl.save(found.run, out)
    if plot is not None:
        fl.plot(found.run, plot)
    shown.show(found.with_findings(given.findings), saved={"run": out, "figure": plot})


def _given(name: str, file: Path | None, preset: Any, overrides: list[str] | None) -> tuple[Effect | str, flags.Given]:
    """Return the effect, changed by what begins with ``effect.``, and the bench that it is felt on."""
    flagged = overrides or []
    own = flags.overrides_of(each for each in flagged if each.startswith(EFFECT))
    effect = fl.rendering.find(name, {path.removeprefix(EFFECT): value for path, value in own.items()})
    of_path = flags.overrides_of(each for each in flagged if each.startswith(PATH))
    given = on_bench(file, preset, [each for each in flagged if not each.startswith((EFFECT, *PATH))])
    if of_path:
        kind = {} if given.system.setpoint.kind == "effect" else {"setpoint.kind": "effect"}
        given = given._replace(system=given.system.evolve(kind | of_path))
    return effect if own else name, given


def on_bench(file: Path | None, preset: Any, overrides: list[str] | None) -> flags.Given:
    """Return a bench to feel effects on; the preset has a law that closes its loop well."""
    named = flags.overrides_of(overrides)
    for path in ("setpoint.effect", "setpoint.kind"):
        if any(name.startswith(path) for name in named):
            raise fl.FrictionloopError(f"{path}: is set by EFFECT and --effect.NAME VALUE")
    given = flags.system_given(file, preset, overrides, "bench")
    if file is None and preset in (None, "bench") and not any(name.startswith("controller.") for name in named):
        return given._replace(system=given.system.evolve(LAW))
    return given
