"""What a person is shown in standard situations, kept as text; the same in JSON; and the form of that.

FRICTIONLOOP_GOLDEN=1 writes tests/golden anew. A situation is a function that returns an answer.
"""

from __future__ import annotations

import importlib
import json
import os
import re
import tempfile
from collections.abc import Callable
from dataclasses import fields
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from golden import GOLDEN, REWRITE, check_screen

import frictionloop as fl
from frictionloop.findings import Result
from frictionloop.findings.render import WORST, lines

SRC = Path(fl.__file__).parent
ANSWER_WITHIN = 6
"""Lines in which the answer stands."""
RINGING = {"controller.kind": "pi", "controller.kp": 0.05, "controller.ki": 60.0}


def check_of_people() -> Result:
    weak = fl.bench().evolve({**RINGING, "controller.kp": 0.03, "controller.ki": 20.0})
    return fl.design.check(weak, fl.design.Requirements(slip_lengths_um=(11.5,)), fl.fingers(6, 0))


def simulate_recorded() -> Result:
    at_s = np.arange(4000) / 1000.0
    force_n = 0.3 + 0.02 * np.sin(3.0 * at_s) + 0.01 * np.sin(150.0 * at_s)
    with tempfile.TemporaryDirectory() as folder:
        path = f"{folder}/slide.csv"
        np.savetxt(path, np.c_[at_s, force_n], header="time_s,Ft [N]", comments="", delimiter=",")
        slide = fl.Recording(path=path, column="Ft", remove_mean=True)
        system = fl.bench().evolve({"disturbance": slide, "motion.stroke_mm": 40.0} | fl.RETUNED)
        return fl.diagnose(fl.simulate(system, 3.0), split_hz=(8,))


SITUATIONS: dict[str, Callable[[], Result]] = {
    "design-check": lambda: fl.design.check(fl.bench().evolve(RINGING)),
    "design-check-people": check_of_people,
    "design-controller": lambda: fl.design.controller(fl.bench(), "pi"),
    "design-limits": lambda: fl.design.limits(fl.bench(), "pi"),
    "design-plate": lambda: fl.design.plate(frequency_hz=40e3, bandwidth_hz=150.0),
    "design-sensor": lambda: fl.design.sensor(resonance_hz=200.0, range_n=2.0, noise_rms_n=1e-4),
    "simulate": lambda: fl.diagnose(fl.simulate(fl.bench())),
    "simulate-paper": lambda: fl.diagnose(fl.simulate(fl.paper())),
    "simulate-recorded": simulate_recorded,
}
"""By the name of a file in tests/golden. Another verb is one more function, and its name here."""
SLOW = {"design-controller", "design-limits"}
named = pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (name in SLOW)) for name in SITUATIONS]
)


@cache
def answered(name: str) -> Result:
    return SITUATIONS[name]()


@named
def test_the_screen_is_as_it_was_small_and_begins_with_the_answer(name):
    found = answered(name)
    check_screen(name, str(found))
    said = str(found).splitlines()
    assert "" in said[: ANSWER_WITHIN + 1] and len(found.rows()) <= ANSWER_WITHIN


@named
def test_what_the_screen_says_stands_in_json_too(name):
    found = answered(name)
    told = json.loads(found.to_json())
    assert told["schema"] == type(found).SCHEMA
    codes = [each["code"] for each in told["findings"]]
    on_screen = re.findall(r"^(?:error|warning|note) +([A-Z-]+) ", str(found), re.MULTILINE)
    assert on_screen == codes[:WORST]
    every = "\n".join("".join(text for text, _ in line) for line in lines(found, everything=True))
    for each in told["findings"]:
        assert each["code"] in every and " ".join(each["said"].split())[:20] in " ".join(every.split())


@named
def test_a_verdict_does_not_contradict_a_count(name):
    found = answered(name)
    if isinstance(found, fl.design.Check):
        verdict, held_on = found.rows()[1]
        assert (verdict == "HOLDS") == found.holds
        assert (verdict == "HOLDS") is (re.search(r"\d+ of \d+", held_on) is None)


def answers() -> list[type[Result]]:
    """Return the classes of answers of the whole package."""
    for path in SRC.rglob("*.py"):
        if ", schema=" in path.read_text(encoding="utf-8"):
            inside = path.relative_to(SRC).with_suffix("").parts
            importlib.import_module(".".join(("frictionloop", *inside)))
    found, left = set(), [Result]
    while left:
        for each in left.pop().__subclasses__():
            found.add(each)
            left.append(each)
    return sorted(
        (each for each in found if each.SCHEMA and each.__module__.startswith("frictionloop.")),
        key=lambda each: each.SCHEMA,
    )


def test_the_form_of_every_answer_is_as_it_was():
    """A field that goes or changes its type is another number in SCHEMA."""
    form = {each.SCHEMA: {field.name: str(field.type) for field in fields(each)} for each in answers()}
    path = GOLDEN / "schema.json"
    if os.environ.get(REWRITE):
        path.write_text(json.dumps(form, indent=1) + "\n", encoding="utf-8")
    assert form == json.loads(path.read_text(encoding="utf-8"))


def test_every_answer_has_a_form_of_its_own_and_says_what_it_is():
    found = answers()
    assert len({each.SCHEMA for each in found}) == len(found) > 3
    for each in found:
        assert re.fullmatch(r"[a-z]+(\.[a-z_]+)*/\d+", each.SCHEMA) and each.__doc__
        assert each.__dataclass_params__.frozen
