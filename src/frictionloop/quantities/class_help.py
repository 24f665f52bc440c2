"""Classes whose ``help`` fits a screen: it shows what this package says of them, not what every class has."""

from __future__ import annotations

from typing import Any, TypeVar

T = TypeVar("T")


class Brief(type):
    """Metaclass of a class that lists only its own public names."""

    def __dir__(cls) -> list[str]:
        """Return the public names that this package gives the class."""
        own = [each for each in cls.__mro__ if each.__module__.partition(".")[0] == __name__.partition(".")[0]]
        public = {name for each in own for name in vars(each) if not name.startswith("_")}
        return sorted(public | {"__doc__", "__module__"})


def brief(record: type[T]) -> type[T]:
    """Return a named tuple that lists its fields alone; a named tuple takes no metaclass of its own."""
    made: Any = Brief(record.__name__, record.__bases__, dict(vars(record)))
    return made
