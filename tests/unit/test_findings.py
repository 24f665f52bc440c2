"""Findings, conditions, results: values, one line each, and the same in every form; the catalogue and who uses it."""

from __future__ import annotations

import ast
import json
import math
import re
from dataclasses import FrozenInstanceError, dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np
import pandas as pd
import pytest
from message_branches import branches_on_messages

import frictionloop as fl
from frictionloop.findings import CATALOGUE, Condition, Finding, Result, explain, shown
from frictionloop.findings.catalogue import SEVERITIES
from frictionloop.findings.render import LINES, WIDTH, WORST, lines
from frictionloop.findings.result import plain, toml_table
from frictionloop.findings.shown import Template, between
from frictionloop.quantities import must_be

SRC = Path(fl.__file__).parent
FILES = sorted(SRC.rglob("*.py"))
MOST_CODES, MOST_TITLE, MOST_TEMPLATE, MOST_EXPLANATION = 150, 12, 25, 60
MOIST = Finding("RING-MOIST", value=4.19, where=Condition(speed_mm_s=20.0), remedy={"motion.contact_s": 10.0})
NOTE, ERROR = Finding("NO-LOOP"), Finding("LAW-CONTRADICTS", value=238.0, unit="mN", limit=190.0)


@dataclass(frozen=True, kw_only=True)
class Answer(Result):
    SCHEMA: ClassVar[str] = "test.answer/1"
    gain: float = math.nan
    trace_n: tuple[float, ...] = (1.0, math.inf)

    def rows(self):
        return [("gain", shown(self.gain)), ("said", "word " * 40)]

    def tables(self):
        frame = pd.DataFrame({"Ms": [1.234, math.inf], "who": ["<a>", "b"]}, index=["low", "high"]).rename_axis("off")
        return {"first": frame, "second": frame * 1}


@pytest.mark.parametrize(("value", "said"), [
    (0.0123456, "0.0123"), (1234.5, "1234"), (0.99951, "1.000"), (math.inf, "∞"), (-math.inf, "-∞"), (math.nan, "-"),
    (None, "-"), (True, "yes"), (12, "12"), ("a word", "a word"), ((1.0, 2.5), "1, 2.5"),
    ({"motion.contact_s": 10.0, "plate.q": 2}, "--motion.contact_s 10 --plate.q 2"),
])  # fmt: skip
def test_a_value_is_as_short_as_it_says_something(value, said):
    assert shown(value) == said
    assert Template().format("{x}", x=value) == said


def test_a_template_keeps_a_format_of_its_own_and_a_range_is_told_by_its_ends():
    assert Template().format("{x:.1f}", x=2.34567) == "2.3"
    assert between(20.0, 60.0, "mm/s") == "20 to 60 mm/s" and between(0.5, 0.5) == "0.5"


def test_a_condition_says_what_applies_and_nothing_else():
    where = Condition(finger=3, channel="f_a", slip_length_um=0.0, speed_mm_s=(10.0, 80.0), occluded=0.39)
    assert str(where) == "finger 3, f_a, slip 0 um, 10, 80 mm/s, 39 % moist"
    assert str(Condition(force_n=0.6, load_n=0.5, occluded=0.0, resonance_off=-0.1)) == (
        "pressed 0.5 N, at 0.6 N, just landed, resonance -10 %"
    )
    assert Condition().values == {} and str(Condition()) == ""
    assert set(where.values) == {"finger", "channel", "slip_length_um", "speed_mm_s", "occluded"}


def test_a_finding_is_a_frozen_value_of_a_known_code():
    assert (MOIST.severity, MOIST.rank, NOTE.rank, ERROR.rank) == ("warning", 1, 2, 0)
    assert Finding("RING-MOIST", severity="note").severity == "note"
    assert str(MOIST) == "never lifted: Ms 4.19, 20 mm/s"
    assert MOIST.to_dict() == {
        "code": "RING-MOIST", "severity": "warning", "said": str(MOIST), "value": 4.19,
        "remedy": {"motion.contact_s": 10.0}, "where": {"speed_mm_s": 20.0},
    }  # fmt: skip
    with pytest.raises(FrozenInstanceError):
        MOIST.value = 1.0
    with pytest.raises(fl.FrictionloopError, match=r"'RING-MOST' is unknown; did you mean RING-MOIST") as refused:
        Finding("RING-MOST")
    assert explain("NO-LOOP").severity == "note" and "\n" not in str(refused.value)


def test_findings_stand_worst_first_and_none_twice():
    found = Answer(findings=(NOTE, MOIST, ERROR))
    assert [each.code for each in found.findings] == ["LAW-CONTRADICTS", "RING-MOIST", "NO-LOOP"]
    more = found.with_findings([NOTE, Finding("FINGER-DRY")])
    assert [each.code for each in more.findings] == ["LAW-CONTRADICTS", "RING-MOIST", "NO-LOOP", "FINGER-DRY"]
    assert found.gain is more.gain and len(found.findings) == 3


def test_json_has_everything_and_nothing_that_json_lacks():
    found = Answer(gain=2.0, findings=(MOIST,))
    read = json.loads(found.to_json())
    assert read == found.to_dict()
    assert list(read) == ["schema", "gain", "trace_n", "findings"]
    assert (read["schema"], read["gain"], read["trace_n"]) == ("test.answer/1", 2.0, [1.0, "Infinity"])
    assert read["findings"] == [MOIST.to_dict()]


def test_values_of_every_kind_become_plain():
    system = fl.bench()
    given = {1: np.float64(2.0), "b": system, "c": Condition(load_n=1.0), "d": {3}, "e": np.array([1.0, np.nan])}
    assert plain(given) == {"1": 2.0, "b": system.model_dump(), "c": {"load_n": 1.0}, "d": [3], "e": [1.0, None]} | {
        "b": json.loads(json.dumps(plain(system)))
    }
    assert plain(pd.Series([1, 2]).to_xarray().to_dataset(name="x")) == {"index": [0, 1], "x": [1, 2]}


def test_a_terminal_gets_the_answer_first_five_findings_and_how_many_more():
    many = Answer(gain=2.0, findings=(*[NOTE] * 4, MOIST, ERROR, Finding("FINGER-DRY")))
    said = str(many).splitlines()
    assert said[0] == "gain  2" and max(map(len, said)) <= WIDTH and len(said) <= LINES
    assert "off     Ms  who" in said and "low   1.23  <a>" in said and "high     ∞  b" in said
    assert said[-1] == "2 more: --all" and sum(line.startswith(SEVERITIES) for line in said) == WORST
    every = "\n".join("".join(text for text, _ in line) for line in lines(many, everything=True))
    assert "second" in every and "more: --all" not in every and every.count("NO-LOOP") == 4


def test_a_long_finding_is_cut_on_the_screen_and_whole_with_everything():
    values = {f"plate.value_{k}": 1.0 for k in range(90)}
    found = Answer(findings=(Finding("ASSUMED", value=90, more={"values": values}),))
    assert str(found).endswith("...")
    every = " ".join("".join(text for text, _ in line) for line in lines(found, everything=True))
    assert "--plate.value_89 1" in " ".join(every.split())


def test_html_and_a_notebook_have_everything_and_nothing_that_is_taken_for_tags():
    found = Answer(gain=2.0, findings=(MOIST,))
    fragment, page = found._repr_html_(), found.to_html()
    assert fragment in page and page.startswith("<!doctype html>") and "test answer" in page
    for piece in ("RING-MOIST", str(MOIST), "&lt;a&gt;", "second", "Sweat that cannot leave"):
        assert piece in fragment
    assert "<a>" not in fragment


def test_a_table_is_named_or_the_first_and_what_is_not_there_is_refused():
    found = Answer()
    assert found.table().equals(found.table("first"))
    with pytest.raises(fl.FrictionloopError, match="table = 'third': accepted are first, second"):
        found.table("third")
    with pytest.raises(fl.FrictionloopError, match="Answer has no figure"):
        found.plot()
    assert Result().rows() == () and str(Result()) == ""


def test_a_block_is_shown_as_toml():
    frame = toml_table("plate", {"kind": "resonant", "q": 230.00000001, "levels": 3, "on": True})
    assert frame.index.name == "[plate]" and frame[""].tolist() == ['= "resonant"', "= 230.0", "= 3", "= true"]


def test_an_error_has_the_code_of_its_entry():
    assert must_be("q", 0.0, "above 0", "um").code == "BAD-VALUE"
    assert fl.FrictionloopError("x", "NO-GAINS").code == "NO-GAINS"
    with pytest.raises(fl.FrictionloopError) as refused:
        fl.bench().evolve({"plate.q": -1.0})
    assert refused.value.code in CATALOGUE


def test_the_catalogue_is_one_that_a_person_can_know_and_its_entries_are_short():
    assert len(CATALOGUE) <= MOST_CODES
    for code, known in CATALOGUE.items():
        assert re.fullmatch(r"[A-Z]+(-[A-Z]+)*", code) and known.severity in SEVERITIES, code
        assert 0 < len(known.title.split()) <= MOST_TITLE and not known.title.endswith("."), code
        assert len(known.template.split()) <= MOST_TEMPLATE, code
        assert 0 < len(known.explanation.split()) <= MOST_EXPLANATION, code
        assert known.explanation.strip().endswith((".", "!", '"')), code


def test_every_code_of_the_source_is_in_the_catalogue():
    called = set()
    for node in (node for path in FILES for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            place = {"Finding": 0, "FrictionloopError": 1, "must_be": 4}.get(node.func.id)
            given = [] if place is None else node.args[place : place + 1]
            given += [each.value for each in node.keywords if place is not None and each.arg == "code"]
            called |= {each.value for each in given if isinstance(each, ast.Constant)}
    assert len(called) > 100 and called - set(CATALOGUE) == set()


def test_nothing_branches_on_text_of_our_own(tmp_path):
    found = {str(path.relative_to(SRC)): [*branches_on_messages(path)] for path in FILES}
    assert {name: at for name, at in found.items() if at} == {}
    bad = tmp_path / "bad.py"
    bad.write_text(
        "try:\n    pass\nexcept FrictionloopError as error:\n    a = 'x' in str(error)\n    b = error.args\n"
        "    c = str(error).endswith('x')\n    d = re.search('x', str(error))\n    e = error.code == 'X'\n"
    )
    assert [*branches_on_messages(bad)] == [4, 5, 6, 7]


def test_in_ipython_a_result_is_what_the_command_line_shows():
    from IPython.core.formatters import DisplayFormatter

    answer = Answer(gain=1.5)
    found, _ = DisplayFormatter().format(answer)
    assert found["text/plain"] == str(answer) and "<table" in found["text/html"]
