"""The frozen, validated parameter block that every part of a System is made of."""

from __future__ import annotations

import inspect
from inspect import Parameter, Signature
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError
from pydantic.fields import FieldInfo

from frictionloop.parameters import wording
from frictionloop.quantities import FrictionloopError, unit_of


def _no_bool(value: Any) -> Any:
    if isinstance(value, bool):
        raise ValueError("must be a number, no boolean")
    return value


Number = Annotated[float, BeforeValidator(_no_bool)]
Whole = Annotated[int, BeforeValidator(_no_bool)]
Positive = Annotated[Number, Field(gt=0)]
NotNegative = Annotated[Number, Field(ge=0)]


if TYPE_CHECKING:
    from pydantic._internal._model_construction import ModelMetaclass
else:
    ModelMetaclass = type(BaseModel)  # its name is not public


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
            raise FrictionloopError(f"{cls.__name__}: {wording.explain(model, error, values)}") from None

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
