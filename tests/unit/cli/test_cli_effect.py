"""The help of the commands of effects."""

from __future__ import annotations

import pytest


@pytest.mark.parametrize("verb", ["list", "show", "check", "play", "import"])
@pytest.mark.parametrize("columns", [80, 120])
def test_help_has_examples_that_fit(frictionloop, monkeypatch, verb, columns):
    monkeypatch.setenv("COLUMNS", str(columns))
    answer = frictionloop("effect", verb, "--help")
    assert f"\n  frictionloop effect {verb}" in answer.out
    assert max(len(line.rstrip()) for line in answer.out.splitlines()) <= columns
