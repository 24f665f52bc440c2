"""The loop of one System as C: its tiles translated, and the numbers that they run on."""

from __future__ import annotations

import ast
from collections.abc import Callable
from pathlib import Path
from string import Template
from typing import Any

from frictionloop.control.laws import law_of
from frictionloop.firmware.c_expressions import filled
from frictionloop.firmware.c_functions import FunctionInC
from frictionloop.firmware.c_types import INT, REAL, VOID, WORD, Kind, Pointer, Struct, Value, bare, identifier, no_c
from frictionloop.firmware.translation import Translation
from frictionloop.loop.kernel import slab_access
from frictionloop.loop.kernel.loop import Tile
from frictionloop.loop.kernel.lowering import lower
from frictionloop.loop.kernel.signal_generation import STREAMS, build_draws
from frictionloop.loop.kernel.step_lifting import Lifting
from frictionloop.loop.kernel.tile_compatibility import kernel_of
from frictionloop.loop.kernel.tile_record import PROGRAMS, SCRATCH, SHARED
from frictionloop.parameters import System
from frictionloop.physics.plate import pulse_step
from frictionloop.quantities.code_version import package_version
from frictionloop.quantities.counter_noise import BLOCK, draw
from frictionloop.quantities.scalar_math import is_compiled

TEMPLATE = Path(__file__).with_name("loop.c.txt")
_KINDS: dict[str, Kind] = {
    "dt": REAL,
    **dict.fromkeys(SCRATCH, Pointer(REAL)),
    **dict.fromkeys(PROGRAMS, Pointer(INT)),
}
RECORD = Struct("Shared", tuple((name, _KINDS.get(name, INT)) for name in SHARED.names or ()))
"""The record of a loop; seeds are drawn with, not computed with."""


class LoopInC:
    """The tiles of the Systems that were lowered here, each translated once."""

    def __init__(self) -> None:
        self.within = Translation(own=OWN)
        self.tiles: dict[Any, str] = {}
        self._normals = self.within.function(draw, [WORD] * 3)[1]
        self._lifting = Lifting(1, _as_it_is, _one)

    def lower(self, system: System, seed: int = 0, **more: Any) -> Tile:
        """Return the numbers of a System, whose programs name the tiles of this C.

        Raises
        ------
        FrictionloopError
            NO-C, for a law in plain Python, a plate driven by pulses, or the paper's rig.
        """
        if not is_compiled(law_of(system.controller).step):
            raise no_c(f"{system.controller.kind}: plain Python")
        if system.plate.pulse_ticks:
            raise no_c("plate.pulse_ticks: math.asin")
        if (kernel := kernel_of(system)) != "substeps":
            raise no_c(f"{kernel}: the paper's rig")
        return lower([system], [seed], compiled=self._tile, **more)

    def _tile(self, width: int, build: Callable[..., Any], *of: Any) -> int:
        key = build, of
        if key not in self.tiles:
            if build is build_draws:
                self.tiles[key] = f"draws_{of[0]}"
            else:
                given: list[Kind] = [Pointer(REAL), INT, INT, INT, Pointer(RECORD)]
                self.tiles[key] = self.within.function(build(self._lifting, *of), given)[0]
        return list(self.tiles).index(key)

    def text(self) -> str:
        """Return the C of all tiles, and of the loop that runs them."""
        record = "".join(f"    _Alignas(8) {kind} {identifier(name)};\n" for name, kind in RECORD.parts)
        return Template(TEMPLATE.read_text(encoding="utf-8")).substitute(
            version=package_version(), record=record, translated=self.within.text(), block=BLOCK,
            Normals=self._normals, draws="".join(map(_draws, STREAMS)), tiles=", ".join(self.tiles.values()),
        )  # fmt: skip


def _as_it_is(function: Any) -> Any:
    return function


def _one(n: int) -> int:
    return 1


def _draws(buffer: str) -> str:
    streams = ", ".join(str(each) for each in STREAMS[buffer])
    return (
        f"static inline void draws_{buffer}(double *s, int64_t n, int64_t first, int64_t periods, Shared *o) {{\n"
        f"    static const uint64_t streams[] = {{{streams}}};\n    (void)s, (void)n, (void)periods;\n"
        f"    draw_streams(o->{buffer}, streams, {len(STREAMS[buffer])}, first, *(const uint64_t *)o->seeds);\n}}\n"
    )


def _address(within: FunctionInC, node: ast.Call) -> Value:
    found: Value = within.visit(node.args[0])
    return found


def _load(within: FunctionInC, node: ast.Call) -> Value:
    cell = _cells(within, node)

    def read(rows: Any) -> Value:
        if not isinstance(rows, tuple):
            return Value(cell(rows), REAL)
        parts = [read(each) for each in rows]
        named = hasattr(rows, "_fields")
        kind = within.within.struct(type(rows)) if named else within.within.plain([each.kind for each in parts])
        return filled(kind, [each.code for each in parts])

    return read(_rows(within, node.args[3]))


def _store(within: FunctionInC, node: ast.Call) -> Value:
    cell, value = _cells(within, node), within.visit(node.args[4])
    if isinstance(value.kind, Struct) and not value.code.isidentifier():
        value = within.evaluated(value)
    done: list[str] = []

    def put(rows: Any, of: Value) -> None:
        if not isinstance(rows, tuple):
            done.append(f"{cell(rows)} = {bare(of.code)}")
            return
        parts = of.kind.parts if isinstance(of.kind, Struct) else ()
        for each, (name, kind) in zip(rows, parts, strict=True):
            put(each, Value(f"{of.code}.{identifier(name)}", kind))

    put(_rows(within, node.args[3]), value)
    return Value(", ".join(done) or "(void)0", VOID)


def _cells(within: FunctionInC, node: ast.Call) -> Callable[[int | str], str]:
    slab, lane, width = (within.visit(each).code for each in node.args[:3])
    return lambda row: f"{slab}[{row} * {width} + {lane}]"


def _rows(within: FunctionInC, node: ast.expr) -> Any:
    """Return row numbers in their shape: whole numbers, and C of those that are worked out."""
    if isinstance(node, ast.Tuple):
        return tuple(_rows(within, each) for each in node.elts)
    root = node
    while isinstance(root, ast.Attribute):
        root = root.value
    known = isinstance(root, ast.Name) and root.id not in within.kinds
    return within.resolved(node) if known else within.number(node).code


def _no_pulses(_within: FunctionInC, _node: ast.Call) -> Value:
    return Value("NAN", REAL)  # `LoopInC.lower` takes no plate that is driven by pulses


OWN = {pulse_step: _no_pulses, slab_access.doubles: _address, slab_access.load: _load, slab_access.store: _store}
"""How compiled code reaches the numbers of a slab."""
