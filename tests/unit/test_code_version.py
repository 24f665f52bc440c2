"""The digest of what the code computes: equal where only words differ, another wherever a number may."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import frictionloop
from frictionloop.loop.sweep_checkpoint import COMPUTING, computing
from frictionloop.quantities import code_version
from frictionloop.quantities.code_version import sources_digest

LAW = '''"""A law."""


class Gains:
    """Gains."""

    kp = 2.0


def step(error):
    """Return the command."""
    return Gains.kp * error  # proportional
'''


@pytest.fixture
def digest(tmp_path):
    def of(text, name="law.py"):
        folder = tmp_path / "room"
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir()
        (folder / name).write_text(text)
        return sources_digest([folder])

    return of


@pytest.mark.parametrize("word", ["A law.", "Gains.\n", "Return the command.", "proportional"])
def test_words_do_not_count(digest, word):
    changed = LAW.replace(f'"""{word.strip()}"""', '"""Other words."""').replace(f"# {word}", "# another")
    if word == "Gains.\n":
        changed = LAW.replace('"""Gains."""', '"""Other words."""')
    assert changed != LAW
    assert digest(changed) == digest("\n\n" + LAW) == digest(LAW)


@pytest.mark.parametrize(
    ("old", "new"), [("2.0", "2.5"), ("* error", "/ error"), ("Gains.kp", "Gains.ki"), ("step", "other")]
)
def test_what_computes_counts(digest, old, new):
    assert digest(LAW.replace(old, new)) != digest(LAW)


def test_c_counts_and_other_files_do_not(digest):
    assert digest("int kp = 2;", "law.c") != digest("int kp = 3;", "law.c")
    assert digest("kp = 2", "law.toml") == digest("kp = 3", "law.toml")


def test_the_loops_own_law_is_among_what_is_read(tmp_path):
    package = Path(frictionloop.__file__).parent
    assert all((package / room).is_dir() for room in COMPUTING)
    folder = tmp_path / "control"
    shutil.copytree(package / "control", folder)
    before = sources_digest([folder])
    law = folder / "pi.py"
    text = law.read_text()
    assert "v > high" in text
    law.write_text(text.replace("v > high", "v >= high"))
    assert sources_digest([folder]) != before


@pytest.mark.slow
def test_every_room_that_a_run_imports_is_read():
    """What an effect asks for is a number of the run, too."""
    effect = '{"setpoint": {"kind": "effect", "effect": "grating"}}'
    code = f"import sys, frictionloop as fl; fl.sweep(fl.bench().evolve({effect}), [{{}}], 0.01); print(*sys.modules)"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    rooms = {name.split(".")[1] for name in found if name.startswith("frictionloop.") and name.count(".") > 1}
    assert rooms - set(COMPUTING) == set()


def test_every_process_finds_the_same():
    code = "from frictionloop.loop.sweep_checkpoint import computing; print(computing())"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == computing()


def test_what_is_cited_is_the_version_and_of_a_clone_its_commit(monkeypatch):
    of_clone = (Path(code_version.__file__).parents[3] / ".git").exists()
    cited = rf"{re.escape(code_version.package_version())}\+g[0-9a-f]{{10,}}(\.modified)?"
    assert not of_clone or re.fullmatch(cited, code_version.cited_version.__wrapped__())

    def without_git(*words, **more):
        raise FileNotFoundError("git")

    monkeypatch.setattr(code_version.subprocess, "run", without_git)
    assert code_version.cited_version.__wrapped__() == code_version.package_version()
