"""What a verb answers: numbers, findings, tables, a figure, and the forms that all answers have."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, is_dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, Self, dataclass_transform

from frictionloop.findings import render
from frictionloop.findings.finding import Condition, Finding
from frictionloop.quantities import FrictionloopError

if TYPE_CHECKING:
    from matplotlib import figure

    Figure = figure.Figure
else:  # imported where one is drawn
    Figure = Any

Row = tuple[str, str]
Table = Any
"""A DataFrame of pandas, which has no types."""
Tables = dict[str, Table]


@dataclass_transform(kw_only_default=True, frozen_default=True, field_specifiers=(field,))
@dataclass(frozen=True, kw_only=True)
class Result:
    """Base of the frozen answers; ``print(answer)`` is what the command line shows."""

    SCHEMA: ClassVar[str] = ""
    """Name and number of the form in JSON, such as design.check/1."""
    WITHOUT: ClassVar[tuple[str, ...]] = ()
    """Fields that JSON leaves out."""
    findings: tuple[Finding, ...] = ()
    """The worst first."""

    def __init_subclass__(cls, schema: str = "", without: str = "", eq: bool = True) -> None:
        """Make a class with a ``schema`` frozen data, by keywords alone; JSON is ``without`` fields, blanks between."""
        cls.WITHOUT = (*cls.WITHOUT, *without.split())
        if schema:
            cls.SCHEMA = schema
            dataclass(frozen=True, kw_only=True, eq=eq)(cls)

    def __post_init__(self) -> None:
        object.__setattr__(self, "findings", tuple(sorted(self.findings, key=lambda each: each.rank)))

    def with_findings(self, more: Sequence[Finding]) -> Self:
        """Return the answer with more findings, those that it has already left out."""
        return replace(self, findings=(*self.findings, *(each for each in more if each not in self.findings)))

    def rows(self) -> Sequence[Row]:
        """Return the answer: a name and its numbers each, the first the most important."""
        return ()

    def tables(self) -> Mapping[str, Table]:
        """Return tables by name, the first of which belongs to the answer."""
        return {}

    def table(self, name: str | None = None) -> Table:
        """Return a table, the first if none is named; the rows of an answer that has none.

        Raises
        ------
        FrictionloopError
            For a name that is not there, naming those that are.
        """
        found = self.tables() or {"answer": frame({name: [said] for name, said in self.rows()}, "", ["answer"])}
        chosen = next(iter(found), "") if name is None else name
        if chosen not in found:
            raise FrictionloopError(f"table = {chosen!r}: accepted are {', '.join(found)}", "UNKNOWN-NAME")
        return found[chosen]

    def plot(self) -> Figure:
        """Return a figure."""
        raise FrictionloopError(f"{type(self).__name__} has no figure", "UNKNOWN-NAME")

    def to_dict(self) -> dict[str, Any]:
        """Return everything by name as JSON holds it: NaN and infinity, which it lacks, are null and a string."""
        names = [each.name for each in fields(self) if each.name not in ("findings", *self.WITHOUT)]
        own = {name: getattr(self, name) for name in names}
        found: dict[str, Any] = plain({"schema": self.SCHEMA, **own, "findings": self.findings})
        return found

    def to_json(self, indent: int | None = 2) -> str:
        """Return `to_dict` as text."""
        return json.dumps(self.to_dict(), indent=indent, ensure_ascii=False, allow_nan=False)

    def to_html(self) -> str:
        """Return a page of its own with everything."""
        return render.page(self)

    def __str__(self) -> str:
        """Return what the command line shows."""
        return render.text(self)

    def _repr_html_(self) -> str:
        return render.fragment(self)

    def _repr_mimebundle_(self, **_: Any) -> dict[str, str]:
        """Show in IPython what the command line shows, not every field."""
        return {"text/plain": str(self)}


def frame(
    rows: Mapping[str, Any] | Sequence[Mapping[str, Any]], index: str, heads: Sequence[str] | None = None
) -> Table:
    """Return rows as a table: by name, or mappings of which ``index`` is the head of the names."""
    import pandas as pd  # type: ignore[import-untyped]

    if isinstance(rows, Mapping):
        return pd.DataFrame.from_dict(rows, orient="index", columns=heads).rename_axis(index or None)
    return pd.DataFrame(list(rows)).set_index(index)


def toml_table(name: str, values: Mapping[str, Any]) -> Table:
    """Return a block as a table whose lines are TOML, for a file that describes a bench."""
    import pandas as pd

    said = [f"= {json.dumps(float(f'{each:.6g}') if isinstance(each, float) else each)}" for each in values.values()]
    return pd.DataFrame({"": said}, index=list(values)).rename_axis(f"[{name}]")


INFINITE = "-Infinity", "Infinity"
"""What JSON has no number for; ``float`` and JavaScript's ``Number`` read it. NaN is null: nothing is known."""


def plain(value: Any) -> Any:  # noqa: PLR0911
    """Return a value as JSON holds it."""
    if isinstance(value, Condition):
        return plain(value.values)
    if hasattr(value, "data_vars"):  # xarray, whose datasets are mappings too
        return {str(name): plain(value[name].values) for name in [*value.coords, *value.data_vars]}
    if hasattr(value, "to_dict"):
        return plain(value.to_dict())
    if isinstance(value, Mapping):
        return {str(name): plain(each) for name, each in value.items()}
    if hasattr(value, "model_dump"):  # pydantic
        return plain(value.model_dump())
    if hasattr(value, "_asdict"):
        return plain(value._asdict())
    if is_dataclass(value) and not isinstance(value, type):
        return {each.name: plain(getattr(value, each.name)) for each in fields(value)}
    if isinstance(value, (Sequence, set, frozenset)) and not isinstance(value, (str, bytes)):
        return [plain(each) for each in value]
    if hasattr(value, "tolist"):  # NumPy
        return plain(value.tolist())
    if isinstance(value, float):
        return value if math.isfinite(value) else None if math.isnan(value) else INFINITE[value > 0]
    return value if value is None or isinstance(value, (bool, int, str)) else str(value)
