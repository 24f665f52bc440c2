"""Blocks from outside: control laws, friction laws, signals and metrics that are no part of this package.

What is registered has a name from then on, its ``kind``: in ``evolve``, in TOML files, on the command line, in run
files and in sweeps. Reading a file never imports code: whoever reads it registers first.
"""

from __future__ import annotations

import inspect
import re
import warnings
from typing import Any

from frictionloop.control.law import Law
from frictionloop.control.laws import LAWS
from frictionloop.loop.block_checks import check_law, check_metric, check_signal, check_vibration
from frictionloop.loop.metric import RunMetric, StreamingMetric
from frictionloop.loop.metrics import METRICS
from frictionloop.parameters import Signal
from frictionloop.parameters.block import kind_of
from frictionloop.parameters.controller import CONTROLLERS
from frictionloop.parameters.input_signals import SOURCES
from frictionloop.parameters.plant import FRICTIONS, FrictionLaw
from frictionloop.physics.vibration import VIBRATIONS, Vibration, per_finger
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.code_version import code_digest
from frictionloop.quantities.outside_errors import place
from frictionloop.quantities.scalar_math import is_compiled

_LAWS: dict[bool, tuple[str, Any, dict[str, Any], Any]] = {
    True: ("law", CONTROLLERS, LAWS, check_law),
    False: ("friction", FRICTIONS, VIBRATIONS, check_vibration),
}
"""What is registered of a control law, and of a friction law."""
_registered: dict[tuple[str, str], tuple[Any, ...]] = {}
"""Arguments of `register`, by what it is and its name."""


def register(block: Any, parameters: Any = None) -> None:
    """Make a block from outside known by its kind; registering a kind again replaces it.

    Parameters
    ----------
    block
        A `Law` (control law), a `Vibration` (friction law), a subclass of `Signal`, a `StreamingMetric` or a
        `RunMetric`.
    parameters
        Of a law: its parameter class, a subclass of `Timing` (control law) or `FrictionLimit` (friction law).

    Raises
    ------
    FrictionloopError
        For anything else, a name of this package, parameters whose kind is not that of the law, and for what cannot
        run: each function is tried once, with the parameters as they are if nothing is given.
    """
    if isinstance(block, Law | Vibration | StreamingMetric | RunMetric):
        _check_hashable(block)
    if isinstance(block, Law | Vibration):
        what, kinds, known, check = _LAWS[isinstance(block, Law)]
        name = block.kind
        _check_kind(block, parameters)
        kinds.check(parameters)
        check(block, parameters)
        kinds.register(parameters)
        if isinstance(block, Vibration) and issubclass(parameters, FrictionLaw):
            known[name] = per_finger(block)
        else:
            known[name] = block
    elif isinstance(block, type) and issubclass(block, Signal):
        SOURCES.check(block)
        check_signal(block)
        SOURCES.register(block)
        what, name = "signal", kind_of(block)
    elif isinstance(block, StreamingMetric | RunMetric):
        if not isinstance(METRICS.get(block.name, block), StreamingMetric | RunMetric):
            raise FrictionloopError(f"metric {block.name!r}: taken; choose another name")
        check_metric(block)
        METRICS[block.name] = block
        what, name = "metric", block.name
    else:
        raise FrictionloopError(f"{block!r:.60}: accepted Law, Vibration, Signal, StreamingMetric, RunMetric")
    _registered[what, name] = (block, parameters)
    _warn_of_python(block)


def forget() -> None:
    """Make every block from outside unknown again."""
    for kinds in (CONTROLLERS, FRICTIONS, SOURCES):
        kinds.forget()
    for table, what in ((LAWS, "law"), (VIBRATIONS, "friction"), (METRICS, "metric")):
        for each, name in _registered:
            if each == what:
                del table[name]
    _registered.clear()


def registered() -> list[tuple[Any, ...]]:
    """Return what was registered, to register it again in another process."""
    return list(_registered.values())


def register_all(blocks: list[tuple[Any, ...]]) -> None:
    """Register in a worker what its caller has registered; nothing happens where it is known already."""
    for block, parameters in blocks:
        if (block, parameters) not in _registered.values():
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # the caller was told
                register(block, parameters)


def outside_digest() -> str:
    """Return a digest of all blocks from outside, which enters the fingerprint of a sweep; "" without any."""
    if not _registered:
        return ""
    return code_digest([_described(*each) for each in _registered.values()])


def _described(block: Any, parameters: Any) -> list[Any]:
    """Return what a block computes: its functions, and the functions and defaults of its parameters."""
    classes: list[Any] = [each for each in (block, parameters) if isinstance(each, type)]
    named = [getattr(value, "fget", value) for each in classes for value in vars(each).values()]
    own = [value for value in named if inspect.isfunction(value)]
    fields = [re.sub(" at 0x[0-9a-f]+", "", repr(each.model_fields)) for each in classes]  # addresses differ by process
    return [block if not isinstance(block, type) else kind_of(block), own, fields]


def _check_kind(block: Any, parameters: Any) -> None:
    if parameters is None or kind_of(parameters) != block.kind:
        raise FrictionloopError(f'{type(block).__name__} "{block.kind}": register(block, Parameters) with this kind')


def _check_hashable(block: Any) -> None:
    """Refuse what cannot be a key: a tile is compiled once for each block."""
    try:
        hash(block)
    except TypeError as error:
        name = getattr(block, "kind", None) or block.name
        raise FrictionloopError(f'{type(block).__name__} "{name}": {error}; give functions and classes') from None


def _warn_of_python(block: Any) -> None:
    """Say of a law that is not compiled what it costs."""
    step = getattr(block, "step", None)
    if isinstance(block, Law) and step is not None and not is_compiled(step):
        warnings.warn(
            f'law "{block.kind}": {place(step)}: plain Python: slow; @fl.step',
            stacklevel=3,
        )
