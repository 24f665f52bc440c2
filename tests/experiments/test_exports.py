"""Sessions in other programs: BIDS by its own validator and its rules, scipy and pandas, streams of LSL."""

import json
import os
import shutil
import subprocess
import sysconfig
from pathlib import Path

import numpy as np
import pandas
import pylsl
import pytest
from scipy.signal import welch

import frictionloop as fl
from frictionloop.experiments import Protocol, read_trials, run, session_export
from frictionloop.experiments.lsl import Streams

PLAN = Protocol(
    name="short",
    stimulus={"standard": 0.35},
    method={"kind": "staircase", "start": [0.15], "most": 0.2},
    timeline={"stroke": {"length_mm": 10.0}},
    stop={"trials": 2},
)
LAYOUT = {
    "beh": ("_beh.tsv", "_beh.json", "_events.tsv", "_events.json", "_physio.tsv.gz", "_physio.json"),
    "motion": ("_tracksys-plate_motion.tsv", "_tracksys-plate_motion.json", "_tracksys-plate_channels.tsv"),
}
"""Folders and suffixes by rules/files/raw of the BIDS schema 1.10: beh, events, task.timeseries, motion, channels."""


@pytest.fixture(scope="module")
def session(tmp_path_factory):
    return run(PLAN, tmp_path_factory.mktemp("s") / "P01", "P01").folder


@pytest.fixture(scope="module")
def dataset(session, tmp_path_factory):
    out = tmp_path_factory.mktemp("bids")
    session_export.bids(session, out)
    return out


def test_names_and_columns_are_those_of_the_bids_schema(dataset):
    stem = "sub-P01_task-short"
    for folder, suffixes in LAYOUT.items():
        found = {each.name for each in (dataset / "sub-P01" / folder).iterdir()}
        assert found == {f"{stem}{suffix}" for suffix in suffixes}
    events = pandas.read_csv(dataset / "sub-P01" / "beh" / f"{stem}_events.tsv", sep="\t")
    assert events.columns[:2].tolist() == ["onset", "duration"]
    channels = pandas.read_csv(dataset / "sub-P01" / "motion" / f"{stem}_tracksys-plate_channels.tsv", sep="\t")
    assert channels.columns.tolist() == ["name", "component", "type", "tracked_point", "units"]
    assert channels["type"].tolist() == ["LATENCY", "POS", "VEL"]
    about = json.loads((dataset / "sub-P01" / "motion" / f"{stem}_tracksys-plate_motion.json").read_text())
    assert {"TaskName", "SamplingFrequency"} <= set(about)
    for each in dataset.rglob("*.json"):
        assert json.loads(each.read_text())


VALIDATOR = shutil.which("bids-validator-deno", path=sysconfig.get_path("scripts"))
"""Of the environment that the tests run in."""


@pytest.mark.skipif(VALIDATOR is None, reason="no bids-validator-deno in this environment")
def test_the_validator_of_bids_finds_no_error(dataset):
    path = f"{Path(VALIDATOR).parent}{os.pathsep}{os.environ['PATH']}"  # it calls deno
    command = [VALIDATOR, str(dataset), "--ignoreWarnings"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=os.environ | {"PATH": path})
    assert "[ERROR]" not in done.stdout + done.stderr
    assert "appears to be BIDS compatible" in done.stdout + done.stderr


def test_every_column_with_a_unit_says_it_and_the_readme_names_files_that_are_there(session, dataset, tmp_path):
    about = json.loads(next(dataset.rglob("*_beh.json")).read_text())
    units = {name: each["Units"] for name, each in about.items() if isinstance(each, dict) and "Units" in each}
    assert units["requested"] == units["delivered"] == units["force_mean_n_1"] == "N"
    assert (units["speed_mm_s_2"], units["rt_s"], units["onset_s"]) == ("mm/s", "s", "s")
    assert not {"trial", "result", "repeat_of", "felt_index_1"} & set(units)
    named = [word.strip(".") for word in (dataset / "README").read_text().split() if word.startswith("*")]
    assert len(named) == 2
    assert all(list(dataset.rglob(name)) for name in named)
    shutil.copytree(session, tmp_path / "P01")
    table = tmp_path / "P01" / "trials.tsv"
    table.write_text(table.read_text().splitlines(keepends=True)[0])
    session_export.bids(tmp_path / "P01", tmp_path / "bids")
    assert "*" not in (tmp_path / "bids" / "README").read_text()


def test_traces_are_read_back_by_pandas_and_scipy_with_their_times(session, dataset):
    stem = dataset / "sub-P01" / "beh" / "sub-P01_task-short"
    names = json.loads(stem.with_name(f"{stem.name}_physio.json").read_text())["Columns"]
    physio = pandas.read_csv(f"{stem}_physio.tsv.gz", sep="\t", header=None, names=names)
    motion = pandas.read_csv(
        dataset / "sub-P01" / "motion" / "sub-P01_task-short_tracksys-plate_motion.tsv", sep="\t", header=None
    )
    trials = read_trials(session)
    assert (physio["time"] == motion[0]).all()
    for trial, first in physio.groupby("trial")["time"].min().items():
        assert first == pytest.approx(trials["onset_s"][trial - 1] - trials["onset_s"][0], abs=1e-9)
    last = physio.groupby("trial")["time"].max() + trials["onset_s"][0]
    assert last.to_numpy() == pytest.approx(trials["offset_s"].to_numpy() - 2e-4, abs=1e-6)
    one = physio[(physio["trial"] == 2) & (physio["interval"] == 1)]
    raw = fl.load(session / trials["raw"][1]).isel(interval=0)
    np.testing.assert_allclose(one["f_delivered"], raw["f_a"], rtol=1e-6)
    spectra = [welch(values, 5000.0)[1] for values in (one["f_delivered"].to_numpy(), raw["f_a"].values)]
    np.testing.assert_allclose(*spectra, rtol=1e-3)


@pytest.mark.slow
def test_streams_carry_strokes_and_markers_on_the_clock_of_the_device(tmp_path):
    streams, inlets = Streams("P77"), {}

    def first(row):
        if not inlets:
            for name in ("frictionloop", "frictionloop-markers"):
                (info,) = pylsl.resolve_byprop("source_id", f"{name}-P77", timeout=60)
                inlets[name] = pylsl.StreamInlet(info)
                inlets[name].open_stream(timeout=60)

    path = run(PLAN, tmp_path / "P77", "P77", streams=streams, progress=first).folder
    trials = read_trials(path)
    samples, times = [], []
    while chunk := inlets["frictionloop"].pull_chunk(timeout=2.0, max_samples=5000):
        if not chunk[0]:
            break
        samples += chunk[0]
        times += chunk[1]
    raw = fl.load(path / trials["raw"][1])
    assert times[0] == pytest.approx(trials["onset_s"][1])
    assert times[-1] == pytest.approx(trials["offset_s"][1] - 2e-4)
    np.testing.assert_allclose(np.array(samples)[:, 0], np.ravel(raw["f_a"].values), rtol=1e-6)
    marks, when = inlets["frictionloop-markers"].pull_chunk(timeout=2.0)
    said = [f"stroke {number} {end}" for number in (1, 2) for end in ("onset", "offset")]
    said.append(f"response {trials['response'][1]}")
    assert [each[0] for each in marks] == [f"trial 2 {each}" for each in said]
    assert when[1] == pytest.approx(trials["onset_s"][1] + 0.5)  # a stroke of 10 mm at 20 mm/s
    assert when[3] == pytest.approx(trials["offset_s"][1])
    assert when[-1] == pytest.approx(trials["offset_s"][1] + trials["rt_s"][1])
    assert inlets["frictionloop"].info().desc().child_value("clock") == "device"
