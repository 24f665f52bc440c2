"""`--use FILE`: a block of the caller's own on the command line."""

from __future__ import annotations

import sys
from pathlib import Path

import half_law
import pytest

from frictionloop.control.lookup import LOOKUP_LAW
from frictionloop.firmware import image
from frictionloop.firmware.compiled_core import host_library
from frictionloop.firmware.image_files import read_hex
from frictionloop.loop.registered_blocks import forget
from frictionloop.quantities import FrictionloopError

LAW = Path(half_law.__file__).read_text(encoding="utf-8")
REGISTER = '\n\nfl.register(fl.Law("half", half, State, Gains), HalfController)\n'


def forgotten():
    """As in a new process: nothing is registered, the module is not imported."""
    forget()
    sys.modules.pop("my_law", None)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    (tmp_path / "my_law.py").write_text(LAW + REGISTER, encoding="utf-8")
    monkeypatch.setattr(sys, "path", list(sys.path))
    yield tmp_path
    forgotten()


@pytest.mark.slow
def test_a_law_of_ones_own_runs_and_is_kept_in_files(frictionloop, process, folder):
    short = ("--preset", "bench", "--controller.kind", "half", "--duration-s", "0.1")
    ran = frictionloop("--use", "my_law.py", "simulate", *short, "--save-system", "half.toml")
    assert (ran.code, ran.err) == (0, "")
    assert 'kind = "half"' in (folder / "half.toml").read_text(encoding="utf-8")
    again = process("simulate", "half.toml", "--duration-s", "0.1", "--use=my_law")
    assert again.ended() == (0, [])
    # A file that names it brings no code.
    forgotten()
    refused = frictionloop("simulate", "half.toml")
    assert refused.code == 2
    assert "--use FILE" in refused.err


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("x = 1 / 0\n", "my_law.py, line 1: division by zero"),
        ("import frictionloop as fl\nfl.register(3)\n", "Law, Vibration, Signal, StreamingMetric, RunMetric"),
        ("def broken(:\n", "SyntaxError"),
    ],
)
def test_an_error_in_the_file_is_told_in_one_line(frictionloop, folder, text, told):
    (folder / "my_law.py").write_text(text, encoding="utf-8")
    ran = frictionloop("--use", "my_law.py", "simulate")
    assert ran.code == 2
    assert told in ran.err
    assert len(ran.err.strip().splitlines()) == 1


# Without a library of an extra, its users say in one line what to install, before anything is done.


def line(library: str, extra: str) -> str:
    return f"{library} is missing; install with: pip install 'frictionloop[{extra}]'"


@pytest.mark.parametrize(
    "tokens",
    [
        ("simulate", "--plot", "run.svg", "--out", "run.h5"),
        ("compare", "--preset", "bench", "--plots", "figures"),
        ("design", "controller", "--preset", "bench", "--plots", "figures", "--out", "out.toml"),
        ("reproduce",),
    ],
)
def test_what_draws_needs_the_report(frictionloop, monkeypatch, tmp_path, tokens):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    answer = frictionloop(*tokens)
    assert (answer.code, answer.out) == (2, "")
    assert line("matplotlib", "report") in answer.err and answer.err.count("\n") == 1
    assert not any(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("library", "extra", "call"),
    [
        ("cffi", "firmware", lambda folder: host_library.__wrapped__(LOOKUP_LAW, 5000)),
        ("ziglang", "image", lambda folder: image.build("teensy41", [], None, folder / "made", rate_hz=5000)),
        ("intelhex", "device", lambda folder: read_hex(folder / "image.hex")),
    ],
)
def test_the_extra_is_named(monkeypatch, tmp_path, library, extra, call):
    monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(FrictionloopError) as caught:
        call(tmp_path)
    assert str(caught.value) == line(library, extra)
    assert not any(tmp_path.iterdir())


def test_a_build_names_everything_that_it_lacks_at_once(frictionloop, monkeypatch):
    for module in ("ziglang", "elftools", "intelhex", "fastcrc"):
        monkeypatch.setitem(sys.modules, module, None)
    answer = frictionloop("firmware", "build", "--preset", "bench", "--out", "made")
    assert (answer.code, answer.out, answer.err.count("\n")) == (2, "", 1)
    assert "ziglang, pyelftools, fastcrc, intelhex are missing; install with: pip install" in answer.err
    assert answer.err.endswith("'frictionloop[image,device]'\n")
