"""``frictionloop effect``: effects there are, of whom they can be had, what a finger gets, and files of others."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

import frictionloop as fl
from frictionloop.cli import file_arguments, flags, screen
from frictionloop.cli.verb import verb
from frictionloop.findings import Finding

if TYPE_CHECKING:
    from frictionloop.rendering import Effect

Name = Annotated[str, Parameter(name="EFFECT", help="Name of the library, or TOML file.", group=flags.SYSTEM)]
Speed = Annotated[float | None, Parameter(help="Of the stroke, mm/s; else the system's.")]
EFFECT = "effect."
PATH = ("setpoint.track.", "setpoint.position")
"""What a flag may say about where an effect is asked: the stroke's line over it, the place measured or predicted."""
EFFECT_FILES = (".toml", ".png", ".wav", ".hjif")


@verb("list [--json]", "")
def list_effects(*, shown: screen.Shown = screen.BRIEFLY) -> None:
    """List the effects of the library: name, kind, and the forces that each asks for."""
    shown.show(fl.rendering.effects())


@verb(
    "show EFFECT [FILE] [OPTIONS]",
    "grating --speed-mm-s 80 --plot grating.svg",
    "my-effect.toml my-bench.toml --fingers 8",
    "grating --effect.spacing_mm 3 --save my-effect.toml",
)
def show(
    effect: Name,
    file: flags.SystemFile = None,
    /,
    *,
    preset: flags.BenchPreset = None,
    overrides: flags.Overrides = None,
    speed_mm_s: flags.Run[Speed] = None,
    seed: flags.Seed = 0,
    fingers: flags.Run[flags.Whole] = 0,
    plot: flags.Result[Path | None] = None,
    save: flags.Result[Path | None] = None,
    shown: screen.Shown = screen.BRIEFLY,
) -> None:
    """Preview an effect: what a finger gets of it, open and closed loop, side by side.

    Parameters
    ----------
    fingers
        Show also how differently so many fingers are given it.
    plot
        Draw what is asked for and delivered over place here (.svg, .pdf or .png).
    save
        Write the effect here: .toml to change it, .png a map, .wav a wave, .hjif haptics.
    """
    file_arguments.check_output("plot", plot, file_arguments.FIGURES)
    file_arguments.check_output("save", save, EFFECT_FILES, new=True)
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


@verb("check EFFECT [FILE] [OPTIONS]", "my-effect.toml", "grating --speed-mm-s 150 --json")
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


@verb(
    "play EFFECT [FILE] [OPTIONS]",
    "bump --out run.h5 --plot run.svg",
    "my-effect.toml my-bench.toml --duration-s 5 --seed 1",
)
def play(
    effect: Name,
    file: flags.SystemFile = None,
    /,
    *,
    preset: flags.BenchPreset = None,
    overrides: flags.Overrides = None,
    duration_s: flags.DurationS = 10.0,
    seed: flags.SeedOfRun = 0,
    out: flags.Result[Path | None] = None,
    plot: flags.Result[Path | None] = None,
    shown: screen.Shown = screen.BRIEFLY,
) -> None:
    """Play an effect under a simulated finger and keep the run.

    Parameters
    ----------
    out
        Save the traces here (HDF5, .h5); ``f_r_intended`` is what the effect asks for at the true place.
    plot
        Draw forces, amplitude and motion here (.svg, .pdf or .png).
    """
    file_arguments.check_run(out, plot)
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
    others = [each for each in flagged if not each.startswith((EFFECT, *PATH))]
    for path in ("setpoint.effect", "setpoint.kind"):
        if any(each.startswith(path) for each in others):
            raise fl.FrictionloopError(f"{path}: is set by EFFECT and --effect.NAME VALUE")
    given = flags.system_given(file, preset, others, "bench", closing=True)
    if of_path:
        kind = {} if given.system.setpoint.kind == "effect" else {"setpoint.kind": "effect"}
        given = given._replace(system=given.system.evolve(kind | of_path))
    return effect if own else name, given


File = Annotated[Path, Parameter(name="FILE", help="Picture, recording, envelope or hjif.", group=flags.SYSTEM)]


@verb(
    "import FILE --out EFFECT.toml [OPTIONS]",
    "leaf.png --mm-per-pixel 0.1 --polarity dark --out leaf.toml",
    "cloth.csv --column 0 --rate-hz 10000 --scale 0.001 --speed-mm-s 40 --out cloth.toml",
    "click.ahap --full-n 0.2 --out click.toml",
    "pattern.hjif --out pattern.toml",
)
def import_file(
    file: File,
    /,
    *,
    out: flags.Result[Path],
    mm_per_pixel: flags.Run[float | None] = None,
    polarity: flags.Run[Literal["bright", "dark"] | None] = None,
    low_n: flags.Run[float] = 0.3,
    high_n: flags.Run[float] = 0.6,
    column: flags.Run[str] = "0",
    rate_hz: flags.Run[float | None] = None,
    scale: flags.Run[float | None] = None,
    offset_n: flags.Run[float | None] = None,
    speed_mm_s: flags.Run[float | None] = None,
    order: flags.Run[int | None] = None,
    full_n: flags.Run[float | None] = None,
    heights: flags.Run[flags.Flag] = False,
    shown: screen.Shown = screen.BRIEFLY,
) -> None:
    """Make an effect of a picture (.png, .tiff), a recording, an envelope (.haptic, .ahap) or an .hjif file.

    Parameters
    ----------
    out
        The effect (.toml).
    mm_per_pixel
        Of a picture: size of a pixel in mm.
    polarity
        Of a picture: what is most friction, bright or dark pixels.
    low_n, high_n
        Of a picture: forces at both ends of grey in N.
    column
        Of a recording: name or number of the column.
    rate_hz
        Of a recording: its rate, if the file does not say it.
    scale
        Of a recording: newtons per unit.
    offset_n
        Of a recording: added after scaling, in N; if not given 0.45 where the recording goes below 0.
    speed_mm_s
        Of a recording: speed of the finger in mm/s; it is then played by place, else over time.
    order
        Of a recording played by place: fit a model with so many coefficients, and write that.
    full_n
        Of an envelope: force that the full amplitude stands for, in N.
    heights
        Of a picture: greys are heights, --low-n and --high-n in mm; their slope is added to 0.45 N.
    """
    file_arguments.check_output("out", out, file_arguments.SYSTEMS, new=True)
    found = fl.rendering.import_effect(
        file, mm_per_pixel=mm_per_pixel, polarity=polarity, low_n=low_n, high_n=high_n, heights=heights, column=column,
        rate_hz=rate_hz, scale=scale, offset_n=offset_n, speed_mm_s=speed_mm_s, order=order, full_n=full_n,
    )  # fmt: skip
    fl.rendering.write_effect(found.effect, out)
    shown.show(found, saved={"effect": out})
