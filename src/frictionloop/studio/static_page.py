"""The live page as one file that needs no server: both loops as WebAssembly, and the numbers of its choices."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from frictionloop.firmware.host_compiler import run, zig
from frictionloop.live.live_engines import TwinEngine
from frictionloop.loop.kernel.tile_record import SHARED
from frictionloop.loop.kernel.traces import traces_of
from frictionloop.loop.live_loop import state_rows
from frictionloop.parameters import System
from frictionloop.parameters.presets import RETUNED
from frictionloop.physics.fingers import fingers
from frictionloop.preview.prepared_stroke import skin_n_mm
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.optional_libraries import needed
from frictionloop.rendering.effect import TURNS_MM_S
from frictionloop.rendering.effect_setpoint import EffectSource
from frictionloop.studio.commands import PRESETS
from frictionloop.studio.effect_feasibility import lines_mm, steepest
from frictionloop.studio.effect_pictures import CELL_MM, effects, map_of
from frictionloop.studio.offline_choices import MOST, Axes, Axis, Choices, PageBench, axes_of
from frictionloop.studio.parallel_fingers import PEOPLE, POPULATION_SEED
from frictionloop.studio.parameter_panels import differences, effect_name, panels_of
from frictionloop.studio.replay import one_page, packed
from frictionloop.studio.server import hello_message

MORE = "pip install 'frictionloop[studio]' && frictionloop studio"
"""What has all that a page without a server lacks."""
LAWS = ("notch_pi", "limit_observer", "filtered_pi", "pi", "lookup")
STOPS: dict[str, list[float]] = {
    "plate.max_amplitude_um": [round(0.1 * n, 1) for n in range(5, 41)],
    "plate.q": [20.0, 50.0, 100.0, 150.0, 200.0, 230.0, 300.0, 400.0, 600.0, 1000.0],
    "friction.nominal_n": [round(0.05 * n, 2) for n in range(4, 41)],
    "friction.occlusion_ratio": [round(1.0 + 0.2 * n, 1) for n in range(16)],
    "friction.static_ratio": [round(1.0 + 0.1 * n, 1) for n in range(11)],
    "sensor.resonance_hz": [60.0, 80.0, 100.0, 120.0, 135.0, 145.0, 155.0, 170.0, 200.0, 250.0, 300.0, 400.0],
    "sensor.noise_density_n_rthz": [0.0, 1e-6, 2.3e-6, 5e-6, 1e-5, 2e-5, 5e-5],
}
GAINS: dict[str, list[float]] = {
    "controller.delay_s": [round(50e-6 * n, 6) for n in range(21)],
    "controller.kp": [0.0, 0.062, 0.2, 0.5, 1.0, 2.0, 3.0, 3.8, 5.0, 7.0, 10.0, 15.0],
    "controller.ki": [0.0, 2.0, 20.0, 50.0, 80.0, RETUNED["controller.ki"], 150.0, 200.0, 400.0, 800.0],
}
ZIG = (
    "-target", "wasm32-freestanding", "-O3", "-ffreestanding", "-nostdlib", "-ffp-contract=off", "-fno-math-errno",
    "-fno-sanitize=all", "-w", "-Wl,--no-entry", "-Wl,--export=advance", "-Wl,--export=__heap_base", "-Wl,--strip-all",
)  # fmt: skip
BUILDS = {"fused": ("-DFUSED", "-mcpu=generic+simd128+relaxed_simd"), "exact": ("-DEXACT",)}
"""WebAssembly has no fma: a build with instructions that may fuse, and one that works each out."""
_HIDDEN = "#save-csv,#save-h5,#save-toml,#tools,#open-effect,#open-file,[data-box=motion],[data-box=board]"


def play_page(system: System, seed: int = 0) -> str:
    """Return the live page of a System as HTML in one piece.

    Raises
    ------
    FrictionloopError
        NO-C for what has no C; STUDIO-NO-SUM where its choices do not add up; or a missing extra.
    """
    needed("ziglang", "ziglang", "image")
    text = one_page("index.html", "frictionloop studio", "bench", page_data(system, seed), {"link.js": "page-link.js"})
    hidden = f"<style>{_HIDDEN}{{display:none}}</style></head>"
    told = "Painting, files, devices, all parameters"
    more = f'<footer><p class="hint">{told}: <code>{MORE.replace("&&", "&amp;&amp;")}</code></p>'
    return text.replace("</head>", hidden, 1).replace("<footer>", more, 1)


def page_data(system: System, seed: int) -> dict[str, Any]:
    """Return what a page computes with and shows, as plain data."""
    bench, blob = PageBench(system, seed), Blob()
    choices = choices_of(system)
    axes = axes_of(bench, choices)
    start = {"law": system.controller.kind, "effect": effect_name(system), "finger": "", "stops": {}}
    return {
        "hello": hello_message(system, ""),
        "more": MORE,
        "rate": system.controller.rate_hz,
        "limits": {"touch_n": system.touch.load.touch_n, "turns_mm_s": TURNS_MM_S},
        "start": start,
        "most": MOST,
        "names": traces_of(system),
        "fields": {name: index for index, name in enumerate(SHARED.names or ())},
        "base": {name: blob.add(words) for name, words in bench.base.items()},
        "shape": blob.add(bench.shape.view(np.uint64)),
        "axes": _axes_told(axes, blob),
        "laws": {law: _law_told(system.evolve(values), choices, law) for law, values in choices.laws.items()},
        "panels": {box: _sliders(fields, choices.stops) for box, fields in panels_of(system).items()},
        "effects": {name: each["setpoint.effect"].model_dump(mode="json") for name, each in choices.effects.items()},
        "fingers": {"": {}, **choices.fingers},
        "presets": {each.name: each.values for each in PRESETS},
        "steep": {name: steep(system.evolve(values)) for name, values in choices.effects.items()},
        "maps": {name: packed(map_of(system.evolve(values))) for name, values in choices.effects.items()},
        "wasm": {build: packed(wasm(bench.loop.text(), flags)) for build, flags in BUILDS.items()},
        "proof": blob.add(proof(system, seed)),
        "blob": blob.text(),
    }  # fmt: skip


def choices_of(system: System) -> Choices:
    """Return what can be chosen on the page of a System."""
    people = {
        f"finger {number + 1}": {path: value for path, value in person.items() if not path.startswith("motion.")}
        for number, person in enumerate(fingers(PEOPLE, POPULATION_SEED))
    }
    kinds = {law: {"controller.kind": law} for law in dict.fromkeys((system.controller.kind, *LAWS))}
    laws = {law: values for law, values in kinds.items() if _accepts(system, values)}
    own = {} if effect_name(system) else {"": getattr(system.setpoint, "effect", None)}
    return Choices(
        laws,
        {name: {"setpoint.effect": effect} for name, effect in (own | effects()).items()},
        {name: person for name, person in people.items() if _accepts(system, person)},
        _accepted(system, STOPS),
        {law: _accepted(system.evolve(values), GAINS) for law, values in laws.items()},
    )


def steep(system: System) -> list[list[int]]:
    """Return where an effect is steeper than the skin follows, by line of the plate: cells of `CELL_MM`."""
    source, half = system.setpoint, system.touch.load.length_mm / 2
    if not isinstance(source, EffectSource):
        return []
    place = np.arange(-half, half, CELL_MM) + CELL_MM / 2
    slope = steepest(source, place, lines_mm(source))[2]
    return [np.flatnonzero(row > skin_n_mm(system)).tolist() for row in slope]


def _accepted(system: System, stops: Mapping[str, Sequence[float]]) -> dict[str, list[float]]:
    """Return the sliders that a System has, each with the stops that it accepts and its own value."""
    found: dict[str, list[float]] = {}
    for path, values in stops.items():
        block, name = path.split(".")
        own = getattr(getattr(system, block), name, None)
        for value in sorted({*values, own}) if isinstance(own, float) else ():
            if _accepts(system, {path: value}):
                found.setdefault(path, []).append(value)
    return found


def _accepts(system: System, values: Mapping[str, Any]) -> bool:
    """Tell whether a System can have these values: not a delay, say, that its feed-forward does not follow."""
    with suppress(FrictionloopError):
        system.evolve(values)
        return True
    return False


class Blob:
    """Words of all arrays, one after the other, packed as differences with all first bytes first."""

    def __init__(self) -> None:
        self._parts: list[bytes] = []
        self._words = 0
        self._known: dict[bytes, list[int]] = {}

    def add(self, words: np.ndarray) -> list[int]:
        """Return where words are, and how many."""
        if (key := words.tobytes()) not in self._known:
            self._known[key] = [self._words, len(words)]
            steps = np.diff(words, prepend=np.zeros(1, np.uint64))
            self._parts.append(steps.view(np.uint8).reshape(-1, 8).T.tobytes())
            self._words += len(words)
        return self._known[key]

    def text(self) -> str:
        """Return all of it, compressed."""
        return packed(b"".join(self._parts))


def _axes_told(axes: Axes, blob: Blob) -> dict[str, Any]:
    def told(axis: Axis) -> dict[str, Any]:
        places = {name: None if at is None else at.tolist() for name, at in axis.places.items()}
        words = [{name: blob.add(each) for name, each in some.items()} for some in axis.words]
        return {"choices": axis.choices, "places": places, "words": words}

    return {
        **{name: told(axis) for name, axis in zip(Axes._fields[:3], axes[:3], strict=True)},
        "stops": {path: told(axis) for path, axis in axes.stops.items()},
        "gains": {law: {path: told(axis) for path, axis in own.items()} for law, own in axes.gains.items()},
    }


def _law_told(system: System, choices: Choices, law: str) -> dict[str, Any]:
    fields = [field for field in panels_of(system)["controller"] if field["path"].startswith("controller.")]
    values = {field["path"]: field["value"] for field in fields if field["path"].count(".") == 1}
    shown = [field | {"choices": list(choices.laws)} for field in fields if field["path"] == "controller.kind"]
    changed = {path: value for path, value in differences(system).items() if path != "setpoint.effect"}
    return {
        "panel": [*shown, *_sliders(fields, choices.gains[law])],
        "values": values,
        "differs": changed,
        "state": state_rows(system),
    }


def _sliders(fields: list[dict[str, Any]], stops: Any) -> list[dict[str, Any]]:
    """Return the fields that have stops, from the first to the last of them."""
    return [f | {"low": stops[f["path"]][0], "high": stops[f["path"]][-1]} for f in fields if f["path"] in stops]


def wasm(text: str, flags: tuple[str, ...]) -> bytes:
    """Return the C of a loop as WebAssembly."""
    with tempfile.TemporaryDirectory() as folder:
        source, out = Path(folder) / "loop.c", Path(folder) / "loop.wasm"
        source.write_text(text, encoding="utf-8")
        run([*zig(), *ZIG, *flags, str(source), "-o", str(out)], "page: does not compile")
        return out.read_bytes()


def proof(system: System, seed: int) -> np.ndarray:
    """Return the words of all channels of 64 periods of the simulator's loops, under the path that the page runs."""
    k = np.arange(64.0)
    path = np.stack([1e-5 * k, np.full(64, 0.05), np.full(64, 0.5)], axis=1)
    return np.ascontiguousarray(TwinEngine(system, seed).advance(path)).view(np.uint64).ravel()
