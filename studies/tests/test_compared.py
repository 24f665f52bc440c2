"""The tables on the pages of studies: of what is kept, and as the commands write them."""

from __future__ import annotations

import numpy as np
import pytest

from studies import kept, laws
from studies.compared import CHOICE, PAGE, choice, compared, written

NAMES = ("law", "speed_mm_s", "slip_length_um", "population", "fingers", "score", "unit", "median", "worst_decile")
SCORES = [
    ("pi", 20.0, 11.5, "all", 9, "residual_rms_n", "N", 0.5, 0.6),
    ("pi", 20.0, 11.5, "capable", 4, "residual_rms_n", "N", 0.02125, 0.03333333),
    ("pi", 20.0, 11.5, "capable", 4, "saturation_index", "1", 0.1, 0.2),
    ("pi", 20.0, 11.5, "capable", 4, "over_oracle", "1", np.nan, np.nan),
    ("pi", 20.0, 11.5, "median capable finger", 1, "sensitivity_peak", "1", np.inf, np.nan),
]


def test_the_table_of_laws_shows_scores_that_are_kept(tmp_path):
    path = tmp_path / "kept.csv"
    laws.keep([dict(zip(NAMES, row, strict=True)) for row in SCORES], path)
    errors, margins = compared(path).split("\n\n**")
    title, _, heads, _, row = errors.splitlines()
    assert title == "**20 mm/s, slip length 11.5 um, errors**, median / worst decile of 4 capable fingers:"
    assert cells(heads) == ["Law", "sines (mN)", "/ oracle"]
    assert cells(row) == ["`pi`", "21.2 / 33.3", "–"]
    title, _, heads, _, row = margins.splitlines()
    assert title == "20 mm/s, margins** of the median capable finger:"
    assert cells(heads) == ["Law", "11.5 um: $M_s$", "±5 %", "±10 %", "2.7 x", "2.7 x, -10 %"]
    assert cells(row) == ["`pi`", "∞", "–", "–", "–", "–"]


def test_the_page_has_the_table_of_the_stored_study():
    for path, table in ((PAGE, compared()), (CHOICE, choice())):
        page = path.read_text(encoding="utf-8")
        assert written(page, table) == page, "to write it anew: python -m studies.compared"


@pytest.mark.parametrize("path", [*sorted(kept.PAGES.glob("*.md")), *kept.SHOWN_IN], ids=lambda path: path.stem)
def test_every_page_has_the_tables_that_are_kept(path):
    page = path.read_text(encoding="utf-8")
    assert kept.written(page) == page, "to write them anew: python -m studies.kept"


def test_every_small_table_that_is_kept_is_shown():
    pages = "".join(path.read_text(encoding="utf-8") for path in [*kept.PAGES.glob("*.md"), *kept.SHOWN_IN])
    unshown = {"laws", "finger-validation", "closing-people", "closing-saves", "closing-power"}
    small = {path.stem for path in kept.RESULTS.glob("*.csv")} - unshown
    assert small == set(kept.SHOWN.findall(pages))


def test_a_table_is_kept_as_it_is_shown(tmp_path, monkeypatch):
    monkeypatch.setattr(kept, "RESULTS", tmp_path)
    kept.keep("errors", "errors", ("law", "rms"), [("pi", kept.both(np.array([1.0, 2.0, 3.0])))])
    assert (tmp_path / "errors.csv").read_text(encoding="utf-8").startswith("# python -m studies.errors, frictionloop ")
    shown = kept.written("before\n<!-- results/errors.csv -->\n<!-- end -->\nafter")
    assert shown.splitlines()[3:] == [
        "| law | rms |",
        "| --- | --- |",
        "| pi | 2.0 / 3.0 |",
        "",
        "<!-- end -->",
        "after",
    ]


def cells(row):
    return [cell.strip() for cell in row.strip("|").split("|")]
