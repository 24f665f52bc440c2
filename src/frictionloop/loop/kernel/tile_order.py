"""Which tiles make up the loop of a tile of systems, and in which order they run."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from frictionloop.control.laws import law_of
from frictionloop.loop.kernel.bench_tile import build_guide, build_move, build_sense
from frictionloop.loop.kernel.foreign_tile import PythonLaw, build_effect
from frictionloop.loop.kernel.irregular_ticks import build_lost, build_prepare, build_tell
from frictionloop.loop.kernel.law_tile import build_law
from frictionloop.loop.kernel.lower_blocks import Signal
from frictionloop.loop.kernel.paper_tile import build_paper
from frictionloop.loop.kernel.signal_generation import build_draws, build_driven, build_signal
from frictionloop.loop.kernel.slab_columns import Slab
from frictionloop.loop.kernel.tile_compatibility import contact_of, effect_of, is_irregular, moves
from frictionloop.loop.kernel.tile_record import Shared
from frictionloop.loop.kernel.traces import build_record, build_tally
from frictionloop.loop.metric import Tally
from frictionloop.parameters import System
from frictionloop.physics.vibration import vibration_of
from frictionloop.quantities.scalar_math import is_compiled


def set_programs(
    shared: Shared,
    slab: Slab,
    system: System,
    kernel: str,
    setpoint: Signal,
    disturbance: Signal,
    places: Mapping[Tally, int],
    compiled: Callable[..., int],
) -> None:
    """Let a record run the tiles of a system's loop, compiled or from the disk."""
    of, quadrature = partial(compiled, slab.width), kernel == "quadrature"
    sine = quadrature and disturbance.how == "sine"
    kinds = disturbance.how, disturbance.shared
    effect = effect_of(system)
    blocks = [] if effect else [of(build_signal, "setpoint", setpoint.how, setpoint.shared, False)]
    blocks += [of(build_signal, "disturbance", *kinds, not sine)]
    if quadrature:
        blocks += [of(build_signal, "driven", *kinds, False) if sine else of(build_driven, disturbance.shared)]
    drawn = {"normals": True, "draws": moves(system), "timing": shared.irregular}
    alike = bool(shared.noise_shared)
    shared.program("blocks", [*blocks, *(of(build_draws, each, alike) for each, used in drawn.items() if used)])
    told = [of(build_tally, *each) for each in places.items()]
    if quadrature:
        shared.program("extras", told)
        shared.set(whole=of(build_paper, shared.table_size > 0))
        return
    plant = contact_of(system), vibration_of(system.friction), moves(system)
    sense, move = of(build_sense, *plant), of(build_move, *plant)
    told += [of(build_record, "effect" if effect else "substeps")] if shared.trace_size else []
    told = [*([of(build_effect, effect.is_plain)] if effect and shared.external else []), *told]
    if shared.external:
        shared.program("obeys", [move])
        shared.program("ticks", [sense, *told])
    else:
        asks = [of(build_effect, effect.is_plain)] if effect else []
        guide = [of(build_guide)] if shared.given else []
        shared.program("ticks", [sense, *asks, *_decides(of, shared, slab, system), *told, *guide, move])


def _decides(of: Any, shared: Shared, slab: Slab, system: System) -> list[int]:
    """Return the tiles of a tick of the controller."""
    law = law_of(system.controller)
    tiles = [of(build_law, law, shared.table_size > 0)]
    if not is_compiled(law.step):
        shared.python = PythonLaw(law, slab, shared.dt)
        tiles = [shared.python.address, *tiles]
    if shared.open_until > 0:
        tiles = [of(build_prepare, law), *tiles, of(build_tell)]
    return [of(build_lost, law, False), *tiles, of(build_lost, law, True)] if is_irregular(system) else tiles
