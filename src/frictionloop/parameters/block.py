"""The frozen, validated parameter block that a System is made of, and the kinds that one may be, from outside too."""

from __future__ import annotations

import inspect
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from inspect import Parameter, Signature
from typing import TYPE_CHECKING, Annotated, Any, Self

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    GetCoreSchemaHandler,
    ValidationError,
    model_validator,
)
from pydantic.fields import FieldInfo
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from frictionloop.parameters.refusals import explain
from frictionloop.quantities import FrictionloopError, must_be, unit_of

if TYPE_CHECKING:
    from pydantic._internal._model_construction import ModelMetaclass
else:
    ModelMetaclass = type(BaseModel)  # its name is not public


def _no_bool(value: Any) -> Any:
    if isinstance(value, bool):
        raise ValueError("must be a number")
    return value


def _normal(value: float) -> float:
    """Return a number, 0 where it is subnormal: one over it would be infinite."""
    return 0.0 if abs(value) < sys.float_info.min else value


Number = Annotated[float, BeforeValidator(_no_bool)]
Whole = Annotated[int, BeforeValidator(_no_bool)]
Positive = Annotated[Number, AfterValidator(_normal), Field(gt=0)]
NotNegative = Annotated[Number, Field(ge=0)]


class BlockType(ModelMetaclass):
    """What a parameter class is: it refuses wrong values in one line, and shows its own names alone."""

    def __call__(cls, *args: Any, **values: Any) -> Any:
        """Make a block, with what is wrong told as ``evolve`` tells it."""
        if args:
            raise FrictionloopError(f"{cls.__name__} takes its values by name: {cls.__name__}({_example(cls)})")
        try:
            return super().__call__(**values)
        except ValidationError as error:
            model: Any = cls
            raise FrictionloopError(f"{cls.__name__}: {explain(model, error, values)}") from None

    def __dir__(cls) -> list[str]:
        """Return the fields, and the functions of this package: pydantic's own would fill sixteen screens of help."""
        own = [each for each in cls.__mro__ if issubclass(each, BaseModel) and each is not BaseModel]
        named = {name for each in own for name in vars(each) if not name.startswith(("_", "model_"))}
        fields: dict[str, FieldInfo] = getattr(cls, "model_fields", {})
        return sorted(named | {"__doc__", "__module__"} | fields.keys())


def _example(cls: Any) -> str:
    fields = [name for name in cls.model_fields if name != "kind"]
    return f"{fields[0]}=..." if fields else ""


class Block(BaseModel, metaclass=BlockType):
    """One box of the block diagram: immutable, finite numbers only, unknown names refused."""

    model_config = ConfigDict(
        frozen=True, extra="forbid", allow_inf_nan=False, use_attribute_docstrings=True, validate_default=True
    )

    @model_validator(mode="after")
    def _checked(self) -> Self:
        self._check()
        return self

    def _check(self) -> None:
        """Refuse values that do not go together, which each class says of its own."""

    def __setattr__(self, name: str, value: Any) -> None:
        """Refuse: a block is a value."""
        raise FrictionloopError(f"{type(self).__name__}.{name}: frozen; evolve returns a copy")

    def __delattr__(self, name: str) -> None:
        """Refuse as `__setattr__` does."""
        self.__setattr__(name, None)

    @classmethod
    def __pydantic_init_subclass__(cls, **kwargs: Any) -> None:
        """Let ``help`` show the fields, each with its unit, default and meaning."""
        super().__pydantic_init_subclass__(**kwargs)
        cls.__signature__ = _signature(cls)
        fields = {name: field for name, field in cls.model_fields.items() if name != "kind" and field.description}
        if fields and cls.__doc__ and "Parameters\n----" not in cls.__doc__:
            lines = [line for name, field in fields.items() for line in _told(name, field)]
            cls.__doc__ = "\n".join([inspect.cleandoc(cls.__doc__), "", "Parameters", "----------", *lines])


def _told(name: str, field: FieldInfo) -> list[str]:
    """Return name, unit, default and meaning of a field."""
    default = field.get_default(call_default_factory=True)
    default = type(default).__name__ + "()" if isinstance(default, BaseModel) else repr(default)
    given = "required" if field.is_required() else f"default {default}"
    unit = f"{unit_of(name)}, " if unit_of(name) else ""
    meaning = inspect.cleandoc(field.description or "").splitlines()
    return [f"{name} : {unit}{given}", *(f"    {line}".rstrip() for line in meaning)]


def _signature(cls: type[BaseModel]) -> Signature:
    """Return the fields by name with their defaults, those that are blocks short, without pydantic's annotations."""
    defaults = {
        name: Parameter.empty if field.is_required() else ... if isinstance(field.default, BaseModel) else field.default
        for name, field in cls.model_fields.items()
    }
    return Signature([Parameter(name, Parameter.KEYWORD_ONLY, default=each) for name, each in defaults.items()])


OWN = ", or a kind of your own (fl.register, --use FILE)"
"""What else a block may be."""


class Kinded(Block):
    """A block that is of one of several kinds."""

    if TYPE_CHECKING:

        @property
        def kind(self) -> str:
            """Name of the kind."""


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
            raise must_be("class", model, f"a subclass of fl.{self.base.__name__}")
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
