"""A System in short: of each block its kind, what differs, what follows; gains for a person; parameters by a word."""

from __future__ import annotations

from typing import Any, NamedTuple

from pydantic import BaseModel

from frictionloop.findings.shown import shown
from frictionloop.parameters.aliases import meant
from frictionloop.parameters.controller import Timing
from frictionloop.parameters.motion import Strokes
from frictionloop.parameters.plant import ResonantPlate, Skin, SuspendedSensor
from frictionloop.parameters.refusals import known_names
from frictionloop.parameters.system import Board, System
from frictionloop.quantities import must_be, unit_of


def own_values(system: System) -> dict[str, Any]:
    """Return the values of a law beside those that every controller has."""
    return {name: value for name, value in system.controller if name not in {*Timing.model_fields, "kind"}}


def gains_said(system: System) -> str:
    """Return the values of a law for a person: kp 7.26   ki 64.7 1/s   notch 132 Hz   no overdrive."""
    told, without = [], []
    for name, value in own_values(system).items():
        if isinstance(value, (list, tuple)):
            told.append(f"{len(value)} {name}")
        elif not isinstance(value, bool):
            word = name.removesuffix("_hz").removeprefix("notch_").replace("_", " ")
            told.append(" ".join(filter(None, (word, shown(value, 4), unit_of(name).replace("N/N", "")))))
        elif not value:
            without.append(f"no {name}")
    return "   ".join([*told, *without])


PROPOSED = 3
"""Names that are proposed."""


def parameters_named(word: str) -> list[str]:
    """Return the dotted names that a word is the last part, the begin of it, or another name of.

    >>> parameters_named("kp")
    ['controller.kp']

    Parameters
    ----------
    word
        Name, with or without dashes.

    Raises
    ------
    FrictionloopError
        For no name.
    """
    if not word:
        raise must_be("word", word, "a name")
    asked = word.replace("-", "_")
    names = {name: name.rsplit(".", 1)[-1] for name in known_names(System, {}) if not name.endswith(".kind")}
    same = [name for name, leaf in names.items() if leaf == asked]
    blocks = [f"{asked}.kind"] if asked in System.model_fields else []
    tried = [meant(f"{block}.{asked}", None, list(names), {}) for block in System.model_fields if asked]
    guessed = [f"{each.name} ({each.how})" if each.how else each.name for each in tried if each]
    begun = [name for name, leaf in names.items() if asked and leaf.startswith(f"{asked}_")]
    return list(dict.fromkeys(same or blocks or guessed or begun))[:PROPOSED]


WHOLE = ("setpoint", "disturbance", "controller")
"""Blocks of which every value is named; of a controller those of its law."""
MOST = 6
"""Values of a list that are shown."""


class BlockSummary(NamedTuple):
    """One block."""

    kind: str
    values: dict[str, Any]
    """By name, those that are not their defaults."""
    derived: dict[str, float]
    """What follows, by a name with its unit."""


def summary(system: System) -> dict[str, BlockSummary]:
    """Return each block of a System by its dotted name, nested ones after the one that holds them."""
    found: dict[str, BlockSummary] = {}
    derived = _derived(system)
    for name, block in system:
        # Where the finger is and how hard it presses is neither known nor used without a motion, and the wiring of a
        # board by no simulation: worth a row only where somebody has set it.
        if (name == "touch" and system.motion.kind == "sliding") or (name == "board" and block == Board()):
            continue
        found |= _blocks(name, block, derived)
    return found


def _blocks(name: str, block: BaseModel, derived: dict[str, dict[str, float]]) -> dict[str, BlockSummary]:
    fields = Timing.model_fields if name == "controller" else {} if name in WHOLE else type(block).model_fields
    usual = {key: each.get_default(call_default_factory=True) for key, each in fields.items() if not each.is_required()}
    kind, values, inner = "", {}, dict[str, BlockSummary]()
    for key in block.model_dump():  # in the order of files: a law's own values before what all controllers have
        value = getattr(block, key)
        if key == "kind":
            kind = str(value)
        elif isinstance(value, BaseModel):
            inner |= _blocks(f"{name}.{key}", value, derived)
        elif value is not None and not (key in usual and value == usual[key]):
            values[key] = value
    own = BlockSummary(kind, values, derived.get(name, {}))
    return ({name: own} if any(own) else {}) | inner


def _derived(system: System) -> dict[str, dict[str, float]]:
    """Return what follows from the values of blocks."""
    plate, sensor, controller, motion = system.plate, system.sensor, system.controller, system.motion
    found: dict[str, dict[str, float]] = {}
    if isinstance(plate, ResonantPlate):
        found["plate"] = {"cutoff_hz": plate.cutoff_hz}
    if isinstance(sensor, SuspendedSensor):
        found["sensor"] = {"stiffness_n_um": 1e-6 * sensor.stiffness_n_m, "noise_rms_n": sensor.noise_rms_n}
        found["sensor"] |= {"step_n": sensor.step_n}
    if controller.delay_s > 0:
        found["controller"] = {"delay_with_half_the_hold_s": controller.delay_s + 0.5 / controller.rate_hz}
    if isinstance(motion, Strokes):
        model = controller.model
        found["controller.model"] = {"lowest_command_n": model.floor_n, "highest_command_n": model.nominal_n}
        found["motion"] = {"cycle_s": motion.cycle_s}
        if isinstance(system.finger, Skin):
            found["finger"] = {"fastest_rise_n_s": system.finger.stiffness_n_m * motion.speed_mm_s * 1e-3}
    return found


def short(value: Any) -> str:
    """Return a value with at most six digits, a long list by its first values."""
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, (list, tuple)):
        seen = ", ".join(map(short, value[:MOST]))
        return f"[{seen}]" if len(value) <= MOST else f"[{seen}, ... {len(value)} values]"
    return '","' if value == "," else str(value)


def listed(values: dict[str, Any]) -> str:
    """Return values by name in a line."""
    return ", ".join(f"{key}={short(value)}" for key, value in values.items())
