"""``frictionloop identify``: what is in a file, and from a lab's recordings to the file of its bench."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from frictionloop.cli import checks, flags, screen

if TYPE_CHECKING:
    from frictionloop.identification.glance import ChannelPreview
    from frictionloop.identification.preview import Preview

CHANNELS_EXAMPLES = """Examples

  frictionloop identify channels hits.mat
  frictionloop identify channels hits.mat --plot hits.png
  frictionloop identify channels hits.mat --save-map hits-map.toml
"""
RecordingFile = Annotated[Path, Parameter(name="FILE", help="A recording.", group=flags.SYSTEM)]


def channels(
    file: RecordingFile,
    /,
    *,
    rate_hz: flags.Run[float | None] = None,
    plot: flags.Result[Path | None] = None,
    save_map: flags.Result[Path | None] = None,
    json: flags.Json = False,
) -> None:
    """Show what a file holds before anything is computed: channels, rate, clipping, wraps, lost samples.

    Parameters
    ----------
    rate_hz
        Sampling rate in Hz, where the file tells none or two.
    plot
        Draw the channels here (.png, .svg or .pdf): the range of each in short windows along the file, before the rest.
    save_map
        Write a channel map here (.toml) to be filled in: which channel is which, in what unit.
    """
    checks.check_output("save_map", save_map, checks.SYSTEMS)
    checks.check_new("save_map", save_map)
    checks.check_output("plot", plot, checks.FIGURES)
    from frictionloop.identification.preview import preview
    from frictionloop.quantities import replacing

    if plot is not None:
        _draw(file, plot, rate_hz)
    found = preview(file, rate_hz)
    if save_map is not None:
        with replacing(save_map) as beside:
            beside.write_text(_map_of(found), encoding="utf-8")
    if json:
        sampling = found.sampling
        screen.show_json(
            {
                "file": found.path,
                "date": found.date,
                "rate_hz": sampling.rate_hz,
                "rate_from": sampling.source,
                "gaps": sampling.gaps,
                "even": sampling.even,
                "channels": [each._asdict() for each in found.channels],
                "notes": found.notes,
                "saved": {"map": save_map, "plot": plot},
            }
        )
        return
    rate = found.sampling.rate_hz
    none = "not told" if found.sampling.even else "none: the times are uneven"
    told = none if rate is None else f"{rate:g} Hz ({found.sampling.source})"
    screen.show(screen.columns([("file", found.path), ("recorded", found.date), ("rate", told)]))
    screen.show("", screen.columns(_rows(found)))
    screen.show(*found.notes, *screen.saved({"the channel map": save_map, "the channels": plot}))


def _draw(file: Path, plot: Path, rate_hz: float | None) -> None:
    from frictionloop.identification.first_look import first_look
    from frictionloop.report.plot import plot as draw
    from frictionloop.report.recording_figure import left_out

    look = first_look(file, rate_hz)
    draw(look, plot)
    out = left_out(look)
    screen.say(f"a first look is drawn in {plot}{f', {out}' * bool(out)}; the whole file is looked through now")


def _rows(found: Preview) -> list[tuple[str, ...]]:
    head = ("channel", "unit", "samples", "from", "to", "rms about mean", "what to know")
    return [head, *(_row(each, found.sampling.rate_hz) for each in found.channels)]


def _row(each: ChannelPreview, rate_hz: float | None) -> tuple[str, ...]:
    lasts = f" ({each.samples / rate_hz:.3g} s)" if rate_hz and each.samples > 1000 else ""
    said = [
        f"clipped {100 * each.clipped:.2g} %" if each.clipped else "",
        f"wraps {each.wraps} time{'s' * (each.wraps > 1)}: give wrap in the map" if each.wraps else "",
        f"{each.missing} missing" if each.missing else "",
        "strokes both ways: rectify takes the magnitude" if each.both_signs else "",
        "always the same" if each.least == each.most else "",
        each.type if each.type != "float64" else "",
    ]
    numbers = (f"{each.least:.4g}", f"{each.most:.4g}", f"{each.rms:.3g}")
    return (each.name, each.unit or "-", f"{each.samples}{lasts}", *numbers, ", ".join(filter(None, said)))


def _map_of(found: Preview) -> str:
    """Return a channel map with every channel of the file, to be renamed, filled in and cut down."""
    rate = found.sampling.rate_hz
    lines = [
        f"# Channels of {Path(found.path).name}. Rename those to be used (f_m, hammer, mass, load), delete the others."
    ]
    if rate is None:
        lines.append("# rate_hz = 1000.0  # nothing in the file tells it")
    for k, each in enumerate(found.channels):
        lines += ["", f"[channels.channel_{k}]", f"column = {_quoted(each.name)}"]
        lines.append(f"unit = {_quoted(each.unit)}" if each.unit else '# unit = "V"')
        lines += ["# scale = 1.0  # newtons in one unit of the column", "# sign = -1", "# zero_s = [0.0, 1.0]"]
    return "\n".join(lines) + "\n"


def _quoted(text: str) -> str:
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'
