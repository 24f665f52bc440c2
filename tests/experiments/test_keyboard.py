"""A person at the keyboard: what is asked, what is taken as an answer."""

import io

import pytest

from frictionloop.experiments import Protocol, run
from frictionloop.experiments.keyboard import Keyboard
from frictionloop.experiments.summary import read_trials

PLAN = Protocol(
    stimulus={"standard": 0.35},
    method={"kind": "staircase", "start": [0.15], "most": 0.2},
    timeline={"stroke": {"length_mm": 10.0}},
    blocks={"practice": 1, "break_every": 2},
    stop={"trials": 3},
)


def test_answers_are_choices_and_breaks_wait_for_enter(tmp_path):
    keys, shown = io.StringIO("1\nx\n2\n1\n\n1\n" + "1\n" * 9), io.StringIO()
    path = run(PLAN, tmp_path / "P01", "P01", respondent=Keyboard(PLAN, keys, shown))
    trials = read_trials(path)
    assert trials["response"].tolist()[:4] == ["1", "2", "1", "1"]
    assert set(trials["phase"][1:]) == {"main"}
    assert "a break" in shown.getvalue()
    assert "stroke 10 mm at 20 mm/s" in shown.getvalue()
    assert trials["valid"].all()


def test_a_keyboard_that_closes_leaves_the_session_to_be_resumed(tmp_path):
    with pytest.raises(KeyboardInterrupt):
        run(PLAN, tmp_path / "P01", "P01", respondent=Keyboard(PLAN, io.StringIO("1\n"), io.StringIO()))
    assert len(read_trials(tmp_path / "P01")) == 1
    assert "stopped" in (tmp_path / "P01" / "log.jsonl").read_text()
