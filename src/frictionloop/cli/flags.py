"""Parameters of the system as flags: ``--controller.kp 12`` becomes the override ``{"controller.kp": 12}``."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple, TypeVar

from cyclopts import Group, Parameter, Token

import frictionloop as fl
from frictionloop import FrictionloopError

if TYPE_CHECKING:
    from frictionloop import System
    from frictionloop.findings import Finding

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

SystemFile = Annotated[Path | None, Parameter(name="FILE", help="System (.toml) in place of the preset.", group=SYSTEM)]
PresetName = Literal["paper", "feasible", "bench"]
"""The presets of `parameters.PRESETS`, written out so that help need not import it; a test holds the two together."""
Preset = Annotated[
    PresetName | None, Parameter(metavar="NAME", help="Ready-made system; paper without a file.", group=SYSTEM)
]
BenchPreset = Annotated[
    PresetName | None, Parameter(metavar="NAME", help="Ready-made system; bench without a file.", group=SYSTEM)
]
"""Of the device's commands and the controller's design, for which the paper's loop without a finger is no start."""


def _dotted(said: str) -> Parameter:
    return Parameter(name=DOTTED, metavar="VALUE", help=said, group=SYSTEM)


Overrides = Annotated[
    list[str] | None, _dotted("Any parameter by its dotted name: --controller.kp 12, --setpoint.kind sine.")
]
Compared = Annotated[
    list[str] | None,
    _dotted("Any parameter of the bench, such as --plate.q 150; not setpoint, finger, strokes or law."),
]
"""Of a comparison, whose protocol sets the rest."""
Json = Annotated[bool, Parameter(help="Print one JSON object.", show_default=False, group=RESULT)]
DurationS = Annotated[float, Parameter(help="Duration of a run in s.", group=RUN)]
Seed = Annotated[Whole, Parameter(help="Seed of all noise.", group=RUN)]
SeedOfRun = Annotated[Whole, Parameter(help="Seed of all noise: the same seed gives the same run.", group=RUN)]
Jobs = Annotated[Whole | None, Parameter(help="Parallel workers; one per core if not given.", group=RUN)]
ScoreFromS = Annotated[float, Parameter(help="Start of what is scored, in s.", group=RUN)]


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
            raise FrictionloopError(f"{text}: accepted a list such as [0.4, 0.8]") from None
        return text
    return value if isinstance(value, (bool, int, float, str, list)) else text


def overrides_of(flags: Iterable[str] | None) -> dict[str, Any]:
    """Return the overrides that gathered flags stand for."""
    pairs = [flag.partition("=") for flag in flags or ()]
    names = [pair[0] for pair in pairs]
    if twice := next((name for name in names if names.count(name) > 1), None):
        raise FrictionloopError(f"--{twice}: is given more than once")
    # A kind comes first, so that the other values land in the block of that kind.
    pairs.sort(key=lambda pair: not pair[0].endswith(".kind"))
    return {name: scalar(value) for name, _, value in pairs}


class Given(NamedTuple):
    """A system of a file or a preset with flags, and what is to be known of that."""

    system: System
    stated: frozenset[str]
    """Dotted names of values that somebody gave."""
    findings: tuple[Finding, ...]


LAW = {"controller.kind": "notch_pi", "controller.feedforward": True}
"""What closes the loop of the bench, if neither a file nor a flag says it (docs/which-law)."""


def system_given(
    file: Path | None,
    preset_name: str | None,
    flags: Iterable[str] | None,
    instead: str = "paper",
    designed: str | None = None,
    closing: bool = False,
) -> Given:
    """Return the system of a file or a preset with the dotted flags applied.

    ``designed`` names the law that a controller is to be found for. With ``closing`` the bench of the preset has `LAW`.
    """
    if file is not None and preset_name is not None:
        raise FrictionloopError(f"{file} and --preset {preset_name}: give one of them", "TWO-SYSTEMS")
    overrides = overrides_of(flags)
    found = fl.described(file, preset_name or instead, overrides, designed)
    own = (
        file is None
        and preset_name in (None, "bench")
        and not any(name.startswith("controller.") for name in overrides)
    )
    system = found.system.evolve(LAW) if closing and own else found.system
    return Given(system, found.stated, found.findings)


class OnBench(NamedTuple):
    """The bench of a file; None where none is named."""

    system: System | None
    findings: tuple[Finding, ...]


def bench_of(file: Path | None) -> OnBench:
    """Return the bench of a file, and what of it is in doubt."""
    if file is None:
        return OnBench(None, ())
    found = fl.described(file)
    return OnBench(found.system, found.findings)
