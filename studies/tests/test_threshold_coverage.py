"""How right thresholds are: what is told of values by hand, and the kept rows found again."""

from __future__ import annotations

import csv

import numpy as np
import pytest

from studies import kept
from studies.threshold_coverage import rows, told


def test_bias_and_share_that_holds_are_of_sessions_with_a_threshold():
    found = np.array([[1.1, 0.9, 1.3], [np.nan] * 3, [2.2, 2.1, 2.5], [4.4, 3.0, 5.0], [0.5, 0.4, 0.9]])
    assert told(found, np.array([1.0, 9.0, 2.0, 4.0, 0.5])) == pytest.approx((7.5, 75.0))


@pytest.mark.slow
def test_kept_rows_are_found_again():
    with (kept.RESULTS / "threshold-coverage.csv").open(newline="", encoding="utf-8") as stream:
        _, *stored = csv.reader(line for line in stream if not line.startswith("#"))
    sessions = int(stored[0][2])
    assert [str(each) for each in next(rows(sessions, 0))[:6]] == stored[0][:6]
