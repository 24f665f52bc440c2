"""What is refused, its code, and in which words: transcripts in tests/golden/refused, a section a subject.

A line of Python begins with ``>>>``, a command with ``$``. Below what is refused stands with which code and message;
all else runs. ``FRICTIONLOOP_GOLDEN=1 pytest FILE`` writes messages anew, never whether something is refused or by
which code: of a new line ``?`` stands for both.
"""

from __future__ import annotations

import ast
import os
import re
import shlex
from pathlib import Path
from typing import NamedTuple

import pytest

from frictionloop.loop.registered_blocks import forget
from frictionloop.quantities import FrictionloopError

REFUSED = Path(__file__).parents[2] / "golden" / "refused"
ENTRY = re.compile(r"^(?:>>> .*(?:\n\.\.\. .*)*|\$ .*)(?:\n(?!>>> |\$ |#|\n).+)*$", re.MULTILINE)

MACHINE = re.compile(r"(?<=needed, ).*(?= free)|(?<=such port; there is ).*?(?=  \[|$)")
"""What another machine says otherwise: its free memory, its ports."""


class Entry(NamedTuple):
    """What is run, and the line that it is refused with, empty where it is not."""

    source: str
    answer: str

    @classmethod
    def read(cls, text: str) -> Entry:
        """Return an entry of a transcript."""
        lines = text.split("\n")
        source = [line for line in lines if line.startswith((">>> ", "... ", "$ "))]
        return cls("\n".join(source), "\n".join(lines[len(source) :]))


def sections() -> dict[str, tuple[Path, str]]:
    """Return the sections of all transcripts by name."""
    found = {}
    for path in sorted(REFUSED.glob("*.txt")):
        for text in re.split(r"^(?=## )", path.read_text(encoding="utf-8"), flags=re.MULTILINE)[1:]:
            found[f"{path.stem}: {text.splitlines()[0].removeprefix('## ')}"] = path, text
    return found


SECTIONS = sections()


def refusal(source: str, names: dict[str, object], frictionloop) -> str:
    """Run an entry, return the line that it is refused with, nothing if it runs."""
    if source.startswith("$ "):
        answer = frictionloop(*shlex.split(source.removeprefix("$ frictionloop ")))
        assert (answer.code, answer.out) in ((2, ""), (0, answer.out)), answer
        return "\n".join(answer.noted) if answer.code else ""
    try:
        exec(compile(ast.parse(re.sub(r"^(>>>|\.\.\.) ", "", source, flags=re.MULTILINE)), "transcript", "exec"), names)
    except FrictionloopError as error:
        return f"{error.code}: {error}"
    return ""


@pytest.mark.filterwarnings("ignore::frictionloop.SignalWarning")
@pytest.mark.parametrize("name", SECTIONS)
def test_each_is_refused_in_a_line_by_its_code(name, frictionloop, tmp_path):
    path, text = SECTIONS[name]
    anew, names = os.environ.get("FRICTIONLOOP_GOLDEN"), {}
    for found in ENTRY.findall(text):
        (source, known), before = Entry.read(found), set(tmp_path.iterdir())
        said = MACHINE.sub("...", refusal(source, names, frictionloop).replace(f"{tmp_path}/", ""))
        assert "\n" not in said and bool(said) == bool(known), f"{source}\n{said}"
        assert source[0] != "$" or not said or set(tmp_path.iterdir()) == before, f"{source} leaves a file"
        if anew and known:
            assert known == "?" or said.split(": ")[0] == known.split(": ")[0], f"{source}\n{said}"
            text = text.replace(f"{source}\n{known}\n", f"{source}\n{said}\n", 1)
        assert anew or said == known, source
    forget()
    if anew:
        path.write_text(path.read_text(encoding="utf-8").replace(SECTIONS[name][1], text), encoding="utf-8")
