"""What README.md shows is what happens."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

import frictionloop as fl

README = Path(__file__).parents[3] / "README.md"
TEXT = README.read_text(encoding="utf-8")


def blocks(language):
    return re.findall(rf"^```{language}\n(.*?)^```", TEXT, flags=re.DOTALL | re.MULTILINE)


def test_python_runs(capsys):
    (source,) = blocks("python")
    assert len(source.strip().replace("\n\n", "\n").splitlines()) <= 5
    exec(source, {})
    r2, error = map(float, capsys.readouterr().out.split())
    assert 0.9 < r2 < 1
    assert 0 < error < 0.05


@pytest.mark.slow
def test_commands_run_and_print_what_is_shown(frictionloop):
    for block in blocks("console"):
        for shown in re.split(r"^\$ ", block, flags=re.MULTILINE)[1:]:
            command, _, output = shown.partition("\n")
            if not command.startswith("frictionloop"):
                continue
            answer = frictionloop(*shlex.split(command)[1:])
            assert (answer.code, answer.err) == (0, ""), command
            if output.strip():
                printed = [line.rstrip() for line in answer.out.splitlines() if "simulated in" not in line]
                assert printed == [line for line in output.splitlines() if "simulated in" not in line]


@pytest.mark.slow
def test_commands_named_in_the_text_exist(frictionloop):
    named = [line for line in re.findall(r"`(frictionloop [^`]+)`", TEXT) if "<" not in line]
    assert named
    fl.write_toml(fl.bench().evolve(fl.RETUNED), "my-controller.toml")  # as the commands before have written it
    for command in named:
        serves = ["--help"] if command == "frictionloop studio" else []  # until it is stopped
        assert frictionloop(*shlex.split(command)[1:], *serves).code == 0, command


def test_files_and_make_targets_exist():
    for target in re.findall(r"\]\((?!https?:)([^)#]+)\)", TEXT):
        assert (README.parent / target).exists(), target
    makefile = (README.parent / "Makefile").read_text(encoding="utf-8")
    for words in re.findall(r"make ((?:[a-z]+ ?)+)", TEXT):
        for target in words.split():
            if target in {"reproduce", "test", "benchmark", "lint", "types", "imports", "docs"}:
                assert f"\n{target}:" in makefile, target
