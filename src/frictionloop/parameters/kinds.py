"""The kinds that a block of a System may be: those of this package, and those that are registered from outside."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from typing import Any

from pydantic import BaseModel, GetCoreSchemaHandler
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from frictionloop.parameters.block import Block
from frictionloop.quantities import FrictionloopError

OWN = ", or a kind of your own (fl.register, --use FILE)"
"""What else a block may be."""


class Kinds:
    """The parameter classes of one block, by the value of their ``kind``; an annotation that pydantic reads."""

    def __init__(
        self,
        base: type[Block],
        *models: type[Block],
        default: str | None = None,
        tuned: bool = False,
        beside: Mapping[str, str] | None = None,
        gone: Mapping[str, str] | None = None,
    ) -> None:
        self.base, self.default, self.tuned = base, default, tuned
        self.beside = dict(beside or {})
        """Where a class stands in the file of its step, "module:Class" by its kind: imported when the kind is used."""
        self.gone = dict(gone or {})
        """Why a kind that files may still name is no more, and what to take in its place."""
        self.outside: set[str] = set()
        self._models = {kind_of(model): model for model in models}

    @property
    def names(self) -> list[str]:
        """Return every kind."""
        return list(dict.fromkeys([*self._models, *self.beside]))

    def __getitem__(self, kind: str) -> type[Block]:
        """Return the class of a kind."""
        if kind in self.beside and kind not in self._models:
            module, _, name = self.beside[kind].partition(":")
            self._models[kind] = getattr(import_module(module), name)
        return self._models[kind]

    def register(self, model: type[Block]) -> None:
        """Add a class from outside; one of the same kind that came from outside before is replaced."""
        self.check(model)
        self._models[kind_of(model)] = model
        self.outside.add(kind_of(model))

    def forget(self) -> None:
        """Leave out the classes from outside."""
        for kind in self.outside:
            del self._models[kind]
        self.outside.clear()

    def check(self, model: type[Block]) -> None:
        """Refuse a class that cannot be added.

        Raises
        ------
        FrictionloopError
            For a class that is not of this block, without a kind, or with the kind of a class of this package.
        """
        if not (isinstance(model, type) and issubclass(model, self.base)):
            raise FrictionloopError(f"{model!r}: must be a subclass of fl.{self.base.__name__}")
        kind = kind_of(model)
        if kind in self.names and kind not in self.outside:
            raise FrictionloopError(f'{model.__name__}.kind = "{kind}": taken; choose another name')
        if not kind.isidentifier():
            raise FrictionloopError(f'{model.__name__}.kind = "{kind}": accepted letters, digits, _')

    def carried(self, values: Mapping[str, Any], model: type[BaseModel]) -> dict[str, Any]:
        """Return what a block of another kind takes over from the values of the old one.

        That is what describes the bench. Where a kind is ``tuned`` (signals, control laws) the fields of its base do;
        a gain or an offset was chosen for the old kind and means something else in the new one. Elsewhere it is what
        both kinds have, unless their defaults say that it was chosen for one of them.
        """
        if self.tuned:
            return {name: values[name] for name in self.base.model_fields if name in values}
        old, new = self[values["kind"]].model_fields, model.model_fields
        return {name: values[name] for name in new if name in old and old[name].default == new[name].default}

    def read(self, value: Any) -> Block:
        """Return the block that a mapping describes, or the block given, if it is of one of the kinds."""
        if isinstance(value, BaseModel):
            kind = getattr(value, "kind", "")
            if kind not in self.names or type(value) is not self[kind]:
                raise PydanticCustomError("kind", "{text}", {"text": f"{type(value).__name__}: {self.accepted()}"})
            return value
        if not isinstance(value, Mapping):
            value = self.sampled(value)
        kind = value.get("kind", self.default)
        if not (isinstance(kind, str) and kind in self.names):
            text = f"kind is missing; {self.accepted()}" if kind is None else f"kind = {kind!r} {self.refusal(kind)}"
            raise PydanticCustomError("kind", "{text}", {"text": text})
        return self[kind].model_validate({"kind": kind, **value})

    def sampled(self, value: Any) -> Mapping[str, Any]:
        """Return the values of a block that an array stands for; only signals have any."""
        raise PydanticCustomError("dict_type", "must be a table of values")

    def accepted(self) -> str:
        """Return the kinds there are, in words."""
        accepted = ", ".join(map(repr, self.names))
        return f"accepted: {accepted}{OWN if self.base is not Block else ''}"

    def refusal(self, kind: Any) -> str:
        """Return why there is no such kind, and what to take in its place."""
        gone = self.gone.get(kind) if isinstance(kind, str) else None
        return gone or f"is unknown; {self.accepted()}"

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Let pydantic read the block by `read`, and write it as what it is."""
        return core_schema.no_info_plain_validator_function(self.read)


def kind_of(model: type[Block]) -> str:
    """Return the kind of a parameter class."""
    if not (isinstance(model, type) and issubclass(model, Block)):
        raise FrictionloopError(f"{model!r:.60}: must be a parameter class")
    field = model.model_fields.get("kind")
    if field is None or not isinstance(field.default, str):
        raise FrictionloopError(f"{model.__name__}: needs a kind")
    return field.default
