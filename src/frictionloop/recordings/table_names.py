"""Names of the columns of a text file, from one or two rows and a row of units."""

from __future__ import annotations

from frictionloop.recordings.headers import said_unit
from frictionloop.recordings.table_layout import NUMBER


def names_of(head: list[list[str]], count: int) -> list[str]:
    """Return a name for each column, from the last rows of the head that have about as many cells."""
    rows = [row for row in head if sum(bool(cell) for cell in row) > (1 if count > 1 else 0)]
    wide = [row for row in rows if abs(len(row) - count) <= max(1, count // 2)] or rows[-1:]
    units: list[str] = []
    if len(wide) > 1 and _are_units(wide[-1]):
        units = [cell.strip("[]() ") for cell in wide.pop()]
    names = [cell.lstrip("# ") for cell in wide[-1]] if wide else []
    if len(wide) > 1 and len(wide[-2]) == len(names) and not any(NUMBER.fullmatch(cell) for cell in wide[-2]):
        names = _under_groups([cell.lstrip("# ") for cell in wide[-2]], names)
    if names and names[0] == "" and len(names) == count + 1:
        names = names[1:]
    names = (names + [""] * count)[:count]
    units = (units + [""] * count)[:count]
    named = [
        f"{name or k} [{unit}]" if unit else name or str(k)
        for k, (name, unit) in enumerate(zip(names, units, strict=True))
    ]
    first = {name: k for k, name in reversed([*enumerate(named)])}
    return [name if first[name] == k else f"{name} {k}" for k, name in enumerate(named)]


def _are_units(row: list[str]) -> bool:
    filled = [cell.strip("[]() ") for cell in row if cell.strip("[]() -")]
    bracketed = [cell for cell in row if cell.strip().startswith(("[", "("))]
    return bool(filled) and (
        2 * sum(said_unit(cell) is not None for cell in filled) >= len(filled) or len(bracketed) == len(filled)
    )


def _under_groups(groups: list[str], names: list[str]) -> list[str]:
    """Return "group name" where names stand under groups; below a blank cell the group before goes on."""
    joined, group = [], ""
    for above, name in zip(groups, names, strict=True):
        group = above or group
        joined.append(f"{group} {name}".strip() if group != name else name)
    return joined
