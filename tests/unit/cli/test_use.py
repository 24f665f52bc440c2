"""`--use FILE`: a block of the caller's own on the command line."""

from __future__ import annotations

import subprocess
import sys

import pytest

LAW = """
from typing import Literal, NamedTuple

import frictionloop as fl


class Parameters(fl.Timing):
    kind: Literal["half"] = "half"
    share: float = 0.5


class State(NamedTuple):
    nothing: float


class Gains(NamedTuple):
    share: float
    low: float
    high: float


@fl.step
def half(state, measured, setpoint_n, gains, dt):
    v = gains.share * setpoint_n
    u = min(max(v, gains.low), gains.high)
    return state, fl.ForceCommand(u, 1.0 if u != v else 0.0)


fl.register(fl.Law("half", half, State, Gains), Parameters)
"""


def frictionloop(*tokens, folder):
    command = [sys.executable, "-m", "frictionloop", *tokens]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "my_law.py").write_text(LAW, encoding="utf-8")
    return tmp_path


def test_a_law_of_ones_own_runs_and_is_kept_in_files(folder):
    short = ("--preset", "bench", "--controller.kind", "half", "--duration-s", "0.1")
    ran = frictionloop("--use", "my_law.py", "simulate", *short, "--save-system", "half.toml", folder=folder)
    assert ran.returncode == 0, ran.stderr
    assert 'kind = "half"' in (folder / "half.toml").read_text(encoding="utf-8")
    again = frictionloop("simulate", "half.toml", "--duration-s", "0.1", "--use=my_law", folder=folder)
    assert again.returncode == 0, again.stderr
    # A file that names it brings no code.
    refused = frictionloop("simulate", "half.toml", folder=folder)
    assert refused.returncode == 2
    assert "--use FILE" in refused.stderr


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("x = 1 / 0\n", "my_law.py, line 1: division by zero"),
        ("import frictionloop as fl\nfl.register(3)\n", "must be a fl.Law"),
        ("def broken(:\n", "SyntaxError"),
    ],
)
def test_an_error_in_the_file_is_told_in_one_line(folder, text, told):
    (folder / "my_law.py").write_text(text, encoding="utf-8")
    ran = frictionloop("--use", "my_law.py", "simulate", folder=folder)
    assert ran.returncode == 2
    assert told in ran.stderr
    assert len(ran.stderr.strip().splitlines()) == 1


@pytest.mark.parametrize("tokens", [("--use",), ("--use", "absent.py")])
def test_a_file_that_is_not_there_is_told(folder, tokens):
    ran = frictionloop("simulate", *tokens, folder=folder)
    assert ran.returncode == 2
    assert "--use" in ran.stderr
