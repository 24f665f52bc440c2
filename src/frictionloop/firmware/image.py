"""Build the image of a board: the C core, the board's own files and the parameters of a bench in one ELF file."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from frictionloop.firmware.board_compatibility import USUAL_TICKS
from frictionloop.firmware.build_identity import revision_here
from frictionloop.firmware.c_types import literal
from frictionloop.firmware.host_compiler import run, zig
from frictionloop.firmware.image_files import check, memory_map, seal, sizes
from frictionloop.firmware.image_law import BoardLaw
from frictionloop.quantities import must_be
from frictionloop.quantities.optional_libraries import needed
from frictionloop.quantities.protocol_schema import firmware_folder, word_count
from frictionloop.quantities.whole_files import replacing

BOARDS = {
    "teensy41": ("main.c",), "teensy41-ads8688": ("main.c",), "mps2": ("main.c", "stimulus.c"),
    "mps2-scenario": ("scenario.c", "stimulus.c"),
}  # fmt: skip
"""Boards with the files they share with others; after the hyphen another converter or program on the same board."""
_WITHOUT = {"teensy41": "ads8688.c", "teensy41-ads8688": "converters.c", "mps2": "scenario_main.c"}
"""File of its folder that a board leaves out."""
CHECK_SUM = "flash_crc"
"""Where a board has the check sum of its flash."""
FLASHED = "teensy41"
"""The board of these whose image is flashed; the others are qemu's."""
BACKGROUND = frozenset(
    (
        "app_messages.c", "app_replies.c", "app_parameters.c", "app_session.c", "app_start.c", "app_waveform.c",
        "fl_crc.c", "fl_effect_wrong.c", "fl_frame.c", "scenario_main.c", "startup.c", "whole.c", "clock.c", "port.c",
        "protection.c",
    )
)  # fmt: skip
"""Files of which the tick runs next to nothing: small rather than quick."""
_COMMON = (
    "-std=c11", "-g", "-Wall", "-Wextra", "-Werror", "-ffreestanding", "-fno-unwind-tables", "-ffunction-sections",
    "-fdata-sections", "-ffp-contract=off", "-fno-math-errno", "-fno-sanitize=all",
)  # fmt: skip
_CORTEX_M7 = ("-target", "thumb-freestanding-eabihf", "-mcpu=cortex_m7+fp_armv8d16")
"""Without the unit's name its registers pass arguments, and the arithmetic is soft all the same."""


@dataclass(frozen=True)
class Image:
    """A built image.

    Attributes
    ----------
    elf, hex, map
        The files: for emulators and debuggers; to be flashed (Intel hex); every symbol with address and size.
    flash_bytes, ram_bytes
        What it takes of either, the stack included.
    """

    elf: Path
    hex: Path
    map: Path
    flash_bytes: int
    ram_bytes: int


def build(
    board: str,
    parameters: Sequence[float],
    law: BoardLaw,
    folder: Path,
    *,
    rate_hz: int,
    carrier_ticks: int = USUAL_TICKS,
    optimise: str | None = None,
) -> Image:
    """Build the image of a board and check it.

    Parameters
    ----------
    board
        One of `BOARDS`.
    parameters
        The words in force at reset.
    law
        Beside the lookup; the table's.
    folder
        Where ``<board>.elf``, ``.hex`` and ``.map`` are written; made if it is missing.
    rate_hz
        Of the ticks.
    carrier_ticks
        Period of the carrier, `board_fit.period_ticks` of the system; those of qemu have none.
    optimise
        Level of optimisation for all files: 0, 1, 2, 3 or s; the budget of memory is then not held against the image.
        By default 2 for what the tick runs, and s for `BACKGROUND`.

    Raises
    ------
    FrictionloopError
        For an unknown board, a table of another length, a missing ziglang, sources that do not compile, and an image
        that fails `image_files.check`.
    """
    if board not in BOARDS or not _home(board).is_dir():
        raise must_be("board", board, " or ".join(each for each in BOARDS if _home(each).is_dir()), code="UNKNOWN-NAME")
    needed("ziglang", "ziglang", "image")
    table = _checked(parameters)
    define = (f"-DFL_TICK_HZ={rate_hz}", f"-DFL_CARRIER_TICKS={carrier_ticks}")
    folder.mkdir(parents=True, exist_ok=True)
    built = folder / "built.c"
    built.write_text(_built(table), encoding="ascii")
    own = [built.resolve(), law.write(folder).resolve()]
    elf = folder / f"{board}.elf"
    with replacing(elf) as fresh:
        _compile_and_link(board, own, fresh.resolve(), define, optimise)
        seal(fresh, CHECK_SUM)
        check(fresh, teensy=_home(board).name == FLASHED, budget=optimise is None)
    flash, ram = sizes(elf)
    return Image(elf, _hex(elf), memory_map(elf), flash, ram)


def _sources(board: str) -> list[Path]:
    boards, home = firmware_folder() / "boards", _home(board)
    return [
        *sorted((firmware_folder() / "core").glob("*.c")),
        *(path for path in sorted(home.glob("*.c")) if path.name != _WITHOUT.get(board)),
        *(boards / name for name in BOARDS[board]),
        boards / "whole.c",
        boards / "freestanding" / "memory.c",
    ]


def _home(board: str) -> Path:
    return firmware_folder() / "boards" / board.partition("-")[0]


def _compile_and_link(board: str, own: Sequence[Path], elf: Path, define: Sequence[str], optimise: str | None) -> None:
    boards, core, home = firmware_folder() / "boards", firmware_folder() / "core", _home(board)
    command = (*zig(), *_CORTEX_M7)
    include = [f"-I{path}" for path in (boards / "freestanding", core, boards, home)]
    levels: dict[str, list[Path]] = {}
    fails = f"{board}: does not build"
    for source in (*_sources(board), *own):
        levels.setdefault(optimise or ("s" if source.name in BACKGROUND else "2"), []).append(source)
    with TemporaryDirectory() as objects:
        for level, sources in levels.items():
            run([*command, *_COMMON, *define, *include, f"-O{level}", "-c", *map(str, sources)], fails, Path(objects))
        made = [str(path) for path in sorted(Path(objects).glob("*.o"))]
        script = f"-Wl,-T,{home / 'link.ld'},--gc-sections"
        run([*command, "-g", "-O2", script, *made, "-o", str(elf)], fails, Path(objects))


def _checked(words: Sequence[float]) -> Sequence[float]:
    if len(words) != word_count():
        raise must_be("parameters", len(words), str(word_count()), "words")
    wrong = next((k for k, word in enumerate(words) if not math.isfinite(word)), None)
    if wrong is not None:
        raise must_be(f"parameters[{wrong}]", words[wrong], "finite")
    return words


def _built(words: Sequence[float]) -> str:
    numbers = ", ".join(map(literal, map(float, words)))
    return (
        '#include "built.h"\n'
        f"const fl_built fl_built_parameters = {{.words = {{{numbers}}}}};\n"
        f'const char fl_built_revision[] = "{revision_here()}";\n'
    )


def _hex(elf: Path) -> Path:
    """Write the Intel hex file beside the ELF file, with zig's objcopy."""
    path = elf.with_suffix(".hex")
    with replacing(path) as fresh:
        run([*zig()[:-1], "objcopy", "-O", "hex", str(elf), str(fresh)], f"{path}: cannot be made")
    return path
