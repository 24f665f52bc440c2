"""Which fields of a System's blocks a model of the loop has: one that it has not got is refused, never left out."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

from pydantic import BaseModel

from frictionloop.parameters.block import Block
from frictionloop.quantities import FrictionloopError

OUTSIDE: Any = object()
"""Stands for a value that nothing equals: a kind that is not known at all, or a field without a default."""


@dataclass(frozen=True, eq=False)
class Represented:
    """What a model of the loop has of the blocks it is made from; tests hold that no field is forgotten."""

    what: str
    """Name of the model, as messages have it."""
    fields: Mapping[type[Block], str]
    """Names of the fields that it has, by the class that declares them."""
    left_out: Mapping[type[Block], str]
    """Names of those that it leaves out knowingly, which its documentation says."""

    def check(self, blocks: Mapping[str, BaseModel]) -> None:
        """Refuse blocks, given by their paths, in which an unknown field is not at its default.

        Raises
        ------
        FrictionloopError
            Naming the field.
        """
        for path, block in blocks.items():
            for name, value, default in self.missing(block):
                told = f"{path}.{name} = {value!r}: {self.what} does not know this"
                if name == "kind":
                    raise FrictionloopError(f"{told} kind; known: {', '.join(self._kinds(block))}")
                other = "" if default is OUTSIDE else f"; must be {default!r} for this"
                raise FrictionloopError(f"{told} field{other}")
            self.check({f"{path}.{name}": inner for name, inner in block if isinstance(inner, BaseModel)})

    def missing(self, block: BaseModel) -> Iterator[tuple[str, Any, Any]]:
        """Yield name, value and default of the unknown fields of a block that are not at their defaults."""
        for name, default in self._unknown(type(block)):
            value = getattr(block, name)
            if default is OUTSIDE or value != default:
                yield name, value, default

    def _kinds(self, block: BaseModel) -> list[str]:
        """Return the kinds that this model of the loop has in the place of a block."""
        bases = {each for each in type(block).__mro__ if issubclass(each, Block) and each is not Block}
        same = [each for each, listed in self.fields.items() if "kind" in listed.split() and bases & set(each.__mro__)]
        return [each.model_fields["kind"].default for each in same]

    @cache  # noqa: B019 - each model of the loop is a constant of its module
    def _unknown(self, block: type[BaseModel]) -> tuple[tuple[str, Any], ...]:
        """Return name and default of each field of a class that is in neither list.

        Fields of a class from outside belong to its own step, which every model of the loop takes as it is.
        """
        known: set[str] = set()
        unknown: set[str] = set()
        for each in reversed(block.__mro__):
            own = vars(each).get("__annotations__", {}).keys() & block.model_fields.keys()
            if "kind" in own:
                known -= {"kind"}  # another kind than the one it inherits from
            known |= {name for listed in (self.fields, self.left_out) for name in listed.get(each, "").split()}
            unknown = (unknown | own if each.__module__.startswith("frictionloop.") else unknown - own) - known
        return tuple((name, _default(block, name)) for name in sorted(unknown))


def _default(block: type[BaseModel], name: str) -> Any:
    field = block.model_fields[name]
    return OUTSIDE if name == "kind" or field.is_required() else field.get_default(call_default_factory=True)
