"""Which tiles make up the loop of a tile of systems, and in which order they run."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

from frictionloop.control.law import Law
from frictionloop.control.laws import law_of
from frictionloop.loop.kernel.bench_loop import build_move, build_sense
from frictionloop.loop.kernel.driven_tile import build_driven, build_swing
from frictionloop.loop.kernel.fixed_tile import build_fixed
from frictionloop.loop.kernel.law_tile import build_law
from frictionloop.loop.kernel.lower_signals import Signal
from frictionloop.loop.kernel.noise_tile import build_draws
from frictionloop.loop.kernel.oracle_tile import build_oracle
from frictionloop.loop.kernel.paper_tile import build_paper
from frictionloop.loop.kernel.python_law import PythonLaw, build_lookup
from frictionloop.loop.kernel.shared import Shared
from frictionloop.loop.kernel.signals import FORMULAS, build_formula, build_samples
from frictionloop.loop.kernel.slab import Slab
from frictionloop.loop.kernel.structure import contact_of, is_irregular, kernel_of, moves
from frictionloop.loop.kernel.switch_tile import build_prepare, build_tell
from frictionloop.loop.kernel.tally_tile import build_tally
from frictionloop.loop.kernel.tiles import compiled_tile
from frictionloop.loop.kernel.timing_tile import build_keep, build_restore
from frictionloop.loop.kernel.traces import build_record
from frictionloop.loop.metric import Tally
from frictionloop.parameters import OracleController, System
from frictionloop.physics.vibration import vibration_of
from frictionloop.quantities.arithmetic import is_compiled


def set_programs(
    shared: Shared,
    slab: Slab,
    system: System,
    setpoint: Signal,
    disturbance: Signal,
    places: Mapping[Tally, int],
) -> None:
    """Let a record run the tiles of a system's loop, compiled or from the disk."""
    of = partial(_tile, slab.width)
    tallied = [of(build_tally, *each) for each in places.items()]
    if kernel_of(system) == "quadrature":
        shared.program("blocks", [*_blocks(of, setpoint, disturbance, driven=True), of(build_draws, "normals")])
        shared.program("extras", tallied)
        shared.set(whole=of(build_paper))
        return
    drawn = [name for name, used in (("normals", True), ("draws", moves(system)), ("timing", shared.irregular)) if used]
    blocks = _blocks(of, setpoint, disturbance, driven=False)
    shared.program("blocks", [*blocks, *(of(build_draws, buffer) for buffer in drawn)])
    plant = contact_of(system), vibration_of(system.friction), moves(system)
    sense, move = of(build_sense, *plant), of(build_move, *plant)
    told = [*tallied, *([of(build_record, "substeps")] if shared.trace_size else [])]
    if shared.external:
        shared.program("obeys", [move])
        shared.program("ticks", [sense, *told])
    else:
        shared.program("ticks", [sense, *_decides(of, shared, slab, system, plant[:2]), *told, move])


def _tile(width: int, build: Any, *of: Any) -> int:
    return int(compiled_tile(build, width, *of).address)


def _blocks(of: Any, setpoint: Signal, disturbance: Signal, *, driven: bool) -> list[int]:
    """Return the tiles that make the signals of a block; ``driven`` also what the disturbance adds to the reading."""
    tiles = [_signal(of, "setpoint", setpoint)]
    if driven and disturbance.how == "sine":
        return [*tiles, of(build_swing)]
    return [*tiles, _signal(of, "disturbance", disturbance), *([of(build_driven)] if driven else [])]


def _signal(of: Any, which: str, signal: Signal) -> int:
    if signal.how in FORMULAS:
        return int(of(build_formula, which, signal.how))
    return int(of(build_samples, which, signal.how == "held"))


def _decides(of: Any, shared: Shared, slab: Slab, system: System, plant: tuple[Any, ...]) -> list[int]:
    """Return the tiles of a tick of the controller."""
    controller, irregular = system.controller, is_irregular(system)
    law: Law | None = None
    if isinstance(controller, OracleController):
        tiles = [of(build_oracle, *plant, controller.preview)]
    elif controller.form == "firmware":
        tiles = [of(build_fixed)]
    else:
        law = law_of(controller)
        tiles = [of(build_law, law)] if is_compiled(law.step) else _python(of, shared, slab, law)
        if shared.open_until > 0:
            tiles = [of(build_prepare, law), *tiles, of(build_tell, law)]
    return [of(build_keep, law), *tiles, of(build_restore, law)] if irregular else tiles


def _python(of: Any, shared: Shared, slab: Slab, law: Law) -> list[int]:
    """Return the tiles of a law in plain Python."""
    shared.python = PythonLaw(law, slab, shared.dt)
    return [shared.python.address, of(build_lookup, law)]
