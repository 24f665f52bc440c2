"""The session that the documentation shows, run again."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

TOOLS = Path(__file__).parents[2] / "docs" / "_tools"


@pytest.fixture
def session(monkeypatch):
    """Return the module that makes the transcript."""
    monkeypatch.syspath_prepend(str(TOOLS))
    import transcript

    yield transcript
    for name in [name for name, module in sys.modules.items() if str(TOOLS) in str(getattr(module, "__file__", ""))]:
        del sys.modules[name]


def test_the_transcript_is_what_the_commands_print(session):
    kept = session.TARGET.read_text(encoding="utf-8")
    assert session.transcript() == kept, "to write it anew: python docs/_tools/transcript.py"


def test_lines_of_the_transcript_fit_the_page(session):
    assert max(len(line) for line in session.TARGET.read_text(encoding="utf-8").splitlines()) <= 88


def test_a_command_that_ends_otherwise_is_an_error(session):
    with pytest.raises(RuntimeError, match=r"device set sim: drive\.ceiling_um=9: exit code 2"):
        session.command("device set sim: drive.ceiling_um=9")
    with pytest.raises(RuntimeError, match="exit code 0"):
        session.command("--version", ends=2)
