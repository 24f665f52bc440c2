"""``frictionloop firmware``: a bench as the parameter table of the microcontroller, and as an image to be flashed."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import App, Group, Parameter

from frictionloop.cli import checks, flags, screen
from frictionloop.cli.helptext import HELP_STYLE

if TYPE_CHECKING:
    from frictionloop.device.export import Table

ARGUMENTS = "[FILE] --out FOLDER [OPTIONS]"
EXPORT_EXAMPLES = r"""Examples

  frictionloop firmware export --preset bench --out my-table
  frictionloop firmware export my-controller.toml --out my-table
"""
BUILD_EXAMPLES = r"""Examples

  frictionloop firmware build --preset bench --controller.kind notch_pi --out my-image
  frictionloop firmware build my-controller.toml --out my-image --board mps2
"""
Out = Annotated[Path, Parameter(help="Folder for the files; made if it is missing.", group=flags.RESULT)]

app = App(
    name="firmware",
    help="The controller on the microcontroller: its parameter table and its image.",
    usage="frictionloop firmware COMMAND [OPTIONS]",
    help_epilogue="Each command has its own help with examples: frictionloop firmware export --help",
    help_format="plaintext",
    help_formatter=HELP_STYLE,
    group=flags.DEVICE,
    default_parameter=Parameter(negative=()),
)
app["--help"].group = Group("About", sort_key=9)


def export(
    file: flags.SystemFile = None,
    /,
    *,
    preset: flags.Preset = None,
    overrides: flags.Overrides = None,
    out: Out,
    json: flags.Json = False,
) -> None:
    """Write the parameter table of a system: as words for the device, as numbers with units, and the system itself."""
    table = _table(file, preset, overrides, out)
    table.write(out)
    _show(table, flags.named(file, preset, overrides), {"table": str(out)}, json)


def build(
    file: flags.SystemFile = None,
    /,
    *,
    preset: flags.Preset = None,
    overrides: flags.Overrides = None,
    board: Annotated[str, Parameter(help="teensy31, or mps2 for qemu-system-arm.", group=flags.RUN)] = "teensy31",
    out: Out,
    json: flags.Json = False,
) -> None:
    """Build the image that runs a system's controller: .elf, .hex to be flashed, .map; with the table beside it."""
    table = _table(file, preset, overrides, out)

    from frictionloop.device.image import build as build_image

    with screen.waiting(f"building the image of {board}; the first time takes half a minute"):
        image = build_image(board, table.words.tolist(), out)
    table.write(out)
    sizes = {"flash": f"{image.flash_bytes:,} of 262,144 bytes", "memory": f"{image.ram_bytes:,} of 65,536 bytes"}
    made = {"image": str(image.elf), "to be flashed": str(image.hex), **sizes, "table": str(out)}
    _show(table, flags.named(file, preset, overrides), made, json)


def _table(file: Path | None, preset: str | None, overrides: list[str] | None, out: Path) -> Table:
    from frictionloop.device.export import table_of

    checks.check_folder("out", out)
    return table_of(flags.system_from(file, preset or (None if file else "bench"), overrides))


def _show(table: Table, origin: str, made: dict[str, str], json: bool) -> None:
    if json:
        screen.show_json({**table.summary(), **made})
        return
    rows = [("system", origin), *((name, str(value)) for name, value in table.summary().items()), *made.items()]
    screen.show(screen.columns(rows))


app.command(export, usage=f"frictionloop firmware export {ARGUMENTS}", help_epilogue=EXPORT_EXAMPLES)
app.command(build, usage=f"frictionloop firmware build {ARGUMENTS}", help_epilogue=BUILD_EXAMPLES)
