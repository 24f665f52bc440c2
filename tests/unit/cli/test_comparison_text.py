"""The tables of a comparison fit a terminal of 80 columns."""

from __future__ import annotations

import math
from types import SimpleNamespace

import pytest

from frictionloop.cli import screen
from frictionloop.cli.comparison_text import SHOWN, _scores, short
from frictionloop.design.comparison import ENTRANTS


@pytest.mark.parametrize(
    "value, text",
    [
        (0.9925, ".993"),
        (0.848, "0.85"),
        (6.667, "6.7"),
        (9.96, "10"),
        (613.4, "613"),
        (-48.12, "-48"),
        (0.004567, "0.0046"),
        (-9999.0, "-9999"),
        (math.inf, "∞"),
        (-math.inf, "-∞"),
        (0.0, "0"),
    ],
)
def test_a_score_in_two_digits(value, text):
    assert short(value) == text


def test_all_laws_fit_80_columns_to_the_last_score(capsys, monkeypatch):
    """Cells about as long as they get: an R2 of thousands below 0, times of 100 ms, and 613 times an oracle's rms."""
    monkeypatch.setenv("COLUMNS", "80")
    long = {
        "r2_identity": (-0.4567, -9876.5),
        "residual_rms_n": (0.61349, 0.98765),
        "fall_63_s": (0.012345, 0.1134),
        "relative_index": (0.01234, 118.2),
        "over_oracle": (613.4, 11234.5),
    }
    assert list(long) == [name for name, _, _ in SHOWN]
    rows = [
        {"law": law, "score": name, "median": median, "worst_decile": worst}
        for law in ENTRANTS
        for name, (median, worst) in long.items()
    ]
    screen.show(screen.table(_scores(SimpleNamespace(laws=ENTRANTS), rows, {})))
    heads, *lines = capsys.readouterr().out.splitlines()
    assert heads.split()[-1] == "/oracle"
    assert [line.split()[0] for line in lines] == list(ENTRANTS)
    assert all(line.split()[1:] == ["-0.46/-9876", "613/988", "12/113", "0.012/118", "613/11234"] for line in lines)
    assert max(map(len, (heads, *lines))) <= 80
