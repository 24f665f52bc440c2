"""Write the files that `make` installs from, with hashes: of the versions in lock.txt, those that each extra needs.

``python requirements/renew.py``, with `uv` on the path, after lock.txt or the dependencies in pyproject.toml changed.
"""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

HERE = Path(__file__).parent
SETS = {
    "report": ("", ["report"]),
    "design": ("report", ["report", "design"]),
    "dev": ("design", ["dev"]),
    "release": ("dev", ["dev", "release"]),
    "bench": ("design", ["bench"]),
    "zig": ("bench", ["bench-zig"]),
}
"""Extras of each file, and the file that it begins with; zig.txt alone is installed beside its own."""
HEAD = "# Written by requirements/renew.py: change lock.txt and run it again.\n"
COMPILE = ("uv", "pip", "compile", "--quiet", "--universal", "--python-version", "3.11", "--generate-hashes")
PLAIN = ("--no-header", "--no-annotate", "--constraint", "lock.txt")


def pins(text: str) -> dict[str, str]:
    """Return what is pinned, each package with its hashes, by name."""
    return {each.split("==")[0]: each for each in re.findall(r"^[\w.-]+==(?:.*\\\n)*.*\n", text, re.MULTILINE)}


def needed(source: str, extras: list[str]) -> dict[str, str]:
    """Return the pins that a file of requirements, or the package with these extras, needs."""
    options = [f"--extra={each}" for each in extras]
    return pins(subprocess.check_output([*COMPILE, *PLAIN, *options, source], cwd=HERE, text=True))


def main() -> None:
    """Write every file."""
    build = needed("build.in", [])
    (HERE / "build.txt").write_text(HEAD + "".join(build.values()), encoding="utf-8")
    written: dict[str, dict[str, str]] = {"": build}
    for name, (first, extras) in SETS.items():
        whole = needed("../pyproject.toml", extras)
        begin = "" if name == "zig" else f"-r {first or 'build'}.txt\n"
        own = [pin for package, pin in whole.items() if package not in written[first]]
        written[name] = written[first] | whole
        (HERE / f"{name}.txt").write_text(HEAD + begin + "".join(own), encoding="utf-8")


if __name__ == "__main__":
    main()
