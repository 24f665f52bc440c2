"""Commands called in this process, and as a process of their own."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from functools import cache
from typing import NamedTuple

import pytest

from frictionloop.cli import main


@pytest.fixture(autouse=True, scope="session")
def _designed_once():
    """The notch of a bench takes seconds to find, a check one: what README.md and the tests design and check is one."""
    from frictionloop import design
    from frictionloop.design import controller_design, controller_synthesis

    really = controller_synthesis.synthesised
    known = cache(really)

    def synthesised(system, law, asked):
        return (known if law == "notch_pi" else really)(system, law, asked)

    checked, checks = design.check, {}

    def check(system, requirements=None, people=None, *, given=()):
        key = repr((system, requirements, people, sorted(given)))
        if key not in checks:
            checks[key] = checked(system, requirements, people, given=given)
        return checks[key]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(design, "check", check)
        for room in (controller_synthesis, controller_design):
            patch.setattr(room, "synthesised", synthesised)
        yield


def without_progress(told):
    """Return lines of stderr but those in which work that takes long says how far it is: a busy machine has some."""
    return [line for line in told.splitlines() if not line.endswith(" s so far")]


class Started(subprocess.Popen):
    """A command that runs as a process of its own."""

    def ended(self):
        """Return the exit code, and what was said on stderr beside progress."""
        return self.wait(60), without_progress(self.stderr.read())


class Answer(NamedTuple):
    code: int
    out: str
    err: str

    @property
    def noted(self):
        """Lines of stderr without progress."""
        return without_progress(self.err)

    def json(self):
        def refuse(word):
            raise AssertionError(f"{word} is not JSON")

        assert (self.code, self.noted) == (0, [])
        return json.loads(self.out, parse_constant=refuse)


@pytest.fixture
def frictionloop(capsys, monkeypatch, tmp_path):
    """Return a function that runs one command in an empty folder."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.argv", ["/elsewhere/frictionloop"])

    def run(*tokens):
        with pytest.raises(SystemExit) as left:
            main([str(token) for token in tokens])
        return Answer(left.value.code, *capsys.readouterr())

    return run


@pytest.fixture
def process(tmp_path):
    """Return a function that starts one command as a process in the same empty folder."""
    started = []
    # A shell that runs the tests in the background has told them to ignore Ctrl-C, and processes inherit that.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)

    def start(*tokens):
        running = Started(
            [sys.executable, "-m", "frictionloop", *map(str, tokens)],
            cwd=tmp_path,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        started.append(running)
        return running

    yield start
    signal.signal(signal.SIGINT, before)
    for running in started:
        running.kill()
        running.communicate()
