"""Parameters of the system as flags: ``--controller.kp 12`` becomes the override ``{"controller.kp": 12}``."""

from __future__ import annotations

import shlex
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeVar

from cyclopts import Group, Parameter, Token

from frictionloop.cli import screen
from frictionloop.quantities.units import FrictionloopError

if TYPE_CHECKING:
    from frictionloop.parameters import System

DOTTED = "--BLOCK.NAME"
"""The one option that all dotted flags are gathered under."""

SYSTEM = Group("System", sort_key=1)
RUN = Group("Run", sort_key=2)
RESULT = Group("Result", sort_key=3)


def whole(_type: Any, tokens: Sequence[Token]) -> int:
    """Return the whole number a flag is given; cyclopts by itself would round."""
    try:
        return int(tokens[0].value)
    except ValueError:
        raise ValueError(f'unable to convert "{tokens[0].value}" into a whole number.') from None


T = TypeVar("T")
Described = Annotated[T, Parameter(group=SYSTEM)]
Run = Annotated[T, Parameter(group=RUN)]
Result = Annotated[T, Parameter(group=RESULT)]
"""A parameter of a verb by the part of its help; what it means stands in the docstring."""
Whole = Annotated[int, Parameter(converter=whole)]
Flag = Annotated[bool, Parameter(show_default=False)]

SystemFile = Annotated[
    Path | None,
    Parameter(name="FILE", help="TOML file that describes the system; the preset is used without it.", group=SYSTEM),
]
PresetName = Literal["paper", "feasible", "bench"]
"""The presets of `parameters.PRESETS`, written out so that help need not import it; a test holds the two together."""
Preset = Annotated[
    PresetName | None,
    Parameter(metavar="NAME", help="Ready-made system instead of a file; paper if neither is given.", group=SYSTEM),
]
BenchPreset = Annotated[
    PresetName | None,
    Parameter(metavar="NAME", help="Ready-made system instead of a file; bench if neither is given.", group=SYSTEM),
]
"""Of the device's commands and the controller's design, for which the paper's loop without a finger is no start."""
Overrides = Annotated[
    list[str] | None,
    Parameter(
        name=DOTTED,
        metavar="VALUE",
        help="Any parameter of the system by its dotted name, such as --controller.kp 12 or --setpoint.kind sine. "
        "The summary of a run and --save-system list the names.",
        group=SYSTEM,
    ),
]
Compared = Annotated[
    list[str] | None,
    Parameter(
        name=DOTTED,
        metavar="VALUE",
        help="Any parameter of the bench by its dotted name, such as --plate.q 150 or --controller.delay_s 300e-6. "
        "Not setpoint, finger, strokes or a law: those a comparison sets by itself.",
        group=SYSTEM,
    ),
]
"""Of a comparison, whose protocol sets the rest."""


Json = Annotated[
    bool, Parameter(help="Print one JSON object instead of the summary.", show_default=False, group=RESULT)
]
DurationS = Annotated[float, Parameter(help="Duration of a run in s.", group=RUN)]
ScoreFromS = Annotated[float, Parameter(help="Start of the part that the metrics score, in s.", group=RUN)]


def gather(tokens: Sequence[str]) -> list[str]:
    """Return the tokens with each ``--block.name value`` rewritten as one token of the option ``DOTTED``."""
    gathered: list[str] = []
    rest = iter(tokens)
    for token in rest:
        name, equals, value = token.partition("=")
        if token == "--":
            return [*gathered, token, *rest]
        if not (name.startswith("--") and "." in name):
            gathered.append(token)
            continue
        if not equals:
            value = next(rest, "--")
            if value.startswith("--"):
                raise FrictionloopError(f"{name}: needs a value, such as {name} 1")
        gathered.append(f"{DOTTED}={name[2:].replace('-', '_')}={value}")
    return gathered


def scalar(text: str) -> Any:
    """Return the TOML value a text holds: a number, true or false, a list; any other text as it stands.

    Numbers with commas between them are a list too: a shell wants quotes around brackets and spaces.
    """
    if "\n" in text:
        return text
    if "," in text and len(text) > 1 and set(text) <= set("0123456789.,+-eE "):
        text = f"[{text}]"
    try:
        value = tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        if text.startswith("[") and text.endswith("]"):
            raise FrictionloopError(f"{text}: is no list; write one like [0.4, 0.8], with 0 before the point") from None
        return text
    return value if isinstance(value, (bool, int, float, str, list)) else text


def overrides_of(flags: Iterable[str] | None) -> dict[str, Any]:
    """Return the overrides that gathered flags stand for."""
    pairs = [flag.partition("=") for flag in flags or ()]
    names = [pair[0] for pair in pairs]
    if twice := next((name for name in names if names.count(name) > 1), None):
        raise FrictionloopError(f"--{twice}: is given more than once; give it once")
    # A kind comes first, so that the other values land in the block of that kind.
    pairs.sort(key=lambda pair: not pair[0].endswith(".kind"))
    return {name: scalar(value) for name, _, value in pairs}


def given(
    file: Path | None,
    preset_name: str | None,
    flags: Iterable[str] | None,
    instead: str = "paper",
    designed: str | None = None,
) -> tuple[System, str]:
    """Return the system of a file or a preset with the dotted flags applied, and in words where it comes from.

    ``designed`` names the law that a controller is to be found for.
    """
    from frictionloop.cli.plausible import ask, differing, named_by, suggested
    from frictionloop.parameters import preset, read_toml
    from frictionloop.parameters.files import start_of
    from frictionloop.sensing.touch import check_follows

    if file is not None and preset_name is not None:
        raise FrictionloopError(
            f"{file} and --preset {preset_name} both name a system; give one (a file may begin with "
            f'preset = "{preset_name}" and hold only what differs)'
        )
    overrides = overrides_of(flags)
    try:
        base = preset(preset_name or instead) if file is None else read_toml(file)
        system = base.evolve(overrides)
        check_follows(system.motion, system.touch)  # a run would refuse it, after a design of some minutes
    except FrictionloopError as error:
        raise FrictionloopError(suggested(str(error))) from None
    start, changes = (None, {}) if file is None else start_of(file)
    origin = str(file) if file else f"{preset_name or instead}()"
    of_file = [] if start is None else _left(start, base, changes, "its preset")
    for line in (*(f"{file}: {each}" for each in of_file), *_left(base, system, overrides, origin)):
        screen.note(line)
    ask(system)
    for line in differing(system, named_by(_flat(changes), overrides), designed):
        screen.note(line)
    return system, changed(origin, overrides)


def again(
    file: Path | None,
    preset_name: str | None,
    flags: Iterable[str] | None,
    left_out: Callable[[str, str], bool],
    instead: str = "paper",
) -> str:
    """Return what names the system on another command line: the file or preset, and flags but those left out."""
    source = [str(file)] if file else ["--preset", preset_name or instead]
    pairs = [(path, value) for path, _, value in (flag.partition("=") for flag in flags or ())]
    kept = [pair for pair in pairs if not left_out(*pair)]
    return shlex.join([*source, *(word for path, value in kept for word in (f"--{path}", value))])


def stated(file: Path | None, flags: Iterable[str] | None) -> set[str]:
    """Return the dotted names that a file beside its preset, and flags give; a file without one was written whole."""
    from frictionloop.parameters.files import start_of

    start, changes = (None, {}) if file is None else start_of(file)
    return {*(_flat(changes) if start else ()), *overrides_of(flags)}


def _flat(changes: Mapping[str, Any]) -> dict[str, Any]:
    """Return values by dotted names, also those in a block within a block."""
    flat: dict[str, Any] = {}
    for name, value in changes.items():
        flat |= {f"{name}.{key}": each for key, each in value.items()} if isinstance(value, Mapping) else {name: value}
    return flat


def changed(origin: str, overrides: Mapping[str, Any]) -> str:
    """Return in words where something comes from and what was changed."""
    said = {name: '","' if value == "," else value for name, value in overrides.items()}
    changes = ", ".join(f"{name} = {value}" for name, value in said.items())
    return f"{origin} with {changes}" if changes else origin


def _left(base: System, system: System, overrides: Mapping[str, Any], origin: str) -> Iterator[str]:
    """Yield a line for each block of a new kind: which values were not taken over from the old one, of ``origin``."""
    for name in type(base).model_fields:
        old, new = getattr(base, name), getattr(system, name)
        if f"{name}.kind" in overrides and old.kind != new.kind:
            shared = type(old).model_fields.keys() & type(new).model_fields.keys() - {"kind"}
            said = {path.split(".")[1] for path in overrides if path.startswith(f"{name}.")}
            left = [each for each in type(new).model_fields if each in shared - said]
            left = [each for each in left if getattr(old, each) != getattr(new, each)]
            if left:
                values = ", ".join(f"{each} = {getattr(new, each)}" for each in left)
                had = ", ".join(f"{getattr(old, each)}" for each in left)
                yield f"{name}.kind = {new.kind}: {values} by default; the {old.kind} of {origin} had {had}"
