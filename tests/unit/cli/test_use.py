"""`--use FILE`: a block of the caller's own on the command line."""

from __future__ import annotations

import sys
from pathlib import Path

import half_law
import pytest

from frictionloop.loop.blocks import forget

LAW = Path(half_law.__file__).read_text(encoding="utf-8")
REGISTER = '\n\nfl.register(fl.Law("half", half, State, Gains), HalfController)\n'


def forgotten():
    """As in a new process: nothing is registered, the module is not imported."""
    forget()
    sys.modules.pop("my_law", None)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    (tmp_path / "my_law.py").write_text(LAW + REGISTER, encoding="utf-8")
    monkeypatch.setattr(sys, "path", list(sys.path))
    yield tmp_path
    forgotten()


@pytest.mark.slow
def test_a_law_of_ones_own_runs_and_is_kept_in_files(frictionloop, process, folder):
    short = ("--preset", "bench", "--controller.kind", "half", "--duration-s", "0.1")
    ran = frictionloop("--use", "my_law.py", "simulate", *short, "--save-system", "half.toml")
    assert (ran.code, ran.err) == (0, "")
    assert 'kind = "half"' in (folder / "half.toml").read_text(encoding="utf-8")
    again = process("simulate", "half.toml", "--duration-s", "0.1", "--use=my_law")
    assert again.ended() == (0, [])
    # A file that names it brings no code.
    forgotten()
    refused = frictionloop("simulate", "half.toml")
    assert refused.code == 2
    assert "--use FILE" in refused.err


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("x = 1 / 0\n", "my_law.py, line 1: division by zero"),
        ("import frictionloop as fl\nfl.register(3)\n", "Law, Vibration, Signal, StreamingMetric, RunMetric"),
        ("def broken(:\n", "SyntaxError"),
    ],
)
def test_an_error_in_the_file_is_told_in_one_line(frictionloop, folder, text, told):
    (folder / "my_law.py").write_text(text, encoding="utf-8")
    ran = frictionloop("--use", "my_law.py", "simulate")
    assert ran.code == 2
    assert told in ran.err
    assert len(ran.err.strip().splitlines()) == 1


@pytest.mark.parametrize("tokens", [("--use",), ("--use", "absent.py")])
def test_a_file_that_is_not_there_is_told(frictionloop, tokens):
    ran = frictionloop("simulate", *tokens)
    assert ran.code == 2
    assert "--use" in ran.err
