"""What `identify channels` says of a file's date, of uneven times, and of what its numbers are."""

from __future__ import annotations

import re
from datetime import datetime

import numpy as np
import pytest
from scipy.io import savemat


def test_the_date_of_a_mat_file_is_that_of_its_header(frictionloop):
    savemat("f.mat", {"force": np.linspace(0.1, 0.2, 50), "fs": 1000.0})
    said = frictionloop("identify", "channels", "f.mat").out
    with open("f.mat", "rb") as stream:
        header = stream.read(116).decode()
    created = datetime.strptime(header.partition("Created on: ")[2].strip(" \0"), "%a %b %d %H:%M:%S %Y")
    assert re.search(r"^recorded +(.*?) *$", said, re.MULTILINE)[1] == created.isoformat()


def test_uneven_times_are_why_there_is_no_rate(frictionloop):
    times = np.cumsum((1 + 0.3 * np.random.default_rng(0).uniform(-1, 1, 400)) / 71)
    np.savetxt("f.txt", np.c_[times, np.sin(times)], header="Time force", comments="")
    said = frictionloop("identify", "channels", "f.txt").out
    assert re.search(r"^rate +none *$", said, re.MULTILINE)
    assert "TIMES-UNEVEN" in said and "RATE-UNKNOWN" not in said


def test_the_rms_is_about_the_mean(frictionloop):
    values = 5.0 + np.tile([-0.1, 0.1], 50)
    np.savetxt("f.csv", values, header="force", comments="")
    said = frictionloop("identify", "channels", "f.csv").out
    assert re.search(r"^force .* 0\.1 *$", said, re.MULTILINE)
    assert re.search(r"^rate +none *$", said, re.MULTILINE) and "RATE-UNKNOWN" in said


def test_uneven_times_have_a_figure_dates_are_iso_and_all_is_shown_once(tmp_path, frictionloop):
    at_s = np.arange(600) / 1000
    rows = [f"{at + 2e-4 * (k == 70):.4f}," + ",".join(f"{k}.{c}" for c in range(14)) for k, at in enumerate(at_s)]
    names = ",".join(["time_s", *(f"c{c}" for c in range(14))])
    (tmp_path / "a.csv").write_text("Date,05.03.2024 10:11:12\n" + "\n".join([names, *rows]))
    answer = frictionloop("identify", "channels", str(tmp_path / "a.csv"), "--json").json()
    uneven = next(each for each in answer["findings"] if each["code"] == "TIMES-UNEVEN")
    assert (uneven["value"], uneven["unit"]) == (pytest.approx(0.2), "ms")
    assert (answer["date"], answer["dated"]) == ("2024-03-05T10:11:12", True)
    said = frictionloop("identify", "channels", str(tmp_path / "a.csv"), "--all").out
    assert all(said.count(f"\nc{c} ") == 1 for c in range(14)) and str(tmp_path) not in said
