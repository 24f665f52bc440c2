"""The channel of a file that a name or a number means."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from frictionloop.quantities import FrictionloopError, check_known, must_be
from frictionloop.recordings.contents import Channel, Contents
from frictionloop.recordings.headers import header

SHOWN = 12
"""Channels that an error lists."""
_LINE = re.compile(r"(.*?)\s*\[\s*(?::\s*,\s*(\d+)|(\d+)\s*,\s*:)\s*\]", re.DOTALL)


def find_channel(where: str, contents: Contents, wanted: str | int) -> Channel:
    """Return a channel by its path, by its column's number, by its name in any case with or without its unit, or group.

    Numbers count from 0: the columns of a text, the channels of a sound, elsewhere what `identify channels` lists.
    ``name[:, k]`` and ``name[k, :]`` are lines of an array.

    Raises
    ------
    FrictionloopError
        For a channel that is not there, or is there more than once; what is there is listed.
    """
    text = str(wanted).strip().strip("\"'").strip().lstrip("/")
    there = contents.channels
    if (line := _LINE.fullmatch(text)) is not None:
        return _line_of(where, there, *line.groups())
    if exact := [each for each in there if each.name == text]:
        return exact[0]
    if text.isdecimal() and (numbered := _numbered(there, int(text))):
        return numbered[0]
    for candidates in _spelt(there, text):
        if len(candidates) > 1:
            raise must_be(f"{where}: column {text!r}", f"{len(candidates)} times there", _listed(candidates))
        if candidates:
            return candidates[0]
    if lines := [each.name for each in there if each.name.partition("[")[0] == text]:
        every = lines[0].replace("0", "*", 1)
        raise must_be(f"{where}: column", text, f"{lines[0]!r} to {lines[-1]!r}, or {every!r} for all")
    names = [each.name for each in there]
    check_known(f"{where}: column", [text], names if len(names) <= SHOWN else [*names[:SHOWN], f"{len(names)} in all"])
    raise AssertionError(text)


def _listed(channels: Sequence[Channel]) -> str:
    names = [repr(each.name) for each in channels]
    return ", ".join(names[:SHOWN]) + (f" and {len(names) - SHOWN} more" if len(names) > SHOWN else "")


def refuse_column(where: str, wanted: str, why: str, others: Sequence[Channel]) -> FrictionloopError:
    """Return the error that a channel is not what is wanted, with those that may be."""
    return FrictionloopError(f"{where}: column = {wanted!r} {why}; accepted: {_listed(others) or 'a force'}")


def _numbered(channels: Sequence[Channel], number: int) -> list[Channel]:
    if any(each.number is not None for each in channels):
        return [each for each in channels if each.number == number]
    return list(channels[number : number + 1])


def _spelt(channels: Sequence[Channel], text: str) -> list[list[Channel]]:
    """Return those that are spelt so, from the strictest way to the loosest."""
    channels = [each for each in channels if not _LINE.fullmatch(each.name)]
    name, unit = _plain(text)
    groups = [each for each in channels if each.name.endswith(f"/{text}")]
    headed = [each for each in channels if (each.leaf, each.unit) == header(text)]
    loose = [
        each
        for each in channels
        if _plain(each.leaf)[0] in (name, *([text.casefold()] if "/" in text else []))
        and unit in ("", (each.unit or "").casefold())
    ]
    doubled = [each for each in channels if each.number is not None and each.name == f"{text} {each.number}"]
    return [groups, headed, doubled, loose]


def _plain(text: str) -> tuple[str, str]:
    """Return the name and the unit of a header as people copy them: in any case, with any brackets."""
    found = header(text)
    return " ".join(found.name.split()).casefold(), (found.unit or "").casefold()


def _line_of(where: str, channels: Sequence[Channel], name: str, column: str | None, row: str | None) -> Channel:
    """Return a line of an array, which the file may have the other way round."""
    shown = f"{name}[:, {column}]" if row is None else f"{name}[{row}, :]"
    lines = [each for each in channels if each.name.partition("[")[0] == name and each.name != name]
    if found := [each for each in lines if each.name == shown]:
        return found[0]
    k = int(row or column or 0)
    across = lines and (row is None) == lines[0].name.endswith(":]")
    if not across or k >= lines[0].samples.size:
        accepted = f"{lines[0].name!r} to {lines[-1].name!r}" if lines else _listed(channels)
        raise must_be(f"{where}: column", shown, accepted)
    samples = np.array([each.samples[k : k + 1][0] for each in lines])
    return replace(lines[0], name=shown, samples=samples, times=None)
