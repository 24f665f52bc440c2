"""The program itself: help, version, start-up, Ctrl-C, pipes that close, and ``reproduce``."""

from __future__ import annotations

import signal
import subprocess
import sys
from contextlib import nullcontext
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path

import pytest

import frictionloop as fl
from frictionloop.quantities.code_version import cited_version
from frictionloop.quantities.compile_events import compiling

VERBS = ("reproduce", "simulate", "sweep", "compare")


@pytest.mark.parametrize("tokens", [(), ("--help",), ("-h",)])
def test_help_lists_the_verbs(frictionloop, tokens):
    answer = frictionloop(*tokens)
    assert (answer.code, answer.err) == (0, "")
    assert all(f"    {verb} " in answer.out for verb in VERBS)


@pytest.mark.parametrize("verb", VERBS)
@pytest.mark.parametrize("columns", [80, 120])
def test_help_of_each_verb_has_examples_that_fit(frictionloop, monkeypatch, verb, columns):
    monkeypatch.setenv("COLUMNS", str(columns))
    answer = frictionloop(verb, "--help")
    assert f"\n  frictionloop {verb}" in answer.out
    assert max(len(line.rstrip()) for line in answer.out.splitlines()) <= columns


def test_version(frictionloop):
    assert frictionloop("--version").out == f"frictionloop {cited_version()}\n"
    assert cited_version().startswith(version("frictionloop"))


def test_nothing_heavy_is_imported_before_it_is_needed():
    script = """
import sys
from frictionloop.cli import main
heavy = {"numba", "xarray", "pandas", "matplotlib", "scipy", "pydantic", "joblib", "h5py", "jinja2"}
run = {"dask", "matplotlib", "joblib", "h5py", "jinja2", "scipy.signal", "scipy.optimize", "scipy.stats"}
helps = (["sweep", "--help"], ["compare", "--help"], ["--version"], ["simulate", "--seed", "x"])
for tokens in (["--help"], *helps, ["simulate", "--preset", "bench", "--duration-s", "0.5"]):
    try:
        main(tokens)
    except SystemExit:
        print("imported:", *((run if "bench" in tokens else heavy) & set(sys.modules)))
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert [line for line in done.stdout.splitlines() if line.startswith("imported:")] == ["imported:"] * 6


def test_module_and_script_are_the_same_program(process):
    out, err = process("--version").communicate()
    assert (out, err) == (f"frictionloop {cited_version()}\n", "")


@pytest.mark.slow
def test_reader_that_leaves_is_no_error(process):
    each = [
        process(*tokens) for tokens in (("simulate",), ("device", "list"), ("device", "list", "--json"), ("--help",))
    ]
    for running in each:  # side by side: most of their time is importing
        running.stdout.close()
    for running in each:
        assert running.ended() == (1, [])


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is always full")
def test_full_output_is_one_line():
    command = [sys.executable, "-m", "frictionloop", "device", "list"]
    with open("/dev/full", "w") as full:
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert (done.returncode, done.stderr) == (1, "error: output: No space left on device\n")


def test_ctrl_c_is_quiet(frictionloop, monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("frictionloop.loop.simulate.traced", interrupted)
    assert frictionloop("simulate") == (130, "", "interrupted\n")


@pytest.fixture
def report(monkeypatch):
    """Put a small report in place of the paper's."""
    (claim,) = fl.reproduce(only=["resonance"]).claims
    thesis = replace(
        claim,
        id="pi-reduces-variability",
        group=None,
        readings={"re-tuned gains, one finger, per newton of slope": 3.0},
        accepted=(1.0, 9.0),
        told={"kp": 0, "ki": 111},
    )
    monkeypatch.setattr("frictionloop.report.reproduction.build_report", lambda folder, progress: [thesis, claim])


def test_reproduce_prints_the_verdict_and_where_the_page_is(frictionloop, report):
    answer = frictionloop("reproduce")
    assert (answer.code, answer.err) == (0, "")
    assert answer.out.startswith("1     yes, if 10 is not N/N: A PI reduces the variability of friction")
    assert "(spread ÷ 3 per newton with Kp = 0, Ki = 111 1/s)" in " ".join(answer.out.split())
    assert "report/index.html" in answer.out
    found = frictionloop("reproduce", "--out", "deep/er", "--json").json()
    assert [each["id"] for each in found["claims"]] == ["pi-reduces-variability", "resonance"] and found[
        "page"
    ] == "deep/er/index.html"
    assert found["statements"][0]["claims"] == ["pi-reduces-variability"]


def test_reproduce_makes_a_claim_alone(frictionloop):
    answer = frictionloop("reproduce", "--only", "resonance")
    assert (answer.code, answer.err) == (0, "")
    (claim,) = frictionloop("reproduce", "--only", "resonance", "--json").json()["claims"]
    assert claim["command"] == "frictionloop reproduce --only resonance" and claim["verdict"] == "not counted"
    assert not Path("report").exists()


def test_a_command_that_is_told_to_end_is_interrupted_as_by_ctrl_c(monkeypatch, capsys):
    """A limit on time sends SIGTERM; a sweep keeps and tells what is done then."""
    from frictionloop.cli import app

    before = signal.getsignal(signal.SIGTERM)

    def work(_):
        signal.raise_signal(signal.SIGTERM)
        raise AssertionError("goes on")

    monkeypatch.setattr(app, "app", lambda *_, **__: work(None))
    with pytest.raises(SystemExit) as left:
        app.main(["simulate"])
    assert left.value.code == 130 and capsys.readouterr().err == "interrupted\n"
    assert signal.getsignal(signal.SIGTERM) is before


def test_a_compilation_does_not_hold_up_the_end(monkeypatch):
    """Python would look at the signal only when the compiler is done: the system ends the process."""
    from frictionloop.cli import app

    taken = []

    def work(*_, **__):
        for inside in (compiling(), nullcontext()):
            with inside:
                taken.append(signal.getsignal(signal.SIGTERM))

    monkeypatch.setattr(app, "app", work)
    with pytest.raises(SystemExit):
        app.main(["simulate"])
    assert taken[0] == signal.SIG_DFL and callable(taken[1])
