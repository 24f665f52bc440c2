"""The program itself: help, version, start-up, Ctrl-C, pipes that close, and ``reproduce``."""

from __future__ import annotations

import json
import re
import signal
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import pytest

from frictionloop.quantities.version import cited_version
from frictionloop.report.protocol import the_bench

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


@pytest.mark.parametrize(
    "tokens", [["--help"], ["sweep", "--help"], ["compare", "--help"], ["--version"], ["simulate", "--seed", "x"]]
)
def test_nothing_heavy_is_imported_before_it_is_needed(tokens):
    script = (
        "import sys; from frictionloop.cli import main\n"
        f"try: main({tokens!r})\n"
        "except SystemExit: pass\n"
        "heavy = {'numba', 'xarray', 'pandas', 'matplotlib', 'scipy', 'pydantic', 'joblib', 'h5py', 'jinja2'}\n"
        "print('imported:', *(heavy & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout.splitlines()[-1].split()) == (0, ["imported:"])


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
@pytest.mark.parametrize("json_flag", [[], ["--json"]])
def test_full_output_is_one_line(json_flag):
    command = [sys.executable, "-m", "frictionloop", "device", "list", *json_flag]
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

    def reproduce(folder):
        claims = [{"id": "kp-range", "verdict": "reproduced"}]
        Path(folder).mkdir(parents=True)
        (Path(folder) / "claims.json").write_text(json.dumps({"schema": 1, "claims": claims}))
        return claims

    told = "frictionloop.report.claims.told"
    monkeypatch.setattr("frictionloop.report.build.reproduce", reproduce)
    monkeypatch.setattr(f"{told}.claims_tables", lambda claims: ["\n".join(map(str, claims))])
    monkeypatch.setattr(f"{told}.summary", lambda claims: ["the idea holds"])


def test_reproduce_prints_the_claims_and_where_the_page_is(frictionloop, report):
    answer = frictionloop("reproduce")
    assert (answer.code, answer.err) == (0, "")
    assert "kp-range" in answer.out
    assert answer.out.endswith("report/index.html\n")


def test_reproduce_json_is_the_claims(frictionloop, report):
    assert frictionloop("reproduce", "--out", "deep/er", "--json").json() == {
        "schema": 1,
        "claims": [{"id": "kp-range", "verdict": "reproduced"}],
        "page": "deep/er/index.html",
    }


def test_reproduce_makes_a_claim_alone(frictionloop):
    answer = frictionloop("reproduce", "--only", "resonance")
    assert (answer.code, answer.err) == (0, "")
    assert answer.out.splitlines() == [
        "· 400 g on 1 N/µm resonates at 250 Hz (Sec. 3.1): not counted",
        "  paper: 250 Hz; here: √(k/m)/2π; accepted: 245 to 255 Hz",
        "  ✓ as printed: 252 Hz",
        "  With the stiffness read as 1 N/µm; “N.µm” is no stiffness.",
        f"  cite: frictionloop {cited_version()} · frictionloop reproduce --only resonance · no random numbers",
    ]
    (claim,) = frictionloop("reproduce", "--only", "resonance", "--json").json()["claims"]
    assert claim["command"] == "frictionloop reproduce --only resonance"
    assert not Path("report").exists()


@pytest.mark.slow
def test_reproduce_of_a_figure_prints_its_numbers_and_what_was_changed(frictionloop):
    changes = ("--sensor.resonance_hz", "200", "--only", "fig-5a-printed")
    answer = frictionloop("reproduce", *changes)
    assert answer.code == 0
    lines = answer.out.splitlines()
    first, head, *rows = lines[:4]
    (unreached,) = (line for line in lines if "does not reach" in line)
    before, again = lines[lines.index("  the bench unchanged:") :][:2]
    printed, skin, slider, would, more, people, cite, where, beside = lines[-9:]
    assert first == "fig-5a-printed, not the paper's bench: sensor.resonance_hz = 200"
    assert head.split()[-2:] == ["spread", "error"] and again.split()[:5] == ["kp", "ki", "Ms", "moist", "R2"]
    assert re.fullmatch(
        r"  printed gains: hold at 0 of 6 slip lengths and speeds, unstable at 6 \(unchanged: 0, unstable at 6\)",
        printed,
    )
    assert [where.split(" mm/s")[0] for where in (skin, slider)] == [
        f"    slip length {length_um:g} um at 10, 20, 80" for length_um in (the_bench().finger.slip_length_um, 0.0)
    ]
    assert unreached == '  sensor.resonance_hz does not reach "ideal sensor, no delay"'
    file = "report/figures/fig-5a-printed-with-sensor.resonance_hz-200.toml"
    assert more == f"  More of printed gains: frictionloop design check {file} --controller.kp 10 --controller.ki 2"
    assert re.fullmatch(r"  an integral alone, kp 0 and ki \S+ 1/s, would hold at all of them", would)
    (ki,) = re.findall(r"kp 0 and ki (\S+) 1/s", would)
    check = f"frictionloop design check {file} --controller.kp 0 --controller.ki {ki} --fingers 100"
    assert people == f"  On how many other fingers these hold: {check}"
    assert before == "  the bench unchanged:"
    assert [row.split("  ")[0] for row in rows] == ["printed gains", "ideal sensor, no delay"]
    command = "frictionloop reproduce --only fig-5a-printed --sensor.resonance_hz 200"
    assert beside.strip() == "beside it the same as .png"
    assert (cite, where) == (
        f"  cite: frictionloop {cited_version()} · {command} · seeds 0 to 14",
        "The figure: report/figures/fig-5a-printed-with-sensor.resonance_hz-200.svg",
    )
    (figure,) = frictionloop("reproduce", *changes, "--json").json()["figures"]
    assert figure["changed"] == {"sensor.resonance_hz": 200}
    assert f"{1e3 * figure['numbers']['printed gains']['error_n']:.3g}" == rows[0].split()[-1]
    assert figure["unchanged"]["printed gains"]["error_n"] != figure["numbers"]["printed gains"]["error_n"]


@pytest.mark.slow
def test_reproduce_on_a_stronger_plate_says_what_the_controller_still_believes(frictionloop):
    said = frictionloop("reproduce", "--plate.max_amplitude_um", "3", "--only", "fig-5a-printed").err
    assert "the controller believes 2.5 um and asks for no more; if it is to know: controller.model.max" in said


def test_reproduce_of_an_unknown_name_is_one_line(frictionloop):
    answer = frictionloop("reproduce", "--only", "resonances")
    assert (answer.code, answer.out) == (2, "")
    assert answer.err.startswith("error: only = 'resonances': is neither a figure nor a claim")
    assert answer.err.count("\n") == 1 and "resonance" in answer.err.partition("accepted, as")[2]


def test_reproduce_into_a_folder_that_cannot_be_made(frictionloop):
    Path("file").write_text("")
    answer = frictionloop("reproduce", "--out", "file")
    assert (answer.code, answer.out) == (2, "")
    assert answer.err == "error: file: cannot be made (Not a directory)\n"


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
