"""A session is a folder that can be left at any moment, and goes on as if it had not been."""

import csv
import multiprocessing
import os
import shutil
import signal
import time

import numpy as np
import pandas
import pytest
from hypothesis import given
from hypothesis import strategies as st

import frictionloop as fl
from frictionloop.experiments import Protocol, session_folder
from frictionloop.experiments.resumable_session import resume, run
from frictionloop.experiments.session_folder import read_trials
from frictionloop.experiments.trial_records import check_of, read_rows
from frictionloop.quantities import FrictionloopError

STAIRCASE = Protocol(
    name="short",
    stimulus={"standard": 0.35},
    method={"kind": "staircase", "start": [0.15], "most": 0.2},
    timeline={"stroke": {"length_mm": 10.0}},
    blocks={"practice": 1, "catch_share": 0.2},
    stop={"trials": 5},
    conditions=[{"name": "closed"}, {"name": "open", "system": {"controller.kind": "lookup"}}],
)
PSI = STAIRCASE.evolve({"method": {"kind": "psi", "levels": 12, "thresholds": 20, "spreads": 6}})


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return run(PSI, tmp_path_factory.mktemp("whole") / "P01", "P01").folder


@pytest.mark.slow
def test_a_session_left_at_any_row_goes_on_with_the_same_trials_and_posterior(whole, tmp_path):
    expected = (whole / "trials.tsv").read_text()
    lines = expected.splitlines(keepends=True)
    rng = np.random.default_rng(0)
    for number in range(2):
        path = tmp_path / f"{number}"
        shutil.copytree(whole, path)
        kept = "".join(lines[: 1 + int(rng.integers(1, len(lines) - 1))])
        torn = lines[-1][: int(rng.integers(1, 60))]  # a row that was being written
        (path / "trials.tsv").write_text(kept + torn)
        resume(path)
        assert (path / "trials.tsv").read_text() == expected


@pytest.mark.slow
def test_what_was_asked_is_what_was_delivered_and_the_traces_are_kept(whole):
    trials = read_trials(whole)
    closed = trials[(trials["condition"] == "closed") & (trials["valid"] == 1)]
    assert np.abs(closed["delivered"] - closed["requested"]).median() < 0.005
    row = trials.iloc[3]
    run_ = fl.load(whole / row["raw"])
    interval = run_.isel(interval=row["comparison"] - 1)
    mean = interval["f_a"].values[interval["scored"].values].mean()
    assert mean == pytest.approx(row[f"force_mean_n_{row['comparison']}"], abs=1e-5)
    assert run_.attrs["trial"] == 4


def test_intervals_of_unequal_length_are_kept_whole(whole, tmp_path):
    runs = [fl.simulate(fl.bench(), duration_s) for duration_s in (0.05, 0.04)]
    shutil.copytree(whole, tmp_path / "P02")
    with session_folder.opened(tmp_path / "P02") as kept:
        read = fl.load(tmp_path / "P02" / kept.keep(99, runs))
    for number, run_ in enumerate(runs):
        interval, rows = read.isel(interval=number), run_.sizes["time"]
        np.testing.assert_array_equal(interval["f_a"][:rows], run_["f_a"].astype("float32"))
        assert np.isnan(interval["f_a"][rows:]).all()
        assert not interval["scored"][rows:].any()


@pytest.mark.soak
@pytest.mark.timeout(1800)
def test_a_session_killed_at_60_random_moments_loses_no_row(whole, tmp_path):
    path = tmp_path / "P01"
    shutil.copytree(whole, path)
    expected = (whole / "trials.tsv").read_text()
    header = expected.splitlines(keepends=True)[0]
    rng, kills = np.random.default_rng(1), 0
    made = multiprocessing.get_context("forkserver")  # a process that imported all it needs is copied for each
    made.set_forkserver_preload(["frictionloop.experiments.resumable_session"])
    (path / "trials.tsv").write_text(header)
    before = header
    while kills < 60:
        log, size = path / "log.jsonl", (path / "log.jsonl").stat().st_size
        process = made.Process(target=resume, args=(path,))
        process.start()
        while log.stat().st_size == size and process.is_alive():  # it has the session open from then on
            time.sleep(0.01)
        process.join(float(rng.uniform(0.0, 1.5)))
        process.kill()
        process.join()
        kills += process.exitcode == -signal.SIGKILL
        now = (path / "trials.tsv").read_text()
        assert now.startswith(before)
        assert expected.startswith(now)
        before = now[: now.rfind("\n") + 1]
        if before == expected:
            (path / "trials.tsv").write_text(header)
            before = header
    resume(path)
    assert (path / "trials.tsv").read_text() == expected


LEFT = {
    "as it was": lambda text: text,
    "without its last end": lambda text: text[:-1],
    "zeros of a lost power supply": lambda text: text + 700 * "\0",
    "zeros after a row without its end": lambda text: text[:-1] + 9 * "\0",
    "blank lines": lambda text: text.replace("\n", "\n\n", 3) + "\n \n",
    "Excel's ends and mark": lambda text: "\ufeff" + text.replace("\n", "\r\n"),
    "half a row": lambda text: text + text.splitlines()[-1][:-1],
}


@pytest.mark.parametrize("left", LEFT)
def test_whole_rows_stay_whatever_power_supplies_and_other_programs_leave(whole, tmp_path, left):
    path = tmp_path / "P01"
    shutil.copytree(whole, path)
    for name in (".DS_Store", "._trials.tsv", "trials (conflicted copy).tsv", "._session.json"):
        (path / name).write_bytes(b"\0\1Mac OS X")
    text = (path / "trials.tsv").read_text()
    (path / "trials.tsv").write_bytes(LEFT[left](text).encode())
    expected = read_trials(whole)
    pandas.testing.assert_frame_equal(read_trials(tmp_path), expected)
    with session_folder.opened(path) as kept:
        kept.add({**kept.rows[-1], "trial": len(expected) + 1, "raw": f"raw/trial-{len(expected) + 1:05d}.h5"})
        assert len(kept.rows) == len(expected) + 1
    pandas.testing.assert_frame_equal(read_trials(path).iloc[:-1], expected)


def test_a_line_of_the_log_that_cannot_be_read_is_passed_over_and_told(whole, tmp_path):
    shutil.copytree(whole, tmp_path / "P01")
    log = tmp_path / "P01" / "log.jsonl"
    log.write_text("{torn\n[1]\n" + log.read_text() + '{"event": "note"}')
    assert session_folder.logged(tmp_path / "P01") == [*session_folder.logged(whole), {"event": "note"}]
    (found,) = [each for each in fl.experiments.report(tmp_path).findings if each.code == "STUDY-LOG"]
    assert found.value == 2


def test_a_session_left_before_its_first_trial_has_nothing_to_report(tmp_path):
    run(PSI, tmp_path / "P01", "P01", trials=0)
    with pytest.raises(FrictionloopError, match="P01: has no trial"):
        fl.experiments.report(tmp_path / "P01")


def test_two_runs_of_one_session_at_once_are_refused(whole):
    with session_folder.opened(whole), pytest.raises(FrictionloopError, match="another run goes on"):
        resume(whole)


@pytest.mark.slow
def test_a_full_disk_ends_the_session_with_whole_rows(whole, tmp_path, monkeypatch):
    path = tmp_path / "P01"
    shutil.copytree(whole, path)
    lines = (whole / "trials.tsv").read_text().splitlines(keepends=True)
    (path / "trials.tsv").write_text("".join(lines[:4]))
    real = os.write

    def full(handle, data):
        if data.startswith(b"6\t"):
            return real(handle, data[:20])
        return real(handle, data)

    monkeypatch.setattr(os, "write", full)
    with pytest.raises(FrictionloopError, match="trial 6 cannot be written \\(No space left"):
        resume(path)
    monkeypatch.undo()
    assert (path / "trials.tsv").read_text() == "".join(lines[:6])
    resume(path)
    assert (path / "trials.tsv").read_text() == "".join(lines)


def edited(table, changes, number):
    """Change cells of a row of a table, by name."""
    header, *rows = (line.split("\t") for line in table.read_text().splitlines())
    cells = dict(zip(header, rows[number], strict=True)) | changes
    rows[number] = list(cells.values())
    table.write_text("".join("\t".join(row) + "\n" for row in (header, *rows)))


EDITS = {
    "requested": "0.01", "response": "2", "valid": "2", "rt_s": "nan", "participant": "P02", "trial": "7",
    "raw": "/etc/passwd", "offset_s": "n/a", "check": "f" * 32, "method_state": "n/a", "counted": "seven",
}  # fmt: skip


@pytest.mark.parametrize("field", EDITS)
def test_a_row_that_was_edited_is_refused_with_its_field(whole, tmp_path, field):
    path = tmp_path / "P01"
    shutil.copytree(whole, path)
    edited(path / "trials.tsv", {field: EDITS[field]}, 1)
    with pytest.raises(FrictionloopError, match=f"row 2: {field} = "):
        resume(path)
    with pytest.raises(FrictionloopError, match=f"row 2: {field} = "):
        read_trials(path)


@given(first=st.integers(0, 15), second=st.integers(0, 15))
def test_rows_that_changed_places_are_refused(whole, first, second):
    rows = read_rows(whole / "trials.tsv", "P01")
    before = rows[first - 1]["check"] if first else ""
    assert (check_of(rows[second], before) == rows[second]["check"]) == (first == second)


def test_a_row_that_was_taken_away_is_refused(whole, tmp_path):
    path = tmp_path / "P01"
    shutil.copytree(whole, path)
    lines = (path / "trials.tsv").read_text().splitlines(keepends=True)
    (path / "trials.tsv").write_text("".join(lines[:3] + lines[4:]))
    with pytest.raises(FrictionloopError, match="row 3: trial = 4: must be 3"):
        resume(path)


def test_what_a_spreadsheet_writes_is_read(whole, tmp_path):
    path = tmp_path / "P01"
    shutil.copytree(whole, path)
    table = pandas.read_csv(path / "trials.tsv", sep="\t", dtype=str, keep_default_na=False)
    table.to_csv(path / "trials.tsv", sep="\t", index=False, quoting=csv.QUOTE_ALL, lineterminator="\r\n")
    pandas.testing.assert_frame_equal(read_trials(path), read_trials(whole))


def test_a_trial_that_is_amended_does_not_count_and_the_session_goes_on_as_before(whole, tmp_path):
    path = tmp_path / "P01"
    shutil.copytree(whole, path)
    expected = (whole / "trials.tsv").read_text().splitlines(keepends=True)
    (path / "trials.tsv").write_text("".join(expected[:-1]))
    counts = read_trials(path)["counted"]
    trial = int(np.flatnonzero(counts)[0]) + 1
    for reason in ("once", 'the "phone" rang'):  # the last word counts
        found = fl.experiments.amend(path, trial, reason)
    assert (found.trials, found.counted) == (len(counts), counts.sum() - 1)
    row = read_trials(path).iloc[trial - 1]
    assert (row["valid"], row["counted"], row["reason"]) == (0, 0, 'amended: the "phone" rang')
    resume(path)
    pandas.testing.assert_frame_equal(
        read_trials(path).drop(index=trial - 1).drop(columns="check"),
        read_trials(whole).drop(index=trial - 1).drop(columns="check"),
    )
    edited(path / "trials.tsv", {"reason": "amended: not at all"}, -2)
    with pytest.raises(FrictionloopError, match=f"row {len(counts) + 2}: reason = "):
        read_trials(path)


@pytest.mark.parametrize(
    ("trial", "reason", "why"), [(0, "x", "trial = 0: must be from 1 to"), (1, " ", "reason = ' ': must be")]
)
def test_what_cannot_be_amended(whole, tmp_path, trial, reason, why):
    shutil.copytree(whole, tmp_path / "P01")
    with pytest.raises(FrictionloopError, match=why):
        fl.experiments.amend(tmp_path / "P01", trial, reason)


ABOUTS = {
    "no UTF-8": b"\xff", "a list": b"[1]", "nothing": b"{}", "deep": b"[" * 100_000, "digits": b"9" * 5000,
    "another schema": b'{"schema": 1, "participant": "P01", "source": "simulated"}',
    "a number for a name": b'{"schema": 2, "participant": 1, "source": "simulated"}',
    "no seed": b'{"schema": 2, "participant": "P01", "source": "simulated", "simulated": {"finger": {}}}',
}  # fmt: skip


@pytest.mark.parametrize("about", ABOUTS)
def test_what_is_no_session_is_refused_by_its_file(whole, tmp_path, about):
    shutil.copytree(whole, tmp_path / "P01")
    (tmp_path / "P01" / "session.json").write_bytes(ABOUTS[about])
    for verb in (resume, fl.experiments.report, lambda path: fl.experiments.amend(path, 1, "x")):
        with pytest.raises(FrictionloopError, match=r"session\.json"):
            verb(tmp_path / "P01")


@pytest.mark.parametrize("event", ["[" * 100_000, '{"event": "given up"}', '{"event": 1}', "9" * 5000])
def test_a_log_of_other_types_is_passed_over(whole, tmp_path, event):
    shutil.copytree(whole, tmp_path / "P01")
    with (tmp_path / "P01" / "log.jsonl").open("a") as log:
        log.write(event + "\n")
    assert session_folder.logged(tmp_path / "P01") == session_folder.logged(whole)


@pytest.mark.parametrize("name", [".lock", "log.jsonl"])
def test_a_folder_in_the_place_of_a_file_is_refused(whole, tmp_path, name):
    shutil.copytree(whole, tmp_path / "P01")
    (tmp_path / "P01" / name).unlink()
    (tmp_path / "P01" / name).mkdir()
    with pytest.raises(FrictionloopError, match="Is a directory"):
        resume(tmp_path / "P01")
