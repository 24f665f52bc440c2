"""What `make` installs: every file of the package index with its hash, of the versions in requirements/lock.txt."""

from __future__ import annotations

import json
import re
import subprocess
import tomllib
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[2] / "requirements"
HASHED = sorted(path.name for path in FOLDER.glob("*.txt") if path.name != "lock.txt")
LOCKED = dict(re.findall(r"^([\w.-]+)==(\S+)$", (FOLDER / "lock.txt").read_text(encoding="utf-8"), re.MULTILINE))
OTHER_SYSTEMS = {"appnope", "colorama", "hidapi", "pywin32-ctypes"}
"""What only Windows or macOS installs."""


def plain(name):
    return re.sub(r"[-_.]+", "-", name).lower()


@pytest.mark.parametrize("name", HASHED)
def test_every_pin_has_a_hash_and_the_version_of_the_lock(name):
    text = (FOLDER / name).read_text(encoding="utf-8").replace("\\\n", "")
    pins = [line.split() for line in text.splitlines() if line and not line.startswith(("#", "-r "))]
    locked = {plain(package): version for package, version in LOCKED.items()}
    assert pins
    for requirement, *more in pins:
        package, version = requirement.split("==")
        assert sum(each.startswith("--hash=sha256:") for each in more) > 0, package
        assert version == locked.get(plain(package), version), package
        assert plain(package) in locked or package in OTHER_SYSTEMS, package


def test_the_files_together_have_all_that_is_locked():
    text = "".join((FOLDER / name).read_text(encoding="utf-8") for name in HASHED)
    pinned = {plain(package) for package in re.findall(r"^([\w.-]+)==", text, re.MULTILINE)}
    assert {plain(package) for package in LOCKED} <= pinned


def test_no_file_names_a_host():
    assert not [path.name for path in FOLDER.iterdir() if "://" in path.read_text(encoding="utf-8")]


def test_all_files_say_one_version():
    root = FOLDER.parent
    project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    meta = json.loads((root / "codemeta.json").read_text(encoding="utf-8"))
    cited = re.search(r"^version: (\S+)$", (root / "CITATION.cff").read_text(encoding="utf-8"), re.MULTILINE)[1]
    assert meta["version"] == cited == project["version"]
    assert project["version"] in (root / "CHANGELOG.md").read_text(encoding="utf-8")
    assert (meta["description"], meta["keywords"]) == (project["description"], project["keywords"])


@pytest.mark.slow
def test_a_step_of_make_says_what_it_does_and_is_not_silent():
    step = ["sh", str(FOLDER / "step.sh"), "Waiting, usually 3 s"]
    done = subprocess.run([*step, "sleep", "3"], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (0, "Waiting, usually 3 s .\n")
    assert subprocess.run([*step, "false"], capture_output=True, check=False).returncode == 1
