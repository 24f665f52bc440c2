"""A person at the keyboard: what is asked, what is taken as an answer."""

import io
import json
import os
import threading

import pytest

from frictionloop.experiments import Protocol, run
from frictionloop.experiments.respondent import Aborted, Keyboard, bar
from frictionloop.experiments.session_folder import read_trials
from frictionloop.experiments.trial_sequence import TrialOrder

PLAN = Protocol(
    stimulus={"standard": 0.35},
    method={"kind": "staircase", "start": [0.15], "most": 0.2},
    timeline={"stroke": {"length_mm": 10.0}},
    blocks={"practice": 1, "break_every": 2},
    stop={"trials": 3},
    validity={"least_response_s": 0.0},
)


def test_answers_are_choices_and_breaks_wait_for_enter(tmp_path):
    keys, shown = io.StringIO("1\nx\n2\n1\n\n1\n" + "1\n" * 9), io.StringIO()
    path = run(PLAN, tmp_path / "P01", "P01", respondent=Keyboard(PLAN, keys, shown)).folder
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


def test_notes_pauses_and_an_abort_are_in_the_log_and_answers_are_not_taken_for_them(tmp_path):
    keys = io.StringIO("1\nnote the finger is wet\n1\npause\n\n1\nabort\n")
    with pytest.raises(Aborted):
        run(PLAN, tmp_path / "P01", "P01", respondent=Keyboard(PLAN, keys, io.StringIO()))
    lines = [json.loads(line) for line in (tmp_path / "P01" / "log.jsonl").read_text().splitlines()]
    events = [each for each in lines if each["event"] in ("note", "pause", "go on", "abort", "stopped")]
    assert [each["event"] for each in events] == ["note", "pause", "go on", "abort", "stopped"]
    assert (events[0]["trial"], events[0]["text"]) == (2, "the finger is wet")
    assert events[-1]["why"] == "aborted at the keyboard"


def test_what_was_typed_before_the_question_is_no_answer_but_its_words_are_obeyed():
    mine, theirs = os.openpty()
    with os.fdopen(theirs) as keys, os.fdopen(mine, "w", buffering=1) as typed:
        keyboard, notes = Keyboard(PLAN, keys, io.StringIO()), []
        keyboard.log = lambda event, **told: notes.append(told.get("text"))
        typed.write("1\n\n1\nnote dry\n1")  # impatient, and half a line
        threading.Timer(0.3, typed.write, ["2\n"]).start()
        found = keyboard.respond(TrialOrder(PLAN, "P01").next(), [])
    assert (found.response, notes) == ("2", ["dry"])
    assert found.rt_s > 0.2


def test_an_answer_sooner_than_anybody_feels_does_not_count(tmp_path):
    plan = PLAN.evolve({"validity.least_response_s": 0.1, "fit_to_finger": False})
    keyboard = Keyboard(plan, io.StringIO("1\n"), io.StringIO())
    row = read_trials(run(plan, tmp_path / "P01", "P01", respondent=keyboard, trials=1).folder).iloc[0]
    assert (row["valid"], row["again"], row["response"]) == (0, 1, "1")
    assert row["reason"].startswith("rt_s=")


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.mark.slow
def test_on_a_terminal_a_bar_shows_where_the_finger_ought_to_be(tmp_path):
    shown = Terminal()
    keyboard = Keyboard(PLAN, io.StringIO("1\n"), shown)
    with pytest.raises(KeyboardInterrupt):
        run(PLAN.evolve({"fit_to_finger": False}), tmp_path / "P01", "P01", respondent=keyboard)
    first = shown.getvalue().partition("trial 1:")[0]
    bars = [each for each in first.split("\r") if each.startswith("1 |")]
    places = [each.index("o") for each in bars]
    assert len(bars) > 5
    assert places == sorted(places)
    assert places[-1] > 30
    assert "mm/s" in bars[-1]
    assert [bar(0.25, way, 9).index("o") for way in ("forth", "back", "both")] == [3, 7, 5]
