"""``frictionloop firmware``: a bench as the parameter table of the microcontroller, and as an image to be flashed."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from frictionloop.cli import checks, flags, screen
from frictionloop.quantities.extra import all_needed

if TYPE_CHECKING:
    from frictionloop.firmware.export import Table
    from frictionloop.parameters import System

ARGUMENTS = "[FILE] --out FOLDER [OPTIONS]"
EXPORT_EXAMPLES = r"""Examples

  frictionloop firmware export --preset bench --out my-table
  frictionloop firmware export my-controller.toml --out my-table
"""
BUILD_EXAMPLES = r"""Examples

  frictionloop firmware build --preset bench --controller.kind notch_pi --out my-image
  frictionloop firmware build my-controller.toml --out my-image --laws pi,notch_pi
  frictionloop firmware build my-controller.toml --out my-image --board mps2
"""
ELSEWHERE = "a reference image with two force axes, not on this one,"
RINGS = (
    "these gains are unstable on this bench: not for a finger; `frictionloop design controller` finds some that hold"
)
Out = Annotated[Path, Parameter(help="Folder for the files; made if it is missing.", group=flags.RESULT)]


def export(
    file: flags.SystemFile = None,
    /,
    *,
    preset: flags.BenchPreset = None,
    overrides: flags.Overrides = None,
    out: Out,
    json: flags.Json = False,
) -> None:
    """Write the parameter table of a system: as words for the device, as numbers with units, and the system itself."""
    table, origin = _table(file, preset, overrides, out)
    table.write(out)
    _show(table, origin, {}, [("table", str(out))], json)


def build(
    file: flags.SystemFile = None,
    /,
    *,
    preset: flags.BenchPreset = None,
    overrides: flags.Overrides = None,
    board: flags.Run[str] = "teensy31",
    laws: flags.Run[str | None] = None,
    out: Out,
    json: flags.Json = False,
) -> None:
    """Build the image that runs a system's controller: .elf, .hex (to be flashed), .map; with the table beside it.

    Parameters
    ----------
    board
        teensy31, or mps2 or mps2-scenario for qemu-system-arm.
    laws
        Kinds of controller that the image has, with commas: pi,notch_pi; all by default. filtered_pi also
        runs notch_pi.
    """
    all_needed("ziglang", "elftools", "cobs", "fastcrc", "intelhex")
    table, origin = _table(file, preset, overrides, out)

    from frictionloop.device.emulator.memory_map import FLASH_BYTES, RAM_BYTES
    from frictionloop.firmware.board_fit import period_ticks
    from frictionloop.firmware.image import FLASHED
    from frictionloop.firmware.image import build as build_image

    with screen.waiting(f"building the image of {board}; the first time takes half a minute"):
        kinds = laws.split(",") if laws is not None else None
        image = build_image(board, table.words.tolist(), out, laws=kinds, carrier_ticks=period_ticks(table.system))
    cycles = _traced(str(image.elf)) if board == FLASHED else None
    table.write(out)
    sizes = {"flash_bytes": image.flash_bytes, "ram_bytes": image.ram_bytes}
    made: dict[str, Any] = {"board": board, "image": str(image.elf), "hex": str(image.hex), **sizes, "cycles": cycles}
    to_flash = board == FLASHED
    rows = [
        ("image", made["image"]),
        ("to be flashed" if to_flash else f"of {board}", made["hex"]),
        ("flash", f"{image.flash_bytes:,}" + (f" of {FLASH_BYTES:,} bytes" if to_flash else " bytes")),
        ("memory", f"{image.ram_bytes:,}" + (f" of {RAM_BYTES:,} bytes" if to_flash else " bytes")),
        ("table", str(out)),
    ]
    _show(table, origin, made, rows, json)
    if cycles and not json:
        screen.show("", *_cycle_lines(cycles))


def _traced(image: str) -> dict[str, dict[str, int]] | None:
    """Return what the cycles of a tick period go to, by what is assumed of the waits; None without an emulator."""
    from importlib.util import find_spec

    if not (find_spec("unicorn") and find_spec("capstone")):
        return None
    from frictionloop.device.emulator.budget import traced

    with screen.waiting("tracing the image in an emulator"):
        return traced(image).table()


def _cycle_lines(cycles: dict[str, dict[str, int]]) -> list[str]:
    """Return the cycles as a table, and what they say."""
    from frictionloop.control.cost import BUDGET_CYCLES
    from frictionloop.device.emulator.budget import LATE_CYCLES, LATE_US

    heads = ("tick", "interrupts", "background", "sum")
    lines = [f"cycles of {BUDGET_CYCLES:,} a tick, of this image{'':10s}" + "".join(f"{head:>12s}" for head in heads)]
    for name, row in cycles.items():
        lines.append(f"  {name:46s}" + "".join(f"{row[head]:12,d}" for head in heads))
    first = next(iter(cycles.values()))
    longest, left = first["longest_interrupt"], BUDGET_CYCLES - first["tick"] - first["interrupts"]
    verdict = "less" if longest <= LATE_CYCLES else "MORE"
    lines += [
        f"With the effect that takes longest, the tick is {first['effect']:,} cycles.",
        f"The port interrupts for {longest:,} cycles at most, {verdict} than the {LATE_US} us that make a tick late.",
        f"A host that never stops asks {first['flood']:,} cycles of the {left:,} left to the background"
        + ("." if first["flood"] <= left else ": some of its frames are lost, and no tick."),
    ]
    return [*lines, *_over(cycles)]


def _over(cycles: dict[str, dict[str, int]]) -> list[str]:
    """Return what it means that a row's sum exceeds a tick, if one does."""
    from frictionloop.control.cost import BUDGET_CYCLES

    over = {name: row["tick"] + row["interrupts"] for name, row in cycles.items() if row["sum"] > BUDGET_CYCLES}
    if not over:
        return []
    late = max(over.values()) > BUDGET_CYCLES
    then = "TICKS ARE LATE THEN" if late else "ticks are on time then too, and the background lags behind"
    return [
        f"Above {BUDGET_CYCLES:,} in sum: {', '.join(over)}. With tick and interrupts {max(over.values()):,}, {then}."
    ]


def _table(file: Path | None, preset: str | None, overrides: list[str] | None, out: Path) -> tuple[Table, str]:
    from frictionloop.firmware.export import Table
    from frictionloop.firmware.parameter_words import firmware_words

    checks.check_folder("out", out)
    system, origin = flags.noted(file, preset, overrides, "bench")
    return Table(system, firmware_words(system)), origin


def _show(table: Table, origin: str, made: dict[str, Any], rows: list[tuple[str, str]], json: bool) -> None:
    from frictionloop.firmware.board_fit import misfits

    found, unfit, stable = table.summary(), misfits(table.system), _stable(table.system)
    if json:
        told = {"system": origin, **found, **made, "table": rows[-1][1], "misfits": unfit, "stable": stable}
        screen.show_json(told)
        return
    low_n, high_n = found["clamp_n"]
    traced, worst, where = (
        made.get("cycles"),
        found["worst_tick_cycles"],
        ELSEWHERE,
    )
    if traced:
        worst, where = next(iter(traced.values()))["tick"], "this image"
    cost = f"worst tick {worst:,} of {found['tick_cycles']:,} cycles, traced on {where} in an emulator"
    about: list[tuple[str, ...]] = [
        *_inside(table.system),
        ("clamp", f"{low_n:.4g} to {high_n:.4g} N"),
        ("ceiling", _ceiling(table.system)),
        ("cost", cost if worst else "not traced"),
        ("words", f"{found['words']}, layout {found['layout']}, values {found['values']}"),
    ]
    wrong = [("DOES NOT FIT" if k == 0 else "", line) for k, line in enumerate(unfit)]
    if stable is False:
        wrong.append(("RINGS", RINGS))
    screen.show(screen.columns([("system", origin), *wrong, *about, *rows]))


def _stable(system: System) -> bool | None:
    """Tell whether the linear loop is stable at the forces asked for, dry and moist; None where that is not known."""
    from frictionloop.cli.ringing import points_of
    from frictionloop.quantities import FrictionloopError

    try:
        return all(each.is_stable() for each in points_of(system))
    except FrictionloopError:
        return None


def _ceiling(system: System) -> str:
    """Return the largest amplitude that the board ever commands, whose it is, and which forces it leaves out."""
    from frictionloop.analysis.operating import asked, law_at
    from frictionloop.physics.friction import friction_force
    from frictionloop.quantities import FrictionloopError

    if (own := system.board.ceiling_um) is not None:
        said = f"{own:g} um, board.ceiling_um"
        try:
            least_n, wanted = float(friction_force(own, law_at(system))), asked(system)
        except FrictionloopError:  # a recording whose level is not known
            return said
        if wanted.low_n >= least_n:
            return said
        none = "NO" if wanted.high_n < least_n else "not every"
        return (
            f"{said}, for a first run: {none} force asked for, {wanted.low_n:.3g} to {wanted.high_n:.3g} N, is reached "
            f"on the file's finger just landed, which has {least_n:.3g} N there"
        )
    return (
        f"{system.plate.max_amplitude_um:g} um, the plate's largest; for a first run set board.ceiling_um, such as 0.5"
    )


def _inside(system: System) -> list[tuple[str, str]]:
    """Return what of a system is in the words: its law with the gains, the delay it is for, and the carrier."""
    from frictionloop.cli import describe
    from frictionloop.firmware.board_fit import carrier_said

    controller = system.controller
    law = next(row[1] for row in describe.system_rows(system) if row[0] == "controller")
    whole_us = 1e6 * (controller.delay_s + 0.5 / controller.rate_hz)
    carrier = [("carrier", said)] if (said := carrier_said(system)) else []
    delay = f"{1e6 * controller.delay_s:g} us from sample to amplitude, {whole_us:.4g} us with half the hold"
    return [("law", law), *carrier, ("loop delay", delay)]
