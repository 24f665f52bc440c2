"""Without a library of an extra, its users say in one line what to install, before anything is done."""

from __future__ import annotations

import sys

import pytest

from frictionloop.firmware import image
from frictionloop.firmware.compiled import host_library
from frictionloop.firmware.image_files import read_hex
from frictionloop.quantities import FrictionloopError


def line(library: str, extra: str) -> str:
    pip = ".venv/bin/pip install --constraint requirements/lock.txt"
    return f"{library} is missing; install with: {pip} --editable '.[{extra}]'"


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
        ("cffi", "firmware", lambda folder: host_library.__wrapped__()),
        ("ziglang", "image", lambda folder: image.build("teensy31", [], folder / "made")),
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
    assert "ziglang, pyelftools, fastcrc, intelhex are missing; install with: .venv/bin/pip install" in answer.err
    assert answer.err.endswith("--constraint requirements/lock.txt --editable '.[image,device]'\n")
